//! Error against step size of every integrator, through an impact.

use feeler_engine::{Integrator, Program, RunSettings, Scenario, Simulation, Trace};
use feeler_plant::description::{Body, Contact, ContactLaw, Engagement, GROUND, Machine, Quantity, SignalName};
use serde::Serialize;

use crate::error::ValidationError;
use crate::table::Row;

/// The exact integrator's peak, limited by the parabola through three samples of the record: (w h)^4 / 50 of 1e-5 s at 200 rad/s.
const EXACT: f64 = 1e-9;
/// Speed of approach, m/s.
const SPEED_M_PER_S: f64 = 0.25;

/// One integrator at one step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Step, s.
    pub step_s: f64,
    /// Relative error of the peak force.
    pub relative_error: f64,
}

/// One integrator over all steps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Convergence {
    /// Name of the integrator.
    pub integrator: String,
    /// Coarsest step first.
    pub points: Vec<Point>,
    /// Slope of log error over log step, by regression; not a number where errors are all rounding.
    pub slope: f64,
}

/// A mass of 10 kg that flies into a sensor of 1e5 N/m and 100 N s/m.
fn impact(integrator: Integrator, step_s: f64) -> Result<f64, ValidationError> {
    let mut machine = Machine::default();
    let body = Body { mass_kg: 10.0, position_m: -1.0e-3 / 3.0, velocity_m_per_s: SPEED_M_PER_S, ..Body::default() };
    machine.bodies.insert("tip".into(), body);
    let contact = Contact {
        between: ["tip".into(), GROUND.into()],
        engagement: Engagement::Unilateral,
        law: ContactLaw::KelvinVoigt,
        stiffness: 1e5,
        damping_n_s_per_m: 100.0,
        gap_m: 0.0,
        effects: Vec::new(),
    };
    machine.contacts.insert("tool".into(), contact);
    let record = vec![SignalName::new("tool", Quantity::SpringForce)];
    let run = RunSettings { duration_s: 0.04, step_s, integrator, record, ..RunSettings::default() };
    let program = Program::new(&Scenario { machine, controllers: [].into_iter().collect(), run })?;
    let mut trace = Trace::new(program.record_names());
    Simulation::<f64>::new(vec![program])?.run(&mut trace)?;
    Ok(peak(&trace.columns[0]))
}

/// The top of the parabola through the largest sample and its neighbours.
fn peak(force: &[f64]) -> f64 {
    let i = (1..force.len() - 1).max_by(|&a, &b| force[a].total_cmp(&force[b])).unwrap_or(1);
    let (a, b, c) = (force[i - 1], force[i], force[i + 1]);
    let bend = a - 2.0 * b + c;
    b - (c - a) * (c - a) / (8.0 * bend)
}

/// Peak of `k d` of a damped mass that meets the spring at a speed: `m v omega_n exp(-zeta phi / root) `, `phi = acos(zeta)`.
fn peak_by_hand() -> f64 {
    let (m, k, c, v) = (10.0, 1e5, 100.0, SPEED_M_PER_S);
    let omega = f64::sqrt(k / m);
    let zeta = c / (2.0 * m * omega);
    let root = (1.0 - zeta * zeta).sqrt();
    // Largest where d' = 0: omega_d t = atan2(root, zeta).
    let phase = root.atan2(zeta);
    k * v / omega * (-zeta * phase / root).exp()
}

/// Errors of all integrators.
///
/// # Errors
/// [`ValidationError::Engine`].
pub fn convergence(steps_s: &[f64]) -> Result<Vec<Convergence>, ValidationError> {
    let truth = peak_by_hand();
    let mut all = Vec::new();
    for (integrator, name) in Integrator::ALL {
        let mut points = Vec::new();
        for &step_s in steps_s {
            points.push(Point { step_s, relative_error: (impact(integrator, step_s)? / truth - 1.0).abs() });
        }
        let slope = slope(&points);
        all.push(Convergence { integrator: name.into(), points, slope });
    }
    Ok(all)
}

/// Slope of log error over log step, by regression.
pub(crate) fn slope(points: &[Point]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|p| (p.step_s.ln(), p.relative_error.max(f64::MIN_POSITIVE).ln())).collect();
    let n = logs.len() as f64;
    let (mx, my) = (logs.iter().map(|l| l.0).sum::<f64>() / n, logs.iter().map(|l| l.1).sum::<f64>() / n);
    logs.iter().map(|(x, y)| (x - mx) * (y - my)).sum::<f64>() / logs.iter().map(|(x, _)| (x - mx) * (x - mx)).sum::<f64>()
}

/// Steps of the table: half a millisecond down, each half of the one before, none a divisor of the instant of impact.
pub fn default_steps_s() -> Vec<f64> {
    (0..8).map(|i| 2e-4 / f64::from(1_u32 << i)).collect()
}

/// Rows: the exact integrator is exact at steps that resolve the peak, the others converge at least linearly through the impact.
///
/// # Errors
/// [`ValidationError::Engine`].
pub fn convergence_rows() -> Result<Vec<Row>, ValidationError> {
    let claim = "convergence of the peak force through an impact";
    let all = convergence(&default_steps_s())?;
    let mut rows = Vec::new();
    for one in &all {
        let finest = one.points.last().map_or(f64::NAN, |p| p.relative_error);
        if one.integrator == Integrator::Exact.name() {
            rows.push(Row::at_most(format!("{}: relative error", one.integrator), claim, finest, EXACT));
        } else {
            rows.push(Row::above(format!("{}: slope", one.integrator), claim, one.slope, 0.9));
        }
    }
    Ok(rows)
}
