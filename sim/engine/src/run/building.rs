//! Scenarios put together in a program.

use feeler_control::ControllerSpec;
use feeler_plant::description::{Elements, Machine, SignalName};

use super::scenario::{ControllerUse, Scenario};
use super::settings::RunSettings;

impl Scenario {
    /// A machine without controllers, run for a second with nothing recorded.
    pub fn new(machine: Machine) -> Self {
        Self { machine, controllers: Elements::default(), run: RunSettings::default() }
    }

    /// With a controller; another of this name is replaced.
    #[must_use]
    pub fn with_controller(mut self, name: impl Into<String>, controller: ControllerUse) -> Self {
        self.controllers.insert(name.into(), controller);
        self
    }

    /// The same, run for this many seconds.
    #[must_use]
    pub fn lasting(mut self, duration_s: f64) -> Self {
        self.run.duration_s = duration_s;
        self
    }

    /// The same with these signals recorded at this rate, Hz.
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

    /// The same, closed over a sensor.
    #[must_use]
    pub fn reading(mut self, sensor: impl Into<String>) -> Self {
        self.reads = Some(sensor.into());
        self
    }
}
