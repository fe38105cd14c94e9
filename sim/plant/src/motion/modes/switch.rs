//! What can switch.

use super::super::{Coordinates, Motion};
use super::{ContactState, Mode};
use crate::assembly::Assembly;
use crate::description::Engagement;

/// Which side of a free play.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StopSide {
    /// Reached when the elongation grows.
    Upper,
    /// Reached when it falls.
    Lower,
}

/// Something that changes the equations of motion when it switches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Switch {
    /// A unilateral contact.
    Contact(usize),
    /// One side of the free play of a link.
    Stop(usize, StopSide),
    /// Dry friction of a link.
    Friction(usize),
    /// The effort limit of a velocity source.
    Limit(usize),
    /// The rate limit of a drive.
    Ramp(usize),
}

/// Everything that switches in a machine, in the order of its modes.
pub(in crate::motion) fn switches(assembly: &Assembly, coordinates: &Coordinates) -> Vec<Switch> {
    // Two nodes that share a coordinate (or are both fixed) cannot move against each other: nothing there
    // switches.
    let apart = |a, b| coordinates.of(a) != coordinates.of(b);
    let contacts = (assembly.contacts.iter().enumerate())
        .filter(|(_, contact)| contact.engagement == Engagement::Unilateral && apart(contact.a, contact.b))
        .map(|(i, _)| Switch::Contact(i));
    let links = assembly.links.iter().enumerate().filter(|(_, link)| !link.rigid && apart(link.a, link.b));
    let links = links.flat_map(|(i, link)| {
        let play =
            (link.play > 0.0).then_some([Switch::Stop(i, StopSide::Upper), Switch::Stop(i, StopSide::Lower)]);
        play.into_iter().flatten().chain(link.friction.acts().then_some(Switch::Friction(i)))
    });
    let limits = (assembly.drives.iter().enumerate())
        .filter(|(_, drive)| drive.velocity_source.is_some() && drive.limit.is_finite())
        .map(|(i, _)| Switch::Limit(i));
    let ramps = assembly
        .drives
        .iter()
        .enumerate()
        .filter(|(_, drive)| drive.rate_limit.is_finite())
        .map(|(i, _)| Switch::Ramp(i));
    contacts.chain(links).chain(limits).chain(ramps).collect()
}

impl Motion {
    /// The number of a switch in a [`Mode`](super::Mode).
    pub(in crate::motion) fn number_of(&self, switch: Switch) -> Option<usize> {
        self.switches.iter().position(|&s| s == switch)
    }

    /// The state of a contact, which is clamped, absent, or switches.
    pub fn contact_state(&self, mode: Mode, contact: usize) -> ContactState {
        match self.assembly.contacts[contact].engagement {
            Engagement::Clamped => ContactState::Pushing,
            Engagement::Free => ContactState::Open,
            Engagement::Unilateral => self.state_of(mode, Switch::Contact(contact)),
        }
    }

    /// The state of one side of the free play of a link.
    pub(in crate::motion) fn stop_state(&self, mode: Mode, link: usize, side: StopSide) -> ContactState {
        self.state_of(mode, Switch::Stop(link, side))
    }

    fn state_of(&self, mode: Mode, switch: Switch) -> ContactState {
        self.number_of(switch).map_or(ContactState::Open, |i| mode.contact(i))
    }
}
