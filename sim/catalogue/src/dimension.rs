//! Physical dimensions, as exponents of kilogram, metre (or radian on a rotational axis), second and ampere,
//! with their names and SI units on either axis.

use std::borrow::Cow;
use std::fmt;
use std::ops::{Div, Mul};

/// `kg^mass m^length s^time A^current`; a rotational axis reads kg m² for kg, rad for m. Exponents are real:
/// a contact law `k d^n` takes N/m^n with any `n`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dimension {
    /// Exponent of mass.
    pub mass: f64,
    /// Exponent of the coordinate.
    pub length: f64,
    /// Exponent of time.
    pub time: f64,
    /// Exponent of electric current.
    pub current: f64,
    /// For laws `F = k d^n` the stiffness is N/m^n with `n` from the file: any exponent of length is then
    /// valid.
    pub any_length: bool,
    /// Dimension of an unknown signal: any dimension is then valid.
    pub unknown: bool,
}

/// Exponents with a smaller difference are equal; files have two or three digits.
const EXPONENT_TOLERANCE: f64 = 1e-6;

/// Whether two exponents are equal to the precision of files.
pub fn same_exponent(a: f64, b: f64) -> bool {
    (a - b).abs() < EXPONENT_TOLERANCE
}

impl Dimension {
    /// `kg^mass m^length s^time`.
    pub const fn new(mass: f64, length: f64, time: f64) -> Self {
        Self { mass, length, time, current: 0.0, any_length: false, unknown: false }
    }

    const fn electric(mass: f64, length: f64, time: f64, current: f64) -> Self {
        Self { current, ..Self::new(mass, length, time) }
    }

    /// A pure number (radians of phase count as such).
    pub const NONE: Self = Self::new(0.0, 0.0, 0.0);
    /// The dimension of an unknown signal, for which every unit is accepted.
    pub const UNKNOWN: Self = Self { unknown: true, ..Self::NONE };
    /// kg.
    pub const MASS: Self = Self::new(1.0, 0.0, 0.0);
    /// m.
    pub const LENGTH: Self = Self::new(0.0, 1.0, 0.0);
    /// s.
    pub const TIME: Self = Self::new(0.0, 0.0, 1.0);
    /// Hz.
    pub const FREQUENCY: Self = Self::new(0.0, 0.0, -1.0);
    /// m/s.
    pub const VELOCITY: Self = Self::new(0.0, 1.0, -1.0);
    /// m/s².
    pub const ACCELERATION: Self = Self::new(0.0, 1.0, -2.0);
    /// s/m.
    pub const INVERSE_VELOCITY: Self = Self::new(0.0, -1.0, 1.0);
    /// N.
    pub const FORCE: Self = Self::new(1.0, 1.0, -2.0);
    /// N/s.
    pub const FORCE_RATE: Self = Self::new(1.0, 1.0, -3.0);
    /// N/m.
    pub const STIFFNESS: Self = Self::power_stiffness(1.0);
    /// N/m³.
    pub const CUBIC_STIFFNESS: Self = Self::power_stiffness(3.0);
    /// N s²/m².
    pub const DRAG: Self = Self::new(1.0, -1.0, 0.0);
    /// N/m^n for any `n`.
    pub const POWER_STIFFNESS: Self = Self { any_length: true, ..Self::STIFFNESS };
    /// N s/m.
    pub const DAMPING: Self = Self::new(1.0, 0.0, -1.0);
    /// N/(m s): from the integral of a position error to a force.
    pub const STIFFNESS_RATE: Self = Self::new(1.0, 0.0, -3.0);
    /// A.
    pub const CURRENT: Self = Self::electric(0.0, 0.0, 0.0, 1.0);
    /// V.
    pub const VOLTAGE: Self = Self::electric(1.0, 2.0, -3.0, -1.0);
    /// ohm.
    pub const RESISTANCE: Self = Self::electric(1.0, 2.0, -3.0, -2.0);
    /// H.
    pub const INDUCTANCE: Self = Self::electric(1.0, 2.0, -2.0, -2.0);
    /// N/A, which is V s/m.
    pub const FORCE_PER_CURRENT: Self = Self::electric(1.0, 1.0, -2.0, -1.0);

    /// N/m^n.
    pub const fn power_stiffness(exponent: f64) -> Self {
        Self::new(1.0, 1.0 - exponent, -2.0)
    }

    /// Whether two dimensions are the same.
    pub fn is(self, other: Self) -> bool {
        let same = same_exponent(self.mass, other.mass)
            && same_exponent(self.time, other.time)
            && same_exponent(self.current, other.current)
            && (self.any_length || other.any_length || same_exponent(self.length, other.length));
        same || self.unknown || other.unknown
    }

    fn named(self) -> Option<&'static Named> {
        NAMED.iter().find(|named| named.dimension.any_length == self.any_length && named.dimension.is(self))
    }

    /// The SI unit on a translational (or rotational) axis, in the notation of files.
    pub fn si_unit(self, rotational: bool) -> Cow<'static, str> {
        self.named().map_or_else(|| self.product(rotational).into(), |named| named.on(rotational)[1].into())
    }

    /// The SI unit of a named dimension; empty for any other.
    pub fn named_unit(self, rotational: bool) -> &'static str {
        self.named().map_or("", |named| named.on(rotational)[1])
    }

    /// Its unit as a product of base units. If mass occurs, force replaces it as a base unit, which keeps
    /// products short: (m/s)/N rather than s/kg.
    fn product(self, rotational: bool) -> String {
        let (force, length, time) = (self.mass, self.length - self.mass, self.time + 2.0 * self.mass);
        let (newton, metre): (&[&str], &str) = if rotational { (&["N", "m"], "rad") } else { (&["N"], "m") };
        let mut above = Vec::new();
        let mut below = Vec::new();
        let others = [(metre, length), ("s", time), ("A", self.current)];
        let factors = newton.iter().map(|unit| (*unit, force)).chain(others);
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
        match self.named().map(|named| named.on(rotational)) {
            Some([name, ""]) => name.to_owned(),
            Some([name, unit]) => format!("{name} ({unit})"),
            None => format!("in {}", self.si_unit(rotational)),
        }
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.si_unit(false))
    }
}

impl Mul for Dimension {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let [mass, length] = [self.mass + other.mass, self.length + other.length];
        Self::electric(mass, length, self.time + other.time, self.current + other.current)
    }
}

impl Div for Dimension {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let [mass, length] = [self.mass - other.mass, self.length - other.length];
        Self::electric(mass, length, self.time - other.time, self.current - other.current)
    }
}

/// A named dimension: its name, and its SI unit on a translational and on a rotational axis.
struct Named {
    dimension: Dimension,
    translational: [&'static str; 2],
    rotational: [&'static str; 2],
}

impl Named {
    fn on(&self, rotational: bool) -> [&'static str; 2] {
        if rotational { self.rotational } else { self.translational }
    }
}

const fn named(
    dimension: Dimension,
    translational: [&'static str; 2],
    rotational: [&'static str; 2],
) -> Named {
    Named { dimension, translational, rotational }
}

const NAMED: &[Named] = &[
    named(Dimension::NONE, ["a pure number", ""], ["a pure number", ""]),
    named(Dimension::MASS, ["a mass", "kg"], ["a moment of inertia", "kg m2"]),
    named(Dimension::LENGTH, ["a length", "m"], ["an angle", "rad"]),
    named(Dimension::TIME, ["a time", "s"], ["a time", "s"]),
    named(Dimension::FREQUENCY, ["a frequency", "Hz"], ["a frequency", "Hz"]),
    named(Dimension::VELOCITY, ["a velocity", "m/s"], ["an angular velocity", "rad/s"]),
    named(Dimension::ACCELERATION, ["an acceleration", "m/s2"], ["an angular acceleration", "rad/s2"]),
    named(
        Dimension::INVERSE_VELOCITY,
        ["an inverse velocity", "s/m"],
        ["an inverse angular velocity", "s/rad"],
    ),
    named(Dimension::FORCE, ["a force", "N"], ["a torque", "N m"]),
    named(Dimension::FORCE_RATE, ["a force rate", "N/s"], ["a torque rate", "N m/s"]),
    named(Dimension::STIFFNESS, ["a stiffness", "N/m"], ["a torsional stiffness", "N m/rad"]),
    named(
        Dimension::CUBIC_STIFFNESS,
        ["a cubic stiffness", "N/m3"],
        ["a cubic torsional stiffness", "N m/rad3"],
    ),
    named(
        Dimension::DRAG,
        ["a drag over the square of speed", "N s2/m2"],
        ["a drag over the square of angular velocity", "N m s2/rad2"],
    ),
    named(Dimension::POWER_STIFFNESS, ["a stiffness", "N/m^n"], ["a torsional stiffness", "N m/rad^n"]),
    named(Dimension::DAMPING, ["a damping", "N s/m"], ["a torsional damping", "N m s/rad"]),
    named(Dimension::STIFFNESS_RATE, ["an integral gain", "N/(m s)"], ["an integral gain", "N m/(rad s)"]),
    named(Dimension::CURRENT, ["a current", "A"], ["a current", "A"]),
    named(Dimension::VOLTAGE, ["a voltage", "V"], ["a voltage", "V"]),
    named(Dimension::RESISTANCE, ["a resistance", "ohm"], ["a resistance", "ohm"]),
    named(Dimension::INDUCTANCE, ["an inductance", "H"], ["an inductance", "H"]),
    named(Dimension::FORCE_PER_CURRENT, ["a force constant", "N/A"], ["a torque constant", "N m/A"]),
];
