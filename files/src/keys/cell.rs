//! Scenarios of a whole arm.

use feeler_catalogue::{Bound, Dimension, Key, KeyKind, Keyed, Keys, Unit, keys, number, optional, required};
use feeler_geometry::Placement;
use feeler_manipulator::{Hold, Part, Start};

use super::surface::SHAPES;
use super::{ABOUT, BASE, CONTACTS, CONTROLLERS, NAME, RUN_TABLE, SENSORS};

pub(crate) const ARM_FILE: Key = required(
    "arm",
    KeyKind::Text,
    "an arm file, or a URDF (`.urdf`), relative to this one; keys of `[joints]` here replace those of the \
     arm file",
);
pub(crate) const TOOL: Key = optional(
    "tool",
    KeyKind::Text,
    "with a URDF: link whose frame is the tool's; if absent, the last link without a child",
);
const BUILDS_ON: Key =
    Key { text: "a base file of this kind, relative to this one; keys here replace its keys", ..BASE };

/// The top of such a file.
pub(crate) static CELL: Keys = Keys { keys: &[NAME, ABOUT, ARM_FILE, TOOL, BUILDS_ON], choice: None };

pub(crate) const POSE: Key = optional(
    "pose",
    // Pure numbers are rad; a text may have `deg`.
    KeyKind::Numbers(Unit::Of(Dimension::NONE), 0),
    "positions of the joints in their order, rad (m of one that slides); or `place`",
);
pub(crate) const PLACE: Key = optional(
    "place",
    KeyKind::Numbers(Unit::Of(Dimension::LENGTH), 3),
    "tool position in the base's frame, its x axis along the normal; with fewer than five joints the \
     position alone",
);
pub(crate) const NORMAL: Key = Start::NORMAL;
pub(crate) const SPEED: Key =
    number("speed", Unit::Of(Dimension::VELOCITY), Bound::Any, 0.0, "of the tool along the normal");

/// `[start]`
pub(crate) static START: Keys = Keys { keys: &[POSE, PLACE, NORMAL, SPEED], choice: None };

/// `[hold]`
pub(crate) static HOLD: Keys = Keys { keys: keys!(Hold::FIELDS), choice: None };

/// `[tip]`, `[workpiece]`
pub(crate) static PLACED: Keys = Keys { keys: keys!(Placement::FIELDS), choice: Some(SHAPES) };

/// The table of the initial state.
pub(crate) const START_TABLE: &str = Start::TABLE;
/// The table of the tip's shape.
pub(crate) const TIP: &str = Part::TIP;
/// The table of the workpiece's shape.
pub(crate) const WORKPIECE: &str = Part::WORKPIECE;
/// The table of the position control.
pub(crate) const HOLD_TABLE: &str = "hold";

/// Tables of such a file that an axis does not have, and their meaning.
pub(crate) static CELL_TABLES: [(&str, &Keys, &str); 4] = [
    (START_TABLE, &START, "Initial state of the arm: at rest except for `speed`, with relaxed gears."),
    (
        TIP,
        &PLACED,
        "Shape of the tip, in the frame of the tool. A ball is exact; other shapes follow Parry's \
         iterations.",
    ),
    (
        WORKPIECE,
        &PLACED,
        "Shape of the workpiece, at rest in the base's frame. A ball's centre must stay outside a \
         mesh or height field.",
    ),
    (
        HOLD_TABLE,
        &HOLD,
        "Position control of the tool's other directions, sampled with the controller: all five with six \
         joints, else two.",
    ),
];

/// Tables of elements that such a file shares with an axis.
pub(crate) const SHARED: [&str; 4] = [CONTACTS.table, SENSORS.table, CONTROLLERS.table, RUN_TABLE];
