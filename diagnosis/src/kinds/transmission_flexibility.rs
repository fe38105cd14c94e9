//! `transmission-flexibility`: a flexible joint.

use feeler_plant::effects::{Host, Kind, TransmissionFlexibility};

use super::start::{NARROW, every, is_overdamped, mode};
use super::{Element, Glance, Known, Seen};

/// Range of the search for the mode of a joint.
const RANGE_HZ: (f64, f64) = (10.0, 400.0);

impl Known for TransmissionFlexibility {
    /// On average, a joint with play is flexible, too.
    const WHERE_IT_RATTLES: Option<Kind> = Some(Kind::Backlash);

    fn starts(element: &Element<'_>, _: &Glance) -> Vec<Self> {
        let Some(assembly) = element.assembly() else { return Vec::new() };
        let mass_of = |node: usize| assembly.nodes[node].mass_kg;
        // The split of a body is unknown: a third or two thirds may be on the spring.
        let split = match element.host {
            Host::Spring(i) => vec![[mass_of(assembly.links[i].a), mass_of(assembly.links[i].b)]],
            Host::Body(node) => [1.0 / 3.0, 2.0 / 3.0]
                .map(|share| [(1.0 - share) * mass_of(node), share * mass_of(node)])
                .to_vec(),
            _ => Vec::new(),
        };
        let of = |[a, b]: [f64; 2]| {
            every(RANGE_HZ).map(move |frequency_hz| {
                let (stiffness, damping) = mode(a * b / (a + b), frequency_hz, NARROW);
                Self { stiffness, damping, tip_mass: b }
            })
        };
        split.into_iter().flat_map(of).collect()
    }

    fn is_trivial(self, _: &Element<'_>, seen: Seen) -> bool {
        seen.is_lost(seen.command_n / self.stiffness)
            || is_overdamped(self.tip_mass, self.stiffness, self.damping)
    }
}
