//! What linear theory adds: how far the loop is from its limit, and how fast it is.

use feeler_analysis::{ControlLoop, SampledLoop};
use feeler_control::LinearLaw;
use feeler_engine::Scenario;
use feeler_lti::{DiscreteStateSpace, StateSpace};
use feeler_plant::assembly::Source;
use nalgebra::DMatrix;

use crate::sweep::{contact_view, sampled_growth_per_s};

/// Factors of the loop's gain that are tried: from here to its inverse.
const SMALLEST_FACTOR: f64 = 0.02;
/// Factors tried, evenly by ratio.
const FACTORS: u32 = 48;
/// A margin is located to this.
const MARGIN_ACCURACY: f64 = 1e-3;
/// Frequency that counts as low, Hz.
const LOWEST_HZ: f64 = 0.05;
/// Frequencies from there to half of the sampling rate at which the closed loop is looked at, evenly by ratio: 1 % apart.
const FREQUENCIES: u32 = 900;

/// The loop in contact with the drives' gain scaled.
fn scaled(whole: &ControlLoop, factor: f64) -> Option<ControlLoop> {
    whole.altered(|assembly, _| assembly.drives.iter_mut().for_each(|drive| drive.gain *= factor)).ok()
}

fn is_stable(whole: &ControlLoop, factor: f64) -> Option<bool> {
    sampled_growth_per_s(&scaled(whole, factor)?).ok().map(|rate| rate < 0.0)
}

/// Whether the sampled loop in contact is stable; none where linear theory has no answer.
pub(super) fn is_stable_in_contact(scenario: &Scenario) -> Option<bool> {
    let whole = ControlLoop::new(scenario, &contact_view(scenario)).ok()?;
    is_stable(&whole, 1.0)
}

/// The largest factor on the loop's gain up to which it is stable in contact: below one where it is unstable as it is, infinite where none within
/// reason destabilises it, zero where no smaller gain helps.
pub(super) fn gain_margin(scenario: &Scenario) -> Option<f64> {
    let whole = ControlLoop::new(scenario, &contact_view(scenario)).ok()?;
    let factor = |i: u32| SMALLEST_FACTOR * SMALLEST_FACTOR.powf(-2.0 * f64::from(i) / f64::from(FACTORS));
    let mut stable: Option<f64> = None;
    for i in 0..=FACTORS {
        let here = factor(i);
        match (is_stable(&whole, here)?, stable) {
            (true, _) => stable = Some(here),
            // Gains below the first stable one do not count: an open loop may be unstable.
            (false, None) => {}
            (false, Some(below)) => {
                let (mut low, mut high) = (below, here);
                while high / low > 1.0 + MARGIN_ACCURACY {
                    let middle = (low * high).sqrt();
                    if is_stable(&whole, middle)? { low = middle } else { high = middle }
                }
                return Some(low);
            }
        }
    }
    Some(if stable.is_some() { f64::INFINITY } else { 0.0 })
}

/// The frequency at which the reading, as the sampled loop makes it follow the reference, first falls 3 dB below what it is at low frequency, Hz; half of
/// the sampling rate where it never does.
pub(super) fn bandwidth_hz(scenario: &Scenario) -> Option<f64> {
    let whole = ControlLoop::new(scenario, &contact_view(scenario)).ok()?;
    let controller = crate::run::ForceLoop::find(scenario).map_or(0, |found| found.controller);
    let wiring = whole.controllers().get(controller)?;
    let nyquist_hz = 0.5 / wiring.spec.period_s;
    let ratio = (nyquist_hz / LOWEST_HZ).powf(1.0 / f64::from(FREQUENCIES));
    let frequencies_hz: Vec<f64> = (0..FREQUENCIES).map(|i| LOWEST_HZ * ratio.powi(i.cast_signed())).collect();

    let reading = whole.plant().output(Source::Sensor(wiring.reading?)).ok()?;
    let plant = SampledLoop::response_to(&whole, controller, reading).ok()?;
    let open = SampledLoop::new(&whole).ok()?.open_loop(controller).ok()?;
    let law = of_reference(&wiring.spec.linear(wiring.motion_is_velocity).ok()?, wiring.spec.period_s)?;
    let response = |system: &DiscreteStateSpace| system.frequency_response(&frequencies_hz).ok();
    let (plant, open, law) = (response(&plant)?, response(&open)?, response(&law)?);
    let closed = |i: usize| (plant[i][(0, 0)] * law[i][(0, 0)] / (open[i][(0, 0)] + 1.0)).norm();
    let least = closed(0) * std::f64::consts::FRAC_1_SQRT_2;
    let falls = (1..frequencies_hz.len()).find(|&i| closed(i) < least);
    Some(falls.map_or(nyquist_hz, |i| frequencies_hz[i]))
}

/// A law from its reference to its output.
fn of_reference(law: &LinearLaw, period_s: f64) -> Option<DiscreteStateSpace> {
    let n = law.c.len();
    let a = DMatrix::from_fn(n, n, |i, j| law.a[i][j]);
    let b = DMatrix::from_fn(n, 1, |i, _| law.b[i][0]);
    let c = DMatrix::from_fn(1, n, |_, j| law.c[j]);
    StateSpace::discrete(a, b, c, DMatrix::from_element(1, 1, law.d[0]), period_s).ok()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::format::{Document, Setting};

    fn bandwidth(settings: &[(&str, f64)]) -> f64 {
        let document = Document::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("paper/flexible-contact.toml")).unwrap();
        let settings = settings.iter().map(|(key, value)| (*key, Setting::Number(*value)));
        bandwidth_hz(&document.with(settings).unwrap().scenario).unwrap()
    }

    #[test]
    fn prop_a_lower_gain_gains_no_bandwidth() {
        let gains = [0.8, 0.4, 0.2, 0.1, 0.05].map(|kp| bandwidth(&[("controllers.force.kp", kp)]));
        assert!(gains.windows(2).all(|pair| pair[1] <= pair[0]), "{gains:?}");
    }

    #[test]
    fn prop_damping_alone_does_not_multiply_the_bandwidth() {
        let (without, with) = (bandwidth(&[]), bandwidth(&[("springs.guide.damping", 600.0)]));
        assert!(with < 1.5 * without, "{with} {without}");
    }
}
