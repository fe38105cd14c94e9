//! What a page shows of a loop: frequency responses, sampled and continuous, and root loci over the gain in question.

use std::f64::consts::TAU;

use feeler_control::Law;
use feeler_engine::Scenario;
use feeler_lti::{C64, StateSpace, TimeDomain, TransferEvaluator, root_locus};
use feeler_plant::description::SignalName;
use nalgebra::DMatrix;

use crate::continuous_loop::ContinuousLoop;
use crate::control_loop::ControlLoop;
use crate::error::AnalysisError;
use crate::gain_key::gain;
use crate::linearise::OutputRow;
use crate::report::{Report, Request};
use crate::sampled_loop::SampledLoop;

/// Points of a response over its whole band, evenly spaced on a logarithmic scale.
const POINTS: u32 = 500;
/// Points on each side of every resonance and antiresonance, spaced by its own width.
const POINTS_BESIDE: i32 = 12;
/// Gains of a root locus.
const GAINS: u32 = 240;
/// A locus reaches this many times beyond the largest stable gain, and begins this far below it.
const BEYOND: f64 = 20.0;
const BELOW: f64 = 1e-3;

/// Responses over frequency, not a number where a response has none: at a pole on the axis, and beyond half of the sampling rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// Hz, rising.
    pub frequencies_hz: Vec<f64>,
    /// From command to output in continuous time, delays of drive and sensor exact.
    pub plant: Vec<C64>,
    /// The same under the controller's hold, sampled; absent without a controller.
    pub plant_sampled: Option<Vec<C64>>,
    /// The loop broken at its controller, without sampling, delay and filters; absent as the continuous gain of a [`Report`].
    pub open: Option<Vec<C64>>,
    /// The loop broken at its controller, as built.
    pub open_sampled: Option<Vec<C64>>,
    /// Half of the sampling rate, Hz.
    pub nyquist_hz: Option<f64>,
    /// Root locus of the continuous loop.
    pub locus: Option<Locus>,
    /// Root locus of the loop as built, in the z plane of [`Locus::period_s`].
    pub locus_sampled: Option<Locus>,
}

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

/// Curves behind a report.
///
/// # Errors
/// As [`crate::analyze`].
pub fn curves(scenario: &Scenario, request: &Request, report: &Report) -> Result<Curves, AnalysisError> {
    let whole = ControlLoop::new(scenario, &request.view)?;
    let name = |text: &str| text.parse::<SignalName>().map_err(|_| AnalysisError::NotLinear { name: text.to_owned() });
    let (input, output) = (name(&report.input)?, name(&report.output)?);
    let channel = whole.plant().channel(&input, &output)?;
    let drive = whole.plant().drive(&input)?;
    let looped = report.gain.as_ref().map(|g| whole.gain_of_key(&g.key)).transpose()?;
    let holder = looped.as_ref().map(|(controller, _)| *controller).or_else(|| whole.controllers().iter().position(|c| c.drive == drive));
    let nyquist_hz = holder.map(|controller| 0.5 / whole.controllers()[controller].spec.period_s);
    let roots: Vec<C64> = channel.poles()?.into_iter().chain(channel.zeros()?).collect();
    let frequencies_hz = grid(&roots, nyquist_hz);

    let at = |system: &StateSpace| over(system, &frequencies_hz);
    let mut plant = at(&channel.system);
    for (value, f) in plant.iter_mut().zip(&frequencies_hz) {
        *value *= C64::cis(-TAU * f * channel.delay_s);
    }
    let row = whole.plant().output(whole.plant().source(&output)?)?;
    let plant_sampled = holder
        .filter(|&controller| whole.controllers()[controller].drive == drive)
        .map(|controller| Ok::<_, AnalysisError>(over(&held_plant(&whole, controller, row)?, &frequencies_hz)))
        .transpose()?;
    let (mut open, mut open_sampled, mut locus, mut locus_sampled) = (None, None, None, None);
    if let (Some((controller, key)), Some(gains)) = (&looped, &report.gain) {
        let present = gain(&whole.controllers()[*controller].spec, key)?;
        let sampled = SampledLoop::new(&whole)?;
        let broken = sampled.open_loop(*controller).ok();
        open_sampled = broken.as_ref().map(|system| over(system, &frequencies_hz));
        let zeros = broken.map(|system| system.zeros().unwrap_or_default()).unwrap_or_default();
        let closed = |k: f64| sampled.closed_loop_with(*controller, key, k);
        locus_sampled = Some(follow(Some(sampled.common_period_s()), closed, zeros, present, gains.sampled.stable[1])?);
        if let Some(range) = &gains.continuous {
            let continuous = ContinuousLoop::new(&whole)?;
            let broken = continuous.open_loop(*controller)?;
            open = Some(at(&broken));
            let closed = |k: f64| continuous.closed_loop_with(*controller, key, k);
            locus = Some(follow(None, closed, broken.zeros().unwrap_or_default(), present, range.stable[1])?);
        }
    }
    Ok(Curves { frequencies_hz, plant, plant_sampled, open, open_sampled, nyquist_hz, locus, locus_sampled })
}

/// From a drive's held command to a signal, the loops of all controllers open.
fn held_plant(whole: &ControlLoop, controller: usize, row: OutputRow) -> Result<feeler_lti::DiscreteStateSpace, AnalysisError> {
    let alone = whole.altered(|_, controllers| {
        let mut kept = controllers.swap_remove(controller);
        (kept.spec.law, kept.spec.delay_s, kept.reading, kept.motion) = (Law::OpenLoop, 0.0, None, None);
        *controllers = vec![kept];
    })?;
    SampledLoop::response_to(&alone, 0, row)
}

/// Frequencies (Hz) that show every root near the axis, and end beyond the last of them and half of the sampling rate.
fn grid(roots: &[C64], nyquist_hz: Option<f64>) -> Vec<f64> {
    let sizes = || roots.iter().map(|r| r.norm() / TAU).filter(|f| *f > 1e-3);
    let (lowest, highest) = (sizes().fold(f64::INFINITY, f64::min), sizes().fold(0.0, f64::max));
    let low = if lowest.is_finite() { (0.1 * lowest).clamp(1e-2, 1.0) } else { 0.1 };
    let nyquist = nyquist_hz.unwrap_or(0.0);
    let high = (2.0 * highest.min(4.0 * nyquist.max(100.0))).max(nyquist).max(100.0 * low);
    let mut all: Vec<f64> = (0..=POINTS).map(|i| low * (high / low).powf(f64::from(i) / f64::from(POINTS))).collect();
    for root in roots.iter().filter(|r| r.im > 0.0) {
        let width = root.re.abs().max(1e-5 * root.im) / TAU;
        let beside = (-POINTS_BESIDE..=POINTS_BESIDE).map(|i| root.im / TAU + 0.4 * f64::from(i) * width);
        all.extend(beside.filter(|f| (low..high).contains(f)));
    }
    all.extend(nyquist_hz);
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

fn over<T: TimeDomain>(system: &StateSpace<T>, frequencies_hz: &[f64]) -> Vec<C64> {
    let evaluator = TransferEvaluator::new(system);
    let nyquist = system.domain().nyquist_rad_per_s() * (1.0 + 1e-9);
    let none = C64::new(f64::NAN, f64::NAN);
    let value = |f: &f64| {
        let w = TAU * f;
        if w > nyquist { none } else { evaluator.at(system.domain().boundary_point(w)).map_or(none, |g| g[(0, 0)]) }
    };
    frequencies_hz.iter().map(value).collect()
}

fn follow(
    period_s: Option<f64>,
    closed: impl Fn(f64) -> Result<DMatrix<f64>, AnalysisError>,
    zeros: Vec<C64>,
    present_gain: f64,
    largest: Option<f64>,
) -> Result<Locus, AnalysisError> {
    let zero = closed(0.0)?;
    let present = feeler_lti::eigenvalues(&closed(present_gain)?)?;
    let scale = largest.filter(|k| *k > 0.0).unwrap_or(present_gain.abs().max(f64::MIN_POSITIVE));
    let (from, to) = (BELOW * scale, BEYOND * scale.max(present_gain));
    let mut gains: Vec<f64> = (0..=GAINS).map(|i| from * (to / from).powf(f64::from(i) / f64::from(GAINS))).collect();
    gains.extend([0.0, present_gain.max(0.0)].into_iter().chain(largest));
    gains.sort_by(f64::total_cmp);
    gains.dedup();
    // Whether a gain exists does not depend on its value, and zero has been tried.
    let traced = root_locus(|k| closed(k).unwrap_or_else(|_| zero.clone()), &gains)?;
    Ok(Locus { period_s, gains: traced.gains, branches: traced.branches, zeros, present_gain, present })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_the_grid_rises_and_shows_a_sharp_root() {
        let sharp = C64::new(-0.1, 600.0);
        let found = grid(&[sharp, sharp.conj()], Some(500.0));
        assert!(found.is_sorted() && found.contains(&500.0));
        let near = found.iter().filter(|f| (**f - 600.0 / TAU).abs() < 0.1).count();
        assert!(near >= 24, "{near}");
    }

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
}
