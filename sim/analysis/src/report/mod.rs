//! The complete analysis, as programs read it (`feeler analyze --json`).

mod json;
mod of_loop;
mod signals;

use std::borrow::Cow;

use feeler_engine::Scenario;
use feeler_lti::{Continuous, frequencies_hz};
use feeler_plant::description::{Engagement, Quantity, SignalName};
use nalgebra::DMatrix;
use serde::Serialize;

use crate::error::AnalysisError;
use crate::limits::limit_cycle::{LimitCycle, limit_cycles};
use crate::limits::margins::MarginReport;
use crate::limits::sensitivity::{RankedBy, Sensitivity};
use crate::limits::waterfall::{Limit, Waterfall};
use crate::loops::control_loop::ControlLoop;
use crate::loops::loop_pair::LoopPair;
use crate::machine::assumptions::Assumption;
use crate::machine::channel::ResponseChannel;
use crate::machine::modes::{BodyMotion, ModeClass, ModeInPair, VibrationMode, classify, modes, undamped_hz};
use crate::machine::outer_force::commanded;
use crate::machine::prepare::View;
use crate::workers::Workers;

pub use of_loop::{GainReport, LoopReport, StableRange, WhyNoWaterfall};

/// Roundings of an eigenvalue of the matrix of stiffness over mass.
const ROUNDINGS: f64 = 16.0;

/// The request: absent fields are chosen from the scenario.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Request {
    /// An actuator's command, or the external force on a body, as in `tip.force`. The default is the actuator
    /// of the controller in question, or the first actuator.
    pub input: Option<SignalName>,
    /// A signal. The default is the signal that the sensor of the controller in question reads. Without a
    /// controller it is the first contact's spring force, then the reading of the first sensor, then the
    /// position of the driven body.
    pub output: Option<SignalName>,
    /// A gain; by default the first controller's leading one.
    pub gain: Option<String>,
    /// The linear view of the machine.
    pub view: View,
    /// Whether to compute sensitivities of the bandwidth to every mass, stiffness and damping.
    pub sensitivities: bool,
    /// Threads that compute the sensitivities.
    pub workers: Workers,
    /// Whether to skip the slow parts: the waterfall of the bandwidth, chatter by describing functions, and
    /// the curves of the plant.
    pub brief: bool,
    /// Whether to skip the root loci, which take up to a third of the time of a brief request.
    pub without_loci: bool,
}

/// A mode for the pair of input and output.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModeReport {
    /// Modulus of its pole over 2 pi.
    pub frequency_hz: f64,
    /// Negative real part of its pole over the modulus.
    pub damping_ratio: f64,
    /// Its class for input and output.
    pub class: ModeClass,
    /// Its class in the loop; `None` without a loop.
    pub class_in_loop: Option<ModeClass>,
    /// Phase that remains lost beyond the mode.
    pub phase_change_deg: f64,
    /// Largest phase lag near the mode.
    pub phase_dip_deg: f64,
    /// Whether it is the rigid-body motion.
    pub rigid_body: bool,
    /// Phase that it takes at the loop's crossover; `None` without a crossover.
    pub margin_cost_deg: Option<f64>,
    /// How far each body moves.
    pub shape: Vec<BodyMotion>,
}

/// A linear system `x' = A x + B u`, `y = C x + D u`, SI; the delay is separate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StateSpaceReport {
    /// Rows of A.
    pub a: Vec<Vec<f64>>,
    /// Rows of B.
    pub b: Vec<Vec<f64>>,
    /// Rows of C.
    pub c: Vec<Vec<f64>>,
    /// Rows of D.
    pub d: Vec<Vec<f64>>,
    /// Names of the states.
    pub states: Vec<String>,
    /// Names of the inputs.
    pub inputs: Vec<String>,
    /// Names of the outputs.
    pub outputs: Vec<String>,
}

impl StateSpaceReport {
    fn new(channel: &ResponseChannel, input: &SignalName, output: &SignalName) -> Self {
        let rows = |m: &DMatrix<f64>| m.row_iter().map(|row| row.iter().copied().collect()).collect();
        let system = &channel.system;
        Self {
            a: rows(system.a()),
            b: rows(system.b()),
            c: rows(system.c()),
            d: rows(system.d()),
            states: channel.states.clone(),
            inputs: vec![input.to_string()],
            outputs: vec![output.to_string()],
        }
    }
}

/// The analysis of one scenario.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Signal that excites the machine.
    pub input: String,
    /// Signal that is observed.
    pub output: String,
    /// Force on the first contact at the operating point, N (N m for a rotary machine); `None` without a
    /// contact.
    pub preload_n: Option<f64>,
    /// Exact delay from input to output beside poles and zeros, s.
    pub delay_s: f64,
    /// Real and imaginary part, rad/s.
    pub poles: Vec<[f64; 2]>,
    /// Real and imaginary part, rad/s.
    pub zeros: Vec<[f64; 2]>,
    /// Moduli over 2 pi, conjugate pairs once.
    pub poles_hz: Vec<f64>,
    /// Moduli over 2 pi, conjugate pairs once.
    pub zeros_hz: Vec<f64>,
    /// Gain of the factored form: the response without its delay is this times the product of (s - zero) over
    /// the product of (s - pole). `None` if the output does not depend on the input.
    pub zero_pole_gain: Option<f64>,
    /// The linear system with these poles and zeros.
    pub state_space: StateSpaceReport,
    /// Modes by rising frequency.
    pub modes: Vec<ModeReport>,
    /// The loop of the gain in question; absent without a controller that closes a loop.
    pub looped: Option<LoopReport>,
    /// Frequencies of undamped modes that the loop observes, Hz.
    pub undamped_hz: Vec<f64>,
    /// Chatter of a contact that only pushes, as describing functions predict it; empty if there is none or
    /// the theory does not apply.
    pub limit_cycles: Vec<LimitCycle>,
    /// Nonlinear properties of the machine and their linear replacements.
    pub assumptions: Vec<Assumption>,
}

impl Report {
    /// Poles and zeros up to this modulus are rounding, 1/s: a spring that should hold them is lost beside
    /// far stiffer ones. `None` if there is no such spring.
    pub fn lost_below_per_s(&self) -> Option<f64> {
        // Rounding applies to the squares.
        let largest = self.poles.iter().map(|[re, im]| re.hypot(*im)).fold(0.0, f64::max);
        let is_lost = self.assumptions.iter().any(Assumption::is_of_lost_spring);
        is_lost.then_some((ROUNDINGS * f64::EPSILON).sqrt() * largest)
    }

    /// The signals between which the loop is closed.
    pub fn pair(&self) -> Option<&LoopPair> {
        self.looped.as_ref()?.pair.as_ref()
    }

    /// The gain in question and its stable values.
    pub fn gain(&self) -> Option<&GainReport> {
        self.looped.as_ref().map(|of| &of.gain)
    }

    /// Margins of the sampled loop.
    pub fn margins(&self) -> Option<&MarginReport> {
        self.looped.as_ref()?.margins.as_ref()
    }

    /// The waterfall: what limits the bandwidth.
    pub fn waterfall(&self) -> Option<&Waterfall> {
        self.looped.as_ref()?.waterfall.as_ref()
    }

    /// The problem, or the limit, that bounds the bandwidth.
    pub fn limit(&self) -> Option<Limit> {
        self.looped.as_ref()?.limit()
    }

    /// Why there is no waterfall.
    pub fn why_no_waterfall(&self) -> Option<&WhyNoWaterfall> {
        self.looped.as_ref()?.why_no_waterfall.as_ref()
    }

    /// Sensitivities, the most important first; empty unless requested.
    pub fn sensitivities(&self) -> &[Sensitivity] {
        self.looped.as_ref().map_or(&[], |of| &of.sensitivities)
    }

    /// The criterion of their ranking.
    pub fn ranked_by(&self) -> Option<RankedBy> {
        self.looped.as_ref()?.ranked_by
    }
}

/// Analyses a scenario.
///
/// # Errors
/// The mistakes of the scenario or the request; [`AnalysisError::Lti`].
pub fn analyze(scenario: &Scenario, request: &Request) -> Result<Report, AnalysisError> {
    let (scenario, asked) = match &request.input {
        Some(input) => {
            let (scenario, command) = commanded(scenario, input);
            (scenario, Some(command))
        }
        None => (Cow::Borrowed(scenario), None),
    };
    let scenario = scenario.as_ref();
    let whole = match &request.gain {
        Some(key) => ControlLoop::varying(scenario, &request.view, key)?,
        None => ControlLoop::new(scenario, &request.view)?,
    };
    let plant = whole.plant();
    let (input, output) = request.signals(asked, scenario, &whole)?;
    let channel = plant.channel(&input, &output)?;
    let own = modes(plant)?;
    let drive = plant.drive(&input)?;
    let classified = classify(plant, &own, drive, plant.source(&output)?, &channel)?;
    let looped = (request.gain.clone().or_else(|| whole.default_gain_key()))
        .map(|key| LoopReport::new(&scenario.machine, &whole, &key, &own, &classified, request))
        .transpose()?;
    let (looped, in_loop) = looped.unzip();
    let in_loop = in_loop.flatten();
    let crossover_hz = (looped.as_ref())
        .and_then(|of: &LoopReport| of.margins.as_ref())
        .and_then(|margins| margins.crossover_hz);
    let form = channel.zero_pole_gain()?;
    let (poles, zeros, factor) = match form {
        Some(form) => (form.poles, form.zeros, Some(form.leading_coefficient)),
        None => (channel.poles()?, Vec::new(), None),
    };
    let pairs = |points: &[feeler_lti::C64]| points.iter().map(|p| [p.re, p.im]).collect::<Vec<_>>();
    let own_input = plant.input(drive);
    let is_servo = own_input.quantity == Quantity::Force;
    let named = request.input.as_ref().filter(|_| !is_servo).unwrap_or(&own_input);
    Ok(Report {
        input: named.to_string(),
        output: output.to_string(),
        preload_n: Some(request.view.preload_n()).filter(|force| *force > 0.0),
        delay_s: channel.delay_s,
        poles: pairs(&poles),
        zeros: pairs(&zeros),
        poles_hz: frequencies_hz(Continuous, &poles),
        zeros_hz: frequencies_hz(Continuous, &zeros),
        zero_pole_gain: factor,
        state_space: StateSpaceReport::new(&channel, named, &output),
        modes: described(&own, &classified, in_loop.as_deref(), crossover_hz),
        undamped_hz: undamped_hz(&own, in_loop.as_deref().unwrap_or(&classified)),
        looped,
        limit_cycles: if request.brief { Vec::new() } else { chatter(scenario)? },
        assumptions: whole.assumptions(&request.view),
    })
}

/// Modes between input and output, and in the loop.
fn described(
    own: &[VibrationMode],
    classified: &[ModeInPair],
    in_loop: Option<&[ModeInPair]>,
    crossover_hz: Option<f64>,
) -> Vec<ModeReport> {
    let describe = |(i, mode): (usize, &VibrationMode)| {
        let (asked, looped) = (&classified[i], in_loop.map_or(&classified[i], |pairs| &pairs[i]));
        ModeReport {
            frequency_hz: mode.frequency_hz(),
            damping_ratio: mode.damping_ratio(),
            class: asked.class,
            class_in_loop: in_loop.map(|_| looped.class),
            phase_change_deg: asked.phase_change_deg,
            phase_dip_deg: asked.dip_deg,
            rigid_body: asked.rigid_body,
            margin_cost_deg: crossover_hz.map(|f| {
                let factor = looped.factor(mode, feeler_lti::C64::new(0.0, std::f64::consts::TAU * f));
                if looped.class == ModeClass::Uninvolved { 0.0 } else { -factor.arg().to_degrees() }
            }),
            shape: mode.shape.clone(),
        }
    };
    own.iter().enumerate().map(describe).collect()
}

/// Limit cycles of contacts that only push; `None` if the theory does not apply.
fn chatter(scenario: &Scenario) -> Result<Vec<LimitCycle>, AnalysisError> {
    let pushes_only =
        scenario.machine.contacts.values().any(|contact| contact.engagement == Engagement::Unilateral);
    match pushes_only.then(|| limit_cycles(scenario)) {
        None | Some(Err(AnalysisError::NoLimitCycle { .. } | AnalysisError::LongDelay { .. })) => {
            Ok(Vec::new())
        }
        Some(found) => found,
    }
}
