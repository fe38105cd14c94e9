//! Contacts between tool and workpiece.

use crate::effects::EffectUse;

/// The force sensor as the paper draws it (Fig. 1): a spring `k_s`, `b_s` between tip and workpiece,
/// compressed by `d = x_tip - x_work - gap`.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Tip and workpiece (or ground).
    pub between: [String; 2],
    /// Whether the two are attached, push only, or never meet.
    pub engagement: Engagement,
    /// Force against compression and its rate.
    pub law: ContactLaw,
    /// `k`: N/m, or N/m^exponent for a power law.
    pub stiffness: f64,
    /// Linear damping `c`, N s/m.
    pub damping_n_s_per_m: f64,
    /// Distance to close before tip and workpiece touch, at zero positions.
    pub gap_m: f64,
    /// Departures from the ideal contact.
    pub effects: Vec<EffectUse>,
}

impl Contact {
    /// A linear contact that pushes only and whose tip and workpiece touch at zero positions.
    pub fn kelvin_voigt(
        tip: impl Into<String>,
        workpiece: impl Into<String>,
        stiffness_n_per_m: f64,
        damping_n_s_per_m: f64,
    ) -> Self {
        Self {
            between: [tip.into(), workpiece.into()],
            engagement: Engagement::Unilateral,
            law: ContactLaw::KelvinVoigt,
            stiffness: stiffness_n_per_m,
            damping_n_s_per_m,
            gap_m: 0.0,
            effects: Vec::new(),
        }
    }
}

/// How tip and workpiece hold on to each other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Engagement {
    /// Bilateral, attached where the bodies stand at the start; the gap counts as zero.
    Clamped,
    /// Pushes only.
    #[default]
    Unilateral,
    /// Absent.
    Free,
}

/// Contact force against compression `d` and its rate, for `d > 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactLaw {
    /// `k d + c d'`.
    KelvinVoigt,
    /// `k d^n (1 + alpha d')`.
    HuntCrossley {
        /// `alpha`, s/m, >= 0.
        alpha_s_per_m: f64,
        /// `n`, >= 1.
        exponent: f64,
    },
    /// `k d^1.5 + c d'` (c usually zero).
    Hertz,
}
