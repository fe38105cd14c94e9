//! Experiments on the simulated machine.

use feeler_analysis::frf::{Excitation, FrfExperiment, NoiseMethod};
use feeler_analysis::{AnalysisError, LinearMachine};
use feeler_engine::{ControllerUse, Scenario};
use feeler_lti::eigenvalues;
use feeler_lti::spectral::LocalPolynomialSettings;
use feeler_plant::assembly::assemble;
use feeler_plant::description::{
    ActuatorKind, Engagement, Machine, MotorInput, PositionServo, Quantity, SignalName,
};

use super::between::{between, require_path, sensed};
use super::distortion::Separated;
use super::error::{FrfError, require};
use super::request::{ExcitationKind, FrfRequest, NoiseEstimator};
use super::response::FrequencyResponse;
use crate::numbers::{plain, with_unit};
use crate::refusal::Refusal;
use crate::signals;

/// Hold of a machine without controllers, s.
const HOLD_S: f64 = 1e-3;
/// Default root mean square of the excitation, N (or N m), and m/s (rad/s) for a velocity source.
const RMS_FORCE: f64 = 1.0;
const RMS_VELOCITY: f64 = 0.01;
/// Default root mean square of a position: 2 mm, or about a tenth of a degree; then of a voltage (V) and a
/// current (A).
const RMS_POSITION: f64 = 2e-3;
const RMS_VOLTAGE: f64 = 1.0;
const RMS_CURRENT: f64 = 0.1;
/// The excitation is at least this multiple of dry friction, so that sliding bodies keep sliding.
const TIMES_FRICTION: f64 = 5.0;
/// Share of the drive's limit. Noise has peaks of three to four times its root mean square.
const SHARE_OF_LIMIT: f64 = 0.1;
/// Time constants after which a transient is below rounding: exp(-36) = 2e-16. It then does not appear as
/// distortion far below a resonance. The second constant limits the waiting time, s.
const TIME_CONSTANTS: f64 = 36.0;
const WAIT_S: (f64, f64) = (0.5, 120.0);
/// Largest number of samples of an excitation; each takes some tens of bytes and at least half a microsecond.
const MOST_SAMPLES: f64 = 1e8;
/// Length of a record if none is requested, s.
const DURATION_S: f64 = 60.0;
/// Defaults of a multisine: period, s, evaluated periods, and phase realisations; then the number of
/// frequencies of a stepped sine.
const PERIOD_S: f64 = 1.0;
const PERIODS: usize = 4;
const REALISATIONS: usize = 4;
const POINTS: usize = 40;

/// The response of a simulated machine. The request's `experiments` are not used.
///
/// # Errors
/// A request that the machine cannot meet, or a simulation that ends early.
pub fn simulate(scenario: &Scenario, request: &FrfRequest) -> Result<FrequencyResponse, FrfError> {
    let kind = request.excitation.unwrap_or(ExcitationKind::WhiteNoise);
    let averages = matches!(request.estimator, Some(NoiseEstimator::Averaged(_)));
    request.require_segments(averages && kind == ExcitationKind::WhiteNoise)?;
    let mut notes = Vec::new();
    let experiment = experiment(request, scenario, &mut notes)?;
    let (low, high) = request.band(experiment.hold_s, 1.0, None)?;
    let rms = request.rms.unwrap_or_else(|| usual_rms(&experiment.machine, &experiment.actuator));
    require(
        rms > 0.0 && rms.is_finite(),
        || format!("--rms must be above zero (got {rms})"),
        "give the root mean square of the command, in SI",
    )?;
    let decay_time_s = decay_time_s(&experiment)?;
    let wait_s = decay_time_s.clamp(WAIT_S.0, WAIT_S.1);
    if decay_time_s > wait_s && kind != ExcitationKind::WhiteNoise {
        let (left, waited) = (with_unit(decay_time_s, "s"), with_unit(wait_s, "s"));
        notes.push(format!(
            "transients take {left} to decay, but the experiment waits for {waited} only: the rest appears \
             as distortion, and the confidence bands do not include it"
        ));
    }
    let excitation = excitation(request, kind, &experiment, wait_s, low)?;
    let input = SignalName::new(&experiment.actuator, Quantity::Command).to_string();
    require_path(&experiment, (low, high), &input)?;
    let measured = experiment.measure(&excitation, rms, (low, high))?;
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
    let realisations = request.realisations.unwrap_or(REALISATIONS) as f64;
    let isolated = kind == ExcitationKind::SteppedSine;
    let between_hz = between(&measured.estimate.frequencies_hz, isolated);
    let between = experiment.linear_response(&between_hz)?;
    let variances = measured.noise_variance.zip(measured.distortion_variance).zip(measured.evidence);
    let separated = variances.map(|((noise, distortion), evidence)| Separated {
        // The noise of one realisation, from that of the mean over all.
        noise: noise.into_iter().map(|v| v * realisations).collect(),
        distortion,
        evidence,
    });
    let hold = with_unit(experiment.hold_s, "s");
    Ok(FrequencyResponse {
        title: scenario.machine.name.clone(),
        about: scenario.machine.about.clone(),
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
        separated,
        confidence: request.confidence,
    })
}

fn experiment(
    request: &FrfRequest,
    scenario: &Scenario,
    notes: &mut Vec<String>,
) -> Result<FrfExperiment, FrfError> {
    let mut machine = scenario.machine.clone();
    let engage = |machine: &mut Machine, engagement| {
        machine.contacts.values_mut().for_each(|contact| contact.engagement = engagement);
    };
    if let Some(engagement) = request.engagement {
        engage(&mut machine, engagement);
    } else if machine.contacts.values().any(|contact| contact.engagement == Engagement::Unilateral) {
        machine
            .contacts
            .values_mut()
            .filter(|c| c.engagement == Engagement::Unilateral)
            .for_each(|c| c.engagement = Engagement::Clamped);
        notes.push("unilateral contacts were taken as clamped; --free removes them".to_owned());
    }
    let controller = scenario
        .controllers
        .values()
        .find(|c| c.reads.is_some())
        .or_else(|| scenario.controllers.values().next());
    let actuator = match &request.input {
        Some(input) => signals::command(&machine, input)?.element,
        None => {
            match controller.map(|c| c.drives.clone()).or_else(|| machine.actuators.keys().next().cloned()) {
                Some(actuator) => actuator,
                None => {
                    return Err(FrfError::Source(Refusal::new(
                        "no actuator to excite",
                        "give the machine an [actuators.NAME]",
                    )));
                }
            }
        }
    };
    let output = output(request, controller, &machine)?;
    let hold_s = request
        .hold_s
        .or_else(|| scenario.controllers.values().find(|c| c.drives == actuator).map(|c| c.spec.period_s))
        .unwrap_or(HOLD_S);
    let hold_s = whole_samples(&machine, &actuator, hold_s, request.hold_s.is_some())?;
    require(
        hold_s > 0.0 && hold_s.is_finite(),
        || format!("--hold must be above zero (got {hold_s} s)"),
        "give the time for which each command is held, in s",
    )?;
    let offset = request.offset.unwrap_or(0.0);
    if touches_nonlinearly(&machine) {
        let rest = if offset == 0.0 {
            "without a mean force (--offset sets one)".to_owned()
        } else {
            format!("under the mean command of {}", plain(offset))
        };
        notes.push(format!(
            "the contact's stiffness or damping depends on its force; the linear response is that at rest \
             {rest}"
        ));
    }
    Ok(FrfExperiment {
        machine,
        actuator,
        output,
        hold_s,
        offset,
        seed: request.seed.unwrap_or(scenario.run.seed),
    })
}

/// The hold of a target of a sampled servo: a whole number of its samples. Otherwise the response of the
/// servo differs from one target to the next.
fn whole_samples(machine: &Machine, actuator: &str, hold_s: f64, is_stated: bool) -> Result<f64, FrfError> {
    let kind = machine.actuators.get(actuator).map(|actuator| &actuator.kind);
    let Some(ActuatorKind::PositionServo(PositionServo { period_s: Some(period_s), .. })) = kind else {
        return Ok(hold_s);
    };
    let samples = hold_s / period_s;
    let is_whole = samples.round() >= 1.0 && (samples - samples.round()).abs() < 1e-6 * samples;
    require(
        is_whole || !is_stated,
        || {
            let (hold, period) = (with_unit(hold_s, "s"), with_unit(*period_s, "s"));
            format!(
                "a target held for {hold} is not a whole number of samples of `{actuator}`, every {period}"
            )
        },
        "choose --hold as a multiple of the servo's period",
    )?;
    Ok(if is_whole { hold_s } else { (samples * (1.0 - 1e-6)).ceil() * period_s })
}

/// The requested output. The default is the reading of the controller, else the contact force, else any
/// reading.
fn output(
    request: &FrfRequest,
    controller: Option<&ControllerUse>,
    machine: &Machine,
) -> Result<SignalName, FrfError> {
    // The controller's input: the sensor's reading with its filter, delay, resolution and noise.
    let read = controller.and_then(|c| c.reads.as_ref()).and_then(|name| machine.sensors.get_key_value(name));
    // A removed contact has no force. The output is then the motion of the body that would touch.
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
    let wanted = request.output.as_deref().map(|name| signals::named(machine, name)).transpose()?;
    wanted.or(read).or(pressed).or_else(any_sensor).ok_or_else(|| {
        Refusal::new(
            "the machine has no sensor and no contact",
            "name a signal with --output, as in --output motor.acceleration",
        )
        .into()
    })
}

/// Whether an acting contact has a nonlinear law, including effects.
fn touches_nonlinearly(machine: &Machine) -> bool {
    let contacts = assemble(machine).map(|assembly| assembly.contacts).unwrap_or_default();
    contacts.iter().any(|contact| contact.engagement != Engagement::Free && !contact.law.is_linear())
}

fn usual_rms(machine: &Machine, actuator: &str) -> f64 {
    let Some(actuator) = machine.actuators.get(actuator) else { return RMS_FORCE };
    match actuator.kind {
        ActuatorKind::VelocitySource { .. } | ActuatorKind::TargetVelocity => RMS_VELOCITY,
        ActuatorKind::PositionServo(_) | ActuatorKind::Imposed => RMS_POSITION,
        ActuatorKind::DcMotor(motor) => match motor.input {
            MotorInput::Voltage => motor.supply_voltage_v.map_or(RMS_VOLTAGE, |most| SHARE_OF_LIMIT * most),
            MotorInput::Duty => SHARE_OF_LIMIT,
            MotorInput::Current => motor.current_limit_a.map_or(RMS_CURRENT, |most| SHARE_OF_LIMIT * most),
        },
        ActuatorKind::Force { .. } | ActuatorKind::FeedForward => {
            let links = assemble(machine).map(|assembly| assembly.links).unwrap_or_default();
            let friction: f64 =
                links.iter().map(|link| link.friction.forward.max(link.friction.backward)).sum();
            let usual = actuator.limit_n.map_or(RMS_FORCE, |limit| SHARE_OF_LIMIT * limit);
            usual.max(TIMES_FRICTION * friction)
        }
    }
}

/// Time in which transients decay, s; zero if no motion decays.
fn decay_time_s(experiment: &FrfExperiment) -> Result<f64, AnalysisError> {
    let plant = LinearMachine::new(&experiment.machine, &experiment.view())?;
    let input = SignalName::new(&experiment.actuator, Quantity::Command);
    let poles = match plant.channel(&input, &experiment.output) {
        // An output that differentiates an imposed motion has the poles of the machine.
        Err(AnalysisError::ImposedOutput { .. }) => eigenvalues(plant.a()).map_err(AnalysisError::from)?,
        channel => channel?.poles().map_err(AnalysisError::from)?,
    };
    let slowest = poles.iter().map(|p| -p.re).filter(|rate| *rate > 1e-6).fold(f64::INFINITY, f64::min);
    Ok(TIME_CONSTANTS / slowest)
}

fn excitation(
    request: &FrfRequest,
    kind: ExcitationKind,
    experiment: &FrfExperiment,
    wait_s: f64,
    low_hz: f64,
) -> Result<Excitation, FrfError> {
    let duration_s = request.duration_s.unwrap_or(DURATION_S);
    let positive = |name: &str, value: f64| {
        require(
            value > 0.0 && value.is_finite(),
            || format!("--{name} must be above zero (got {value} s)"),
            "give a time in s",
        )
    };
    positive("duration", duration_s)?;
    let chosen = match kind {
        ExcitationKind::WhiteNoise => {
            let segment_s = request.segment_s.unwrap_or(duration_s / 15.0);
            positive("segment", segment_s)?;
            let local = NoiseMethod::LocalPolynomial(LocalPolynomialSettings::default());
            let method = request
                .estimator
                .and_then(NoiseEstimator::averaged)
                .map_or(local, |estimator| NoiseMethod::Welch { segment_s, estimator });
            Excitation::WhiteNoise { duration_s, method }
        }
        ExcitationKind::Multisine => {
            let period_s = request.period_s.unwrap_or(PERIOD_S);
            positive("period", period_s)?;
            let holds = period_s / experiment.hold_s;
            require(
                (holds - holds.round()).abs() < 1e-6 * holds && holds >= 4.0,
                || {
                    format!(
                        "a period of {period_s} s is not a whole number of holds of {} s",
                        experiment.hold_s
                    )
                },
                "choose --period as a multiple of the hold",
            )?;
            let transient_periods = (wait_s / period_s).ceil() as usize;
            let (periods, realisations) =
                (request.periods.unwrap_or(PERIODS), request.realisations.unwrap_or(REALISATIONS));
            Excitation::Multisine { period_s, periods, transient_periods, realisations }
        }
        ExcitationKind::Chirp => Excitation::Chirp { sweep_s: duration_s, rest_s: wait_s, half_width: 1 },
        ExcitationKind::SteppedSine => {
            let points = request.points.unwrap_or(POINTS);
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
                "{} of simulation at a hold of {held} are {samples:.1e} samples; at most {MOST_SAMPLES:.0e} \
                 are possible",
                with_unit(whole_s, "s")
            )
        },
        "choose a shorter --duration or --period, fewer --points or --realisations, a higher --from, or a \
         longer --hold",
    )?;
    Ok(chosen)
}

/// Total simulated time, s.
fn length_s(excitation: &Excitation) -> f64 {
    match *excitation {
        Excitation::Multisine { period_s, periods, transient_periods, realisations } => {
            period_s * (periods + transient_periods) as f64 * realisations as f64
        }
        Excitation::Chirp { sweep_s, rest_s, .. } => sweep_s + rest_s,
        Excitation::SteppedSine { points, settle_s, measure_s } => points as f64 * (settle_s + measure_s),
        Excitation::WhiteNoise { duration_s, .. } => duration_s,
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
            format!("white noise for {}, local polynomials (leakage removed)", with_unit(duration_s, "s"))
        }
        Excitation::Multisine { period_s, periods, realisations, .. } => {
            format!(
                "random-phase multisine, period {}, {periods} periods, {realisations} realisations",
                with_unit(period_s, "s")
            )
        }
        Excitation::Chirp { sweep_s, .. } => format!("linear chirp over {}, H1", with_unit(sweep_s, "s")),
        Excitation::SteppedSine { points, .. } => format!("stepped sine, {points} frequencies"),
    }
}
