//! Resamples series with uneven stamps or lost rows to an even grid.

/// Interpolation of a signal between its rows.
#[derive(Clone, Copy)]
pub(super) enum Between {
    /// The value of the last row, for commands. A row applies from half a spacing before its stamp, because
    /// stamps jitter and a command belongs to its own row.
    Held,
    Straight,
    /// A cubic through four rows, because a position has no corners.
    Smooth,
}

/// Resamples a series with stamps `time` at `rows` evenly spaced instants from its first stamp.
pub(super) fn regrid(
    time: &[f64],
    column: &[f64],
    rows: usize,
    spacing_s: f64,
    between: Between,
) -> Vec<f64> {
    let mut at = 0;
    if let Between::Held = between {
        let held = |i: usize| {
            let t = time[0] + (i as f64 + 0.5) * spacing_s;
            while at + 1 < time.len() && time[at + 1] < t {
                at += 1;
            }
            column[at]
        };
        return (0..rows).map(held).collect();
    }
    (0..rows)
        .map(|i| {
            let t = time[0] + i as f64 * spacing_s;
            while at + 2 < time.len() && time[at + 1] <= t {
                at += 1;
            }
            let share = ((t - time[at]) / (time[at + 1] - time[at])).clamp(0.0, 1.0);
            let straight = column[at] + share * (column[at + 1] - column[at]);
            match between {
                Between::Smooth if at > 0 && at + 2 < time.len() => cubic(time, column, at - 1, t),
                _ => straight,
            }
        })
        .collect()
}

/// Rows of the even grid that are further than half a spacing from every stamp in `time`, or whose nearest
/// row has no reading; empty if there are none.
pub(super) fn far_from_rows(time: &[f64], gaps: &[bool], rows: usize, spacing_s: f64) -> Vec<bool> {
    let mut at = 0;
    let far: Vec<bool> = (0..rows)
        .map(|i| {
            let t = time[0] + i as f64 * spacing_s;
            while at + 1 < time.len() && (time[at + 1] - t).abs() <= (time[at] - t).abs() {
                at += 1;
            }
            (time[at] - t).abs() > 0.5 * spacing_s || gaps.get(at) == Some(&true)
        })
        .collect();
    if far.contains(&true) { far } else { Vec::new() }
}

/// Lagrange's cubic through the four rows from index `first`, at time `t`.
fn cubic(time: &[f64], column: &[f64], first: usize, t: f64) -> f64 {
    let rows = first..first + 4;
    let weight = |i: usize| -> f64 {
        rows.clone().filter(|j| *j != i).map(|j| (t - time[j]) / (time[i] - time[j])).product()
    };
    rows.clone().map(|i| column[i] * weight(i)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows 3 and 4 of seven are lost, and row 1 has no reading.
    #[test]
    fn truth_rows_far_from_every_stamp_are_unknown() {
        let time = [0.0, 0.011, 0.019, 0.05, 0.0605];
        let gaps = [false, true, false, false, false];
        let far = far_from_rows(&time, &gaps, 7, 0.01);
        assert_eq!(far, [false, true, false, true, true, false, false]);
        assert!(far_from_rows(&time[..3], &[], 3, 0.01).is_empty());
    }

    /// If each instant took the row before its stamp, half of the commands would be a row late.
    #[test]
    fn regress_a_held_command_stays_with_its_row_where_stamps_wander() {
        let spacing_s = 0.01;
        let stamp = |k: usize| (k as f64 + 0.2 * (7.3 * k as f64).sin()) * spacing_s;
        let time: Vec<f64> = (0..200).map(stamp).collect();
        let column: Vec<f64> = (0..200).map(f64::from).collect();
        assert_eq!(regrid(&time, &column, 200, spacing_s, Between::Held), column);
        // A lost row keeps the command of the row before.
        let kept = |k: &usize| !(50..53).contains(k);
        let [time, column] = [time, column.clone()]
            .map(|series| (0..200).filter(kept).map(|k| series[k]).collect::<Vec<f64>>());
        let held = regrid(&time, &column, 200, spacing_s, Between::Held);
        assert_eq!(held[48..55].to_vec(), [48.0, 49.0, 49.0, 49.0, 49.0, 53.0, 54.0]);
        assert_eq!(held.last(), Some(&199.0));
    }

    #[test]
    fn order_a_position_between_uneven_rows_is_right_to_the_fourth_power() {
        let worst = |rows: usize, between: Between| {
            let spacing_s = 1.0 / rows as f64;
            // Stamps deviate by up to a fifth of a row.
            let stamp = |k: usize| (k as f64 + 0.2 * (7.3 * k as f64).sin()) * spacing_s;
            let time: Vec<f64> = (0..rows).map(stamp).collect();
            let column: Vec<f64> = time.iter().map(|t| (5.0 * t).sin()).collect();
            let found = regrid(&time, &column, rows, spacing_s, between);
            let inner = found.iter().enumerate().take(rows - 4).skip(4);
            inner.map(|(k, x)| (x - (5.0 * k as f64 * spacing_s).sin()).abs()).fold(0.0, f64::max)
        };
        let orders = [(Between::Straight, 2.0), (Between::Smooth, 4.0)];
        for (between, order) in orders {
            let slope = (worst(100, between) / worst(400, between)).log2() / 2.0;
            assert!((slope - order).abs() < 0.3, "{slope} for {order}");
        }
    }
}
