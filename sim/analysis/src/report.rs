//! Everything at once, in the shape that programs read (`feeler analyze --json`).

use feeler_engine::Scenario;
use feeler_lti::{LoopTransfer, Margins};
use feeler_plant::assembly::Source;
use feeler_plant::description::{Contact, Engagement, Quantity, SignalName};
use serde::Serialize;

use crate::control_loop::ControlLoop;
use crate::error::AnalysisError;
use crate::limit_cycle::{LimitCycle, limit_cycles};
use crate::modes::{BodyMotion, ModeClass, classify, modes};
use crate::prepare::View;
use crate::sampled_loop::SampledLoop;
use crate::stability::GainBands;
use crate::waterfall::{Limit, Sensitivity, Waterfall};

/// What to analyse; what is absent is chosen from the scenario.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Request {
    /// An actuator's command; else that of the first controller's actuator, or of the first actuator.
    pub input: Option<SignalName>,
    /// A signal; else what the first controller's sensor reads, or the first contact's spring force.
    pub output: Option<SignalName>,
    /// A gain; else the first controller's leading one.
    pub gain: Option<String>,
    /// How the machine is taken.
    pub view: View,
    /// Whether to find out how the bandwidth answers to every mass, stiffness and damping.
    pub sensitivities: bool,
}

/// A mode for the pair of input and output.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModeReport {
    /// |s| / 2 pi.
    pub frequency_hz: f64,
    /// -Re s / |s|.
    pub damping_ratio: f64,
    /// Its class for input and output.
    pub class: ModeClass,
    /// Phase that is lost for good beyond it.
    pub phase_change_deg: f64,
    /// Largest lag on the way.
    pub phase_dip_deg: f64,
    /// Whether it is the rigid-body motion.
    pub rigid_body: bool,
    /// Phase that it takes at the loop's crossover; absent without a crossover.
    pub margin_cost_deg: Option<f64>,
    /// How far each body moves.
    pub shape: Vec<BodyMotion>,
}

/// Stable values of a gain about its present value.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StableRange {
    /// Lower and upper edge; absent where there is none.
    pub stable: [Option<f64>; 2],
    /// Frequency at the upper edge, Hz (at the lower one where there is no upper).
    pub edge_hz: Option<f64>,
    /// Index of the mode that the motion at that edge is most like.
    pub edge_mode: Option<usize>,
    /// Every interval.
    pub all: GainBands,
}

/// Stable values of a gain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GainReport {
    /// The gain's key.
    pub key: String,
    /// In the loop without sampling, delay and filters; absent where the law has no such form.
    pub continuous: Option<StableRange>,
    /// In the loop as built.
    pub sampled: StableRange,
}

/// Margins of the sampled loop broken at its controller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MarginReport {
    /// Factor by which the gain may rise; absent where no rise destabilises, and where the loop is unstable.
    pub gain: Option<f64>,
    /// Factor by which the gain may fall, or at which an unstable loop first meets its limit; absent where no fall meets it.
    pub gain_decrease: Option<f64>,
    /// Smallest phase margin; absent where the loop is unstable.
    pub phase_deg: Option<f64>,
    /// Delay that the loop bears in addition, s; absent where the loop is unstable.
    pub delay_s: Option<f64>,
    /// Crossover with the smallest phase margin, Hz.
    pub crossover_hz: Option<f64>,
    /// Balanced disk margin, 0 to 2.
    pub disk: f64,
    /// Largest modulus of the sensitivity.
    pub sensitivity_peak: f64,
    /// Largest modulus of the complementary sensitivity.
    pub complementary_sensitivity_peak: f64,
    /// Unstable poles of the closed loop by Nyquist's count.
    pub unstable_poles: usize,
    /// Unstable poles of the open loop, from which the count starts.
    pub open_unstable_poles: usize,
}

/// The analysis of one scenario.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The input.
    pub input: String,
    /// The output.
    pub output: String,
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
    /// Modes by rising frequency.
    pub modes: Vec<ModeReport>,
    /// Absent without a controller that closes a loop.
    pub gain: Option<GainReport>,
    /// Absent as the gain, and where the loop varies in time.
    pub margins: Option<MarginReport>,
    /// Absent as the gain.
    pub limit: Option<Limit>,
    /// The account behind the limit.
    pub waterfall: Option<Waterfall>,
    /// Chatter of a contact that only pushes, as describing functions predict it; empty where there is none or the theory does not apply.
    pub limit_cycles: Vec<LimitCycle>,
    /// What to stiffen, lighten or damp first: the most telling number first; empty unless asked for.
    pub sensitivities: Vec<Sensitivity>,
}

/// Analyses a scenario.
///
/// # Errors
/// The mistakes of the scenario or the request; [`AnalysisError::Lti`].
pub fn analyze(scenario: &Scenario, request: &Request) -> Result<Report, AnalysisError> {
    let whole = match &request.gain {
        Some(key) => ControlLoop::varying(scenario, &request.view, key)?,
        None => ControlLoop::new(scenario, &request.view)?,
    };
    let plant = whole.plant();
    let (input, output) = request.signals(scenario, &whole)?;
    let channel = plant.channel(&input, &output)?;
    let pairs = |points: Vec<feeler_lti::C64>| points.into_iter().map(|p| [p.re, p.im]).collect::<Vec<_>>();
    let own = modes(plant)?;
    let classified = classify(plant, &own, plant.drive(&input)?, plant.source(&output)?, &channel)?;

    let key = request.gain.clone().or_else(|| whole.default_gain_key());
    let (mut gain, mut margins, mut waterfall, mut sensitivities) = (None, None, None, Vec::new());
    if let Some(key) = key {
        let (controller, name) = whole.gain_of_key(&key)?;
        let present = crate::gain_key::gain(&whole.controllers()[controller].spec, &name)?;
        let continuous = match whole.continuous_bands(&key) {
            Ok(bands) => Some(StableRange::about(present, bands)),
            Err(AnalysisError::Improper { .. }) => None,
            Err(other) => return Err(other),
        };
        let sampled = StableRange::about(present, whole.sampled_bands(&key)?);
        margins = match SampledLoop::new(&whole)?.open_loop(controller) {
            Ok(open) => Some(MarginReport::new(&LoopTransfer::discrete(&open)?)?),
            Err(AnalysisError::SlowerThanLoop { .. }) => None,
            Err(other) => return Err(other),
        };
        if continuous.is_some() && margins.is_some() {
            waterfall = Some(whole.waterfall(&key, &own, &classified)?);
        }
        if request.sensitivities && margins.is_some() {
            sensitivities = whole.sensitivities(&key)?;
        }
        gain = Some(GainReport { key, continuous, sampled });
    }
    let pushes_only = scenario.machine.contacts.values().any(|contact| contact.engagement == Engagement::Unilateral);
    let limit_cycles = match pushes_only.then(|| limit_cycles(scenario)) {
        None | Some(Err(AnalysisError::NoLimitCycle { .. })) => Vec::new(),
        Some(found) => found?,
    };
    let crossover_hz = margins.as_ref().and_then(|m: &MarginReport| m.crossover_hz);
    let described = own.iter().zip(&classified).map(|(mode, pair)| ModeReport {
        frequency_hz: mode.frequency_hz(),
        damping_ratio: mode.damping_ratio(),
        class: pair.class,
        phase_change_deg: pair.phase_change_deg,
        phase_dip_deg: pair.dip_deg,
        rigid_body: pair.rigid_body,
        margin_cost_deg: crossover_hz.map(|f| {
            let factor = pair.factor(mode, feeler_lti::C64::new(0.0, std::f64::consts::TAU * f));
            if pair.class == ModeClass::Uninvolved { 0.0 } else { -factor.arg().to_degrees() }
        }),
        shape: mode.shape.clone(),
    });
    Ok(Report {
        input: input.to_string(),
        output: output.to_string(),
        delay_s: channel.delay_s,
        poles: pairs(channel.poles()?),
        zeros: pairs(channel.zeros()?),
        poles_hz: channel.poles_hz()?,
        zeros_hz: channel.zeros_hz()?,
        modes: described.collect(),
        gain,
        margins,
        limit: waterfall.as_ref().map(|w| w.limit),
        waterfall,
        limit_cycles,
        sensitivities,
    })
}

impl Request {
    fn signals(&self, scenario: &Scenario, whole: &ControlLoop) -> Result<(SignalName, SignalName), AnalysisError> {
        let machine = &scenario.machine;
        let first = whole.controllers().iter().find(|c| c.reading.is_some()).or(whole.controllers().first());
        let drive = first.map_or(0, |c| c.drive);
        let input =
            self.input.clone().or_else(|| machine.actuators.get_index(drive).map(|(name, _)| SignalName::new(name, Quantity::Command)));
        let input = input.ok_or_else(|| AnalysisError::NotAnInput { name: "(no actuator)".into() })?;
        let read = first.and_then(|c| c.reading).and_then(|i| machine.sensors.get_index(i)).map(|(_, sensor)| sensor.reads.clone());
        // A contact that is absent feels nothing: what moves then is the body that would touch.
        let felt = |(i, (name, contact)): (usize, (&String, &Contact))| {
            let part = whole.plant().motion().assembly().contacts.get(i)?;
            Some(match part.engagement {
                Engagement::Free => SignalName::new(&contact.between[0], Quantity::Acceleration),
                _ => SignalName::new(name, Quantity::SpringForce),
            })
        };
        let pressed = || machine.contacts.iter().enumerate().find_map(felt);
        let output = self.output.clone().or(read).or_else(pressed);
        let output = output.ok_or_else(|| AnalysisError::NotLinear { name: "(no sensor and no contact)".into() })?;
        if let Source::Drive(_, Quantity::Command) = whole.plant().source(&output)? {
            return Err(AnalysisError::NotLinear { name: output.to_string() });
        }
        Ok((input, output))
    }
}

impl StableRange {
    fn about(present: f64, all: GainBands) -> Self {
        let Some(band) = all.nearest(present) else { return Self { stable: [None, None], all, ..Self::default() } };
        let edge = band.upper.as_ref().or(band.lower.as_ref());
        Self {
            stable: [Some(band.lower.as_ref().map_or(0.0, |e| e.gain)), band.upper.as_ref().map(|e| e.gain)],
            edge_hz: edge.map(|e| e.frequency_hz),
            edge_mode: edge.and_then(|e| e.mode),
            all: all.clone(),
        }
    }
}

impl MarginReport {
    /// The margins of a loop.
    ///
    /// # Errors
    /// [`AnalysisError::Lti`].
    pub fn new<T: feeler_lti::TimeDomain>(open: &LoopTransfer<T>) -> Result<Self, AnalysisError> {
        let margins: Margins = open.margins()?;
        let unstable_poles = open.closed_loop_unstable_poles(1.0)?;
        let stable = unstable_poles == 0;
        let phase = margins.smallest_phase();
        Ok(Self {
            gain: margins.smallest_increase().filter(|_| stable).map(|m| m.factor),
            gain_decrease: margins.smallest_decrease().map(|m| m.factor),
            phase_deg: phase.filter(|_| stable).map(|p| p.margin_deg()),
            delay_s: margins.smallest_delay().filter(|_| stable).map(|p| p.delay_s),
            crossover_hz: phase.map(|p| p.frequency_hz),
            disk: margins.disk.alpha,
            sensitivity_peak: margins.sensitivity.value,
            complementary_sensitivity_peak: margins.complementary_sensitivity.value,
            unstable_poles,
            open_unstable_poles: open.unstable_poles(),
        })
    }
}
