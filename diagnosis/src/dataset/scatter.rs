//! The noise of a channel without a stated one, from the scatter of its own readings.
//!
//! Differences of a high order remove a motion and leave white noise. Its variance is multiplied by a
//! binomial coefficient (Gasser, Sroka and Jennen-Steinmetz 1986; Hall, Kay and Titterington 1990). Noise
//! that a filter has removed from the upper band is not visible, so the result is a lower bound.

/// Order of the differences: at an eighth of the sampling rate a motion is reduced to a thousandth, so that
/// only noise and impacts remain.
const ORDER: usize = 8;
/// Binomial coefficient of twice the order over the order: the factor of a difference on the variance of
/// white noise.
const GAIN: f64 = 12870.0;
/// Standard deviation of a normal distribution over its median absolute value. A median ignores the few rows
/// of an impact.
const SIGMA_OVER_MEDIAN: f64 = 1.4826;

/// Standard deviation of white noise in a series.
pub(crate) fn of_series(series: &[f64]) -> f64 {
    let mut differences = series.to_vec();
    for _ in 0..ORDER {
        differences = differences.windows(2).map(|pair| pair[1] - pair[0]).collect();
    }
    let mut sizes: Vec<f64> = differences.into_iter().map(f64::abs).collect();
    sizes.sort_by(f64::total_cmp);
    sizes.get(sizes.len() / 2).map_or(0.0, |middle| SIGMA_OVER_MEDIAN * middle / GAIN.sqrt())
}

/// Standard deviation of white noise in a channel, from its series in all experiments. It is the median, so
/// that neither a filtered experiment nor one with impacts decides.
pub(super) fn of_channel<'a>(series: impl Iterator<Item = &'a Vec<f64>>) -> f64 {
    let mut found: Vec<f64> = series.map(|series| of_series(series)).collect();
    found.sort_by(f64::total_cmp);
    found.get(found.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIGMA: f64 = 0.02;

    /// A motion of unit size up to an eighth of the sampling rate, with uniform noise and an impact.
    fn noisy(sigma: f64) -> Vec<f64> {
        let mut state: u64 = 5;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt()
        };
        let at = |k: usize| {
            (0.01 * k as f64).sin()
                + 0.1 * (0.7 * k as f64).sin()
                + if (900..905).contains(&k) { 30.0 } else { 0.0 }
        };
        (0..4000).map(|k| at(k) + sigma * draw()).collect()
    }

    #[test]
    fn truth_scatter_is_the_noise_and_not_the_motion() {
        // Neighbouring differences share rows, so 4000 of them give the median to about four per cent.
        assert!((of_series(&noisy(SIGMA)) / SIGMA - 1.0).abs() < 0.1);
        // A tenth at 0.7 radians a row, times (2 sin 0.35)^8 / sqrt(12870): the apparent noise of a motion in
        // the upper band.
        assert!(of_series(&noisy(0.0)) < 1e-4);
        let [a, b, c] = [SIGMA, 0.0, 2.0 * SIGMA].map(noisy);
        assert!((of_channel([a, b, c].iter()) / SIGMA - 1.0).abs() < 0.1);
        assert!(of_series(&[1.0; 4]).abs() < f64::EPSILON);
    }
}
