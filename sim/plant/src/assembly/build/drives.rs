//! Actuators from names to numbers.

use feeler_catalogue::Field;

use super::super::{Assembly, Drive, GROUND_NODE, SensorPart, ServoFeed, Source};
use super::Build;
use crate::description::{Actuator, ActuatorKind, DcMotor, GROUND, MotorInput, PositionServo, Quantity};
use crate::problem::Problem;

impl Build<'_> {
    pub(super) fn drives(&mut self) {
        for (name, actuator) in &self.machine.actuators {
            let on = self.node(&Actuator::ON.of(name), &actuator.on);
            let reacts_on = self.node(&Actuator::REACTS_ON.of(name), &actuator.reacts_on);
            let mut drive = Drive::new(name, actuator, [on, reacts_on]);
            match &actuator.kind {
                ActuatorKind::Imposed => {
                    drive.impose(self.assembly.nodes[on].position_m);
                    self.imposed_problems(name, actuator);
                }
                ActuatorKind::PositionServo(servo) => self.servo_problems(name, servo),
                ActuatorKind::DcMotor(motor) => {
                    self.motor_problems(name, motor);
                    let reflected = motor.rotor_inertia * motor.gear_ratio.powi(2);
                    self.assembly.nodes[on].mass_kg += reflected;
                }
                ActuatorKind::TargetVelocity | ActuatorKind::FeedForward => {
                    drive.feeds = self.feed(name, actuator);
                }
                ActuatorKind::Force { .. } | ActuatorKind::VelocitySource { .. } => {}
            }
            self.assembly.drives.push(drive);
        }
    }

    fn imposed_problems(&mut self, name: &str, actuator: &Actuator) {
        if actuator.reacts_on != GROUND {
            let message =
                format!("an imposed motion is one against ground, not against `{}`", actuator.reacts_on);
            let remedy = format!("leave `{}` out", Actuator::REACTS_ON.key.name);
            self.problems.push(Problem::new(Actuator::REACTS_ON.of(name), message, remedy));
        }
        if actuator.limit_n.is_some() {
            let message = "an imposed motion takes whatever force it needs";
            let remedy = format!("leave `{}` out, or use a `position-servo`", Actuator::LIMIT.key.name);
            self.problems.push(Problem::new(Actuator::LIMIT.of(name), message, remedy));
        }
    }

    /// The servo input that an actuator represents: an input of the only servo between the same bodies.
    fn feed(&mut self, name: &str, actuator: &Actuator) -> Option<ServoFeed> {
        let is_fed = |other: &Actuator| {
            matches!(other.kind, ActuatorKind::PositionServo(_))
                && other.on == actuator.on
                && other.reacts_on == actuator.reacts_on
        };
        let mut servos = self.machine.actuators.values().enumerate().filter(|(_, other)| is_fed(other));
        let (servo, other) = (servos.next().map(|(i, _)| i), servos.next());
        let mut problem = |field: &Field<Actuator>, message: String, remedy: String| {
            self.problems.push(Problem::new(field.of(name), message, remedy));
        };
        let (on, reacts_on) = (&actuator.on, &actuator.reacts_on);
        if servo.is_none() || other.is_some() {
            let many = if servo.is_none() { "no" } else { "more than one" };
            let message = format!("there is {many} position servo on `{on}` that reacts on `{reacts_on}`");
            problem(&Actuator::ON, message, "name the two bodies of one `position-servo`".to_owned());
        }
        if actuator.limit_n.is_some() {
            let message = "an input of a servo has no effort of its own".to_owned();
            problem(&Actuator::LIMIT, message, format!("give the servo the `{}`", Actuator::LIMIT.key.name));
        }
        Some(ServoFeed { servo: servo?, is_velocity: actuator.kind == ActuatorKind::TargetVelocity })
    }

    fn servo_problems(&mut self, name: &str, servo: &PositionServo) {
        if servo.period_s.is_some() {
            return;
        }
        let given = [
            (Actuator::SERVO_COMPUTE_DELAY, servo.compute_delay_s > 0.0),
            (Actuator::SERVO_RESOLUTION, servo.resolution_m.is_some()),
            (Actuator::SERVO_OUTPUT_RESOLUTION, servo.output_resolution_n.is_some()),
        ];
        for (field, _) in given.into_iter().filter(|(_, is_given)| *is_given) {
            let key = field.key.name;
            let message = format!("`{key}` belongs to a sampled loop, and this loop is continuous");
            let remedy = format!("add a `{}`, or leave `{key}` out", Actuator::SERVO_PERIOD.key.name);
            self.problems.push(Problem::new(field.of(name), message, remedy));
        }
    }

    fn motor_problems(&mut self, name: &str, motor: &DcMotor) {
        if motor.input == MotorInput::Duty && motor.supply_voltage_v.is_none() {
            let message = "a duty cycle is a share of a supply voltage, and there is none";
            let field = Actuator::SUPPLY_VOLTAGE;
            let remedy = format!("add `{}`, in V", field.key.name);
            self.problems.push(Problem::new(field.of(name), message, remedy));
        }
        if motor.input == MotorInput::Current && motor.inductance_h > 0.0 {
            let message = "an amplifier that controls the current already compensates the inductance";
            let field = Actuator::INDUCTANCE;
            let (input, voltage) = (Actuator::MOTOR_INPUT.key.name, MotorInput::Voltage.name());
            let remedy = format!("leave `{}` out, or use `{input} = \"{voltage}\"`", field.key.name);
            self.problems.push(Problem::new(field.of(name), message, remedy));
        }
    }

    /// The encoders of sampled servos, which read the stroke of their drive after its effects.
    pub(super) fn encoders(&mut self) {
        let Assembly { drives, sensors, .. } = &mut self.assembly;
        for drive in drives {
            let Some(sampling) = drive.sampling().copied() else { continue };
            sensors.push(SensorPart {
                name: drive.name.clone(),
                source: Source::Node(drive.on, Quantity::Position),
                relative_to: drive.reacts_on,
                tool_inertia: (0.0, GROUND_NODE),
                gain: 1.0,
                bias: 0.0,
                filters: Vec::new(),
                delay: 0.0,
                resolutions: sampling.resolution.into_iter().collect(),
                noise: 0.0,
            });
            drive.sample_by(sensors.len() - 1);
        }
    }
}
