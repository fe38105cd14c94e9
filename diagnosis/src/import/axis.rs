//! The believed machine of one joint: from a URDF or MJCF, or only from its motion.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use feeler_arm::{JointBelief, JointKind, Mjcf, Urdf};
use feeler_files::{Document, machine_to_toml};
use feeler_plant::description::{Axis, Body, GROUND, Machine, Quantity, Spring};
use feeler_plant::effects::{CoulombFriction, EffectUse};
use feeler_problem::short;

use crate::error::DiagnosisError;

/// Where beliefs come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Model {
    /// A machine file, used unchanged.
    Machine(PathBuf),
    /// A URDF.
    Urdf(PathBuf),
    /// An MJCF.
    Mjcf(PathBuf),
}

/// Names of the elements of a first machine.
const BODY: &str = "joint";
const BEARING: &str = "bearing";
const SERVO: &str = "servo";
const ENCODER: &str = "encoder";
/// Half of the lag of a well damped loop is the time constant of its corner: `lag = 2 / omega`.
const LAG_OMEGA: f64 = 2.0;
/// Lag that is assumed if none is visible, s.
const USUAL_LAG_S: f64 = 0.05;
/// Armature that is assumed for a joint whose model moves no mass, kg m2.
const LEAST_INERTIA: f64 = 1e-6;

/// Every joint of a model.
pub(super) struct Beliefs {
    joints: Vec<AxisBelief>,
}

/// The believed parameters of one joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AxisBelief {
    /// The joint and its loop.
    pub joint: JointBelief,
    /// Whether it slides.
    pub is_straight: bool,
    /// Inertia (or mass) of the bodies that it moves, at the pose with all joints at zero.
    pub inertia: f64,
}

impl Beliefs {
    /// Reads a model.
    pub(super) fn load(model: &Model) -> Result<Self, DiagnosisError> {
        let (path, mjcf) = match model {
            Model::Urdf(path) => {
                let tree = parsed(path, Urdf::parse)?;
                let of = |joint: &feeler_arm::Joint| JointBelief {
                    name: joint.name.clone(),
                    link: joint.link.clone(),
                    damping: joint.viscous_friction,
                    friction: joint.dry_friction,
                    effort_limit: joint.effort_limit,
                    ..JointBelief::default()
                };
                let joints = tree.moving_joints().map(of).collect();
                (path, Mjcf { tree, joints })
            }
            Model::Mjcf(path) => (path, parsed(path, Mjcf::parse)?),
            Model::Machine(_) => return Ok(Self { joints: Vec::new() }),
        };
        let mut joints = Vec::new();
        for joint in mjcf.joints {
            let chain = mjcf.tree.chain(&joint.link).map_err(|error| wrong(path, &error))?;
            let at = chain.joints.iter().position(|other| other.name == joint.name);
            let pose = vec![0.0; chain.joints()];
            let inertia = at.map_or(0.0, |i| chain.mass_matrix(&pose)[(i, i)]);
            let is_straight = at.is_some_and(|i| chain.joints[i].kind == JointKind::Prismatic);
            joints.push(AxisBelief { joint, is_straight, inertia });
        }
        Ok(Self { joints })
    }

    /// The joint with this name in the log: by its name, else by its index if both have the same number.
    pub(super) fn find(&self, name: &str, among: &[String]) -> Option<(&AxisBelief, String)> {
        let plain = |text: &str| text.to_lowercase().replace(['_', '-', ' '], "");
        let named = self.joints.iter().find(|belief| plain(&belief.joint.name) == plain(name));
        if let Some(found) = named {
            return Some((found, "of the same name".into()));
        }
        let place = among.iter().position(|other| other == name)?;
        let found = self.joints.get(place).filter(|_| self.joints.len() == among.len())?;
        let why = format!("both list {} joints, and this is number {}", among.len(), place + 1);
        Some((found, why))
    }

    /// Names of all joints.
    pub(super) fn names(&self) -> Vec<&str> {
        self.joints.iter().map(|belief| belief.joint.name.as_str()).collect()
    }
}

fn parsed<T>(
    path: &Path,
    parse: impl Fn(&str) -> Result<T, feeler_arm::ArmError>,
) -> Result<T, DiagnosisError> {
    let text = fs::read_to_string(path).map_err(|error| DiagnosisError::Unreadable {
        file: path.to_owned(),
        reason: error.to_string(),
        remedy: "check the name of the model file",
    })?;
    parse(&text).map_err(|error| wrong(path, &error))
}

fn wrong(path: &Path, error: &feeler_arm::ArmError) -> DiagnosisError {
    DiagnosisError::Unreadable {
        file: path.to_owned(),
        reason: error.to_string(),
        remedy: "correct the model file there, or leave it out: the motion alone gives a first machine",
    }
}

/// A machine file, the names of its signals, and the assumptions.
pub(super) struct First {
    pub(super) text: String,
    /// Signal of the target or command.
    pub(super) input: String,
    /// Signal of the position.
    pub(super) position: String,
    pub(super) assumptions: Vec<String>,
    /// Whether the text ends with the encoder of a first machine.
    is_own: bool,
}

impl First {
    /// A machine that the user gives.
    pub(super) fn given(path: &Path) -> Result<Self, DiagnosisError> {
        let document = Document::load(path)?;
        let machine = &document.scenario.machine;
        let file = || path.to_owned();
        let Some((name, drive)) = machine.actuators.iter().next() else {
            return Err(DiagnosisError::Unreadable {
                file: file(),
                reason: "the machine has no actuator, so that nothing takes the target".into(),
                remedy: "add [actuators.NAME] with `on` and `kind`",
            });
        };
        let sensor = machine.sensors.iter().find(|(_, sensor)| {
            sensor.reads.element == drive.on && sensor.reads.quantity == Quantity::Position
        });
        let position =
            sensor.map_or_else(|| format!("{}.position", drive.on), |(name, _)| format!("{name}.reading"));
        Ok(Self {
            text: document.to_toml(),
            input: format!("{name}.command"),
            position,
            assumptions: vec![format!(
                "the target drives `{name}`, the first actuator of {}",
                path.display()
            )],
            is_own: false,
        })
    }

    /// Adds the step of the encoder to a first machine.
    pub(super) fn note_step(&mut self, step: Option<f64>) {
        let Some(step) = step.filter(|_| self.is_own) else { return };
        let _ = writeln!(self.text, "resolution = {step:?}");
        self.assumptions.push(format!("the encoder's step is {}, which its readings show", short(step)));
    }

    /// A first machine of one joint with a position servo.
    pub(super) fn servo(belief: Option<&AxisBelief>, lag_s: Option<f64>) -> Self {
        let mut assumptions = Vec::new();
        let given = belief.cloned().unwrap_or_default();
        let joint = &given.joint;
        let mut inertia = given.inertia + joint.armature;
        let unit = if given.is_straight { "kg" } else { "kg m2" };
        if belief.is_none() {
            inertia = 1.0;
            assumptions.push(
                "without a model or a measured force the inertia is set to 1, and forces are relative to it"
                    .into(),
            );
        } else {
            assumptions.push(format!(
                "inertia {} {unit}: links {} at the pose where all joints are zero, armature {}",
                short(inertia),
                short(given.inertia),
                short(joint.armature)
            ));
        }
        if inertia < LEAST_INERTIA {
            inertia = LEAST_INERTIA;
            assumptions
                .push(format!("the model moves no mass here: the inertia is set to {LEAST_INERTIA} {unit}"));
        }
        let (kp, kd) = if let Some(kp) = joint.kp {
            assumptions.push(format!("kp {} and kd {}, as the model states", short(kp), short(joint.kd)));
            (kp, joint.kd)
        } else {
            let lag = lag_s.filter(|lag| *lag > 0.0).unwrap_or(USUAL_LAG_S);
            let omega = LAG_OMEGA / lag;
            let (kp, kd) = (inertia * omega.powi(2), (2.0 * inertia * omega - joint.damping).max(0.0));
            assumptions.push(format!(
                "kp {} and kd {} are guesses: a critically damped loop that lags by {} ms{}",
                short(kp),
                short(kd),
                short(1e3 * lag),
                if lag_s.is_some() { ", as the position does" } else { "" }
            ));
            (kp, kd)
        };
        let mut machine = Machine::new(if joint.name.is_empty() { BODY } else { &joint.name });
        machine.axis = if given.is_straight { Axis::Translational } else { Axis::Rotational };
        let mut bearing = Spring::new(GROUND, BODY, 0.0, joint.damping);
        if joint.friction > 0.0 {
            bearing.effects.push(EffectUse::of(CoulombFriction { level: joint.friction }));
        }
        let machine = machine.with_body(BODY, Body::new(inertia)).with_spring(BEARING, bearing);
        let mut text = machine_to_toml(&machine);
        let _ = writeln!(
            text,
            "\n[actuators.{SERVO}]\non = \"{BODY}\"\nkind = \"position-servo\"\nkp = {kp:?}\nkd = {kd:?}"
        );
        if joint.delay_s > 0.0 {
            let _ = writeln!(text, "delay = {:?}", joint.delay_s);
        }
        if let Some(limit) = joint.effort_limit {
            let _ = writeln!(text, "limit = {limit:?}");
        }
        let _ = writeln!(text, "\n[sensors.{ENCODER}]\nreads = \"{BODY}.position\"");
        Self {
            text,
            input: format!("{SERVO}.target"),
            position: format!("{ENCODER}.reading"),
            assumptions,
            is_own: true,
        }
    }
}
