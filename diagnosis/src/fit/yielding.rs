//! How guides with dry friction yield before they slide, as fitted.

use std::f64::consts::TAU;

use feeler_plant::assembly::Presliding;
use feeler_plant::description::Machine;
use feeler_plant::effects::{EffectUse, Kind};

use crate::fit::least_squares::Fitted;
use crate::fit::unknown::Target;

/// Records show the presliding of guides if they determine its frequency this well: its deviation over that
/// of the prior.
const SHOWN: f64 = 0.5;

/// The fitted presliding of a guide.
pub(crate) struct Yielding {
    /// Index of the spring.
    pub(crate) spring: usize,
    pub(crate) presliding: Presliding,
    /// Relative standard deviations of stiffness and damping ratio.
    pub(crate) sigma: [f64; 2],
}

impl Fitted {
    /// The guides that yield as fitted. Empty if the records do not show it, and for guides that state it.
    pub(crate) fn yielding(&self) -> Vec<Yielding> {
        let of = |target: Target| {
            let i = self.model.unknowns.iter().position(|unknown| unknown.target == target)?;
            let (unknown, theta) = (&self.model.unknowns[i], self.theta[i]);
            let sigma = *self.sigma.get(i)?;
            let is_shown = sigma < SHOWN * unknown.prior?.1 && !unknown.is_at_end(theta);
            Some((unknown.value(theta), sigma, is_shown))
        };
        let frequency = of(Target::PreslidingFrequency).filter(|(.., is_shown)| *is_shown);
        let (Some((hz, of_hz, _)), Some((damping_ratio, of_ratio, _))) =
            (frequency, of(Target::PreslidingDamping))
        else {
            return Vec::new();
        };
        let Some(assembly) = self.model.assembly(&self.theta, None) else { return Vec::new() };
        let springs = self.model.believed.springs.len();
        let dry = assembly.dry_guides().filter(|(i, link)| *i < springs && link.presliding.is_none());
        dry.map(|(spring, link)| {
            let stiffness = assembly.sliding_mass_kg(link) * (TAU * hz).powi(2);
            let presliding = Presliding { stiffness, damping_ratio };
            Yielding { spring, presliding, sigma: [2.0 * of_hz, of_ratio] }
        })
        .collect()
    }

    /// The fitted machine. Its guides state their presliding.
    pub(crate) fn machine(&self) -> Machine {
        let mut machine = self.model.machine(&self.theta);
        for Yielding { spring, presliding, .. } in self.yielding() {
            let values = vec![presliding.stiffness, presliding.damping_ratio];
            machine.springs[spring]
                .effects
                .push(EffectUse { definition: Kind::Presliding.definition(), values });
        }
        machine
    }
}
