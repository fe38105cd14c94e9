//! A two-mass axis against a force sensor.

use feeler_control::{ControllerSpec, ForceGains, Law};
use feeler_engine::{ControllerUse, Scenario};
use feeler_plant::description::{
    Actuator, Body, Contact, Engagement, GROUND, Machine, Quantity, Sensor, SignalName, Spring,
};

pub(crate) fn spring(a: &str, b: &str, k: f64, c: f64) -> Spring {
    Spring::new(a, b, k, c)
}

pub(crate) fn sensor(element: &str, quantity: Quantity) -> Sensor {
    Sensor::ideal(SignalName::new(element, quantity))
}

/// Motor of 7 kg, transmission, tip of 5 kg, clamped sensor; sensors `force` and `encoder`.
pub(crate) fn machine() -> Machine {
    let mut machine = Machine::default();
    machine.bodies.insert("motor".into(), Body::new(7.0));
    machine.bodies.insert("tip".into(), Body::new(5.0));
    machine.springs.insert("guide".into(), spring(GROUND, "motor", 0.0, 60.0));
    machine.springs.insert("transmission".into(), spring("motor", "tip", 1.2e6, 120.0));
    let contact =
        Contact { engagement: Engagement::Clamped, ..Contact::kelvin_voigt("tip", GROUND, 2e5, 120.0) };
    machine.contacts.insert("tool".into(), contact);
    let drive = Actuator::ideal("motor", GROUND);
    machine.actuators.insert("drive".into(), drive);
    machine.sensors.insert("force".into(), sensor("tool", Quantity::SpringForce));
    machine.sensors.insert("encoder".into(), sensor("motor", Quantity::Position));
    machine
}

/// A controller on the drive.
pub(crate) fn control(law: Law, reads: &str, period_s: f64, delay_s: f64) -> ControllerUse {
    let spec = ControllerSpec { delay_s, ..ControllerSpec::new(law, period_s) };
    ControllerUse::new(spec, "drive").reading(reads)
}

/// The axis under proportional force control at 1 kHz.
pub(crate) fn force_loop(kp: f64, delay_s: f64) -> Scenario {
    let law = Law::ExplicitForce(ForceGains { kp, ..ForceGains::default() });
    Scenario::new(machine()).with_controller("force", control(law, "force", 1e-3, delay_s))
}
