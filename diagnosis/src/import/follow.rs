//! Lag of a position behind its target, and the accuracy.

use feeler_logs::{Column, Table};

/// Number of compared instants.
const INSTANTS: usize = 4000;
/// Longest lag of the search, s.
const LONGEST_S: f64 = 0.5;
/// Smallest correlation of two columns of one motion.
const ONE_MOTION: f64 = 0.85;
/// How much better the reverse must match: half a period late, a motion that recurs is its own reverse.
const CLEARLY: f64 = 0.3;
/// Number of trial lags.
const LAGS: usize = 200;

/// How one column follows another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Follow {
    /// How much later, s.
    pub lag_s: f64,
    /// Correlation at this lag; negative if it moves the other way.
    pub correlation: f64,
    /// How many times as far it moves, in the numbers of the log.
    pub times: f64,
}

impl Follow {
    /// Whether it moves the other way.
    pub fn is_turned(self) -> bool {
        self.is_of_one_motion() && self.correlation < 0.0
    }

    /// Whether the two are of one motion.
    pub(super) fn is_of_one_motion(self) -> bool {
        self.correlation.abs() > ONE_MOTION
    }
}

/// The lag at which a position matches a target best, or its reverse if it matches that alone; `None` if
/// either is constant.
pub(super) fn follow(target: (&Table, &Column), position: (&Table, &Column)) -> Option<Follow> {
    let (target, position) = (Readings::of(target)?, Readings::of(position)?);
    let begin = target.times_s[0].max(position.times_s[0]) + LONGEST_S;
    let end = target.times_s.last()?.min(*position.times_s.last()?);
    if end <= begin {
        return None;
    }
    let at = |k: usize| begin + (end - begin) * k as f64 / INSTANTS as f64;
    let is: Vec<f64> = (0..INSTANTS).map(|k| position.at(at(k))).collect();
    let tried = (0..=LAGS).filter_map(|lag| {
        let lag_s = LONGEST_S * lag as f64 / LAGS as f64;
        let wanted: Vec<f64> = (0..INSTANTS).map(|k| target.at(at(k) - lag_s)).collect();
        let [correlation, times] = compared(&wanted, &is)?;
        Some(Follow { lag_s, correlation, times })
    });
    let tried: Vec<Follow> = tried.collect();
    let order = |a: &&Follow, b: &&Follow| a.correlation.total_cmp(&b.correlation);
    let (along, against) = (tried.iter().max_by(order)?, tried.iter().min_by(order)?);
    let is_turned = along.correlation + against.correlation < -CLEARLY;
    Some(if is_turned && against.is_of_one_motion() { *against } else { *along })
}

struct Readings {
    times_s: Vec<f64>,
    values: Vec<f64>,
}

impl Readings {
    fn of((table, column): (&Table, &Column)) -> Option<Self> {
        let origin_s = table.clock.as_ref()?.origin_s;
        let both = table.times_s.iter().zip(&column.values).filter(|(t, x)| t.is_finite() && x.is_finite());
        // Origins of calendar clocks are far from zero; both columns lose the same digits.
        let (times_s, values): (Vec<f64>, Vec<f64>) = both.map(|(t, x)| (t + origin_s, *x)).unzip();
        let moves = values.windows(2).any(|pair| pair[0].to_bits() != pair[1].to_bits());
        moves.then_some(Self { times_s, values })
    }

    fn at(&self, t: f64) -> f64 {
        let after = self.times_s.partition_point(|time| *time <= t);
        let Some(before) = after.checked_sub(1) else { return self.values[0] };
        let Some(next) = self.times_s.get(after) else { return self.values[before] };
        let share = (t - self.times_s[before]) / (next - self.times_s[before]);
        self.values[before] + share * (self.values[after] - self.values[before])
    }
}

/// Correlation of two series, and the size of the second over that of the first.
fn compared(a: &[f64], b: &[f64]) -> Option<[f64; 2]> {
    let n = a.len() as f64;
    let (mean_a, mean_b) = (a.iter().sum::<f64>() / n, b.iter().sum::<f64>() / n);
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (x, y) in a.iter().zip(b) {
        aa += (x - mean_a).powi(2);
        bb += (y - mean_b).powi(2);
        ab += (x - mean_a) * (y - mean_b);
    }
    (aa > 0.0 && bb > 0.0).then(|| [ab / (aa * bb).sqrt(), (bb / aa).sqrt()])
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_logs::{Clock, ClockUnit};

    fn series(shift_s: f64) -> (Table, Column) {
        let times_s: Vec<f64> = (0..2000).map(|k| f64::from(k) * 0.005).collect();
        let wave = |t: f64| (3.0 * t).sin() + 0.4 * (11.0 * t).sin();
        let values = times_s.iter().map(|t| wave(t - shift_s)).collect();
        let column = Column { name: "q".into(), values, ..Column::default() };
        let clock =
            Clock { column: "t_s".into(), unit: ClockUnit::Seconds, origin_s: 0.0, why: String::new() };
        let table = Table {
            name: String::new(),
            file: "a.csv".into(),
            clock: Some(clock),
            times_s,
            rows_before: 1,
            columns: Vec::new(),
        };
        (table, column)
    }

    #[test]
    fn truth_the_lag_of_a_shifted_wave_is_found() {
        let (target, position) = (series(0.0), series(0.06));
        let found = follow((&target.0, &target.1), (&position.0, &position.1)).expect("a lag");
        // Lags are tried in steps of 2.5 ms.
        assert!((found.lag_s - 0.06).abs() <= 0.0025 && found.correlation > 0.999, "{found:?}");
        assert!((found.times - 1.0).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn truth_a_position_of_the_other_sign_follows_turned() {
        let (target, mut position) = (series(0.0), series(0.06));
        position.1.values.iter_mut().for_each(|x| *x *= -50.0);
        let found = follow((&target.0, &target.1), (&position.0, &position.1)).expect("a lag");
        assert!((found.lag_s - 0.06).abs() <= 0.0025 && found.correlation < -0.999, "{found:?}");
        assert!((found.times / 50.0 - 1.0).abs() < 0.01, "{found:?}");
    }

    /// 0.1 has roundings in its sums.
    #[test]
    fn truth_what_stands_still_follows_nothing() {
        let (target, mut still) = (series(0.0), series(0.06));
        still.1.values.iter_mut().for_each(|x| *x = 0.1);
        assert_eq!(follow((&target.0, &target.1), (&still.0, &still.1)), None);
        assert_eq!(follow((&still.0, &still.1), (&still.0, &still.1)), None);
    }
}
