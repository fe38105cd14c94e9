//! The simulator as a library: one crate that names the parts.
//!
//! ```
//! use feeler_sim::prelude::*;
//!
//! // A 10 kg axis, 5 mm off a wall of 100 kN/m, pushed towards it with 40 N.
//! let mut machine = Machine::default();
//! machine.bodies.insert("tip".into(), Body { mass_kg: 10.0, position_m: -5e-3, ..Body::default() });
//! machine.contacts.insert("tool".into(), Contact::kelvin_voigt("tip", GROUND, 1e5, 100.0));
//! machine.actuators.insert("drive".into(), Actuator::ideal("tip", GROUND));
//! let mut spec = ControllerSpec::new(Law::OpenLoop, 1e-3);
//! spec.reference = ReferenceSpec::Constant(40.0);
//! let controller = ControllerUse { spec, reads: None, motion: None, drives: "drive".into(), effects: Vec::new() };
//! let run = RunSettings { duration_s: 0.2, record: vec!["tool.force".parse()?], ..RunSettings::default() };
//! let scenario = Scenario { machine, controllers: [("push".to_string(), controller)].into_iter().collect(), run };
//!
//! let program = Program::new(&scenario)?;
//! let mut trace = Trace::new(program.record_names());
//! Simulation::<f64>::new(vec![program])?.run(&mut trace)?;
//!
//! // Constant acceleration without friction: it touches after sqrt(2 * 5 mm * 10 kg / 40 N) = 50 ms.
//! assert!((trace.events[0].t_s - 0.05).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub use feeler_analysis as analysis;
pub use feeler_control as control;
pub use feeler_engine as engine;
pub use feeler_lanes as lanes;
pub use feeler_lti as lti;
pub use feeler_plant as plant;

/// What most programs need.
pub mod prelude {
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
