//! `backlash`: free play.

use feeler_plant::effects::{Backlash, Host, Kind, Parameters};

use super::start::mode;
use super::{Element, Glance, Known, Seen};

/// Trial frequencies of two bodies in contact at their flanks, Hz.
const FLANKS_HZ: [f64; 3] = [100.0, 250.0, 600.0];
/// Initial ratio of the flanks' stiffness times the play to the largest command.
const STIFF: f64 = 10.0;
/// A play counts as zero if this share of the largest command deflects the flanks by more.
const LEAST_PLAY: f64 = 0.01;

impl Known for Backlash {
    const APART: &'static [(Kind, &'static str)] =
        &[(Kind::SurfaceOffset, "reverse the force while the tool stays in contact: only free play shows")];

    fn starts(element: &Element<'_>, glance: &Glance) -> Vec<Self> {
        let (Some(assembly), Host::Spring(i)) = (element.assembly(), element.host) else { return Vec::new() };
        let link = &assembly.links[i];
        let [a, b] = [link.a, link.b].map(|node| assembly.nodes[node].mass_kg);
        let flanks = FLANKS_HZ.map(|frequency_hz| mode(a * b / (a + b), frequency_hz, 0.05));
        let at = |width: f64| flanks.map(|(stiffness, damping)| Self { width, stiffness, damping });
        // For an axis with a long stroke, in units of that stroke: the largest command deflects the flanks by
        // a tenth of the play.
        let reduced = a * b / (a + b);
        let coarse = [0.003, 0.01, 0.03].map(|share| share * glance.stroke()).into_iter().map(|width| {
            let stiffness = STIFF * glance.command / width.max(f64::MIN_POSITIVE);
            Self { width, stiffness, damping: 0.2 * (stiffness * reduced).sqrt() }
        });
        // Sensors on both bodies measure the play directly.
        let seen = glance.elongation(element.host).into_iter();
        let seen = seen.flat_map(|range| [range, 0.9 * range]).flat_map(at);
        let fine = [1.0, 4.0, 15.0].into_iter().flat_map(|factor| at(factor * Self::typical().width));
        fine.chain(coarse).chain(seen).filter(|own| own.width > 0.0 && own.stiffness.is_finite()).collect()
    }

    fn is_trivial(self, _: &Element<'_>, seen: Seen) -> bool {
        seen.is_lost(self.width) || self.width * self.stiffness < LEAST_PLAY * seen.command_n
    }
}
