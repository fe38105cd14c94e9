//! Two series of one motion: by what factor, and how many rows apart.

/// How one series stands to another of the same motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Comparison {
    /// By how many rows the second is behind the first.
    pub(super) late_rows: f64,
    /// The second over the first, negative where they go against each other.
    pub(super) factor: f64,
    /// Correlation of the two without that shift.
    pub(super) correlation: f64,
}

impl Comparison {
    /// The first against the second.
    pub(super) fn turned(self) -> Self {
        Self { late_rows: -self.late_rows, factor: 1.0 / self.factor, ..self }
    }
}

/// The acceleration of a position, under a triangle of `2 span` rows.
pub(super) fn second_difference(series: &[f64], span: usize, spacing_s: f64) -> Vec<f64> {
    let scale = (span as f64 * spacing_s).powi(2);
    (span..series.len() - span).map(|k| (series[k + span] - 2.0 * series[k] + series[k - span]) / scale).collect()
}

/// A series under the triangle that a second difference puts an acceleration under.
pub(super) fn smoothed(series: &[f64], span: usize) -> Vec<f64> {
    let weight = |j: usize| 1.0 - (j as f64 - span as f64).abs() / span as f64;
    let at = |k: usize| (0..=2 * span).map(|j| weight(j) * series[k + j - span]).sum::<f64>() / span as f64;
    (span..series.len() - span).map(at).collect()
}

/// Compares two series, the second shifted by up to `most` rows either way; none where they correlate by less than `same`: they are not of one motion.
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
        // The other way round: a sign.
        let turned = -heights[most];
        return (turned >= same).then(|| Comparison { late_rows: 0.0, factor: -factor(most), correlation: turned });
    }
    // The top of a parabola through the best shift and its neighbours.
    let part = if best > 0 && best < 2 * most {
        let [before, top, after] = [heights[best - 1], heights[best], heights[best + 1]];
        0.5 * (before - after) / (before - 2.0 * top + after).min(-f64::MIN_POSITIVE)
    } else {
        0.0
    };
    Some(Comparison { late_rows: best as f64 + part - most as f64, factor: factor(best), correlation: heights[best] })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A parabola through three points of a smooth peak is off by far less than this part of a row.
    const PART_OF_A_ROW: f64 = 0.02;

    #[test]
    fn truth_a_shift_and_a_factor_are_read_off() {
        let wave = |k: f64| (0.05 * k).sin() + 0.6 * (0.131 * k).cos();
        let first: Vec<f64> = (0..800).map(|k| wave(f64::from(k))).collect();
        let second: Vec<f64> = (0..800).map(|k| 9.81 * wave(f64::from(k) - 7.4)).collect();
        let found = compare(&first, &second, 20, 0.85).unwrap();
        assert!((found.late_rows - 7.4).abs() < PART_OF_A_ROW, "{found:?}");
        // Its energy over the shifted stretch differs by what is cut off at the ends.
        assert!((found.factor / 9.81 - 1.0).abs() < 0.01, "{found:?}");
        let against: Vec<f64> = first.iter().map(|x| -x).collect();
        assert!(compare(&first, &against, 3, 0.85).unwrap().factor < 0.0);
    }
}
