//! A drive with a controller from the machine's file. The record holds the controller's reference, and
//! predictions simulate the controller.

use feeler_control::ControllerSpec;
use feeler_engine::Scenario;
use feeler_plant::description::{Machine, Quantity};

/// A controller at a drive, with its names resolved to indices.
#[derive(Clone, Debug, PartialEq)]
pub struct Looped {
    pub name: String,
    pub drive: usize,
    /// Law, gains and timing.
    pub spec: ControllerSpec,
    /// Sensor of the controlled quantity.
    pub reading: Option<usize>,
    /// Sensor of the position or velocity that the controller uses.
    pub motion: Option<usize>,
    /// Whether that sensor measures velocity.
    pub motion_is_velocity: bool,
}

impl Looped {
    /// The controller `name` of a scenario, at the elements of a machine; `None` if the machine lacks one.
    pub(super) fn of(scenario: &Scenario, machine: &Machine, name: &str) -> Option<Self> {
        let used = scenario.controllers.get(name)?;
        let sensor = |name: Option<&str>| name.map(|name| machine.sensors.get_index_of(name));
        // A named sensor that the machine lacks makes the controller unusable.
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
