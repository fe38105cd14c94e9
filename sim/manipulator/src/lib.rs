//! A whole arm in motion against a workpiece.
//!
//! A [`Cell`] describes the simulation: an arm with its joints' drives and effects, and a tool tip and a
//! workpiece with their shapes. It also has a wrist sensor and a controller. The controller controls the
//! force along a normal and holds the tool's other directions. [`CellSimulation`] integrates the full
//! nonlinear equations of the flexible-joint arm (M. W. Spong, J. Dyn. Sys. Meas. Control 109, 1987) by
//! classical Runge-Kutta steps. A step ends when the tool touches or leaves the workpiece. It also ends when
//! a flank of a free play meets, or a joint sticks or breaks loose. Gravity counts as compensated.
//!
//! Sensors, filters, drives, effects and control laws are those of the single axis: `feeler-plant`,
//! `feeler-control` and the parts of `feeler-engine`. The controller drives a force along the normal.
//! Contact, sensors, controller and run are therefore described by a scenario of the axis that represents the
//! arm along that normal.

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
mod start;
mod state;
mod stepping;

pub use bodies::{BodyShapes, link_capsules};
pub use cell::{Cell, Hold};
pub use error::ManipulatorError;
pub use joint::{JointPart, joint_effect_host, joint_effects};
pub use record::{CellRecord, JointEvent, LOWER, UPPER};
pub use simulation::{CellSimulation, Finished};
pub use start::{Part, Start};
