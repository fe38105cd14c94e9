//! Impacts in a joint with free play appear in the accelerations on both sides of it, whatever the model.
//!
//! There is no force between the flanks of free play, but a large one at a flank. The difference of the two
//! accelerations is therefore small most of the time and large briefly. Its kurtosis shows this: 3 for noise
//! and for sums of many sines, less for few sines, and far more for rare impacts. A linear flexible joint
//! keeps the kurtosis of the excitation.

use feeler_plant::assembly::Source;
use feeler_plant::description::{Engagement, Quantity};

use crate::dataset::Dataset;

/// Smallest kurtosis of a difference of accelerations with impacts: more than twice that of noise.
const IMPACTS: f64 = 7.0;
/// Smallest ratio of the deviation of the difference to that of its noise at which the kurtosis is
/// meaningful.
const OVER_NOISE: f64 = 5.0;

/// Evidence that two bodies with accelerometers hit each other; `None` without evidence. Records in which a
/// tool touches and leaves contain impacts anyway, and are ignored.
pub(crate) fn rattles(dataset: &Dataset) -> Option<String> {
    let accelerations: Vec<usize> = (0..dataset.channels.len())
        .filter(|&c| dataset.channels[c].quantity(&dataset.machine) == Quantity::Acceleration)
        .collect();
    let [first, .., last] = accelerations[..] else { return None };
    let is_of_a_body = |c: usize| matches!(dataset.channels[c].source, Source::Sensor(_) | Source::Node(..));
    if !(is_of_a_body(first) && is_of_a_body(last)) {
        return None;
    }
    let noise = dataset.channels[first].noise.hypot(dataset.channels[last].noise);
    let own = dataset.machine.contacts.values().next().map_or(Engagement::Free, |contact| contact.engagement);
    let mut found: Vec<f64> = dataset
        .records
        .iter()
        .filter(|record| record.engagement.unwrap_or(own) != Engagement::Unilateral)
        .filter_map(|record| {
            let difference: Vec<f64> =
                record.series[last].iter().zip(&record.series[first]).map(|(a, b)| a - b).collect();
            let (deviation, kurtosis) = shape(&difference);
            (deviation > OVER_NOISE * noise).then_some(kurtosis)
        })
        .collect();
    found.sort_by(f64::total_cmp);
    let middle = found.get(found.len() / 2).copied().filter(|middle| *middle > IMPACTS)?;
    let [a, b] = [first, last].map(|c| &dataset.channels[c].column);
    Some(format!(
        "`{a}` and `{b}` differ in impacts (kurtosis {middle:.0}, 3 for a joint that bends): the bodies hit \
         each other across a free play"
    ))
}

/// Standard deviation and kurtosis.
fn shape(series: &[f64]) -> (f64, f64) {
    let n = series.len().max(1) as f64;
    let mean = series.iter().sum::<f64>() / n;
    let moment = |power: i32| series.iter().map(|x| (x - mean).powi(power)).sum::<f64>() / n;
    let variance = moment(2);
    (variance.sqrt(), moment(4) / variance.powi(2).max(f64::MIN_POSITIVE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_sine_has_a_kurtosis_of_three_halves_and_rare_blows_a_large_one() {
        let sine: Vec<f64> =
            (0..1000).map(|k| (std::f64::consts::TAU * f64::from(k) / 100.0).sin()).collect();
        // Whole periods: the moments are exact to machine precision.
        assert!((shape(&sine).1 - 1.5).abs() < 1e-9);
        let blows: Vec<f64> = (0..1000).map(|k| if k % 50 == 0 { 1.0 } else { 0.0 }).collect();
        // p = 1/50: (1 - 3 p (1 - p)) / (p (1 - p)) = 48.02.
        assert!((shape(&blows).1 - 48.02).abs() < 0.01);
    }
}
