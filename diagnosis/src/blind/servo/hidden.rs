//! Effects that a servo joint may hide, scaled by its loop and its motion.

use std::f64::consts::TAU;

use super::super::axis::{Axis, Joint};
use super::super::noise::Random;
use super::firmware::Firmware;

/// A joint with its loop, before or after effects are hidden in it.
#[derive(Clone, Debug)]
pub(super) struct Built {
    pub(super) axis: Axis,
    pub(super) firmware: Firmware,
    /// Largest target, rad.
    pub(super) amplitude: f64,
}

impl Built {
    /// Frequency of the loop, rad/s.
    pub(super) fn omega(&self) -> f64 {
        (self.firmware.kp / self.axis.mass_kg()).sqrt()
    }

    /// Torque that holds an error of this share of the amplitude.
    fn torque(&self, share: f64) -> f64 {
        share * self.firmware.kp * self.amplitude
    }

    /// Torque that gravity and friction require, N m.
    fn carried(&self) -> f64 {
        self.axis.friction.level + self.axis.gravity.map_or(0.0, |[amplitude, _]| amplitude)
    }

    /// A joint between motor and link with this stiffness and a small damping ratio.
    fn joint(&self, stiffness: f64, play: f64) -> Joint {
        let axis = &self.axis;
        let reduced = axis.motor_kg * axis.load_kg / axis.mass_kg();
        Joint { stiffness, damping: 0.1 * (stiffness * reduced).sqrt(), play }
    }
}

/// A kind that can be hidden.
pub(super) struct Recipe {
    pub(super) kind: &'static str,
    pub(super) place: &'static str,
    /// Changes the joint and gives the parameters that were drawn.
    pub(super) apply: fn(&mut Built, &mut Random) -> Vec<(&'static str, f64)>,
}

const fn recipe(
    kind: &'static str,
    place: &'static str,
    apply: fn(&mut Built, &mut Random) -> Vec<(&'static str, f64)>,
) -> Recipe {
    Recipe { kind, place, apply }
}

impl Recipe {
    /// Whether the kind is dry friction. If it is hidden, the machine file states no friction.
    pub(super) fn is_friction(&self) -> bool {
        self.kind.ends_with("-friction") && self.kind != "viscous-friction"
    }
}

/// Single kinds that target and position of a servo can show.
pub(super) const SINGLE: &[Recipe] = &[
    recipe("coulomb-friction", "guide", |built, random| {
        let level = built.torque(random.log_between(0.03, 0.12));
        built.axis.friction.level = level;
        vec![("level", level)]
    }),
    recipe("loop-gain", "drive", |built, random| {
        let gain = random.between(1.5, 2.5).powf(random.sign());
        built.firmware.kp *= gain;
        built.firmware.kd *= gain;
        vec![("gain", gain)]
    }),
    recipe("command-delay", "drive", |built, random| {
        let delay_s = random.between(0.3, 0.9) / built.omega();
        built.firmware.delay_s += delay_s;
        vec![("delay", delay_s)]
    }),
    recipe("gravity", "guide", |built, random| {
        let [amplitude, phase] = [built.torque(random.log_between(0.08, 0.3)), random.between(0.0, TAU)];
        built.axis.gravity = Some([amplitude, phase]);
        vec![("amplitude", amplitude), ("phase", phase)]
    }),
    recipe("transmission-flexibility", "transmission", |built, random| {
        let link = built.omega() * random.between(1.3, 3.0);
        let joint = built.joint(built.axis.load_kg * link * link, 0.0);
        built.axis.joint = Some(joint);
        vec![("stiffness", joint.stiffness), ("damping", joint.damping), ("tip_mass", built.axis.load_kg)]
    }),
    recipe("force-limit", "drive", |built, random| {
        built.firmware.current_limit = built.carried() + built.torque(random.between(0.12, 0.25));
        vec![("limit", built.firmware.current_limit)]
    }),
    recipe("viscous-friction", "guide", |built, random| {
        let damping = random.between(0.5, 1.5) * 2.0 * built.omega() * built.axis.mass_kg();
        built.axis.damping += damping;
        vec![("damping", damping)]
    }),
    recipe("added-mass", "transmission", |built, random| {
        let mass = built.axis.mass_kg() * random.between(0.6, 2.0);
        built.axis.load_kg += mass;
        vec![("mass", mass)]
    }),
    recipe("constant-load", "guide", |built, random| {
        built.axis.constant_load = random.sign() * built.torque(random.log_between(0.05, 0.2));
        vec![("force", built.axis.constant_load)]
    }),
    recipe("drive-gain", "drive", |built, random| {
        let gain = random.between(1.08, 1.3).powf(random.sign());
        built.firmware.target_gain = gain;
        vec![("gain", gain)]
    }),
    recipe("actuator-lag", "drive", |built, random| {
        built.axis.drive.lag_s = random.between(0.3, 0.8) / built.omega();
        vec![("time_constant", built.axis.drive.lag_s)]
    }),
    recipe("drive-deadband", "drive", |built, random| {
        built.firmware.deadband = built.amplitude * random.log_between(0.03, 0.1);
        vec![("width", built.firmware.deadband)]
    }),
    recipe("stribeck-friction", "guide", |built, random| {
        let level = built.torque(random.log_between(0.03, 0.08));
        let above = level * random.between(0.4, 1.0);
        let speed = built.amplitude * built.omega() * random.log_between(0.02, 0.08);
        built.axis.friction.level = level;
        built.axis.friction.stribeck = Some([above, speed]);
        vec![("coulomb", level), ("static", level + above), ("velocity", speed)]
    }),
    recipe("torque-speed-line", "drive", |built, random| {
        let force = built.carried() + built.torque(random.between(0.4, 0.7));
        let speed = built.amplitude * built.omega() * random.between(0.3, 0.6);
        built.firmware.limit = force;
        built.firmware.no_load_speed = Some(speed);
        vec![("force", force), ("speed", speed)]
    }),
    recipe("backlash", "transmission", |built, random| {
        let play = built.amplitude * random.log_between(0.04, 0.12);
        // An error of a third of the amplitude bends the flanks by a tenth of the play.
        built.axis.joint = Some(built.joint(10.0 * built.torque(0.3) / play, play));
        vec![("width", play)]
    }),
    recipe("encoder-resolution", "encoder", |built, random| {
        built.firmware.resolution = built.amplitude * random.log_between(0.01, 0.03);
        vec![("resolution", built.firmware.resolution)]
    }),
];

pub(super) const BEYOND: &[Recipe] = &[
    recipe("sagging-drive", "drive", |built, random| {
        built.axis.drive.sag = random.between(0.4, 0.7) / built.torque(0.5);
        Vec::new()
    }),
    recipe("tight-spot", "guide", |built, random| {
        let centre = built.amplitude * random.between(-0.3, 0.3);
        built.axis.friction.tight_spot = Some([random.between(2.0, 4.0), centre, 0.15 * built.amplitude]);
        built.axis.friction.level = built.torque(0.03);
        Vec::new()
    }),
    recipe("cable-pull", "guide", |built, random| {
        let slack = built.amplitude * random.between(0.0, 0.2);
        built.axis.cable = Some([slack, built.firmware.kp * random.between(0.3, 0.8)]);
        Vec::new()
    }),
];

/// Pairs of faults, neither of which explains the other.
pub(super) const PAIRED: [[&str; 2]; 4] = [
    ["coulomb-friction", "command-delay"],
    ["command-delay", "gravity"],
    ["coulomb-friction", "drive-gain"],
    ["constant-load", "force-limit"],
];
