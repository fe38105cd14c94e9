//! What can be wrong with an arm.

use thiserror::Error;

fn four_digits(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// Why an arm cannot be read, moved or reduced.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ArmError {
    /// The text is no XML.
    #[error("the URDF is no XML: {what}; export it again")]
    Xml {
        /// What the parser says, with line and column.
        what: String,
    },
    /// An element of the URDF is missing or wrong.
    #[error("line {line}: {what}")]
    Urdf {
        /// The line, from 1.
        line: u32,
        /// What is wrong, and what to do.
        what: String,
    },
    /// A link or joint that does not exist.
    #[error("there is no {kind} `{name}` in the URDF; it has {known}")]
    Unknown {
        /// `link` or `joint`.
        kind: &'static str,
        /// What was asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// A moving link that can turn about an axis around which nothing resists.
    #[error(
        "joint `{joint}` moves nothing that has mass or inertia: all from link `{link}` to the tip is massless about its axis; give the link an `inertial`"
    )]
    Massless {
        /// The joint.
        joint: String,
        /// The link it moves.
        link: String,
    },
    /// A chain without joints that move.
    #[error("nothing moves between the base and link `{tip}`; name a link further out")]
    NoJoints {
        /// The last link.
        tip: String,
    },
    /// The number of joint positions.
    #[error("{given} joint positions for {needed} joints ({names}); give one each, in this order")]
    Pose {
        /// How many were given.
        given: usize,
        /// How many are needed.
        needed: usize,
        /// The joints.
        names: String,
    },
    /// A joint beyond its limits.
    #[error("joint `{joint}` at {position} is outside its limits, {lower} to {upper}; choose a pose inside")]
    Limit {
        /// The joint.
        joint: String,
        /// The position asked for, rad or m.
        position: f64,
        /// Lower limit.
        lower: f64,
        /// Upper limit.
        upper: f64,
    },
    /// A direction that is none.
    #[error("the normal [{}, {}, {}] has no direction; give three numbers that are not all zero", .normal[0], .normal[1], .normal[2])]
    Normal {
        /// What was given.
        normal: [f64; 3],
    },
    /// The arm cannot move along the normal at a pose.
    #[error(
        "at this pose the arm cannot move along the normal{held}: the best it can do is {share} of a unit per unit of joint motion; choose another pose or normal, or let the other directions go"
    )]
    Singular {
        /// A remark on the other directions.
        held: &'static str,
        /// Smallest singular value of the task over the largest.
        share: f64,
    },
    /// A joint without what the reduction needs.
    #[error("joint `{joint}`: {what} is {value}; it must be {rule}")]
    Drive {
        /// The joint.
        joint: String,
        /// Which number.
        what: &'static str,
        /// What was given.
        value: f64,
        /// What it must be.
        rule: &'static str,
    },
    /// Numbers left all bounds.
    #[error("the motion diverged at {t_s} s; take a smaller step")]
    Diverged {
        /// When, s.
        t_s: f64,
    },
    /// No pose was found that brings the tool there.
    #[error("no pose within the joint limits brings the tool to [{}, {}, {}] m; {} m are left", .target_m[0], .target_m[1], .target_m[2], four_digits(*.left_m))]
    Unreachable {
        /// Where it should go.
        target_m: [f64; 3],
        /// How far away the best pose is.
        left_m: f64,
    },
}
