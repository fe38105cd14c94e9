//! One case: its joint, its loop, and the effects hidden in them.

use std::f64::consts::{PI, TAU};

use super::super::axis::{Axis, Friction};
use super::super::cases::{Case, HiddenEffect};
use super::super::noise::Random;
use super::conditions::{ServoConditions, draw as draw_conditions};
use super::firmware::Firmware;
use super::hidden::{BEYOND, Built, PAIRED, Recipe, SINGLE};

/// Length of a cycle of cases, and the cases in it that hide nothing, two effects, or an effect outside the
/// library. The others hide one effect.
const TURN: usize = 12;
const NOTHING: usize = 3;
const PAIRS: [usize; 2] = [5, 9];
const NO_LIBRARY: usize = 7;
/// Step through the kinds, coprime to their number so that all are reached.
const STRIDE: usize = 7;

/// A case as built.
pub(super) struct Drawn {
    pub(super) case: Case,
    pub(super) conditions: ServoConditions,
    pub(super) built: Built,
    pub(super) believed: Built,
    /// Whether the machine file has any dry friction.
    pub(super) is_friction_believed: bool,
}

pub(super) fn draw(index: usize, random: &mut Random, is_known: &dyn Fn(&str) -> bool) -> Drawn {
    let recipes = recipes(index, random);
    let hides = |kind: &str| recipes.iter().any(|recipe| recipe.kind == kind);
    let mut conditions = draw_conditions(random);
    if hides("gravity") {
        conditions.gravity_share = None;
    }
    let ideal = ideal(&conditions, random);
    let mut built = as_built(&ideal, random);
    if hides("torque-speed-line") {
        built.firmware.no_load_speed = None;
    }
    let mut believed = ideal;
    believed.firmware.no_load_speed = built.firmware.no_load_speed;
    let effects = recipes
        .iter()
        .map(|recipe| {
            let drawn = (recipe.apply)(&mut built, random);
            HiddenEffect::new(recipe.kind, recipe.place, drawn, !is_known(recipe.kind))
        })
        .collect();
    let case = Case {
        case: format!("case-{index:03}"),
        effects,
        allowed: Vec::new(),
        conditions: None,
        servo: Some(conditions.clone()),
    };
    let is_friction_believed = !recipes.iter().any(|recipe| recipe.is_friction());
    Drawn { case, conditions, built, believed, is_friction_believed }
}

/// The effects hidden in case `index`.
fn recipes(index: usize, random: &mut Random) -> Vec<&'static Recipe> {
    let (round, at) = (index / TURN, index % TURN);
    if at == NOTHING {
        return Vec::new();
    }
    if PAIRS.contains(&at) {
        let pair = PAIRED[random.pick(PAIRED.len())];
        return SINGLE.iter().filter(|recipe| pair.contains(&recipe.kind)).collect();
    }
    if at == NO_LIBRARY {
        return vec![&BEYOND[round % BEYOND.len()]];
    }
    let before = [NOTHING, PAIRS[0], PAIRS[1], NO_LIBRARY].iter().filter(|other| **other < at).count();
    vec![&SINGLE[(round * (TURN - 4) + at - before) * STRIDE % SINGLE.len()]]
}

/// The joint as believed.
fn ideal(conditions: &ServoConditions, random: &mut Random) -> Built {
    let omega = TAU * conditions.loop_hz;
    let (inertia, amplitude) = if conditions.is_hobby {
        (random.log_between(1e-3, 4e-2), random.between(0.3, 0.8))
    } else {
        (random.log_between(0.02, 2.0), random.between(0.1, 0.4))
    };
    let kp = inertia * omega * omega;
    let damping = 2.0 * random.between(0.4, 0.9) * inertia * omega;
    let guide = random.between(0.1, 0.4);
    let most = kp * amplitude;
    let limit = most * random.between(0.9, 1.5);
    let load = inertia * random.between(0.4, 0.75);
    let friction = most * if conditions.is_hobby { random.log_between(0.008, 0.03) } else { 0.005 };
    let axis = Axis {
        motor_kg: inertia - load,
        load_kg: load,
        damping: guide * damping,
        friction: Friction {
            level: friction,
            bristle_m: amplitude * random.log_between(5e-4, 2e-3),
            ..Friction::default()
        },
        gravity: conditions.gravity_share.map(|share| [share * most, random.between(0.0, TAU)]),
        ..Axis::default()
    };
    let firmware = Firmware {
        kp,
        kd: (1.0 - guide) * damping,
        limit,
        current_limit: f64::INFINITY,
        no_load_speed: conditions.is_hobby.then(|| amplitude * omega * random.between(0.8, 1.5)),
        deadband: 0.0,
        target_gain: 1.0,
        delay_s: random.between(0.2, 2.5) / conditions.rate_hz,
        period_s: if conditions.is_hobby { 1e-3 } else { 2.5e-4 },
        resolution: conditions.resolution,
        is_back_emf: conditions.is_hobby,
    };
    Built { axis, firmware, amplitude }
}

/// The joint as built: every value deviates a little from the ideal.
fn as_built(ideal: &Built, random: &mut Random) -> Built {
    let mut built = ideal.clone();
    let mut off = |value: &mut f64, share: f64| *value *= 1.0 + random.between(-share, share);
    off(&mut built.axis.motor_kg, 0.04);
    off(&mut built.axis.load_kg, 0.04);
    off(&mut built.axis.damping, 0.25);
    off(&mut built.axis.friction.level, 0.1);
    off(&mut built.firmware.kp, 0.02);
    off(&mut built.firmware.kd, 0.08);
    off(&mut built.firmware.limit, 0.03);
    if let Some([amplitude, phase]) = &mut built.axis.gravity {
        off(amplitude, 0.04);
        *phase += 0.03 * PI * (random.share() - 0.5);
    }
    built
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_in_library(kind: &str) -> bool {
        feeler_plant::effects::find(kind).is_some()
    }

    #[test]
    fn truth_what_is_hidden_is_named_as_the_library_names_it() {
        for recipe in SINGLE {
            let mut built = ideal(&draw_conditions(&mut Random::new(1)), &mut Random::new(2));
            let definition = feeler_plant::effects::find(recipe.kind).unwrap();
            for (name, _) in (recipe.apply)(&mut built, &mut Random::new(3)) {
                assert!(
                    definition.parameters.iter().any(|parameter| parameter.name == name),
                    "{}.{name}",
                    recipe.kind
                );
            }
        }
    }

    #[test]
    fn truth_every_kind_has_its_turn() {
        let cases: Vec<Case> =
            (0..120).map(|i| draw(i, &mut Random::new(i as u64), &is_in_library).case).collect();
        let mut kinds: Vec<&str> = cases.iter().flat_map(|case| &case.effects).map(|e| &*e.kind).collect();
        kinds.sort_unstable();
        kinds.dedup();
        assert_eq!(kinds.len(), SINGLE.len() + BEYOND.len());
        let of = |n: usize| cases.iter().filter(|case| case.effects.len() == n).count();
        assert_eq!([of(0), of(2)], [10, 20]);
    }

    #[test]
    fn prop_a_limit_leaves_the_servo_the_torque_to_carry_its_weight() {
        for seed in 0..400 {
            let drawn = draw(seed, &mut Random::new(seed as u64), &is_in_library);
            let axis = &drawn.built.axis;
            let carried = axis.friction.level + axis.gravity.map_or(0.0, |[amplitude, _]| amplitude);
            let firmware = &drawn.built.firmware;
            assert!(firmware.limit.min(firmware.current_limit) > carried, "{seed}");
        }
    }
}
