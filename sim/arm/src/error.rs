//! Errors of an arm.

use std::borrow::Cow;

use feeler_problem::{Remedy, short};
use thiserror::Error;

/// Why an arm cannot be read, moved or reduced.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ArmError {
    #[error("the model is not XML: {what}")]
    Xml {
        /// The parser's message, with line and column.
        what: String,
    },
    #[error("line {line}: {what}")]
    Urdf {
        /// The line, from 1.
        line: u32,
        what: String,
        remedy: Cow<'static, str>,
    },
    #[error("there is no {kind} `{name}` in the model")]
    Unknown {
        /// `link` or `joint`.
        kind: &'static str,
        name: String,
        known: String,
    },
    #[error(
        "joint `{joint}` moves nothing that has mass or inertia: all from link `{link}` to the tip is \
         massless about its axis"
    )]
    Massless { joint: String, link: String },
    #[error("nothing moves between the base and link `{tip}`")]
    NoJoints { tip: String },
    #[error("{given} joint positions for {needed} joints ({names})")]
    Pose { given: usize, needed: usize, names: String },
    #[error("joint `{joint}` at {position} is outside its limits, {lower} to {upper}")]
    Limit {
        joint: String,
        /// The requested position, rad or m.
        position: f64,
        lower: f64,
        upper: f64,
    },
    #[error("the normal [{}, {}, {}] has no direction", .normal[0], .normal[1], .normal[2])]
    Normal { normal: [f64; 3] },
    #[error(
        "at this pose the arm cannot move along the normal{held}: the best it can do is {share} of a unit \
         per unit of joint motion"
    )]
    Singular {
        /// A remark on the other directions.
        held: &'static str,
        /// Smallest singular value of the task over the largest.
        share: f64,
    },
    #[error("joint `{joint}`: {what} is {value}")]
    Drive { joint: String, what: &'static str, value: f64, rule: &'static str },
    #[error("the motion diverged at {t_s} s")]
    Diverged { t_s: f64 },
    #[error("no pose within the joint limits brings the tool to [{}, {}, {}] m: the best pose \
             misses it by {} m", .target_m[0], .target_m[1], .target_m[2], short(*.left_m))]
    Unreachable {
        target_m: [f64; 3],
        /// Distance of the best pose.
        left_m: f64,
    },
}

impl Remedy for ArmError {
    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::Xml { .. } => "export the model again".into(),
            Self::Urdf { remedy, .. } => remedy.as_ref().into(),
            Self::Unknown { known, .. } => format!("name one of {known}").into(),
            Self::Massless { link, .. } => format!("give link `{link}` an `inertial`").into(),
            Self::NoJoints { .. } => "name a link farther from the base".into(),
            Self::Pose { .. } => "give one each, in this order".into(),
            Self::Limit { joint, lower, upper, .. } => {
                format!("choose a pose with `{joint}` from {} to {}", short(*lower), short(*upper)).into()
            }
            Self::Normal { .. } => "give three numbers that are not all zero".into(),
            Self::Singular { .. } => {
                "choose another pose or normal, or leave the other directions free".into()
            }
            Self::Drive { what, rule, .. } => format!("write a {what} that is {rule}").into(),
            Self::Diverged { .. } => "take a smaller step".into(),
            Self::Unreachable { .. } => "choose a place within reach, or give a pose".into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let all = [
            ArmError::Xml { what: "unknown token at 1:1".into() },
            ArmError::Urdf { line: 3, what: "`<link>` has no `name`".into(), remedy: "add `name`".into() },
            ArmError::Unknown { kind: "link", name: "tol".into(), known: "base, tool".into() },
            ArmError::Massless { joint: "j1".into(), link: "l1".into() },
            ArmError::NoJoints { tip: "base".into() },
            ArmError::Pose { given: 1, needed: 2, names: "j1, j2".into() },
            ArmError::Limit { joint: "j1".into(), position: 4.0, lower: -3.0, upper: 3.0 },
            ArmError::Normal { normal: [0.0; 3] },
            ArmError::Singular { held: "", share: 0.0 },
            ArmError::Drive { joint: "j1".into(), what: "stiffness", value: 0.0, rule: "above zero" },
            ArmError::Diverged { t_s: 0.1 },
            ArmError::Unreachable { target_m: [9.0, 0.0, 0.0], left_m: 8.0 },
        ];
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("error.rs")),
            Vec::<String>::new()
        );
    }
}
