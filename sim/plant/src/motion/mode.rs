//! What can switch, and in which state each switch is.

use super::Coordinates;
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

/// The state of one switch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum SwitchState {
    /// Contact or stop: apart. Friction: sticking. Limit: not reached. Ramp: at its target.
    Rest = 0,
    /// Contact or stop: still compressed, but coming apart faster than the law pushes, so no force. Friction:
    /// sliding backward. Limit: at the lower one. Ramp: falling.
    Minus = 1,
    /// Contact or stop: pushing. Friction: sliding forward. Limit: at the upper one. Ramp: rising.
    Plus = 2,
}

/// The states of all switches: two bits each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Mode(u128);

impl Mode {
    /// The most switches a machine may have.
    pub const CAPACITY: usize = 64;

    /// The state of switch `i`.
    pub fn get(self, i: usize) -> SwitchState {
        match (self.0 >> (2 * i)) & 3 {
            0 => SwitchState::Rest,
            1 => SwitchState::Minus,
            _ => SwitchState::Plus,
        }
    }

    /// The same with switch `i` in another state.
    #[must_use]
    pub fn with(self, i: usize, state: SwitchState) -> Self {
        Self(self.0 & !(3 << (2 * i)) | ((state as u128) << (2 * i)))
    }
}

pub(super) fn switches(assembly: &Assembly, coordinates: &Coordinates) -> Vec<Switch> {
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
