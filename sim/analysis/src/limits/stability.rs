//! Stable values of a gain, and the motion that begins to grow at each edge.

use std::f64::consts::TAU;

use feeler_lti::{
    AffineLoop, C64, GainEdge, GainSearch, LtiError, RankOneLoop, StableGains, TimeDomain, eigen,
    eigenvalues, stable_gains,
};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use crate::error::AnalysisError;
use crate::limits::drift::WithoutDrift;
use crate::loops::continuous_loop::ContinuousLoop;
use crate::loops::control_loop::ControlLoop;
use crate::loops::sampled_loop::SampledLoop;
use crate::machine::modes::{VibrationMode, modes};

/// Decades searched above and below the gain at which loop and machine have equal weight.
const DECADES: u32 = 7;
/// Points per decade of the search, before refinement where growth rates bend.
const POINTS_PER_DECADE: u32 = 12;
/// Matrices count as affine in the gain if they depart from a straight line by at most this share of their
/// largest element.
const AFFINE: f64 = 1e-13;
/// From this number of states onwards, the edges of a gain that acts in one place follow from its response.
pub(crate) const MANY_STATES: usize = 32;
/// Growth rates below this cannot be distinguished from zero, 1/s. At gains near zero an integrator's pole
/// lies that close to the limit. Eigenvalues of sampled loops are accurate to 1e-12 per period of at most
/// 1e-3 s.
const TELLING_GROWTH_PER_S: f64 = 1e-7;

/// An edge of stability.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Edge {
    /// Gain at which stability begins or ends.
    pub gain: f64,
    /// Frequency of the motion that begins to grow, Hz. If several rates repeat together, many frequencies
    /// look alike once per common period; this is the one at which the bodies move.
    pub frequency_hz: f64,
    /// Index of the machine's own mode that the motion resembles most. `None` if it resembles none, as with a
    /// rigid body that nothing holds.
    pub mode: Option<usize>,
}

/// An interval of stable gains; an edge at which the search ended is `None`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Band {
    /// Lower edge; `None` if the interval begins at zero.
    pub lower: Option<Edge>,
    /// Upper edge; `None` if the interval has no upper end.
    pub upper: Option<Edge>,
}

/// Every interval of stable gains from zero onwards, rising.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct GainBands {
    /// From zero onwards, rising.
    pub bands: Vec<Band>,
}

/// Every interval of stable gains below zero, rising.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BelowZero {
    /// The intervals; an upper edge is `None` if the interval ends at zero.
    pub(crate) bands: Vec<Band>,
    /// The motion at the limit of stability at gain zero itself.
    pub(crate) at_zero: Edge,
}

impl BelowZero {
    /// No intervals: the result of a search that ends at zero.
    pub(crate) fn not_sought() -> Self {
        Self { bands: Vec::new(), at_zero: Edge { gain: 0.0, frequency_hz: 0.0, mode: None } }
    }

    /// Intervals below zero, from those of the gain with reversed sign, which begin at zero.
    fn mirrored(turned: GainBands, at_zero: Edge) -> Self {
        let negated = |edge: Edge| Edge { gain: -edge.gain, ..edge };
        let bands = turned
            .bands
            .into_iter()
            .rev()
            .map(|band| Band { lower: band.upper.map(negated), upper: band.lower.map(negated) });
        Self { bands: bands.collect(), at_zero }
    }
}

/// The interval that contains a gain, else the nearest one.
pub(crate) fn nearest<'a>(bands: impl Iterator<Item = &'a Band>, gain: f64) -> Option<&'a Band> {
    let distance = |band: &Band| {
        let below = band.lower.as_ref().map_or(0.0, |edge| edge.gain - gain);
        let above = band.upper.as_ref().map_or(0.0, |edge| gain - edge.gain);
        below.max(above).max(0.0)
    };
    bands.min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

impl GainBands {
    /// The interval that contains a gain, else the nearest one; `None` if no gain is stable.
    pub fn nearest(&self, gain: f64) -> Option<&Band> {
        nearest(self.bands.iter(), gain)
    }

    /// Every interval on both sides of zero, rising; intervals that meet at zero are joined.
    pub(crate) fn joined(&self, below: BelowZero) -> Vec<Band> {
        let BelowZero { bands: mut all, at_zero } = below;
        let mut above = self.bands.clone();
        let ends_at_zero = all.last_mut().filter(|band| band.upper.is_none());
        let begins_at_zero = above.first_mut().filter(|band| band.lower.is_none());
        match (ends_at_zero, begins_at_zero) {
            (Some(low), Some(_)) => low.upper = above.remove(0).upper,
            (Some(low), None) => low.upper = Some(at_zero),
            (None, Some(high)) => high.lower = Some(at_zero),
            (None, None) => {}
        }
        all.append(&mut above);
        all
    }

    /// The largest stable gain of the first interval: zero if no gain is stable, `None` if it has no end.
    pub(crate) fn largest(&self) -> Option<f64> {
        self.bands.first().map_or(Some(0.0), |band| band.upper.as_ref().map(|edge| edge.gain))
    }

    /// The first edge as the gain rises from zero: infinite if there is none, zero if no gain is stable.
    pub fn first_upper(&self) -> f64 {
        self.bands.first().map_or(0.0, |band| band.upper.as_ref().map_or(f64::INFINITY, |edge| edge.gain))
    }
}

impl ControlLoop {
    /// Stable values from zero onwards, in the sampled loop, of the gain with this key. Edges are exact to
    /// about 1e-12.
    ///
    /// # Errors
    /// [`AnalysisError::NoController`], [`AnalysisError::NoGain`], [`AnalysisError::Rates`],
    /// [`AnalysisError::Lti`].
    pub fn sampled_bands(&self, key: &str) -> Result<GainBands, AnalysisError> {
        let (controller, gain) = self.gain_of_key(key)?;
        if let Some(bands) = self.late_bands(controller, &gain, 1.0)? {
            return Ok(bands);
        }
        let sampled = SampledLoop::new(self)?;
        let matrix = |k: f64| sampled.closed_loop_with(controller, &gain, k);
        self.bands(sampled.domain()?, matrix, sampled.expand(), sampled.alias_s())
    }

    /// The new gain of a sampled edge at `edge_hz` after a small change of the machine. `None` for loops with
    /// few states or several rates, and if no edge is near.
    pub(crate) fn edge_near(&self, key: &str, edge_hz: f64) -> Result<Option<f64>, AnalysisError> {
        let (controller, gain) = self.gain_of_key(key)?;
        let Ok(sampled) = SampledLoop::new(self) else { return Ok(None) };
        let matrix = |k: f64| sampled.closed_loop_with(controller, &gain, k);
        let Ok(low) = matrix(2.0) else { return Ok(None) };
        if low.nrows() < MANY_STATES || sampled.alias_s().is_some() || edge_hz <= 0.0 {
            return Ok(None);
        }
        let (middle, high) = (matrix(4.0)?, matrix(6.0)?);
        let slope = (&middle - &low) / 2.0;
        let zero = &low - &slope * 2.0;
        let affine = (&zero + &slope * 6.0 - &high).amax() <= AFFINE * high.amax();
        let one_place = affine.then(|| RankOneLoop::new(sampled.domain().ok()?, &zero, &slope)).flatten();
        Ok(one_place
            .and_then(|found| found.gain_near(TAU * edge_hz).ok().flatten())
            .filter(|gain| *gain > 0.0))
    }

    /// Stable values from zero onwards, in the continuous loop, of the gain with this key.
    ///
    /// # Errors
    /// As [`Self::sampled_bands`], and [`AnalysisError::Improper`].
    pub fn continuous_bands(&self, key: &str) -> Result<GainBands, AnalysisError> {
        let (controller, gain) = self.gain_of_key(key)?;
        let continuous = ContinuousLoop::new(self)?;
        let matrix = |k: f64| continuous.closed_loop_with(controller, &gain, k);
        self.bands(feeler_lti::Continuous, matrix, continuous.expand(), None)
    }

    /// Every interval of stable values of a gain in the sampled loop, on both sides of zero, rising.
    ///
    /// # Errors
    /// As [`Self::sampled_bands`].
    pub fn sampled_intervals(&self, key: &str) -> Result<Vec<Band>, AnalysisError> {
        Ok(self.sampled_bands(key)?.joined(self.sampled_bands_below_zero(key)?))
    }

    /// Every interval of stable values of a gain in the continuous loop, on both sides of zero, rising.
    ///
    /// # Errors
    /// As [`Self::continuous_bands`].
    pub fn continuous_intervals(&self, key: &str) -> Result<Vec<Band>, AnalysisError> {
        Ok(self.continuous_bands(key)?.joined(self.continuous_bands_below_zero(key)?))
    }

    /// Stable values below zero of a gain in the sampled loop; empty if the law allows none.
    ///
    /// # Errors
    /// As [`Self::sampled_bands`].
    pub(crate) fn sampled_bands_below_zero(&self, key: &str) -> Result<BelowZero, AnalysisError> {
        let (controller, gain) = self.gain_of_key(key)?;
        let mirrored = match self.late_bands(controller, &gain, -1.0) {
            Err(AnalysisError::Control(_)) => Some(GainBands::default()),
            other => other?,
        };
        if let Some(mirrored) = mirrored {
            // If everything else decays, the remaining motion is that of the integrator with vanishing gain.
            return Ok(BelowZero::mirrored(mirrored, Edge { gain: 0.0, frequency_hz: 0.0, mode: None }));
        }
        let sampled = SampledLoop::new(self)?;
        let matrix = |k: f64| sampled.closed_loop_with(controller, &gain, k);
        self.bands_below_zero(sampled.domain()?, matrix, sampled.expand(), sampled.alias_s())
    }

    /// Stable values below zero of a gain in the continuous loop; empty if the law allows none.
    ///
    /// # Errors
    /// As [`Self::continuous_bands`].
    pub(crate) fn continuous_bands_below_zero(&self, key: &str) -> Result<BelowZero, AnalysisError> {
        let (controller, gain) = self.gain_of_key(key)?;
        let continuous = ContinuousLoop::new(self)?;
        let matrix = |k: f64| continuous.closed_loop_with(controller, &gain, k);
        self.bands_below_zero(feeler_lti::Continuous, matrix, continuous.expand(), None)
    }

    fn bands_below_zero<T: TimeDomain>(
        &self,
        domain: T,
        matrix: impl Fn(f64) -> Result<DMatrix<f64>, AnalysisError>,
        expand: &DMatrix<f64>,
        alias_s: Option<f64>,
    ) -> Result<BelowZero, AnalysisError> {
        let mirrored = match self.bands(domain, |k| matrix(-k), expand, alias_s) {
            // A mass or a stiffness has no values below zero.
            Err(AnalysisError::Control(_)) => GainBands::default(),
            other => other?,
        };
        Ok(BelowZero::mirrored(mirrored, self.at_zero(domain, matrix(0.0).ok(), expand, alias_s)?))
    }

    /// The motion at the limit of stability at gain zero.
    fn at_zero<T: TimeDomain>(
        &self,
        domain: T,
        matrix: Option<DMatrix<f64>>,
        expand: &DMatrix<f64>,
        alias_s: Option<f64>,
    ) -> Result<Edge, AnalysisError> {
        let none = Edge { gain: 0.0, frequency_hz: 0.0, mode: None };
        let Some(matrix) = matrix.filter(|m| m.iter().all(|v| v.is_finite())) else { return Ok(none) };
        let found = eigen(&matrix)?;
        let distance = |p: C64| domain.growth_per_s(p).abs();
        let upper = (0..found.values.len()).filter(|&i| found.values[i].im >= 0.0);
        let nearest = upper.min_by(|&i, &j| distance(found.values[i]).total_cmp(&distance(found.values[j])));
        let Some(i) = nearest else { return Ok(none) };
        let mode = self.most_alike(&modes(self.plant())?, &found.vectors[i], expand);
        Ok(Edge {
            frequency_hz: self.frequency_hz(domain, found.values[i], &found.vectors[i], expand, alias_s),
            mode,
            ..none
        })
    }

    pub(crate) fn bands<T: TimeDomain>(
        &self,
        domain: T,
        matrix: impl Fn(f64) -> Result<DMatrix<f64>, AnalysisError>,
        expand: &DMatrix<f64>,
        alias_s: Option<f64>,
    ) -> Result<GainBands, AnalysisError> {
        // Errors do not depend on the value of the gain, so these calls find them all. The exceptions are
        // loops without a solution at single gains. One example is an impedance with force gain -1, which
        // does not respond to motion. So the gain must not have size one.
        let (unit, [low, middle, high]) = finite_unit(&matrix)?;
        let slope = (&middle - &low) / (2.0 * unit);
        let zero = &low - &slope * (2.0 * unit);
        let affine = (&zero + &slope * (6.0 * unit) - &high).amax() <= AFFINE * high.amax();
        let (zero, slope) = if affine { without_idle(&zero, &slope, expand.ncols()) } else { (zero, slope) };
        let rest = affine.then(|| {
            WithoutDrift::new(zero.clone(), slope.clone(), domain.point_of_s(C64::new(0.0, 0.0)).re)
        });
        let (zero, slope) = rest.as_ref().map_or((&zero, &slope), |rest| (&rest.zero, &rest.slope));
        let scale = AffineLoop::new(zero.clone(), slope.clone(), domain)?.gain_scale();
        let at = |k: f64| if affine { zero + slope * k } else { matrix(k).unwrap_or_else(|_| low.clone()) };
        let lower = smallest_telling(domain, &at, scale)?;
        let search = GainSearch {
            lower,
            decades: DECADES,
            points_per_decade: POINTS_PER_DECADE,
            ..GainSearch::non_negative(scale)?
        };
        let many = affine && zero.nrows() >= MANY_STATES;
        let one_place = many.then(|| RankOneLoop::new(domain, zero, slope)).flatten();
        let quick = one_place.and_then(|found| found.stable_gains(&search).ok().flatten());
        let stable: StableGains = quick.map_or_else(|| stable_gains(domain, at, &search), Ok)?;
        let has_edges = stable.intervals.iter().any(|i| i.lower.is_some() || i.upper.is_some());
        let own = if has_edges { modes(self.plant())? } else { Vec::new() };
        let edge = |edge: GainEdge| {
            let vector = rest.as_ref().map(|rest| rest.whole(edge.gain, edge.eigenvalue, &edge.eigenvector));
            let vector = vector.as_ref().unwrap_or(&edge.eigenvector);
            let mode = self.most_alike(&own, vector, expand);
            Edge {
                gain: edge.gain,
                frequency_hz: self.frequency_hz(domain, edge.eigenvalue, vector, expand, alias_s),
                mode,
            }
        };
        let bands =
            stable.intervals.into_iter().map(|i| Band { lower: i.lower.map(edge), upper: i.upper.map(edge) });
        Ok(GainBands { bands: bands.collect() })
    }

    /// Frequency of a motion of the loop, Hz. If several rates repeat together every `alias_s`, the frequency
    /// at which the bodies move.
    fn frequency_hz<T: TimeDomain>(
        &self,
        domain: T,
        value: C64,
        vector: &DVector<C64>,
        expand: &DMatrix<f64>,
        alias_s: Option<f64>,
    ) -> f64 {
        match alias_s {
            Some(period_s) => self.unfolded_hz(value.arg() / TAU, vector, expand, period_s),
            None => domain.s_of_point(value).im.abs() / TAU,
        }
    }

    /// The frequency at which the bodies move, among all frequencies with the same phase per period. The
    /// ratio of the speeds to the positions of the bodies gives it roughly, with its sign.
    fn unfolded_hz(&self, turns: f64, vector: &DVector<C64>, expand: &DMatrix<f64>, period_s: f64) -> f64 {
        let motion = of_machine(vector, expand);
        let (coordinates, layout) = (self.plant().motion().coordinates(), self.plant().motion().layout());
        let (mut spin, mut size) = (0.0, 0.0);
        for g in 0..coordinates.count() {
            let (q, v) = (motion[layout.q(g)], motion[layout.v(g)]);
            spin += coordinates.mass_kg(g) * (q.conj() * v).im;
            size += coordinates.mass_kg(g) * q.norm_sqr();
        }
        let whole = if size > 0.0 { (spin / size / TAU * period_s - turns).round() } else { 0.0 };
        ((turns + whole) / period_s).abs()
    }

    /// The mode whose shape has the largest modal assurance with the machine's part of a motion of the loop.
    /// `None` if most of the motion belongs to no mode, as with a machine that nothing holds.
    pub(crate) fn most_alike(
        &self,
        own: &[VibrationMode],
        vector: &DVector<C64>,
        expand: &DMatrix<f64>,
    ) -> Option<usize> {
        let motion = of_machine(vector, expand);
        let coordinates = self.plant().motion().coordinates();
        // In units of kinetic energy, so that light bodies do not outweigh heavy ones.
        let weighted = |v: &DVector<C64>| {
            DVector::from_fn(coordinates.count(), |g, _| {
                v[self.plant().motion().layout().q(g)] * coordinates.mass_kg(g).sqrt()
            })
        };
        let motion = weighted(&motion);
        let likeness = |mode: &VibrationMode| {
            let shape = weighted(&mode.vector);
            shape.dotc(&motion).norm_sqr() / (shape.norm_squared() * motion.norm_squared())
        };
        let alike: Vec<f64> = own.iter().map(likeness).collect();
        let best = (0..own.len()).max_by(|&i, &j| alike[i].total_cmp(&alike[j]))?;
        // Shapes are orthogonal in kinetic energy except for damping. The remainder of the motion belongs to
        // no oscillating mode.
        let elsewhere = 1.0 - alike.iter().sum::<f64>();
        (alike[best] > elsewhere).then_some(best)
    }
}

/// The machine's part of a motion of the loop.
fn of_machine(vector: &DVector<C64>, expand: &DMatrix<f64>) -> DVector<C64> {
    expand.map(|v| C64::new(v, 0.0)) * vector.rows(0, expand.ncols())
}

/// The largest power of ten, up to one, whose multiples by 2, 4 and 6 all give finite matrices, with these
/// matrices. An unstable loop lifted over thousands of periods overflows, and one with direct feed-through
/// has no solution at single gains.
fn finite_unit(
    matrix: &impl Fn(f64) -> Result<DMatrix<f64>, AnalysisError>,
) -> Result<(f64, [DMatrix<f64>; 3]), AnalysisError> {
    let at = |unit: f64| Ok([matrix(2.0 * unit)?, matrix(4.0 * unit)?, matrix(6.0 * unit)?]);
    for decade in 0..=i32::try_from(DECADES).unwrap_or(i32::MAX) {
        let unit = 10_f64.powi(-decade);
        match at(unit) {
            Err(AnalysisError::Lti(LtiError::AlgebraicLoop)) => {}
            Err(error) => return Err(error),
            Ok(found) if found[2].iter().all(|v| v.is_finite()) => return Ok((unit, found)),
            Ok(_) => {}
        }
    }
    Ok((1.0, at(1.0)?))
}

/// The smallest gain of the search at which stability can be decided; zero if there is none.
fn smallest_telling<T: TimeDomain>(
    domain: T,
    at: &impl Fn(f64) -> DMatrix<f64>,
    scale: f64,
) -> Result<f64, AnalysisError> {
    let decades = i32::try_from(DECADES).unwrap_or(i32::MAX);
    for decade in -decades..=decades {
        let gain = scale * 10_f64.powi(decade);
        let matrix = at(gain);
        if matrix.iter().any(|v| !v.is_finite()) {
            return Ok(0.0);
        }
        let growth = eigenvalues(&matrix)?
            .into_iter()
            .map(|p| domain.growth_per_s(p))
            .fold(f64::NEG_INFINITY, f64::max);
        if growth.abs() > TELLING_GROWTH_PER_S {
            return Ok(gain);
        }
    }
    Ok(0.0)
}

/// Both matrices without those states from `first` onwards that do not affect anything: held outputs that are
/// overwritten before they act. Each is an eigenvalue at exactly zero, and its rounding would mislead the
/// search.
fn without_idle(zero: &DMatrix<f64>, slope: &DMatrix<f64>, first: usize) -> (DMatrix<f64>, DMatrix<f64>) {
    let mut kept: Vec<usize> = (0..zero.ncols()).collect();
    loop {
        let acts = |j: usize| kept.iter().any(|&i| zero[(i, j)] != 0.0 || slope[(i, j)] != 0.0);
        let left: Vec<usize> = kept.iter().copied().filter(|&j| j < first || acts(j)).collect();
        if left.len() == kept.len() {
            let part = |m: &DMatrix<f64>| m.select_rows(&kept).select_columns(&kept);
            return (part(zero), part(slope));
        }
        kept = left;
    }
}
