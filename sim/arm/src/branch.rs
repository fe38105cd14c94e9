//! A body of an axis in addition to motor and tool.

use std::f64::consts::TAU;

/// A body on a spring at the motor: flexibility that loads the drive. If it moves the tool as well, a second
/// spring joins the two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branch {
    /// Mass of the body, kg.
    pub mass_kg: f64,
    /// Stiffness of the spring to the motor.
    pub stiffness_n_per_m: f64,
    /// Damping of the spring to the motor.
    pub damping_n_s_per_m: f64,
    /// Stiffness of its spring to the tool; zero without one.
    pub to_tool_n_per_m: f64,
    /// Damping of the spring to the tool.
    pub to_tool_n_s_per_m: f64,
}

impl Branch {
    /// Its undamped frequency, with motor and tool held.
    pub fn frequency_hz(&self) -> f64 {
        ((self.stiffness_n_per_m + self.to_tool_n_per_m) / self.mass_kg).sqrt() / TAU
    }

    /// A body without a spring to the tool.
    pub(crate) fn beside(mass_kg: f64, stiffness_n_per_m: f64, damping_n_s_per_m: f64) -> Self {
        Self { mass_kg, stiffness_n_per_m, damping_n_s_per_m, to_tool_n_per_m: 0.0, to_tool_n_s_per_m: 0.0 }
    }

    /// Whether a spring joins it to the tool.
    pub fn is_linked(&self) -> bool {
        self.to_tool_n_per_m > 0.0 || self.to_tool_n_s_per_m > 0.0
    }

    /// Its lag behind an accelerating motor, weighted by its mass, kg s².
    pub(crate) fn lag(&self) -> f64 {
        self.mass_kg * self.mass_kg / self.stiffness_n_per_m
    }
}
