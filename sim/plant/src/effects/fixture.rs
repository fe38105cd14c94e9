//! The machine for tests of effects: motor (7 kg) and tip (5 kg) on a guide, in front of a wall.

use super::Host;
use crate::assembly::{Assembly, assemble};
use crate::description::{Actuator, Body, Contact, Machine, Quantity, Sensor, SignalName, Spring};

pub(super) const MOTOR: Host = Host::Body(1);
pub(super) const GUIDE: Host = Host::Spring(0);
pub(super) const TRANSMISSION: Host = Host::Spring(1);
pub(super) const TOOL: Host = Host::Contact(0);
pub(super) const FORCE: Host = Host::Sensor(0);

/// Motor and tip move as one.
pub(super) fn rigid() -> Assembly {
    axis(Spring { rigid: true, ..Spring::new("motor", "tip", 0.0, 0.0) })
}

/// Motor and tip are joined by a spring.
pub(super) fn flexible() -> Assembly {
    axis(Spring::new("motor", "tip", 1.2e6, 120.0))
}

fn axis(transmission: Spring) -> Assembly {
    let tool = Contact { gap_m: 4e-3, ..Contact::kelvin_voigt("tip", "ground", 2e5, 120.0) };
    let sensor = |element: &str, quantity| Sensor::ideal(SignalName::new(element, quantity));
    let machine = Machine::new("axis")
        .with_body("motor", Body::new(7.0))
        .with_body("tip", Body::new(5.0))
        .with_spring("guide", Spring::new("ground", "motor", 0.0, 60.0))
        .with_spring("transmission", transmission)
        .with_contact("tool", tool)
        .with_actuator("drive", Actuator::ideal("motor", "ground"))
        .with_sensor("force", sensor("tool", Quantity::SpringForce))
        .with_sensor("encoder", sensor("motor", Quantity::Position));
    assemble(&machine).unwrap()
}
