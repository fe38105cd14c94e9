//! Instants of sampled controllers over their common period.

use crate::error::AnalysisError;

/// Instants closer than this are equal, s, as in the engine's clock.
const SAME_INSTANT_S: f64 = 1e-12;
/// Largest number of samples of the fastest controller in a common period: a search for stable gains steps
/// through them about a hundred times.
const MOST_SAMPLES: usize = 1000;
/// Ratios of periods this close to a fraction are that fraction.
const COMMENSURATE: f64 = 1e-9;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Timing {
    pub(crate) period_s: f64,
    pub(crate) offset_s: f64,
    /// Time from a sample until its output acts, s.
    pub(crate) output_delay_s: f64,
    /// Delays of the two sensors; `None` without a sensor.
    pub(crate) sensor_delay_s: [Option<f64>; 2],
    /// Whether this is the loop of a sampled servo. It samples after all others of its instant, with the
    /// targets that they give.
    pub(crate) is_servo: bool,
}

/// An action at an instant, in order of execution; loops of servos act after all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Action {
    /// The signal of a delayed sensor (0: reading, 1: motion) of a controller is taken.
    Take(usize, usize),
    /// A controller samples.
    Sample(usize),
    /// The oldest output in transit of a controller takes effect.
    Arrive(usize),
}

impl Action {
    fn controller(self) -> usize {
        match self {
            Self::Take(i, _) | Self::Sample(i) | Self::Arrive(i) => i,
        }
    }
}

/// All instants of one common period, and the outputs in transit when it begins.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Schedule {
    pub(crate) common_s: f64,
    /// Instants from zero onwards, and what happens at each.
    pub(crate) instants: Vec<(f64, Vec<Action>)>,
    /// Per controller, outputs under way.
    pub(crate) pending: Vec<usize>,
    /// Per controller and sensor, signals taken but not yet read.
    pub(crate) taken: Vec<[usize; 2]>,
}

impl Schedule {
    pub(crate) fn new(timings: &[Timing]) -> Result<Self, AnalysisError> {
        let common_s = common_period_s(timings)?;
        let mut events: Vec<(f64, Action)> = Vec::new();
        let (mut pending, mut taken) = (vec![0; timings.len()], vec![[0; 2]; timings.len()]);
        let inside = |t: f64| t >= -SAME_INSTANT_S && t < common_s - SAME_INSTANT_S;
        for (i, timing) in timings.iter().enumerate() {
            let delays = timing.sensor_delay_s.iter().flatten().copied();
            let reach_s = delays.fold(timing.output_delay_s, f64::max);
            // From the first sample whose output arrives in this period to the last sample whose reading is
            // taken in it.
            let first = ((-reach_s - timing.offset_s) / timing.period_s).floor() as i64 - 1;
            let last = ((common_s + reach_s - timing.offset_s) / timing.period_s).ceil() as i64 + 1;
            for k in first..=last {
                let t = timing.offset_s + k as f64 * timing.period_s;
                let before = t < -SAME_INSTANT_S;
                if inside(t) {
                    events.push((t, Action::Sample(i)));
                }
                let arrival = t + timing.output_delay_s;
                if inside(arrival) {
                    events.push((arrival, Action::Arrive(i)));
                }
                pending[i] += usize::from(before && arrival >= -SAME_INSTANT_S);
                for (which, delay) in timing.sensor_delay_s.iter().enumerate() {
                    let Some(delay) = delay.filter(|delay| *delay > 0.0) else { continue };
                    if inside(t - delay) {
                        events.push((t - delay, Action::Take(i, which)));
                    }
                    taken[i][which] += usize::from(!before && t - delay < -SAME_INSTANT_S);
                }
            }
        }
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut instants: Vec<(f64, Vec<Action>)> = Vec::new();
        for (t, action) in events {
            match instants.last_mut() {
                Some((at, actions)) if t <= *at + SAME_INSTANT_S => actions.push(action),
                _ => instants.push((t, vec![action])),
            }
        }
        for (_, actions) in &mut instants {
            actions.sort_by_key(|&action| (timings[action.controller()].is_servo, action));
        }
        Ok(Self { common_s, instants, pending, taken })
    }
}

/// The shortest time that holds a whole number of each period.
fn common_period_s(timings: &[Timing]) -> Result<f64, AnalysisError> {
    let slowest = timings.iter().map(|t| t.period_s).fold(0.0, f64::max);
    let fastest = timings.iter().map(|t| t.period_s).fold(f64::INFINITY, f64::min);
    let most = (MOST_SAMPLES as f64 * fastest / slowest).max(1.0) as usize;
    let whole = |samples: usize| {
        timings.iter().all(|t| {
            let ratio = samples as f64 * slowest / t.period_s;
            (ratio - ratio.round()).abs() <= COMMENSURATE * ratio
        })
    };
    let samples =
        (1..=most).find(|&samples| whole(samples)).ok_or(AnalysisError::Rates { limit: MOST_SAMPLES })?;
    Ok(samples as f64 * slowest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timing(period_s: f64, output_delay_s: f64, sensor_delay_s: f64) -> Timing {
        let sensor_delay_s = [Some(sensor_delay_s), None];
        Timing { period_s, offset_s: 0.0, output_delay_s, sensor_delay_s, is_servo: false }
    }

    #[test]
    fn truth_two_rates_repeat_after_their_common_multiple() {
        let schedule = Schedule::new(&[timing(2e-3, 0.0, 0.0), timing(3e-3, 0.0, 0.0)]).unwrap();
        assert!((schedule.common_s - 6e-3).abs() < 1e-15);
        let samples = |i| {
            schedule
                .instants
                .iter()
                .flat_map(|(_, actions)| actions)
                .filter(|a| **a == Action::Sample(i))
                .count()
        };
        assert_eq!((samples(0), samples(1)), (3, 2));
    }

    #[test]
    fn truth_what_is_under_way_when_a_period_begins() {
        // 2.5 samples late: at zero the outputs of the last two samples are still in transit. Half a sample
        // of sensor delay takes one reading early.
        let schedule = Schedule::new(&[timing(1e-3, 2.5e-3, 0.5e-3)]).unwrap();
        assert_eq!((schedule.pending[0], schedule.taken[0]), (2, [1, 0]));
        assert_eq!(schedule.instants.len(), 2);
        // A delay of exactly one sample arrives with the next sample, after it.
        let schedule = Schedule::new(&[timing(1e-3, 1e-3, 0.0)]).unwrap();
        assert_eq!(schedule.pending[0], 1);
        assert_eq!(schedule.instants[0].1, vec![Action::Sample(0), Action::Arrive(0)]);
    }

    #[test]
    fn truth_periods_without_common_multiple_are_refused() {
        let refused = Schedule::new(&[timing(1e-3, 0.0, 0.0), timing(1e-3 * 2_f64.sqrt(), 0.0, 0.0)]);
        assert!(matches!(refused, Err(AnalysisError::Rates { .. })));
    }
}
