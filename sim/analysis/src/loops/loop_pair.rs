//! The actuator and the sensor between which a controller closes its loop, independent of the analysed
//! signals.

use feeler_plant::description::{Machine, Quantity, SignalName};
use serde::Serialize;

use crate::error::AnalysisError;
use crate::loops::control_loop::ControlLoop;
use crate::machine::modes::{ModeInPair, VibrationMode, classify};

/// The loop of one controller, to which gains, margins and limits refer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LoopPair {
    /// Name of the controller that closes it.
    pub controller: String,
    /// The command that it gives.
    pub input: String,
    /// The signal that its sensor reads. For a law without force feedback it is the motion, unless its force
    /// gain is analysed.
    pub output: String,
    /// The signal whose bandwidth is reported: the one that the reference prescribes.
    pub controlled: String,
}

/// The loop of a controller as one of its gains closes it, and the class of each mode in it. `None` if the
/// controller reads nothing.
pub(crate) fn loop_pair(
    machine: &Machine,
    whole: &ControlLoop,
    controller: usize,
    gain: &str,
    modes: &[VibrationMode],
) -> Result<Option<(LoopPair, Vec<ModeInPair>)>, AnalysisError> {
    let own = &whole.controllers()[controller];
    let signal = |sensor: Option<usize>| {
        sensor.and_then(|i| machine.sensors.get_index(i)).map(|(_, sensor)| sensor.reads.clone())
    };
    let sensor = signal(own.sensor_of_gain(gain));
    let drive =
        machine.actuators.get_index(own.drive).map(|(name, _)| SignalName::new(name, Quantity::Command));
    let Some((input, output)) = drive.zip(sensor) else { return Ok(None) };
    let plant = whole.plant();
    let pairs = classify(plant, modes, own.drive, plant.source(&output)?, &plant.channel(&input, &output)?)?;
    let controlled = signal(own.controlled()).map_or_else(|| output.to_string(), |signal| signal.to_string());
    Ok(Some((
        LoopPair {
            controller: own.name.clone(),
            input: input.to_string(),
            output: output.to_string(),
            controlled,
        },
        pairs,
    )))
}
