//! The controller that controls the force of a contact.

use feeler_control::Law;
use feeler_engine::Scenario;
use feeler_plant::description::{Quantity, Sensor, SignalName};

/// A controller whose reference is the force of a contact.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ForceLoop {
    pub controller: usize,
    pub name: String,
    pub sensor: usize,
    pub contact: usize,
}

impl ForceLoop {
    /// The first controller with a force reference whose sensor reads a contact, or another force if there is
    /// only one contact.
    pub fn find(scenario: &Scenario) -> Option<Self> {
        let machine = &scenario.machine;
        scenario.controllers.iter().enumerate().find_map(|(controller, (name, used))| {
            if !matches!(used.spec.law, Law::ExplicitForce(_) | Law::Admittance(_)) {
                return None;
            }
            let sensor = machine.sensors.get_index_of(used.reads.as_ref()?)?;
            let element = &machine.sensors[sensor].reads.element;
            let only = (machine.contacts.len() == 1).then_some(0);
            let contact = machine.contacts.get_index_of(element).or(only)?;
            Some(Self { controller, name: name.clone(), sensor, contact })
        })
    }

    /// The signal of its reference.
    pub fn reference_signal(&self) -> String {
        SignalName::new(&self.name, Quantity::Reference).to_string()
    }

    /// The sensor's uncertainty: its noise and half its resolution, N.
    pub(in crate::run) fn unresolved_n(&self, scenario: &Scenario) -> f64 {
        let sensor = &scenario.machine.sensors[self.sensor];
        self.hidden_by_noise_n(scenario) + 0.5 * sensor.resolution.unwrap_or(0.0) / scale(sensor)
    }

    /// The amplitude hidden by the sensor's noise: four standard deviations, N.
    pub(in crate::run) fn hidden_by_noise_n(&self, scenario: &Scenario) -> f64 {
        let sensor = &scenario.machine.sensors[self.sensor];
        4.0 * sensor.noise / scale(sensor)
    }
}

/// Standard deviation of the noisiest sensor as a force, N. A position is scaled by the stiffest contact.
/// Velocity and acceleration are first integrated over the shortest controller period.
pub(in crate::run) fn sensor_noise_n(scenario: &Scenario) -> f64 {
    let stiffness = scenario.machine.contacts.values().map(|contact| contact.stiffness).fold(0.0, f64::max);
    let period_s = scenario.controllers.values().map(|used| used.spec.period_s).fold(f64::INFINITY, f64::min);
    let force_n = |sensor: &Sensor| {
        let factor = match sensor.reads.quantity {
            Quantity::Position | Quantity::Compression => stiffness,
            Quantity::Velocity => stiffness * period_s,
            Quantity::Acceleration => stiffness * period_s * period_s,
            _ => 1.0,
        };
        factor * sensor.noise / scale(sensor)
    };
    scenario.machine.sensors.values().filter(|sensor| sensor.noise > 0.0).map(force_n).fold(0.0, f64::max)
}

/// Gain from the measured quantity to the reading.
fn scale(sensor: &Sensor) -> f64 {
    if sensor.gain == 0.0 { 1.0 } else { sensor.gain.abs() }
}
