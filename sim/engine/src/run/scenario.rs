//! A scenario: a machine, its controllers, and the settings of the run.

use feeler_catalogue::{Field, KeyKind, Keyed, Tabled, field, optional, required};
use feeler_control::ControllerSpec;
use feeler_plant::description::{Elements, Machine, Sensor};
use feeler_plant::effects::EffectUse;

use super::settings::RunSettings;

/// A machine with its controllers and the settings of its run.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// The machine that the controllers drive.
    pub machine: Machine,
    /// Its controllers, in the order of the file.
    pub controllers: Elements<ControllerUse>,
    /// Duration, step, integrator and what to record.
    pub run: RunSettings,
}

impl Scenario {
    /// The period of each controller with its key, s.
    pub fn periods(&self) -> impl Iterator<Item = (String, f64)> {
        self.controllers.iter().map(|(name, used)| (ControllerSpec::PERIOD.of(name), used.spec.period_s))
    }

    /// The delay of each controller and of each sensor with its key, s.
    pub fn delays(&self) -> impl Iterator<Item = (String, f64)> {
        let controllers =
            self.controllers.iter().map(|(name, used)| (ControllerSpec::DELAY.of(name), used.spec.delay_s));
        let sensors =
            self.machine.sensors.iter().map(|(name, sensor)| (Sensor::DELAY.of(name), sensor.delay_s));
        controllers.chain(sensors)
    }
}

/// A controller and its wiring.
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerUse {
    /// Law, gains, timing and reference.
    pub spec: ControllerSpec,
    /// Sensor that it controls; `None` for an open-loop excitation.
    pub reads: Option<String>,
    /// Sensor of position or velocity for joint damping, impedance and the approach. By default the first
    /// sensor that reads position or velocity of the driven body, if there is one.
    pub motion: Option<String>,
    /// Actuator that it drives; the commands of several controllers on one actuator add.
    pub drives: String,
    /// Departures from the ideal controller.
    pub effects: Vec<EffectUse>,
}

/// The wiring; the signal that it reads is a key of its law.
impl ControllerUse {
    /// The driven actuator.
    pub const DRIVES: Field<Self> = field!(ControllerUse: drives,
        required("drives", KeyKind::Name("an actuator"), "the actuator whose command it gives"));
    /// The sensor of the driven body's motion.
    pub const MOTION: Field<Self> = field!(ControllerUse: motion,
        optional("motion", KeyKind::Name("a sensor of position or velocity"),
            "sensor for damping, impedance and the approach; if absent, the first that reads position or \
             velocity of the driven body"));
}

impl Tabled for ControllerUse {
    const TABLE: &'static str = ControllerSpec::TABLE;
}

impl Keyed for ControllerUse {
    const FIELDS: &'static [Field<Self>] = &[ControllerUse::DRIVES, ControllerUse::MOTION];
}
