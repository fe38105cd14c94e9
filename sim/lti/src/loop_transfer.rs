//! The frequency response of an open loop, sampled as finely as resonances, crossings and delay require.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::domain::{C64, Continuous, Discrete, TimeDomain};
use crate::error::{LtiError, require_not_negative};
use crate::polish::MANY_STATES;
use crate::response::TransferEvaluator;
use crate::state_space::StateSpace;

/// Neighbouring points of the sampled response differ by less than this in ln L and ln(1 + L): 8 degrees or
/// 15 % each.
const LOG_STEP: f64 = 0.15;
/// Neighbouring frequencies closer than this relative distance are not split: there is a pole or zero on the
/// boundary.
const MIN_RELATIVE_GAP: f64 = 1e-9;
/// A response below this share of its largest value is rounding, as far beyond the modes of a long chain.
const ROUNDING: f64 = 1e-14;
/// Beyond the last landmark, the response has settled if it is this close to its value at infinity.
const SETTLED: f64 = 1e-3;
/// Modulus of the loop at which an arc about one of its poles is small enough.
const LARGE: f64 = 1e3;
/// Largest number of tenfold reductions of an arc; the loop never becomes large at a pole that cancels.
const MAX_SHRINKS: usize = 16;
/// A pole whose damping ratio is below this counts as on the stability boundary.
const ON_BOUNDARY: f64 = 1e-9;
/// A pole this much slower than the fastest pole, or than half of the sampling rate, is an integrator. The
/// share is the square root of rounding, as double integrators require.
const INTEGRATES: f64 = 1e-9;
/// Smallest share of half of the sampling rate at which z can be distinguished from 1 despite rounding.
const TOLD_APART: f64 = 1e-12;
/// This share applies if the response is certainly infinite at zero frequency. It is the cube root of
/// rounding, as triple integrators require.
const INTEGRATE_TOGETHER: f64 = 1e-5;

/// An open loop with one input and one output and negative feedback: the closed loop has the poles where 1 +
/// L = 0.
#[derive(Debug, Clone)]
pub struct LoopTransfer<T: TimeDomain = Continuous> {
    evaluator: TransferEvaluator,
    domain: T,
    delay_s: f64,
    feed_through: f64,
    poles_s: Vec<C64>,
    zeros_s: Vec<C64>,
}

/// One point of the sampled response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopPoint {
    /// Point of the s plane: on the imaginary axis, or on a small arc to the right of a pole there.
    pub s: C64,
    /// The open loop there.
    pub value: C64,
}

impl LoopTransfer<Continuous> {
    /// A continuous loop followed by an exact delay (s).
    ///
    /// # Errors
    /// [`LtiError::Shape`] unless there is one input and one output; [`LtiError::OutOfRange`] for a negative
    /// delay.
    pub fn continuous(system: &StateSpace, delay_s: f64) -> Result<Self, LtiError> {
        require_not_negative("delay (s)", delay_s)?;
        Self::build(system, delay_s)
    }
}

impl LoopTransfer<Discrete> {
    /// A sampled loop.
    ///
    /// # Errors
    /// [`LtiError::Shape`] unless there is one input and one output.
    pub fn discrete(system: &StateSpace<Discrete>) -> Result<Self, LtiError> {
        Self::build(system, 0.0)
    }

    /// A sampled loop followed by a delay of whole samples, exact however long.
    ///
    /// # Errors
    /// As [`Self::discrete`].
    pub fn late(system: &StateSpace<Discrete>, samples: usize) -> Result<Self, LtiError> {
        Self::build(system, samples as f64 * system.period_s())
    }
}

impl<T: TimeDomain> LoopTransfer<T> {
    fn build(system: &StateSpace<T>, delay_s: f64) -> Result<Self, LtiError> {
        system.require_siso()?;
        let domain = system.domain();
        // Points at z = 0 (pure delays) have no s-plane equivalent and do not shape the response.
        let to_s = |points: Vec<C64>| {
            points.into_iter().map(|p| domain.s_of_point(p)).filter(|s| s.is_finite()).collect()
        };
        // The zeros only show where the samples must be dense. Those of a sampled long chain may be NaN.
        let zeros = if system.states() < MANY_STATES { system.zeros() } else { system.unpolished_zeros() };
        let zeros = zeros.unwrap_or_default();
        let mut poles_s: Vec<C64> = to_s(system.poles()?);
        let nyquist = Some(domain.nyquist_rad_per_s()).filter(|w| w.is_finite()).unwrap_or(0.0);
        let fastest = poles_s.iter().map(|p| p.norm()).fold(nyquist, f64::max);
        let evaluator = TransferEvaluator::new(system).for_many_points();
        // Rounding moves an integrator's pole away from the origin to either side, and several of them
        // farther.
        let singular = evaluator.at(domain.point_of_s(C64::new(0.0, 0.0))).is_err();
        let near = if singular { INTEGRATE_TOGETHER } else { INTEGRATES };
        for pole in poles_s.iter_mut().filter(|p| p.norm() <= near * fastest) {
            *pole = C64::new(0.0, 0.0);
        }
        Ok(Self {
            evaluator,
            domain,
            delay_s,
            feed_through: system.d()[(0, 0)],
            poles_s,
            zeros_s: to_s(zeros),
        })
    }

    /// The time domain.
    pub fn domain(&self) -> T {
        self.domain
    }

    /// The open loop at a point of the s plane (z = exp(s T) for a sampled one).
    ///
    /// # Errors
    /// [`LtiError::AtPole`].
    pub fn at_s(&self, s: C64) -> Result<C64, LtiError> {
        Ok(self.evaluator.at(self.domain.point_of_s(s))?[(0, 0)] * (-s * self.delay_s).exp())
    }

    /// The open loop at an angular frequency, rad/s.
    ///
    /// # Errors
    /// [`LtiError::AtPole`].
    pub fn at_frequency(&self, w: f64) -> Result<C64, LtiError> {
        self.at_s(C64::new(0.0, w))
    }

    /// Poles of the open loop to the right of the stability boundary; those on it do not count.
    pub fn unstable_poles(&self) -> usize {
        self.poles_s.iter().filter(|p| p.re > 0.0 && !on_boundary(**p)).count()
    }

    /// Natural frequencies (rad/s) of poles and zeros, at which a response bends.
    fn landmarks(&self) -> impl Iterator<Item = C64> {
        self.poles_s.iter().chain(&self.zeros_s).copied()
    }

    /// Frequency (rad/s) beyond which the response is constant: the Nyquist frequency, or the frequency at
    /// which it has settled.
    fn last_frequency(&self, gain: f64) -> Result<f64, LtiError> {
        let nyquist = self.domain.nyquist_rad_per_s();
        if nyquist.is_finite() {
            return Ok(nyquist);
        }
        let mut w = 10.0 * self.landmarks().map(C64::norm).fold(0.0, f64::max);
        if w <= 0.0 {
            w = if self.delay_s > 0.0 { 1.0 / self.delay_s } else { 1.0 };
        }
        for _ in 0..64 {
            let undelayed = self.evaluator.at(C64::new(0.0, w))?[(0, 0)];
            if gain.abs() * (undelayed - self.feed_through).norm() < SETTLED {
                break;
            }
            w *= 2.0;
        }
        Ok(w)
    }

    /// The response of `gain` times the loop along the upper half of the stability boundary, from zero
    /// frequency to the last that matters. It passes poles on the boundary on small arcs to their right, and
    /// is fine enough to count its turns about -1.
    ///
    /// # Errors
    /// [`LtiError::AtPole`] if a pole on the boundary could not be distinguished from its neighbours.
    pub fn sampled(&self, gain: f64) -> Result<Vec<LoopPoint>, LtiError> {
        let evaluate = |s: C64| Ok(LoopPoint { s, value: self.at_s(s)? * gain });
        let last = self.last_frequency(gain)?;
        let (mut points, mut largest): (Vec<LoopPoint>, f64) = (Vec::new(), 0.0);
        for stretch in self.stretches(gain, last)? {
            // Each stretch is a straight line or an arc; its nodes are refined along it.
            let at = |node: &f64| Ok((*node, evaluate(stretch.point(*node))?));
            let nodes = stretch.nodes.iter().map(at).collect::<Result<Vec<_>, LtiError>>()?;
            largest = nodes.iter().map(|(_, point)| point.value.norm()).fold(largest, f64::max);
            points.push(nodes[0].1);
            for pair in nodes.windows(2) {
                split(&stretch, &evaluate, ROUNDING * largest, pair[0], pair[1], &mut points)?;
            }
        }
        Ok(points)
    }

    /// The path along the boundary as lines and arcs.
    fn stretches(&self, gain: f64, last: f64) -> Result<Vec<Stretch>, LtiError> {
        let mut avoided: Vec<f64> =
            self.poles_s.iter().filter(|p| on_boundary(**p) && p.im >= 0.0).map(|p| p.im).collect();
        avoided.sort_by(f64::total_cmp);
        avoided.dedup_by(|a, b| (*a - *b).abs() <= 1e-6 * b.abs());
        // Closer to a pole than this, z equals the pole up to rounding. A zero there cancels it, as for an
        // integrator with almost no gain.
        let closest = Some(self.domain.nyquist_rad_per_s())
            .filter(|nyquist| nyquist.is_finite())
            .map_or(0.0, |nyquist| TOLD_APART * nyquist);
        let mut stretches = Vec::new();
        let mut start = 0.0;
        for w in avoided.into_iter().filter(|w| *w <= last) {
            let nearest = self
                .landmarks()
                .map(|p| (p - C64::new(0.0, w)).norm())
                .filter(|d| *d > 1e-6 * w.max(1e-12 * last));
            let mut radius = (1e-3 * nearest.fold(if w > 0.0 { w } else { last }, f64::min)).max(closest);
            // Roots of the closed loop near the pole must stay outside the arc, so the loop must be large on
            // it.
            for _ in 0..MAX_SHRINKS {
                if radius <= closest || (self.at_s(C64::new(radius, w))? * gain).norm() > LARGE {
                    break;
                }
                radius = (0.1 * radius).max(closest);
            }
            if w - radius > start {
                stretches.push(Stretch::line(self.nodes(start, w - radius)));
            }
            let from = if w - radius > 0.0 { -FRAC_PI_2 } else { 0.0 };
            let to = if w + radius < last { FRAC_PI_2 } else { 0.0 };
            let nodes = (0..=8).map(|i| from + (to - from) * f64::from(i) / 8.0).collect();
            stretches.push(Stretch { centre: C64::new(0.0, w), radius, nodes });
            start = w + radius;
        }
        if start < last {
            stretches.push(Stretch::line(self.nodes(start, last)));
        }
        Ok(stretches)
    }

    /// Initial frequencies between two ends: a logarithmic grid, and a cluster about each pole and zero as
    /// wide as its damping.
    fn nodes(&self, start: f64, end: f64) -> Vec<f64> {
        let slowest = self.landmarks().map(C64::norm).filter(|w| *w > 0.0).fold(end, f64::min);
        let first = if start > 0.0 { start } else { (1e-3 * slowest).min(0.1 * end) };
        let decades = (end / first).log10().max(0.1);
        let count = (20.0 * decades).ceil() as u32;
        let mut nodes: Vec<f64> =
            (0..=count).map(|i| first * (end / first).powf(f64::from(i) / f64::from(count))).collect();
        for p in self.landmarks() {
            let width = p.re.abs().max(1e-9 * p.im.abs());
            nodes.push(p.im);
            for factor in [0.25, 0.5, 1.0, 2.0, 4.0, 10.0, 30.0] {
                nodes.extend([p.im - factor * width, p.im + factor * width]);
            }
        }
        if self.delay_s > 0.0 {
            // A delay turns the phase by at most half a radian between nodes; refinement does the rest.
            let turns = (end * self.delay_s / 0.5).ceil().min(1e6) as u32;
            nodes.extend((1..turns).map(|i| end * f64::from(i) / f64::from(turns)));
        }
        nodes.retain(|w| *w > start && *w < end);
        nodes.extend([start, end]);
        nodes.sort_by(f64::total_cmp);
        nodes.dedup();
        nodes
    }
}

fn on_boundary(p: C64) -> bool {
    p.re.abs() <= ON_BOUNDARY * p.norm().max(f64::MIN_POSITIVE)
}

/// A piece of the path: along the imaginary axis, or on an arc about a point of it.
struct Stretch {
    centre: C64,
    /// Radius of the arc; zero for a line.
    radius: f64,
    /// Frequencies (rad/s), or angles on the arc (rad).
    nodes: Vec<f64>,
}

impl Stretch {
    fn line(nodes: Vec<f64>) -> Self {
        Self { centre: C64::new(0.0, 0.0), radius: 0.0, nodes }
    }

    fn point(&self, node: f64) -> C64 {
        if self.radius > 0.0 { self.centre + C64::from_polar(self.radius, node) } else { C64::new(0.0, node) }
    }
}

/// Adds the points needed between two nodes, and the second node. Values below `least` are rounding.
fn split(
    stretch: &Stretch,
    evaluate: &impl Fn(C64) -> Result<LoopPoint, LtiError>,
    least: f64,
    left: (f64, LoopPoint),
    right: (f64, LoopPoint),
    out: &mut Vec<LoopPoint>,
) -> Result<(), LtiError> {
    let one = C64::new(1.0, 0.0);
    let change = |a: C64, b: C64| if a == b { 0.0 } else { (b / a).ln().norm() };
    let (l, r) = (left.1.value, right.1.value);
    let is_small = l.norm().max(r.norm()) <= least;
    let rough = !((is_small || change(l, r) <= LOG_STEP) && change(one + l, one + r) <= LOG_STEP);
    if rough && right.0 - left.0 > MIN_RELATIVE_GAP * left.0.abs().max(right.0.abs()) {
        let node = 0.5 * (left.0 + right.0);
        let middle = (node, evaluate(stretch.point(node))?);
        split(stretch, evaluate, least, left, middle, out)?;
        split(stretch, evaluate, least, middle, right, out)
    } else {
        out.push(right.1);
        Ok(())
    }
}

/// Phase (rad) through which 1 + L turns along sampled points.
pub(crate) fn winding_rad(points: &[LoopPoint]) -> f64 {
    let one = C64::new(1.0, 0.0);
    points.windows(2).map(|pair| ((one + pair[1].value) / (one + pair[0].value)).arg()).sum()
}

impl<T: TimeDomain> LoopTransfer<T> {
    /// Unstable poles of the loop closed with `gain`, by Nyquist's count: those of the open loop plus the
    /// clockwise encirclements of -1. A loop with a delay and a feed-through of `gain` >= 1 in modulus has
    /// infinitely many, and the count is then not valid.
    ///
    /// # Errors
    /// [`LtiError::AtPole`].
    pub fn closed_loop_unstable_poles(&self, gain: f64) -> Result<usize, LtiError> {
        Ok(self.count_from(&self.sampled(gain)?))
    }

    /// The count from sampled points. By symmetry the whole contour turns twice as far as its upper half.
    pub(crate) fn count_from(&self, points: &[LoopPoint]) -> usize {
        let counterclockwise = (winding_rad(points) / PI).round();
        (self.unstable_poles() as f64 - counterclockwise).max(0.0) as usize
    }
}
