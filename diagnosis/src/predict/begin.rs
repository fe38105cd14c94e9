//! Frequency and initial state of a motion, from its readings alone.

use nalgebra::{Matrix3, Vector3};

/// Share of the excursion over which a frequency is measured. Noise and encoder steps then do not matter.
const MOVED: f64 = 0.5;
/// Largest number of pairs of rows that measure the displacement over a lag.
const MOST_PAIRS: usize = 500;
/// Smallest number of rows at the start, and standard errors by which the initial speed must differ.
const FEWEST_ROWS: usize = 6;
const STANDARD_ERRORS: f64 = 4.0;
/// An estimate of a value agrees with others if it lies in all their intervals of this many standard errors.
const AGREEING: f64 = 2.0;
/// Smallest share of the initial excursion that is due to the initial speed. A smaller share is an error of
/// the parabola.
const SPEED_SHARE: f64 = 0.05;
/// Relative resolution of a record's numbers.
const DIGITS: f64 = 1e-9;
/// A displacement of more than this many steps is clear. At half the time, a motion with an initial speed has
/// covered about half of it, and a motion from rest a quarter. The limit is between the two.
const CLEAR_STEPS: f64 = 8.0;
const HALF_WAY: f64 = 0.35;
/// Largest ratio of scatter to the step of the readings for a motion that is a parabola.
const SCATTER: f64 = 2.0;

/// Frequency of a motion, rad/s, and its excursion (root mean square); `None` if nothing moves. The frequency
/// is that of a sine with the same displacement in a short time.
pub(crate) fn pace(series: &[f64], spacing_s: f64) -> Option<[f64; 2]> {
    let n = series.len();
    let mean = series.iter().sum::<f64>() / n.max(1) as f64;
    let mean_square = |sum: f64, n: usize| (sum / n.max(1) as f64).sqrt();
    let excursion = mean_square(series.iter().map(|x| (x - mean).powi(2)).sum(), n);
    let stride = (n / MOST_PAIRS).max(1);
    let moved = |lag: usize| {
        let pairs = (0..n - lag).step_by(stride);
        mean_square(pairs.clone().map(|k| (series[k + lag] - series[k]).powi(2)).sum(), pairs.len())
    };
    std::iter::successors(Some(1_usize), |lag| Some((lag + lag / 4).max(lag + 1)))
        .take_while(|lag| *lag < n / 2)
        .map(|lag| (lag, moved(lag)))
        .find(|(_, moved)| *moved >= MOVED * excursion && excursion > 0.0)
        .map(|(lag, moved)| {
            let turn = 2.0 * (0.5 * moved / excursion).min(1.0).asin();
            [turn / (lag as f64 * spacing_s), excursion]
        })
}

/// Position and speed at the first row, from a parabola through the first rows. These are the rows of
/// `stretch_s`, or fewer if the motion is a parabola over a shorter time only. `None` if the speed does not
/// differ from the believed one by more than the scatter and the steps of the readings (`step`).
pub(super) fn beginning(
    series: &[f64],
    spacing_s: f64,
    stretch_s: f64,
    step: f64,
    believed: f64,
) -> Option<[f64; 2]> {
    let range = series.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(*x), b.max(*x)]);
    let step = step.max(DIGITS * (range[1] - range[0]));
    let most = most_rows(spacing_s, stretch_s).min(series.len());
    let fits: Vec<Parabola> = std::iter::successors(Some(most), |rows| Some(rows / 2))
        .take_while(|rows| *rows >= FEWEST_ROWS)
        .map_while(|rows| Parabola::through(&series[..rows]))
        .collect();
    let last = fits.len().checked_sub(2)?;
    let chosen = fits.iter().position(|fit| fit.left < SCATTER * step).unwrap_or(last).min(last);
    let [begun, shorter] = [&fits[chosen], &fits[chosen + 1]];
    // The difference between two lengths shows the error of the parabola.
    let missed = begun.speed - shorter.speed;
    let error = missed.hypot(begun.error * begun.left.hypot(step / 12.0_f64.sqrt()));
    let other = (begun.speed - believed * spacing_s).abs();
    let excursion = series[..begun.rows].iter().map(|x| (x - series[0]).abs()).fold(0.0, f64::max);
    let stands_out = other > STANDARD_ERRORS * error && other * begun.rows as f64 > SPEED_SHARE * excursion;
    stands_out.then_some([begun.value, begun.speed / spacing_s])
}

/// Largest number of rows at the start that are fitted.
fn most_rows(spacing_s: f64, stretch_s: f64) -> usize {
    ((stretch_s / spacing_s) as usize).max(2 * FEWEST_ROWS)
}

/// The value at the first row of readings with noise `sigma`. Parabolas through ever more rows of `stretch_s`
/// estimate it, as long as they agree with those through fewer (Lepskii, Theory Probab. Appl. 35, 1991).
pub(super) fn first_value(series: &[f64], spacing_s: f64, stretch_s: f64, sigma: f64) -> f64 {
    let most = most_rows(spacing_s, stretch_s).min(series.len());
    let mut found = series[0];
    let [mut low, mut high] = [-1.0, 1.0].map(|side| series[0] + side * AGREEING * sigma);
    let lengths = std::iter::successors(Some(FEWEST_ROWS), |rows| Some(2 * rows));
    let fits = lengths.take_while(|rows| *rows <= most).map_while(|rows| Parabola::through(&series[..rows]));
    for fit in fits {
        if !(low..=high).contains(&fit.value) {
            break;
        }
        found = fit.value;
        low = low.max(found - AGREEING * fit.value_error * sigma);
        high = high.min(found + AGREEING * fit.value_error * sigma);
    }
    found
}

/// Whether a motion has an initial speed. It has then covered about half of its displacement at half the
/// time; from rest, a quarter at most.
pub(super) fn is_in_motion(series: &[f64], step: f64) -> bool {
    let step = step.max(DIGITS * series.iter().fold(0.0_f64, |most, x| most.max((x - series[0]).abs())));
    let way = |row: usize| (series[row] - series[0]).abs();
    let middle = (1..series.len().div_ceil(2)).find(|half| way(2 * half) > CLEAR_STEPS * step);
    middle.is_some_and(|half| way(half) > HALF_WAY * way(2 * half))
}

/// A parabola through rows: value and speed (per row) at the first row, and root mean square of the
/// residuals. The standard errors of speed and value are those for residuals of one.
pub(super) struct Parabola {
    rows: usize,
    pub(super) value: f64,
    pub(super) speed: f64,
    left: f64,
    error: f64,
    value_error: f64,
}

impl Parabola {
    /// Root mean square of the residuals.
    pub(super) fn left(&self) -> f64 {
        self.left
    }

    pub(super) fn is_finite(&self) -> bool {
        self.value.is_finite() && self.speed.is_finite()
    }

    pub(super) fn through(series: &[f64]) -> Option<Self> {
        let rows = series.len() as f64;
        let powers = |k: usize| {
            let t = k as f64 / rows;
            Vector3::new(1.0, t, t * t)
        };
        let (mut a, mut b) = (Matrix3::zeros(), Vector3::zeros());
        for (k, x) in series.iter().enumerate() {
            a += powers(k) * powers(k).transpose();
            b += powers(k) * (x - series[0]);
        }
        let inverse = a.try_inverse()?;
        let fit = inverse * b;
        let square = |(k, x): (usize, &f64)| (x - series[0] - powers(k).dot(&fit)).powi(2);
        let left: f64 = series.iter().enumerate().map(square).sum();
        Some(Self {
            rows: series.len(),
            value: series[0] + fit[0],
            speed: fit[1] / rows,
            left: (left / (rows - 3.0)).sqrt(),
            error: inverse[(1, 1)].sqrt() / rows,
            value_error: inverse[(0, 0)].sqrt(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    const SPACING_S: f64 = 2e-3;
    const OMEGA: f64 = 3.0;
    const STEP: f64 = 1e-3;

    fn counted(position: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..5000).map(|k| (position(f64::from(k) * SPACING_S) / STEP).round() * STEP).collect()
    }

    #[test]
    fn truth_a_sine_has_its_frequency_and_begins_with_its_speed() {
        let series = counted(|t| 0.4 * (OMEGA * t + 0.3).sin());
        // The excursion of four and three quarter periods differs by some percent from that of whole periods.
        let [omega, excursion] = pace(&series, SPACING_S).unwrap();
        assert!((omega / OMEGA - 1.0).abs() < 0.05);
        assert!((excursion / (0.4 / 2.0_f64.sqrt()) - 1.0).abs() < 0.05);
        let [position, speed] = beginning(&series, SPACING_S, 1.0 / (6.0 * OMEGA), STEP, 0.0).unwrap();
        // Over a twentieth of a period a parabola is off by thousandths of the amplitude. A step is a 400th
        // of it.
        assert!((position - 0.4 * 0.3_f64.sin()).abs() < STEP);
        assert!((speed / (0.4 * OMEGA * 0.3_f64.cos()) - 1.0).abs() < 0.05);
    }

    #[test]
    fn truth_a_motion_that_soon_turns_begins_with_its_own_speed() {
        let of = |series: &dyn Fn(f64) -> f64, believed| {
            let series: Vec<f64> = (0..200).map(|k| series(f64::from(k) * SPACING_S)).collect();
            beginning(&series, SPACING_S, 0.1, 1e-7, believed)
        };
        let turns = |t: f64| 1e-3 * (1.0 - (60.0 * t).cos());
        assert_eq!(of(&turns, 0.0), None, "from rest");
        let moves = |t: f64| 0.4 * t + turns(t);
        // Twelve rows turn the phase by 1.4 rad. The error of a parabola is less than 0.06 m/s, 15 % of the
        // speed.
        assert!(of(&moves, 0.0).is_some_and(|[_, speed]| (speed / 0.4 - 1.0).abs() < 0.15));
        assert_eq!(of(&moves, 0.4), None, "as believed");
    }

    #[test]
    fn truth_a_motion_from_rest_is_not_one_that_goes_on() {
        let of = |series: &dyn Fn(f64) -> f64| is_in_motion(&counted(series), STEP);
        assert!(of(&|t| 0.3 * t) && of(&|t| 0.3 * t - 4.0 * t * t) && of(&|t| 0.3 * t + 3.0 * t * t));
        assert!(!of(&|t| 2.0 * t * t) && !of(&|t| 0.1 * (1.0 - (9.0 * t).cos())) && !of(&|_| 0.2));
    }

    /// From rest, the mean error of the first value falls with the number of rows. Where the motion soon
    /// turns, a long parabola misses it by two deviations, and a short one counts.
    #[test]
    fn truth_the_first_value_is_averaged_as_far_as_the_motion_allows() {
        let mut chance = Chance::seeded(3);
        let sigma = 1e-6;
        let mut error = |motion: &dyn Fn(f64) -> f64| {
            let squares = (0..200).map(|_| {
                let series: Vec<f64> =
                    (0..100).map(|k| motion(f64::from(k) * SPACING_S) + sigma * chance.deviate()).collect();
                (first_value(&series, SPACING_S, 0.2, sigma) - motion(0.0)).powi(2)
            });
            (squares.sum::<f64>() / 200.0).sqrt() / sigma
        };
        let still = error(&|_| 0.3);
        assert!(still < 0.6, "{still}");
        let turning = error(&|t| 0.3 + 1e-4 * (1.0 - (60.0 * t).cos()));
        assert!(turning < 1.2, "{turning}");
        assert_eq!(first_value(&[0.5, 0.6, 0.7], SPACING_S, 0.2, 0.0).to_bits(), 0.5_f64.to_bits());
    }

    #[test]
    fn truth_rest_is_no_motion() {
        assert_eq!(pace(&[0.2; 100], SPACING_S), None);
        assert_eq!(beginning(&counted(|_| 0.2), SPACING_S, 0.1, STEP, 0.0), None);
        assert_eq!(beginning(&counted(|t| 0.2 + 2.0 * t * t), SPACING_S, 0.1, STEP, 0.0), None);
    }
}
