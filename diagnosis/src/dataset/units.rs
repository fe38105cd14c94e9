//! Factors between units that are often confused.

use feeler_plant::description::Quantity;

/// Standard gravity, m/s².
const GRAVITY: f64 = 9.806_65;
/// Degrees in a radian.
const DEGREES: f64 = 57.295_779_5;
/// Newtons in a pound-force.
const POUND_N: f64 = 4.448_221_6;

/// Factors by which a reading in a wrong unit is too large, and the units.
fn factors(quantity: Quantity) -> &'static [(f64, &'static str)] {
    match quantity {
        Quantity::Position => &[
            (1e3, "1000 (mm for m?)"),
            (1e2, "100 (cm for m?)"),
            (DEGREES, "57.3 (degrees for radians?)"),
            (1e6, "a million (µm for m, or a clock in ms for s?)"),
            (1e-3, "1/1000 (is the other column in mm?)"),
        ],
        Quantity::Acceleration => &[
            (1e3, "1000 (mm/s² for m/s²?)"),
            (1e2, "100 (cm/s² for m/s²?)"),
            (1.0 / GRAVITY, "1/9.81 (g for m/s²?)"),
            (GRAVITY, "9.81 (converted from g twice?)"),
            (DEGREES, "57.3 (degrees for radians?)"),
            (1e-3, "1/1000 (is the other column in mm?)"),
            (1e-6, "a millionth (is the other column in µm, or the clock in ms?)"),
        ],
        _ => &[
            (1e-3, "1/1000 (kN for N?)"),
            (1e3, "1000 (mN for N?)"),
            (1.0 / GRAVITY, "1/9.81 (kgf for N?)"),
            (1.0 / POUND_N, "1/4.45 (lbf for N?)"),
        ],
    }
}

/// The units that a factor suggests, in words; `near` is its relative tolerance.
pub(super) fn mixed_up(factor: f64, quantity: Quantity, near: f64) -> Option<&'static str> {
    if factor < 0.0 {
        return ((-factor).ln().abs() < near.ln_1p()).then_some("-1 (a sign?)");
    }
    factors(quantity)
        .iter()
        .find(|(wanted, _)| (factor / wanted).ln().abs() < near.ln_1p())
        .map(|(_, what)| *what)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_units_are_told_by_their_factor_and_its_direction() {
        assert!(mixed_up(0.1, Quantity::Acceleration, 0.15).unwrap().contains("g for m/s²"));
        assert!(mixed_up(1020.0, Quantity::Position, 0.15).unwrap().contains("mm for m"));
        assert!(mixed_up(9.7e-4, Quantity::Force, 0.3).unwrap().contains("kN for N"));
        assert!(mixed_up(-1.02, Quantity::Position, 0.15).unwrap().contains("sign"));
        assert_eq!(mixed_up(1.3, Quantity::Force, 0.3), None);
    }
}
