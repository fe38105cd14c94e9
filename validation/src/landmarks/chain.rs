//! The chain with fitted parameters.

use std::f64::consts::TAU;

use feeler_plant::description::{Actuator, ActuatorKind, Body, Contact, Engagement, GROUND, Machine, Spring};
use nalgebra::DVector;
use serde::Serialize;

use crate::error::ValidationError;

/// Bodies after the motor.
pub(super) const LINKS: usize = 4;

/// A serial chain: base on its mount, motor guided on the base, four more masses, a velocity source; clamped
/// by its sensor to the base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LandmarkChain {
    /// Mass of the base, kg.
    pub base_kg: f64,
    /// Frequency of the base with everything on it, Hz, and its damping ratio.
    pub mount: [f64; 2],
    /// Mass of the motor, kg.
    pub motor_kg: f64,
    /// Damping of the guide, N s/m.
    pub guide_n_s_per_m: f64,
    /// Masses after the motor, kg.
    pub masses_kg: [f64; LINKS],
    /// Springs before each of them, N/m.
    pub stiffness_n_per_m: [f64; LINKS],
    /// Dampers beside the springs, N s/m.
    pub damping_n_s_per_m: [f64; LINKS],
    /// Damping (N s/m) and time constant (s) of the velocity source.
    pub source: [f64; 2],
    /// Stiffness (N/m) and damping (N s/m) of the sensor.
    pub sensor: [f64; 2],
}

/// Number of parameters of a chain.
pub(super) const PARAMETERS: usize = 2 + 1 + 1 + 1 + 3 * LINKS + 2 + 2;

impl LandmarkChain {
    /// Stiffness (N/m) and damping (N s/m) of the mount, which carries all bodies.
    pub(super) fn mount_spring(&self) -> [f64; 2] {
        let on_mount = self.base_kg + self.motor_kg + self.masses_kg.iter().sum::<f64>();
        let w = TAU * self.mount[0];
        [on_mount * w * w, 2.0 * self.mount[1] * on_mount * w]
    }

    /// The same chain with another mass of the base, and all masses, stiffnesses and dampings scaled by one
    /// factor. Such chains respond equally to a velocity command.
    #[must_use]
    pub(super) fn of_base(&self, base_kg: f64) -> Self {
        let factor = base_kg / self.base_kg;
        Self {
            base_kg,
            mount: self.mount,
            motor_kg: self.motor_kg * factor,
            guide_n_s_per_m: self.guide_n_s_per_m * factor,
            masses_kg: self.masses_kg.map(|m| m * factor),
            stiffness_n_per_m: self.stiffness_n_per_m.map(|k| k * factor),
            damping_n_s_per_m: self.damping_n_s_per_m.map(|c| c * factor),
            source: [self.source[0] * factor, self.source[1]],
            sensor: self.sensor.map(|value| value * factor),
        }
    }

    /// The chain of a machine with the bodies, springs, contact and actuator of [`Self::machine`], all
    /// numbers above zero.
    ///
    /// # Errors
    /// [`ValidationError::Chain`] names the missing element, or the one that is not above zero.
    pub fn of_machine(machine: &Machine) -> Result<Self, ValidationError> {
        let missing = |what: String| ValidationError::Chain { what };
        let mass = |name: &str| {
            machine
                .bodies
                .get(name)
                .map(|body| body.mass_kg)
                .ok_or_else(|| missing(format!("no [bodies.{name}]")))
        };
        let spring =
            |name: &str| machine.springs.get(name).ok_or_else(|| missing(format!("no [springs.{name}]")));
        let both =
            |name: &str| spring(name).map(|spring| [spring.stiffness_n_per_m, spring.damping_n_s_per_m]);
        let drive = machine.actuators.get("drive").ok_or_else(|| missing("no [actuators.drive]".into()))?;
        let ActuatorKind::VelocitySource { damping_n_s_per_m: source_damping, time_constant_s } = drive.kind
        else {
            return Err(missing("actuators.drive is not a velocity source".into()));
        };
        let tool = machine.contacts.get("tool").ok_or_else(|| missing("no [contacts.tool]".into()))?;
        let (base_kg, motor_kg) = (mass("base")?, mass("motor")?);
        let [mut masses_kg, mut stiffness_n_per_m, mut damping_n_s_per_m] = [[0.0; LINKS]; 3];
        for i in 0..LINKS {
            masses_kg[i] = mass(&format!("link{}", i + 1))?;
            [stiffness_n_per_m[i], damping_n_s_per_m[i]] = both(&format!("joint{}", i + 1))?;
        }
        let on_mount = base_kg + motor_kg + masses_kg.iter().sum::<f64>();
        let [k, c] = both("mount")?;
        let w = (k / on_mount).sqrt();
        let chain = Self {
            base_kg,
            mount: [w / TAU, c / (2.0 * on_mount * w)],
            motor_kg,
            guide_n_s_per_m: spring("guide")?.damping_n_s_per_m,
            masses_kg,
            stiffness_n_per_m,
            damping_n_s_per_m,
            source: [source_damping, time_constant_s],
            sensor: [tool.stiffness, tool.damping_n_s_per_m],
        };
        let bad = Self::parameter_names()
            .into_iter()
            .zip(chain.values())
            .find(|(_, value)| !(value.is_finite() && *value > 0.0));
        if let Some((name, value)) = bad {
            return Err(missing(format!(
                "{name} is {value}, and a fit of logarithms needs numbers above zero"
            )));
        }
        let alike = chain.machine(Engagement::Free);
        let elsewhere = alike
            .springs
            .iter()
            .find(|(name, spring)| machine.springs[name.as_str()].between != spring.between);
        if let Some((name, spring)) = elsewhere {
            return Err(missing(format!(
                "springs.{name} is not between {} and {}",
                spring.between[0], spring.between[1]
            )));
        }
        if tool.between != alike.contacts["tool"].between
            || (drive.on.as_str(), drive.reacts_on.as_str()) != ("motor", "base")
        {
            return Err(missing(
                "contacts.tool is to be between link4 and base, actuators.drive on motor against base".into(),
            ));
        }
        let more = (machine.bodies.len() > alike.bodies.len()).then_some("bodies");
        let more = more.or_else(|| (machine.springs.len() > alike.springs.len()).then_some("springs"));
        more.map_or(Ok(chain), |more| {
            Err(missing(format!("it has more {more} than base, motor and link1 to link4 need")))
        })
    }

    pub(super) fn to_logs(self) -> DVector<f64> {
        DVector::from_iterator(PARAMETERS, self.values().into_iter().map(f64::ln))
    }

    pub(super) fn from_logs(logs: &DVector<f64>) -> Self {
        let p: Vec<f64> = logs.iter().map(|l| l.exp()).collect();
        let list = |first: usize| std::array::from_fn(|i| p[first + i]);
        Self {
            base_kg: p[0],
            mount: [p[1], p[2]],
            motor_kg: p[3],
            guide_n_s_per_m: p[4],
            masses_kg: list(5),
            stiffness_n_per_m: list(5 + LINKS),
            damping_n_s_per_m: list(5 + 2 * LINKS),
            source: [p[5 + 3 * LINKS], p[6 + 3 * LINKS]],
            sensor: [p[7 + 3 * LINKS], p[8 + 3 * LINKS]],
        }
    }

    /// Names of the parameters, in the order of [`super::Fit::undetermined`].
    pub(super) fn parameter_names() -> Vec<String> {
        let of = |what: &str| (1..=LINKS).map(move |i| format!("{what} {i}")).collect::<Vec<_>>();
        let head = ["base mass", "mount frequency", "mount damping ratio", "motor mass", "guide damping"]
            .map(String::from);
        let tail = ["source damping", "source time constant", "sensor stiffness", "sensor damping"]
            .map(String::from);
        head.into_iter().chain(of("mass")).chain(of("stiffness")).chain(of("damping")).chain(tail).collect()
    }

    /// Values of the parameters with their units, in the order of their names.
    pub fn parameters(&self) -> Vec<(f64, &'static str)> {
        let one = |value, unit| std::iter::once((value, unit));
        let list = |values: [f64; LINKS], unit| values.into_iter().map(move |value| (value, unit));
        one(self.base_kg, "kg")
            .chain(one(self.mount[0], "Hz"))
            .chain(one(self.mount[1], ""))
            .chain(one(self.motor_kg, "kg"))
            .chain(one(self.guide_n_s_per_m, "N s/m"))
            .chain(list(self.masses_kg, "kg"))
            .chain(list(self.stiffness_n_per_m, "N/m"))
            .chain(list(self.damping_n_s_per_m, "N s/m"))
            .chain(one(self.source[0], "N s/m"))
            .chain(one(self.source[1], "s"))
            .chain(one(self.sensor[0], "N/m"))
            .chain(one(self.sensor[1], "N s/m"))
            .collect()
    }

    pub(super) fn values(&self) -> Vec<f64> {
        self.parameters().into_iter().map(|(value, _)| value).collect()
    }

    /// The machine: `base`, `motor`, `link1` to `link4`, the last of which is the end-point; contact `tool`.
    pub fn machine(&self, engagement: Engagement) -> Machine {
        let mut machine = Machine::new("landmarks");
        machine.bodies.insert("base".into(), Body::new(self.base_kg));
        machine.bodies.insert("motor".into(), Body::new(self.motor_kg));
        let [stiffness, damping] = self.mount_spring();
        machine.springs.insert("mount".into(), Spring::new(GROUND, "base", stiffness, damping));
        machine.springs.insert("guide".into(), Spring::new("base", "motor", 0.0, self.guide_n_s_per_m));
        let mut before = "motor".to_string();
        for i in 0..LINKS {
            let name = format!("link{}", i + 1);
            machine.bodies.insert(name.clone(), Body::new(self.masses_kg[i]));
            let (stiffness, damping) = (self.stiffness_n_per_m[i], self.damping_n_s_per_m[i]);
            let joint = Spring::new(before, name.as_str(), stiffness, damping);
            machine.springs.insert(format!("joint{}", i + 1), joint);
            before = name;
        }
        let contact =
            Contact { engagement, ..Contact::kelvin_voigt(before, "base", self.sensor[0], self.sensor[1]) };
        machine.contacts.insert("tool".into(), contact);
        let kind = ActuatorKind::VelocitySource {
            damping_n_s_per_m: self.source[0],
            time_constant_s: self.source[1],
        };
        let drive = Actuator { kind, ..Actuator::ideal("motor", "base") };
        machine.actuators.insert("drive".into(), drive);
        machine
    }
}
