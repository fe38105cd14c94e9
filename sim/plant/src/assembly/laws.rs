//! Nonlinear laws of position and speed.

use std::f64::consts::TAU;

use super::{NodeId, TabulatedForce};

/// A force `amplitude * sin(2 pi x / pitch + phase)` of the drive's relative position `x`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ripple {
    /// N.
    pub amplitude: f64,
    /// m.
    pub pitch: f64,
    /// rad.
    pub phase: f64,
}

/// A force on one node and its opposite on another, as a function of their relative position.
#[derive(Clone, Debug, PartialEq)]
pub struct Weight {
    /// Name of the body or of the effect's host.
    pub name: String,
    /// Node that is pulled.
    pub on: NodeId,
    /// Node that carries the reaction.
    pub reacts_on: NodeId,
    /// Whether the earth pulls a body: its reaction stays on ground, whatever carries the machine.
    pub is_of_earth: bool,
    /// Force over the relative position.
    pub course: PositionForce,
}

/// A force over position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PositionForce {
    /// A weight on a lever.
    Pull(Pull),
    /// A force of a guide, by its values at some points.
    Table(TabulatedForce),
}

impl PositionForce {
    /// The force at a position, N.
    pub fn force(&self, x: f64) -> f64 {
        match self {
            Self::Pull(pull) => pull.force(x),
            Self::Table(table) => table.force(x),
        }
    }

    /// The weight on a lever, if it is one.
    pub fn pull(&self) -> Option<Pull> {
        match self {
            Self::Pull(pull) => Some(*pull),
            Self::Table(_) => None,
        }
    }

    /// Derivative of the force by position, N/m.
    pub fn slope(&self, x: f64) -> f64 {
        match self {
            Self::Pull(pull) => pull.slope(x),
            Self::Table(table) => table.slope(x),
        }
    }

    /// Potential energy, J, up to a constant.
    pub fn potential(&self, x: f64) -> f64 {
        match self {
            Self::Pull(pull) => pull.potential(x),
            Self::Table(table) => table.potential(x),
        }
    }

    /// A bound on the slope, N/m.
    pub fn stiffness(&self) -> f64 {
        match self {
            Self::Pull(pull) => pull.stiffness(),
            Self::Table(table) => table.stiffness(),
        }
    }
}

/// A force `-amplitude * sin(2 pi x / period + phase)`: a weight on a lever that turns once per period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull {
    /// N.
    pub amplitude: f64,
    /// m.
    pub period: f64,
    /// rad.
    pub phase: f64,
}

impl Pull {
    fn angle(&self, x: f64) -> f64 {
        TAU * x / self.period + self.phase
    }

    /// The force at a position, N.
    pub fn force(&self, x: f64) -> f64 {
        -self.amplitude * self.angle(x).sin()
    }

    /// Derivative of the force by position, N/m.
    pub fn slope(&self, x: f64) -> f64 {
        -self.stiffness() * self.angle(x).cos()
    }

    /// Potential energy above the lowest position, J.
    pub fn potential(&self, x: f64) -> f64 {
        self.amplitude * self.period / TAU * (1.0 - self.angle(x).cos())
    }

    /// The largest slope, N/m.
    pub fn stiffness(&self) -> f64 {
        self.amplitude * TAU / self.period
    }
}

/// Bristles that bend by `z` under a sliding speed `v` (LuGre): `z' = v - stiffness |v| / g(v) z`. The
/// friction force is `stiffness z + damping z'`, with `g(v) = coulomb + (static - coulomb) exp(-(v /
/// velocity)^2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bristle {
    /// N/m.
    pub stiffness: f64,
    /// N s/m.
    pub damping: f64,
    /// Level far above the Stribeck speed, N.
    pub coulomb: f64,
    /// Level at rest less `coulomb`, N.
    pub excess: f64,
    /// Stribeck speed, m/s.
    pub velocity: f64,
}

impl Bristle {
    /// `g(v)`, N.
    pub fn level(&self, v: f64) -> f64 {
        self.coulomb + self.falling(v)
    }

    /// Excess of the level over `coulomb` at a speed, N.
    fn falling(&self, v: f64) -> f64 {
        self.excess * (-(v / self.velocity).powi(2)).exp()
    }

    /// Rate at which bristles with deflection `z` straighten at a speed `v > 0`, m/s: `stiffness v z / g(v)`.
    pub fn slip(&self, v: f64, z: f64) -> f64 {
        self.stiffness * v * z / self.level(v)
    }

    /// Derivatives of [`Self::slip`] by `v` and by `z`.
    pub(crate) fn slip_slopes(&self, v: f64, z: f64) -> [f64; 2] {
        let level = self.level(v);
        let level_slope = -2.0 * v / self.velocity.powi(2) * self.falling(v);
        let by_z = self.stiffness * v / level;
        [self.stiffness * z / level * (1.0 - v * level_slope / level), by_z]
    }
}
