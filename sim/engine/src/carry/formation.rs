//! The properties that the lanes of a simulation share at present, so that the loop need not query each lane
//! at every instant.

use feeler_lanes::{Lane, LaneMask};
use feeler_plant::motion::ContactState;

use crate::carry::lane::LaneCore;

/// The state of the lanes as a group. It is valid until a lane goes alone.
#[derive(Debug)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts")]
pub(crate) struct Formation<L: Lane> {
    /// Counts new formations; tables that depend on the lanes' modes compare it.
    pub(super) number: u64,
    /// Lanes that travel by exponentials: they are in a linear mode and have not ended.
    pub(super) travelling: L::Mask,
    /// Whether some lane that has not ended goes alone.
    pub(super) any_alone: bool,
    pub(super) all_linear: bool,
    pub(super) all_ended: bool,
    /// Whether guides stick bodies to each other in some lane. Their speeds are then kept bitwise equal.
    pub(super) any_joined: bool,
    /// Per contact, 1 in lanes in which it pushes and 0 in the others.
    pub(super) touching: Vec<L>,
}

impl<L: Lane> Formation<L> {
    pub(crate) fn new(lanes: &[LaneCore]) -> Self {
        let mut formation = Self {
            number: 0,
            travelling: L::Mask::splat(false),
            any_alone: false,
            all_linear: false,
            all_ended: false,
            any_joined: false,
            touching: Vec::new(),
        };
        formation.form(lanes);
        formation
    }

    /// Recomputes the shared properties from every lane.
    pub(crate) fn form(&mut self, lanes: &[LaneCore]) {
        self.number += 1;
        self.travelling = L::Mask::from_fn(|l| lanes[l].flow().linear && !lanes[l].has_ended());
        self.any_alone = lanes.iter().any(|lane| !lane.flow().linear && !lane.has_ended());
        self.all_linear = lanes.iter().all(|lane| lane.flow().linear);
        self.all_ended = lanes.iter().all(LaneCore::has_ended);
        self.any_joined = lanes.iter().any(LaneCore::joins_bodies);
        let pushes = |lane: &LaneCore, contact: usize| {
            lane.motion.contact_state(lane.flow().equations.mode, contact) == ContactState::Pushing
        };
        let touching = |contact: usize| L::from_fn(|l| f64::from(u8::from(pushes(&lanes[l], contact))));
        self.touching.clear();
        self.touching.extend((0..lanes[0].motion.assembly().contacts.len()).map(touching));
    }
}
