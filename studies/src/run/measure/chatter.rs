//! Figures of a sustained oscillation.

use feeler_lti::spectral::dominant_frequency;
use serde::Serialize;

use crate::run::measure::contact::Interval;

/// Largest number of cycles after which chatter may repeat: 1, or a multiple after period doublings.
const MOST_IMPACTS_PER_PERIOD: usize = 8;
/// Largest relative spread of the period of chatter that repeats.
const REPEATS_WITHIN: f64 = 0.02;
/// Smallest number of repetitions of a period.
const LEAST_REPEATS: usize = 3;

/// A sustained oscillation of a contact force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Oscillation {
    /// Frequency of repetition, Hz: from the instants of touch-down if the tool leaves the workpiece and the
    /// impacts repeat, else from the spectrum.
    pub frequency_hz: f64,
    /// Half of peak to peak, N. It has the unit of `controlled` if that is present.
    pub amplitude_n: f64,
    /// Frequency of the strongest line of the force's spectrum, Hz; `None` if there is no line.
    pub spectral_hz: Option<f64>,
    /// Amplitude of that line, N; `None` without one. It has the unit of `controlled` if that is present.
    pub spectral_amplitude_n: Option<f64>,
    /// Touch-downs per second.
    pub impacts_per_s: f64,
    /// Share of the time in contact.
    pub contact_share: f64,
    /// Number of impacts after which it repeats (1, or more after period doublings); `None` if impacts do not
    /// repeat.
    pub impacts_per_period: Option<usize>,
}

/// The oscillation of `force_n` (rows `period_s` apart) within `tail_s`, of a contact with these touch-downs
/// and spans of pushing.
pub(in crate::run) fn oscillation(
    touches_s: &[f64],
    spans: &[Interval],
    force_n: &[f64],
    period_s: f64,
    tail_s: [f64; 2],
) -> Oscillation {
    let (low, high) =
        force_n.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &f| (low.min(f), high.max(f)));
    let length_s = tail_s[1] - tail_s[0];
    let touches: Vec<f64> =
        touches_s.iter().copied().filter(|t| (tail_s[0]..=tail_s[1]).contains(t)).collect();
    let impacts_per_s = match touches.as_slice() {
        [first, .., last] => (touches.len() - 1) as f64 / (last - first),
        _ => 0.0,
    };
    let in_contact: f64 = spans.iter().map(|interval| interval.within_s(tail_s[0], tail_s[1])).sum();
    let impacts_per_period = impacts_per_period(&touches);
    // At least two cycles within the tail.
    let band = (2.0 / length_s, 0.5 / period_s);
    let line = dominant_frequency(force_n, period_s, band).ok().flatten();
    let frequency_hz = match impacts_per_period {
        Some(impacts) => impacts_per_s / impacts as f64,
        None => line.map_or(impacts_per_s, |(frequency, _)| frequency),
    };
    Oscillation {
        frequency_hz,
        amplitude_n: if high > low { 0.5 * (high - low) } else { 0.0 },
        spectral_hz: line.map(|(frequency, _)| frequency),
        spectral_amplitude_n: line.map(|(_, amplitude)| amplitude),
        impacts_per_s,
        contact_share: in_contact / length_s,
        impacts_per_period,
    }
}

/// The smallest number of impacts after which the intervals between them repeat.
fn impacts_per_period(touches_s: &[f64]) -> Option<usize> {
    let spread = |step: usize| {
        let periods: Vec<f64> = touches_s.windows(step + 1).map(|window| window[step] - window[0]).collect();
        let mean = periods.iter().sum::<f64>() / periods.len() as f64;
        (periods.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / periods.len() as f64).sqrt() / mean
    };
    (1..=MOST_IMPACTS_PER_PERIOD)
        .find(|&step| touches_s.len() > step * LEAST_REPEATS && spread(step) < REPEATS_WITHIN / step as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touches(intervals: &[f64], count: usize) -> Vec<f64> {
        intervals.iter().cycle().take(count).scan(0.0, |t, dt| Some(std::mem::replace(t, *t + dt))).collect()
    }

    #[test]
    fn truth_periods_are_counted_in_impacts() {
        assert_eq!(impacts_per_period(&touches(&[0.04], 20)), Some(1));
        assert_eq!(impacts_per_period(&touches(&[0.04, 0.05], 20)), Some(2));
        assert_eq!(impacts_per_period(&touches(&[0.04, 0.05, 0.04, 0.06], 20)), Some(4));
        // Intervals of a logistic map in chaos.
        let chaos: Vec<f64> = std::iter::successors(Some(0.3), |x| Some(4.0 * x * (1.0 - x)))
            .take(60)
            .map(|x| 0.02 + 0.02 * x)
            .collect();
        assert_eq!(impacts_per_period(&touches(&chaos, 60)), None);
        assert_eq!(impacts_per_period(&[0.0, 0.1, 0.2]), None);
    }
}
