//! The effects that each case hides.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::bench::{Bench, Compliance};
use super::noise::Random;
use super::servo::conditions::ServoConditions;
use super::wild::conditions::Conditions;

/// An effect that is hidden.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HiddenEffect {
    /// Kind of the effect.
    pub kind: String,
    /// Place of the effect.
    pub place: String,
    /// Parameters by name, SI; empty for an effect outside the library.
    pub parameters: IndexMap<String, f64>,
    /// Whether the library lacks this effect.
    #[serde(default)]
    pub outside_library: bool,
}

impl HiddenEffect {
    /// A hidden effect. Values are kept by name if the library has the effect.
    pub(super) fn new(kind: &str, place: &str, drawn: Vec<(&str, f64)>, outside_library: bool) -> Self {
        let named = drawn.into_iter().filter(|_| !outside_library);
        let parameters = named.map(|(name, value)| (name.to_owned(), value)).collect();
        Self { kind: kind.into(), place: place.into(), parameters, outside_library }
    }
}

/// A case with its hidden truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// Name of its folder.
    pub case: String,
    /// The hidden effects; empty if there is only noise.
    pub effects: Vec<HiddenEffect>,
    /// Kinds that an answer may name without being wrong: each stands for a believed value that is off.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub allowed: Vec<String>,
    /// Recording conditions of a wild case, where they were drawn.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conditions: Option<Conditions>,
    /// Recording conditions of a servo joint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub servo: Option<ServoConditions>,
}

pub(super) fn ideal() -> Bench {
    Bench {
        base_kg: 150.0,
        motor_kg: 8.0,
        tip_kg: 4.0,
        workpiece_kg: 3.0,
        guide_damping: 50.0,
        wall_stiffness: 1.6e5,
        wall_damping: 150.0,
        wall_exponent: 1.0,
        wall_cubic: 0.0,
        hunt_crossley: 0.0,
        gap_m: 5e-3,
        limit_n: 400.0,
        mount: None,
        transmission: None,
        fixture: None,
        coulomb: 0.0,
        asymmetry: 0.0,
        stribeck: None,
        load_ratio: 0.0,
        constant_load: 0.0,
        drive_gain: 1.0,
        drive_lag_s: 0.0,
        drive_delay_s: 0.0,
        deadband: 0.0,
        slew: f64::INFINITY,
        ripple: None,
        force_gain: 1.0,
        force_bias: 0.0,
        force_lag_s: 0.0,
        force_delay_s: 0.0,
        force_resolution: 0.0,
        tool_kg: 0.0,
        encoder_resolution: 1e-6,
        drag: 0.0,
        cable: 0.0,
        sag: 0.0,
        creep: None,
    }
}

/// The bench as built: every value deviates a little from the ideal.
pub(super) fn built(random: &mut Random) -> Bench {
    let mut bench = ideal();
    let mut off = |value: &mut f64, share: f64| *value *= 1.0 + share * (2.0 * random.share() - 1.0);
    for value in [
        &mut bench.motor_kg,
        &mut bench.tip_kg,
        &mut bench.workpiece_kg,
        &mut bench.wall_stiffness,
        &mut bench.base_kg,
    ] {
        off(value, 0.04);
    }
    off(&mut bench.guide_damping, 0.25);
    off(&mut bench.wall_damping, 0.25);
    off(&mut bench.gap_m, 0.01);
    off(&mut bench.force_gain, 0.02);
    bench
}

/// An effect that can be hidden: kind, place, and the function that changes the bench and gives the drawn
/// parameters.
type Recipe = (&'static str, &'static str, fn(&mut Bench, &mut Random) -> Vec<(&'static str, f64)>);

/// Effects of the library.
pub(super) const LIBRARY: &[Recipe] = &[
    ("actuator-lag", "drive", |b, r| {
        b.drive_lag_s = r.log_between(1.2e-3, 5e-3);
        vec![("time_constant", b.drive_lag_s)]
    }),
    ("command-delay", "drive", |b, r| {
        b.drive_delay_s = r.log_between(0.9e-3, 4e-3);
        vec![("delay", b.drive_delay_s)]
    }),
    ("drive-gain", "drive", |b, r| {
        b.drive_gain = 1.0 + r.sign() * r.between(0.15, 0.4);
        vec![("gain", b.drive_gain)]
    }),
    ("drive-deadband", "drive", |b, r| {
        b.deadband = r.log_between(2.0, 7.0);
        vec![("width", b.deadband)]
    }),
    ("force-limit", "drive", |b, r| {
        b.limit_n = r.between(38.0, 60.0);
        vec![("limit", b.limit_n)]
    }),
    ("slew-limit", "drive", |b, r| {
        b.slew = r.log_between(4e3, 1.2e4);
        vec![("rate", b.slew)]
    }),
    ("force-ripple", "drive", |b, r| {
        let [amplitude, pitch, phase] =
            [r.log_between(3.0, 8.0), r.log_between(4e-3, 9e-3), r.between(0.0, std::f64::consts::TAU)];
        b.ripple = Some([amplitude, pitch, phase]);
        vec![("amplitude", amplitude), ("pitch", pitch), ("phase", phase)]
    }),
    ("constant-load", "guide", |b, r| {
        b.constant_load = r.sign() * r.log_between(3.0, 12.0);
        vec![("force", b.constant_load)]
    }),
    ("coulomb-friction", "guide", |b, r| {
        b.coulomb = r.log_between(5.0, 16.0);
        vec![("level", b.coulomb)]
    }),
    ("stribeck-friction", "guide", |b, r| {
        let [coulomb, above, velocity] =
            [r.log_between(4.0, 8.0), r.between(4.0, 9.0), r.log_between(8e-3, 3e-2)];
        (b.coulomb, b.stribeck) = (coulomb, Some([above, velocity]));
        vec![("coulomb", coulomb), ("static", coulomb + above), ("velocity", velocity)]
    }),
    ("viscous-friction", "guide", |b, r| {
        let damping = r.log_between(150.0, 400.0);
        b.guide_damping += damping;
        vec![("damping", damping)]
    }),
    ("load-friction", "guide", |b, r| {
        b.load_ratio = r.between(0.1, 0.3);
        vec![("ratio", b.load_ratio)]
    }),
    ("asymmetric-friction", "guide", |b, r| {
        (b.coulomb, b.asymmetry) = (r.log_between(6.0, 14.0), r.sign() * r.between(0.25, 0.5));
        vec![("level", b.coulomb), ("asymmetry", b.asymmetry)]
    }),
    ("added-mass", "transmission", |b, r| {
        let mass = r.between(2.5, 6.0);
        b.tip_kg += mass;
        vec![("mass", mass)]
    }),
    ("transmission-flexibility", "transmission", |b, r| {
        let [stiffness, damping] = [r.log_between(6e5, 2e6), r.log_between(60.0, 200.0)];
        b.transmission = Some(Compliance::elastic(stiffness, damping));
        vec![("stiffness", stiffness), ("damping", damping)]
    }),
    ("backlash", "transmission", |b, r| {
        let width = r.log_between(4e-5, 1.5e-4);
        b.transmission = Some(Compliance::with_play(width));
        vec![("width", width)]
    }),
    ("hardening-stiffness", "contact", |b, r| {
        // At a deflection of 0.3 mm the cubic force is this share of the linear one.
        b.wall_cubic = b.wall_stiffness * r.between(0.6, 1.5) / 9e-8;
        vec![("cubic", b.wall_cubic)]
    }),
    ("base-flexibility", "base", |b, r| {
        let [stiffness, damping] = [r.log_between(8e5, 3e6), r.log_between(600.0, 2500.0)];
        b.mount = Some(Compliance::elastic(stiffness, damping));
        vec![("mass", b.base_kg), ("stiffness", stiffness), ("damping", damping)]
    }),
    ("workpiece-dynamics", "workpiece", |b, r| {
        let [mass, stiffness, damping] =
            [r.between(2.5, 6.0), r.log_between(8e5, 3e6), r.log_between(100.0, 400.0)];
        b.workpiece_kg = mass;
        b.fixture = Some(Compliance::elastic(stiffness, damping));
        vec![("mass", mass), ("stiffness", stiffness), ("damping", damping)]
    }),
    ("contact-stiffness", "contact", |b, r| {
        b.wall_stiffness *= if r.share() < 0.5 { r.between(0.45, 0.75) } else { r.between(1.35, 2.0) };
        vec![("stiffness", b.wall_stiffness)]
    }),
    ("contact-damping", "contact", |b, r| {
        b.wall_damping *= r.between(4.0, 8.0);
        vec![("damping", b.wall_damping)]
    }),
    ("hertz-contact", "contact", |b, r| {
        b.wall_exponent = 1.5;
        // The drawn wall is about as stiff as the believed one at 25 N.
        b.wall_stiffness *= r.between(0.8, 1.2) * (25.0 / b.wall_stiffness).powf(-0.5);
        vec![("exponent", 1.5), ("stiffness", b.wall_stiffness)]
    }),
    ("surface-offset", "contact", |b, r| {
        let offset = r.sign() * r.log_between(5e-4, 2e-3);
        b.gap_m += offset;
        vec![("offset", offset)]
    }),
    ("force-lag", "force-sensor", |b, r| {
        b.force_lag_s = r.log_between(1e-3, 4e-3);
        vec![("time_constant", b.force_lag_s)]
    }),
    ("force-delay", "force-sensor", |b, r| {
        b.force_delay_s = r.log_between(0.9e-3, 4e-3);
        vec![("delay", b.force_delay_s)]
    }),
    ("force-gain", "force-sensor", |b, r| {
        b.force_gain = 1.0 + r.sign() * r.between(0.15, 0.35);
        vec![("gain", b.force_gain)]
    }),
    ("force-bias", "force-sensor", |b, r| {
        b.force_bias = r.sign() * r.log_between(2.0, 8.0);
        vec![("bias", b.force_bias)]
    }),
    ("force-resolution", "force-sensor", |b, r| {
        b.force_resolution = r.log_between(0.8, 2.5);
        vec![("resolution", b.force_resolution)]
    }),
    ("tool-inertia", "force-sensor", |b, r| {
        b.tool_kg = r.between(0.4, 1.2);
        vec![("mass", b.tool_kg)]
    }),
    ("encoder-resolution", "encoder", |b, r| {
        b.encoder_resolution = r.log_between(1.5e-5, 6e-5);
        vec![("resolution", b.encoder_resolution)]
    }),
];

/// Effects outside the library.
pub(super) const OUTSIDE: &[Recipe] = &[
    ("quadratic-drag", "guide", |b, r| {
        b.drag = r.log_between(1500.0, 5000.0);
        Vec::new()
    }),
    ("cable-pull", "guide", |b, r| {
        b.cable = r.log_between(700.0, 2500.0);
        Vec::new()
    }),
    ("sagging-drive", "drive", |b, r| {
        b.sag = r.between(0.35, 0.7);
        Vec::new()
    }),
    ("force-creep", "force-sensor", |b, r| {
        b.creep = Some([r.between(0.15, 0.3), r.log_between(0.08, 0.3)]);
        Vec::new()
    }),
];

/// Pairs consist of effects that stand for one fault each, and neither explains the other.
const PAIRED: [[&str; 2]; 8] = [
    ["coulomb-friction", "command-delay"],
    ["coulomb-friction", "base-flexibility"],
    ["force-lag", "coulomb-friction"],
    ["drive-gain", "surface-offset"],
    ["transmission-flexibility", "force-bias"],
    ["workpiece-dynamics", "constant-load"],
    ["added-mass", "force-delay"],
    ["actuator-lag", "contact-stiffness"],
];

/// Length of a cycle of cases: one without effects, two with a pair, one with an effect outside the library,
/// and eight with single effects.
const TURN: usize = 12;

/// The bench of case `index` of a benchmark, with its hidden effects.
pub(super) fn case(index: usize, random: &mut Random) -> (Bench, Case) {
    let mut bench = built(random);
    let mut effects = Vec::new();
    let mut hide = |recipe: &Recipe, outside_library: bool, random: &mut Random| {
        let (kind, place, apply) = *recipe;
        effects.push(HiddenEffect::new(kind, place, apply(&mut bench, random), outside_library));
    };
    let round = index / TURN;
    match index % TURN {
        3 => {}
        5 | 9 => {
            let pair = PAIRED[random.pick(PAIRED.len())];
            for recipe in LIBRARY.iter().filter(|(kind, ..)| pair.contains(kind)) {
                hide(recipe, false, random);
            }
        }
        7 => hide(&OUTSIDE[round % OUTSIDE.len()], true, random),
        at => {
            let singles = at - [3, 5, 7, 9].iter().filter(|other| **other < at).count();
            // A stride that is prime to the number of effects reaches all of them.
            let which = (round * (TURN - 4) + singles) * 7 % LIBRARY.len();
            hide(&LIBRARY[which], false, random);
        }
    }
    let case = format!("case-{index:03}");
    (bench, Case { case, effects, allowed: Vec::new(), conditions: None, servo: None })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_what_is_hidden_is_named_as_the_library_names_it() {
        for (kind, _, apply) in LIBRARY {
            let definition = feeler_plant::effects::find(kind).unwrap();
            for (name, _) in apply(&mut ideal(), &mut Random::new(1)) {
                assert!(
                    definition.parameters.iter().any(|parameter| parameter.name == name),
                    "{kind}.{name}"
                );
            }
        }
    }

    #[test]
    fn truth_every_effect_has_its_turn() {
        let mut hidden: Vec<String> = (0..240)
            .flat_map(|i| case(i, &mut Random::new(i as u64)).1.effects)
            .map(|effect| effect.kind)
            .collect();
        hidden.sort_unstable();
        hidden.dedup();
        assert_eq!(hidden.len(), LIBRARY.len() + OUTSIDE.len());
    }
}
