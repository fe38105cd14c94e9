//! The zero level of a function of two variables, from its values on a grid.

/// Polylines of the zero level, in units of the grid: `values[j][i]` is at `(i, j)`. Cells with a NaN are
/// omitted. `centre` gives the value in the middle of the cell at `(i, j)`. It is called if the corners do
/// not decide between two possible lines.
pub(super) fn zero_level(values: &[Vec<f64>], centre: &dyn Fn(usize, usize) -> f64) -> Vec<Vec<[f64; 2]>> {
    let mut pieces: Vec<[[f64; 2]; 2]> = Vec::new();
    for j in 0..values.len().saturating_sub(1) {
        for i in 0..values[j].len().saturating_sub(1) {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let at = |k: usize| values[corners[k % 4].1][corners[k % 4].0];
            if (0..4).any(|k| !at(k).is_finite()) {
                continue;
            }
            let crossing = |k: usize| {
                let (a, b) = (at(k), at(k + 1));
                ((a > 0.0) != (b > 0.0)).then(|| {
                    let share = a / (a - b);
                    let ((x0, y0), (x1, y1)) = (corners[k], corners[(k + 1) % 4]);
                    [x0 as f64 + share * (x1 as f64 - x0 as f64), y0 as f64 + share * (y1 as f64 - y0 as f64)]
                })
            };
            let mut found: Vec<[f64; 2]> = (0..4).filter_map(crossing).collect();
            // Each line cuts off a corner: the first and third, or the other two, whichever have the opposite
            // sign of the middle.
            if found.len() == 4 && (at(0) > 0.0) != (centre(i, j) > 0.0) {
                found.rotate_right(1);
            }
            // If the level passes through a corner, a piece may have no length.
            pieces
                .extend(found.chunks_exact(2).map(|pair| [pair[0], pair[1]]).filter(|[a, b]| !meets(*a, *b)));
        }
    }
    join(pieces)
}

/// Ends closer than this are one, in units of the grid.
fn meets(a: [f64; 2], b: [f64; 2]) -> bool {
    (a[0] - b[0]).abs().max((a[1] - b[1]).abs()) < 1e-9
}

/// Pieces whose ends meet, as lines.
fn join(mut pieces: Vec<[[f64; 2]; 2]>) -> Vec<Vec<[f64; 2]>> {
    let mut lines = Vec::new();
    while let Some([start, end]) = pieces.pop() {
        let mut line = std::collections::VecDeque::from([start, end]);
        while let Some((i, forward, other)) = (pieces.iter().enumerate()).find_map(|(i, &[a, b])| {
            let (first, last) = (line[0], line[line.len() - 1]);
            let cases = [
                (meets(last, a), true, b),
                (meets(last, b), true, a),
                (meets(first, a), false, b),
                (meets(first, b), false, a),
            ];
            cases.into_iter().find(|(meets, ..)| *meets).map(|(_, forward, other)| (i, forward, other))
        }) {
            pieces.swap_remove(i);
            if forward { line.push_back(other) } else { line.push_front(other) }
        }
        lines.push(line.into());
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A circle of radius 6 about (10, 10); linear interpolation on cells of size one errs by up to 1 / (8 *
    /// 6).
    #[test]
    fn truth_a_circle_is_one_closed_line() {
        let values: Vec<Vec<f64>> = (0..21)
            .map(|j| (0..21).map(|i| (f64::from(i) - 10.0).hypot(f64::from(j) - 10.0) - 6.0).collect())
            .collect();
        let lines = zero_level(&values, &|_, _| panic!("no cell of a circle this large is open"));
        assert_eq!(lines.len(), 1);
        assert!(lines[0].iter().all(|[x, y]| ((x - 10.0).hypot(y - 10.0) - 6.0).abs() < 0.03));
        assert!(meets(lines[0][0], lines[0][lines[0].len() - 1]));
    }

    /// A strip about the falling diagonal, narrower than a cell, and the same with the signs reversed.
    #[test]
    fn regress_a_strip_narrower_than_a_cell_is_two_lines() {
        for sign in [1.0, -1.0] {
            let strip = |x: f64, y: f64| sign * ((x + y - 9.0).abs() - 0.4);
            let values: Vec<Vec<f64>> =
                (0..10).map(|j| (0..10).map(|i| strip(f64::from(i), f64::from(j))).collect()).collect();
            let lines = zero_level(&values, &|i, j| strip(i as f64 + 0.5, j as f64 + 0.5));
            assert_eq!(lines.len(), 2, "{lines:?}");
            for line in lines {
                let sides: Vec<bool> = line.iter().map(|[x, y]| x + y > 9.0).collect();
                assert!(sides.windows(2).all(|pair| pair[0] == pair[1]), "{line:?}");
            }
        }
    }
}
