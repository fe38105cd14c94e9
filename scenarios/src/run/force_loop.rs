//! Which controller wants which force of which contact.

use feeler_control::Law;
use feeler_engine::Scenario;
use feeler_plant::description::{Quantity, SignalName};

/// A controller whose reference is the force of a contact.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ForceLoop {
    /// Index of the controller.
    pub controller: usize,
    /// Its name.
    pub name: String,
    /// Index of its sensor.
    pub sensor: usize,
    /// Index of the contact.
    pub contact: usize,
}

impl ForceLoop {
    /// The first controller whose reference is a force and whose sensor reads a contact, or another force where there is only one contact.
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

    /// What the sensor cannot tell apart: four sigma of its noise and half its resolution, N.
    pub(super) fn unresolved_n(&self, scenario: &Scenario) -> f64 {
        let sensor = &scenario.machine.sensors[self.sensor];
        let gain = if sensor.gain == 0.0 { 1.0 } else { sensor.gain.abs() };
        (4.0 * sensor.noise + 0.5 * sensor.resolution.unwrap_or(0.0)) / gain
    }
}
