//! `backlash`: free play.

use feeler_plant::effects::{Backlash, Host, Kind, Parameters};

use super::start::mode;
use super::{Element, Glance, Known, Seen};

/// Frequencies of two bodies on their flanks that are tried.
const FLANKS_HZ: [f64; 3] = [100.0, 250.0, 600.0];
/// Free play that this share of the largest command would take up in a spring of the flanks' stiffness is
/// none.
const LEAST_PLAY: f64 = 0.01;

impl Known for Backlash {
    const APART: &'static [(Kind, &'static str)] =
        &[(Kind::SurfaceOffset, "reverse the force while the tool stays in contact: only free play shows")];

    fn starts(element: &Element<'_>, _: &Glance) -> Vec<Self> {
        let (Some(assembly), Host::Spring(i)) = (element.assembly(), element.host) else { return Vec::new() };
        let link = &assembly.links[i];
        let [a, b] = [link.a, link.b].map(|node| assembly.nodes[node].mass_kg);
        let flanks = FLANKS_HZ.map(|frequency_hz| mode(a * b / (a + b), frequency_hz, 0.05));
        let at = |width: f64| flanks.map(|(stiffness, damping)| Self { width, stiffness, damping });
        [1.0, 4.0, 15.0].into_iter().flat_map(|factor| at(factor * Self::typical().width)).collect()
    }

    fn is_trivial(self, _: &Element<'_>, seen: Seen) -> bool {
        self.width * self.stiffness < LEAST_PLAY * seen.command_n
    }
}
