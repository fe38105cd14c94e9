//! Comparison of two series of one motion: their ratio, and their shift in rows.

use std::f64::consts::PI;

/// Relation of one series to another of the same motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Comparison {
    /// Delay of the second series in rows.
    pub(super) late_rows: f64,
    /// Standard deviation of the delay; infinite if the correlation has no maximum within the range of
    /// shifts.
    pub(super) late_sd: f64,
    /// Mean frequency of the common part, rad per row.
    pub(super) omega: f64,
    /// Ratio of the second series to the first; negative for opposite signs.
    pub(super) factor: f64,
    /// Correlation of the two series at this delay.
    pub(super) correlation: f64,
}

impl Comparison {
    /// The relation of the first series to the second.
    pub(super) fn turned(self) -> Self {
        Self { late_rows: -self.late_rows, factor: 1.0 / self.factor, ..self }
    }

    /// Whether the shift is surely larger than `rows`.
    pub(super) fn is_off_by(self, rows: f64) -> bool {
        self.late_rows.abs() > rows + SURE * self.late_sd
    }
}

/// Standard deviations by which a shift must be significant.
pub(super) const SURE: f64 = 6.0;

/// The acceleration of a position, smoothed by a triangle of `2 span` rows.
pub(super) fn second_difference(series: &[f64], span: usize, spacing_s: f64) -> Vec<f64> {
    let scale = (span as f64 * spacing_s).powi(2);
    (span..series.len() - span)
        .map(|k| (series[k + span] - 2.0 * series[k] + series[k - span]) / scale)
        .collect()
}

/// The acceleration of a velocity, smoothed by the same triangle as [`second_difference`]: the difference of
/// its means over the `span` rows after and before.
pub(super) fn difference(series: &[f64], span: usize, spacing_s: f64) -> Vec<f64> {
    // Means by the trapezoidal rule.
    let mean = |rows: &[f64]| {
        let sum: f64 = rows.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).sum();
        sum / span as f64
    };
    (span..series.len() - span)
        .map(|k| (mean(&series[k..=k + span]) - mean(&series[k - span..=k])) / (span as f64 * spacing_s))
        .collect()
}

/// A series, smoothed by the same triangle as [`second_difference`].
pub(super) fn smoothed(series: &[f64], span: usize) -> Vec<f64> {
    let weight = |j: usize| 1.0 - (j as f64 - span as f64).abs() / span as f64;
    let at = |k: usize| (0..=2 * span).map(|j| weight(j) * series[k + j - span]).sum::<f64>() / span as f64;
    (span..series.len() - span).map(at).collect()
}

/// Compares two series, with the second shifted by up to `most` rows either way. `None` if their correlation
/// is below `same`: they do not measure the same motion.
pub(super) fn compare(first: &[f64], second: &[f64], most: usize, same: f64) -> Option<Comparison> {
    if first.len() <= 2 * most {
        return None;
    }
    let inner = &first[most..first.len() - most];
    let energy = |series: &[f64]| series.iter().map(|x| x * x).sum::<f64>();
    let xx = energy(inner);
    let shifted = |i: usize| &second[i..i + inner.len()];
    let correlation = |i: usize| {
        let xy: f64 = inner.iter().zip(shifted(i)).map(|(a, b)| a * b).sum();
        xy / (xx * energy(shifted(i))).sqrt().max(f64::MIN_POSITIVE)
    };
    let heights: Vec<f64> = (0..=2 * most).map(correlation).collect();
    let best = (0..heights.len()).max_by(|&i, &j| heights[i].total_cmp(&heights[j]))?;
    let factor = |i: usize| (energy(shifted(i)) / xx.max(f64::MIN_POSITIVE)).sqrt();
    if heights[best] < same {
        // The series have opposite signs.
        let turned = -heights[most];
        return (turned >= same).then(|| Comparison {
            late_rows: 0.0,
            late_sd: f64::INFINITY,
            omega: 0.0,
            factor: -factor(most),
            correlation: turned,
        });
    }
    // The vertex of a parabola through the best shift and its neighbours. At the end of the range there is no
    // vertex.
    let (mut part, mut late_sd, mut omega) = (0.0, f64::INFINITY, 0.0);
    if best > 0 && best < 2 * most {
        let [before, top, after] = [heights[best - 1], heights[best], heights[best + 1]];
        let bend = (2.0 * top - before - after).max(f64::MIN_POSITIVE);
        part = 0.5 * (after - before) / bend;
        // The uncorrelated part shifts the vertex by its ratio to the slope of the common part. Each half
        // wave is an independent sample.
        omega = (bend / top).sqrt();
        let half_waves = inner.len() as f64 * omega / PI;
        late_sd = ((top.powi(-2) - 1.0).max(0.0) / half_waves).sqrt() / omega;
    }
    Some(Comparison {
        late_rows: best as f64 + part - most as f64,
        late_sd,
        omega,
        factor: factor(best),
        correlation: heights[best],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bound on the error of the vertex for a smooth maximum, rows.
    const PART_OF_A_ROW: f64 = 0.02;

    /// The speed is a parabola, for which the error of the trapezoidal rule is constant. The difference
    /// removes it.
    #[test]
    fn truth_position_and_velocity_of_a_cubic_have_one_acceleration() {
        let times: Vec<f64> = (0..60).map(|k| 0.01 * f64::from(k)).collect();
        let place: Vec<f64> = times.iter().map(|t| 2.0 * t.powi(3) - t.powi(2)).collect();
        let speed: Vec<f64> = times.iter().map(|t| 6.0 * t.powi(2) - 2.0 * t).collect();
        let [a, b] = [second_difference(&place, 5, 0.01), difference(&speed, 5, 0.01)];
        assert_eq!(a.len(), b.len());
        // Rounding errors of positions up to 1, divided by the square of 50 ms.
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn truth_a_shift_and_a_factor_are_read_off() {
        let wave = |k: f64| (0.05 * k).sin() + 0.6 * (0.131 * k).cos();
        let first: Vec<f64> = (0..800).map(|k| wave(f64::from(k))).collect();
        let second: Vec<f64> = (0..800).map(|k| 9.81 * wave(f64::from(k) - 7.4)).collect();
        let found = compare(&first, &second, 20, 0.85).unwrap();
        assert!((found.late_rows - 7.4).abs() < PART_OF_A_ROW, "{found:?}");
        // The energies differ by the parts that the shift cuts off at the ends.
        assert!((found.factor / 9.81 - 1.0).abs() < 0.01, "{found:?}");
        assert!(found.is_off_by(6.0) && !found.is_off_by(7.8), "{found:?}");
        let against: Vec<f64> = first.iter().map(|x| -x).collect();
        assert!(compare(&first, &against, 3, 0.85).unwrap().factor < 0.0);
    }

    #[test]
    fn truth_a_slow_motion_under_noise_says_little_of_time() {
        let mut seed: u64 = 7;
        let mut noise = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let wave = |k: i32| (0.006 * f64::from(k)).sin();
        let first: Vec<f64> = (0..4000).map(|k| wave(k) + noise()).collect();
        let second: Vec<f64> = (0..4000).map(|k| wave(k) + noise()).collect();
        let [first, second] = [first, second].map(|series| smoothed(&series, 8));
        // Neither an uncertain shift nor one at the end of the range is reported.
        let found = compare(&first, &second, 100, 0.85).unwrap();
        assert!(!found.is_off_by(1.0), "{found:?}");
        let late: Vec<f64> = (0..4000).map(|k| wave(k - 200)).collect();
        assert!(!compare(&first, &smoothed(&late, 8), 100, 0.7).unwrap().is_off_by(1.0));
    }
}
