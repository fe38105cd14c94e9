//! Everything at once, in the shape that programs read (`feeler analyze --json`).

use std::borrow::Cow;

use feeler_engine::Scenario;
use feeler_plant::assembly::Source;
use feeler_plant::description::{Contact, Engagement, GROUND, Quantity, SignalName};
use nalgebra::DMatrix;
use serde::Serialize;

use crate::error::AnalysisError;
use crate::limits::limit_cycle::{LimitCycle, limit_cycles};
use crate::limits::margins::MarginReport;
use crate::limits::sensitivity::{RankedBy, Sensitivity, rank};
use crate::limits::stability::{Band, BelowZero, Edge, GainBands, nearest};
use crate::limits::waterfall::{Limit, Waterfall};
use crate::loops::control_loop::ControlLoop;
use crate::loops::loop_pair::{LoopReport, loop_pair};
use crate::machine::assumptions::Assumption;
use crate::machine::channel::Channel;
use crate::machine::modes::{BodyMotion, Mode, ModeClass, ModeInPair, classify, modes};
use crate::machine::outer_force::commanded;
use crate::machine::prepare::View;
use crate::workers::Workers;

/// Damping ratios below this are rounding.
const UNDAMPED: f64 = 1e-9;

/// What to analyse; what is absent is chosen from the scenario.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Request {
    /// An actuator's command, or the force from outside on a body, as in `tip.force`; else that of the
    /// actuator of the controller in question, or of the first actuator.
    pub input: Option<SignalName>,
    /// A signal; else what the sensor of the controller in question reads, the first contact's spring force,
    /// what the first sensor reads, or the position of the driven body.
    pub output: Option<SignalName>,
    /// A gain; else the first controller's leading one.
    pub gain: Option<String>,
    /// How the machine is taken.
    pub view: View,
    /// Whether to find out how the bandwidth answers to every mass, stiffness and damping.
    pub sensitivities: bool,
    /// Who finds them out.
    pub workers: Workers,
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
    /// Its class in the loop; absent without one.
    pub class_in_loop: Option<ModeClass>,
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
    /// Smallest and largest stable gain of those that are not below zero (of those below, where the present
    /// gain is); absent where there is none.
    pub stable: [Option<f64>; 2],
    /// Frequency at the upper edge, Hz (at the lower one where there is no upper).
    pub edge_hz: Option<f64>,
    /// Index of the mode that the motion at that edge is most like.
    pub edge_mode: Option<usize>,
    /// Both edges of the interval, the lower one wherever it is, also below zero; absent where the interval
    /// has no end.
    pub edges: [Option<Edge>; 2],
    /// Every interval on either side of zero, rising.
    pub intervals: Vec<Band>,
    /// Every interval of gains from zero on.
    pub all: GainBands,
}

/// Stable values of a gain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GainReport {
    /// The gain's key.
    pub key: String,
    /// Its value in the file.
    pub present: f64,
    /// In the loop without sampling, delay and filters; absent where the law has no such form.
    pub continuous: Option<StableRange>,
    /// In the loop as built.
    pub sampled: StableRange,
}

/// A linear system `x' = A x + B u`, `y = C x + D u`, SI; the delay stands beside it.
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
    /// What the states are.
    pub states: Vec<String>,
    /// What the inputs are.
    pub inputs: Vec<String>,
    /// What the outputs are.
    pub outputs: Vec<String>,
}

impl StateSpaceReport {
    fn new(channel: &Channel, input: &SignalName, output: &SignalName) -> Self {
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
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The input.
    pub input: String,
    /// The output.
    pub output: String,
    /// Force with which the first contact is pressed where the machine is linearised, N (N m for a rotary
    /// machine); absent without one.
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
    /// The response, without its delay, is this times the product of (s - zero) over the product of (s -
    /// pole); absent where the output does not depend on the input.
    pub zero_pole_gain: Option<f64>,
    /// The linear system of which these are poles and zeros.
    pub state_space: StateSpaceReport,
    /// Modes by rising frequency.
    pub modes: Vec<ModeReport>,
    /// The loop that all that follows is of, whatever input and output are; absent without a controller that
    /// reads something.
    #[serde(rename = "loop")]
    pub of_loop: Option<LoopReport>,
    /// Absent without a controller that closes a loop.
    pub gain: Option<GainReport>,
    /// Absent as the gain, and where the loop varies in time.
    pub margins: Option<MarginReport>,
    /// Why there is no account of what limits the bandwidth; absent where there is one, or no loop.
    pub untold: Option<Untold>,
    /// Frequencies of modes without any damping that the loop sees, Hz.
    pub undamped_hz: Vec<f64>,
    /// Absent as the gain.
    pub limit: Option<Limit>,
    /// The account behind the limit.
    pub waterfall: Option<Waterfall>,
    /// Chatter of a contact that only pushes, as describing functions predict it; empty where there is none
    /// or the theory does not apply.
    pub limit_cycles: Vec<LimitCycle>,
    /// What to stiffen, lighten or damp first: the most telling number first; empty unless asked for.
    pub sensitivities: Vec<Sensitivity>,
    /// By what they are ranked; absent where there are none.
    pub ranked_by: Option<RankedBy>,
    /// What of the machine is not linear, and what is taken in its place.
    pub assumptions: Vec<Assumption>,
}

/// Why the bandwidth of a loop has no account.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "reason", rename_all = "kebab-case")]
pub enum Untold {
    /// Another controller is sampled more slowly, so that the loop broken at this one varies in time.
    SlowerLoop {
        /// This one.
        controller: String,
        /// Its period, s.
        period_s: f64,
        /// The period with which all repeat together, s.
        common_s: f64,
        /// The controller that has this period, at which the loop can be broken; absent where no period is a
        /// multiple of all others.
        slowest: Option<String>,
    },
    /// The law's continuous form differentiates a signal that jumps with the command, so that there is no
    /// loop on paper.
    NoContinuousForm {
        /// The controller.
        controller: String,
    },
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
    let pairs = |points: Vec<feeler_lti::C64>| points.into_iter().map(|p| [p.re, p.im]).collect::<Vec<_>>();
    let own = modes(plant)?;
    let classified = classify(plant, &own, plant.drive(&input)?, plant.source(&output)?, &channel)?;

    let key = request.gain.clone().or_else(|| whole.default_gain_key());
    let (mut gain, mut margins, mut waterfall, mut sensitivities, mut ranked_by) =
        (None, None, None, Vec::new(), None);
    let (mut pair, mut untold) = (None, None);
    if let Some(key) = key {
        let (controller, name) = whole.gain_of_key(&key)?;
        pair = loop_pair(&scenario.machine, &whole, controller, &name, &own)?;
        let present = crate::loops::gain_key::gain(&whole.controllers()[controller].spec, &name)?;
        let continuous = match whole.continuous_bands(&key) {
            Ok(bands) => Some(StableRange::about(present, bands, whole.continuous_bands_below_zero(&key)?)),
            Err(AnalysisError::Improper { name }) => {
                untold = Some(Untold::NoContinuousForm { controller: name });
                None
            }
            Err(other) => return Err(other),
        };
        let sampled =
            StableRange::about(present, whole.sampled_bands(&key)?, whole.sampled_bands_below_zero(&key)?);
        margins = match whole.open_loop(controller) {
            Ok(open) => Some(MarginReport::new(&open.transfer()?)?),
            Err(AnalysisError::SlowerThanLoop { name, period_s, common_s }) => {
                let slowest = whole
                    .controllers()
                    .iter()
                    .find(|c| (common_s - c.spec.period_s).abs() <= 1e-9 * common_s);
                let slowest = slowest.map(|controller| controller.name.clone());
                untold = Some(Untold::SlowerLoop { controller: name, period_s, common_s, slowest });
                None
            }
            Err(other) => return Err(other),
        };
        if continuous.is_some() && margins.is_some() {
            waterfall = Some(whole.waterfall(
                &key,
                &own,
                pair.as_ref().map_or(&classified, |(_, in_loop)| in_loop),
            )?);
        }
        if request.sensitivities && margins.is_some() {
            sensitivities = whole.sensitivities(&key, request.workers)?;
            let by = match &waterfall {
                Some(Waterfall { limit: Limit::Saturation, .. }) => RankedBy::Saturation,
                Some(Waterfall { rides_mode: Some(_), .. }) => RankedBy::LargestGain,
                _ => RankedBy::BandwidthAndGain,
            };
            rank(&mut sensitivities, by);
            ranked_by = (!sensitivities.is_empty()).then_some(by);
        }
        gain = Some(GainReport { key, present, continuous, sampled });
    }
    let pushes_only =
        scenario.machine.contacts.values().any(|contact| contact.engagement == Engagement::Unilateral);
    let limit_cycles = match pushes_only.then(|| limit_cycles(scenario)) {
        None | Some(Err(AnalysisError::NoLimitCycle { .. } | AnalysisError::LongDelay { .. })) => Vec::new(),
        Some(found) => found?,
    };
    let crossover_hz = margins.as_ref().and_then(|m: &MarginReport| m.crossover_hz);
    let in_loop = pair.as_ref().map(|(_, pairs): &(LoopReport, Vec<ModeInPair>)| pairs);
    let undamped_hz = undamped_hz(&own, in_loop.unwrap_or(&classified));
    let described = own.iter().enumerate().map(|(i, mode)| {
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
    });
    let named = request.input.as_ref().unwrap_or(&input);
    Ok(Report {
        input: named.to_string(),
        output: output.to_string(),
        preload_n: Some(request.view.preload_n()).filter(|force| *force > 0.0),
        delay_s: channel.delay_s,
        poles: pairs(channel.poles()?),
        zeros: pairs(channel.zeros()?),
        poles_hz: channel.poles_hz()?,
        zeros_hz: channel.zeros_hz()?,
        zero_pole_gain: channel.zero_pole_gain()?.map(|form| form.leading_coefficient),
        state_space: StateSpaceReport::new(&channel, named, &output),
        modes: described.collect(),
        of_loop: pair.map(|(report, _)| report),
        gain,
        margins,
        untold,
        undamped_hz,
        limit: waterfall.as_ref().map(|w| w.limit),
        waterfall,
        limit_cycles,
        sensitivities,
        ranked_by,
        assumptions: whole.assumptions(&request.view),
    })
}

/// Frequencies of modes that nothing damps and that a pair of actuator and sensor sees, Hz.
pub(crate) fn undamped_hz(modes: &[Mode], pairs: &[ModeInPair]) -> Vec<f64> {
    let seen = modes.iter().zip(pairs).filter(|(_, pair)| pair.class != ModeClass::Uninvolved);
    seen.filter(|(mode, _)| mode.damping_ratio().abs() < UNDAMPED)
        .map(|(mode, _)| mode.frequency_hz())
        .collect()
}

impl Request {
    /// Input, where none is `asked` for that of the loop, and output.
    fn signals(
        &self,
        asked_input: Option<SignalName>,
        scenario: &Scenario,
        whole: &ControlLoop,
    ) -> Result<(SignalName, SignalName), AnalysisError> {
        let machine = &scenario.machine;
        // The controller whose gain is asked for, if it reads something.
        let key = self.gain.clone().or_else(|| whole.default_gain_key());
        let asked =
            key.and_then(|key| whole.gain_of_key(&key).ok()).map(|(i, gain)| (&whole.controllers()[i], gain));
        let asked =
            asked.and_then(|(controller, gain)| Some((controller, controller.sensor_of_gain(&gain)?)));
        let reads_something = || whole.controllers().iter().find_map(|c| Some((c, c.fed_back()?)));
        let (first, sensor) = asked
            .or_else(reads_something)
            .map_or((whole.controllers().first(), None), |(c, i)| (Some(c), Some(i)));
        let drive = first.map_or(0, |c| c.drive);
        let input = asked_input.or_else(|| {
            machine.actuators.get_index(drive).map(|(name, _)| SignalName::new(name, Quantity::Command))
        });
        let input = input.ok_or_else(|| AnalysisError::NotAnInput { name: "(no actuator)".into() })?;
        let read = sensor.and_then(|i| machine.sensors.get_index(i)).map(|(_, sensor)| sensor.reads.clone());
        // A contact that is absent feels nothing: what moves then is the body that would touch.
        let felt = |(i, (name, contact)): (usize, (&String, &Contact))| {
            let part = whole.plant().motion().assembly().contacts.get(i)?;
            Some(match part.engagement {
                Engagement::Free => SignalName::new(&contact.between[0], Quantity::Acceleration),
                _ => SignalName::new(name, Quantity::SpringForce),
            })
        };
        let pressed = || machine.contacts.iter().enumerate().find_map(felt);
        let any_sensor = || machine.sensors.values().next().map(|sensor| sensor.reads.clone());
        // Where nothing is sensed, the body that is driven tells what the drive does.
        let driven = || {
            let (_, actuator) = machine.actuators.get_index(drive)?;
            let body = [&actuator.on, &actuator.reacts_on].into_iter().find(|end| *end != GROUND)?;
            Some(SignalName::new(body, Quantity::Position))
        };
        let output = self.output.clone().or(read).or_else(pressed).or_else(any_sensor).or_else(driven);
        let output = output.ok_or_else(|| AnalysisError::NotAnInput { name: "(no actuator)".into() })?;
        if let Source::Drive(_, Quantity::Command) = whole.plant().source(&output)? {
            return Err(AnalysisError::NotLinear { name: output.to_string() });
        }
        Ok((input, output))
    }
}

impl GainReport {
    /// Whether the file's own value lies beyond every stable interval of the loop as built.
    pub fn is_unstable_as_set(&self) -> bool {
        let holds = |band: &Band| {
            let from = band.lower.as_ref().map_or(f64::NEG_INFINITY, |edge| edge.gain);
            let to = band.upper.as_ref().map_or(f64::INFINITY, |edge| edge.gain);
            (from..=to).contains(&self.present)
        };
        !self.sampled.intervals.iter().any(holds)
    }
}

impl StableRange {
    fn about(present: f64, all: GainBands, below: BelowZero) -> Self {
        let intervals = all.joined(below);
        // Of a gain that is not below zero, those below are asked for by nobody.
        let asked = |band: &&Band| present < 0.0 || band.upper.as_ref().is_none_or(|edge| edge.gain > 0.0);
        let Some(band) = nearest(intervals.iter().filter(asked), present).cloned() else {
            return Self { intervals, all, ..Self::default() };
        };
        let [low, high] = [&band.lower, &band.upper].map(|edge| edge.as_ref().map(|e| e.gain));
        let edge = band.upper.as_ref().or(band.lower.as_ref());
        Self {
            stable: [if present < 0.0 { low } else { Some(low.unwrap_or(0.0).max(0.0)) }, high],
            edge_hz: edge.map(|e| e.frequency_hz),
            edge_mode: edge.and_then(|e| e.mode),
            edges: [band.lower, band.upper],
            intervals,
            all,
        }
    }
}
