//! Limit cycles of a contact that only pushes, by describing functions: the linear theory of chatter.
//!
//! In a cycle the compression is taken as `b + a sin wt`. The one-sided spring then has a mean force and a
//! first harmonic, which equal those of a softer spring that also pulls. Saturation of the drive is treated
//! in the same way. The sampled loop with these equivalent gains is otherwise exact. An amplitude at which it
//! neither grows nor decays is a cycle; the cycle is stable if larger amplitudes decay. Harmonics are
//! neglected, so accuracy improves with the filtering of the machine. Impacts far apart are outside the
//! method.
//!
//! Source: A. Gelb and W. E. Vander Velde, "Multiple-Input Describing Functions and Nonlinear System Design",
//! McGraw-Hill 1968, on dual-input describing functions.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use feeler_control::{ControllerSpec, Reference};
use feeler_engine::Scenario;
use feeler_lti::{C64, TimeDomain, eigen};
use feeler_plant::assembly::Source;
use feeler_plant::description::{Quantity, SignalName};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use crate::error::AnalysisError;
use crate::loops::control_loop::ControlLoop;
use crate::loops::sampled_loop::SampledLoop;
use crate::machine::prepare::View;

/// Range of offsets `b / a` of the search: from oscillations far smaller than the mean compression to contact
/// during a few per cent of the time.
const OFFSETS: [f64; 2] = [-0.995, 30.0];
/// Points of the search on each side of the offset at which contact is first lost.
const POINTS: u32 = 24;
/// Bisections of an interval that contains a cycle.
const HALVINGS: u32 = 40;
/// Iterations between the saturation's equivalent gain and the motion that it shapes.
const ROUNDS: u32 = 30;
/// The iteration ends when the equivalent gain changes by less than this.
const SETTLED: f64 = 1e-10;
/// Motions below this frequency are drift, Hz.
const DRIFT_HZ: f64 = 1e-3;
/// Static gains are evaluated at z - 1 equal to this, so that an integrator's gain is finite.
const NEARLY_STATIC: f64 = 1e-9;

/// A limit cycle, approximated by the first harmonic of each signal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LimitCycle {
    /// Frequency of the first harmonic, Hz.
    pub frequency_hz: f64,
    /// Largest elastic force of the contact.
    pub peak_force_n: f64,
    /// Mean force of the contact.
    pub mean_force_n: f64,
    /// Share of the time in contact; 1 if contact is never lost.
    pub contact_share: f64,
    /// Amplitude of the compression, m.
    pub amplitude_m: f64,
    /// Share of the command's oscillation that the drive's limit lets through; 1 without saturation.
    pub drive_share: f64,
    /// Whether the cycle attracts. An unstable cycle is the largest disturbance from which the loop still
    /// settles.
    pub stable: bool,
}

/// Equivalent gains of the ramp `max(x, 0)` for `x = a (offset + sin)`, each divided by `a` or by the slope.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ramp {
    /// Mean value over `a`.
    mean: f64,
    /// First harmonic over `a`. A damper that acts only while `x > 0` has this share of the effect of one
    /// that always acts.
    harmonic: f64,
    /// Share of the time with `x > 0`.
    share: f64,
}

impl Ramp {
    fn new(offset: f64) -> Self {
        let o = offset.clamp(-1.0, 1.0);
        let (angle, root) = (FRAC_PI_2 + o.asin(), (1.0 - o * o).sqrt());
        let mean = if offset >= 1.0 { offset } else { (o * angle + root) / PI };
        Self { mean, harmonic: (angle + o * root) / PI, share: angle / PI }
    }
}

/// Mean and equivalent gain of a symmetric saturation, for a command with this mean and amplitude.
fn saturation(limit: f64, mean: f64, amplitude: f64) -> [f64; 2] {
    if limit.is_infinite() || amplitude <= 0.0 {
        return [mean.clamp(-limit, limit), 1.0];
    }
    let (above, below) = (Ramp::new((mean - limit) / amplitude), Ramp::new((-mean - limit) / amplitude));
    [mean + amplitude * (below.mean - above.mean), 1.0 - above.harmonic - below.harmonic]
}

/// The loop at one amplitude.
struct Trial {
    growth_per_s: f64,
    cycle: LimitCycle,
}

/// The part of the balance that does not depend on the amplitude.
struct Balance {
    whole: ControlLoop,
    controller: usize,
    limit: f64,
    /// Command of the loop at rest: its value without any force, and its change for one newton of drive
    /// force.
    static_command: [f64; 2],
    /// Mean contact force for a drive force of one newton.
    force_per_command: f64,
    stiffness_n_per_m: f64,
}

/// Limit cycles of a scenario with one linear contact, by falling peak force; `None` if the loop has none.
///
/// # Errors
/// [`AnalysisError::NoLimitCycle`] for machines that this theory does not cover; the mistakes of the
/// scenario; [`AnalysisError::Lti`].
pub fn limit_cycles(scenario: &Scenario) -> Result<Vec<LimitCycle>, AnalysisError> {
    let balance = Balance::new(scenario)?;
    let mut cycles = Vec::new();
    let mut last: Option<(f64, Trial)> = None;
    for offset in offsets() {
        let trial = balance.trial(offset)?;
        if let Some((before, earlier)) = &last
            && (earlier.growth_per_s > 0.0) != (trial.growth_per_s > 0.0)
        {
            let mut cycle = balance.between(*before, offset, earlier.growth_per_s > 0.0)?;
            // Amplitudes grow from one trial to the next.
            cycle.stable = earlier.growth_per_s > 0.0;
            cycles.push(cycle);
        }
        last = Some((offset, trial));
    }
    cycles.sort_by(|a, b| b.peak_force_n.total_cmp(&a.peak_force_n));
    Ok(cycles)
}

/// Offsets from small amplitudes to large ones.
fn offsets() -> impl Iterator<Item = f64> {
    let [low, high] = OFFSETS;
    let share = |i: u32| f64::from(i) / f64::from(POINTS);
    let held = (0..POINTS).map(move |i| high.powf(1.0 - share(i)));
    held.chain((0..=POINTS).map(move |i| 1.0 + (low - 1.0) * share(i)))
}

impl Balance {
    fn new(scenario: &Scenario) -> Result<Self, AnalysisError> {
        let refuse = |reason: &'static str| AnalysisError::NoLimitCycle { reason };
        let whole = ControlLoop::new(scenario, &View::CLAMPED)?;
        let [contact] = whole.assembly().contacts.as_slice() else {
            return Err(refuse("the machine needs exactly one contact"));
        };
        if !contact.law.is_linear() {
            return Err(refuse("the contact's force is not linear in compression and its rate"));
        }
        let stiffness_n_per_m = contact.law.stiffness;
        let name = SignalName::new(contact.name.clone(), Quantity::SpringForce);
        let closes = |c: &crate::loops::control_loop::LoopController| {
            c.reading.is_some() && !matches!(c.spec.law, feeler_control::Law::OpenLoop)
        };
        let controller = whole
            .controllers()
            .iter()
            .position(closes)
            .ok_or_else(|| refuse("no controller closes a loop"))?;
        let wiring = &whole.controllers()[controller];
        let drive = &whole.assembly().drives[wiring.drive];
        let limit = drive.limit.min(wiring.spec.output_limit.unwrap_or(f64::INFINITY));

        let plant = whole.plant();
        let force = plant.channel_of(wiring.drive, &plant.output(plant.source(&name)?)?)?;
        let reading =
            plant.channel_of(wiring.drive, &plant.output(Source::Sensor(wiring.reading.unwrap_or(0)))?)?;
        let period_s = wiring.spec.period_s;
        let at = |channel: &crate::machine::channel::ResponseChannel| -> Result<f64, AnalysisError> {
            Ok(channel.frequency_response(&[NEARLY_STATIC / (TAU * period_s)])?[0].re)
        };
        let [of_reference, of_reading] = static_law(&wiring.spec, wiring.motion_is_velocity)?;
        let reference = Reference::new(&wiring.spec.reference, scenario.run.seed, "reference")?
            .value(scenario.run.duration_s);
        Ok(Self {
            controller,
            limit,
            static_command: [of_reference * reference, of_reading * at(&reading)?],
            force_per_command: at(&force)?,
            stiffness_n_per_m,
            whole,
        })
    }

    /// The loop with an oscillation whose mean compression is `offset` times its amplitude.
    fn trial(&self, offset: f64) -> Result<Trial, AnalysisError> {
        let ramp = Ramp::new(offset);
        let drive = self.whole.controllers()[self.controller].drive;
        let (mut drive_share, mut command_n) = (1.0, 0.0);
        let mut round = 0;
        loop {
            let mean_force_n = self.mean_force(command_n);
            let amplitude_m = (mean_force_n / (self.stiffness_n_per_m * ramp.mean)).max(0.0);
            let equivalent = self.whole.altered(|assembly, _| {
                let law = &mut assembly.contacts[0].law;
                law.stiffness *= ramp.harmonic;
                law.damping *= ramp.harmonic;
                assembly.drives[drive].gain *= drive_share;
            })?;
            let motion = Motion::of(&equivalent, self.controller)?;
            command_n = motion.command_per_m * amplitude_m;
            let next = saturation(self.limit, self.mean_command(command_n), command_n)[1];
            round += 1;
            if (next - drive_share).abs() <= SETTLED || round == ROUNDS {
                let cycle = LimitCycle {
                    frequency_hz: motion.frequency_hz,
                    peak_force_n: self.stiffness_n_per_m * amplitude_m * (1.0 + offset),
                    mean_force_n,
                    contact_share: ramp.share,
                    amplitude_m,
                    drive_share,
                    stable: false,
                };
                return Ok(Trial { growth_per_s: motion.growth_per_s, cycle });
            }
            // Half steps: the share falls as the command grows, so whole steps may alternate for ever.
            drive_share = 0.5 * (drive_share + next);
        }
    }

    fn between(
        &self,
        mut grows: f64,
        mut decays: f64,
        first_grows: bool,
    ) -> Result<LimitCycle, AnalysisError> {
        if !first_grows {
            std::mem::swap(&mut grows, &mut decays);
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (grows + decays);
            if self.trial(middle)?.growth_per_s > 0.0 { grows = middle } else { decays = middle }
        }
        Ok(self.trial(0.5 * (grows + decays))?.cycle)
    }

    /// Mean of a command that oscillates with this amplitude, N: the root of an increasing function.
    fn mean_command(&self, amplitude_n: f64) -> f64 {
        let [alone, per_newton] = self.static_command;
        let excess = |u: f64| u - alone - per_newton * saturation(self.limit, u, amplitude_n)[0];
        // Exact without saturation, and close to it otherwise.
        let linear = alone / (1.0 - per_newton);
        if self.limit.is_infinite() {
            return linear;
        }
        let reach = alone.abs() + per_newton.abs() * self.limit + linear.abs();
        let (mut low, mut high) = (-reach, reach);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if excess(middle) < 0.0 { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }

    fn mean_force(&self, amplitude_n: f64) -> f64 {
        self.force_per_command * saturation(self.limit, self.mean_command(amplitude_n), amplitude_n)[0]
    }
}

/// The fastest growing oscillation of a linear loop.
struct Motion {
    growth_per_s: f64,
    frequency_hz: f64,
    /// Amplitude of the controller's output for one metre of compression.
    command_per_m: f64,
}

impl Motion {
    fn of(whole: &ControlLoop, controller: usize) -> Result<Self, AnalysisError> {
        let sampled = SampledLoop::new(whole)?;
        let domain = sampled.domain()?;
        let found = eigen(&sampled.closed_loop()?)?;
        let oscillates = |value: &C64| value.im >= 0.0 && domain.s_of_point(*value).im > TAU * DRIFT_HZ;
        let grown = |value: C64| domain.growth_per_s(value);
        let candidates = found.values.iter().zip(&found.vectors).filter(|(value, _)| oscillates(value));
        let Some((value, vector)) = candidates.max_by(|a, b| grown(*a.0).total_cmp(&grown(*b.0))) else {
            return Err(AnalysisError::NoLimitCycle { reason: "the loop does not oscillate" });
        };
        let compression = whole.plant().output(Source::Contact(0, Quantity::Compression))?;
        let plant_states = sampled.expand().ncols();
        let motion: DVector<C64> = sampled.expand().map(|v| C64::new(v, 0.0)) * vector.rows(0, plant_states);
        let moved: C64 = compression.c.iter().zip(motion.iter()).map(|(c, x)| x * *c).sum();
        Ok(Self {
            growth_per_s: grown(*value),
            frequency_hz: domain.s_of_point(*value).im / TAU,
            command_per_m: vector[plant_states + controller].norm() / moved.norm(),
        })
    }
}

/// Static gains of a law, approximately: from its reference and from its reading to its output.
fn static_law(spec: &ControllerSpec, motion_is_velocity: bool) -> Result<[f64; 2], AnalysisError> {
    let law = spec.linear(motion_is_velocity)?;
    let n = law.c.len();
    let resolvent =
        DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j)) * (1.0 + NEARLY_STATIC) - law.a[i][j]);
    let gain = |input: usize| {
        if n == 0 {
            return Some(law.d[input]);
        }
        let b = DVector::from_fn(n, |i, _| law.b[i][input]);
        let state = resolvent.clone().lu().solve(&b)?;
        Some(law.d[input] + law.c.iter().zip(state.iter()).map(|(c, x)| c * x).sum::<f64>())
    };
    match (gain(0), gain(1)) {
        (Some(reference), Some(reading)) => Ok([reference, reading]),
        _ => Err(AnalysisError::NoLimitCycle { reason: "the control law has no static gain" }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEPS: u32 = 200_000;
    /// The midpoint rule errs by the square of the step at a kink of the integrand.
    const KINK: f64 = 1e-9;
    /// The midpoint rule also errs by the height of each jump, over one step. There are two jumps of up to 2.
    const JUMP: f64 = 4.0 / STEPS as f64;

    /// Mean and first harmonic of a function of `offset + sin`, and of its damper.
    fn by_quadrature(offset: f64) -> [f64; 3] {
        let mut sums = [0.0; 3];
        for i in 0..STEPS {
            let angle = TAU * (f64::from(i) + 0.5) / f64::from(STEPS);
            let (sin, cos) = angle.sin_cos();
            if offset + sin > 0.0 {
                sums[0] += offset + sin;
                sums[1] += 2.0 * (offset + sin) * sin;
                sums[2] += 2.0 * cos * cos;
            }
        }
        sums.map(|sum| sum / f64::from(STEPS))
    }

    #[test]
    fn truth_equivalent_gains_are_fourier_coefficients() {
        for offset in [-0.9, -0.4, 0.0, 0.3, 0.8, 1.0, 2.5] {
            let ramp = Ramp::new(offset);
            let [mean, harmonic, damper] = by_quadrature(offset);
            for (found, truth, tolerance) in
                [(ramp.mean, mean, KINK), (ramp.harmonic, harmonic, KINK), (ramp.harmonic, damper, JUMP)]
            {
                assert!((found - truth).abs() <= tolerance, "{offset}: {found} {truth}");
            }
        }
    }

    #[test]
    fn truth_saturation_has_its_textbook_describing_function() {
        // Slotine and Li, "Applied Nonlinear Control", eq. 5.20, for a limit of half the amplitude.
        let r: f64 = 0.5;
        let textbook = 2.0 / PI * (r.asin() + r * (1.0 - r * r).sqrt());
        let [mean, share] = saturation(1.0, 0.0, 2.0);
        assert!(
            (share - textbook).abs() <= 4.0 * f64::EPSILON && mean.abs() <= 4.0 * f64::EPSILON,
            "{share} {textbook}"
        );
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "what passes does so unchanged")]
    fn truth_what_stays_within_the_limit_passes() {
        assert_eq!(saturation(10.0, 3.0, 5.0), [3.0, 1.0]);
    }

    #[test]
    fn truth_offsets_fall() {
        let all: Vec<f64> = offsets().collect();
        assert!(all.windows(2).all(|pair| pair[1] < pair[0]), "{all:?}");
    }
}
