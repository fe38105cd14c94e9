//! A two-mass axis against a force sensor.

use feeler_control::{ControllerSpec, ForceGains, Law};
use feeler_engine::{ControllerUse, RunSettings, Scenario};
use feeler_plant::description::{
    Actuator, ActuatorKind, Body, Contact, ContactLaw, Engagement, GROUND, Machine, Quantity, Sensor, SignalName, Spring,
};

pub(crate) fn spring(a: &str, b: &str, k: f64, c: f64) -> Spring {
    Spring { between: [a.into(), b.into()], stiffness_n_per_m: k, damping_n_s_per_m: c, ..Spring::default() }
}

pub(crate) fn sensor(element: &str, quantity: Quantity) -> Sensor {
    Sensor {
        reads: SignalName::new(element, quantity),
        relative_to: None,
        gain: 1.0,
        bias: 0.0,
        low_pass: None,
        delay_s: 0.0,
        resolution: None,
        noise: 0.0,
        effects: Vec::new(),
    }
}

/// Motor of 7 kg, transmission, tip of 5 kg, clamped sensor; sensors `force` and `encoder`.
pub(crate) fn machine() -> Machine {
    let mut machine = Machine::default();
    machine.bodies.insert("motor".into(), Body { mass_kg: 7.0, ..Body::default() });
    machine.bodies.insert("tip".into(), Body { mass_kg: 5.0, ..Body::default() });
    machine.springs.insert("guide".into(), spring(GROUND, "motor", 0.0, 60.0));
    machine.springs.insert("transmission".into(), spring("motor", "tip", 1.2e6, 120.0));
    let contact = Contact {
        between: ["tip".into(), GROUND.into()],
        engagement: Engagement::Clamped,
        law: ContactLaw::KelvinVoigt,
        stiffness: 2e5,
        damping_n_s_per_m: 120.0,
        gap_m: 0.0,
        effects: Vec::new(),
    };
    machine.contacts.insert("tool".into(), contact);
    let drive = Actuator {
        on: "motor".into(),
        reacts_on: GROUND.into(),
        kind: ActuatorKind::Force { bandwidth_hz: None },
        limit_n: None,
        rate_limit_per_s: None,
        effects: Vec::new(),
    };
    machine.actuators.insert("drive".into(), drive);
    machine.sensors.insert("force".into(), sensor("tool", Quantity::SpringForce));
    machine.sensors.insert("encoder".into(), sensor("motor", Quantity::Position));
    machine
}

/// A controller on the drive.
pub(crate) fn control(law: Law, reads: &str, period_s: f64, delay_s: f64) -> ControllerUse {
    let spec = ControllerSpec { delay_s, ..ControllerSpec::new(law, period_s) };
    ControllerUse { spec, reads: Some(reads.into()), motion: None, drives: "drive".into(), effects: Vec::new() }
}

/// The axis under proportional force control at 1 kHz.
pub(crate) fn force_loop(kp: f64, delay_s: f64) -> Scenario {
    let law = Law::ExplicitForce(ForceGains { kp, ..ForceGains::default() });
    let controllers = [("force".to_string(), control(law, "force", 1e-3, delay_s))].into_iter().collect();
    Scenario { machine: machine(), controllers, run: RunSettings::default() }
}
