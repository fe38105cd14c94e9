//! The first machine of one joint: by its model, or only by its motion.

use std::fmt::Write as _;
use std::path::Path;

use feeler_arm::JointBelief;
use feeler_files::{Document, machine_to_toml};
use feeler_plant::description::{
    Actuator, ActuatorKind, Axis, Body, GROUND, Machine, PositionServo, Quantity, Sensor, SignalName, Spring,
};
use feeler_plant::effects::{CoulombFriction, EffectUse};
use feeler_problem::short;

use super::axis::AxisBelief;
use super::role::ColumnRole;
use super::roles::Amount;
use super::seen::Seen;
use crate::error::DiagnosisError;

/// Names of the elements of a first machine.
const BODY: &str = "joint";
const BEARING: &str = "bearing";
const SERVO: &str = "servo";
const DRIVE: &str = "drive";
const LOAD: &str = "load";
const ENCODER: &str = "encoder";
const SPEED: &str = "speed";
const LEAD: &str = "lead";
/// Assumed meaning of a logged command of a force drive.
const FORCE: &str = "the command is the force of the drive";
const CURRENT: &str = "the command is a current, and forces are counted in amperes: state the force per \
                       ampere as `scale` of [columns.command]";
const VOLTAGE: &str = "the command is a voltage or a share of it, and forces are counted in its unit. State \
                       the force per unit at rest as `scale` of [columns.command]. The back-EMF counts as \
                       damping of the bearing";
/// Half of the lag of a well damped loop is the time constant of its corner: `lag = 2 / omega`.
const LAG_OMEGA: f64 = 2.0;
/// Lag that is assumed if none is visible, s.
const USUAL_LAG_S: f64 = 0.05;
/// A lag this many times that of the stated loop has another cause: targets also come late by a row or two.
const FAR_OFF_LAG: f64 = 5.0;
/// A gain this many times another is in another unit: believed masses are hardly twice the real ones.
const FAR_OFF_GAIN: f64 = 2.0;
/// Dry friction shifts where a joint holds its load by up to its level: a load this many times larger shows.
const LOAD_OVER_FRICTION: f64 = 3.0;
/// How far a gain may be off that follows from a load: as far as the masses of models, mostly.
const OFF_BY_LOAD: f64 = 0.5;
/// The same of a gain that follows from a lag, as a logarithm. A loop of damping ratio `z` lags by
/// `2 z / omega`, so that the gain goes with `z^2`, and servos have 0.6 to 1.6.
const OFF_BY_LAG: f64 = 1.0;
/// Armature that is assumed for a joint whose model moves no mass, kg m2.
const LEAST_INERTIA: f64 = 1e-6;

/// Gains of a servo.
struct Gains {
    kp: f64,
    kd: f64,
    /// Their source.
    why: String,
    /// How far `kp` may be off, if nobody has stated it.
    tolerance: Option<f64>,
}

/// The share of the stated gains that the machine takes, why, and how far it may be off. Used if a loop with
/// the stated gains could not move as the log does.
///
/// A load is held with an error of `load / kp`. Where no load shows over dry friction, a target that moves
/// steadily is followed `(kd + damping) / kp` later. With the damping beside it, a smaller gain lags more.
/// A target that comes with its speed meets no `kd`.
fn believed_share(kp: f64, joint: &JointBelief, seen: &Seen) -> (f64, String, Option<f64>) {
    let as_stated = (1.0, ", as the model states".into(), None);
    if let Some(held) = seen.held.gain(LOAD_OVER_FRICTION * joint.friction) {
        let share = held / kp;
        if (1.0 / FAR_OFF_GAIN..FAR_OFF_GAIN).contains(&share) {
            return as_stated;
        }
        let why = format!(
            ", {} times those of the model, by the errors with which the servo holds its load",
            short(share)
        );
        return (share, why, Some(OFF_BY_LOAD));
    }
    let kd = if seen.has_speed { 0.0 } else { joint.kd };
    let stated_s = (kd + joint.damping) / kp;
    let Some(lag_s) = seen.lag_s.filter(|lag_s| *lag_s > FAR_OFF_LAG * (stated_s + joint.delay_s)) else {
        return as_stated;
    };
    let share = joint.damping / (kp * (lag_s - joint.delay_s) - kd);
    if share <= 0.0 {
        return as_stated;
    }
    let why = format!(
        ", {} times those of the model: a loop with those lags by {} ms, but the position lags by {} ms",
        short(share),
        short(1e3 * stated_s),
        short(1e3 * lag_s)
    );
    (share, why, Some(OFF_BY_LAG))
}

fn written(kp: f64, kd: f64) -> String {
    let [kp_key, kd_key] = [Actuator::SERVO_KP, Actuator::SERVO_KD].map(|field| field.key.name);
    format!("{kp_key} {} and {kd_key} {}", short(kp), short(kd))
}

/// The gains of a servo that follows as the log shows.
fn gains(joint: &JointBelief, inertia: f64, seen: &Seen) -> Gains {
    if let Some(kp) = joint.kp {
        let (share, why, tolerance) = believed_share(kp, joint, seen);
        let (kp, kd) = (share * kp, share * joint.kd);
        return Gains { kp, kd, why: format!("{}{why}", written(kp, kd)), tolerance };
    }
    // The lag behind a target that comes with its speed is that of friction alone.
    let seen_s = seen.lag_s.filter(|lag| *lag > 0.0 && !seen.has_speed);
    let lag = seen_s.unwrap_or(USUAL_LAG_S);
    let omega = LAG_OMEGA / lag;
    let (kp, kd) = (inertia * omega.powi(2), (2.0 * inertia * omega - joint.damping).max(0.0));
    let why = format!(
        "{} are guesses: a critically damped loop that lags by {} ms{}",
        written(kp, kd),
        short(1e3 * lag),
        if seen_s.is_some() { ", as the position does" } else { "" }
    );
    Gains { kp, kd, why, tolerance: Some(OFF_BY_LAG) }
}

/// A machine file, the names of its signals, and the assumptions.
#[derive(Clone)]
pub(super) struct First {
    pub(super) text: String,
    /// Signal of the target or command.
    pub(super) input: String,
    /// Signal of the position.
    pub(super) position: String,
    pub(super) assumptions: Vec<String>,
    /// Signal of what gravity and other joints do, where the machine has a place for it.
    pub(super) load: Option<String>,
    /// Signal of the target's speed, where the servo takes it.
    speed: Option<String>,
    /// Signal of a force that the servo adds, where it takes one.
    lead: Option<String>,
    /// Whether it is a slide.
    pub(super) is_straight: bool,
}

impl First {
    /// The signal of a column; `None` if the machine has none.
    pub(super) fn signal(&self, role: ColumnRole) -> Option<&str> {
        match role {
            ColumnRole::Target | ColumnRole::Command => Some(&self.input),
            ColumnRole::Position => Some(&self.position),
            ColumnRole::TargetVelocity => self.speed.as_deref(),
            ColumnRole::FeedForward => self.lead.as_deref(),
            ColumnRole::Velocity | ColumnRole::Effort => None,
        }
    }

    /// A machine that the user gives.
    pub(super) fn given(path: &Path) -> Result<Self, DiagnosisError> {
        let document = Document::load(path)?;
        let machine = &document.scenario.machine;
        let file = || path.to_owned();
        let mut drives = machine.actuators.iter().filter(|(_, drive)| !drive.kind.feeds_servo());
        let Some((name, drive)) = drives.next() else {
            return Err(DiagnosisError::Unreadable {
                file: file(),
                reason: "the machine has no actuator, so nothing takes the target".into(),
                remedy: "add [actuators.NAME] with `on` and `kind`",
            });
        };
        let sensor = machine.sensors.iter().find(|(_, sensor)| {
            sensor.reads.element == drive.on && sensor.reads.quantity == Quantity::Position
        });
        let position =
            sensor.map_or_else(|| format!("{}.position", drive.on), |(name, _)| format!("{name}.reading"));
        let beside = |kind: &ActuatorKind| {
            let is_it = |other: &Actuator| {
                other.kind == *kind && other.on == drive.on && other.reacts_on == drive.reacts_on
            };
            let found = machine.actuators.iter().find(|(_, other)| is_it(other));
            found.map(|(name, _)| format!("{name}.command"))
        };
        Ok(Self {
            text: document.to_toml(),
            speed: beside(&ActuatorKind::TargetVelocity),
            lead: beside(&ActuatorKind::FeedForward),
            input: format!("{name}.command"),
            position,
            assumptions: vec![format!(
                "the target drives `{name}`, the first actuator of {}",
                path.display()
            )],
            load: None,
            is_straight: machine.axis == Axis::Translational,
        })
    }

    /// A first machine of one joint, with a position servo, or with a force drive if that command was logged.
    /// `middle` is the inertia of the links with each joint at the middle of the first run. It is given for
    /// an arm whose other joints and weight load this one.
    pub(super) fn of(
        input: ColumnRole,
        belief: Option<&AxisBelief>,
        middle: Option<f64>,
        seen: &Seen,
    ) -> Self {
        let is_force = input == ColumnRole::Command;
        let mut assumptions = Vec::new();
        let given = belief.cloned().unwrap_or_default();
        let joint = &given.joint;
        let inertia = inertia(belief, middle, is_force, &mut assumptions);
        let name = if is_force { DRIVE } else { SERVO };
        let mut tolerance = None;
        let kind = if is_force {
            let counted = match seen.command {
                Amount::Force => FORCE,
                Amount::Current => CURRENT,
                Amount::Voltage => VOLTAGE,
            };
            assumptions.push(counted.into());
            ActuatorKind::Force { bandwidth_hz: None }
        } else {
            let gains = gains(joint, inertia, seen);
            assumptions.push(gains.why);
            tolerance = gains.tolerance;
            let delay_s = joint.delay_s;
            let servo = PositionServo { kp: gains.kp, kd: gains.kd, delay_s, ..PositionServo::default() };
            ActuatorKind::PositionServo(servo)
        };
        let mut machine = Machine::new(if joint.name.is_empty() { BODY } else { &joint.name });
        let is_straight = belief.map_or(seen.is_straight, |belief| belief.is_straight);
        machine.axis = if is_straight { Axis::Translational } else { Axis::Rotational };
        let mut bearing = Spring::new(GROUND, BODY, 0.0, joint.damping);
        if joint.friction > 0.0 {
            bearing.effects.push(EffectUse::of(CoulombFriction { level: joint.friction }));
        }
        let drive = |kind| Actuator { kind, ..Actuator::ideal(BODY, GROUND) };
        let mut machine = machine
            .with_body(BODY, Body::new(inertia))
            .with_spring(BEARING, bearing)
            .with_actuator(name, Actuator { limit_n: joint.effort_limit, ..drive(kind) });
        let (has_speed, has_lead) = (seen.has_speed && !is_force, seen.has_lead && !is_force);
        for (name, kind) in [
            has_speed.then_some((SPEED, ActuatorKind::TargetVelocity)),
            has_lead.then_some((LEAD, ActuatorKind::FeedForward)),
        ]
        .into_iter()
        .flatten()
        {
            machine = machine.with_actuator(name, drive(kind));
            assumptions.push(format!(
                "the servo is assumed to use `{name}` with its targets; if it takes positions alone, \
                 remove [actuators.{name}] and its column"
            ));
        }
        if middle.is_some() {
            machine = machine.with_actuator(LOAD, drive(ActuatorKind::Force { bandwidth_hz: None }));
            assumptions.push(
                "the column `load` is the load of the weight and of the other joints' motion, from the \
                 masses of the model and the positions of the log"
                    .into(),
            );
        }
        let reads = SignalName::new(BODY, Quantity::Position);
        machine = machine.with_sensor(ENCODER, Sensor { resolution: seen.step, ..Sensor::ideal(reads) });
        if let Some(step) = seen.step {
            assumptions.push(format!("the encoder's step is {}, which its readings show", short(step)));
        }
        let mut text = machine_to_toml(&machine);
        if let Some(tolerance) = tolerance {
            let kp = Actuator::SERVO_KP.key.name;
            let _ = writeln!(text, "\n[tolerance]\n\"actuators.{name}.{kp}\" = {tolerance:?}");
        }
        Self {
            text,
            input: format!("{name}.{}", if is_force { "command" } else { "target" }),
            position: format!("{ENCODER}.reading"),
            assumptions,
            load: middle.map(|_| format!("{LOAD}.command")),
            speed: has_speed.then(|| format!("{SPEED}.command")),
            lead: has_lead.then(|| format!("{LEAD}.command")),
            is_straight,
        }
    }
}

/// Inertia of the joint with all that it moves.
fn inertia(
    belief: Option<&AxisBelief>,
    middle: Option<f64>,
    is_force: bool,
    assumptions: &mut Vec<String>,
) -> f64 {
    let Some(AxisBelief { joint, is_straight, inertia }) = belief else {
        let assumed = if is_force {
            "without a model the inertia is set to 1"
        } else {
            "without a model or a measured force the inertia is set to 1, and forces are relative to it"
        };
        assumptions.push(assumed.into());
        return 1.0;
    };
    let links = middle.unwrap_or(*inertia);
    let whole = links + joint.armature;
    let unit = if *is_straight { "kg" } else { "kg m2" };
    let pose = if middle.is_some() {
        "with each joint at the middle of the first run"
    } else {
        "where all joints are zero"
    };
    assumptions.push(format!(
        "inertia {} {unit}: links {} {pose}, armature {}",
        short(whole),
        short(links),
        short(joint.armature)
    ));
    if whole < LEAST_INERTIA {
        assumptions
            .push(format!("the model moves no mass here: the inertia is set to {LEAST_INERTIA} {unit}"));
    }
    whole.max(LEAST_INERTIA)
}
