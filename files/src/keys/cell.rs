//! Scenarios of a whole arm.

use feeler_catalogue::{Bound, Key, Kind, Shape, Unit, number, optional, required};
use feeler_plant::units::Dimension;

use super::surface::SHAPES;

const LENGTH: Unit = Unit::Of(Dimension::LENGTH);
// Pure numbers of rad; a text may say `deg`.
const ANGLE: Unit = Unit::Of(Dimension::NONE);

/// The top of such a file.
pub(crate) static CELL: Shape = Shape {
    keys: &[
        optional("name", Kind::Text, "short name; the file's own where absent"),
        optional("about", Kind::Text, "what it is for, in one or two sentences"),
        required(
            "arm",
            Kind::Text,
            "an arm file, or a URDF (`.urdf`), relative to this one; `[joints]` of this file are laid over those of the arm file, key by key, and a URDF has none",
        ),
        optional(
            "tool",
            Kind::Text,
            "with a URDF: link whose frame is the tool's; where absent, the last one that nothing hangs on",
        ),
        optional(
            "machine",
            Kind::Text,
            "a file of this kind, relative to this one, on which this one builds: what is given here replaces what it says, key by key",
        ),
    ],
    choice: None,
};

/// `[start]`
pub(crate) static START: Shape = Shape {
    keys: &[
        optional(
            "pose",
            Kind::Numbers(ANGLE, 0),
            "positions of the joints in their order, rad (m of one that slides); or `place`",
        ),
        optional(
            "place",
            Kind::Numbers(LENGTH, 3),
            "where the tool is in the base's frame, its x axis along the normal; of an arm with fewer than five joints the place alone",
        ),
        required(
            "normal",
            Kind::Numbers(Unit::Of(Dimension::NONE), 3),
            "from the tool into the workpiece, in the base's frame: the direction in which force is controlled",
        ),
        number("speed", Unit::Of(Dimension::VELOCITY), Bound::Any, 0.0, "of the tool along the normal"),
    ],
    choice: None,
};

/// `[hold]`
pub(crate) static HOLD: Shape = Shape {
    keys: &[
        number(
            "bandwidth",
            Unit::Of(Dimension::FREQUENCY),
            Bound::NotNegative,
            5.0,
            "natural frequency; 0 for no position control",
        ),
        number("damping_ratio", Unit::Of(Dimension::NONE), Bound::Positive, 1.0, "damping ratio"),
    ],
    choice: None,
};

const X: Key = number("x", LENGTH, Bound::Any, 0.0, "position");
const Y: Key = number("y", LENGTH, Bound::Any, 0.0, "position");
const Z: Key = number("z", LENGTH, Bound::Any, 0.0, "position");
const TURN_X: Key =
    number("turn_x", ANGLE, Bound::Any, 0.0, "part along x of the axis of rotation times its angle");
const TURN_Y: Key = number("turn_y", ANGLE, Bound::Any, 0.0, "part along y");
const TURN_Z: Key = number("turn_z", ANGLE, Bound::Any, 0.0, "part along z");

/// `[tip]`, `[workpiece]`
pub(crate) static PLACED: Shape = Shape { keys: &[X, Y, Z, TURN_X, TURN_Y, TURN_Z], choice: Some(SHAPES) };

/// Tables of such a file beside those of an axis, and what they are.
pub(crate) static CELL_TABLES: [(&str, &Shape, &str); 4] = [
    ("start", &START, "How the arm begins, at rest but for `speed`; its gears are relaxed."),
    (
        "tip",
        &PLACED,
        "What touches, in the frame of the tool. A ball is measured exactly, other shapes as closely as Parry iterates.",
    ),
    (
        "workpiece",
        &PLACED,
        "What is touched, in the base's frame; it stands still. A mesh or height field is a surface: the centre of a ball must stay outside.",
    ),
    (
        "hold",
        &HOLD,
        "Position control of the tool's other directions, sampled with the controller: of an arm with six joints or more all five, of one with fewer the two of position.",
    ),
];

/// Tables of elements that such a file shares with an axis.
pub(crate) const SHARED: [&str; 4] = ["contacts", "sensors", "controllers", "run"];
