//! The mode: which contacts push and which joints stick. The motion is smooth while it lasts. States and
//! rules are those of every machine ([`feeler_plant::motion::modes`]).

use feeler_plant::motion::{ContactState, FrictionState, StopSide};

/// Contacts in touch, and sliding joints.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CellMode {
    /// Tip and workpiece.
    pub(crate) contact: ContactState,
    /// Lower and upper flank of each gear's play.
    pub(crate) flanks: Vec<[ContactState; 2]>,
    /// The dry friction of each motor; `None` without friction.
    pub(crate) slides: Vec<Option<FrictionState>>,
}

impl CellMode {
    /// All contacts apart, and no joint sticking.
    pub(crate) fn open(joints: usize) -> Self {
        Self {
            contact: ContactState::Open,
            flanks: vec![[ContactState::Open; 2]; joints],
            slides: vec![None; joints],
        }
    }

    /// Whether the tip pushes on the workpiece.
    pub(crate) fn touches(&self) -> bool {
        self.contact == ContactState::Pushing
    }
}

/// A switch, and its new state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SwitchChange {
    /// The contact of tip and workpiece.
    Contact(ContactState),
    /// A flank of a gear.
    Flank(usize, StopSide, ContactState),
    /// The dry friction of a motor. `None`: the motor comes to rest, and its torques decide.
    Slide(usize, Option<FrictionState>),
}

/// Index of a flank among the two of its gear.
pub(crate) fn index_of(side: StopSide) -> usize {
    usize::from(side == StopSide::Upper)
}
