//! Dry friction of a link.

use super::TabulatedForce;

/// Set-valued dry friction against the sliding speed `v = e'` of a link.
///
/// While sliding forward its magnitude is `forward + (static_forward - forward) exp(-(v/velocity)^2) +
/// load_ratio |F| + over(e)`; backward is analogous. At rest it takes any value up to the static level of its
/// direction. `|F|` is the sum of the sizes of all contact forces and weights of the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Level for `v > 0`, N.
    pub forward: f64,
    /// Level for `v < 0`, N.
    pub backward: f64,
    /// Excess of the static over the kinetic level (Stribeck), N; zero for a constant level.
    pub stribeck_excess: f64,
    /// Stribeck speed, m/s.
    pub stribeck_velocity: f64,
    /// Growth of the level with contact forces and weights.
    pub load_ratio: f64,
    /// A further level over the elongation of the link.
    pub over: Option<TabulatedForce>,
}

impl Friction {
    /// No friction.
    pub const NONE: Self = Self {
        forward: 0.0,
        backward: 0.0,
        stribeck_excess: 0.0,
        stribeck_velocity: 1.0,
        load_ratio: 0.0,
        over: None,
    };

    /// Whether any force can arise.
    pub fn acts(&self) -> bool {
        let levels = [self.forward, self.backward, self.stribeck_excess, self.load_ratio];
        levels.iter().any(|level| *level > 0.0) || self.over.is_some()
    }

    /// The same law with `share` of each level.
    #[must_use]
    pub fn scaled(&self, share: f64) -> Self {
        Self {
            forward: share * self.forward,
            backward: share * self.backward,
            stribeck_excess: share * self.stribeck_excess,
            load_ratio: share * self.load_ratio,
            over: self.over.map(|table| table.scaled(share)),
            ..*self
        }
    }
}
