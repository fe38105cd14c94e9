//! Actuators with their own loop or motion, as a program runs them.

use std::sync::Arc;

use feeler_catalogue::{LAW, Tabled};
use feeler_control::{AntiWindup, ControllerSpec, Law, PositionGains, Reference, SampleClock};
use feeler_plant::assembly::{Assembly, Drive, Source};
use feeler_plant::description::{ActuatorKind, Elements, Knot, Profile};
use feeler_plant::problem::Problem;

use super::scenario::{ControllerUse, Scenario};
use super::wanted::{Tapped, Wanted};
use crate::error::EngineError;

/// Largest number of knots of an imposed motion.
const MOST_KNOTS: f64 = 2e7;

/// A sampled servo with its loop as a controller.
#[derive(Clone, Debug)]
pub(crate) struct ServoWiring {
    pub(crate) name: String,
    pub(crate) drive: usize,
    pub(crate) spec: ControllerSpec,
    pub(crate) clock: SampleClock,
    pub(crate) encoder: Tapped,
    /// Its initial position, which is its target until the first command.
    pub(crate) start_m: f64,
}

/// The loop of a sampled servo as a controller that reads its encoder; `None` for other drives.
pub fn servo_spec(drive: &Drive) -> Option<ControllerSpec> {
    let (servo, sampling) = (drive.servo?, drive.sampling()?);
    let anti_windup = if servo.ki > 0.0 {
        AntiWindup::BackCalculation { tracking_time_s: servo.kp / servo.ki }
    } else {
        AntiWindup::Off
    };
    let (kp, ki, damping) = (servo.kp, servo.ki, servo.kd);
    let gains = PositionGains { kp, ki, damping, anti_windup, ..PositionGains::default() };
    Some(ControllerSpec {
        delay_s: sampling.delay,
        output_resolution: sampling.output_resolution,
        output_limit: Some(drive.limit).filter(|limit| limit.is_finite()),
        ..ControllerSpec::new(Law::Position(gains), sampling.period)
    })
}

/// The sampled servos of a machine.
pub(crate) fn servos(assembly: &Assembly, wanted: &mut Wanted) -> Result<Vec<ServoWiring>, EngineError> {
    let mut found = Vec::new();
    for (i, drive) in assembly.drives.iter().enumerate() {
        let (Some(spec), Some(sampling)) = (servo_spec(drive), drive.sampling()) else { continue };
        let name = drive.name.clone();
        let clock = SampleClock::new(&spec, 0, &name)
            .map_err(|source| EngineError::Control { name: name.clone(), source })?;
        let signal = wanted.index(Source::Sensor(sampling.encoder));
        let encoder = Tapped { sensor: sampling.encoder, signal };
        let start_m = assembly.nodes[drive.on].position_m - assembly.nodes[drive.reacts_on].position_m;
        found.push(ServoWiring { name, drive: i, spec, clock, encoder, start_m });
    }
    Ok(found)
}

/// Gives every imposed motion of an assembly the reference of the only controller that commands it.
pub(crate) fn impose(scenario: &Scenario, assembly: &mut Assembly, problems: &mut Vec<Problem>) {
    for (i, (name, actuator)) in scenario.machine.actuators.iter().enumerate() {
        if actuator.kind != ActuatorKind::Imposed {
            continue;
        }
        let drive = &mut assembly.drives[i];
        match motion(name, &scenario.controllers, scenario.run.duration_s, scenario.run.seed, drive) {
            Ok(profile) => drive.imposed = profile.or_else(|| drive.imposed.take()),
            Err(problem) => problems.push(problem),
        }
    }
}

/// The motion of an imposed drive; `None` if no controller commands it.
fn motion(
    name: &str,
    controllers: &Elements<ControllerUse>,
    duration_s: f64,
    seed: u64,
    drive: &Drive,
) -> Result<Option<Arc<Profile>>, Problem> {
    let mut commanding = controllers.iter().filter(|(_, used)| used.drives == name);
    let Some((controller, used)) = commanding.next() else { return Ok(None) };
    if let Some((other, _)) = commanding.next() {
        let message = format!("`{controller}` and `{other}` both prescribe the motion of `{name}`");
        return Err(Problem::new(ControllerUse::DRIVES.of(other), message, "keep one of them"));
    }
    let spec = &used.spec;
    if spec.law != Law::OpenLoop || spec.approach.is_some() {
        let message = format!("`{name}` is imposed: its motion is given in advance, so no feedback moves it");
        let remedy = format!(
            "give the controller `{LAW} = \"{}\"`, or the actuator another kind",
            Law::OpenLoop.name()
        );
        return Err(Problem::new(format!("{}.{LAW}", ControllerUse::place(controller)), message, remedy));
    }
    let count = ((duration_s - spec.offset_s) / spec.period_s).ceil().max(0.0) + 2.0;
    if count > MOST_KNOTS {
        let message = format!("{count} samples of an imposed motion; {MOST_KNOTS} is the most");
        return Err(Problem::new(ControllerSpec::PERIOD.of(controller), message, "sample it less often"));
    }
    // Mistakes of a reference are reported with the wiring of controllers.
    let Ok(reference) = Reference::new(&spec.reference, seed, &ControllerUse::place(controller)) else {
        return Ok(None);
    };
    let late_s = spec.delay_s + drive.delay;
    let points: Vec<(f64, f64)> = (0..count as u64)
        .map(|k| spec.offset_s + k as f64 * spec.period_s)
        .map(|t_s| (t_s + late_s, drive.held(reference.value(t_s))))
        .collect();
    Profile::new(&knots(&points)).map(|profile| Some(Arc::new(profile)))
}

/// Knots through points: the rate at each is that from the previous point to the next.
pub fn knots(points: &[(f64, f64)]) -> Vec<Knot> {
    let knot = |i: usize| {
        let (before, after) = (points[i.saturating_sub(1)], points[(i + 1).min(points.len() - 1)]);
        let span_s = after.0 - before.0;
        let rate_m_per_s = if span_s > 0.0 { (after.1 - before.1) / span_s } else { 0.0 };
        Knot { t_s: points[i].0, offset_m: points[i].1, rate_m_per_s }
    };
    (0..points.len()).map(knot).collect()
}
