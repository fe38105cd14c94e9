//! Feeler as a library: one crate that re-exports the parts.
//!
//! ```
//! use feeler_sim::prelude::*;
//!
//! // A 10 kg axis, 5 mm off a wall of 100 kN/m, pushed towards it with 40 N.
//! let machine = Machine::new("axis")
//!     .with_body("tip", Body::new(10.0).at(-5e-3))
//!     .with_contact("tool", Contact::kelvin_voigt("tip", GROUND, 1e5, 100.0))
//!     .with_actuator("drive", Actuator::ideal("tip", GROUND));
//! let push = ControllerSpec {
//!     reference: ReferenceSpec::Constant(40.0),
//!     ..ControllerSpec::new(Law::OpenLoop, 1e-3)
//! };
//! let scenario = Scenario::new(machine)
//!     .with_controller("push", ControllerUse::new(push, "drive"))
//!     .lasting(0.2)
//!     .recording(["tool.force".parse()?], 1e4);
//!
//! let trace = trace(&scenario)?;
//!
//! // Constant acceleration without friction: it touches after sqrt(2 * 5 mm * 10 kg / 40 N) = 50 ms.
//! assert!((trace.events[0].t_s - 0.05).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The programs in `examples/` go on from here: pressing a wall, chatter, a sweep, linear theory, a
//! diagnosis, and a whole arm. Each prints numbers beside what a reader can compute by hand.
//!
//! | wanted | where |
//! |---|---|
//! | a machine and a run of it | [`plant`], [`control`], [`engine`] |
//! | poles, margins, stable gains, bandwidth | [`analysis`], on [`lti`] |
//! | scenario files and back | [`files`], whose keys are [`catalogue`]'s |
//! | outcomes, sweeps, frequency responses, reasons of chatter | [`studies`] |
//! | what a machine file does not know | [`diagnosis`] |
//! | whole arms | [`arm`], [`manipulator`], with [`geometry`] |
//! | all of it beside closed forms and other people's numbers | [`validation`] |
//! | Rapier in place of the own stepper | [`multibody`] |

pub use feeler_analysis as analysis;
pub use feeler_arm as arm;
pub use feeler_catalogue as catalogue;
pub use feeler_control as control;
pub use feeler_diagnosis as diagnosis;
pub use feeler_engine as engine;
pub use feeler_files as files;
pub use feeler_geometry as geometry;
pub use feeler_lanes as lanes;
pub use feeler_logs as logs;
pub use feeler_lti as lti;
pub use feeler_manipulator as manipulator;
pub use feeler_multibody as multibody;
pub use feeler_plant as plant;
pub use feeler_problem as problem;
pub use feeler_studies as studies;
pub use feeler_validation as validation;

use feeler_engine::{EngineError, Program, Scenario, Simulation, Trace};

/// Runs a scenario and returns its record with events. [`studies::run::run`] also gives the outcome.
///
/// # Errors
/// Every mistake of the scenario at once.
pub fn trace(scenario: &Scenario) -> Result<Trace, EngineError> {
    let program = Program::new(scenario)?;
    let mut trace = Trace::new(program.record_names());
    Simulation::<f64>::new(vec![program])?.run(&mut trace)?;
    Ok(trace)
}

/// The names that most programs need.
pub mod prelude {
    pub use crate::trace;
    pub use feeler_control::{Approach, ControllerSpec, ForceGains, Law, PositionGains, ReferenceSpec};
    pub use feeler_engine::{
        ControllerUse, EnergyBalance, EngineError, Event, EventKind, Integrator, Observer, Program, RunEnd,
        RunSettings, Scenario, Simulation, Trace,
    };
    pub use feeler_lanes::{Lane, Pack};
    pub use feeler_plant::description::{
        Actuator, ActuatorKind, Axis, Body, Contact, ContactLaw, Engagement, GROUND, LowPass, Machine,
        Quantity, Sensor, SignalName, Spring,
    };
}
