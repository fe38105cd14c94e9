//! Error against step size of every integrator, through the first impact of the reference machines.

use std::fmt::Write as _;
use std::path::Path;

use feeler_engine::{Integrator, Program, RunSettings, Scenario, Simulation, Trace};
use feeler_files::Document;
use feeler_plant::description::{Quantity, SignalName};
use serde::Serialize;

use crate::error::ValidationError;
use crate::table::CheckRow;

/// Reference machines, and the largest contact force (N) of each on a grid of 0.1 ms. The numbers come from
/// three independent integrations with located events, which agree to 1e-9 N.
const MACHINES: [(&str, f64); 3] =
    [("m1", 140.269_504_131_704_14), ("m2", 142.273_739_491_869_86), ("m4", 127.472_053_082_160_19)];
/// Tolerance of those numbers, N: the requirement on the exact integrator.
const INDEPENDENT_N: f64 = 1e-6;
/// Peaks of the exact integrator at any two steps agree to this share. It covers rounding, and the parabola
/// through rows of 10 us, (w h)^4 of 1e-3.
const EXACT: f64 = 1e-9;
/// Fixed-step methods handle an event at the end of its step, which is first order. The position of the event
/// within the step is random. After averaging over sixteen phases in a bin, a spread of 0.2 in the logarithm
/// remains, over steps that span a factor of 32.
const ORDER: [f64; 2] = [0.85, 1.15];
/// The first impact ends before this, s.
const DURATION_S: f64 = 0.058;
/// Row spacing for peaks of the exact motion, a divisor of the controllers' period, s.
const FINE_S: f64 = 1e-5;
/// The two steps at which the exact integrator must agree with itself, s.
const APART_S: [f64; 2] = [1e-3, 1e-5];
/// Number of steps about each nominal one.
const PHASES: u32 = 16;
/// Largest relative distance of these steps from the nominal one.
const AROUND: f64 = 0.09;
/// Fractional part of the golden section, whose multiples spread evenly and match no period of the
/// controller.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// One integrator at one step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Nominal step, s.
    pub step_s: f64,
    /// Relative error of the peak force: root mean square over sixteen steps about the nominal one.
    pub relative_error: f64,
}

/// One integrator over all steps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Convergence {
    /// Name of the machine.
    pub machine: String,
    /// Name of the integrator.
    pub integrator: String,
    /// Coarsest step first.
    pub points: Vec<Point>,
    /// Slope of log error over log step, by regression; `None` if all errors are rounding.
    pub order: Option<f64>,
}

/// A reference machine with the reference of its errors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Truth {
    /// Name of the machine.
    pub machine: String,
    /// Largest contact force of the exact motion, N.
    pub peak_n: f64,
    /// Relative difference of the peaks at steps of 1 ms and 10 us.
    pub apart: f64,
    /// Difference to the independent number, on its grid, N.
    pub independent_n: f64,
}

/// Errors of all integrators on all machines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Study {
    /// The reference of the errors.
    pub truths: Vec<Truth>,
    /// Machine by machine.
    pub series: Vec<Convergence>,
}

/// Contact force at rows `row_s` apart.
fn force(
    scenario: &Scenario,
    integrator: Integrator,
    step_s: f64,
    row_s: f64,
) -> Result<Vec<f64>, ValidationError> {
    let record = vec![SignalName::new("tool", Quantity::Force)];
    let run = RunSettings {
        duration_s: DURATION_S,
        step_s,
        integrator,
        record,
        record_rate_hz: Some(1.0 / row_s),
        ..scenario.run.clone()
    };
    let program = Program::new(&Scenario { run, ..scenario.clone() })?;
    let mut trace = Trace::new(program.record_names());
    Simulation::<f64>::new(vec![program])?.run(&mut trace)?;
    Ok(trace.columns.swap_remove(0))
}

/// The largest value between rows: of the parabola through three of them, unless a controller sample, at
/// which the force may bend, lies inside.
fn peak(force: &[f64], row_s: f64, period_s: f64) -> f64 {
    let largest = force.iter().copied().fold(0.0, f64::max);
    let at = force.iter().position(|&f| f.total_cmp(&largest).is_eq()).unwrap_or(0);
    let sample = |row: usize| ((row as f64 * row_s / period_s) * (1.0 + 1e-12)).floor();
    let top = |first: usize| {
        let [a, b, c] = force.get(first..first + 3)?.try_into().ok()?;
        // The last row may be the sample itself; the others belong to one hold.
        let held = sample(first).total_cmp(&sample(first + 1)).is_eq()
            && (first + 2) as f64 * row_s <= (sample(first) + 1.0) * period_s * (1.0 + 1e-12);
        let (bend, slope): (f64, f64) = (a - 2.0 * b + c, 0.5 * (c - a));
        let vertex = -slope / bend;
        (held && bend < 0.0 && vertex.abs() <= 1.0).then(|| b - 0.5 * slope * slope / bend)
    };
    (at.saturating_sub(2)..=at).filter_map(top).fold(largest, f64::max)
}

/// Errors of all integrators, from the reference machines among the scenario files.
///
/// # Errors
/// [`ValidationError::Reference`] if a file is absent or has mistakes, [`ValidationError::Engine`].
pub fn convergence(scenarios: &Path, steps_s: &[f64]) -> Result<Study, ValidationError> {
    let mut study = Study { truths: Vec::new(), series: Vec::new() };
    for (name, independent_n) in MACHINES {
        let path = scenarios.join("reference").join(format!("{name}.toml"));
        let document =
            Document::load(&path).map_err(|error| ValidationError::Reference { what: error.to_string() })?;
        let scenario = &document.scenario;
        let period_s =
            scenario.controllers.values().map(|used| used.spec.period_s).fold(f64::INFINITY, f64::min);
        let exact = |step_s| -> Result<f64, ValidationError> {
            Ok(peak(&force(scenario, Integrator::Exact, step_s, FINE_S)?, FINE_S, period_s))
        };
        let [coarse_n, peak_n] = [exact(APART_S[0])?, exact(APART_S[1])?];
        let on_grid_n = force(scenario, Integrator::Exact, 1e-4, 1e-4)?.into_iter().fold(0.0, f64::max);
        let (apart, independent_n) = ((coarse_n / peak_n - 1.0).abs(), (on_grid_n - independent_n).abs());
        study.truths.push(Truth { machine: name.into(), peak_n, apart, independent_n });
        for (integrator, title) in Integrator::ALL {
            let mut points = Vec::new();
            for &step_s in steps_s {
                let mut squares = 0.0;
                for phase in 1..=PHASES {
                    let h = step_s * (1.0 + AROUND * (2.0 * (GOLDEN * f64::from(phase)).fract() - 1.0));
                    // The exact motion may be evaluated between its steps; additional rows would shorten a
                    // fixed step.
                    let row_s = if integrator == Integrator::Exact { FINE_S } else { h };
                    let error = peak(&force(scenario, integrator, h, row_s)?, row_s, period_s) / peak_n - 1.0;
                    squares += error * error;
                }
                points.push(Point { step_s, relative_error: (squares / f64::from(PHASES)).sqrt() });
            }
            let order = points.iter().any(|point| point.relative_error > EXACT).then(|| slope(&points));
            study.series.push(Convergence { machine: name.into(), integrator: title.into(), points, order });
        }
    }
    Ok(study)
}

/// Slope of log error over log step, by regression.
pub(crate) fn slope(points: &[Point]) -> f64 {
    let logs: Vec<(f64, f64)> =
        points.iter().map(|p| (p.step_s.ln(), p.relative_error.max(f64::MIN_POSITIVE).ln())).collect();
    let n = logs.len() as f64;
    let (mx, my) = (logs.iter().map(|l| l.0).sum::<f64>() / n, logs.iter().map(|l| l.1).sum::<f64>() / n);
    logs.iter().map(|(x, y)| (x - mx) * (y - my)).sum::<f64>()
        / logs.iter().map(|(x, _)| (x - mx) * (x - mx)).sum::<f64>()
}

/// Steps of the table: 50 us down, each half of the one before. From about 0.1 ms on, semi-implicit Euler
/// reaches M4's workpiece so late that its controller sees the contact a sample later. The motion is then
/// different, and its peak does not show an order.
pub fn default_steps_s() -> Vec<f64> {
    (0..6).map(|i| 5e-5 / f64::from(1_u32 << i)).collect()
}

/// The study as the page `docs/convergence.md`.
pub fn markdown(study: &Study) -> String {
    let mut text = String::from(
        "# Convergence through an impact\n\
         \n\
         ```console\n\
         # long: some minutes\n\
         feeler validate convergence\n\
         benches/peers/run              # measures the simulators of the picture, and draws it\n\
         ```\n\
         \n\
         ![Error of the peak force against computing time](work-precision.svg)\n\
         \n\
         The reference machines M1, M2 and M4 (`scenarios/reference/`) meet a wall or a workpiece under\n\
         sampled force control. The tables show the relative error of the largest contact force, by\n\
         integrator and step. The order is the slope of log error over log step, by regression. The\n\
         first command makes this page, the second one the picture ([performance](performance.md)).\n\
         \n\
         Each number is the root mean square over sixteen steps within 9 % of the nominal one. These steps\n\
         are incommensurate with the controller's period of 1 ms, so events fall anywhere in a step. Steps\n\
         of 0.1 ms are too coarse to show an order. Semi-implicit Euler then meets the workpiece of M4 so\n\
         late that its controller sees the contact one sample later. The largest force differs by 3 %.\n",
    );
    for truth in &study.truths {
        let columns: Vec<&Convergence> =
            study.series.iter().filter(|series| series.machine == truth.machine).collect();
        let _ = write!(
            text,
            "\n## {}: largest force {:.6} N\n\n| step (s) |",
            truth.machine.to_uppercase(),
            truth.peak_n
        );
        for column in &columns {
            let _ = write!(text, " {} |", column.integrator);
        }
        let _ = writeln!(text, "\n|---|{}", "---|".repeat(columns.len()));
        for (i, point) in columns.first().map_or(&[][..], |column| &column.points).iter().enumerate() {
            let _ = write!(text, "| {:e} |", (point.step_s * 1e12).round() / 1e12);
            for column in &columns {
                let _ = write!(text, " {} |", shown(column.points[i].relative_error));
            }
            text.push('\n');
        }
        text.push_str("| order |");
        for column in &columns {
            let order = column.order.map_or_else(|| "exact".to_owned(), |order| format!("{order:.2}"));
            let _ = write!(text, " {order} |");
        }
        text.push('\n');
    }
    text.push_str(
        "\n\
         ## How to read it\n\
         \n\
         The exact integrator locates events, and its motion does not depend on the step. Its peak is the\n\
         reference here: the same at steps of 1 ms and 10 us, to machine precision. On a grid of 0.1 ms it\n\
         agrees with numbers computed outside this project within 1e-6 N (`feeler validate` checks both).\n\
         \n\
         The fixed-step methods place an event at the end of its step, so they are of first order through\n\
         an impact. On smooth motion semi-implicit Euler is of order 1 and RK4 of order 4\n\
         (`cargo test -p feeler-engine order_`).\n\
         \n\
         Words: [glossary](glossary.md).\n",
    );
    text
}

/// Errors at the level of rounding differ between processors.
fn shown(error: f64) -> String {
    if error < EXACT { format!("< {EXACT:e}") } else { format!("{error:.2e}") }
}

/// Rows: the exact integrator is exact and agrees with the independent numbers, the others converge at first
/// order through the impact.
///
/// # Errors
/// As [`convergence`].
pub(crate) fn convergence_rows(scenarios: &Path) -> Result<Vec<CheckRow>, ValidationError> {
    Ok(study_rows(&convergence(scenarios, &default_steps_s())?))
}

/// Rows of a finished study.
pub fn study_rows(study: &Study) -> Vec<CheckRow> {
    let claim = "convergence of the peak force through an impact";
    let mut rows = Vec::new();
    for truth in &study.truths {
        rows.push(CheckRow::at_most(
            format!("{}: peak at steps of 1 ms and 10 us", truth.machine),
            claim,
            truth.apart,
            EXACT,
        ));
        rows.push(CheckRow::at_most(
            format!("{}: peak against independent numbers, N", truth.machine),
            claim,
            truth.independent_n,
            INDEPENDENT_N,
        ));
    }
    for one in &study.series {
        let name = format!("{}, {}", one.machine, one.integrator);
        rows.push(if let Some(order) = one.order {
            let [low, high] = ORDER;
            CheckRow::close(format!("{name}: order"), claim, order, 0.5 * (low + high), 0.5 * (high - low))
        } else {
            let worst = one.points.iter().map(|point| point.relative_error).fold(0.0, f64::max);
            CheckRow::at_most(format!("{name}: relative error"), claim, worst, EXACT)
        });
    }
    rows
}
