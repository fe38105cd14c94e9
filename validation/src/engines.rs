//! Two engines against each other: Feeler's exact one and Rapier, on the paper's machines and the reference
//! machines M1, M2 and M4.

use std::path::Path;

use feeler_control::{ForceGains, ReferenceSpec};
use feeler_engine::{Integrator, Program, Scenario, Trace};
use feeler_files::Document;
use feeler_plant::description::{ActuatorKind, Engagement, Quantity, SignalName};
use feeler_studies::run::simulation;
use serde::Serialize;

use crate::convergence::{Point, slope};
use crate::error::ValidationError;
use crate::experiments::{HOLD_S, paper_axes};
use crate::table::CheckRow;

/// Reference machines with an impact, by their scenario files.
const REFERENCES: [&str; 3] = ["m1", "m2", "m4"];
/// End of the runs, s: after touch-down and the first bounce of the reference machines. A later impact falls
/// near a controller sample, where any difference of the engines changes the number of commands.
const DURATION_S: f64 = 0.1;
/// Rows of the compared records per second; all steps divide its period.
const RECORD_HZ: f64 = 2000.0;
/// Gains well inside the stable ranges of all paper machines with one sample's hold: force per force, and
/// speed per force.
const GAINS: (f64, f64) = (0.2, 5e-4);
/// Largest departure from order one, by regression, on smooth motion: errors of second order, a few
/// hundredths of the first at the coarsest step.
const SMOOTH_ORDER: f64 = 0.03;
/// The same departure through impacts. An impact takes effect at the end of a step, up to one step late. This
/// scatters the errors about their trend by a factor of two. Over six halvings of the step that is at most
/// 0.35 in the slope.
const IMPACT_ORDER: f64 = 0.35;
/// Largest difference at the finest step over the travel: a few steps of 5 us times the machines' fastest 800
/// rad/s.
const FINEST: f64 = 1e-2;

/// One machine in both engines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EngineAgreement {
    /// Name of the machine.
    pub machine: String,
    /// Whether the tip hits the workpiece, or is attached to it.
    pub impact: bool,
    /// Coarsest step first: largest difference of the tip's position over its largest travel.
    pub points: Vec<Point>,
    /// Slope of log difference over log step, by regression.
    pub order: f64,
}

/// Steps of Rapier, s: each half of the one before.
pub fn default_steps_s() -> Vec<f64> {
    (0..6).map(|i| 1.25e-4 / f64::from(1_u32 << i)).collect()
}

/// The machines of the comparison. The paper's under force control attach to the workpiece. The reference
/// machines hit it; they need the folder of scenario files.
///
/// # Errors
/// [`ValidationError::Reference`] for a scenario file that is absent or has mistakes.
pub fn machines(scenarios: Option<&Path>) -> Result<Vec<(String, Scenario)>, ValidationError> {
    let mut all = Vec::new();
    for (name, axis) in paper_axes() {
        let kp = if matches!(axis.drive, ActuatorKind::VelocitySource { .. }) { GAINS.1 } else { GAINS.0 };
        let mut scenario = axis.force_loop(ForceGains { kp, ..ForceGains::default() }, HOLD_S, 0.0);
        for used in scenario.controllers.values_mut() {
            used.spec.reference = ReferenceSpec::Constant(20.0);
        }
        all.push((name, scenario));
    }
    for name in REFERENCES.iter().filter(|_| scenarios.is_some()) {
        let path = scenarios.unwrap_or(Path::new("")).join("reference").join(format!("{name}.toml"));
        let document =
            Document::load(&path).map_err(|error| ValidationError::Reference { what: error.to_string() })?;
        all.push((name.to_uppercase(), document.scenario));
    }
    Ok(all)
}

/// Position of the tip over the run.
fn positions(scenario: &Scenario, integrator: Integrator, step_s: f64) -> Result<Vec<f64>, ValidationError> {
    let mut scenario = scenario.clone();
    let run = &mut scenario.run;
    (run.duration_s, run.step_s, run.integrator, run.record_rate_hz) =
        (DURATION_S, step_s, integrator, Some(RECORD_HZ));
    run.record = vec![SignalName::new("tip", Quantity::Position)];
    let program = Program::new(&scenario)?;
    let mut trace = Trace::new(program.record_names());
    simulation(program, scenario.machine.axis)?.run(&mut trace)?;
    Ok(trace.columns.swap_remove(0))
}

/// Runs one machine in both engines.
///
/// # Errors
/// [`ValidationError::Engine`].
pub fn agreement(
    machine: &str,
    scenario: &Scenario,
    steps_s: &[f64],
) -> Result<EngineAgreement, ValidationError> {
    let exact = positions(scenario, Integrator::Exact, 1.0 / RECORD_HZ)?;
    let start = exact.first().copied().unwrap_or_default();
    let travel = exact.iter().map(|x| (x - start).abs()).fold(0.0, f64::max);
    let mut points = Vec::new();
    for &step_s in steps_s {
        let found = positions(scenario, Integrator::External, step_s)?;
        let worst = exact.iter().zip(&found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        points.push(Point { step_s, relative_error: worst / travel });
    }
    let impact =
        scenario.machine.contacts.values().any(|contact| contact.engagement == Engagement::Unilateral);
    Ok(EngineAgreement { machine: machine.into(), impact, order: slope(&points), points })
}

/// Every machine in both engines.
///
/// # Errors
/// Those of [`machines`] and [`agreement`].
pub fn agreements(
    scenarios: Option<&Path>,
    steps_s: &[f64],
) -> Result<Vec<EngineAgreement>, ValidationError> {
    machines(scenarios)?.iter().map(|(name, scenario)| agreement(name, scenario, steps_s)).collect()
}

/// Rows: the engines converge to each other at the order of Rapier's integrator, and are close at the finest
/// step.
pub fn engine_rows(agreements: &[EngineAgreement]) -> Vec<CheckRow> {
    let claim = "two engines converge to each other at first order";
    let of_machine = |one: &EngineAgreement| {
        let finest = one.points.last().map_or(f64::NAN, |point| point.relative_error);
        [
            CheckRow::close(
                format!("{}: order", one.machine),
                claim,
                one.order,
                1.0,
                if one.impact { IMPACT_ORDER } else { SMOOTH_ORDER },
            ),
            CheckRow::at_most(
                format!("{}: difference at the finest step, over the travel", one.machine),
                claim,
                finest,
                FINEST,
            ),
        ]
    };
    agreements.iter().flat_map(of_machine).collect()
}
