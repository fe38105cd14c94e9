//! A drive that a controller of the machine's file commands while a record is predicted: the record holds
//! the reference of the controller.

use feeler_control::ControllerSpec;
use feeler_engine::Scenario;
use feeler_plant::description::{Machine, Quantity};

/// A controller at a drive, its names resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct Looped {
    pub name: String,
    pub drive: usize,
    /// Law, gains and timing.
    pub spec: ControllerSpec,
    /// Sensor that it controls.
    pub reading: Option<usize>,
    /// Sensor of position or velocity that it works with.
    pub motion: Option<usize>,
    /// Which of the two that is.
    pub motion_is_velocity: bool,
}

impl Looped {
    /// The controller `name` of a scenario, at the elements of a machine; `None` if the machine lacks one.
    pub(super) fn of(scenario: &Scenario, machine: &Machine, name: &str) -> Option<Self> {
        let used = scenario.controllers.get(name)?;
        let sensor = |name: Option<&str>| name.map(|name| machine.sensors.get_index_of(name));
        // A sensor that is named and absent makes the whole absent.
        let reading = sensor(used.reads.as_deref());
        let motion = sensor(used.motion_sensor(machine));
        if [reading, motion].contains(&Some(None)) {
            return None;
        }
        let motion = motion.flatten();
        Some(Self {
            name: name.into(),
            drive: machine.actuators.get_index_of(&used.drives)?,
            spec: used.spec.clone(),
            reading: reading.flatten(),
            motion,
            motion_is_velocity: motion
                .is_some_and(|sensor| machine.sensors[sensor].reads.quantity == Quantity::Velocity),
        })
    }
}
