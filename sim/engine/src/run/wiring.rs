//! Checks the sensors and drives of a controller against the machine: one rule for files and for programs.

use feeler_catalogue::GainPart;
use feeler_control::{ControllerSpec, Law, READS};
use feeler_plant::description::{Actuator, ActuatorKind, Machine, Quantity};
use feeler_plant::names::did_you_mean;
use feeler_plant::problem::Problem;

use crate::run::scenario::ControllerUse;

const FORCE: [Quantity; 2] = [Quantity::Force, Quantity::SpringForce];
const MOTION: [Quantity; 2] = [Quantity::Position, Quantity::Velocity];

impl ControllerUse {
    /// The sensor of position or velocity that the controller uses. It is the one that the controller names,
    /// else the first that reads the motion of the driven body. `None` if it needs no such sensor.
    pub fn motion_sensor<'a>(&'a self, machine: &'a Machine) -> Option<&'a str> {
        if let Some(named) = &self.motion {
            return Some(named);
        }
        let body = &machine.actuators.get(&self.drives).filter(|_| self.needs_motion())?.on;
        let reads_it = |element: &str, quantity| element == body && MOTION.contains(&quantity);
        machine
            .sensors
            .iter()
            .find(|(_, sensor)| reads_it(&sensor.reads.element, sensor.reads.quantity))
            .map(|(name, _)| name.as_str())
    }

    /// Whether it needs a motion sensor. The approach of a velocity source needs none: the drive holds the
    /// speed itself.
    fn needs_motion(&self) -> bool {
        self.spec.law.needs_motion() || self.approaches_by_force()
    }

    fn approaches_by_force(&self) -> bool {
        self.spec.approach.is_some_and(|approach| !approach.velocity_drive)
    }

    /// The part that needs the controlled sensor; `None` if there is no such part.
    fn needs_reading(&self) -> Option<&'static str> {
        let law = &self.spec.law;
        match law {
            Law::Impedance(_) | Law::OpenLoop => {
                let inner = law.gain(GainPart::Reading).filter(|gain| gain.number(law) != Some(0.0));
                inner.map(|gain| gain.key.name).or(self.spec.approach.map(|_| "the approach"))
            }
            Law::ExplicitForce(_) | Law::Position(_) | Law::Admittance(_) => Some("this law"),
        }
    }

    /// Every mistake of the wiring. Keys are the controller's own: `drives`, `reads`, `motion`.
    pub fn wiring_problems(&self, machine: &Machine) -> Vec<Problem> {
        let mut problems = Vec::new();
        if !machine.actuators.contains_key(&self.drives) {
            let remedy = did_you_mean(&self.drives, machine.actuators.keys().map(String::as_str));
            problems.push(Problem::new(
                Self::DRIVES.key.name,
                format!("there is no actuator `{}`", self.drives),
                remedy,
            ));
        }
        let (read, what): (&[_], _) = match self.spec.law {
            Law::Position(_) => (&[Quantity::Position], "a position"),
            Law::OpenLoop | Law::ExplicitForce(_) | Law::Impedance(_) | Law::Admittance(_) => {
                (&FORCE, "a force")
            }
        };
        let named = |name: &Option<String>, key, wanted: &[Quantity], what: &str| {
            name.as_ref().and_then(|name| sensor_problem(machine, name, key, wanted, what))
        };
        problems.extend(named(&self.reads, READS.name, read, what));
        problems.extend(named(&self.motion, Self::MOTION.key.name, &MOTION, "a position or velocity"));
        if self.needs_motion()
            && machine.actuators.contains_key(&self.drives)
            && self.motion_sensor(machine).is_none()
        {
            let message = if self.approaches_by_force() {
                "the approach of a force drive needs a motion sensor"
            } else {
                "this law needs a motion sensor"
            };
            let remedy = format!(
                "add `{} = \"...\"`, or a sensor that reads position or velocity of the driven body",
                Self::MOTION.key.name
            );
            problems.push(Problem::new(Self::MOTION.key.name, message, remedy));
        }
        let approached = machine.actuators.get(&self.drives).filter(|_| self.spec.approach.is_some());
        if approached.is_some_and(|actuator| !can_approach(actuator)) {
            let message = format!(
                "an approach moves a drive by a force or a speed, and `{}` takes neither",
                self.drives
            );
            problems.push(Problem::new(
                ControllerSpec::APPROACH.key.name,
                message,
                "leave it out, and let the reference approach",
            ));
        }
        if let (Some(needs), None) = (self.needs_reading(), &self.reads) {
            let message = format!("{needs} needs {what} sensor");
            problems.push(Problem::new(READS.name, message, format!("add `{} = \"...\"`", READS.name)));
        }
        problems
    }
}

/// Whether the command of an actuator is a force or a speed, as an approach requires.
fn can_approach(actuator: &Actuator) -> bool {
    matches!(actuator.kind, ActuatorKind::Force { .. } | ActuatorKind::VelocitySource { .. })
}

/// The mistake of a sensor that is named under a key and must read one of some quantities.
fn sensor_problem(
    machine: &Machine,
    name: &str,
    key: &str,
    wanted: &[Quantity],
    what: &str,
) -> Option<Problem> {
    let Some(sensor) = machine.sensors.get(name) else {
        let remedy = did_you_mean(name, machine.sensors.keys().map(String::as_str));
        return Some(Problem::new(key, format!("there is no sensor `{name}`"), remedy));
    };
    if wanted.contains(&sensor.reads.quantity) {
        return None;
    }
    let fitting = machine.sensors.iter().filter(|(_, sensor)| wanted.contains(&sensor.reads.quantity));
    let remedy = did_you_mean(name, fitting.map(|(name, _)| name.as_str()));
    let message = format!("the sensor `{name}` reads `{}`, and this needs {what}", sensor.reads);
    Some(Problem::new(key, message, remedy))
}

#[cfg(test)]
mod tests {
    use feeler_control::{Approach, ForceGains};
    use feeler_plant::description::{Actuator, Body, GROUND, Sensor, SignalName};

    use super::*;

    /// The mistakes of a force controller with an approach, on a body without a motion sensor.
    fn mistakes(velocity_drive: bool) -> Vec<String> {
        let mut machine = Machine::default();
        machine.bodies.insert("tool".into(), Body { mass_kg: 1.0, ..Body::default() });
        machine.actuators.insert("drive".into(), Actuator::ideal("tool", GROUND));
        let force = Sensor::ideal(SignalName::new("wall", Quantity::Force));
        machine.sensors.insert("force".into(), force);
        let mut spec = ControllerSpec::new(Law::ExplicitForce(ForceGains::default()), 1e-3);
        spec.approach = Some(Approach { velocity_drive, ..Approach::new(0.01, 2.0, 1.0) });
        let used = ControllerUse {
            spec,
            reads: Some("force".into()),
            motion: None,
            drives: "drive".into(),
            effects: Vec::new(),
        };
        used.wiring_problems(&machine).into_iter().map(|problem| problem.key).collect()
    }

    /// Programs required a motion sensor for every approach, files only for that of a force drive. A velocity
    /// source holds the speed by itself.
    #[test]
    fn regress_the_approach_of_a_velocity_source_needs_no_sensor_of_motion() {
        assert_eq!(mistakes(true), Vec::<String>::new());
        assert_eq!(mistakes(false), ["motion"]);
    }
}
