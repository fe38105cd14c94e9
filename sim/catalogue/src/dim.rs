//! Dimensions as real exponents, with their names and SI units on either axis.

use std::ops::{Div, Mul};

use crate::dimension::Dimension;

/// `kg^mass m^length s^time` of a translational axis. Exponents are real: a contact law `k d^n` takes N/m^n
/// with any `n`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dim {
    /// Exponent of mass.
    pub mass: f64,
    /// Exponent of the coordinate.
    pub length: f64,
    /// Exponent of time.
    pub time: f64,
    /// Any exponent of length will do.
    pub any_length: bool,
    /// Of a signal that is not known: anything will do.
    pub unknown: bool,
}

/// Exponents that differ by less are equal; files write them with two or three digits.
const EXPONENT_TOLERANCE: f64 = 1e-6;

/// Whether two exponents are equal but for the digits that files write.
pub fn same_exponent(a: f64, b: f64) -> bool {
    (a - b).abs() < EXPONENT_TOLERANCE
}

impl Dim {
    const fn new(mass: f64, length: f64, time: f64) -> Self {
        Self { mass, length, time, any_length: false, unknown: false }
    }

    /// N/m^n.
    pub const fn power_stiffness(exponent: f64) -> Self {
        Self::new(1.0, 1.0 - exponent, -2.0)
    }

    /// That of a signal which is not known, so that nothing is said of units that may be right.
    pub const UNKNOWN: Self = Self { mass: 0.0, length: 0.0, time: 0.0, any_length: false, unknown: true };

    /// Whether two dimensions are the same.
    pub fn is(self, other: Self) -> bool {
        let same = same_exponent(self.mass, other.mass)
            && same_exponent(self.time, other.time)
            && (self.any_length || other.any_length || same_exponent(self.length, other.length));
        same || self.unknown || other.unknown
    }

    /// What a quantity of this dimension is called.
    pub fn name(self, rotational: bool) -> Option<&'static str> {
        NAMES
            .iter()
            .find(|(dimension, ..)| Self::from(*dimension).is(self))
            .map(|(_, straight, rotary)| if rotational { *rotary } else { *straight })
    }

    /// SI unit, in the notation of files.
    pub fn si_unit(self, rotational: bool) -> String {
        let known = NAMES
            .iter()
            .map(|(dimension, ..)| *dimension)
            .find(|dimension| !self.any_length && Self::from(*dimension).is(self));
        if let Some(dimension) = known {
            return dimension.si_unit(rotational).to_owned();
        }
        if self.any_length {
            return Dimension::POWER_STIFFNESS.si_unit(rotational).to_owned();
        }
        // Writing force as a base unit, where mass occurs, keeps products short: (m/s)/N rather than s/kg.
        let (force, length, time) = (self.mass, self.length - self.mass, self.time + 2.0 * self.mass);
        let (newton, metre): (&[&str], &str) = if rotational { (&["N", "m"], "rad") } else { (&["N"], "m") };
        let mut above = Vec::new();
        let mut below = Vec::new();
        let factors = newton.iter().map(|unit| (*unit, force)).chain([(metre, length), ("s", time)]);
        for (unit, exponent) in factors.filter(|(_, exponent)| !same_exponent(*exponent, 0.0)) {
            let side = if exponent > 0.0 { &mut above } else { &mut below };
            let power = exponent.abs();
            side.push(if same_exponent(power, 1.0) { unit.to_owned() } else { format!("{unit}^{power}") });
        }
        match (above.is_empty(), below.as_slice()) {
            (_, []) => above.join(" "),
            (true, [one]) => format!("1/{one}"),
            (true, several) => format!("1/({})", several.join(" ")),
            (false, [one]) => format!("{}/{one}", above.join(" ")),
            (false, several) => format!("{}/({})", above.join(" "), several.join(" ")),
        }
    }

    /// "a length (m)", "a pure number", or just the unit.
    pub fn phrase(self, rotational: bool) -> String {
        match self.name(rotational) {
            Some(name) if self.is(Self::from(Dimension::NONE)) => name.to_owned(),
            Some(name) => format!("{name} ({})", self.si_unit(rotational)),
            None => format!("in {}", self.si_unit(rotational)),
        }
    }
}

impl From<Dimension> for Dim {
    fn from(dimension: Dimension) -> Self {
        let any_length = dimension.any_length;
        Self {
            mass: dimension.mass.into(),
            length: dimension.length.into(),
            time: dimension.time.into(),
            any_length,
            unknown: false,
        }
    }
}

impl Mul for Dim {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::new(self.mass + other.mass, self.length + other.length, self.time + other.time)
    }
}

impl Div for Dim {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        Self::new(self.mass - other.mass, self.length - other.length, self.time - other.time)
    }
}

/// Dimension, its name on a translational axis, its name on a rotational one.
const NAMES: &[(Dimension, &str, &str)] = &[
    (Dimension::NONE, "a pure number", "a pure number"),
    (Dimension::MASS, "a mass", "a moment of inertia"),
    (Dimension::LENGTH, "a length", "an angle"),
    (Dimension::TIME, "a time", "a time"),
    (Dimension::FREQUENCY, "a frequency", "a frequency"),
    (Dimension::VELOCITY, "a velocity", "an angular velocity"),
    (Dimension::ACCELERATION, "an acceleration", "an angular acceleration"),
    (Dimension::INVERSE_VELOCITY, "an inverse velocity", "an inverse angular velocity"),
    (Dimension::FORCE, "a force", "a torque"),
    (Dimension::FORCE_RATE, "a force rate", "a torque rate"),
    (Dimension::STIFFNESS, "a stiffness", "a torsional stiffness"),
    (Dimension::CUBIC_STIFFNESS, "a cubic stiffness", "a cubic torsional stiffness"),
    (Dimension::DAMPING, "a damping", "a torsional damping"),
];
