//! When a drive or controller was at its limit.

use feeler_engine::{Scenario, Trace};
use feeler_plant::assembly::Assembly;
use feeler_plant::description::{Quantity, SignalName};

/// A value this close to its limit is at it: limits act on held numbers, so all that separates the two is rounding.
const AT_LIMIT: f64 = 1.0 - 1e-9;

/// For each row of the record whether some drive or controller was at its limit. Commands and outputs are held between controller samples, so the
/// share of rows is the share of samples.
pub(super) fn rows(scenario: &Scenario, assembly: &Assembly, record: &Trace) -> Vec<bool> {
    let mut saturated = vec![false; record.t_s.len()];
    let mut mark = |element: &str, quantity, gain: f64, limit: f64| {
        let signal = SignalName::new(element, quantity).to_string();
        for (flag, value) in saturated.iter_mut().zip(record.column(&signal).unwrap_or_default()) {
            *flag |= (gain * value).abs() >= limit * AT_LIMIT;
        }
    };
    for drive in assembly.drives.iter().filter(|drive| drive.limit.is_finite()) {
        // A force drive clamps its command, a velocity source its effort.
        match drive.velocity_source {
            None => mark(&drive.name, Quantity::Command, drive.gain, drive.limit),
            Some(_) => mark(&drive.name, Quantity::Force, 1.0, drive.limit),
        }
    }
    for (name, used) in &scenario.controllers {
        if let Some(limit) = used.spec.output_limit {
            mark(name, Quantity::Output, 1.0, limit);
        }
    }
    saturated
}

/// Share of rows that are marked.
pub(super) fn share(saturated: &[bool]) -> f64 {
    saturated.iter().filter(|&&flag| flag).count() as f64 / saturated.len().max(1) as f64
}
