//! Factors between units that are often confused.

use feeler_plant::description::Quantity;

/// Standard gravity, m/s².
const GRAVITY: f64 = 9.806_65;
/// Degrees per radian.
const DEGREES: f64 = 57.295_779_5;
/// Newtons per pound-force.
const POUND_N: f64 = 4.448_221_6;

/// Counts of a fine encoder per radian.
const STEPS: f64 = 4096.0 / std::f64::consts::TAU;
/// Largest plausible ratio of two columns of one machine: beyond it, one of them is in a wrong unit.
const HOPELESS: f64 = 50.0;
/// Largest plausible ratio between a driving force and a motion: against gravity the force may be a hundred
/// times the inertial force of a slow motion.
const HOPELESS_PUSH: f64 = 1e4;

/// The factor equals the column's own `unit` and `scale`.
pub(super) const STATED: &str = "its own `unit` or `scale` (are its numbers in SI already?)";
/// The reading is too small by a factor between units.
const TOO_SMALL: &str = "the inverse of a factor between units (converted twice?)";
/// The factor belongs to no common unit.
pub(super) const COUNTS: &str = "no factor of common units (counts?)";
/// The factor of a command belongs to no common unit, and is too small for counts.
pub(super) const CURRENT: &str = "no factor of common units (a current for a force, or a mass that the \
                                  machine file lacks?)";

/// A column of a comparison.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading<'a> {
    /// Header of the column.
    pub(super) column: &'a str,
    /// The stated quantity.
    pub(super) quantity: Quantity,
    /// The factor from the stated unit and scale.
    pub(super) scale: f64,
    /// Whether the axis turns, so that positions are angles.
    pub(super) is_turning: bool,
}

/// Factors by which a reading in a wrong unit is too large, and the units.
fn factors(quantity: Quantity) -> &'static [(f64, &'static str)] {
    match quantity {
        Quantity::Position => &[
            (1e3, "1000 (mm for m?)"),
            (1e2, "100 (cm for m?)"),
            (1e6, "a million (µm for m, or a clock in ms for s?)"),
        ],
        Quantity::Velocity => &[(1e3, "1000 (mm/s for m/s?)"), (1e2, "100 (cm/s for m/s?)")],
        Quantity::Acceleration => &[
            (1e3, "1000 (mm/s² for m/s²?)"),
            (1e2, "100 (cm/s² for m/s²?)"),
            (1.0 / GRAVITY, "1/9.81 (g for m/s²?)"),
            (GRAVITY, "9.81 (converted from g twice?)"),
        ],
        _ => &[
            (1e-3, "1/1000 (kN for N?)"),
            (1e3, "1000 (mN for N?)"),
            (1.0 / GRAVITY, "1/9.81 (kgf for N?)"),
            (1.0 / POUND_N, "1/4.45 (lbf for N?)"),
        ],
    }
}

/// The same for angles.
fn factors_of_angles(quantity: Quantity) -> &'static [(f64, &'static str)] {
    match quantity {
        Quantity::Position => {
            &[(DEGREES, "57.3 (degrees for radians?)"), (STEPS, "652 (counts of 4096 a turn for radians?)")]
        }
        Quantity::Velocity => &[
            (DEGREES, "57.3 (degrees for radians?)"),
            (30.0 / std::f64::consts::PI, "9.55 (turns a minute for rad/s?)"),
        ],
        Quantity::Acceleration => &[(DEGREES, "57.3 (degrees for radians?)")],
        _ => &[],
    }
}

/// A reversed sign, in words.
pub(super) const SIGN: &str = "-1 (a sign?)";

/// The confused units that a factor suggests, in words; `near` is its relative tolerance.
fn mixed_up(factor: f64, reading: Reading<'_>, near: f64) -> Option<&'static str> {
    if factor < 0.0 {
        return ((-factor).ln().abs() < near.ln_1p()).then_some(SIGN);
    }
    let off = |wanted: f64| (factor / wanted).ln().abs();
    let angles = if reading.is_turning { factors_of_angles(reading.quantity) } else { &[] };
    (factors(reading.quantity).iter().chain(angles))
        .filter(|(wanted, _)| off(*wanted) < near.ln_1p())
        .min_by(|a, b| off(a.0).total_cmp(&off(b.0)))
        .map(|(_, what)| *what)
}

/// Whether a factor between two columns is the stated scale of the first.
pub(super) fn is_stated(factor: f64, scale: f64, near: f64) -> bool {
    let rest = factor / scale;
    let is_close = rest > 0.0 && rest.ln().abs() < near.ln_1p();
    is_close && (scale < 0.0 || scale.ln().abs() > 2.0 * near.ln_1p())
}

/// The wrong one of two columns of one motion, from the ratio of the first to the second (`true` for the
/// second), and the reason. If the second is known to be right, the first is wrong.
pub(super) fn wrong(
    [first, second]: [Reading<'_>; 2],
    factor: f64,
    near: f64,
    is_second_right: bool,
) -> Option<(bool, &'static str)> {
    if is_stated(factor, first.scale, near) {
        return Some((false, STATED));
    }
    if !is_second_right && is_stated(1.0 / factor, second.scale, near) {
        return Some((true, STATED));
    }
    if let Some(what) = mixed_up(factor, first, near) {
        return Some((false, what));
    }
    if factor < 0.0 {
        return None;
    }
    // Smaller ratios may be a property of the machine.
    let inverse =
        mixed_up(1.0 / factor, second, near).filter(|_| !(1.0 / HOPELESS..HOPELESS).contains(&factor));
    let is_push = |reading: &Reading<'_>| matches!(reading.quantity, Quantity::Command | Quantity::Force);
    let hopeless = if [first, second].iter().any(is_push) { HOPELESS_PUSH } else { HOPELESS };
    match inverse {
        Some(what) if !is_second_right => Some((true, what)),
        Some(_) if !is_push(&first) => Some((false, TOO_SMALL)),
        // The column with the larger numbers holds counts.
        _ if factor > hopeless => Some((false, COUNTS)),
        _ if factor < 1.0 / hopeless && !is_second_right => Some((true, COUNTS)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_units_are_told_by_their_factor_and_its_direction() {
        let named = |factor, quantity, near| mixed_up(factor, reading(quantity, 1.0), near).unwrap();
        assert!(named(0.1, Quantity::Acceleration, 0.15).contains("g for m/s²"));
        assert!(named(1020.0, Quantity::Position, 0.15).contains("mm for m"));
        assert!(named(9.7e-4, Quantity::Force, 0.3).contains("kN for N"));
        assert!(named(-1.02, Quantity::Position, 0.15).contains("sign"));
        assert_eq!(mixed_up(1.3, reading(Quantity::Force, 1.0), 0.3), None);
        // A length is not in degrees, nor in counts of a turn.
        let length = Reading { is_turning: false, ..reading(Quantity::Position, 1.0) };
        assert_eq!(mixed_up(DEGREES, length, 0.15), None);
        assert!(mixed_up(785.0, length, 0.3).unwrap().contains("mm for m"));
        assert!(named(785.0, Quantity::Position, 0.3).contains("4096"));
    }

    fn reading(quantity: Quantity, scale: f64) -> Reading<'static> {
        Reading { column: "a", quantity, scale, is_turning: true }
    }

    #[test]
    fn truth_the_column_that_one_factor_mends_is_the_wrong_one() {
        let pair =
            |first, second| [reading(Quantity::Position, first), reading(Quantity::Acceleration, second)];
        // Numbers in metres with a stated `unit = "mm"`; then an accelerometer with `unit = "mm/s2"`.
        assert_eq!(wrong(pair(1e-3, 1.0), 0.98e-3, 0.15, false), Some((false, STATED)));
        assert_eq!(wrong(pair(1.0, 1e-3), 1.02e3, 0.15, false), Some((true, STATED)));
        // Without a stated unit, the column with larger numbers is in a unit smaller than SI.
        let of = |factor, is_right| wrong(pair(1.0, 1.0), factor, 0.15, is_right);
        assert!(of(1e3, false).is_some_and(|(second, what)| !second && what.contains("mm for m")));
        assert!(of(1e-3, false).is_some_and(|(second, what)| second && what.contains("mm/s²")));
        assert_eq!(of(1e-3, true), Some((false, TOO_SMALL)));
        assert_eq!([of(1.0, false), of(0.3, false), of(4.45, false)], [None; 3]);
        // Counts of a converter, in a motion or in a force.
        assert_eq!([of(2e5, false), of(5e-6, false)], [Some((false, COUNTS)), Some((true, COUNTS))]);
        let pushed = |factor| {
            wrong([reading(Quantity::Command, 1.0), reading(Quantity::Acceleration, 1.0)], factor, 0.3, true)
        };
        assert_eq!([pushed(2e5), pushed(200.0)], [Some((false, COUNTS)), None]);
    }

    #[test]
    fn truth_targets_and_positions_accuse_the_one_with_the_larger_numbers() {
        let pair = [reading(Quantity::Position, 1.0); 2];
        for (size, words) in [(DEGREES, "degrees"), (STEPS, "4096"), (1e3, "mm for m"), (8e4, "counts?")] {
            let named = |factor, is_second| {
                wrong(pair, factor, 0.3, false)
                    .is_some_and(|(second, what)| second == is_second && what.contains(words))
            };
            assert!(named(0.9 * size, false) && named(1.1 / size, true), "{size}");
        }
        assert!(wrong(pair, -0.9, 0.3, false).is_some_and(|(_, what)| what.contains("a sign")));
        // A servo that moves by half its target.
        assert_eq!(wrong(pair, 0.5, 0.3, false), None);
    }
}
