//! Irreducible parts of a system: which of its states, inputs and outputs decide its zeros together.
//!
//! Many machines are rows of bodies, and the force passes from spring to spring. The system matrix is then
//! block triangular in a suitable order of its rows and columns, and its zeros are those of the blocks: one
//! for each spring. A block has a few rows, and its zeros are exact to machine precision. In the whole matrix
//! they are multiple zeros, which rounding scatters. Source: Dulmage and Mendelsohn, Canadian Journal of
//! Mathematics 10 (1958).

use std::collections::VecDeque;

use nalgebra::DMatrix;

use crate::polish::Reduced;

/// The parts of a system with as many inputs as outputs, or the system itself if it has only one part.
pub(crate) fn parts(system: Reduced) -> Vec<Reduced> {
    split(&system).unwrap_or_else(|| vec![system])
}

fn split(system: &Reduced) -> Option<Vec<Reduced>> {
    let (n, m) = (system.a.nrows(), system.d.nrows());
    if system.d.ncols() != m || m == 0 {
        return None;
    }
    let whole = whole(system);
    // The zero sought is on the diagonal of every state.
    let is_linked = |i: usize, j: usize| (i == j && i < n) || whole[(i, j)] != 0.0;
    let column_of = matched(n, n + m, is_linked)?;
    let mut row_of = vec![0; n + m];
    for (row, &column) in column_of.iter().enumerate() {
        row_of[column] = row;
    }
    let blocks = strongly_linked(n + m, |i, k| is_linked(i, column_of[k]));
    if blocks.len() < 2 {
        return None;
    }
    let mut found = Vec::new();
    for rows in blocks {
        let mut columns: Vec<usize> = rows.iter().map(|&row| column_of[row]).collect();
        columns.sort_unstable();
        let (states, outputs): (Vec<usize>, Vec<usize>) =
            rows.iter().partition(|row| **row < n && columns.binary_search(row).is_ok());
        let inputs: Vec<usize> =
            columns.into_iter().filter(|column| states.binary_search(column).is_err()).collect();
        // For a block with several outputs, the rank of the whole matrix is the sharper test.
        if outputs.len() > 1 {
            return None;
        }
        let part = |rows: &[usize], columns: &[usize]| whole.select_rows(rows).select_columns(columns);
        if !states.is_empty() {
            found.push(Reduced {
                a: part(&states, &states),
                b: part(&states, &inputs),
                c: part(&outputs, &states),
                d: part(&outputs, &inputs),
            });
        }
    }
    Some(found)
}

/// The matrix [A B; C D].
fn whole(system: &Reduced) -> DMatrix<f64> {
    let (n, m) = (system.a.nrows(), system.d.nrows());
    let mut whole = DMatrix::zeros(n + m, n + m);
    whole.view_mut((0, 0), (n, n)).copy_from(&system.a);
    whole.view_mut((0, n), (n, m)).copy_from(&system.b);
    whole.view_mut((n, 0), (m, n)).copy_from(&system.c);
    whole.view_mut((n, n), (m, m)).copy_from(&system.d);
    whole
}

/// A column for every row, each used once, so that all pairs are linked; `None` if there is no such choice.
/// The first `given` rows and columns are linked in pairs.
fn matched(given: usize, count: usize, is_linked: impl Fn(usize, usize) -> bool) -> Option<Vec<usize>> {
    let mut row_of: Vec<Option<usize>> = (0..count).map(|i| (i < given).then_some(i)).collect();
    for first in given..count {
        // The shortest way from this row to a free column, over pairs that exchange their columns.
        let mut reached_from = vec![None; count];
        let mut rows = VecDeque::from([first]);
        let mut end = None;
        while let Some(row) = rows.pop_front().filter(|_| end.is_none()) {
            let is_new = |column: &usize| reached_from[*column].is_none() && is_linked(row, *column);
            let reached: Vec<usize> = (0..count).filter(is_new).collect();
            for column in reached {
                reached_from[column] = Some(row);
                match row_of[column] {
                    Some(next) => rows.push_back(next),
                    None => end = end.or(Some(column)),
                }
            }
        }
        let mut column = end?;
        loop {
            let row = reached_from[column]?;
            row_of[column] = Some(row);
            if row == first {
                break;
            }
            // The column that this row had before: the one through which it was reached.
            column = (0..count).find(|&j| j != column && row_of[j] == Some(row))?;
        }
    }
    let mut column_of = vec![0; count];
    for (column, row) in row_of.into_iter().enumerate() {
        column_of[row?] = column;
    }
    Some(column_of)
}

/// Groups of nodes that lead to each other, each rising.
fn strongly_linked(count: usize, leads: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    // First the nodes by the time at which a walk leaves them last; then walks against the links, from the
    // last node.
    let mut left = Vec::with_capacity(count);
    let mut seen = vec![false; count];
    for start in 0..count {
        left.extend(walk(start, count, &leads, &mut seen));
    }
    let mut seen = vec![false; count];
    let mut groups = Vec::new();
    for start in left.into_iter().rev() {
        let mut group = walk(start, count, &|i, j| leads(j, i), &mut seen);
        if !group.is_empty() {
            group.sort_unstable();
            groups.push(group);
        }
    }
    groups
}

/// The nodes not seen before that a walk from `start` reaches, in the order in which it leaves them.
fn walk(start: usize, count: usize, leads: &impl Fn(usize, usize) -> bool, seen: &mut [bool]) -> Vec<usize> {
    let mut left = Vec::new();
    if std::mem::replace(&mut seen[start], true) {
        return left;
    }
    let mut on_the_way = vec![(start, 0)];
    while let Some((node, next)) = on_the_way.last_mut() {
        if *next == count {
            left.push(*node);
            on_the_way.pop();
            continue;
        }
        let (from, to) = (*node, *next);
        *next += 1;
        if !seen[to] && leads(from, to) {
            seen[to] = true;
            on_the_way.push((to, 0));
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    /// Two lags in series with a lead in between, (s + 3) / (s + 1)(s + 2): the lead is a separate part.
    #[test]
    fn truth_parts_in_series_are_found() {
        let series = Reduced {
            a: dmatrix![-1.0, 0.0; 2.0, -2.0],
            b: dmatrix![1.0; 1.0],
            c: dmatrix![0.0, 1.0],
            d: dmatrix![0.0],
        };
        let parts = parts(series);
        assert_eq!(parts.len(), 1);
        // y = 0 holds the second state at zero, so 2 x + u = 0 and the first is free at s = -1 - 2.
        let Reduced { a, b, c, d } = &parts[0];
        assert_eq!((a.shape(), d.shape()), ((1, 1), (1, 1)));
        assert!((a[(0, 0)] - b[(0, 0)] * c[(0, 0)] / d[(0, 0)] + 3.0).abs() < 1e-15);
    }

    #[test]
    fn truth_what_has_one_part_stays_as_it_is() {
        let full = Reduced {
            a: dmatrix![1.0, 2.0; 3.0, 4.0],
            b: dmatrix![1.0; 1.0],
            c: dmatrix![1.0, 1.0],
            d: dmatrix![1.0],
        };
        let found = parts(full.clone());
        assert_eq!((found.len(), &found[0].a), (1, &full.a));
    }

    /// No input reaches the output.
    #[test]
    fn truth_what_has_no_way_through_is_not_split() {
        let apart = Reduced {
            a: dmatrix![-1.0, 0.0; 0.0, -2.0],
            b: dmatrix![1.0; 0.0],
            c: dmatrix![0.0, 1.0],
            d: dmatrix![0.0],
        };
        assert_eq!(parts(apart).len(), 1);
    }
}
