//! Poles of a closed loop followed over its gain, as far as its zeros.

use feeler_lti::{C64, RootLocus, eigenvalues, root_locus};
use nalgebra::DMatrix;

use crate::error::AnalysisError;

/// Gains of a locus in each decade, before it is refined where poles move fast.
const GAINS_PER_DECADE: f64 = 50.0;
/// A locus begins this far below the largest stable gain and reaches at least this many times beyond it...
const BELOW: f64 = 1e-3;
const BEYOND: f64 = 20.0;
/// ...and on, in steps of a decade up to so many, until some branch has come to each zero within this share of the zero's size.
const DECADES: i32 = 7;
const ARRIVED: f64 = 0.02;
/// From one gain to the next no pole within the picture moves farther than this share of its size, if halving the step so often helps.
const STEP: f64 = 0.04;
const HALVINGS: usize = 5;
const MOST_GAINS: usize = 1500;
/// The picture reaches this many times farther than poles at gain zero and zeros.
const PICTURE: f64 = 3.0;

/// Poles of a closed loop over its gain.
#[derive(Clone, Debug, PartialEq)]
pub struct Locus {
    /// Step of the z plane, s; absent in the s plane.
    pub period_s: Option<f64>,
    /// Rising from zero.
    pub gains: Vec<f64>,
    /// One branch for each pole, one point for each gain.
    pub branches: Vec<Vec<C64>>,
    /// Where branches end.
    pub zeros: Vec<C64>,
    /// The gain of the file.
    pub present_gain: f64,
    /// Poles at it.
    pub present: Vec<C64>,
}

impl Locus {
    /// The point of the s plane that belongs to a point of the locus, rad/s.
    pub fn s_of(&self, point: C64) -> C64 {
        self.period_s.map_or(point, |period_s| point.ln() / period_s)
    }
}

/// Follows the poles over the gain.
pub(crate) fn follow(
    period_s: Option<f64>,
    closed: impl Fn(f64) -> Result<DMatrix<f64>, AnalysisError>,
    zeros: Vec<C64>,
    present_gain: f64,
    largest: Option<f64>,
) -> Result<Locus, AnalysisError> {
    let zero = closed(0.0)?;
    let present = eigenvalues(&closed(present_gain)?)?;
    // Whether a gain exists does not depend on its value, and zero has been tried.
    let matrix = |k: f64| closed(k).unwrap_or_else(|_| zero.clone());
    let scale = largest.filter(|k| *k > 0.0).unwrap_or(present_gain.abs().max(f64::MIN_POSITIVE));
    let from = BELOW * scale;
    let mut to = BEYOND * scale.max(present_gain);
    let poles = eigenvalues(&zero)?;
    // Of the s plane, where zeros far out are asymptotes to the eye; the z plane is as large as its unit circle.
    let size = poles.iter().chain(&zeros).map(|p| p.norm()).fold(0.0, f64::max);
    for _ in 0..DECADES {
        let ends = eigenvalues(&matrix(to))?;
        let arrived = |z: &C64| ends.iter().any(|p| (p - z).norm() <= ARRIVED * z.norm().max(ARRIVED * size));
        if zeros.iter().all(arrived) {
            break;
        }
        to *= 10.0;
    }
    let count = (GAINS_PER_DECADE * (to / from).log10()).ceil();
    let mut gains: Vec<f64> = (0..=count as u32).map(|i| from * (to / from).powf(f64::from(i) / count)).collect();
    gains.extend([0.0, present_gain.max(0.0)].into_iter().chain(largest));
    gains.sort_by(f64::total_cmp);
    gains.dedup();
    let mut traced = root_locus(matrix, &gains)?;
    for _ in 0..HALVINGS {
        let between = long_steps(&traced, PICTURE * size);
        if between.is_empty() || traced.gains.len() + between.len() > MOST_GAINS {
            break;
        }
        gains.extend(between);
        gains.sort_by(f64::total_cmp);
        traced = root_locus(matrix, &gains)?;
    }
    Ok(Locus { period_s, gains: traced.gains, branches: traced.branches, zeros, present_gain, present })
}

/// Gains in the middle of steps in which some pole within the picture moves far.
fn long_steps(traced: &RootLocus, reach: f64) -> Vec<f64> {
    let is_long = |j: usize| {
        traced.branches.iter().map(|branch| (branch[j - 1], branch[j])).any(|(a, b)| {
            let size = a.norm().min(b.norm());
            size <= reach && (b - a).norm() > STEP * size.max(STEP * reach)
        })
    };
    (1..traced.gains.len()).filter(|&j| is_long(j)).map(|j| 0.5 * (traced.gains[j - 1] + traced.gains[j])).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::dmatrix;

    use super::*;

    #[test]
    fn truth_points_of_the_z_plane_have_their_frequency() {
        let locus = Locus {
            period_s: Some(1e-3),
            gains: Vec::new(),
            branches: Vec::new(),
            zeros: Vec::new(),
            present_gain: 1.0,
            present: Vec::new(),
        };
        let s = C64::new(-20.0, 300.0);
        assert!((locus.s_of((s * 1e-3).exp()) - s).norm() < 1e-9);
    }

    /// 1 + k (s^2 + 0.02 s + 4) / (s (s^2 + 0.02 s + 9)): two branches run into the lightly damped zeros, one away along the real axis.
    #[test]
    fn truth_branches_arrive_at_their_zeros_in_short_steps() {
        let zero = C64::new(-0.01, (4.0_f64 - 1e-4).sqrt());
        let closed = |k: f64| Ok(dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; -4.0 * k, -9.0 - 0.02 * k, -0.02 - k]);
        let locus = follow(None, closed, vec![zero, zero.conj()], 0.1, None).unwrap();
        let ends: Vec<C64> = locus.branches.iter().map(|branch| branch[branch.len() - 1]).collect();
        assert!(ends.iter().any(|p| (p - zero).norm() < ARRIVED * zero.norm()));
        for branch in &locus.branches {
            let near = branch.windows(2).filter(|pair| pair[0].norm() < 6.0 && pair[1].norm() < 6.0);
            assert!(near.map(|pair| (pair[1] - pair[0]).norm()).fold(0.0, f64::max) < 0.3);
        }
    }
}
