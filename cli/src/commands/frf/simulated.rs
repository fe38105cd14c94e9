//! Experiments on the simulated machine.

use feeler_analysis::frf::{Excitation, Experiment, NoiseMethod};
use feeler_analysis::{LinearMachine, View};
use feeler_lti::spectral::LocalPolynomialSettings;
use feeler_plant::assembly::assemble;
use feeler_plant::description::{ActuatorKind, Engagement, Machine, Quantity, SignalName};
use feeler_scenarios::format::{Document, Draft};

use super::{Response, band, estimator, refused, require, require_segments};
use crate::arguments::{EstimatorKind, ExcitationKind, Frf};
use crate::failure::BadInput;
use crate::numbers::{plain, with_unit};

/// Hold of a machine without controllers, s.
const HOLD_S: f64 = 1e-3;
/// Root mean square of the excitation where nothing tells better, N (or N m), and m/s (rad/s) for a velocity source.
const RMS_FORCE: f64 = 1.0;
const RMS_VELOCITY: f64 = 0.01;
/// And as a multiple of dry friction, so that what slides keeps sliding.
const TIMES_FRICTION: f64 = 5.0;
/// And as a share of the drive's limit, which noise reaches at three to four times its root mean square.
const SHARE_OF_LIMIT: f64 = 0.1;
/// Time constants after which a transient is below 1e-6, and the bounds within which it is waited for, s.
const TIME_CONSTANTS: f64 = 14.0;
const WAIT_S: (f64, f64) = (0.5, 30.0);
/// Samples of an excitation at most; each takes some tens of bytes and half a microsecond or more.
const MOST_SAMPLES: f64 = 1e8;
/// Records without a stated length, s.
const DURATION_S: f64 = 60.0;

pub(super) fn respond(arguments: &Frf) -> anyhow::Result<Response> {
    require(
        arguments.experiments.is_empty(),
        || "--experiment names a record of a dataset, and this is a scenario".to_owned(),
        "name a dataset's folder, or leave --experiment out",
    )?;
    require_segments(arguments, arguments.estimator != EstimatorKind::LocalPolynomial)?;
    let document = Draft::load_with(&arguments.source, &arguments.settings)?.build()?;
    let mut notes = Vec::new();
    let experiment = experiment(arguments, &document, &mut notes)?;
    let (low, high) = band(arguments, experiment.hold_s, 1.0, None)?;
    let rms = arguments.rms.unwrap_or_else(|| usual_rms(&experiment.machine, &experiment.actuator));
    require(rms > 0.0 && rms.is_finite(), || format!("an excitation of {rms} excites nothing"), "give a size above zero with --rms")?;
    let wait_s = wait_s(&experiment).map_err(|error| refused(arguments, &error))?;
    let excitation = excitation(arguments, &experiment, wait_s, low)?;
    let measured = experiment.measure(&excitation, rms, (low, high)).map_err(|error| refused(arguments, &error))?;
    require(
        measured.estimate.response.iter().any(|value| value.norm() > 0.0),
        || format!("nothing moved under {} rms at `{}`: there is no response to estimate", plain(rms), experiment.actuator),
        "excite it more strongly with --rms, beyond dry friction and free play",
    )?;
    let realisations = arguments.realisations as f64;
    let told_apart = measured.noise_variance.zip(measured.distortion_variance);
    let hold = with_unit(experiment.hold_s, "s");
    Ok(Response {
        title: document.scenario.machine.name.clone(),
        about: document.scenario.machine.about.clone(),
        input: SignalName::new(&experiment.actuator, Quantity::Command).to_string(),
        output: experiment.output.to_string(),
        how: format!("simulated: {}, {} rms, held for {hold}, seed {}", words(&excitation, arguments), plain(rms), experiment.seed),
        notes,
        hold_s: experiment.hold_s,
        estimate: measured.estimate,
        linear: measured.linear,
        // The noise of the mean over realisations, as that of one of them.
        told_apart: told_apart.map(|(noise, distortion)| [noise.into_iter().map(|v| v * realisations).collect(), distortion]),
        confidence: arguments.confidence,
    })
}

fn experiment(arguments: &Frf, document: &Document, notes: &mut Vec<String>) -> anyhow::Result<Experiment> {
    let scenario = &document.scenario;
    let mut machine = scenario.machine.clone();
    let engage = |machine: &mut Machine, engagement| machine.contacts.values_mut().for_each(|contact| contact.engagement = engagement);
    if arguments.clamped {
        engage(&mut machine, Engagement::Clamped);
    } else if arguments.free {
        engage(&mut machine, Engagement::Free);
    } else if machine.contacts.values().any(|contact| contact.engagement == Engagement::Unilateral) {
        machine.contacts.values_mut().filter(|c| c.engagement == Engagement::Unilateral).for_each(|c| c.engagement = Engagement::Clamped);
        notes.push("contacts that can only push were taken as clamped; --free takes them away".to_owned());
    }
    let controller = scenario.controllers.values().find(|c| c.reads.is_some()).or_else(|| scenario.controllers.values().next());
    let signal = |text: &Option<String>| {
        let parse =
            |text: &String| text.parse::<SignalName>().map_err(|e| BadInput::error(e.to_string(), "signals are listed in docs/format.md"));
        text.as_ref().map(parse).transpose()
    };
    let actuator = match signal(&arguments.input)? {
        Some(input) => {
            let plant = LinearMachine::new(&machine, &View::default()).map_err(|error| refused(arguments, &error))?;
            plant.drive(&input).map_err(|error| refused(arguments, &error))?;
            input.element
        }
        None => match controller.map(|c| c.drives.clone()).or_else(|| machine.actuators.keys().next().cloned()) {
            Some(actuator) => actuator,
            None => {
                return Err(BadInput::error(
                    format!("{}: no actuator to excite", arguments.source.display()),
                    "give the machine an [actuators.NAME]",
                ));
            }
        },
    };
    let read = controller.and_then(|c| c.reads.as_ref()).and_then(|name| machine.sensors.get(name)).map(|sensor| sensor.reads.clone());
    let pressed = machine.contacts.keys().next().map(|name| SignalName::new(name, Quantity::SpringForce));
    let Some(output) = signal(&arguments.output)?.or(read).or(pressed) else {
        return Err(BadInput::error(
            "no sensor and no contact to look at",
            "name a signal with --output, as in --output motor.acceleration",
        ));
    };
    let hold_s =
        arguments.hold.or_else(|| scenario.controllers.values().find(|c| c.drives == actuator).map(|c| c.spec.period_s)).unwrap_or(HOLD_S);
    require(hold_s > 0.0 && hold_s.is_finite(), || format!("a hold of {hold_s} s is none"), "give a time above zero with --hold, in s")?;
    Ok(Experiment { machine, actuator, output, hold_s, offset: arguments.offset, seed: arguments.seed.unwrap_or(scenario.run.seed) })
}

fn usual_rms(machine: &Machine, actuator: &str) -> f64 {
    let Some(actuator) = machine.actuators.get(actuator) else { return RMS_FORCE };
    match actuator.kind {
        ActuatorKind::VelocitySource { .. } => RMS_VELOCITY,
        ActuatorKind::Force { .. } => {
            let links = assemble(machine).map(|assembly| assembly.links).unwrap_or_default();
            let friction: f64 = links.iter().map(|link| link.friction.forward.max(link.friction.backward)).sum();
            let usual = actuator.limit_n.map_or(RMS_FORCE, |limit| SHARE_OF_LIMIT * limit);
            usual.max(TIMES_FRICTION * friction)
        }
    }
}

/// Time in which transients die away.
fn wait_s(experiment: &Experiment) -> Result<f64, feeler_analysis::AnalysisError> {
    let plant = LinearMachine::new(&experiment.machine, &View::default())?;
    let channel = plant.channel(&SignalName::new(&experiment.actuator, Quantity::Command), &experiment.output)?;
    let slowest = channel.poles()?.iter().map(|p| -p.re).filter(|rate| *rate > 1e-6).fold(f64::INFINITY, f64::min);
    Ok((TIME_CONSTANTS / slowest).clamp(WAIT_S.0, WAIT_S.1))
}

fn excitation(arguments: &Frf, experiment: &Experiment, wait_s: f64, low_hz: f64) -> anyhow::Result<Excitation> {
    let duration_s = arguments.duration.unwrap_or(DURATION_S);
    let positive = |name: &str, value: f64| {
        require(value > 0.0 && value.is_finite(), || format!("--{name} {value} is no time"), "give seconds above zero")
    };
    positive("duration", duration_s)?;
    let samples = duration_s / experiment.hold_s;
    require(
        samples <= MOST_SAMPLES,
        || format!("{duration_s} s at a hold of {} s are {samples:.1e} samples, and {MOST_SAMPLES:.0e} are the most", experiment.hold_s),
        "choose a shorter --duration or a longer --hold",
    )?;
    Ok(match arguments.excitation {
        ExcitationKind::WhiteNoise => {
            let segment_s = arguments.segment.unwrap_or(duration_s / 15.0);
            positive("segment", segment_s)?;
            let local = NoiseMethod::LocalPolynomial(LocalPolynomialSettings::default());
            let method = estimator(arguments.estimator).map_or(local, |estimator| NoiseMethod::Welch { segment_s, estimator });
            Excitation::WhiteNoise { duration_s, method }
        }
        ExcitationKind::Multisine => {
            let period_s = arguments.period.unwrap_or(1.0);
            positive("period", period_s)?;
            let holds = period_s / experiment.hold_s;
            require(
                (holds - holds.round()).abs() < 1e-6 * holds && holds >= 4.0,
                || format!("a period of {period_s} s is no whole number of holds of {} s", experiment.hold_s),
                "choose --period as a multiple of the hold",
            )?;
            let transient_periods = (wait_s / period_s).ceil() as usize;
            Excitation::Multisine { period_s, periods: arguments.periods, transient_periods, realisations: arguments.realisations }
        }
        ExcitationKind::Chirp => Excitation::Chirp { sweep_s: duration_s, rest_s: wait_s, half_width: 1 },
        ExcitationKind::SteppedSine => {
            Excitation::SteppedSine { points: arguments.points, settle_s: wait_s, measure_s: (5.0 / low_hz).max(1.0) }
        }
    })
}

fn words(excitation: &Excitation, arguments: &Frf) -> String {
    match *excitation {
        Excitation::WhiteNoise { duration_s, method: NoiseMethod::Welch { segment_s, estimator } } => {
            format!("white noise for {}, {estimator:?} of segments of {}", with_unit(duration_s, "s"), with_unit(segment_s, "s"))
        }
        Excitation::WhiteNoise { duration_s, .. } => {
            format!("white noise for {}, local polynomials (leakage taken away)", with_unit(duration_s, "s"))
        }
        Excitation::Multisine { period_s, periods, realisations, .. } => {
            format!("random-phase multisine, period {}, {periods} periods, {realisations} realisations", with_unit(period_s, "s"))
        }
        Excitation::Chirp { sweep_s, .. } => format!("linear chirp over {}, H1", with_unit(sweep_s, "s")),
        _ => format!("stepped sine, {} frequencies", arguments.points),
    }
}
