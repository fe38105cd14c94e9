//! Actuators: the loop of a servo, and the limit of its force.

use roxmltree::Node;

use super::belief::JointBelief;
use super::known::ACTUATORS;
use super::read::{Remarks, exactly, numbers_of};
use crate::error::ArmError;
use crate::xml::wrong;

/// An actuator as its class and its own attributes make it. All kinds share their defaults, as in MuJoCo:
/// `general` is the common form of the others.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    gain: f64,
    /// Force without a command: constant, per position, per speed.
    bias: [f64; 3],
    is_biased: bool,
    /// The damping is a ratio, not a force per speed.
    has_ratio: bool,
    /// Gain, bias or dynamics of a kind that is not read.
    is_other: bool,
    gear: f64,
    forces: Option<[f64; 2]>,
    is_limited: Option<bool>,
    commands: Option<[f64; 2]>,
    is_clamped: Option<bool>,
    armature: f64,
    damping: f64,
    delay_s: f64,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            gain: 1.0,
            bias: [0.0; 3],
            is_biased: false,
            has_ratio: false,
            is_other: false,
            gear: 1.0,
            forces: None,
            is_limited: None,
            commands: None,
            is_clamped: None,
            armature: 0.0,
            damping: 0.0,
            delay_s: 0.0,
        }
    }
}

impl Drive {
    /// Takes the attributes of an element. Elements other than actuators change nothing.
    pub(super) fn apply(&mut self, node: Node<'_, '_>, remarks: &mut Remarks) -> Result<(), ArmError> {
        let kind = node.tag_name().name();
        if !ACTUATORS.contains(&kind) {
            return Ok(());
        }
        remarks.check(node, kind)?;
        let find = |name: &str| node.attribute(name);
        let first = |name: &str, absent: f64| match find(name) {
            None => Ok(absent),
            Some(text) => Ok(numbers_of(node, name, text)?.first().copied().unwrap_or(absent)),
        };
        let pair = |name: &str| find(name).map(|text| exactly::<2>(node, name, text)).transpose();
        let yes = |name: &str| find(name).filter(|word| *word != "auto").map(|word| word == "true");
        self.gear = first("gear", self.gear)?;
        self.armature = first("armature", self.armature)?;
        self.damping = first("damping", self.damping)?;
        self.delay_s = first("delay", self.delay_s)?;
        self.forces = pair("forcerange")?.or(self.forces);
        self.commands = pair("ctrlrange")?.or(self.commands);
        self.is_limited = yes("forcelimited").or(self.is_limited);
        self.is_clamped = yes("ctrllimited").or(self.is_clamped);
        match kind {
            "position" => {
                let kp = first("kp", self.gain)?;
                if find("dampratio").is_some() && find("kv").is_some() {
                    return wrong(node, "it states both `kv` and `dampratio`", "remove one of them");
                }
                let kd = -first("kv", -self.bias[2])?;
                if find("kv").is_some() || find("dampratio").is_some() {
                    self.has_ratio = first("dampratio", 0.0)? > 0.0;
                }
                (self.gain, self.bias, self.is_biased) = (kp, [0.0, -kp, kd], true);
                self.is_other = false;
            }
            "motor" => {
                (self.gain, self.is_biased, self.has_ratio, self.is_other) = (1.0, false, false, false);
            }
            _ => {
                self.gain = first("gainprm", self.gain)?;
                if let Some(text) = find("biasprm") {
                    let all = numbers_of(node, "biasprm", text)?;
                    (0..3).for_each(|i| self.bias[i] = all.get(i).copied().unwrap_or(self.bias[i]));
                    self.has_ratio = self.bias[2] > 0.0;
                }
                let is = |name: &str, known: &[&str]| find(name).is_none_or(|word| known.contains(&word));
                self.is_other |= !is("gaintype", &["fixed"]) || !is("dyntype", &["none"]);
                self.is_other |= !is("biastype", &["none", "affine"]);
                self.is_biased = find("biastype").map_or(self.is_biased, |word| word == "affine");
            }
        }
        Ok(())
    }

    /// Adds it to the beliefs of the joint that it drives.
    pub(super) fn drives(
        &self,
        node: Node<'_, '_>,
        belief: &mut JointBelief,
        remarks: &mut Remarks,
    ) -> Result<(), ArmError> {
        let remedy = "state `kp` and `kv` of the joint itself, and leave it out";
        let is_servo = self.is_biased && self.bias.iter().any(|x| x.abs() > 0.0);
        let is_position = is_servo && (self.gain + self.bias[1]).abs() <= f64::EPSILON * self.gain.abs();
        let is_geared = (self.gear - 1.0).abs() > f64::EPSILON;
        if self.is_other || is_servo && (!is_position || self.bias[0].abs() > 0.0) {
            let follows = "state a servo as `<position joint= kp= kv=/>`";
            remarks.add(node, format!("the actuator of joint `{}`", belief.name), follows);
            return Ok(());
        }
        if is_servo && is_geared {
            return wrong(node, "the `gear` of a servo is not read", remedy);
        }
        if is_servo && self.has_ratio {
            return wrong(node, "a damping by `dampratio` is not read", remedy);
        }
        if is_servo && belief.kp.is_some() {
            let what = format!("joint `{}` has two position servos", belief.name);
            return wrong(node, what, "leave one of them out");
        }
        let forces = self.forces.filter(|_| self.is_limited != Some(false));
        let commands = self.commands.filter(|_| self.is_clamped != Some(false));
        let of_command = commands.filter(|_| !is_servo).map(|range| range.map(|u| self.gain * u));
        for range in [forces, of_command].into_iter().flatten() {
            limit(node, belief, range.map(|force| self.gear * force), remarks);
        }
        if is_servo {
            belief.kp = Some(self.gain).filter(|kp| *kp > 0.0);
            belief.kd = -self.bias[2];
            if commands.is_some() {
                remarks.add(node, "the range of targets (`ctrlrange`)", "no target is clamped");
            }
        }
        belief.delay_s = self.delay_s;
        belief.armature += self.gear.powi(2) * self.armature;
        belief.damping += self.gear.powi(2) * self.damping;
        Ok(())
    }
}

/// Lowers the limit of a joint's effort to that of a range.
pub(super) fn limit(node: Node<'_, '_>, belief: &mut JointBelief, range: [f64; 2], remarks: &mut Remarks) {
    let [low, high] = range.map(f64::abs);
    if (low - high).abs() > f64::EPSILON * low.max(high) {
        let what = format!("the smaller limit of the force on joint `{}`", belief.name);
        remarks.add(node, what, "`limit` of the drive is the larger one");
    }
    let most = low.max(high);
    if most > 0.0 {
        belief.effort_limit = Some(belief.effort_limit.map_or(most, |other| other.min(most)));
    }
}
