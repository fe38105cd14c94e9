//! Stable values of a gain: every interval, its edges, and the motion that appears at each edge.
//!
//! The sorted growth rates of all motions are continuous functions of the gain. They are sampled on a
//! logarithmic grid. The grid is refined where a rate bends so much that it might reach the limit between
//! samples; edges are then bisected.

use nalgebra::{DMatrix, DVector};

use crate::balance::balance;
use crate::domain::{C64, TimeDomain};
use crate::eigen::{checked_balance, eigen, eigenvalues_of_balanced};
use crate::error::{LtiError, require_finite, require_positive, require_shape};
use crate::search::bisect;

/// Width to which an edge is bracketed, relative to the gain.
const EDGE_WIDTH: f64 = 1e-14;
/// Largest number of bisections of one grid interval in search of a narrow crossing.
const MAX_REFINEMENTS: usize = 16;
/// A motion whose growth rate is within this many roundings of the limit is marginal.
const MARGINAL_ROUNDINGS: f64 = 16.0;

/// Range and resolution of a search for stable gains.
#[derive(Debug, Clone, PartialEq)]
pub struct GainSearch {
    /// Smallest gain of interest.
    pub lower: f64,
    /// Largest gain of interest; may be infinite.
    pub upper: f64,
    /// A gain with a noticeable effect on the loop: the centre of the logarithmic grid.
    pub scale: f64,
    /// Decades of the grid above and below `scale`. An infinite search ends at scale * 10^decades.
    pub decades: u32,
    /// Grid points in each decade, before refinement.
    pub points_per_decade: u32,
    /// Motions that grow more slowly than this count as stable, 1/s. Usually zero. Machines without damping
    /// are marginal at every gain; for them a small positive number finds the gain at which motions begin to
    /// grow.
    pub growth_limit_per_s: f64,
}

impl GainSearch {
    /// All gains from zero, around a typical one.
    ///
    /// # Errors
    /// [`LtiError::OutOfRange`] unless the scale is positive and finite.
    pub fn non_negative(scale: f64) -> Result<Self, LtiError> {
        require_positive("gain scale", scale)?;
        Ok(Self {
            lower: 0.0,
            upper: f64::INFINITY,
            scale,
            decades: 8,
            points_per_decade: 24,
            growth_limit_per_s: 0.0,
        })
    }

    /// Grid of gains, rising, from `lower` to `upper`.
    fn grid(&self) -> Result<Vec<f64>, LtiError> {
        require_positive("gain scale", self.scale)?;
        if self.lower.is_nan() || self.upper.is_nan() || self.lower > self.upper {
            return Err(LtiError::OutOfRange {
                quantity: "largest gain",
                value: self.upper,
                range: "[smallest gain, inf]",
            });
        }
        let half = i64::from(self.decades) * i64::from(self.points_per_decade);
        let magnitude =
            |i: i64| self.scale * 10_f64.powf(i as f64 / f64::from(self.points_per_decade.max(1)));
        let ends = (self.lower.max(-magnitude(half)), self.upper.min(magnitude(half)));
        let mut grid: Vec<f64> = (-half..=half).rev().map(|i| -magnitude(i)).collect();
        grid.push(0.0);
        grid.extend((-half..=half).map(magnitude));
        grid.retain(|k| *k > ends.0 && *k < ends.1);
        grid.insert(0, ends.0);
        grid.push(ends.1);
        grid.dedup();
        Ok(grid)
    }
}

/// A loop whose state matrix depends on a gain k as A(k) = A0 + k A1.
#[derive(Debug, Clone, PartialEq)]
pub struct AffineLoop<T: TimeDomain> {
    a0: DMatrix<f64>,
    a1: DMatrix<f64>,
    domain: T,
}

impl<T: TimeDomain> AffineLoop<T> {
    /// A loop from its two matrices (n x n).
    ///
    /// # Errors
    /// [`LtiError::Shape`] or [`LtiError::NotFinite`].
    pub fn new(a0: DMatrix<f64>, a1: DMatrix<f64>, domain: T) -> Result<Self, LtiError> {
        let n = a0.nrows();
        require_shape("A0", &a0, (n, n))?;
        require_shape("A1", &a1, (n, n))?;
        require_finite("A0", &a0)?;
        require_finite("A1", &a1)?;
        Ok(Self { a0, a1, domain })
    }

    /// The loop u = -k y around a system with one input and one output, and without feed-through.
    ///
    /// # Errors
    /// [`LtiError::Shape`]; [`LtiError::OutOfRange`] if D is not zero, since A is then not affine in the
    /// gain.
    pub fn negative_feedback(system: &crate::state_space::StateSpace<T>) -> Result<Self, LtiError> {
        system.require_siso()?;
        let d = system.d()[(0, 0)];
        if d.abs() > 0.0 {
            return Err(LtiError::OutOfRange {
                quantity: "feed-through of the loop",
                value: d,
                range: "[0, 0]",
            });
        }
        Self::new(system.a().clone(), -(system.b() * system.c()), system.domain())
    }

    /// A(k).
    pub fn at(&self, gain: f64) -> DMatrix<f64> {
        &self.a0 + &self.a1 * gain
    }

    /// The time domain.
    pub fn domain(&self) -> T {
        self.domain
    }

    /// The gain at which both matrices have equal weight, a natural scale for [`GainSearch`].
    pub fn gain_scale(&self) -> f64 {
        let balanced = balance(&self.a0);
        let n = self.a0.nrows();
        let a1 = DMatrix::from_fn(n, n, |i, j| self.a1[(i, j)] * balanced.scale[j] / balanced.scale[i]);
        let ratio = balanced.matrix.norm() / a1.norm();
        if ratio.is_finite() && ratio > 0.0 { ratio } else { 1.0 }
    }

    /// Every interval of stable gains in [0, infinity).
    ///
    /// # Errors
    /// [`LtiError::EigenvaluesNotConverged`].
    pub fn stable_gains(&self) -> Result<StableGains, LtiError> {
        stable_gains(self.domain, |k| self.at(k), &GainSearch::non_negative(self.gain_scale())?)
    }
}

/// An edge of stability.
#[derive(Debug, Clone, PartialEq)]
pub struct GainEdge {
    /// The gain, to about 1e-14 relative if the eigenvalues are that accurate.
    pub gain: f64,
    /// Frequency of the motion that begins to grow, Hz; 0 for a drift, the Nyquist frequency for a motion
    /// that alternates from sample to sample.
    pub frequency_hz: f64,
    /// Eigenvalue of that motion (s or z plane), imaginary part not negative.
    pub eigenvalue: C64,
    /// Eigenvector of that motion, unit 2-norm.
    pub eigenvector: DVector<C64>,
}

/// An interval of stable gains; an edge is `None` at the end of the search.
#[derive(Debug, Clone, PartialEq)]
pub struct StableInterval {
    pub lower: Option<GainEdge>,
    pub upper: Option<GainEdge>,
}

impl StableInterval {
    /// Distance of a gain from the interval; zero inside.
    pub fn distance(&self, gain: f64) -> f64 {
        let below = self.lower.as_ref().map_or(0.0, |edge| edge.gain - gain);
        let above = self.upper.as_ref().map_or(0.0, |edge| gain - edge.gain);
        below.max(above).max(0.0)
    }
}

/// All intervals of stable gains within the search, rising.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StableGains {
    /// The intervals; empty if no gain is stable.
    pub intervals: Vec<StableInterval>,
}

impl StableGains {
    /// The interval that contains a gain, or else the nearest one; `None` if no gain is stable.
    pub fn nearest(&self, gain: f64) -> Option<&StableInterval> {
        self.intervals.iter().min_by(|a, b| a.distance(gain).total_cmp(&b.distance(gain)))
    }
}

/// Growth rates at one gain.
pub(crate) struct Sample {
    gain: f64,
    /// Excess over the limit, falling; values within rounding are exactly zero.
    excess: Vec<f64>,
}

impl Sample {
    /// Motions that grow.
    pub(crate) fn unstable(&self) -> usize {
        self.excess.iter().filter(|excess| **excess > 0.0).count()
    }

    pub(crate) fn is_stable(&self) -> bool {
        self.excess.first().is_none_or(|&e| e < 0.0)
    }

    fn is_marginal(&self) -> bool {
        self.excess.first().is_some_and(|&e| e.abs() <= 0.0)
    }
}

/// Every interval of stable gains of a loop given by its state matrix as a function of the gain.
///
/// A gain at which the matrix is not finite counts as unstable.
///
/// # Errors
/// [`LtiError::OutOfRange`] for a search without extent; the errors of [`eigenvalues`](crate::eigenvalues)
/// for the matrices.
///
/// # Example
/// ```
/// use feeler_lti::{Continuous, GainSearch, stable_gains};
/// use nalgebra::dmatrix;
/// // s^3 + 2 s^2 + s + k is stable for 0 < k < 2 and oscillates at 1 rad/s beyond.
/// let a = |k: f64| dmatrix![0.0, 1.0, 0.0; 0.0, 0.0, 1.0; -k, -1.0, -2.0];
/// let stable = stable_gains(Continuous, a, &GainSearch::non_negative(1.0)?)?;
/// let edge = stable.intervals[0].upper.as_ref().expect("bounded");
/// assert!((edge.gain - 2.0).abs() < 1e-12);
/// assert!((edge.frequency_hz - 1.0 / std::f64::consts::TAU).abs() < 1e-12);
/// # Ok::<(), feeler_lti::LtiError>(())
/// ```
pub fn stable_gains<T: TimeDomain>(
    domain: T,
    closed_loop: impl Fn(f64) -> DMatrix<f64>,
    search: &GainSearch,
) -> Result<StableGains, LtiError> {
    let sample = |gain: f64| {
        let a = closed_loop(gain);
        // Lifted over many periods, an unstable loop overflows.
        if a.iter().all(|v| v.is_finite()) {
            sample_growth(domain, &a, gain, search.growth_limit_per_s)
        } else {
            Ok(Sample { gain, excess: vec![f64::INFINITY] })
        }
    };
    let grid = search.grid()?;
    let mut samples = vec![sample(grid[0])?];
    for &gain in &grid[1..] {
        let next = sample(gain)?;
        if let Some(previous) = samples.pop() {
            refine(&sample, previous, &next, MAX_REFINEMENTS, &mut samples)?;
        }
        samples.push(next);
    }
    // A pole that approaches the border as the gain grows without bound is finally within rounding of it.
    // Beyond that, stability cannot be decided; it is not an edge.
    if search.upper.is_infinite()
        && let Some(last_told) = samples.iter().rposition(|sample| !sample.is_marginal())
        && samples[last_told].is_stable()
    {
        samples.truncate(last_told + 1);
    }
    let edge = |inside: &Sample, outside: &Sample| -> Result<GainEdge, LtiError> {
        let gain = if outside.is_marginal() {
            outside.gain
        } else {
            let (a, b) = if inside.gain < outside.gain {
                (inside.gain, outside.gain)
            } else {
                (outside.gain, inside.gain)
            };
            bisect(a, b, EDGE_WIDTH, |k| Ok(if sample(k)?.is_stable() { -1.0 } else { 1.0 }))?
        };
        describe_edge(domain, &closed_loop(gain), gain, search.growth_limit_per_s)
    };
    let mut intervals = Vec::new();
    let mut lower: Option<Option<GainEdge>> = samples[0].is_stable().then_some(None);
    for pair in samples.windows(2) {
        match (pair[0].is_stable(), pair[1].is_stable()) {
            (false, true) => lower = Some(Some(edge(&pair[1], &pair[0])?)),
            (true, false) => {
                let upper = Some(edge(&pair[0], &pair[1])?);
                intervals.push(StableInterval { lower: lower.take().flatten(), upper });
            }
            _ => {}
        }
    }
    if let Some(lower) = lower {
        intervals.push(StableInterval { lower, upper: None });
    }
    Ok(StableGains { intervals })
}

pub(crate) fn sample_growth<T: TimeDomain>(
    domain: T,
    a: &DMatrix<f64>,
    gain: f64,
    limit: f64,
) -> Result<Sample, LtiError> {
    let balanced = checked_balance(a)?;
    let poles = eigenvalues_of_balanced(&balanced)?;
    // Rounding of an eigenvalue is relative to order and norm of the balanced matrix. In the z plane a growth
    // rate is ln |z| / T, and the norm counts as at least 1, the modulus on the border. For lifted periods
    // the norm may be many decades larger.
    let nyquist = domain.nyquist_rad_per_s();
    let norm = balanced.matrix.norm();
    let unit = |pole: C64| {
        if nyquist.is_finite() {
            nyquist / std::f64::consts::PI * norm.max(1.0) / pole.norm().max(1.0)
        } else {
            norm
        }
    };
    #[expect(clippy::cast_precision_loss, reason = "orders are far below 2^52")]
    let roundings = MARGINAL_ROUNDINGS * a.nrows() as f64 * f64::EPSILON;
    let beyond_rounding = |pole: C64| {
        let excess = domain.growth_per_s(pole) - limit;
        if excess.abs() <= roundings * unit(pole) { 0.0 } else { excess }
    };
    let mut excess: Vec<f64> = poles.into_iter().map(beyond_rounding).collect();
    excess.sort_by(|a, b| b.total_cmp(a));
    Ok(Sample { gain, excess })
}

/// Pushes `left` and the points needed between it and `right`, rising.
fn refine(
    sample: &impl Fn(f64) -> Result<Sample, LtiError>,
    left: Sample,
    right: &Sample,
    depth: usize,
    out: &mut Vec<Sample>,
) -> Result<(), LtiError> {
    let middle = sample(0.5 * (left.gain + right.gain))?;
    // A growth rate that bends by more than its distance from the limit may cross it twice between samples.
    // Rates of matrices with different orders cannot be compared, and -inf (a pole at z = 0) is never near
    // the limit.
    let suspicious = left.excess.iter().zip(&middle.excess).zip(&right.excess).any(|((l, m), r)| {
        let bend = (m - 0.5 * (l + r)).abs();
        let distance = l.abs().min(m.abs()).min(r.abs());
        distance > 0.0 && distance < 2.0 * bend && bend.is_finite()
    });
    if suspicious && depth > 0 {
        refine(sample, left, &middle, depth - 1, out)?;
        refine(sample, middle, right, depth - 1, out)
    } else {
        out.push(left);
        out.push(middle);
        Ok(())
    }
}

fn describe_edge<T: TimeDomain>(
    domain: T,
    a: &DMatrix<f64>,
    gain: f64,
    limit: f64,
) -> Result<GainEdge, LtiError> {
    let found = eigen(a)?;
    let distance = |v: &C64| (domain.growth_per_s(*v) - limit).abs();
    let candidates = found.values.iter().zip(&found.vectors).filter(|(v, _)| v.im >= 0.0);
    let (value, vector) = candidates
        .min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)))
        .ok_or(LtiError::EigenvaluesNotConverged { order: a.nrows() })?;
    let frequency_hz = domain.s_of_point(*value).im.abs() / std::f64::consts::TAU;
    Ok(GainEdge { gain, frequency_hz, eigenvalue: *value, eigenvector: vector.clone() })
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use nalgebra::dmatrix;

    use super::*;
    use crate::domain::Discrete;

    #[test]
    fn regress_a_loop_lifted_over_many_periods_is_not_searched_for_what_rounding_makes_of_it() {
        // Forty samples of x' = (1 - k) x beside a lag. Eigenvalues grow with the fortieth power of the gain,
        // and rounding of the large ones hides the others.
        let count = Cell::new(0);
        let lifted = |k: f64| {
            count.set(count.get() + 1);
            dmatrix![1.0 - k, 0.3, 0.0; 0.0, 0.9, 0.2 * k; 0.1, 0.0, 0.8].pow(40)
        };
        let one = |k: f64| dmatrix![1.0 - k, 0.3, 0.0; 0.0, 0.9, 0.2 * k; 0.1, 0.0, 0.8];
        let search = GainSearch::non_negative(1.0).unwrap();
        let found = stable_gains(Discrete::new(0.04).unwrap(), lifted, &search).unwrap();
        let grid = search.grid().unwrap().len();
        assert!(count.get() < 4 * grid, "{} for {grid}", count.get());
        let edges = |gains: &StableGains| -> Vec<f64> {
            gains
                .intervals
                .iter()
                .flat_map(|i| [&i.lower, &i.upper])
                .flatten()
                .map(|edge| edge.gain)
                .collect()
        };
        let plain = stable_gains(Discrete::new(0.001).unwrap(), one, &search).unwrap();
        let (found, plain) = (edges(&found), edges(&plain));
        assert_eq!(found.len(), plain.len(), "{found:?} {plain:?}");
        // Rounding of an eigenvalue of the fortieth power, as a share of the gain.
        assert!(
            found.iter().zip(&plain).all(|(a, b)| (a - b).abs() <= 1e-9 * b.abs()),
            "{found:?} {plain:?}"
        );
    }
}
