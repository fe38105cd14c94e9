//! The force that a file asks for, and what is too weak, too late or too coarse for it.

use feeler_catalogue::Tabled;
use feeler_control::reference::FOLLOWED;
use feeler_control::{Approach, ControllerSpec, Reference};
use feeler_engine::{ControllerUse, Scenario};
use feeler_plant::description::{Actuator, ActuatorKind, Axis, Contact, Quantity, Sensor};
use feeler_problem::Problem;

use super::distance::apart_m;
use crate::numbers::{two_digits, with_unit};
use crate::run::ForceLoop;

/// Instants of a run at which a reference is evaluated.
const INSTANTS: u32 = 200;
/// Noise above this share of the force asked for, as a standard deviation, hides it.
const HIDES: f64 = 0.5;
/// Share of the reference at which an approach usually ends.
const TOUCH: f64 = 0.2;

/// The reference of a force loop whose sensor reads its contact.
pub(super) struct Asked<'a> {
    pub(super) scenario: &'a Scenario,
    pub(super) found: ForceLoop,
    sensor: &'a Sensor,
    sensor_name: &'a str,
    /// The contact and its name.
    pub(super) contact: &'a Contact,
    pub(super) touched: &'a str,
    /// Smallest and largest force asked for over the run, zero included, N.
    pub(super) range_n: [f64; 2],
    pub(super) unit: &'static str,
}

impl<'a> Asked<'a> {
    pub(super) fn find(scenario: &'a Scenario) -> Option<Self> {
        let found = ForceLoop::find(scenario)?;
        let spec = &scenario.controllers[found.controller].spec;
        let (touched, contact) = scenario.machine.contacts.get_index(found.contact)?;
        let (sensor_name, sensor) = scenario.machine.sensors.get_index(found.sensor)?;
        if sensor.reads.element != *touched || sensor.gain == 0.0 {
            return None;
        }
        let reference = Reference::new(&spec.reference, scenario.run.seed, &found.name).ok()?;
        let wanted = (0..=INSTANTS).map(|i| {
            let t_s = scenario.run.duration_s * f64::from(i) / f64::from(INSTANTS);
            reference.value(t_s) / sensor.gain
        });
        let range_n = wanted.fold([0.0_f64; 2], |[least, most], n| [least.min(n), most.max(n)]);
        let unit = if scenario.machine.axis == Axis::Translational { "N" } else { "N m" };
        Some(Self { scenario, found, sensor, sensor_name, contact, touched, range_n, unit })
    }

    /// The largest force asked for, N.
    fn most_n(&self) -> f64 {
        let [least, most] = self.range_n;
        most.max(-least)
    }

    /// Every doubt about a part that is too weak or too coarse for the force.
    pub(super) fn doubts(&self) -> Vec<Problem> {
        if self.most_n() <= 0.0 {
            return Vec::new();
        }
        let all = [self.weak_drives(), self.low_output(), self.late_touch(), self.noisy(), self.coarse()];
        all.into_iter().flatten().chain(self.coarse_encoders()).collect()
    }

    /// Drives that together give less than the force.
    fn weak_drives(&self) -> Option<Problem> {
        let limits = self.scenario.machine.actuators.values().map(|actuator| actuator.limit_n);
        let most_n = limits.sum::<Option<f64>>()?;
        (most_n < self.most_n()).then(|| {
            Problem::new(
                Actuator::LIMIT.of(&self.scenario.controllers[self.found.controller].drives),
                format!("the drive gives {} at most, less than the {}", self.force(most_n), self.reference()),
                format!("raise the limit, or lower {}", FOLLOWED.of::<ControllerUse>(&self.found.name)),
            )
        })
    }

    /// An output that is limited below the force, if it is a force.
    fn low_output(&self) -> Option<Problem> {
        let used = &self.scenario.controllers[self.found.controller];
        let limit_n = used.spec.output_limit.filter(|_| !self.drives_velocity())?;
        (limit_n < self.most_n()).then(|| {
            Problem::new(
                ControllerSpec::OUTPUT_LIMIT.of(&self.found.name),
                format!("the output is {} at most, less than the {}", self.force(limit_n), self.reference()),
                "raise the limit, or lower the reference",
            )
        })
    }

    /// Whether the output is something else than a force.
    fn drives_velocity(&self) -> bool {
        let drive = &self.scenario.controllers[self.found.controller].drives;
        let kind = self.scenario.machine.actuators.get(drive).map(|actuator| &actuator.kind);
        !matches!(kind, Some(ActuatorKind::Force { .. }))
    }

    /// An approach that ends at a force above the reference.
    fn late_touch(&self) -> Option<Problem> {
        let spec = &self.scenario.controllers[self.found.controller].spec;
        let until_n = spec.approach.as_ref()?.until / self.sensor.gain;
        (until_n > self.range_n[1] && self.range_n[1] > 0.0).then(|| {
            Problem::new(
                format!("{}.{}", ControllerUse::place(&self.found.name), Approach::key(&Approach::UNTIL)),
                format!(
                    "the approach presses up to {}, more than the {}",
                    self.force(until_n),
                    self.reference()
                ),
                format!("{} is enough to tell a touch", self.force(two_digits(TOUCH * self.range_n[1]))),
            )
        })
    }

    /// A force sensor whose noise hides the force.
    fn noisy(&self) -> Option<Problem> {
        let noise_n = self.sensor.noise / self.sensor.gain.abs();
        (noise_n > HIDES * self.most_n()).then(|| {
            Problem::new(
                Sensor::NOISE.of(self.sensor_name),
                format!("a standard deviation of {} hides the {}", self.force(noise_n), self.reference()),
                format!("noise is in {} unless a unit is given: write \"m{0}\" if that is meant", self.unit),
            )
        })
    }

    /// A force sensor with steps as large as the force.
    fn coarse(&self) -> Option<Problem> {
        let step_n = self.sensor.resolution? / self.sensor.gain.abs();
        (step_n > self.most_n()).then(|| {
            Problem::new(
                Sensor::RESOLUTION.of(self.sensor_name),
                format!("steps of {} are larger than the {}", self.force(step_n), self.reference()),
                format!(
                    "resolution is in {} unless a unit is given: write \"m{0}\" if that is meant",
                    self.unit
                ),
            )
        })
    }

    /// Encoders with steps as large as the whole motion: the gap, and what the springs and the contact yield.
    fn coarse_encoders(&self) -> Vec<Problem> {
        let machine = &self.scenario.machine;
        let stiffnesses = machine.springs.values().map(|spring| spring.stiffness_n_per_m);
        let yields = |stiffness: f64| if stiffness > 0.0 { self.most_n() / stiffness } else { 0.0 };
        let sinks_m: f64 = stiffnesses.chain([self.contact.stiffness]).map(yields).sum();
        let motion_m = apart_m(machine, self.contact).max(0.0) + sinks_m;
        let used = &self.scenario.controllers[self.found.controller];
        let is_used = |name: &String| used.motion.as_ref().is_none_or(|motion| motion == name);
        let length = if machine.axis == Axis::Translational { "m" } else { "rad" };
        let of_sensor = |(name, sensor): (&String, &Sensor)| {
            let step_m = sensor.resolution? / sensor.gain.abs();
            let is_coarse = sensor.reads.quantity == Quantity::Position && is_used(name) && step_m > motion_m;
            is_coarse.then(|| {
                Problem::new(
                    Sensor::RESOLUTION.of(name),
                    format!(
                        "steps of {} are larger than the motion: gap and deflection are {}",
                        with_unit(step_m, length),
                        with_unit(two_digits(motion_m), length)
                    ),
                    format!("a step of {} resolves it", with_unit(two_digits(0.01 * motion_m), length)),
                )
            })
        };
        machine.sensors.iter().filter_map(of_sensor).collect()
    }

    fn force(&self, force_n: f64) -> String {
        with_unit(force_n, self.unit)
    }

    fn reference(&self) -> String {
        format!("{} of the reference", self.force(self.most_n()))
    }
}
