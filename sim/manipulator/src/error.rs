//! Errors of an arm against a workpiece.

use std::borrow::Cow;

use feeler_arm::ArmError;
use feeler_control::ControlError;
use feeler_engine::{EngineError, RunSettings};
use feeler_geometry::GeometryError;
use feeler_problem::{Remedy, short};
use thiserror::Error;

use crate::start::{Part, Start};

/// Why a cell cannot be simulated.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ManipulatorError {
    #[error(transparent)]
    Arm(#[from] ArmError),
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    #[error(transparent)]
    Engine(#[from] EngineError),
    #[error(transparent)]
    Control(#[from] ControlError),
    /// An element that the axis along the normal must have exactly once.
    #[error("there must be one {what}, not {count}")]
    Count { what: &'static str, count: usize },
    #[error("the tip starts {} m inside the workpiece", short(*.depth_m))]
    Penetrates { depth_m: f64 },
    #[error("along the normal from its start the tip never meets the workpiece")]
    NeverMeets,
    #[error(
        "the tip would touch after {} m along the normal, at [{}, {}, {}] m, where the arm does not reach \
         (the best pose misses it by {} m)",
        short(*.travel_m), short(.place_m[0]), short(.place_m[1]), short(.place_m[2]), short(*.left_m)
    )]
    OutOfReach {
        travel_m: f64,
        place_m: [f64; 3],
        /// Distance of the best pose, m.
        left_m: f64,
    },
    #[error("at the start the links `{a}` and `{b}` overlap by {} m", short(*.depth_m))]
    SelfIntersects {
        /// The first link, or `base`.
        a: String,
        b: String,
        depth_m: f64,
    },
    #[error("steps of {step_s} s are too long for the fastest mode of the arm in contact, {rate_per_s} 1/s")]
    Step { step_s: f64, rate_per_s: f64, most_s: f64 },
    #[error(
        "{what} asks for steps of {step_s:.3e} s, and {duration_s} s are {steps:.3e} of them, while at most \
         {most:.0e} are taken"
    )]
    Work {
        /// The fastest part.
        what: String,
        key: String,
        step_s: f64,
        duration_s: f64,
        steps: f64,
        most: f64,
    },
}

impl Remedy for ManipulatorError {
    fn passed_on(&self) -> Option<&dyn Remedy> {
        match self {
            Self::Arm(error) => Some(error),
            Self::Geometry(error) => Some(error),
            Self::Engine(error) => Some(error),
            Self::Control(error) => Some(error),
            _ => None,
        }
    }

    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::Arm(error) => error.remedy(),
            Self::Geometry(error) => error.remedy(),
            Self::Engine(error) => error.remedy(),
            Self::Control(error) => error.remedy(),
            Self::Count { what, count: 0 } => format!("add a {what}").into(),
            Self::Count { what, .. } => format!("keep one {what} and remove the others").into(),
            Self::Penetrates { .. } => "move the start back against the normal, or the workpiece away".into(),
            Self::NeverMeets => "turn the normal towards it, or move start or workpiece".into(),
            Self::OutOfReach { .. } => "move the workpiece nearer".into(),
            Self::SelfIntersects { .. } => "choose a pose in which the arm does not run into itself".into(),
            Self::Step { most_s, .. } => format!("choose {most_s} s or less, or leave the step out").into(),
            Self::Work { .. } => "make the fastest motion slower, as by more inertia or less stiffness and \
                 damping, or shorten the run"
                .into(),
        }
    }

    fn place(&self) -> String {
        match self {
            Self::Work { key, .. } => key.clone(),
            Self::Step { .. } => RunSettings::key(&RunSettings::STEP),
            Self::NeverMeets => format!("{}.{}", Start::TABLE, Start::NORMAL.name),
            Self::OutOfReach { .. } => Part::WORKPIECE.into(),
            Self::Geometry(_) => Part::TIP.into(),
            Self::Penetrates { .. } | Self::SelfIntersects { .. } | Self::Count { .. } => Start::TABLE.into(),
            Self::Arm(_) | Self::Engine(_) | Self::Control(_) => {
                self.passed_on().map_or_else(String::new, Remedy::place)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let all = [
            ManipulatorError::Arm(ArmError::Normal { normal: [0.0; 3] }),
            ManipulatorError::Geometry(GeometryError::EmptyPath),
            ManipulatorError::Engine(EngineError::Lanes { given: 3, lanes: 4 }),
            ManipulatorError::Control(ControlError::ApproachNeedsForce),
            ManipulatorError::Count { what: "contact", count: 0 },
            ManipulatorError::Count { what: "contact", count: 2 },
            ManipulatorError::Penetrates { depth_m: 1e-3 },
            ManipulatorError::NeverMeets,
            ManipulatorError::OutOfReach { travel_m: 1.0, place_m: [1.0; 3], left_m: 0.1 },
            ManipulatorError::SelfIntersects { a: "base".into(), b: "l3".into(), depth_m: 1e-3 },
            ManipulatorError::Step { step_s: 1.0, rate_per_s: 1e3, most_s: 1e-3 },
            ManipulatorError::Work {
                what: "the motor of joint j1".into(),
                key: "joints.j1".into(),
                step_s: 1e-9,
                duration_s: 1.0,
                steps: 1e9,
                most: 1e8,
            },
        ];
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("error.rs")),
            Vec::<String>::new()
        );
    }
}
