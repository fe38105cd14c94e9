//! Physical dimensions, as exponents of kilogram, metre (or radian on a rotational axis) and second.

use std::fmt;

/// `kg^mass m^length s^time`; a rotational axis reads kg m² for kg, rad for m.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Dimension {
    /// Exponent of mass.
    pub mass: i8,
    /// Exponent of the coordinate.
    pub length: i8,
    /// Exponent of time.
    pub time: i8,
    /// For laws `F = k d^n`, the stiffness is N/m^n with `n` from the file: any exponent of length is then
    /// right.
    pub any_length: bool,
}

impl Dimension {
    const fn new(mass: i8, length: i8, time: i8) -> Self {
        Self { mass, length, time, any_length: false }
    }

    /// A pure number (radians of phase count as such).
    pub const NONE: Self = Self::new(0, 0, 0);
    /// kg.
    pub const MASS: Self = Self::new(1, 0, 0);
    /// m.
    pub const LENGTH: Self = Self::new(0, 1, 0);
    /// s.
    pub const TIME: Self = Self::new(0, 0, 1);
    /// Hz.
    pub const FREQUENCY: Self = Self::new(0, 0, -1);
    /// m/s.
    pub const VELOCITY: Self = Self::new(0, 1, -1);
    /// m/s².
    pub const ACCELERATION: Self = Self::new(0, 1, -2);
    /// s/m.
    pub const INVERSE_VELOCITY: Self = Self::new(0, -1, 1);
    /// N.
    pub const FORCE: Self = Self::new(1, 1, -2);
    /// N/s.
    pub const FORCE_RATE: Self = Self::new(1, 1, -3);
    /// N/m.
    pub const STIFFNESS: Self = Self::new(1, 0, -2);
    /// N/m³.
    pub const CUBIC_STIFFNESS: Self = Self::new(1, -2, -2);
    /// N/m^n for any `n`.
    pub const POWER_STIFFNESS: Self = Self { any_length: true, ..Self::STIFFNESS };
    /// N/m².
    pub const PRESSURE: Self = Self::new(1, -1, -2);
    /// N s/m.
    pub const DAMPING: Self = Self::new(1, 0, -1);

    /// The SI unit on a translational (or rotational) axis.
    pub fn si_unit(self, rotational: bool) -> &'static str {
        let (translational, rotary) = match self {
            Self::NONE => ("", ""),
            Self::MASS => ("kg", "kg m2"),
            Self::LENGTH => ("m", "rad"),
            Self::TIME => ("s", "s"),
            Self::FREQUENCY => ("Hz", "Hz"),
            Self::VELOCITY => ("m/s", "rad/s"),
            Self::ACCELERATION => ("m/s2", "rad/s2"),
            Self::INVERSE_VELOCITY => ("s/m", "s/rad"),
            Self::FORCE => ("N", "N m"),
            Self::FORCE_RATE => ("N/s", "N m/s"),
            Self::STIFFNESS => ("N/m", "N m/rad"),
            Self::CUBIC_STIFFNESS => ("N/m3", "N m/rad3"),
            Self::POWER_STIFFNESS => ("N/m^n", "N m/rad^n"),
            Self::PRESSURE => ("N/m2", "N/m2"),
            Self::DAMPING => ("N s/m", "N m s/rad"),
            _ => ("SI", "SI"),
        };
        if rotational { rotary } else { translational }
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.si_unit(false))
    }
}
