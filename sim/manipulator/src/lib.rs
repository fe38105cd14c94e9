//! A whole arm in motion against a workpiece.
//!
//! [`Cell`] is what is to be simulated: an arm with its joints' drives and effects, a tool tip and a
//! workpiece with their shapes, a wrist sensor, and a controller of the force along a normal that holds the
//! tool's other directions. [`Simulation`] moves it: the full nonlinear equations of the flexible-joint arm
//! (M. W. Spong, J. Dyn. Sys. Meas. Control 109, 1987) by classical Runge-Kutta steps, which end where the
//! tool touches or leaves the workpiece, a flank of a free play meets, or a joint sticks or breaks loose.
//! Gravity is taken as compensated.
//!
//! Sensors, filters, drives, effects and control laws are those of the single axis: `feeler-plant`,
//! `feeler-control` and the parts of `feeler-engine`. What the controller drives is a force along the normal,
//! and so what describes contact, sensors, controller and run is a scenario of the axis that the arm is along
//! that normal.

mod bodies;
mod cell;
mod error;
mod evaluation;
mod hold;
mod joint;
mod mode;
mod record;
mod sampling;
mod simulation;
mod state;
mod stepping;

pub use bodies::{BodyShapes, link_capsules};
pub use cell::{Cell, Hold, Part, Start};
pub use error::ManipulatorError;
pub use joint::{JointPart, joint_effect_host, joint_effects};
pub use record::{JointEvent, LOWER, Record, UPPER};
pub use simulation::{Finished, Simulation};
