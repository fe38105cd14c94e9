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

/// Poles over a gain, each branch continuous.
#[derive(Debug, Clone, PartialEq)]
pub struct RootLocus {
    /// The gains.
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
    let clear = matched.iter().enumerate().all(|(i, to)| {
        let others =
            from.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| (other - from[i]).norm());
        (to - from[i]).norm() <= CLEAR_MOVE * others.fold(f64::INFINITY, f64::min)
    });
    if clear || halvings == 0 {
        return Ok(matched);
    }
    let middle = 0.5 * (start + end);
    let half_way = advance(poles, from, (start, middle), halvings - 1)?;
    advance(poles, &half_way, (middle, end), halvings - 1)
}
