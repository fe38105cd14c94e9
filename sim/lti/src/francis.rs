//! Eigenvalues and Schur form of real matrices by the QR algorithm with Francis' double shift.
//!
//! A search over gains solves thousands of problems of four to twenty states. There a plain loop over one
//! array is several times as fast as blocked code. Source: Martin, Peters and Wilkinson, `orthes` and `hqr`,
//! Numerische Mathematik 12 and 14 (1968, 1970).

use nalgebra::DMatrix;

use crate::domain::C64;

/// Steps for one eigenvalue; two to four usually suffice.
const MOST_STEPS: usize = 60;
/// If the largest element lies within this factor of one, no product of a few elements overflows or vanishes.
const ORDINARY: f64 = 1e90;
/// After each of these numbers of steps the shift is replaced by an arbitrary one, which breaks cycles.
const STUCK: usize = 10;

/// A square matrix, row by row.
pub(crate) struct Rows {
    pub(crate) order: usize,
    values: Vec<f64>,
}

impl Rows {
    /// From elements row by row, with the power of two by which they were divided if their size is not
    /// ordinary.
    fn new(order: usize, mut values: Vec<f64>) -> (Self, f64) {
        let largest = values.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
        let is_ordinary = largest <= 0.0 || (ORDINARY.recip()..ORDINARY).contains(&largest);
        let unit = if is_ordinary { 1.0 } else { largest.log2().floor().exp2() };
        if !is_ordinary {
            for v in &mut values {
                *v /= unit;
            }
        }
        (Self { order, values }, unit)
    }

    /// Sum of the sizes of all elements.
    pub(crate) fn norm(&self) -> f64 {
        self.values.iter().map(|v| v.abs()).sum()
    }

    pub(crate) fn at(&self, i: usize, j: usize) -> f64 {
        self.values[i * self.order + j]
    }

    fn set(&mut self, i: usize, j: usize, value: f64) {
        self.values[i * self.order + j] = value;
    }

    /// Reduces to Hessenberg form by reflections, and applies these to `basis` as well.
    fn reduce_to_hessenberg(&mut self, mut basis: Option<&mut Self>) {
        let n = self.order;
        let mut v = vec![0.0; n];
        let mut along = vec![0.0; n];
        for k in 0..n.saturating_sub(2) {
            let size = (k + 2..n).map(|i| self.at(i, k).abs()).fold(0.0, f64::max);
            if size <= 0.0 {
                continue;
            }
            let scale = size.max(self.at(k + 1, k).abs());
            for (i, entry) in v.iter_mut().enumerate().skip(k + 1) {
                *entry = self.at(i, k) / scale;
            }
            let norm = v[k + 1..].iter().map(|x| x * x).sum::<f64>().sqrt();
            let head = if v[k + 1] < 0.0 { -norm } else { norm };
            v[k + 1] += head;
            let half_square = head * v[k + 1];
            along[k..].fill(0.0);
            for (row, v) in self.values.chunks_exact(n).zip(&v).skip(k + 1) {
                along[k..].iter_mut().zip(&row[k..]).for_each(|(sum, entry)| *sum += v * entry);
            }
            along[k..].iter_mut().for_each(|sum| *sum /= half_square);
            for (row, v) in self.values.chunks_exact_mut(n).zip(&v).skip(k + 1) {
                row[k..].iter_mut().zip(&along[k..]).for_each(|(entry, along)| *entry -= along * v);
            }
            self.reflect_columns(k + 1, &v[k + 1..], half_square);
            if let Some(basis) = &mut basis {
                basis.reflect_columns(k + 1, &v[k + 1..], half_square);
            }
            self.set(k + 1, k, -head * scale);
            for i in k + 2..n {
                self.set(i, k, 0.0);
            }
        }
    }

    /// The columns from `first` onwards, reflected along `v`.
    fn reflect_columns(&mut self, first: usize, v: &[f64], half_square: f64) {
        for row in self.values.chunks_exact_mut(self.order) {
            let row = &mut row[first..];
            let along = row.iter().zip(v).map(|(r, v)| r * v).sum::<f64>() / half_square;
            row.iter_mut().zip(v).for_each(|(entry, v)| *entry -= along * v);
        }
    }

    /// First row of the block that ends at `high`: the element left of it is zero up to rounding.
    fn first_of_block(&self, high: usize, norm: f64) -> usize {
        let mut low = high;
        while low > 0 {
            let beside = self.at(low - 1, low - 1).abs() + self.at(low, low).abs();
            let beside = if beside > 0.0 { beside } else { norm };
            if self.at(low, low - 1).abs() <= f64::EPSILON * beside {
                break;
            }
            low -= 1;
        }
        low
    }

    /// Both eigenvalues of the block of rows `i` and `i + 1`.
    pub(crate) fn pair(&self, i: usize) -> [C64; 2] {
        let (corner, product) = (self.at(i + 1, i + 1), self.at(i + 1, i) * self.at(i, i + 1));
        let half = 0.5 * (self.at(i, i) - corner);
        let square = half * half + product;
        let root = square.abs().sqrt();
        if square < 0.0 {
            return [C64::new(corner + half, -root), C64::new(corner + half, root)];
        }
        let far = if half < 0.0 { half - root } else { half + root };
        let near = if far.abs() > 0.0 { -product / far } else { 0.0 };
        [C64::new(corner + far, 0.0), C64::new(corner + near, 0.0)]
    }

    /// One double step on the block from `low` to `high`. The shifts have the sum and product of the block's
    /// last pair, or are arbitrary. With a basis, the rest of the matrix takes part.
    fn step(&mut self, low: usize, high: usize, arbitrary: bool, mut basis: Option<&mut Self>) {
        let (x, y, w) = if arbitrary {
            let s = self.at(high, high - 1).abs() + self.at(high - 1, high - 2).abs();
            (self.at(high, high) + 0.75 * s, self.at(high, high) + 0.75 * s, -0.4375 * s * s)
        } else {
            let w = self.at(high, high - 1) * self.at(high - 1, high);
            (self.at(high, high), self.at(high - 1, high - 1), w)
        };
        // The step may begin where two subdiagonal elements in a row are small.
        let first_column = |of: &Self, m: usize| {
            let z = of.at(m, m);
            let (r, s) = (x - z, y - z);
            let head = [
                (r * s - w) / of.at(m + 1, m) + of.at(m, m + 1),
                of.at(m + 1, m + 1) - z - r - s,
                of.at(m + 2, m + 1),
            ];
            let size: f64 = head.iter().map(|h| h.abs()).sum();
            head.map(|h| h / size)
        };
        let mut m = high - 2;
        let mut head = first_column(self, m);
        while m > low {
            let z = self.at(m, m);
            let beside = self.at(m - 1, m - 1).abs() + z.abs() + self.at(m + 1, m + 1).abs();
            let left = self.at(m, m - 1).abs() * (head[1].abs() + head[2].abs());
            if left < f64::EPSILON * head[0].abs() * beside {
                break;
            }
            m -= 1;
            head = first_column(self, m);
        }
        for i in m + 2..=high {
            self.set(i, i - 2, 0.0);
            if i > m + 2 {
                self.set(i, i - 3, 0.0);
            }
        }
        for k in m..high {
            let is_three = k + 1 < high;
            let mut scale = 1.0;
            if k > m {
                head = [
                    self.at(k, k - 1),
                    self.at(k + 1, k - 1),
                    if is_three { self.at(k + 2, k - 1) } else { 0.0 },
                ];
                scale = head.iter().map(|h| h.abs()).sum();
                if scale <= 0.0 {
                    continue;
                }
                head = head.map(|h| h / scale);
            }
            let norm = head.iter().map(|h| h * h).sum::<f64>().sqrt();
            let norm = if head[0] < 0.0 { -norm } else { norm };
            if k > m {
                self.set(k, k - 1, -norm * scale);
            } else if low < m {
                self.set(k, k - 1, -self.at(k, k - 1));
            }
            let first = head[0] + norm;
            let row = [first / norm, head[1] / norm, head[2] / norm];
            let column = [head[1] / first, head[2] / first];
            let near = high.min(k + 3);
            let reach = if basis.is_some() { [self.order - 1, 0] } else { [high, low] };
            self.reflect_three_rows(k, reach[0], row, column, is_three);
            self.reflect_three_columns(k, [reach[1], near], row, column, is_three);
            if let Some(basis) = &mut basis {
                basis.reflect_three_columns(k, [0, basis.order - 1], row, column, is_three);
            }
        }
    }

    /// A reflection of two or three neighbouring rows from `k` onwards, up to column `last`.
    fn reflect_three_rows(&mut self, k: usize, last: usize, row: [f64; 3], column: [f64; 2], is_three: bool) {
        let n = self.order;
        for j in k..=last {
            let mut sum = self.at(k, j) + column[0] * self.at(k + 1, j);
            if is_three {
                sum += column[1] * self.at(k + 2, j);
                self.values[(k + 2) * n + j] -= sum * row[2];
            }
            self.values[k * n + j] -= sum * row[0];
            self.values[(k + 1) * n + j] -= sum * row[1];
        }
    }

    /// The same reflection of columns, in the rows from `first` to `last`.
    fn reflect_three_columns(
        &mut self,
        k: usize,
        [first, last]: [usize; 2],
        row: [f64; 3],
        column: [f64; 2],
        is_three: bool,
    ) {
        let n = self.order;
        for i in first..=last {
            let of = &mut self.values[i * n + k..];
            let mut sum = row[0] * of[0] + row[1] * of[1];
            if is_three {
                sum += row[2] * of[2];
                of[2] -= sum * column[1];
            }
            of[0] -= sum;
            of[1] -= sum * column[0];
        }
    }
}

/// Eigenvalues of a balanced matrix, in no order, conjugate pairs exact and adjacent; `None` if the iteration
/// does not converge.
pub(crate) fn eigenvalues_by_francis(matrix: &DMatrix<f64>) -> Option<Vec<C64>> {
    let n = matrix.nrows();
    // Rows of the transpose: its eigenvalues are the same.
    let (mut h, unit) = Rows::new(n, matrix.as_slice().to_vec());
    let mut found = Vec::with_capacity(n);
    iterate(&mut h, None, |h, low, high| {
        if low == high {
            found.push(C64::new(h.at(low, low), 0.0));
        } else {
            found.extend(h.pair(low));
        }
    })?;
    for value in &mut found {
        *value *= unit;
    }
    found.iter().all(|value| value.is_finite()).then_some(found)
}

/// A real Schur form `A = unit Q T Q^T`.
pub(crate) struct Schur {
    pub(crate) unit: f64,
    /// T, upper triangular except for blocks of two.
    pub(crate) form: Rows,
    /// Q.
    pub(crate) basis: DMatrix<f64>,
    /// First row of each block of T, from the last block on, and whether it has two.
    pub(crate) blocks: Vec<(usize, bool)>,
}

/// The Schur form of a balanced matrix; `None` if the iteration does not converge.
pub(crate) fn schur_by_francis(matrix: &DMatrix<f64>) -> Option<Schur> {
    let n = matrix.nrows();
    let (mut form, unit) = Rows::new(n, matrix.transpose().as_slice().to_vec());
    let mut basis = Rows { order: n, values: DMatrix::<f64>::identity(n, n).as_slice().to_vec() };
    let mut blocks = Vec::with_capacity(n);
    iterate(&mut form, Some(&mut basis), |_, low, high| blocks.push((low, low < high)))?;
    Some(Schur { unit, form, basis: DMatrix::from_row_slice(n, n, &basis.values), blocks })
}

/// Splits a matrix from its end into blocks of one or two rows; passes the first and last row of each to
/// `show`.
fn iterate(
    h: &mut Rows,
    mut basis: Option<&mut Rows>,
    mut show: impl FnMut(&Rows, usize, usize),
) -> Option<()> {
    h.reduce_to_hessenberg(basis.as_deref_mut());
    let norm = h.norm();
    let (mut left, mut steps) = (h.order, 0);
    while left > 0 {
        let high = left - 1;
        let low = h.first_of_block(high, norm);
        if high - low > 1 {
            if steps == MOST_STEPS {
                return None;
            }
            steps += 1;
            h.step(low, high, steps % STUCK == 0, basis.as_deref_mut());
            continue;
        }
        show(h, low, high);
        (left, steps) = (low, 0);
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::balance::balance;

    /// Largest distance of each of some points from the nearest of others.
    fn apart(from: &[C64], to: &[C64]) -> f64 {
        from.iter()
            .map(|p| to.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min))
            .fold(0.0, f64::max)
    }

    /// Two algorithms, both backward stable to some n eps |A|, 1e-14. The condition of an eigenvalue is some
    /// thousands at most.
    #[test]
    fn truth_the_eigenvalues_of_nalgebra() {
        for n in 1..=40 {
            for seed in 0..8_u32 {
                // Decimals of large sines look random.
                let entry = |i: usize, j: usize| {
                    let mixed = (1 + i * 127 + j * 311 + seed as usize * 7919) as f64;
                    2.0 * (mixed.sin() * 43_758.545_3).rem_euclid(1.0) - 1.0
                };
                let matrix = balance(&DMatrix::from_fn(n, n, entry)).matrix;
                let own = eigenvalues_by_francis(&matrix).unwrap();
                let other: Vec<C64> = matrix.complex_eigenvalues().iter().copied().collect();
                let far = apart(&own, &other).max(apart(&other, &own));
                assert!(own.len() == n && far < 1e-10 * matrix.norm(), "{n} {seed}: {far}");
            }
        }
    }

    /// n equal masses and springs between walls: `omega_k = 2 sqrt(k / m) sin(k pi / (2 n + 2))`.
    #[test]
    fn truth_a_uniform_chain_swings_at_its_closed_form() {
        for bodies in [1, 2, 5, 12, 20] {
            let n = 2 * bodies;
            let stiffness = 1e5;
            let mut a = DMatrix::zeros(n, n);
            for i in 0..bodies {
                a[(i, bodies + i)] = 1.0;
                a[(bodies + i, i)] = -2.0 * stiffness;
                for j in [i.wrapping_sub(1), i + 1].into_iter().filter(|j| *j < bodies) {
                    a[(bodies + i, j)] = stiffness;
                }
            }
            let mut found: Vec<f64> = eigenvalues_by_francis(&balance(&a).matrix)
                .unwrap()
                .into_iter()
                .filter(|p| p.im > 0.0)
                .map(|p| p.im)
                .collect();
            found.sort_by(f64::total_cmp);
            assert_eq!(found.len(), bodies);
            for (k, w) in found.iter().enumerate() {
                let angle = (k + 1) as f64 * std::f64::consts::PI / (2 * bodies + 2) as f64;
                let truth = 2.0 * stiffness.sqrt() * angle.sin();
                // Tolerance: rounding of the largest frequency, amplified by the ratio of the largest to the
                // smallest.
                assert!((w - truth).abs() < 1e-11 * 2.0 * stiffness.sqrt(), "{bodies} {k}: {w} {truth}");
            }
        }
    }

    /// A cyclic shift defeats the ordinary shifts: all its eigenvalues have modulus one.
    #[test]
    fn truth_a_cycle_converges() {
        for n in [3, 4, 7, 16] {
            let cycle = DMatrix::from_fn(n, n, |i, j| if (i + 1) % n == j { 1.0 } else { 0.0 });
            let found = eigenvalues_by_francis(&cycle).unwrap();
            let truth: Vec<C64> =
                (0..n).map(|k| C64::cis(std::f64::consts::TAU * k as f64 / n as f64)).collect();
            assert!(apart(&truth, &found) < 1e-13, "{n}: {found:?}");
        }
    }
}
