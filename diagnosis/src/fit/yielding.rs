//! How guides with dry friction yield before they slide, as fitted.

use feeler_plant::assembly::{Link, Presliding};

use crate::fit::least_squares::Fitted;
use crate::fit::unknown::Target;
use crate::predict;

/// Records show the presliding of guides if they determine its frequency and damping ratio this well: the
/// deviation of each over that of its prior.
const SHOWN: f64 = 0.5;

/// The fitted presliding of a guide.
pub(crate) struct Yielding {
    /// Index of the spring.
    pub(crate) spring: usize,
    pub(crate) presliding: Presliding,
    /// Relative standard deviations of stiffness and damping ratio.
    pub(crate) sigma: [f64; 2],
    /// Largest deflection before sliding, m.
    pub(crate) deflection_m: f64,
}

impl Fitted {
    /// The guides that yield as fitted, for standard deviations `sigma` of all values. Empty if the records
    /// do not show it; guides that state it are left out.
    pub(crate) fn yielding(&self, sigma: &[f64]) -> Vec<Yielding> {
        let of = |target: Target| {
            let i = self.model.unknowns.iter().position(|unknown| unknown.target == target)?;
            let (unknown, theta, sigma) = (&self.model.unknowns[i], self.theta[i], *sigma.get(i)?);
            let is_shown = sigma < SHOWN * unknown.prior?.1 && !unknown.is_at_end(theta);
            is_shown.then(|| (unknown.value(theta), sigma))
        };
        let found = of(Target::PreslidingFrequency).zip(of(Target::PreslidingDamping));
        let Some(((frequency_hz, of_hz), (damping_ratio, of_ratio))) = found else { return Vec::new() };
        let fitted = predict::Presliding { frequency_hz, damping_ratio };
        let Some(assembly) = self.model.assembly(&self.theta, None) else { return Vec::new() };
        let springs = self.model.believed.springs.len();
        let yielding = |(spring, link): (usize, &Link)| {
            let presliding = fitted.of_mass(assembly.sliding_mass_kg(link));
            Yielding {
                spring,
                presliding,
                sigma: [2.0 * of_hz, of_ratio],
                deflection_m: link.friction.forward.max(link.friction.backward) / presliding.stiffness,
            }
        };
        let dry = assembly.dry_guides().filter(|(i, link)| *i < springs && link.presliding.is_none());
        dry.map(yielding).collect()
    }
}
