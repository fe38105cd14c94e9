//! One case: its conditions, its axis and its hidden effects.

use std::f64::consts::TAU;

use super::super::axis::{Axis, Friction};
use super::super::cases::{Case, HiddenEffect};
use super::super::noise::Random;
use super::conditions::{Conditions, draw as draw_conditions};
use super::hidden::{BESIDE_FRICTION, BEYOND, COULOMB, Recipe, SINGLE, gravity};
use super::motion::Sizes;

/// Length of a cycle of cases, and the cases in it that hide nothing, two effects, or an effect outside the
/// library. The others hide one effect.
const TURN: usize = 20;
const NOTHING: [usize; 2] = [3, 13];
const PAIRS: [usize; 4] = [5, 9, 15, 18];
const NO_LIBRARY: [usize; 5] = [1, 7, 11, 16, 19];

/// Step through the kinds that are hidden alone: a prime that divides no number of them.
const STEP: usize = 7;

/// Largest relative error of a believed mass.
const MASS_OFF: f64 = 0.05;
/// An answer may name a believed friction level or damping that is off by more than this factor.
const MAY_BE_NAMED: f64 = 1.1;

/// A case as built.
pub(super) struct Drawn {
    pub(super) case: Case,
    pub(super) conditions: Conditions,
    pub(super) axis: Axis,
    pub(super) sizes: Sizes,
    pub(super) believed: Believed,
}

/// Values that the machine file states.
#[derive(Clone, Debug)]
pub(super) struct Believed {
    pub(super) motor_kg: f64,
    pub(super) load_kg: f64,
    pub(super) damping: f64,
    /// Level of dry friction; `None` if the file states no friction.
    pub(super) friction: Option<f64>,
    /// Amplitude and phase of gravity; `None` if the file states no gravity.
    pub(super) gravity: Option<[f64; 2]>,
    pub(super) limit: f64,
}

/// Draws case `index`; `is_known` says whether the library has a kind, so that a file can state it and an
/// answer can name it.
pub(super) fn draw(index: usize, random: &mut Random, is_known: &dyn Fn(&str) -> bool) -> Drawn {
    let mut conditions = draw_conditions(random);
    let recipes = recipes(index, conditions.is_rotational, is_known, random);
    let hides = |kind: &str| recipes.iter().any(|recipe| recipe.kind == kind);
    // Gravity that the machine file does not state would be a second hidden effect.
    if !is_known("gravity") || hides("gravity") {
        conditions.gravity_share = None;
    }
    if recipes.iter().any(|recipe| recipe.is_friction()) {
        conditions.friction_factor = None;
    }
    if recipes.iter().any(|recipe| recipe.needs_load_encoder) {
        conditions.channels = 3;
    }
    if hides("viscous-friction") {
        conditions.damping_factor = 1.0;
    }
    let (mut axis, sizes) = build(&conditions, random);
    conditions.resolution *= if conditions.is_rotational { 1.0 } else { sizes.amplitude };
    let off = |random: &mut Random| random.between(1.0 - MASS_OFF, 1.0 + MASS_OFF);
    let believed = Believed {
        motor_kg: axis.motor_kg * off(random),
        load_kg: axis.load_kg * off(random),
        damping: axis.damping * conditions.damping_factor,
        friction: conditions.friction_factor.map(|factor| axis.friction.level * factor),
        gravity: axis.gravity.map(|[amplitude, phase]| [amplitude * off(random), phase]),
        limit: 5.0 * sizes.command,
    };
    let effects = recipes
        .iter()
        .map(|recipe| {
            let drawn = (recipe.apply)(&mut axis, &sizes, random);
            HiddenEffect::new(recipe.kind, recipe.place, drawn, !is_known(recipe.kind))
        })
        .collect();
    let case = Case {
        case: format!("case-{index:03}"),
        effects,
        allowed: allowed(&conditions),
        conditions: Some(conditions.clone()),
        servo: None,
    };
    Drawn { case, conditions, axis, sizes, believed }
}

/// Kinds that an answer may name without being wrong, because a believed value is off.
fn allowed(conditions: &Conditions) -> Vec<String> {
    let is_off = |factor: f64| factor.ln().abs() > MAY_BE_NAMED.ln();
    let mut allowed = Vec::new();
    if is_off(conditions.damping_factor) {
        allowed.push("viscous-friction".to_owned());
    }
    if conditions.friction_factor.is_some_and(is_off) {
        allowed.push("coulomb-friction".to_owned());
    }
    allowed
}

/// The effects hidden in case `index`.
fn recipes(
    index: usize,
    is_rotational: bool,
    is_known: &dyn Fn(&str) -> bool,
    random: &mut Random,
) -> Vec<&'static Recipe> {
    let (round, at) = (index / TURN, index % TURN);
    let nth = |turns: &[usize]| round * turns.len() + turns.iter().filter(|turn| **turn < at).count();
    if NOTHING.contains(&at) {
        return Vec::new();
    }
    if PAIRS.contains(&at) {
        let kind = BESIDE_FRICTION[random.pick(BESIDE_FRICTION.len())];
        return std::iter::once(&COULOMB).chain(SINGLE.iter().find(|recipe| recipe.kind == kind)).collect();
    }
    let (single, beyond) = alone(is_rotational, is_known);
    if NO_LIBRARY.contains(&at) && !beyond.is_empty() {
        return vec![beyond[nth(&NO_LIBRARY) % beyond.len()]];
    }
    let others = [NOTHING.as_slice(), &PAIRS, &NO_LIBRARY]
        .map(|turns| turns.iter().filter(|turn| **turn < at).count());
    let singles = TURN - NOTHING.len() - PAIRS.len() - NO_LIBRARY.len();
    let which = round * singles + at - others.iter().sum::<usize>();
    vec![single[which * STEP % single.len()]]
}

/// The kinds that such an axis may hide alone: those of the library, and those outside it.
fn alone(
    is_rotational: bool,
    is_known: &dyn Fn(&str) -> bool,
) -> (Vec<&'static Recipe>, Vec<&'static Recipe>) {
    let fits = BEYOND.iter().filter(|recipe| is_rotational || !recipe.only_rotational);
    let (known, beyond): (Vec<_>, Vec<_>) = fits.partition(|recipe| is_known(recipe.kind));
    (SINGLE.iter().chain(known).collect(), beyond)
}

/// The axis without hidden effects, and the magnitudes of its motion.
fn build(conditions: &Conditions, random: &mut Random) -> (Axis, Sizes) {
    let (mass, amplitude) = if conditions.is_rotational {
        (random.log_between(3e-3, 3.0), random.log_between(0.3, 1.5))
    } else {
        (random.log_between(1.0, 100.0), random.log_between(0.02, 0.4))
    };
    let omega = TAU * conditions.motion_hz;
    let inertial = mass * amplitude * omega * omega;
    let viscous = inertial * random.log_between(0.3, 5.0);
    let moving = inertial + viscous;
    let carried = moving * (1.0 + conditions.gravity_share.unwrap_or(0.0));
    let level = carried * conditions.friction_share / (1.0 - conditions.friction_share);
    let sizes = Sizes { amplitude, omega, moving, command: carried + level };
    let load_kg = mass * random.between(0.3, 0.7);
    let friction =
        Friction { level, bristle_m: amplitude * random.log_between(3e-4, 2e-3), ..Friction::default() };
    let axis = Axis {
        motor_kg: mass - load_kg,
        load_kg,
        damping: viscous / (amplitude * omega),
        friction,
        gravity: conditions.gravity_share.map(|share| gravity(&sizes, share, random)),
        ..Axis::default()
    };
    (axis, sizes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_in_library(kind: &str) -> bool {
        feeler_plant::effects::find(kind).is_some()
    }

    #[test]
    fn truth_what_is_hidden_is_named_as_the_library_names_it() {
        for recipe in SINGLE.iter().chain(BEYOND) {
            let (mut axis, sizes) = build(&draw_conditions(&mut Random::new(1)), &mut Random::new(2));
            let drawn = (recipe.apply)(&mut axis, &sizes, &mut Random::new(3));
            let Some(definition) = feeler_plant::effects::find(recipe.kind) else {
                assert!(BEYOND.iter().any(|beyond| beyond.kind == recipe.kind), "{}", recipe.kind);
                continue;
            };
            for (name, _) in drawn {
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
            (0..320).map(|i| draw(i, &mut Random::new(i as u64), &is_in_library).case).collect();
        let mut kinds: Vec<&str> = Vec::new();
        cases.iter().flat_map(|case| &case.effects).for_each(|effect| kinds.push(&effect.kind));
        kinds.sort_unstable();
        kinds.dedup();
        let mut wanted: Vec<&str> = SINGLE.iter().chain(BEYOND).map(|recipe| recipe.kind).collect();
        wanted.sort_unstable();
        wanted.dedup();
        assert_eq!(kinds, wanted);
        let of = |n: usize| cases.iter().filter(|case| case.effects.len() == n).count();
        assert_eq!([of(0), of(2)], [32, 64]);
    }

    #[test]
    fn truth_the_step_reaches_every_kind_that_is_hidden_alone() {
        for is_rotational in [false, true] {
            let (single, _) = alone(is_rotational, &is_in_library);
            assert_ne!(single.len() % STEP, 0, "{is_rotational}");
        }
    }

    #[test]
    fn prop_friction_has_its_share_of_the_largest_command() {
        for seed in 0..200 {
            let drawn = draw(0, &mut Random::new(seed), &is_in_library);
            let share = drawn.axis.friction.level / drawn.sizes.command;
            assert!((share - drawn.conditions.friction_share).abs() < 1e-12);
        }
    }
}
