//! The switches of a machine.

use super::super::{Coordinates, Motion};
use super::{ContactState, DirectionState, Mode};
use crate::assembly::{Assembly, StopSide};
use crate::description::Engagement;

/// Something that changes the equations of motion when it switches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Switch {
    /// A unilateral contact.
    Contact(usize),
    /// One side of the free play of a link.
    Stop(usize, StopSide),
    /// Dry friction of a link.
    Friction(usize),
    /// The effort limit of a drive whose force has dynamics or depends on the motion.
    Limit(usize),
    /// The bound on the effort of a drive that depends on the speed.
    Line(usize),
    /// The deadband of the error of a continuous servo.
    Deadband(usize),
    /// The rate limit of a drive, or its way from one command to the next.
    Ramp(usize),
    /// The direction of a link whose resistance depends on it.
    Direction(usize),
}

/// All switches of a machine, in the order of its modes.
pub(in crate::motion) fn switches(assembly: &Assembly, coordinates: &Coordinates) -> Vec<Switch> {
    // Two nodes with the same coordinate (or both fixed) cannot move relative to each other, so nothing
    // switches between them.
    let apart = |a, b| coordinates.of(a) != coordinates.of(b);
    let contacts = (assembly.contacts.iter().enumerate())
        .filter(|(_, contact)| contact.engagement == Engagement::Unilateral && apart(contact.a, contact.b))
        .map(|(i, _)| Switch::Contact(i));
    let links = assembly.links.iter().enumerate().filter(|(_, link)| !link.rigid && apart(link.a, link.b));
    let links = links.flat_map(|(i, link)| {
        let stops = link.stops().map(move |(side, _)| Switch::Stop(i, side));
        let direction = link.feels_direction().then_some(Switch::Direction(i));
        stops.chain(link.friction.acts().then_some(Switch::Friction(i))).chain(direction)
    });
    let drives = || assembly.drives.iter().enumerate();
    let limits = drives()
        .filter(|(_, drive)| drive.limits_force() && drive.limit.is_finite())
        .map(|(i, _)| Switch::Limit(i));
    let lines = drives().filter(|(_, drive)| drive.line.is_some()).map(|(i, _)| Switch::Line(i));
    let deadbands = drives()
        .filter(|(_, drive)| drive.continuous_servo().is_some() && drive.deadband > 0.0)
        .map(|(i, _)| Switch::Deadband(i));
    let ramps = drives().filter(|(_, drive)| drive.ramps()).map(|(i, _)| Switch::Ramp(i));
    contacts.chain(links).chain(limits).chain(lines).chain(deadbands).chain(ramps).collect()
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

    /// The direction of a link, if its resistance depends on it.
    pub(in crate::motion) fn direction(&self, mode: Mode, link: usize) -> DirectionState {
        self.number_of(Switch::Direction(link)).map_or(DirectionState::AtRest, |i| mode.direction(i))
    }

    fn state_of(&self, mode: Mode, switch: Switch) -> ContactState {
        self.number_of(switch).map_or(ContactState::Open, |i| mode.contact(i))
    }
}
