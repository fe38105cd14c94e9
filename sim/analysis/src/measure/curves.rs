//! Curves that a page shows of a loop: frequency responses, sampled and continuous, and root loci over the
//! gain in question.

use std::f64::consts::TAU;

use feeler_control::Law;
use feeler_engine::Scenario;
use feeler_lti::{C64, StateSpace, TimeDomain, TransferEvaluator};
use feeler_plant::description::SignalName;

use crate::error::AnalysisError;
use crate::limits::locus::{Fineness, Locus, follow};
use crate::loops::continuous_loop::ContinuousLoop;
use crate::loops::control_loop::ControlLoop;
use crate::loops::gain_key::gain;
use crate::loops::late::LateResponse;
use crate::loops::sampled_loop::SampledLoop;
use crate::loops::step_response::StepResponse;
use crate::machine::linearise::OutputRow;
use crate::machine::outer_force::commanded;
use crate::report::{GainReport, Report, Request};

/// Points of a response over its whole band, evenly spaced on a logarithmic scale; fewer if it is one of
/// many.
const POINTS: usize = 500;
const BRIEF_POINTS: usize = 200;
/// Points on each side of every resonance and antiresonance, spaced by its own width.
const POINTS_BESIDE: i32 = 12;
/// Largest change between neighbouring points. It is that of a response relative to itself, and of the open
/// and closed loop on the Riemann sphere relative to its radius. Curves then look smooth on a logarithmic
/// scale and in the plane.
const CHANGE: f64 = 0.12;
const ARC: f64 = 0.02;
/// Duration of a step response in periods of the crossover, at a phase margin of 60°; it grows as the margin
/// falls. The second number is the lower limit of the margin in degrees. The third is the duration without a
/// crossover.
const STEP_PERIODS: f64 = 5.0;
const LITTLE_DEG: f64 = 6.0;
const STEP_S: f64 = 0.5;
/// Largest number of bisections of a step, and of points.
const HALVINGS: usize = 12;
const MOST_POINTS: usize = 3000;
const MOST_BRIEF_POINTS: usize = 600;

/// Responses over frequency. NaN where a response does not exist: at a pole on the axis, and above half of
/// the sampling rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// Hz, rising.
    pub frequencies_hz: Vec<f64>,
    /// From command to output in continuous time, delays of drive and sensor exact; empty in a brief report.
    pub plant: Vec<C64>,
    /// Response of the plant under the controller's hold, sampled; `None` without a controller, or in a brief
    /// report.
    pub plant_sampled: Option<Vec<C64>>,
    /// The loop broken at its controller, without sampling, delay and filters; `None` if the [`Report`] has
    /// no continuous gain.
    pub open: Option<Vec<C64>>,
    /// The loop broken at its controller, as built.
    pub open_sampled: Option<Vec<C64>>,
    /// Half of the sampling rate, Hz.
    pub nyquist_hz: Option<f64>,
    /// The controlled signal after a step of the reference, sampled, with the gains of the file.
    pub step: Option<StepResponse>,
    /// Root locus of the continuous loop.
    pub locus: Option<Locus>,
    /// Root locus of the loop as built, in the z plane of [`Locus::period_s`]; `None` if a long delay gives
    /// too many branches.
    pub locus_sampled: Option<Locus>,
}

/// Curves behind a report.
///
/// # Errors
/// As [`crate::analyze`].
pub fn curves(scenario: &Scenario, request: &Request, report: &Report) -> Result<Curves, AnalysisError> {
    let name = |text: &str| {
        text.parse::<SignalName>().map_err(|_| AnalysisError::NotLinear { name: text.to_owned() })
    };
    let (scenario, input) = commanded(scenario, &name(&report.input)?);
    let (scenario, output) = (scenario.as_ref(), name(&report.output)?);
    let whole = match report.gain() {
        Some(gain) => ControlLoop::varying(scenario, &request.view, &gain.key)?,
        None => ControlLoop::new(scenario, &request.view)?,
    };
    let drive = whole.plant().drive(&input)?;
    let looped = report.gain().map(|g| whole.gain_of_key(&g.key)).transpose()?;
    let of_drive = || whole.controllers().iter().position(|c| c.drive == drive);
    let holder = looped.as_ref().map(|(controller, _)| *controller).or_else(of_drive);
    let nyquist_hz = holder.map(|controller| 0.5 / whole.controllers()[controller].spec.period_s);

    let plants = if request.brief {
        [None, None]
    } else {
        let held = holder.filter(|&controller| whole.controllers()[controller].drive == drive);
        plant_responses(&whole, held, &input, &output)?
    };
    let (mut open, mut open_sampled, mut in_loop) = (None, None, None);
    if let (Some((controller, key)), Some(gains)) = (&looped, report.gain()) {
        let broken = whole.open_loop(*controller).ok();
        open_sampled = broken.as_ref().map(at_late);
        let continuous = gains.continuous.as_ref().map(|_| ContinuousLoop::new(&whole)).transpose()?;
        let continuous =
            continuous.map(|looped| Ok::<_, AnalysisError>((looped.open_loop(*controller)?, looped)));
        let continuous = continuous.transpose()?;
        open = continuous.as_ref().map(|(broken, _)| at(broken));
        in_loop = Some(InLoop { whole: &whole, controller: *controller, key, gains, broken, continuous });
    }
    let [points, most_points] =
        if request.brief { [BRIEF_POINTS, MOST_BRIEF_POINTS] } else { [POINTS, MOST_POINTS] };
    let loops = [open, open_sampled];
    let over_frequency = || {
        let grid = grid(&roots(report), nyquist_hz, points);
        let frequencies_hz = refined(grid, most_points, &plants, &loops);
        let values = |response: &Option<Response>| {
            response.as_ref().map(|at| frequencies_hz.iter().map(|&f| at(f)).collect::<Vec<C64>>())
        };
        let responses = [&plants, &loops].map(|pair| [values(&pair[0]), values(&pair[1])]);
        (frequencies_hz, responses)
    };
    let over_gain = || in_loop.as_ref().map(|looped| looped.step_and_loci(request, report)).transpose();
    let ((frequencies_hz, [[plant, plant_sampled], [open, open_sampled]]), over_gain) =
        request.workers.both(over_frequency, over_gain);
    let (step, locus, locus_sampled) = over_gain?.unwrap_or_default();
    let plant = plant.unwrap_or_default();
    Ok(Curves {
        frequencies_hz,
        plant,
        plant_sampled,
        open,
        open_sampled,
        nyquist_hz,
        step,
        locus,
        locus_sampled,
    })
}

/// A loop that a gain closes, with the loop broken at its controller.
struct InLoop<'a> {
    whole: &'a ControlLoop,
    controller: usize,
    key: &'a str,
    gains: &'a GainReport,
    broken: Option<LateResponse>,
    continuous: Option<(StateSpace, ContinuousLoop)>,
}

impl InLoop<'_> {
    /// The step response, and the loci of the continuous and the sampled loop.
    fn step_and_loci(&self, request: &Request, report: &Report) -> Result<StepAndLoci, AnalysisError> {
        let (controller, key) = (self.controller, self.key);
        let fineness = if request.brief { Fineness::BRIEF } else { Fineness::WHOLE };
        let present = gain(&self.whole.controllers()[controller].spec, key)?;
        let broken = self.broken.as_ref();
        let step =
            broken.map(|_| StepResponse::new(self.whole, controller, step_s(report))).transpose()?.flatten();
        if request.without_loci {
            return Ok((step, None, None));
        }
        // A long delay has hundreds of branches, one for each sample, which would show nothing.
        let late = broken.is_some_and(|open| open.samples > 0);
        let sampled = SampledLoop::new(self.whole)?;
        let locus_sampled = (!late).then(|| {
            let zeros = || broken.and_then(|open| open.system.zeros().ok()).unwrap_or_default();
            let closed = |k: f64| sampled.closed_loop_with(controller, key, k);
            let (period_s, largest) = (sampled.common_period_s(), self.gains.sampled.stable[1]);
            follow(Some(period_s), closed, zeros, present, largest, fineness)
        });
        let locus_sampled = locus_sampled.transpose()?;
        // In a brief report the sampled locus, which is shown first, is enough.
        let wanted = self.continuous.as_ref().filter(|_| locus_sampled.is_none() || !request.brief);
        let locus = wanted.zip(self.gains.continuous.as_ref()).map(|((broken, continuous), range)| {
            let closed = |k: f64| continuous.closed_loop_with(controller, key, k);
            let zeros = || broken.zeros().unwrap_or_default();
            follow(None, closed, zeros, present, range.stable[1], fineness)
        });
        Ok((step, locus.transpose()?, locus_sampled))
    }
}

/// The step response, the continuous locus and the sampled one.
type StepAndLoci = (Option<StepResponse>, Option<Locus>, Option<Locus>);

/// Duration of the step response to show, s: some periods of the crossover, more if it rings.
fn step_s(report: &Report) -> f64 {
    let Some(margins) = report.margins() else { return STEP_S };
    let hz = margins.crossover_hz.or(report.looped.as_ref().and_then(|looped| looped.bandwidth_hz));
    let damping = margins.phase_deg.unwrap_or(LITTLE_DEG).clamp(LITTLE_DEG, 60.0) / 60.0;
    hz.filter(|hz| *hz > 0.0).map_or(STEP_S, |hz| STEP_PERIODS / (hz * damping))
}

/// A response over frequency (Hz).
type Response = Box<dyn Fn(f64) -> C64 + Send + Sync>;

/// Adds frequencies (Hz) until the curves look smooth.
fn refined(
    mut frequencies_hz: Vec<f64>,
    most_points: usize,
    plants: &[Option<Response>],
    loops: &[Option<Response>],
) -> Vec<f64> {
    let at = |f: f64| Point {
        values: plants.iter().flatten().map(|response| response(f)).collect(),
        loops: loops.iter().flatten().map(|response| response(f)).collect(),
    };
    let mut points: Vec<Point> = frequencies_hz.iter().map(|&f| at(f)).collect();
    for _ in 0..HALVINGS {
        let coarse: Vec<usize> =
            (1..points.len()).filter(|&i| points[i - 1].is_far_from(&points[i])).collect();
        if coarse.is_empty() || points.len() + coarse.len() > most_points {
            break;
        }
        let middle = |i: &usize| (frequencies_hz[i - 1] * frequencies_hz[*i]).sqrt();
        let mut all: Vec<(f64, Point)> = coarse
            .iter()
            .map(middle)
            .map(|f| (f, at(f)))
            .chain(frequencies_hz.iter().copied().zip(points))
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        (frequencies_hz, points) = all.into_iter().unzip();
    }
    frequencies_hz
}

/// All responses at one frequency.
struct Point {
    values: Vec<C64>,
    loops: Vec<C64>,
}

impl Point {
    fn is_far_from(&self, other: &Self) -> bool {
        let change = |(a, b): (&C64, &C64)| (a - b).norm() > CHANGE * a.norm().max(b.norm());
        let arc = |a: C64, b: C64| {
            2.0 * (a - b).norm() > ARC * ((1.0 + a.norm_sqr()) * (1.0 + b.norm_sqr())).sqrt()
        };
        let closed = |l: &C64| l / (l + 1.0);
        // NaN counts as a change.
        self.values.iter().zip(&other.values).any(change)
            || self
                .loops
                .iter()
                .zip(&other.loops)
                .any(|(a, b)| arc(*a, *b) || arc(closed(a), closed(b)) || change((a, b)))
    }
}

/// Responses from a command to a signal: in continuous time, and held and sampled by a controller.
fn plant_responses(
    whole: &ControlLoop,
    holder: Option<usize>,
    input: &SignalName,
    output: &SignalName,
) -> Result<[Option<Response>; 2], AnalysisError> {
    let channel = whole.plant().channel(input, output)?;
    let (delayed, delay_s) = (at(&channel.system), channel.delay_s);
    let plant: Response = Box::new(move |f| delayed(f) * C64::cis(-TAU * f * delay_s));
    let row = whole.plant().output(whole.plant().source(output)?)?;
    let sampled = holder
        .map(|controller| Ok::<_, AnalysisError>(at_late(&held_plant(whole, controller, row)?)))
        .transpose()?;
    Ok([Some(plant), sampled])
}

/// From a drive's held command to a signal, with all control loops open.
fn held_plant(whole: &ControlLoop, controller: usize, row: OutputRow) -> Result<LateResponse, AnalysisError> {
    let alone = whole.altered(|_, controllers| {
        let mut kept = controllers.swap_remove(controller);
        (kept.spec.law, kept.spec.delay_s, kept.reading, kept.motion) = (Law::OpenLoop, 0.0, None, None);
        *controllers = vec![kept];
    })?;
    alone.response_to(0, row)
}

/// Poles and zeros of a report.
fn roots(report: &Report) -> Vec<C64> {
    report.poles.iter().chain(&report.zeros).map(|[re, im]| C64::new(*re, *im)).collect()
}

/// Frequencies (Hz) that resolve every root near the axis, and end beyond the last root and half of the
/// sampling rate.
fn grid(roots: &[C64], nyquist_hz: Option<f64>, points: usize) -> Vec<f64> {
    let sizes = || roots.iter().map(|r| r.norm() / TAU).filter(|f| *f > 1e-3);
    let (lowest, highest) = (sizes().fold(f64::INFINITY, f64::min), sizes().fold(0.0, f64::max));
    let low = if lowest.is_finite() { (0.1 * lowest).clamp(1e-2, 1.0) } else { 0.1 };
    let nyquist = nyquist_hz.unwrap_or(0.0);
    let high = (2.0 * highest.min(4.0 * nyquist.max(100.0))).max(nyquist).max(100.0 * low);
    // Scales end at 1, 2 or 5 of a decade.
    let (low, high) = (1.0 / round_above(1.0 / low), round_above(high));
    let mut all: Vec<f64> = (0..=points).map(|i| low * (high / low).powf(i as f64 / points as f64)).collect();
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

/// The next of 1, 2, 5, 10 ... at or above a number.
fn round_above(value: f64) -> f64 {
    let decade = 10_f64.powf(value.log10().floor());
    // A value that is already round stays, up to rounding.
    let reaches = |round: &&f64| **round * decade >= value * (1.0 - 1e-9);
    [1.0, 2.0, 5.0].iter().find(reaches).map_or(10.0 * decade, |round| round * decade)
}

fn at_late(response: &LateResponse) -> Response {
    let prompt = at(&response.system);
    let delay_s = response.samples as f64 * response.system.period_s();
    Box::new(move |f| prompt(f) * C64::cis(-TAU * f * delay_s))
}

fn at<T: TimeDomain + Send + Sync + 'static>(system: &StateSpace<T>) -> Response {
    let evaluator = TransferEvaluator::new(system).for_many_points();
    let domain = system.domain();
    let nyquist = domain.nyquist_rad_per_s() * (1.0 + 1e-9);
    let none = C64::new(f64::NAN, f64::NAN);
    Box::new(move |f| {
        let w = TAU * f;
        if w > nyquist { none } else { evaluator.at(domain.boundary_point(w)).map_or(none, |g| g[(0, 0)]) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_the_grid_rises_and_shows_a_sharp_root() {
        let sharp = C64::new(-0.1, 600.0);
        let found = grid(&[sharp, sharp.conj()], Some(500.0), POINTS);
        assert!(found.is_sorted() && found.contains(&500.0));
        let near = found.iter().filter(|f| (**f - 600.0 / TAU).abs() < 0.1).count();
        assert!(near >= 24, "{near}");
    }
}
