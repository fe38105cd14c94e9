//! The linear response beside a measured one.

use feeler_analysis::frf::FrfExperiment;
use feeler_plant::description::{Machine, Quantity, SignalName};

use super::error::{FrfError, require};

/// Smallest distance of two frequencies that counts as a gap, over the smallest spacing.
const GAP: f64 = 1.5;
/// Step between frequencies at which a curve is drawn, as a share of them.
const STEP: f64 = 0.01;

/// Frequencies (Hz) between those of an estimate, without measurements: everywhere between isolated
/// frequencies, otherwise only in the gaps.
pub fn between(frequencies_hz: &[f64], isolated: bool) -> Vec<f64> {
    let spacing = frequencies_hz.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let gaps = frequencies_hz.windows(2).filter(|pair| isolated || pair[1] - pair[0] > GAP * spacing);
    let filled = gaps.flat_map(|pair| {
        let ratio = pair[1] / pair[0];
        let count = ((ratio.ln() / STEP).ceil() as usize).clamp(2, 200);
        (1..count).map(move |i| pair[0] * ratio.powf(i as f64 / count as f64))
    });
    filled.collect()
}

/// The signal that a sensor reads, if the given signal is its reading.
pub fn sensed(machine: &Machine, signal: &SignalName) -> Option<String> {
    let sensor = machine.sensors.get(&signal.element).filter(|_| signal.quantity == Quantity::Reading)?;
    Some(sensor.reads.to_string())
}

/// Rejects an output that the input does not affect, by linear theory.
///
/// # Errors
/// The refusal, or a machine outside linear theory.
pub fn require_path(
    experiment: &FrfExperiment,
    (low_hz, high_hz): (f64, f64),
    input: &str,
) -> Result<(), FrfError> {
    let ends = [low_hz, (low_hz * high_hz).sqrt(), high_hz];
    let response = experiment.linear_response(&ends)?;
    require(
        response.iter().any(|value| value.norm() > 0.0),
        || {
            format!(
                "{input} does not reach {}: the machine has no path between them with these contacts",
                experiment.output
            )
        },
        "name another --output, as the acceleration of a body; no force reaches a contact that is absent, \
         and a contact of force k d^1.5 needs a mean force (--offset) to have a stiffness",
    )?;
    Ok(())
}
