//! Rows that a recorder lost and cells that it left empty: counted, and bridged if there are few.

use feeler_logs::median_step;

use super::fault::FaultKind;

/// Largest number of consecutive missing rows that is bridged.
const MOST_TOGETHER: usize = 20;
/// Largest share of missing rows that is bridged.
const MOST_SHARE: f64 = 0.05;

/// Whether this number of missing rows, with at most `longest` in a row, is small enough for interpolation.
pub(super) fn are_few(longest: usize, missing: usize, rows: usize) -> bool {
    longest <= MOST_TOGETHER && missing as f64 <= MOST_SHARE * rows as f64
}

/// First rows after pauses that are too long for interpolation.
pub(crate) fn breaks(times_s: &[f64]) -> Vec<usize> {
    let Some(usual_s) = median_step(times_s) else { return Vec::new() };
    let longest_s = (MOST_TOGETHER as f64 + 1.5) * usual_s;
    (1..times_s.len()).filter(|row| times_s[*row] - times_s[row - 1] > longest_s).collect()
}

/// A gap of this many sample intervals means that a row is missing.
pub(super) const FIRST_LOST: f64 = 1.5;

/// Missing rows of a record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lost {
    pub(super) rows: usize,
    pub(super) stretches: usize,
    pub(super) longest_s: f64,
    /// Index of the row after the longest gap.
    pub(super) longest_at: usize,
}

impl Lost {
    /// The missing rows, if interpolation can replace them. `None` if nothing or too much is missing, or if
    /// the stamps do not advance.
    pub(super) fn bridged(time: &[f64]) -> Option<Self> {
        let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mut sorted = steps.clone();
        sorted.sort_by(f64::total_cmp);
        let spacing_s = sorted.get(sorted.len() / 2).copied().filter(|_| sorted[0] > 0.0)?;
        let lost = Self::between(&steps, spacing_s);
        (lost.rows > 0 && lost.is_few(spacing_s, time.len())).then_some(lost)
    }

    /// The missing rows, from the steps between neighbouring time stamps, s; `spacing_s` is the usual step.
    fn between(steps: &[f64], spacing_s: f64) -> Self {
        let mut lost = Self { rows: 0, stretches: 0, longest_s: 0.0, longest_at: 0 };
        for (i, step) in steps.iter().enumerate() {
            let missing = (step / spacing_s).round() - 1.0;
            if missing >= 1.0 {
                lost.rows += missing as usize;
                lost.stretches += 1;
                if missing * spacing_s > lost.longest_s {
                    (lost.longest_s, lost.longest_at) = (missing * spacing_s, i + 1);
                }
            }
        }
        lost
    }

    fn is_few(&self, spacing_s: f64, rows: usize) -> bool {
        self.longest_s <= (MOST_TOGETHER as f64 + 0.5) * spacing_s
            && self.rows as f64 <= MOST_SHARE * rows as f64
    }
}

/// Interpolates a few empty cells and marks their rows in `gaps`. Reports a fatal fault if there are more.
/// Returns the index of the first empty cell.
pub(super) fn empty_cells(
    column: &mut [f64],
    gaps: &mut Vec<bool>,
    unreadable: Option<(usize, usize)>,
    is_held: bool,
) -> Option<(usize, FaultKind)> {
    if let Some((row, cells)) = unreadable {
        return Some((row, FaultKind::NotANumber { cells }));
    }
    let first = column.iter().position(|x| !x.is_finite())?;
    let cells = column.iter().filter(|x| !x.is_finite()).count();
    let stretches = column.chunk_by(|a, b| a.is_finite() == b.is_finite());
    let longest = stretches.filter(|run| !run[0].is_finite()).map(<[f64]>::len).max().unwrap_or(0);
    if !are_few(longest, cells, column.len()) {
        return Some((first, FaultKind::NotANumber { cells }));
    }
    gaps.resize(column.len(), false);
    gaps.iter_mut().zip(column.iter()).for_each(|(gap, x)| *gap |= !x.is_finite());
    let empty: Vec<bool> = column.iter().map(|x| !x.is_finite()).collect();
    bridge(column, |k| empty[k], is_held);
    Some((first, FaultKind::EmptyCells { cells, longest }))
}

/// Fills missing rows: with the last value if `is_held`, otherwise by linear interpolation. Before the first
/// and after the last reading the nearest value is kept.
pub(super) fn bridge(column: &mut [f64], is_missing: impl Fn(usize) -> bool, is_held: bool) {
    let (missing, known): (Vec<usize>, Vec<usize>) = (0..column.len()).partition(|&k| is_missing(k));
    for k in missing {
        let after = known.partition_point(|other| *other < k);
        let before = after.checked_sub(1).map(|i| known[i]);
        column[k] = match (before, known.get(after)) {
            (Some(a), Some(&b)) if !is_held => {
                column[a] + (column[b] - column[a]) * (k - a) as f64 / (b - a) as f64
            }
            (Some(a), _) => column[a],
            (None, Some(&b)) => column[b],
            (None, None) => f64::NAN,
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 20 rows are missing between rows 9 and 10, and 21 between rows 49 and 50.
    #[test]
    fn truth_more_missing_rows_together_than_are_bridged_are_a_break() {
        let at = |k: i32| 0.01 * f64::from(k + if k >= 10 { 20 } else { 0 } + if k >= 50 { 21 } else { 0 });
        assert_eq!(breaks(&(0..100).map(at).collect::<Vec<f64>>()), [50]);
        assert!(breaks(&[]).is_empty() && breaks(&[0.0, 1.0]).is_empty());
    }

    #[test]
    fn truth_lost_rows_are_counted_by_stretches() {
        let mut steps = vec![0.01; 200];
        steps[20] = 0.021;
        steps[90] = 0.059;
        let lost = Lost::between(&steps, 0.01);
        assert_eq!((lost.rows, lost.stretches, lost.longest_at), (6, 2, 91));
        assert!((lost.longest_s - 0.05).abs() < 1e-12);
        assert!(lost.is_few(0.01, 201));
        // Six of a hundred are too many, and so are 21 in a row.
        assert!(!lost.is_few(0.01, 101));
        steps[90] = 0.22;
        assert!(!Lost::between(&steps, 0.01).is_few(0.01, 10_000));
        assert_eq!(Lost::between(&[0.01; 9], 0.01).rows, 0);
    }
}
