//! Drift of a machine that nothing holds in place: the machine moves as a whole, and the loop neither senses
//! nor drives that motion.
//!
//! A drift is an eigenvalue on the limit of stability at every gain, so it says nothing about any gain. Its
//! rounding errors would look like crossings. A search over gains therefore leaves the drift out.

use feeler_lti::{C64, balance};
use nalgebra::{DMatrix, DVector, RowDVector};

/// A row does not respond to a direction if its terms cancel to this share of their sizes. Exponentials are
/// accurate to about 1e-14.
const CANCELS: f64 = 1e-10;
/// Singular values below this share of the largest may belong to a drift (rows have equal scale). [`CANCELS`]
/// then decides.
const SMALL: f64 = 1e-9;

/// A state matrix A0 + k A1 as a function of a gain k, without its drift.
#[derive(Clone, Debug)]
pub(crate) struct WithoutDrift {
    /// A0 of the remaining states.
    pub(crate) zero: DMatrix<f64>,
    /// A1 of the remaining states.
    pub(crate) slope: DMatrix<f64>,
    neutral: f64,
    left_out: Vec<LeftOut>,
}

/// A state whose value only measures the drift. While the drift moves this state by 1, it moves the other
/// states by known distances.
#[derive(Clone, Debug)]
struct LeftOut {
    state: usize,
    direction: DVector<f64>,
    zero: RowDVector<f64>,
    slope: RowDVector<f64>,
}

impl WithoutDrift {
    /// Leaves out every direction v with `A0 v = neutral v` and `A1 v = 0`; `neutral` is 0 in continuous time
    /// and 1 in discrete time.
    pub(crate) fn new(zero: DMatrix<f64>, slope: DMatrix<f64>, neutral: f64) -> Self {
        let mut drifts = drifts(&zero, &slope, neutral);
        let mut rest = Self { zero, slope, neutral, left_out: Vec::new() };
        while let Some(drift) = drifts.pop() {
            let state = drift.icamax();
            let direction = &drift / drift[state];
            for other in &mut drifts {
                let share = other[state];
                other.axpy(-share, &direction, 1.0);
                *other = other.clone().remove_row(state);
            }
            rest.leave_out(state, direction);
        }
        rest
    }

    /// Replaces the other states by their distances from the drift.
    fn leave_out(&mut self, state: usize, direction: DVector<f64>) {
        let direction = direction.remove_row(state);
        let quotient = |m: &DMatrix<f64>| {
            let row = m.row(state).into_owned().remove_column(state);
            let rest = m.clone().remove_row(state).remove_column(state) - &direction * &row;
            (rest, row)
        };
        let (zero, zero_row) = quotient(&self.zero);
        let (slope, slope_row) = quotient(&self.slope);
        (self.zero, self.slope) = (zero, slope);
        self.left_out.push(LeftOut { state, direction, zero: zero_row, slope: slope_row });
    }

    /// Expands an eigenvector of the remaining states to all states.
    pub(crate) fn whole(&self, gain: f64, eigenvalue: C64, vector: &DVector<C64>) -> DVector<C64> {
        self.left_out.iter().rev().fold(vector.clone(), |vector, out| {
            let pull: C64 =
                (&out.zero + &out.slope * gain).iter().zip(vector.iter()).map(|(a, v)| v * *a).sum();
            let away = eigenvalue - self.neutral;
            let gone = if away.norm() > CANCELS { pull / away } else { C64::new(0.0, 0.0) };
            let moved = vector + out.direction.map(|d| gone * d);
            moved.insert_row(out.state, gone)
        })
    }
}

/// Unit directions to which neither matrix responds.
fn drifts(zero: &DMatrix<f64>, slope: &DMatrix<f64>, neutral: f64) -> Vec<DVector<f64>> {
    let n = zero.nrows();
    if n == 0 {
        return Vec::new();
    }
    let scale = balance(&(zero.abs() + slope.abs())).scale;
    let change = zero - DMatrix::identity(n, n) * neutral;
    let stacked = DMatrix::from_fn(2 * n, n, |i, j| if i < n { change[(i, j)] } else { slope[(i - n, j)] });
    let mut scaled = DMatrix::from_fn(2 * n, n, |i, j| stacked[(i, j)] * scale[j]);
    for mut row in scaled.row_iter_mut() {
        let size = row.amax();
        if size > 0.0 {
            row /= size;
        }
    }
    let svd = scaled.svd(false, true);
    let Some(directions) = svd.v_t else { return Vec::new() };
    let largest = svd.singular_values.amax();
    let left_alone = |v: &DVector<f64>| {
        stacked.row_iter().all(|row| {
            let terms = || row.iter().zip(v.iter()).map(|(a, v)| a * v);
            terms().sum::<f64>().abs() <= CANCELS * terms().map(f64::abs).sum::<f64>()
        })
    };
    (0..directions.nrows())
        .filter(|&i| svd.singular_values[i] <= SMALL * largest)
        .map(|i| DVector::from_fn(n, |j, _| clean(directions[(i, j)]) * scale[j]))
        .filter(left_alone)
        .collect()
}

/// Sets a component to zero if it is only rounding.
fn clean(component: f64) -> f64 {
    if component.abs() <= CANCELS { 0.0 } else { component }
}

#[cfg(test)]
mod tests {
    use feeler_lti::eigen;
    use nalgebra::dmatrix;

    use super::*;

    /// Eigenvalues of these matrices are accurate to about n eps times their size.
    const EIGEN: f64 = 1e-9;

    /// Two masses joined by a spring, with feedback of their relative speed. States are positions and speeds;
    /// nothing is held in place.
    fn floating() -> (DMatrix<f64>, DMatrix<f64>) {
        let zero =
            dmatrix![0.0, 0.0, 1.0, 0.0; 0.0, 0.0, 0.0, 1.0; -4e5, 4e5, -30.0, 0.0; 4e5, -4e5, 0.0, 0.0];
        let slope =
            dmatrix![0.0, 0.0, 0.0, 0.0; 0.0, 0.0, 0.0, 0.0; 0.0, 0.0, -1.0, 1.0; 0.0, 0.0, 1.0, -1.0];
        (zero, slope)
    }

    #[test]
    fn truth_the_rest_keeps_every_other_eigenvalue() {
        let (zero, slope) = floating();
        let rest = WithoutDrift::new(zero.clone(), slope.clone(), 0.0);
        assert_eq!(rest.zero.nrows(), 3);
        let whole = eigen(&(&zero + &slope * 2.0)).unwrap();
        let left = eigen(&(&rest.zero + &rest.slope * 2.0)).unwrap();
        for value in &left.values {
            let nearest = whole.values.iter().map(|v| (v - value).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest <= EIGEN * 1e3, "{value}");
        }
    }

    #[test]
    fn truth_eigenvectors_come_back_whole() {
        let (zero, slope) = floating();
        let rest = WithoutDrift::new(zero.clone(), slope.clone(), 0.0);
        let gain = 2.0;
        let left = eigen(&(&rest.zero + &rest.slope * gain)).unwrap();
        let matrix = (&zero + &slope * gain).map(|v| C64::new(v, 0.0));
        for (value, vector) in left.values.iter().zip(&left.vectors).filter(|(v, _)| v.norm() > 1.0) {
            let vector = rest.whole(gain, *value, vector);
            assert!(
                (&matrix * &vector - &vector * *value).norm() <= EIGEN * matrix.norm() * vector.norm(),
                "{value}"
            );
        }
    }

    #[test]
    fn truth_a_drift_that_grows_is_kept() {
        // A free mass without force: its speed is a second neutral motion, so its position grows without
        // bound.
        let (zero, slope) = (dmatrix![0.0, 1.0; 0.0, 0.0], DMatrix::zeros(2, 2));
        let rest = WithoutDrift::new(zero, slope, 0.0);
        assert_eq!(rest.zero, dmatrix![0.0]);
    }

    #[test]
    fn truth_a_machine_that_is_held_loses_nothing() {
        let (zero, slope) = (dmatrix![0.0, 1.0; -100.0, -0.1], dmatrix![0.0, 0.0; 0.0, -1.0]);
        assert_eq!(WithoutDrift::new(zero, slope, 0.0).zero.nrows(), 2);
    }
}
