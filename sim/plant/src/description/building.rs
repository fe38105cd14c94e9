//! Builders for machines in programs.

use super::{Actuator, Body, Contact, Machine, Sensor, Spring};

impl Machine {
    /// A machine without elements.
    pub fn new(name: impl Into<String>) -> Self {
        Self { name: name.into(), ..Self::default() }
    }

    /// Adds a body; replaces one of the same name, as the following methods do.
    #[must_use]
    pub fn with_body(mut self, name: impl Into<String>, body: Body) -> Self {
        self.bodies.insert(name.into(), body);
        self
    }

    /// Adds a spring, a guide or a rigid joint.
    #[must_use]
    pub fn with_spring(mut self, name: impl Into<String>, spring: Spring) -> Self {
        self.springs.insert(name.into(), spring);
        self
    }

    /// With a contact.
    #[must_use]
    pub fn with_contact(mut self, name: impl Into<String>, contact: Contact) -> Self {
        self.contacts.insert(name.into(), contact);
        self
    }

    /// With a drive.
    #[must_use]
    pub fn with_actuator(mut self, name: impl Into<String>, actuator: Actuator) -> Self {
        self.actuators.insert(name.into(), actuator);
        self
    }

    /// With a sensor.
    #[must_use]
    pub fn with_sensor(mut self, name: impl Into<String>, sensor: Sensor) -> Self {
        self.sensors.insert(name.into(), sensor);
        self
    }
}

impl Body {
    /// A body at rest at zero; the mass is in kg.
    pub fn new(mass_kg: f64) -> Self {
        Self { mass_kg, ..Self::default() }
    }

    /// Sets the initial position, m.
    #[must_use]
    pub fn at(self, position_m: f64) -> Self {
        Self { position_m, ..self }
    }
}

impl Spring {
    /// A linear spring and damper; elongation is the position of `to` minus that of `from`.
    pub fn new(
        from: impl Into<String>,
        to: impl Into<String>,
        stiffness_n_per_m: f64,
        damping_n_s_per_m: f64,
    ) -> Self {
        Self { between: [from.into(), to.into()], stiffness_n_per_m, damping_n_s_per_m, ..Self::default() }
    }
}
