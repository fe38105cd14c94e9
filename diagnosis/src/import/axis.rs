//! The joints of a URDF or MJCF, and the one that a name in a log means.

use std::fs;
use std::path::{Path, PathBuf};

use feeler_arm::{Chain, JointBelief, JointKind, Mjcf, Urdf};
use feeler_problem::sort::sort_of;

use super::roles::{PLAIN, words};
use crate::error::DiagnosisError;

/// Source of the beliefs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Model {
    /// A machine file, used unchanged.
    Machine(PathBuf),
    /// A URDF.
    Urdf(PathBuf),
    /// An MJCF.
    Mjcf(PathBuf),
}

/// Every joint of a model.
pub(super) struct Beliefs {
    joints: Vec<AxisBelief>,
    tree: Option<Urdf>,
    /// Statements of the file that are not read.
    pub(super) remarks: Vec<String>,
}

/// The believed parameters of one joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AxisBelief {
    /// The joint and its loop.
    pub joint: JointBelief,
    /// Whether it slides.
    pub is_straight: bool,
    /// Inertia (or mass) of all that it moves, with all joints at zero.
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
                (path, Mjcf { tree, joints, remarks: Vec::new() })
            }
            Model::Mjcf(path) => (path, parsed(path, "<mujoco", Mjcf::parse)?),
            Model::Machine(_) => return Ok(Self { joints: Vec::new(), tree: None, remarks: Vec::new() }),
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
        Ok(Self { joints, tree: Some(mjcf.tree), remarks: mjcf.remarks })
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
            let why = if is_same { "both have this name" } else { "no other shares as many words with it" };
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
    if xml && text.contains("<xacro:") {
        let remedy = "expand it by `xacro FILE > robot.urdf`, and name that";
        return Err(refuse("this is a xacro, which a URDF is made from".into(), remedy));
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
