//! The machine for tests of effects: motor (7 kg) and tip (5 kg) on a guide, in front of a wall.

use super::Host;
use crate::assembly::{Assembly, assemble};
use crate::description::{Actuator, Axis, Body, Contact, Machine, Quantity, Sensor, SignalName, Spring};

pub(super) const MOTOR: Host = Host::Body(1);
pub(super) const GUIDE: Host = Host::Spring(0);
pub(super) const TRANSMISSION: Host = Host::Spring(1);
pub(super) const TOOL: Host = Host::Contact(0);
pub(super) const FORCE: Host = Host::Sensor(0);

/// Motor and tip move as one.
pub(super) fn rigid() -> Assembly {
    axis(Spring { between: ["motor".into(), "tip".into()], rigid: true, ..Spring::default() })
}

/// Motor and tip are joined by a spring.
pub(super) fn flexible() -> Assembly {
    let between = ["motor".into(), "tip".into()];
    axis(Spring { between, stiffness_n_per_m: 1.2e6, damping_n_s_per_m: 120.0, ..Spring::default() })
}

fn axis(transmission: Spring) -> Assembly {
    let body = |mass_kg| Body { mass_kg, ..Body::default() };
    let guide =
        Spring { between: ["ground".into(), "motor".into()], damping_n_s_per_m: 60.0, ..Spring::default() };
    let tool = Contact { gap_m: 4e-3, ..Contact::kelvin_voigt("tip", "ground", 2e5, 120.0) };
    let drive = Actuator::ideal("motor", "ground");
    let sensor = |element: &str, quantity| Sensor::ideal(SignalName::new(element, quantity));
    let machine = Machine {
        name: "axis".into(),
        about: "the smallest machine on which every effect has a place".into(),
        axis: Axis::Translational,
        bodies: [("motor".into(), body(7.0)), ("tip".into(), body(5.0))].into_iter().collect(),
        springs: [("guide".into(), guide), ("transmission".into(), transmission)].into_iter().collect(),
        contacts: [("tool".into(), tool)].into_iter().collect(),
        actuators: [("drive".into(), drive)].into_iter().collect(),
        sensors: [
            ("force".into(), sensor("tool", Quantity::SpringForce)),
            ("encoder".into(), sensor("motor", Quantity::Position)),
        ]
        .into_iter()
        .collect(),
        ..Machine::default()
    };
    assemble(&machine).unwrap()
}
