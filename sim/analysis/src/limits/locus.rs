//! Poles of a closed loop as its gain grows, up to the zeros at which branches end.

use feeler_lti::{C64, RootLocus, StateSpace, eigenvalues, root_locus};
use nalgebra::DMatrix;

use crate::error::AnalysisError;

/// How finely a locus is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fineness {
    /// Gains per decade, before refinement where poles move fast.
    per_decade: f64,
    /// Rounds of refinement.
    passes: usize,
    most_gains: usize,
    /// Whether the zeros are exact to machine precision. Otherwise they are accurate enough for a picture.
    exact_zeros: bool,
}

impl Fineness {
    /// For a picture that a user examines.
    pub(crate) const WHOLE: Self = Self { per_decade: 50.0, passes: 3, most_gains: 1200, exact_zeros: true };
    /// For one picture of many in a row.
    pub(crate) const BRIEF: Self = Self { per_decade: 15.0, passes: 1, most_gains: 250, exact_zeros: false };
}

/// A locus begins this far below the largest stable gain and reaches at least this many times beyond it.
const BELOW: f64 = 1e-3;
const BEYOND: f64 = 20.0;
/// It then continues for at most this number of decades, until some branch has come to each zero within this
/// share of the zero's size.
const DECADES: i32 = 4;
const ARRIVED: f64 = 0.02;
/// A locus in the z plane ends when a pole is this far out.
const FAR: f64 = 1e3;
/// Between two gains no pole within the picture moves by more than this share of the picture. Longer steps
/// are divided, into at most [`FINEST`] parts.
const STEP: f64 = 0.02;
const FINEST: f64 = 16.0;
/// Tolerance of matrices, relative to their largest element. Within it they are affine in the gain, and a
/// slope is the product of one column and one row.
const AFFINE: f64 = 1e-10;
/// Within this tolerance only rounding separates matrices from affine ones.
const EXACT: f64 = 1e-13;
/// The picture extends this many times beyond the oscillating poles at gain zero and the oscillating zeros.
/// Its width is at least this share of its height.
const PICTURE: f64 = 1.5;
const LEAST_WIDTH: f64 = 0.15;
/// If a law loses states as its gain vanishes (integral action does), the locus begins at this share of the
/// largest stable gain.
const NEXT_TO_NONE: f64 = 1e-9;

/// Poles of a closed loop over its gain.
#[derive(Clone, Debug, PartialEq)]
pub struct Locus {
    /// Step of the z plane, s; absent in the s plane.
    pub period_s: Option<f64>,
    /// Gains, rising from zero; from nearly zero if the law loses a state at zero.
    pub gains: Vec<f64>,
    /// One branch for each pole, one point for each gain.
    pub branches: Vec<Vec<C64>>,
    /// Zeros of the loop, at which branches end.
    pub zeros: Vec<C64>,
    /// The gain of the file.
    pub present_gain: f64,
    /// Poles at the present gain.
    pub present: Vec<C64>,
}

/// Follows the poles over the gain. The zeros of the open loop serve if the zeros of the gain itself cannot
/// be found.
pub(crate) fn follow(
    period_s: Option<f64>,
    closed: impl Fn(f64) -> Result<DMatrix<f64>, AnalysisError>,
    open_zeros: impl Fn() -> Vec<C64>,
    present_gain: f64,
    largest: Option<f64>,
    fineness: Fineness,
) -> Result<Locus, AnalysisError> {
    let zero = closed(0.0)?;
    let present = eigenvalues(&closed(present_gain)?)?;
    // A law accepts either every gain or none, and it has accepted zero.
    let plain = |k: f64| closed(k).unwrap_or_else(|_| zero.clone());
    let scale = largest.filter(|k| *k > 0.0).unwrap_or(present_gain.abs().max(f64::MIN_POSITIVE));
    let affine = Affine::new(&plain, scale);
    let zeros =
        affine.as_ref().and_then(|affine| affine.zeros(fineness.exact_zeros)).unwrap_or_else(open_zeros);
    let exact = affine.filter(|affine| affine.is_exact);
    let matrix = |k: f64| exact.as_ref().map_or_else(|| plain(k), |affine| affine.at(k));
    let from = BELOW * scale;
    let mut to = BEYOND * scale.max(present_gain);
    let first = if zero.nrows() == matrix(scale).nrows() { 0.0 } else { NEXT_TO_NONE * scale };
    let poles = eigenvalues(&matrix(first))?;
    // In the s plane very distant zeros look like asymptotes. The z plane is as large as its unit circle.
    let size = poles.iter().chain(&zeros).map(|p| p.norm()).fold(0.0, f64::max);
    for _ in 0..DECADES {
        let ends = eigenvalues(&matrix(to))?;
        let arrived = |z: &C64| ends.iter().any(|p| (p - z).norm() <= ARRIVED * z.norm().max(ARRIVED * size));
        if zeros.iter().all(arrived) {
            break;
        }
        to *= 10.0;
    }
    let count = (fineness.per_decade * (to / from).log10()).ceil();
    let mut gains: Vec<f64> =
        (0..=count as u32).map(|i| from * (to / from).powf(f64::from(i) / count)).collect();
    gains.extend([first, present_gain.max(first)].into_iter().chain(largest));
    gains.sort_by(f64::total_cmp);
    gains.dedup();
    if period_s.is_some() {
        // Powers of the gain, as with a fast loop inside a slow one, move poles so far out that rounding
        // hides the others.
        let near = |k: f64| eigenvalues(&matrix(k)).is_ok_and(|poles| poles.iter().all(|p| p.norm() <= FAR));
        let end = gains.iter().position(|&k| k > scale && !near(k)).unwrap_or(gains.len());
        gains.truncate(end);
    }
    let picture = period_s.map_or_else(|| picture_of(poles.iter().chain(&zeros)), |_| [1.0; 2]);
    let mut traced = root_locus(matrix, &gains)?;
    for _ in 0..fineness.passes {
        let between = long_steps(&traced, picture);
        if between.is_empty() || traced.gains.len() + between.len() > fineness.most_gains {
            break;
        }
        gains.extend(between);
        gains.sort_by(f64::total_cmp);
        traced = root_locus(matrix, &gains)?;
    }
    Ok(Locus { period_s, gains: traced.gains, branches: traced.branches, zeros, present_gain, present })
}

/// A closed loop `rest + k slope`.
struct Affine {
    rest: DMatrix<f64>,
    slope: DMatrix<f64>,
    /// Whether only rounding separates it from the loop itself.
    is_exact: bool,
}

impl Affine {
    /// `None` if the closed loop is not affine in the gain.
    fn new(matrix: &impl Fn(f64) -> DMatrix<f64>, scale: f64) -> Option<Self> {
        let [one, two, three] = [1.0, 2.0, 3.0].map(|times| matrix(times * scale));
        let slope = &two - &one;
        let rest = &one - &slope;
        let departure = (&rest + &slope * 3.0 - &three).amax() / three.amax();
        let is_exact = departure <= EXACT;
        (departure <= AFFINE).then(|| Self { rest, slope: slope / scale, is_exact })
    }

    fn at(&self, gain: f64) -> DMatrix<f64> {
        &self.rest + &self.slope * gain
    }

    /// Zeros at which branches end: those between the point at which the gain acts and the quantity that it
    /// multiplies. All other terms of the law belong to the machine. `None` if the gain acts in several
    /// places.
    fn zeros(&self, exact: bool) -> Option<Vec<C64>> {
        let slope = &self.slope;
        // A column and a row through the largest element: where the gain acts and what it multiplies. Their
        // zeros are exact.
        let (row, column) = slope.iamax_full();
        let largest = slope[(row, column)];
        let (b, c) = (slope.columns(column, 1).into_owned(), slope.rows(row, 1) / largest);
        if largest.abs() <= 0.0 || (&b * &c - slope).amax() > AFFINE * largest.abs() {
            return None;
        }
        let system = StateSpace::new(self.rest.clone(), b, c, DMatrix::zeros(1, 1)).ok()?;
        if exact { system.zeros() } else { system.unpolished_zeros() }.ok()
    }
}

/// Half the width and half the height of the oscillating points, rad/s.
fn picture_of<'a>(points: impl Iterator<Item = &'a C64>) -> [f64; 2] {
    let (mut swinging, mut largest) = ([0.0_f64; 2], 0.0_f64);
    for p in points {
        largest = largest.max(p.norm());
        if p.im.abs() > 1e-9 * p.norm() {
            swinging =
                [swinging[0].max(p.re.abs()).max(LEAST_WIDTH * p.im.abs()), swinging[1].max(p.im.abs())];
        }
    }
    swinging.map(|half| if half > 0.0 { half } else { largest.max(f64::MIN_POSITIVE) })
}

/// Gains that divide the steps in which some pole within the picture moves too far.
fn long_steps(traced: &RootLocus, [width, height]: [f64; 2]) -> Vec<f64> {
    let inside = |p: &C64| p.re.abs() <= PICTURE * width && p.im.abs() <= PICTURE * height;
    let parts = |j: usize| {
        let moves = traced
            .branches
            .iter()
            .map(|branch| (branch[j - 1], branch[j]))
            .filter(|(a, b)| inside(a) || inside(b));
        let lengths = moves.map(|(a, b)| (0.5 * (b - a).re / width).hypot(0.5 * (b - a).im / height));
        (lengths.fold(0.0, f64::max) / STEP).clamp(1.0, FINEST).ceil() as usize
    };
    let divided = (1..traced.gains.len()).flat_map(|j| {
        let (from, to, parts) = (traced.gains[j - 1], traced.gains[j], parts(j));
        (1..parts).map(move |i| from + (to - from) * i as f64 / parts as f64)
    });
    divided.collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::dmatrix;

    use super::*;

    /// Integral action on a mode: at gain zero there is no integrator, at any other gain there is one.
    #[test]
    fn regress_every_branch_is_followed_where_a_state_vanishes_with_the_gain() {
        let closed = |k: f64| {
            let mode = dmatrix![0.0, 1.0; -9.0, -0.6];
            Ok(if k > 0.0 { dmatrix![0.0, 1.0, 0.0; -9.0, -0.6, k; -1.0, 0.0, 0.0] } else { mode })
        };
        let locus = follow(None, closed, Vec::new, 1.0, Some(5.4), Fineness::WHOLE).unwrap();
        assert_eq!(locus.branches.len(), 3);
        for branch in &locus.branches {
            let image = |p: C64| locus.branches.iter().any(|other| (other[0] - p).norm() < 1e-6);
            assert!(image(branch[0].conj()) && (branch[1] - branch[0]).norm() < 0.1, "{:?}", &branch[..2]);
        }
    }

    /// s^3 + (0.6 + d) s^2 + 9 s + k z(s) = 0 with z = s + 2. The damping d is another term of the law and
    /// does not affect the zeros of k.
    #[test]
    fn regress_zeros_are_those_of_the_gain_and_not_of_the_whole_law() {
        let closed = |k: f64| Ok(dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; -2.0 * k, -9.0 - k, -4.6]);
        let elsewhere = vec![C64::new(0.0, 13.0), C64::new(0.0, -13.0)];
        let locus = follow(None, closed, || elsewhere.clone(), 1.0, None, Fineness::WHOLE).unwrap();
        assert!(locus.zeros.len() == 1 && (locus.zeros[0] + 2.0).norm() < 1e-9, "{:?}", locus.zeros);
    }

    /// 1 + k (s^2 + 0.02 s + 4) / (s (s^2 + 0.02 s + 9)): two branches end in the lightly damped zeros, one
    /// leaves along the real axis.
    #[test]
    fn truth_branches_arrive_at_their_zeros_in_short_steps() {
        let zero = C64::new(-0.01, (4.0_f64 - 1e-4).sqrt());
        let closed =
            |k: f64| Ok(dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; -4.0 * k, -9.0 - 0.02 * k, -0.02 - k]);
        let locus = follow(None, closed, || vec![zero, zero.conj()], 0.1, None, Fineness::WHOLE).unwrap();
        let ends: Vec<C64> = locus.branches.iter().map(|branch| branch[branch.len() - 1]).collect();
        assert!(ends.iter().any(|p| (p - zero).norm() < ARRIVED * zero.norm()));
        // The picture is 0.15 times as wide as high, and poles at gain zero lie at 3 rad/s.
        let inside = |p: &C64| p.re.abs() < LEAST_WIDTH * 3.0 && p.im.abs() < 3.0;
        for pair in
            locus.branches.iter().flat_map(|branch| branch.windows(2)).filter(|pair| pair.iter().all(inside))
        {
            let step = pair[1] - pair[0];
            assert!((step.re / (LEAST_WIDTH * 6.0)).hypot(step.im / 6.0) < 2.0 * STEP, "{pair:?}");
        }
    }

    /// A pair that hardly moves, and a pole at k^10, as of a loop ten times as fast as its common period. Far
    /// out, the rounding of that pole would hide the pair.
    #[test]
    fn regress_a_locus_ends_before_a_far_pole_drowns_the_others() {
        let turn = dmatrix![1.0, 2.0, 0.5; -1.0, 1.5, 0.7; 0.3, -0.4, 2.0];
        let back = turn.clone().try_inverse().unwrap();
        let closed = |k: f64| {
            Ok(&turn * dmatrix![0.0, 1.0, 0.0; -0.5 - 0.01 * k, 1.2, 0.0; 0.0, 0.0, k.powi(10)] * &back)
        };
        let locus = follow(Some(1e-3), closed, Vec::new, 0.5, Some(1.0), Fineness::WHOLE).unwrap();
        let last = locus.gains[locus.gains.len() - 1];
        assert!(last > 1.5 && last.powi(10) <= FAR, "{last}");
        for pair in locus
            .branches
            .iter()
            .flat_map(|branch| branch.windows(2))
            .filter(|pair| pair.iter().all(|z| z.norm() < 0.9))
        {
            assert!((pair[1] - pair[0]).norm() < 0.05, "{pair:?}");
        }
    }
}
