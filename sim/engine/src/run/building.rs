//! Builders for scenarios in programs.

use feeler_control::ControllerSpec;
use feeler_plant::description::{Elements, Machine, SignalName};

use super::scenario::{ControllerUse, Scenario};
use super::settings::RunSettings;

impl Scenario {
    /// A machine without controllers that runs for one second and records nothing.
    pub fn new(machine: Machine) -> Self {
        Self { machine, controllers: Elements::default(), run: RunSettings::default() }
    }

    /// Adds a controller; replaces one of the same name.
    #[must_use]
    pub fn with_controller(mut self, name: impl Into<String>, controller: ControllerUse) -> Self {
        self.controllers.insert(name.into(), controller);
        self
    }

    /// Sets the duration, s.
    #[must_use]
    pub fn lasting(mut self, duration_s: f64) -> Self {
        self.run.duration_s = duration_s;
        self
    }

    /// Records these signals at this rate, Hz.
    #[must_use]
    pub fn recording(mut self, signals: impl IntoIterator<Item = SignalName>, rate_hz: f64) -> Self {
        self.run.record = signals.into_iter().collect();
        self.run.record_rate_hz = Some(rate_hz);
        self
    }
}

impl ControllerUse {
    /// A controller that drives an actuator and reads nothing.
    pub fn new(spec: ControllerSpec, drives: impl Into<String>) -> Self {
        Self { spec, reads: None, motion: None, drives: drives.into(), effects: Vec::new() }
    }

    /// Closes the loop over a sensor.
    #[must_use]
    pub fn reading(mut self, sensor: impl Into<String>) -> Self {
        self.reads = Some(sensor.into());
        self
    }
}
