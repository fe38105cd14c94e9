//! Fewer points with the same appearance.

/// Largest number of values in all time charts of a page: 16 MB in a file. Longer runs are thinned out.
pub(crate) const MOST_VALUES: usize = 3_000_000;

/// Rows to draw of columns with a common axis. They are the rows with the minimum or maximum of some column
/// in each stretch, so that no peak is lost. Returns about `most` rows, or all if there are fewer.
pub(crate) fn by_extremes(columns: &[&[f64]], rows: usize, most: usize) -> Vec<usize> {
    if rows <= most || columns.is_empty() {
        return (0..rows).collect();
    }
    let stretches = (most / (2 * columns.len())).max(1);
    let mut kept = vec![0, rows - 1];
    for stretch in 0..stretches {
        let (from, to) = (stretch * rows / stretches, (stretch + 1) * rows / stretches);
        for column in columns {
            let smallest = (from..to).min_by(|&i, &j| column[i].total_cmp(&column[j]));
            let largest = (from..to).max_by(|&i, &j| column[i].total_cmp(&column[j]));
            kept.extend(smallest.into_iter().chain(largest));
        }
    }
    kept.sort_unstable();
    kept.dedup();
    kept
}

/// Points of a path with a minimum distance between successive ones, at most `most` points.
pub(crate) fn by_steps(x: &[f64], y: &[f64], most: usize) -> Vec<usize> {
    let extent = |values: &[f64]| {
        let (low, high) = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| (low.min(v), high.max(v)));
        if high > low { high - low } else { 1.0 }
    };
    let (width, height) = (extent(x), extent(y));
    // A thousandth of the plot's size is about a pixel.
    let mut least = 1e-3;
    loop {
        let mut kept: Vec<usize> = Vec::new();
        for i in 0..x.len() {
            let far =
                kept.last().is_none_or(|&j| ((x[i] - x[j]) / width).hypot((y[i] - y[j]) / height) >= least);
            if far {
                kept.push(i);
            }
        }
        if kept.len() <= most {
            return kept;
        }
        least *= 1.5;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_extremes_survive() {
        let mut spike = vec![0.0; 100_000];
        spike[77_777] = 9.0;
        spike[12_345] = -4.0;
        let slope: Vec<f64> = (0..100_000).map(f64::from).collect();
        let kept = by_extremes(&[&spike, &slope], spike.len(), 2000);
        assert!(kept.len() <= 2002 && kept.contains(&77_777) && kept.contains(&12_345));
        assert!(kept.is_sorted() && kept[0] == 0 && kept.last() == Some(&99_999));
    }

    #[test]
    fn truth_paths_keep_their_shape_in_few_points() {
        let angle = |i: u32| f64::from(i) * 1e-3;
        let (x, y): (Vec<f64>, Vec<f64>) = (0..100_000).map(|i| (angle(i).cos(), angle(i).sin())).unzip();
        let kept = by_steps(&x, &y, 3000);
        assert!(kept.len() <= 3000 && kept.len() > 500);
        assert_eq!(by_steps(&[1.0; 10], &[1.0; 10], 100), [0]);
    }
}
