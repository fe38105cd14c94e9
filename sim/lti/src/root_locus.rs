//! Root locus: the poles of a loop followed over its gain.

use nalgebra::DMatrix;

use crate::assignment::assign;
use crate::domain::C64;
use crate::eigen::eigenvalues;
use crate::error::{LtiError, require_finite};

/// Bisections of a gain step in search of an unambiguous continuation. No such step exists if branches meet;
/// then either continuation is correct.
const MAX_HALVINGS: usize = 6;
/// A continuation is unambiguous if no pole moves farther than this share of its distance to the nearest
/// other pole.
const CLEAR_MOVE: f64 = 0.3;
/// Poles nearer to each other than this share of the largest, before and after a step, are one multiple pole.
/// Rounding moves a double pole by the square root of itself, 1.5e-8. Its order does not matter.
const MULTIPLE: f64 = 1e-7;

/// Poles over a gain, each branch continuous.
#[derive(Debug, Clone, PartialEq)]
pub struct RootLocus {
    pub gains: Vec<f64>,
    /// One branch for each pole; `branches[i][j]` is pole i at gain j.
    pub branches: Vec<Vec<C64>>,
}

/// Follows the eigenvalues of a matrix that depends on a gain through the given gains, in their order.
///
/// # Errors
/// The errors of [`eigenvalues`] for the matrices; [`LtiError::NotFinite`] for the gains.
///
/// # Example
/// ```
/// use nalgebra::dmatrix;
/// let a = |k: f64| dmatrix![0.0, 1.0; -k, -2.0];
/// let locus = feeler_lti::root_locus(a, &[0.0, 0.5, 5.0])?;
/// assert!((locus.branches[0][2].re + 1.0).abs() < 1e-14);
/// assert!((locus.branches[0][2].im.abs() - 2.0).abs() < 1e-14);
/// # Ok::<(), feeler_lti::LtiError>(())
/// ```
pub fn root_locus(closed_loop: impl Fn(f64) -> DMatrix<f64>, gains: &[f64]) -> Result<RootLocus, LtiError> {
    require_finite("gains", gains)?;
    let poles = |gain: f64| eigenvalues(&closed_loop(gain));
    let Some(&first) = gains.first() else {
        return Ok(RootLocus { gains: Vec::new(), branches: Vec::new() });
    };
    let mut now = poles(first)?;
    let mut branches: Vec<Vec<C64>> = now.iter().map(|&p| vec![p]).collect();
    for pair in gains.windows(2) {
        now = advance(&poles, &now, (pair[0], pair[1]), MAX_HALVINGS)?;
        for (branch, &pole) in branches.iter_mut().zip(&now) {
            branch.push(pole);
        }
    }
    Ok(RootLocus { gains: gains.to_vec(), branches })
}

/// Poles at the end of a gain step, in the order of the poles at its start.
fn advance(
    poles: &impl Fn(f64) -> Result<Vec<C64>, LtiError>,
    from: &[C64],
    (start, end): (f64, f64),
    halvings: usize,
) -> Result<Vec<C64>, LtiError> {
    let unordered = poles(end)?;
    let matched: Vec<C64> = assign(from, &unordered).into_iter().map(|j| unordered[j]).collect();
    let near = MULTIPLE * from.iter().chain(&matched).map(|pole| pole.norm()).fold(0.0, f64::max);
    let is_one =
        |i: usize, j: usize| (from[j] - from[i]).norm() <= near && (matched[j] - matched[i]).norm() <= near;
    let clear = matched.iter().enumerate().all(|(i, to)| {
        let others = (0..from.len()).filter(|&j| j != i && !is_one(i, j)).map(|j| (from[j] - from[i]).norm());
        (to - from[i]).norm() <= CLEAR_MOVE * others.fold(f64::INFINITY, f64::min)
    });
    if clear || halvings == 0 {
        return Ok(matched);
    }
    let middle = 0.5 * (start + end);
    let half_way = advance(poles, from, (start, middle), halvings - 1)?;
    advance(poles, &half_way, (middle, end), halvings - 1)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use nalgebra::dmatrix;

    use super::*;

    /// A delay of two samples has a double pole at zero. Rounding scatters the pole, which no step resolves,
    /// so every step was halved to the limit.
    #[test]
    fn regress_a_double_pole_does_not_halve_every_step() {
        let turn =
            dmatrix![1.0, 2.0, 0.5, 0.3; -1.0, 1.5, 0.7, -0.2; 0.3, -0.4, 2.0, 0.6; 0.1, 0.8, -0.5, 1.2];
        let back = turn.clone().try_inverse().unwrap();
        let calls = Cell::new(0);
        let closed = |k: f64| {
            calls.set(calls.get() + 1);
            let delay_and_mode = dmatrix![
                0.0, 1.0, 0.0, 0.0; 0.0, 0.0, 0.0, 0.0; 0.0, 0.0, 0.9, 0.3 + k; 0.0, 0.0, -0.3 - k, 0.9];
            &turn * delay_and_mode * &back
        };
        let gains: Vec<f64> = (0..=20).map(|i| 0.005 * f64::from(i)).collect();
        let locus = root_locus(closed, &gains).unwrap();
        let scatter = locus.branches.iter().map(|branch| branch[0].norm()).fold(f64::INFINITY, f64::min);
        assert!(scatter > 0.0, "without rounding this would test nothing");
        assert_eq!(calls.get(), gains.len());
        // 0.9 + (0.3 + k) i, to rounding of a simple pole.
        let end = C64::new(0.9, 0.4);
        assert!(locus.branches.iter().any(|branch| (branch[gains.len() - 1] - end).norm() < 1e-12));
    }
}
