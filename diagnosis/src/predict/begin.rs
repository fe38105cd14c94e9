//! What a record tells of its own motion: how fast it is, and how it begins.

use nalgebra::{Matrix3, Vector3};

/// Share of the excursion by which a motion must have moved for its speed to be read off, so that neither
/// noise nor steps of the encoder count.
const MOVED: f64 = 0.5;
/// Rows that a beginning needs, and standard errors from which on it is one in motion.
const FEWEST_ROWS: usize = 6;
const STANDARD_ERRORS: f64 = 4.0;

/// Frequency of a motion, rad/s, that of a sine which moves as far in a short time, and its excursion (root
/// mean square); `None` where nothing moves.
pub(crate) fn pace(series: &[f64], spacing_s: f64) -> Option<[f64; 2]> {
    let n = series.len();
    let mean = series.iter().sum::<f64>() / n.max(1) as f64;
    let mean_square = |sum: f64, n: usize| (sum / n.max(1) as f64).sqrt();
    let excursion = mean_square(series.iter().map(|x| (x - mean).powi(2)).sum(), n);
    let moved = |lag: usize| {
        let sum = (0..n - lag).map(|k| (series[k + lag] - series[k]).powi(2)).sum();
        mean_square(sum, n - lag)
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

/// Position and speed at the first row by a parabola through the rows of the first `stretch_s`; `None` where
/// no speed stands out of the scatter and the steps of the readings, `step` each.
pub(super) fn beginning(series: &[f64], spacing_s: f64, stretch_s: f64, step: f64) -> Option<[f64; 2]> {
    let rows = ((stretch_s / spacing_s) as usize).max(FEWEST_ROWS).min(series.len());
    if rows < FEWEST_ROWS {
        return None;
    }
    let powers = |k: usize| {
        let t = k as f64 / rows as f64;
        Vector3::new(1.0, t, t * t)
    };
    let (mut a, mut b) = (Matrix3::zeros(), Vector3::zeros());
    for (k, x) in series[..rows].iter().enumerate() {
        a += powers(k) * powers(k).transpose();
        b += powers(k) * (x - series[0]);
    }
    let inverse = a.try_inverse()?;
    let fit = inverse * b;
    let left: f64 =
        series[..rows].iter().enumerate().map(|(k, x)| (x - series[0] - powers(k).dot(&fit)).powi(2)).sum();
    let variance = left / (rows - 3) as f64 + step * step / 12.0;
    let stands_out = fit[1].abs() > STANDARD_ERRORS * (inverse[(1, 1)] * variance).sqrt();
    stands_out.then(|| [series[0] + fit[0], fit[1] / (rows as f64 * spacing_s)])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPACING_S: f64 = 2e-3;
    const OMEGA: f64 = 3.0;
    const STEP: f64 = 1e-3;

    fn counted(position: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..5000).map(|k| (position(f64::from(k) * SPACING_S) / STEP).round() * STEP).collect()
    }

    #[test]
    fn truth_a_sine_has_its_frequency_and_begins_with_its_speed() {
        let series = counted(|t| 0.4 * (OMEGA * t + 0.3).sin());
        // The excursion of four and three quarter periods differs from that of whole ones by some percent.
        let [omega, excursion] = pace(&series, SPACING_S).unwrap();
        assert!((omega / OMEGA - 1.0).abs() < 0.05);
        assert!((excursion / (0.4 / 2.0_f64.sqrt()) - 1.0).abs() < 0.05);
        let [position, speed] = beginning(&series, SPACING_S, 1.0 / (6.0 * OMEGA), STEP).unwrap();
        // A parabola over a twentieth of a period leaves thousandths; a step is a 400th of the amplitude.
        assert!((position - 0.4 * 0.3_f64.sin()).abs() < STEP);
        assert!((speed / (0.4 * OMEGA * 0.3_f64.cos()) - 1.0).abs() < 0.05);
    }

    #[test]
    fn truth_rest_is_no_motion() {
        assert_eq!(pace(&[0.2; 100], SPACING_S), None);
        assert_eq!(beginning(&counted(|_| 0.2), SPACING_S, 0.1, STEP), None);
        assert_eq!(beginning(&counted(|t| 0.2 + 2.0 * t * t), SPACING_S, 0.1, STEP), None);
    }
}
