//! `viscous-friction`: damping beyond the believed one.

use feeler_catalogue::Key;
use feeler_plant::description::Spring;
use feeler_plant::effects::ViscousFriction;

use super::{Balance, Element, Force, Glance, Known, Seen};
use crate::tolerance::DAMPING;

impl Known for ViscousFriction {
    const BALANCE: Option<Balance<Self>> = Some(Balance::forces(
        &[Force::positive(|at| at.speed)],
        |of, _| Self { damping: of[0] },
        |own| (vec![own.damping], 0.0),
    ));
    const ADDS_TO: Option<Key> = Some(Spring::DAMPING.key);

    fn starts(element: &Element<'_>, glance: &Glance) -> Vec<Self> {
        let believed = element.spring().map_or(0.0, |spring| spring.damping_n_s_per_m);
        let own = believed.max(0.1 * glance.command / glance.speed.max(1e-9));
        [0.5, 2.0, 6.0].map(|factor| Self { damping: factor * own }).to_vec()
    }

    fn is_trivial(self, element: &Element<'_>, _: Seen) -> bool {
        let believed = element.spring().map_or(0.0, |spring| spring.damping_n_s_per_m);
        self.damping <= element.tolerance(&Spring::DAMPING.key, DAMPING) * believed
    }
}
