//! Experiments on the simulated machine.

use clap::ValueEnum;
use feeler_analysis::LinearMachine;
use feeler_analysis::frf::{Excitation, Experiment, NoiseMethod};
use feeler_files::{Document, Draft};
use feeler_lti::spectral::LocalPolynomialSettings;
use feeler_plant::assembly::assemble;
use feeler_plant::description::{ActuatorKind, Engagement, Machine, Quantity, SignalName};

use super::{
    Response, ToldApart, band, between, estimator, refused, require, require_path, require_segments, sensed,
};
use crate::arguments::{EstimatorKind, ExcitationKind, Frf};
use crate::numbers::{plain, with_unit};
use crate::signals;
use crate::terminal::failure::BadInput;

/// Hold of a machine without controllers, s.
const HOLD_S: f64 = 1e-3;
/// Root mean square of the excitation where nothing tells better, N (or N m), and m/s (rad/s) for a velocity
/// source.
const RMS_FORCE: f64 = 1.0;
const RMS_VELOCITY: f64 = 0.01;
/// And as a multiple of dry friction, so that what slides keeps sliding.
const TIMES_FRICTION: f64 = 5.0;
/// And as a share of the drive's limit, which noise reaches at three to four times its root mean square.
const SHARE_OF_LIMIT: f64 = 0.1;
/// Time constants after which a transient is below rounding, exp(-36) = 2e-16, so that none is taken for
/// distortion far below a resonance; and the bounds within which it is waited for, s.
const TIME_CONSTANTS: f64 = 36.0;
const WAIT_S: (f64, f64) = (0.5, 120.0);
/// Samples of an excitation at most; each takes some tens of bytes and half a microsecond or more.
const MOST_SAMPLES: f64 = 1e8;
/// Records without a stated length, s.
const DURATION_S: f64 = 60.0;
/// Of a multisine: period, s, periods that are evaluated, and draws of the phases; and frequencies of a
/// stepped sine.
const PERIOD_S: f64 = 1.0;
const PERIODS: usize = 4;
const REALISATIONS: usize = 4;
const POINTS: usize = 40;

pub(super) fn respond(arguments: &Frf) -> anyhow::Result<Response> {
    require(
        arguments.experiments.is_empty(),
        || "--experiment names a record of a dataset, and this is a scenario".to_owned(),
        "name a dataset's folder, or leave --experiment out",
    )?;
    let kind = arguments.excitation.unwrap_or(ExcitationKind::WhiteNoise);
    refuse_others(arguments, kind)?;
    let averages = arguments.estimator.is_some_and(|estimator| estimator != EstimatorKind::LocalPolynomial);
    require_segments(arguments, averages && kind == ExcitationKind::WhiteNoise)?;
    let document = Draft::load_with(&arguments.source, &arguments.settings)?.build()?;
    let mut notes = Vec::new();
    let experiment = experiment(arguments, &document, &mut notes)?;
    let (low, high) = band(arguments, experiment.hold_s, 1.0, None)?;
    let rms = arguments.rms.unwrap_or_else(|| usual_rms(&experiment.machine, &experiment.actuator));
    require(
        rms > 0.0 && rms.is_finite(),
        || format!("an excitation of {rms} excites nothing"),
        "give a size above zero with --rms",
    )?;
    let dies_in_s = dies_in_s(&experiment).map_err(|error| refused(arguments, &error))?;
    let wait_s = dies_in_s.clamp(WAIT_S.0, WAIT_S.1);
    if dies_in_s > wait_s && kind != ExcitationKind::WhiteNoise {
        let (left, waited) = (with_unit(dies_in_s, "s"), with_unit(wait_s, "s"));
        notes.push(format!(
            "transients take {left} to die away and {waited} are waited for: what is left of them reads as distortion, and no band knows of it"
        ));
    }
    let excitation = excitation(arguments, kind, &experiment, wait_s, low)?;
    let input = SignalName::new(&experiment.actuator, Quantity::Command).to_string();
    require_path(arguments, &experiment, (low, high), &input)?;
    let measured =
        experiment.measure(&excitation, rms, (low, high)).map_err(|error| refused(arguments, &error))?;
    require(
        measured.estimate.response.iter().any(|value| value.norm() > 0.0),
        || {
            format!(
                "nothing moved under {} rms at `{}`: there is no response to estimate",
                plain(rms),
                experiment.actuator
            )
        },
        "excite it more strongly with --rms, beyond dry friction, free play and the sensor's resolution",
    )?;
    let realisations = arguments.realisations.unwrap_or(REALISATIONS) as f64;
    let isolated = kind == ExcitationKind::SteppedSine;
    let between_hz = between(&measured.estimate.frequencies_hz, isolated);
    let between = experiment.linear_response(&between_hz).map_err(|error| refused(arguments, &error))?;
    let variances = measured.noise_variance.zip(measured.distortion_variance).zip(measured.evidence);
    let told_apart = variances.map(|((noise, distortion), evidence)| ToldApart {
        // The noise of the mean over realisations, as that of one of them.
        noise: noise.into_iter().map(|v| v * realisations).collect(),
        distortion,
        evidence,
    });
    let hold = with_unit(experiment.hold_s, "s");
    Ok(Response {
        title: document.scenario.machine.name.clone(),
        about: document.scenario.machine.about.clone(),
        input,
        output: experiment.output.to_string(),
        reads: sensed(&experiment.machine, &experiment.output),
        how: format!(
            "simulated: {}, {} rms, held for {hold}, seed {}",
            words(&excitation),
            plain(rms),
            experiment.seed
        ),
        notes,
        hold_s: experiment.hold_s,
        estimate: measured.estimate,
        linear: measured.linear,
        isolated,
        between: between_hz.into_iter().zip(between).collect(),
        told_apart,
        confidence: arguments.confidence,
    })
}

/// What belongs to another excitation has no say in this one.
fn refuse_others(arguments: &Frf, kind: ExcitationKind) -> anyhow::Result<()> {
    use ExcitationKind::{Chirp, Multisine, SteppedSine, WhiteNoise};
    let given: [(&str, bool, &[ExcitationKind]); 6] = [
        ("--estimator", arguments.estimator.is_some(), &[WhiteNoise]),
        ("--duration", arguments.duration.is_some(), &[WhiteNoise, Chirp]),
        ("--period", arguments.period.is_some(), &[Multisine]),
        ("--periods", arguments.periods.is_some(), &[Multisine]),
        ("--realisations", arguments.realisations.is_some(), &[Multisine]),
        ("--points", arguments.points.is_some(), &[SteppedSine]),
    ];
    let name = |kind: &ExcitationKind| {
        kind.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    };
    for (option, given, kinds) in given {
        require(
            !given || kinds.contains(&kind),
            || format!("{option} has no meaning for --excitation {}", name(&kind)),
            &format!(
                "leave it out, or add --excitation {}",
                kinds.iter().map(name).collect::<Vec<_>>().join(" or ")
            ),
        )?;
    }
    Ok(())
}

fn experiment(arguments: &Frf, document: &Document, notes: &mut Vec<String>) -> anyhow::Result<Experiment> {
    let scenario = &document.scenario;
    let mut machine = scenario.machine.clone();
    let engage = |machine: &mut Machine, engagement| {
        machine.contacts.values_mut().for_each(|contact| contact.engagement = engagement)
    };
    if arguments.clamped {
        engage(&mut machine, Engagement::Clamped);
    } else if arguments.free {
        engage(&mut machine, Engagement::Free);
    } else if machine.contacts.values().any(|contact| contact.engagement == Engagement::Unilateral) {
        machine
            .contacts
            .values_mut()
            .filter(|c| c.engagement == Engagement::Unilateral)
            .for_each(|c| c.engagement = Engagement::Clamped);
        notes.push("contacts that can only push were taken as clamped; --free takes them away".to_owned());
    }
    let controller = scenario
        .controllers
        .values()
        .find(|c| c.reads.is_some())
        .or_else(|| scenario.controllers.values().next());
    let actuator = match &arguments.input {
        Some(input) => signals::command(&machine, input)?.element,
        None => {
            match controller.map(|c| c.drives.clone()).or_else(|| machine.actuators.keys().next().cloned()) {
                Some(actuator) => actuator,
                None => {
                    return Err(BadInput::error(
                        format!("{}: no actuator to excite", arguments.source.display()),
                        "give the machine an [actuators.NAME]",
                    ));
                }
            }
        }
    };
    // What the controller gets: the sensor's reading, with its filter, delay, resolution and noise.
    let read = controller.and_then(|c| c.reads.as_ref()).and_then(|name| machine.sensors.get_key_value(name));
    // What is absent feels nothing: then the body that would touch is looked at.
    let pressed = machine.contacts.iter().next().map(|(name, contact)| match contact.engagement {
        Engagement::Free => SignalName::new(&contact.between[0], Quantity::Acceleration),
        _ => SignalName::new(name, Quantity::SpringForce),
    });
    let feels = |signal: &SignalName| {
        machine.contacts.get(&signal.element).is_none_or(|contact| contact.engagement != Engagement::Free)
    };
    let read = read
        .filter(|(_, sensor)| feels(&sensor.reads))
        .map(|(name, _)| SignalName::new(name, Quantity::Reading));
    let any_sensor = || machine.sensors.keys().next().map(|name| SignalName::new(name, Quantity::Reading));
    let wanted = arguments.output.as_deref().map(|name| signals::named(&machine, name)).transpose()?;
    let Some(output) = wanted.or(read).or(pressed).or_else(any_sensor) else {
        return Err(BadInput::error(
            "no sensor and no contact to look at",
            "name a signal with --output, as in --output motor.acceleration",
        ));
    };
    let hold_s = arguments
        .hold
        .or_else(|| scenario.controllers.values().find(|c| c.drives == actuator).map(|c| c.spec.period_s))
        .unwrap_or(HOLD_S);
    require(
        hold_s > 0.0 && hold_s.is_finite(),
        || format!("a hold of {hold_s} s is none"),
        "give a time above zero with --hold, in s",
    )?;
    let offset = arguments.offset.unwrap_or(0.0);
    if touches_nonlinearly(&machine) {
        let rest = if offset == 0.0 {
            "without a mean force (--offset gives one)".to_owned()
        } else {
            format!("under the mean command of {}", plain(offset))
        };
        notes.push(format!("the contact's stiffness or damping depends on its force; the linear response is that at rest {rest}"));
    }
    Ok(Experiment {
        machine,
        actuator,
        output,
        hold_s,
        offset,
        seed: arguments.seed.unwrap_or(scenario.run.seed),
    })
}

/// Whether a contact that acts has a law that is not linear, effects included.
fn touches_nonlinearly(machine: &Machine) -> bool {
    let contacts = assemble(machine).map(|assembly| assembly.contacts).unwrap_or_default();
    contacts.iter().any(|contact| contact.engagement != Engagement::Free && !contact.law.is_linear())
}

fn usual_rms(machine: &Machine, actuator: &str) -> f64 {
    let Some(actuator) = machine.actuators.get(actuator) else { return RMS_FORCE };
    match actuator.kind {
        ActuatorKind::VelocitySource { .. } => RMS_VELOCITY,
        ActuatorKind::Force { .. } => {
            let links = assemble(machine).map(|assembly| assembly.links).unwrap_or_default();
            let friction: f64 =
                links.iter().map(|link| link.friction.forward.max(link.friction.backward)).sum();
            let usual = actuator.limit_n.map_or(RMS_FORCE, |limit| SHARE_OF_LIMIT * limit);
            usual.max(TIMES_FRICTION * friction)
        }
    }
}

/// Time in which transients die away; none where no motion decays.
fn dies_in_s(experiment: &Experiment) -> Result<f64, feeler_analysis::AnalysisError> {
    let plant = LinearMachine::new(&experiment.machine, &experiment.view())?;
    let channel =
        plant.channel(&SignalName::new(&experiment.actuator, Quantity::Command), &experiment.output)?;
    let slowest =
        channel.poles()?.iter().map(|p| -p.re).filter(|rate| *rate > 1e-6).fold(f64::INFINITY, f64::min);
    Ok(TIME_CONSTANTS / slowest)
}

fn excitation(
    arguments: &Frf,
    kind: ExcitationKind,
    experiment: &Experiment,
    wait_s: f64,
    low_hz: f64,
) -> anyhow::Result<Excitation> {
    let duration_s = arguments.duration.unwrap_or(DURATION_S);
    let positive = |name: &str, value: f64| {
        require(
            value > 0.0 && value.is_finite(),
            || format!("--{name} {value} is no time"),
            "give seconds above zero",
        )
    };
    positive("duration", duration_s)?;
    let chosen = match kind {
        ExcitationKind::WhiteNoise => {
            let segment_s = arguments.segment.unwrap_or(duration_s / 15.0);
            positive("segment", segment_s)?;
            let local = NoiseMethod::LocalPolynomial(LocalPolynomialSettings::default());
            let method = arguments
                .estimator
                .and_then(estimator)
                .map_or(local, |estimator| NoiseMethod::Welch { segment_s, estimator });
            Excitation::WhiteNoise { duration_s, method }
        }
        ExcitationKind::Multisine => {
            let period_s = arguments.period.unwrap_or(PERIOD_S);
            positive("period", period_s)?;
            let holds = period_s / experiment.hold_s;
            require(
                (holds - holds.round()).abs() < 1e-6 * holds && holds >= 4.0,
                || format!("a period of {period_s} s is no whole number of holds of {} s", experiment.hold_s),
                "choose --period as a multiple of the hold",
            )?;
            let transient_periods = (wait_s / period_s).ceil() as usize;
            let (periods, realisations) =
                (arguments.periods.unwrap_or(PERIODS), arguments.realisations.unwrap_or(REALISATIONS));
            Excitation::Multisine { period_s, periods, transient_periods, realisations }
        }
        ExcitationKind::Chirp => Excitation::Chirp { sweep_s: duration_s, rest_s: wait_s, half_width: 1 },
        ExcitationKind::SteppedSine => {
            let points = arguments.points.unwrap_or(POINTS);
            Excitation::SteppedSine { points, settle_s: wait_s, measure_s: (5.0 / low_hz).max(1.0) }
        }
    };
    let whole_s = length_s(&chosen);
    let samples = whole_s / experiment.hold_s;
    require(
        samples <= MOST_SAMPLES,
        || {
            let held = with_unit(experiment.hold_s, "s");
            format!(
                "{} of simulation at a hold of {held} are {samples:.1e} samples, and {MOST_SAMPLES:.0e} are the most",
                with_unit(whole_s, "s")
            )
        },
        "choose a shorter --duration or --period, fewer --points or --realisations, a higher --from, or a longer --hold",
    )?;
    Ok(chosen)
}

/// What is simulated in all, s.
fn length_s(excitation: &Excitation) -> f64 {
    match *excitation {
        Excitation::Multisine { period_s, periods, transient_periods, realisations } => {
            period_s * (periods + transient_periods) as f64 * realisations as f64
        }
        Excitation::Chirp { sweep_s, rest_s, .. } => sweep_s + rest_s,
        Excitation::SteppedSine { points, settle_s, measure_s } => points as f64 * (settle_s + measure_s),
        Excitation::WhiteNoise { duration_s, .. } => duration_s,
        _ => 0.0,
    }
}

fn words(excitation: &Excitation) -> String {
    match *excitation {
        Excitation::WhiteNoise { duration_s, method: NoiseMethod::Welch { segment_s, estimator } } => {
            format!(
                "white noise for {}, {estimator:?} of segments of {}",
                with_unit(duration_s, "s"),
                with_unit(segment_s, "s")
            )
        }
        Excitation::WhiteNoise { duration_s, .. } => {
            format!("white noise for {}, local polynomials (leakage taken away)", with_unit(duration_s, "s"))
        }
        Excitation::Multisine { period_s, periods, realisations, .. } => {
            format!(
                "random-phase multisine, period {}, {periods} periods, {realisations} realisations",
                with_unit(period_s, "s")
            )
        }
        Excitation::Chirp { sweep_s, .. } => format!("linear chirp over {}, H1", with_unit(sweep_s, "s")),
        Excitation::SteppedSine { points, .. } => format!("stepped sine, {points} frequencies"),
        _ => String::new(),
    }
}
