//! The input and the output of a report.

use feeler_engine::Scenario;
use feeler_plant::assembly::Source;
use feeler_plant::description::{Contact, Engagement, GROUND, Quantity, SignalName};

use crate::error::AnalysisError;
use crate::loops::control_loop::ControlLoop;
use crate::report::Request;

impl Request {
    /// Input, by default that of the loop, and output.
    pub(super) fn signals(
        &self,
        asked_input: Option<SignalName>,
        scenario: &Scenario,
        whole: &ControlLoop,
    ) -> Result<(SignalName, SignalName), AnalysisError> {
        let machine = &scenario.machine;
        // The controller with the requested gain, if it reads something.
        let key = self.gain.clone().or_else(|| whole.default_gain_key());
        let asked =
            key.and_then(|key| whole.gain_of_key(&key).ok()).map(|(i, gain)| (&whole.controllers()[i], gain));
        let asked =
            asked.and_then(|(controller, gain)| Some((controller, controller.sensor_of_gain(&gain)?)));
        let reads_something = || whole.controllers().iter().find_map(|c| Some((c, c.fed_back()?)));
        let (first, sensor) = asked
            .or_else(reads_something)
            .map_or((whole.controllers().first(), None), |(c, i)| (Some(c), Some(i)));
        let drive = first.map_or(0, |c| c.drive);
        let input = asked_input.or_else(|| {
            machine.actuators.get_index(drive).map(|(name, _)| SignalName::new(name, Quantity::Command))
        });
        let input = input.ok_or_else(|| AnalysisError::NotAnInput { name: "(no actuator)".into() })?;
        let read = sensor.and_then(|i| machine.sensors.get_index(i)).map(|(_, sensor)| sensor.reads.clone());
        // An absent contact has no force, so the output is the motion of the body that would touch.
        let felt = |(i, (name, contact)): (usize, (&String, &Contact))| {
            let part = whole.plant().motion().assembly().contacts.get(i)?;
            Some(match part.engagement {
                Engagement::Free => SignalName::new(&contact.between[0], Quantity::Acceleration),
                _ => SignalName::new(name, Quantity::SpringForce),
            })
        };
        let pressed = || machine.contacts.iter().enumerate().find_map(felt);
        let any_sensor = || machine.sensors.values().next().map(|sensor| sensor.reads.clone());
        // Without a sensor, the motion of the driven body shows the effect of the drive.
        let driven = || {
            let (_, actuator) = machine.actuators.get_index(drive)?;
            let body = [&actuator.on, &actuator.reacts_on].into_iter().find(|end| *end != GROUND)?;
            Some(SignalName::new(body, Quantity::Position))
        };
        let output = self.output.clone().or(read).or_else(pressed).or_else(any_sensor).or_else(driven);
        let output = output.ok_or_else(|| AnalysisError::NotAnInput { name: "(no actuator)".into() })?;
        if let Source::Drive(_, Quantity::Command) = whole.plant().source(&output)? {
            return Err(AnalysisError::NotLinear { name: output.to_string() });
        }
        Ok((input, output))
    }
}
