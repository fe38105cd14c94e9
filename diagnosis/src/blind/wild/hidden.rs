//! Effects that a wild case may hide, scaled by the motion and the command of the case.

use std::f64::consts::TAU;

use super::super::axis::{Axis, Joint};
use super::super::noise::Random;
use super::motion::Sizes;

/// A kind that can be hidden.
pub(super) struct Recipe {
    pub(super) kind: &'static str,
    pub(super) place: &'static str,
    /// Whether only a second encoder can show the effect.
    pub(super) needs_load_encoder: bool,
    /// Whether only a rotational axis can have the effect.
    pub(super) only_rotational: bool,
    /// Changes the axis and gives the parameters that were drawn.
    pub(super) apply: fn(&mut Axis, &Sizes, &mut Random) -> Vec<(&'static str, f64)>,
}

const fn recipe(
    kind: &'static str,
    place: &'static str,
    apply: fn(&mut Axis, &Sizes, &mut Random) -> Vec<(&'static str, f64)>,
) -> Recipe {
    Recipe { kind, place, needs_load_encoder: false, only_rotational: false, apply }
}

impl Recipe {
    /// Whether the kind is dry friction. If it is hidden, the machine file states no friction.
    pub(super) fn is_friction(&self) -> bool {
        FRICTIONS.contains(&self.kind)
    }
}

const FRICTIONS: [&str; 3] = ["coulomb-friction", "stribeck-friction", "asymmetric-friction"];

/// Dry friction at the level drawn with the conditions.
pub(super) const COULOMB: Recipe =
    recipe("coulomb-friction", "guide", |axis, _, _| vec![("level", axis.friction.level)]);

/// Kinds that are hidden alone, in turn. Friction comes more often, as in practice.
pub(super) const SINGLE: &[Recipe] = &[
    COULOMB,
    recipe("added-mass", "transmission", |axis, _, random| {
        let mass = axis.mass_kg() * random.between(0.4, 1.5);
        axis.load_kg += mass;
        vec![("mass", mass)]
    }),
    recipe("stribeck-friction", "guide", |axis, sizes, random| {
        let level = axis.friction.level;
        let above = level * random.between(0.25, 0.8);
        let speed = sizes.speed() * random.log_between(0.05, 0.25);
        axis.friction.stribeck = Some([above, speed]);
        vec![("coulomb", level), ("static", level + above), ("velocity", speed)]
    }),
    recipe("drive-gain", "drive", |axis, _, random| {
        axis.drive.gain = 1.0 + random.sign() * random.between(0.2, 0.45);
        vec![("gain", axis.drive.gain)]
    }),
    recipe("asymmetric-friction", "guide", |axis, _, random| {
        axis.friction.asymmetry = random.sign() * random.between(0.15, 0.4);
        vec![("level", axis.friction.level), ("asymmetry", axis.friction.asymmetry)]
    }),
    recipe("viscous-friction", "guide", |axis, _, random| {
        let damping = axis.damping * random.between(2.0, 5.0);
        axis.damping += damping;
        vec![("damping", damping)]
    }),
    COULOMB,
    recipe("constant-load", "guide", |axis, sizes, random| {
        axis.constant_load = random.sign() * sizes.moving * random.between(0.2, 0.8);
        vec![("force", axis.constant_load)]
    }),
    recipe("drive-deadband", "drive", |axis, sizes, random| {
        axis.drive.deadband = sizes.command * random.between(0.1, 0.35);
        vec![("width", axis.drive.deadband)]
    }),
    recipe("force-ripple", "drive", |axis, sizes, random| {
        let amplitude = sizes.moving * random.between(0.1, 0.4);
        let pitch = sizes.amplitude / random.between(2.0, 8.0);
        let phase = random.between(0.0, TAU);
        axis.drive.ripple = Some([amplitude, pitch, phase]);
        vec![("amplitude", amplitude), ("pitch", pitch), ("phase", phase)]
    }),
    COULOMB,
    recipe("force-limit", "drive", |axis, sizes, random| {
        axis.drive.limit = axis.friction.level + sizes.moving * random.between(0.3, 0.6);
        vec![("limit", axis.drive.limit)]
    }),
    recipe("actuator-lag", "drive", |axis, sizes, random| {
        axis.drive.lag_s = random.between(0.15, 0.4) / sizes.servo(axis.mass_kg());
        vec![("time_constant", axis.drive.lag_s)]
    }),
    recipe("command-delay", "drive", |axis, sizes, random| {
        axis.drive.delay_s = random.between(0.15, 0.4) / sizes.servo(axis.mass_kg());
        vec![("delay", axis.drive.delay_s)]
    }),
    Recipe {
        needs_load_encoder: true,
        ..recipe("backlash", "transmission", |axis, sizes, random| {
            let play = sizes.amplitude * random.log_between(0.01, 0.05);
            // The largest command deflects the flanks by a tenth of the play.
            axis.joint = Some(joint(axis, 10.0 * sizes.command / play, play));
            vec![("width", play)]
        })
    },
    Recipe {
        needs_load_encoder: true,
        ..recipe("transmission-flexibility", "transmission", |axis, sizes, random| {
            let reduced = axis.motor_kg * axis.load_kg / axis.mass_kg();
            let stiffness = reduced * (sizes.omega * random.log_between(8.0, 20.0)).powi(2);
            let joint = joint(axis, stiffness, 0.0);
            axis.joint = Some(joint);
            vec![("stiffness", joint.stiffness), ("damping", joint.damping)]
        })
    },
];

/// A joint with a damping ratio of a tenth.
fn joint(axis: &Axis, stiffness: f64, play: f64) -> Joint {
    let reduced = axis.motor_kg * axis.load_kg / axis.mass_kg();
    Joint { stiffness, damping: 0.2 * (stiffness * reduced).sqrt(), play }
}

/// Kinds that the library lacks, or lacked when this bench was made. The caller knows which it has now.
pub(super) const BEYOND: &[Recipe] = &[
    Recipe {
        only_rotational: true,
        ..recipe("gravity", "guide", |axis, sizes, random| {
            let [amplitude, phase] = gravity(sizes, random.log_between(0.5, 3.0), random);
            axis.gravity = Some([amplitude, phase]);
            vec![("amplitude", amplitude), ("phase", phase)]
        })
    },
    recipe("sagging-drive", "drive", |axis, sizes, random| {
        axis.drive.sag = random.between(0.25, 0.5) / sizes.command;
        Vec::new()
    }),
    recipe("fading-drive", "drive", |axis, sizes, random| {
        axis.drive.fading = random.between(0.3, 0.6) / sizes.speed();
        Vec::new()
    }),
    recipe("directional-damping", "guide", |axis, _, random| {
        let asymmetry = random.sign() * random.between(0.4, 0.8);
        axis.directional = axis.damping * asymmetry;
        vec![("asymmetry", asymmetry)]
    }),
    recipe("warming-guide", "guide", |axis, sizes, random| {
        let periods = random.between(4.0, 12.0);
        axis.friction.warming = Some([random.between(0.3, 0.6), periods * TAU / sizes.omega]);
        Vec::new()
    }),
    recipe("cable-pull", "guide", |axis, sizes, random| {
        let slack = sizes.amplitude * random.between(0.0, 0.3);
        axis.cable = Some([slack, sizes.moving * random.between(1.0, 2.5) / sizes.amplitude]);
        Vec::new()
    }),
    recipe("quadratic-drag", "guide", |axis, sizes, random| {
        axis.drag = axis.damping * random.between(1.5, 4.0) / sizes.speed();
        vec![("drag", axis.drag)]
    }),
    recipe("tight-spot", "guide", |axis, sizes, random| {
        let centre = sizes.amplitude * random.between(-0.3, 0.3);
        axis.friction.tight_spot = Some([random.between(0.6, 1.5), centre, 0.15 * sizes.amplitude]);
        Vec::new()
    }),
    recipe("wavy-friction", "guide", |axis, sizes, random| {
        axis.friction.wave = Some([random.between(0.3, 0.7), sizes.amplitude / random.between(1.0, 4.0)]);
        Vec::new()
    }),
    recipe("hard-stop", "guide", |axis, sizes, random| {
        let at = sizes.amplitude * random.between(0.45, 0.6);
        let stiffness = 8.0 * sizes.command / sizes.amplitude;
        axis.stop = Some([at, stiffness]);
        vec![("position", at), ("stiffness", stiffness)]
    }),
];

/// Amplitude and phase of gravity; `share` is its ratio to the largest force of motion.
pub(super) fn gravity(sizes: &Sizes, share: f64, random: &mut Random) -> [f64; 2] {
    [share * sizes.moving, random.between(0.0, TAU)]
}

/// Kinds that are paired with friction; each is one fault.
pub(super) const BESIDE_FRICTION: [&str; 6] =
    ["drive-gain", "added-mass", "constant-load", "force-ripple", "actuator-lag", "force-limit"];
