//! `base-flexibility`: a base that moves.

use feeler_plant::assembly::GROUND_NODE;
use feeler_plant::effects::{BaseFlexibility, Host, Parameters};

use super::start::{NARROW, every, is_overdamped, mode};
use super::{Element, Glance, Known, Seen};

/// Range of trial frequencies for the mode of a base, Hz.
const RANGE_HZ: (f64, f64) = (4.0, 45.0);

impl Known for BaseFlexibility {
    fn starts(element: &Element<'_>, _: &Glance) -> Vec<Self> {
        let link = |assembly: &feeler_plant::assembly::Assembly| match element.host {
            Host::Spring(i) if assembly.links[i].rigid => {
                let link = &assembly.links[i];
                Some(assembly.nodes[if link.a == GROUND_NODE { link.b } else { link.a }].mass_kg)
            }
            _ => None,
        };
        let mass = element.assembly().as_ref().and_then(link).unwrap_or(Self::typical().mass);
        let at = |frequency_hz: f64| {
            let (stiffness, damping) = mode(mass, frequency_hz, NARROW);
            Self { mass, stiffness, damping }
        };
        every(RANGE_HZ).map(at).collect()
    }

    fn is_trivial(self, _: &Element<'_>, seen: Seen) -> bool {
        seen.is_lost(seen.command_n / self.stiffness)
            || is_overdamped(self.mass, self.stiffness, self.damping)
    }
}
