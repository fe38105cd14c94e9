//! The chain whose parameters are fitted.

use std::f64::consts::TAU;

use feeler_plant::description::{Actuator, ActuatorKind, Body, Contact, Engagement, GROUND, Machine};
use nalgebra::DVector;
use serde::Serialize;

use crate::paper::spring;

/// Bodies after the motor.
const LINKS: usize = 4;

/// A serial chain: base on its mount, motor guided on the base, four more masses, a velocity source; clamped by its sensor to the base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Chain {
    /// Mass of the base, kg.
    pub base_kg: f64,
    /// Frequency of the base with the rest on it, Hz, and its damping ratio.
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

/// How many numbers a chain has.
pub(super) const PARAMETERS: usize = 2 + 1 + 1 + 1 + 3 * LINKS + 2 + 2;

impl Chain {
    /// Where [`super::fit`] starts: a chain found in earlier searches, rounded, which has the landmarks already. The fit polishes it; it is not known to
    /// find the landmarks from a start that knows nothing of them.
    pub const START: Self = Self {
        base_kg: 394.0,
        mount: [11.93, 0.0328],
        motor_kg: 101.0,
        guide_n_s_per_m: 37.7,
        masses_kg: [18.6, 4.68, 0.404, 0.145],
        stiffness_n_per_m: [1.665e6, 6.346e5, 6.61e4, 1.088e4],
        damping_n_s_per_m: [1.4, 0.965, 0.543, 11.0],
        source: [7840.0, 1.61e-3],
        sensor: [1.12e7, 4.26],
    };

    pub(super) fn to_logs(self) -> DVector<f64> {
        DVector::from_iterator(PARAMETERS, self.parameters().into_iter().map(|(value, _)| value.ln()))
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
    pub fn parameter_names() -> Vec<String> {
        let of = |what: &str| (1..=LINKS).map(move |i| format!("{what} {i}")).collect::<Vec<_>>();
        let head = ["base mass", "mount frequency", "mount damping ratio", "motor mass", "guide damping"].map(String::from);
        let tail = ["source damping", "source time constant", "sensor stiffness", "sensor damping"].map(String::from);
        head.into_iter().chain(of("mass")).chain(of("stiffness")).chain(of("damping")).chain(tail).collect()
    }

    /// Values of the parameters with their units, in the order of [`Self::parameter_names`].
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

    /// The machine: `base`, `motor`, `link1` to `link4`, the last of which is the end-point; contact `tool`.
    pub fn machine(&self, engagement: Engagement) -> Machine {
        let mut machine = Machine { name: "landmarks".into(), ..Machine::default() };
        let body = |mass_kg| Body { mass_kg, ..Body::default() };
        machine.bodies.insert("base".into(), body(self.base_kg));
        machine.bodies.insert("motor".into(), body(self.motor_kg));
        let on_mount = self.base_kg + self.motor_kg + self.masses_kg.iter().sum::<f64>();
        let w = TAU * self.mount[0];
        machine.springs.insert("mount".into(), spring(GROUND, "base", on_mount * w * w, 2.0 * self.mount[1] * on_mount * w));
        machine.springs.insert("guide".into(), spring("base", "motor", 0.0, self.guide_n_s_per_m));
        let mut before = "motor".to_string();
        for i in 0..LINKS {
            let name = format!("link{}", i + 1);
            machine.bodies.insert(name.clone(), body(self.masses_kg[i]));
            let joint = spring(&before, &name, self.stiffness_n_per_m[i], self.damping_n_s_per_m[i]);
            machine.springs.insert(format!("joint{}", i + 1), joint);
            before = name;
        }
        let contact = Contact { engagement, ..Contact::kelvin_voigt(before, "base", self.sensor[0], self.sensor[1]) };
        machine.contacts.insert("tool".into(), contact);
        let kind = ActuatorKind::VelocitySource { damping_n_s_per_m: self.source[0], time_constant_s: self.source[1] };
        let drive = Actuator { kind, ..Actuator::ideal("motor", "base") };
        machine.actuators.insert("drive".into(), drive);
        machine
    }
}
