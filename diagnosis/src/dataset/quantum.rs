//! Quantisation steps of readings.

/// Quantisation steps of a channel over all experiments, if coarser than believed; zero otherwise.
#[derive(Clone, Copy)]
pub(super) struct Grain {
    /// The coarsest step of any experiment.
    pub(super) coarsest: f64,
    /// The coarsest step if most experiments have a step, otherwise zero.
    pub(super) usual: f64,
}

/// Steps of a channel; `is_coarse` says whether a step is coarser than believed.
pub(super) fn grain(is_coarse: impl Fn(f64) -> bool, columns: impl Iterator<Item = Vec<f64>>) -> Grain {
    let steps: Vec<Option<f64>> = columns.map(|column| quantum(&column)).collect();
    let stepped = steps.iter().flatten().count();
    let coarse = steps.iter().flatten().copied().filter(|&step| is_coarse(step));
    let coarsest = coarse.fold(0.0, f64::max);
    Grain { coarsest, usual: if 2 * stepped > steps.len() { coarsest } else { 0.0 } }
}

/// Step of which all values are multiples, if there are few enough distinct values. The smallest distance
/// between values is the first estimate, which all values refine.
pub(crate) fn quantum(column: &[f64]) -> Option<f64> {
    let mut values = column.to_vec();
    values.sort_by(f64::total_cmp);
    let range = values.last()? - values.first()?;
    let rounding = 1e-6 * range.max(f64::MIN_POSITIVE);
    values.dedup_by(|b, a| (*b - *a).abs() <= rounding);
    // If more than a third of the rows have distinct values, no step is visible.
    if values.len() < 4 || values.len() > column.len() / 3 {
        return None;
    }
    let mut gaps: Vec<f64> = values.windows(2).map(|w| w[1] - w[0]).collect();
    gaps.sort_by(f64::total_cmp);
    let mut step = gaps[gaps.len() / 4];
    if step <= 0.0 {
        return None;
    }
    // Least squares over increasing distances: an inaccurate first step would give wrong counts at large
    // distances.
    let first = values[0];
    for reach in [4.0, 16.0, 64.0, 256.0, 1024.0, 4096.0] {
        let (mut xx, mut xy) = (0.0, 0.0);
        for value in &values {
            let n = ((value - first) / step).round();
            if n.abs() <= reach {
                xx += n * n;
                xy += n * (value - first);
            }
        }
        if xx > 0.0 {
            step = xy / xx;
        }
    }
    let off = |x: f64| {
        let n = x / step;
        (n - n.round()).abs()
    };
    let worst = values.iter().map(|x| off(x - first)).fold(0.0, f64::max);
    (worst < 0.1).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_quantised_sine_shows_its_step() {
        let step = 0.037;
        let column: Vec<f64> =
            (0..4000).map(|k| ((f64::from(k) * 0.01).sin() / step).round() * step).collect();
        let found = quantum(&column).unwrap();
        // Least squares over levels that are multiples up to rounding errors.
        assert!((found / step - 1.0).abs() < 1e-9);
        let smooth: Vec<f64> = (0..4000).map(|k| (f64::from(k) * 0.01).sin()).collect();
        assert_eq!(quantum(&smooth), None);
    }
}
