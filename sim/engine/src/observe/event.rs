//! Events of a run.

use feeler_plant::assembly::Assembly;
use feeler_plant::motion::{ContactState, FrictionState, LimitState, Switch, SwitchState};

/// Kind of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EventKind {
    /// A contact or one side of a play began to push.
    Touch,
    Lift,
    /// A guide came to rest.
    Stick,
    /// A guide began to slide, or reversed.
    Slip,
    /// A drive reached its limit.
    Limit,
    Release,
}

impl EventKind {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Touch => "touch",
            Self::Lift => "lift",
            Self::Stick => "stick",
            Self::Slip => "slip",
            Self::Limit => "limit",
            Self::Release => "release",
        }
    }

    /// The event of a switch that changes from one state to another. `None` if the change is not an event, as
    /// when an error leaves its deadband.
    pub fn of(switch: Switch, from: SwitchState, to: SwitchState) -> Option<Self> {
        match (from, to) {
            _ if matches!(switch, Switch::Deadband(_)) => None,
            (SwitchState::Contact(from), SwitchState::Contact(to)) => {
                match [from, to].map(|state| state == ContactState::Pushing) {
                    [false, true] => Some(Self::Touch),
                    [true, false] => Some(Self::Lift),
                    _ => None,
                }
            }
            (_, SwitchState::Friction(FrictionState::Stick)) => Some(Self::Stick),
            (_, SwitchState::Friction(_)) => Some(Self::Slip),
            (_, SwitchState::Limit(LimitState::Within)) => Some(Self::Release),
            (_, SwitchState::Limit(_)) => Some(Self::Limit),
            _ => None,
        }
    }
}

/// An event at its instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    pub t_s: f64,
    pub kind: EventKind,
    /// The switch it happened to.
    pub switch: Switch,
}

impl Event {
    /// Name of the element of the event.
    pub fn element<'a>(&self, assembly: &'a Assembly) -> &'a str {
        match self.switch {
            Switch::Contact(i) => &assembly.contacts[i].name,
            Switch::Stop(i, _) | Switch::Friction(i) | Switch::Direction(i) => &assembly.links[i].name,
            Switch::Limit(i) | Switch::Line(i) | Switch::Deadband(i) | Switch::Ramp(i) => {
                &assembly.drives[i].name
            }
        }
    }
}
