//! What is still under way where a run ends.

use feeler_engine::{Scenario, Simulation};
use feeler_lanes::Lane;
use feeler_plant::description::Engagement;

use super::contact::ContactRun;

/// Where a run stands at its end.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Standing {
    /// Whether a controller was in its approach.
    pub(super) is_approaching: bool,
    /// Compression of each contact, m, and how fast it grew, m/s.
    compressions: Vec<[f64; 2]>,
}

impl Standing {
    pub(super) fn of<L: Lane>(simulation: &Simulation<L>, lane: usize) -> Self {
        Self { is_approaching: simulation.is_approaching(lane), compressions: simulation.compressions(lane) }
    }

    /// Whether the tool may yet touch: a controller approaches, or some gap closes at its present rate within `horizon_s`.
    pub(super) fn is_on_its_way(&self, contacts: &[ContactRun], horizon_s: f64) -> bool {
        let arrives = |(contact, [compression, rate]): (&ContactRun, &[f64; 2])| {
            can_touch(contact) && *rate > 0.0 && -compression <= rate * horizon_s
        };
        (self.is_approaching && contacts.iter().any(can_touch)) || contacts.iter().zip(&self.compressions).any(arrives)
    }
}

/// Whether no contact of a scenario ever touches, so that a wall, if there is one, is one that a controller renders, and `no-contact` is its rest.
pub(crate) fn nothing_can_touch(scenario: &Scenario) -> bool {
    scenario.machine.contacts.values().all(|contact| contact.engagement == Engagement::Free)
}

/// Whether a contact is one that opens and closes.
pub(super) fn can_touch(contact: &ContactRun) -> bool {
    contact.engagement == Engagement::Unilateral
}
