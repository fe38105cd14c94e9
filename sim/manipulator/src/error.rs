//! What can be wrong with an arm against a workpiece.

use feeler_arm::ArmError;
use feeler_control::ControlError;
use feeler_engine::EngineError;
use feeler_geometry::GeometryError;
use feeler_plant::problem::short;
use thiserror::Error;

/// Why a cell cannot be simulated.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ManipulatorError {
    /// The arm or its pose.
    #[error(transparent)]
    Arm(#[from] ArmError),
    /// The shapes.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// Contact, sensors or controller.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The controller.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// An element that the axis along the normal must have exactly once.
    #[error("there must be one {what}, not {count}")]
    Count {
        /// What it is.
        what: &'static str,
        /// How many there are.
        count: usize,
    },
    /// The tip starts inside the workpiece.
    #[error("the tip starts {} m inside the workpiece; move the start back against the normal, or the workpiece away", short(*.depth_m))]
    Penetrates {
        /// How deep.
        depth_m: f64,
    },
    /// On its way along the normal the tip passes the workpiece.
    #[error(
        "along the normal from its start the tip never meets the workpiece; turn the normal towards it, or move start or workpiece"
    )]
    NeverMeets,
    /// The place of contact is beyond the arm's reach.
    #[error(
        "the tip would touch after {} m along the normal, at [{}, {}, {}] m, where the arm does not reach ({} m are left); move the workpiece nearer",
        short(*.travel_m), short(.place_m[0]), short(.place_m[1]), short(.place_m[2]), short(*.left_m)
    )]
    OutOfReach {
        /// How far it would have to go.
        travel_m: f64,
        /// Where the tool would be.
        place_m: [f64; 3],
        /// How far away the best pose is.
        left_m: f64,
    },
    /// Two bodies of the arm overlap at the start.
    #[error("at the start the links `{a}` and `{b}` overlap by {} m; choose a pose in which the arm does not run into itself", short(*.depth_m))]
    SelfIntersects {
        /// The first link, or `base`.
        a: String,
        /// The other.
        b: String,
        /// How deep.
        depth_m: f64,
    },
    /// A step at which the stiffest mode grows.
    #[error(
        "steps of {step_s} s are too long for the fastest mode of the arm in contact, {rate_per_s} 1/s; choose {most_s} s or less, or leave the step out"
    )]
    Step {
        /// What was asked for.
        step_s: f64,
        /// Rate of the fastest mode.
        rate_per_s: f64,
        /// The longest step that can be taken.
        most_s: f64,
    },
    /// A run of more steps than anybody waits for.
    #[error(
        "{what} asks for steps of {step_s:.3e} s, and {duration_s} s are {steps:.3e} of them, while at most {most:.0e} are taken; make the fastest motion slower, as by \
         more inertia or less stiffness and damping, or shorten the run"
    )]
    Work {
        /// What is fastest.
        what: String,
        /// Its key in the file.
        key: String,
        /// The step it asks for.
        step_s: f64,
        /// The run.
        duration_s: f64,
        /// How many steps.
        steps: f64,
        /// How many are taken.
        most: f64,
    },
}
