//! The pairing of two sets of points with the smallest sum of squared distances.

use crate::domain::C64;

/// For each point of `from`, the index of its partner in `to`; both have the same length.
///
/// Hungarian method with potentials, O(n^3). Source: Kuhn, Naval Research Logistics 2 (1955), in the
/// shortest-path form of Jonker and Volgenant, Computing 38 (1987).
pub(crate) fn assign(from: &[C64], to: &[C64]) -> Vec<usize> {
    let n = from.len();
    let cost = |row: usize, column: usize| (from[row] - to[column]).norm_sqr();
    // Column n is a virtual start; `row_of[c]` is the row matched to column c, n for none.
    let mut row_of = vec![n; n + 1];
    let mut row_potential = vec![0.0; n + 1];
    let mut column_potential = vec![0.0; n + 1];
    for row in 0..n {
        row_of[n] = row;
        let mut column = n;
        let mut shortest = vec![f64::INFINITY; n];
        let mut before = vec![n; n];
        let mut done = vec![false; n + 1];
        // Grow a shortest-path tree from the new row until a free column is reached.
        while row_of[column] != n {
            done[column] = true;
            let current = row_of[column];
            let mut step = f64::INFINITY;
            let mut next = n;
            for c in (0..n).filter(|&c| !done[c]) {
                let reduced = cost(current, c) - row_potential[current] - column_potential[c];
                if reduced < shortest[c] {
                    shortest[c] = reduced;
                    before[c] = column;
                }
                if shortest[c] < step || next == n {
                    step = shortest[c];
                    next = c;
                }
            }
            for c in 0..=n {
                if done[c] {
                    row_potential[row_of[c]] += step;
                    column_potential[c] -= step;
                } else {
                    shortest[c] -= step;
                }
            }
            column = next;
        }
        // Walk back and shift the matches along the path.
        while column != n {
            let previous = before[column];
            row_of[column] = row_of[previous];
            column = previous;
        }
    }
    let mut partner = vec![0; n];
    for (column, &row) in row_of[..n].iter().enumerate() {
        partner[row] = column;
    }
    partner
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_best_of_all_permutations() {
        let point = |k: usize| C64::new(((k * 37) % 11) as f64, ((k * 53) % 13) as f64);
        let from: Vec<C64> = (0..5).map(point).collect();
        let to: Vec<C64> = (5..10).map(point).collect();
        let total = |order: &[usize]| {
            order.iter().enumerate().map(|(i, &j)| (from[i] - to[j]).norm_sqr()).sum::<f64>()
        };
        let mut best = f64::INFINITY;
        for code in 0..5_usize.pow(5) {
            let order: Vec<usize> = (0..5).map(|i| code / 5_usize.pow(i) % 5).collect();
            if (0..5).all(|j| order.contains(&j)) {
                best = best.min(total(&order));
            }
        }
        assert!((total(&assign(&from, &to)) - best).abs() < 1e-12);
    }
}
