//! The motion that a position law, an impedance or a position servo controls without contact.

use feeler_control::Law;
use feeler_engine::Scenario;
use feeler_plant::description::{ActuatorKind, GROUND, Quantity, Sensor, SignalName};

/// A controller whose reference is a motion.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::run) struct Controlled {
    pub(in crate::run) controller: String,
    /// The signal that it controls.
    pub(in crate::run) signal: SignalName,
    /// Gain from that motion to the sensor's reading.
    gain: f64,
    /// Standard deviation of the sensor's noise, in units of the signal.
    pub(in crate::run) noise: f64,
}

impl Controlled {
    /// The first controller of a motion: by its own law, or by targets of a servo.
    pub(in crate::run) fn find(scenario: &Scenario) -> Option<Self> {
        scenario.controllers.iter().find_map(|(name, used)| {
            let sensor = match used.spec.law {
                Law::Position(_) => used.reads.as_ref().or(used.motion.as_ref()),
                Law::Impedance(_) => used.motion.as_ref().or(used.reads.as_ref()),
                Law::ExplicitForce(_) | Law::Admittance(_) => None,
                Law::OpenLoop => {
                    let drive = scenario.machine.actuators.get(&used.drives)?;
                    let aims =
                        matches!(drive.kind, ActuatorKind::PositionServo(_)) && drive.reacts_on == GROUND;
                    let signal = SignalName::new(&drive.on, Quantity::Position);
                    return aims.then(|| Self { controller: name.clone(), signal, gain: 1.0, noise: 0.0 });
                }
            }?;
            let Sensor { reads, gain, noise, .. } = scenario.machine.sensors.get(sensor)?;
            let gain = if *gain == 0.0 { 1.0 } else { *gain };
            Some(Self { controller: name.clone(), signal: reads.clone(), gain, noise: noise / gain.abs() })
        })
    }

    /// The reference over the rows, in units of the signal.
    pub(in crate::run) fn wanted(&self, reference: &[f64]) -> Vec<f64> {
        reference.iter().map(|value| value / self.gain).collect()
    }
}
