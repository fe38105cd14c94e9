//! The machine on which the tests of effects try them: motor (7 kg) and tip (5 kg) on a guide, before a wall.

use super::Host;
use crate::assembly::{Assembly, assemble};
use crate::description::{
    Actuator, ActuatorKind, Axis, Body, Contact, ContactLaw, Engagement, Machine, Quantity, Sensor, SignalName, Spring,
};

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
    let guide = Spring { between: ["ground".into(), "motor".into()], damping_n_s_per_m: 60.0, ..Spring::default() };
    let tool = Contact {
        between: ["tip".into(), "ground".into()],
        engagement: Engagement::Unilateral,
        law: ContactLaw::KelvinVoigt,
        stiffness: 2e5,
        damping_n_s_per_m: 120.0,
        gap_m: 4e-3,
        effects: Vec::new(),
    };
    let drive = Actuator {
        on: "motor".into(),
        reacts_on: "ground".into(),
        kind: ActuatorKind::Force { bandwidth_hz: None },
        limit_n: None,
        rate_limit_per_s: None,
        effects: Vec::new(),
    };
    let sensor = |element: &str, quantity| Sensor {
        reads: SignalName::new(element, quantity),
        relative_to: None,
        gain: 1.0,
        bias: 0.0,
        low_pass: None,
        delay_s: 0.0,
        resolution: None,
        noise: 0.0,
        effects: Vec::new(),
    };
    let machine = Machine {
        name: "axis".into(),
        about: "the smallest machine on which every effect has a place".into(),
        axis: Axis::Translational,
        bodies: [("motor".into(), body(7.0)), ("tip".into(), body(5.0))].into_iter().collect(),
        springs: [("guide".into(), guide), ("transmission".into(), transmission)].into_iter().collect(),
        contacts: [("tool".into(), tool)].into_iter().collect(),
        actuators: [("drive".into(), drive)].into_iter().collect(),
        sensors: [("force".into(), sensor("tool", Quantity::SpringForce)), ("encoder".into(), sensor("motor", Quantity::Position))]
            .into_iter()
            .collect(),
        ..Machine::default()
    };
    assemble(&machine).unwrap()
}
