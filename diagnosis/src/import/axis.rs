//! The believed machine of one joint: from a URDF or MJCF, or only from its motion.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use feeler_arm::{Chain, JointBelief, JointKind, Mjcf, Urdf};
use feeler_files::{Document, machine_to_toml};
use feeler_plant::description::{Axis, Body, GROUND, Machine, Quantity, Spring};
use feeler_plant::effects::{CoulombFriction, EffectUse};
use feeler_problem::{short, sort::sort_of};

use super::roles::{PLAIN, Role, words};
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
const DRIVE: &str = "drive";
const LOAD: &str = "load";
const ENCODER: &str = "encoder";
/// Half of the lag of a well damped loop is the time constant of its corner: `lag = 2 / omega`.
const LAG_OMEGA: f64 = 2.0;
/// Lag that is assumed if none is visible, s.
const USUAL_LAG_S: f64 = 0.05;
/// A lag this many times that of the stated loop is none of it: targets come late by a row or two besides.
const FAR_OFF_LAG: f64 = 5.0;
/// A gain this many times another is in another unit: believed masses are hardly twice the real ones.
const FAR_OFF_GAIN: f64 = 2.0;
/// Dry friction shifts where a joint holds its load by up to its level: a load this many times larger shows.
const LOAD_OVER_FRICTION: f64 = 3.0;
/// Share of the squares of the errors that a load explains at least where it makes them.
const LEAST_EXPLAINED: f64 = 0.25;
/// Armature that is assumed for a joint whose model moves no mass, kg m2.
const LEAST_INERTIA: f64 = 1e-6;

/// Every joint of a model.
pub(super) struct Beliefs {
    joints: Vec<AxisBelief>,
    tree: Option<Urdf>,
}

/// The believed parameters of one joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AxisBelief {
    /// The joint and its loop.
    pub joint: JointBelief,
    /// Whether it slides.
    pub is_straight: bool,
    /// Inertia (or mass) of all that it moves, where all joints stand at zero.
    pub inertia: f64,
}

impl Beliefs {
    /// Reads a model.
    pub(super) fn load(model: &Model) -> Result<Self, DiagnosisError> {
        let (path, mjcf) = match model {
            Model::Urdf(path) => {
                let tree = parsed(path, "<robot", Urdf::parse)?;
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
            Model::Mjcf(path) => (path, parsed(path, "<mujoco", Mjcf::parse)?),
            Model::Machine(_) => return Ok(Self { joints: Vec::new(), tree: None }),
        };
        let mut joints = Vec::new();
        let names: Vec<String> = mjcf.joints.iter().map(|joint| joint.name.clone()).collect();
        for joint in mjcf.joints {
            let chain = mjcf.tree.chain(&joint.link).map_err(|error| wrong(path, &error))?;
            let place = |other: &feeler_arm::Joint| names.iter().position(|name| *name == other.name);
            let way: Vec<Option<usize>> = chain.joints.iter().map(place).collect();
            let at = chain.joints.iter().position(|other| other.name == joint.name);
            let pose = vec![0.0; chain.joints()];
            let inertia = at.map_or(0.0, |i| chain.mass_matrix(&pose)[(i, i)]);
            let is_straight = at.is_some_and(|i| chain.joints[i].kind == JointKind::Prismatic);
            joints.push((way, AxisBelief { joint, is_straight, inertia }));
        }
        // A file may list joints from the tip: every joint follows those that carry it.
        joints.sort_by(|(a, _), (b, _)| a.cmp(b));
        let joints = joints.into_iter().map(|(_, belief)| belief).collect();
        Ok(Self { joints, tree: Some(mjcf.tree) })
    }

    /// The longest chain on which a joint lies, and its place there.
    pub(super) fn chain_through(&self, joint: &str) -> Option<(Chain, usize)> {
        let tree = self.tree.as_ref()?;
        let chains = self.joints.iter().filter_map(|tip| tree.chain(&tip.joint.link).ok());
        let on_it = |chain: Chain| {
            let at = chain.joints.iter().position(|other| other.name == joint)?;
            Some((chain, at))
        };
        chains.filter_map(on_it).max_by_key(|(chain, _)| chain.joints())
    }

    /// The joint with this name in the log: by its name, or by words that both names share. Else by its
    /// index, if both have the same number and no name contradicts.
    pub(super) fn find(&self, name: &str, among: &[String]) -> Option<(&AxisBelief, String)> {
        let place = among.iter().position(|other| other == name)?;
        let named = by_names(among, &self.names());
        if let Some(joint) = named[place] {
            let found = &self.joints[joint];
            let is_same = plain(&found.joint.name) == plain(name);
            let why = if is_same { "of the same name" } else { "no other shares as many words with it" };
            return Some((found, why.into()));
        }
        let agree = named.iter().enumerate().all(|(i, joint)| joint.is_none_or(|joint| joint == i));
        let found = self.joints.get(place).filter(|_| agree && self.joints.len() == among.len())?;
        let why = format!("both list {} joints, and this is number {}", among.len(), place + 1);
        Some((found, why))
    }

    /// Names of all joints.
    pub(super) fn names(&self) -> Vec<&str> {
        self.joints.iter().map(|belief| belief.joint.name.as_str()).collect()
    }
}

fn plain(name: &str) -> String {
    name.to_lowercase().replace(['_', '-', ' '], "")
}

/// For each name of the log, the joint that has its name, or shares more words with it than with any other
/// name.
fn by_names(logged: &[String], joints: &[&str]) -> Vec<Option<usize>> {
    let equal = |name: &String| joints.iter().position(|joint| plain(joint) == plain(name));
    let mut found: Vec<Option<usize>> = logged.iter().map(equal).collect();
    // Pairs that are both open, and the words that they share.
    let open = |found: &[Option<usize>]| -> Vec<([usize; 2], usize, usize)> {
        let names = (0..logged.len()).filter(|i| found[*i].is_none());
        let pairs = names.flat_map(|i| (0..joints.len()).map(move |j| (i, j)));
        let pairs = pairs.filter(|(_, j)| !found.contains(&Some(*j)));
        pairs.map(|(i, j)| (shared_words(&logged[i], joints[j]), i, j)).filter(|of| of.0[0] > 0).collect()
    };
    loop {
        let pairs = open(&found);
        let is_best = |(words, i, j): &&([usize; 2], usize, usize)| {
            let rivals = pairs.iter().filter(|(_, k, l)| (k == i) != (l == j));
            rivals.map(|(other, ..)| other).all(|other| other < words)
        };
        let Some((_, i, j)) = pairs.iter().filter(is_best).max_by_key(|(words, ..)| *words) else {
            return found;
        };
        found[*i] = Some(*j);
    }
}

/// Number of words that two names of joints share, then of numbers.
fn shared_words(a: &str, b: &str) -> [usize; 2] {
    let others = words(b);
    let is_number = |word: &String| word.chars().all(|c| c.is_ascii_digit());
    let shared = words(a).into_iter().filter(|word| others.contains(word) && !PLAIN.contains(&word.as_str()));
    let (numbers, texts): (Vec<String>, Vec<String>) = shared.partition(is_number);
    [texts.len(), numbers.len()]
}

/// What is taken of the stated gains, and why, where a loop with them could not move as the log does.
///
/// A load is held with an error of `load / kp`. Where no load shows over dry friction, a target that moves
/// steadily is followed `(kd + damping) / kp` later. With the damping beside it, a smaller gain lags more.
fn believed_share(kp: f64, joint: &JointBelief, seen: &Seen) -> (f64, String) {
    let as_stated = (1.0, ", as the model states".into());
    if let Some(held) = seen.held.gain(LOAD_OVER_FRICTION * joint.friction) {
        let share = held / kp;
        if (1.0 / FAR_OFF_GAIN..FAR_OFF_GAIN).contains(&share) {
            return as_stated;
        }
        let why = format!(
            ": {} of what the model states, as the errors with which the servo holds its load show",
            short(share)
        );
        return (share, why);
    }
    let stated_s = (joint.kd + joint.damping) / kp;
    let Some(lag_s) = seen.lag_s.filter(|lag_s| *lag_s > FAR_OFF_LAG * (stated_s + joint.delay_s)) else {
        return as_stated;
    };
    let share = joint.damping / (kp * (lag_s - joint.delay_s) - joint.kd);
    if share <= 0.0 {
        return as_stated;
    }
    let why = format!(
        ": {} of what the model states, with which a loop lags by {} ms, and not by {} ms as the \
         position does",
        short(share),
        short(1e3 * stated_s),
        short(1e3 * lag_s)
    );
    (share, why)
}

/// Gains of a servo, and where they come from.
fn gains(joint: &JointBelief, inertia: f64, seen: &Seen) -> ([f64; 2], String) {
    if let Some(kp) = joint.kp {
        let (share, why) = believed_share(kp, joint, seen);
        let (kp, kd) = (share * kp, share * joint.kd);
        return ([kp, kd], format!("kp {} and kd {}{why}", short(kp), short(kd)));
    }
    let lag = seen.lag_s.filter(|lag| *lag > 0.0).unwrap_or(USUAL_LAG_S);
    let omega = LAG_OMEGA / lag;
    let (kp, kd) = (inertia * omega.powi(2), (2.0 * inertia * omega - joint.damping).max(0.0));
    let why = format!(
        "kp {} and kd {} are guesses: a critically damped loop that lags by {} ms{}",
        short(kp),
        short(kd),
        short(1e3 * lag),
        if seen.lag_s.is_some() { ", as the position does" } else { "" }
    );
    ([kp, kd], why)
}

/// What the log shows of a joint.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    /// How much later the position follows, s.
    pub(super) lag_s: Option<f64>,
    /// Errors under loads.
    pub(super) held: Held,
    /// Step of the encoder.
    pub(super) step: Option<f64>,
}

/// Sums over rows of an error under a known load.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Held {
    rows: f64,
    load_load: f64,
    load_error: f64,
    error_error: f64,
}

impl Held {
    pub(super) fn add(&mut self, load: f64, error: f64) {
        if load.is_finite() && error.is_finite() {
            self.rows += 1.0;
            self.load_load += load * load;
            self.load_error += load * error;
            self.error_error += error * error;
        }
    }

    /// Load over error, by least squares of the error, which friction and motion spoil; `None` if the
    /// load is no larger than this.
    fn gain(&self, least: f64) -> Option<f64> {
        let gain = -self.load_load / self.load_error;
        let is_loaded = self.load_load > self.rows * least.powi(2) && self.load_load > 0.0;
        let explained = self.load_error.powi(2) / (self.load_load * self.error_error);
        (is_loaded && explained > LEAST_EXPLAINED && gain.is_finite() && gain > 0.0).then_some(gain)
    }
}

/// A model whose first element is `root`.
fn parsed<T>(
    path: &Path,
    root: &str,
    parse: impl Fn(&str) -> Result<T, feeler_arm::ArmError>,
) -> Result<T, DiagnosisError> {
    let refuse =
        |reason: String, remedy| DiagnosisError::Unreadable { file: path.to_owned(), reason, remedy };
    let bytes =
        fs::read(path).map_err(|error| refuse(error.to_string(), "check the name of the model file"))?;
    if let Some(sort) = sort_of(&bytes) {
        return Err(refuse(sort.what.into(), "name a URDF or an MJCF model, or leave it out"));
    }
    let text = String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..at].split(|byte| *byte == b'\n').count();
        refuse(format!("line {line}: byte {at} is not UTF-8"), "save the model as UTF-8")
    })?;
    let xml = text.trim_start_matches('\u{feff}').trim_start().starts_with('<');
    for (other, what, remedy) in [
        ("<robot", "this is a URDF, not an MJCF model", "name it by --urdf"),
        ("<mujoco", "this is an MJCF model, not a URDF", "name it by --mjcf"),
    ] {
        if xml && other != root && text.contains(other) && !text.contains(root) {
            return Err(refuse(what.into(), remedy));
        }
    }
    if !xml {
        let remedy = "name a URDF by --urdf, an MJCF model by --mjcf, a machine file by --machine";
        return Err(refuse("this is not XML, so neither URDF nor MJCF".into(), remedy));
    }
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
            load: None,
        })
    }

    /// A first machine of one joint, with a position servo, or with a force drive if that command was logged.
    /// `middle` is the inertia of the links where each joint stands at the middle of the first run. It is
    /// given for an arm whose other joints and weight load this one.
    pub(super) fn of(input: Role, belief: Option<&AxisBelief>, middle: Option<f64>, seen: &Seen) -> Self {
        let is_force = input == Role::Command;
        let mut assumptions = Vec::new();
        let given = belief.cloned().unwrap_or_default();
        let joint = &given.joint;
        let links = middle.unwrap_or(given.inertia);
        let mut inertia = links + joint.armature;
        let unit = if given.is_straight { "kg" } else { "kg m2" };
        if belief.is_none() {
            inertia = 1.0;
            let assumed = if is_force {
                "without a model the inertia is set to 1"
            } else {
                "without a model or a measured force the inertia is set to 1, and forces are relative to it"
            };
            assumptions.push(assumed.into());
        } else {
            assumptions.push(format!(
                "inertia {} {unit}: links {} {}, armature {}",
                short(inertia),
                short(links),
                if middle.is_some() {
                    "where each joint stands at the middle of the first run"
                } else {
                    "where all joints are zero"
                },
                short(joint.armature)
            ));
        }
        if inertia < LEAST_INERTIA {
            inertia = LEAST_INERTIA;
            assumptions
                .push(format!("the model moves no mass here: the inertia is set to {LEAST_INERTIA} {unit}"));
        }
        let name = if is_force { DRIVE } else { SERVO };
        let kind = if is_force {
            assumptions.push("the command is the force of the drive".into());
            "kind = \"force\"".to_owned()
        } else {
            let ([kp, kd], why) = gains(joint, inertia, seen);
            assumptions.push(why);
            format!("kind = \"position-servo\"\nkp = {kp:?}\nkd = {kd:?}")
        };
        let mut machine = Machine::new(if joint.name.is_empty() { BODY } else { &joint.name });
        machine.axis = if given.is_straight { Axis::Translational } else { Axis::Rotational };
        let mut bearing = Spring::new(GROUND, BODY, 0.0, joint.damping);
        if joint.friction > 0.0 {
            bearing.effects.push(EffectUse::of(CoulombFriction { level: joint.friction }));
        }
        let machine = machine.with_body(BODY, Body::new(inertia)).with_spring(BEARING, bearing);
        let mut text = machine_to_toml(&machine);
        let _ = writeln!(text, "\n[actuators.{name}]\non = \"{BODY}\"\n{kind}");
        if joint.delay_s > 0.0 && !is_force {
            let _ = writeln!(text, "delay = {:?}", joint.delay_s);
        }
        if let Some(limit) = joint.effort_limit {
            let _ = writeln!(text, "limit = {limit:?}");
        }
        if middle.is_some() {
            let _ = writeln!(text, "\n[actuators.{LOAD}]\non = \"{BODY}\"\nkind = \"force\"");
            assumptions.push(
                "the column `load` is the load of the weight and of the other joints' motion, from the \
                 masses of the model and the positions of the log"
                    .into(),
            );
        }
        let _ = writeln!(text, "\n[sensors.{ENCODER}]\nreads = \"{BODY}.position\"");
        if let Some(step) = seen.step {
            let _ = writeln!(text, "resolution = {step:?}");
            assumptions.push(format!("the encoder's step is {}, which its readings show", short(step)));
        }
        Self {
            text,
            input: format!("{name}.{}", if is_force { "command" } else { "target" }),
            position: format!("{ENCODER}.reading"),
            assumptions,
            load: middle.map(|_| format!("{LOAD}.command")),
        }
    }
}
