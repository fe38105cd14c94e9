//! `surface` and `profile` of a contact.

use feeler_catalogue::{Bound, Choice, Key, Kind, Shape, Unit, Variant, number, optional, required};
use feeler_plant::units::Dimension;

const LENGTH: Unit = Unit::Of(Dimension::LENGTH);
const VELOCITY: Unit = Unit::Of(Dimension::VELOCITY);
// Pure numbers of rad; a text may say `deg`.
const ANGLE: Unit = Unit::Of(Dimension::NONE);

const FILE: Key =
    required("file", Kind::Text, "the file, relative to this one: `.stl` (text or binary) or `.obj`");
const SCALE: Key = number("scale", LENGTH, Bound::Positive, 1e-3, "length of the file's unit");
const RADIUS: Key = required("radius", Kind::Quantity(LENGTH, Bound::Positive), "radius");
const HALF_LENGTH: Key = required(
    "half_length",
    Kind::Quantity(LENGTH, Bound::Positive),
    "half the length of its axis, which lies along y",
);

/// An elastic material.
static MATERIAL: Shape = Shape {
    keys: &[
        required(
            "youngs_modulus",
            Kind::Quantity(Unit::Of(Dimension::PRESSURE), Bound::Positive),
            "Young's modulus",
        ),
        number("poisson_ratio", Unit::Of(Dimension::NONE), Bound::Within(0.0, 0.5), 0.3, "Poisson's ratio"),
    ],
    choice: None,
};

/// The shapes that there are.
pub(crate) const SHAPES: Choice = Choice {
    key: "shape",
    default: None,
    text: "the shape, centred on its position",
    variants: &[
        Variant { name: "ball", text: "a ball", keys: &[RADIUS] },
        Variant { name: "capsule", text: "a cylinder with round ends", keys: &[HALF_LENGTH, RADIUS] },
        Variant {
            name: "cuboid",
            text: "a box",
            keys: &[
                required("half_x", Kind::Quantity(LENGTH, Bound::Positive), "half its extent in x"),
                required("half_y", Kind::Quantity(LENGTH, Bound::Positive), "half its extent in y"),
                required("half_z", Kind::Quantity(LENGTH, Bound::Positive), "half its extent in z"),
            ],
        },
        Variant { name: "cylinder", text: "a cylinder with flat ends", keys: &[HALF_LENGTH, RADIUS] },
        Variant { name: "hull", text: "the convex hull of the corners of a mesh file", keys: &[FILE, SCALE] },
        Variant { name: "mesh", text: "the triangles of a mesh file", keys: &[FILE, SCALE] },
        Variant {
            name: "height-field",
            text: "heights above the y-z plane towards the tip, flat in two triangles between its samples",
            keys: &[
                required(
                    "file",
                    Kind::Text,
                    "a CSV file, relative to this one, without a header: one line per z, one height in m per y",
                ),
                required("extent_y", Kind::Quantity(LENGTH, Bound::Positive), "length of a line"),
                required(
                    "extent_z",
                    Kind::Quantity(LENGTH, Bound::Positive),
                    "from the first line to the last",
                ),
            ],
        },
    ],
};

/// Position and orientation, and a shape.
static BODY: Shape = Shape {
    keys: &[
        number(
            "x",
            LENGTH,
            Bound::Any,
            0.0,
            "position along the axis of motion; of a tip, ahead of its body",
        ),
        number("y", LENGTH, Bound::Any, 0.0, "position sideways"),
        number("z", LENGTH, Bound::Any, 0.0, "position sideways"),
        number("turn_x", ANGLE, Bound::Any, 0.0, "part along x of the axis of rotation times its angle"),
        number("turn_y", ANGLE, Bound::Any, 0.0, "part along y"),
        number("turn_z", ANGLE, Bound::Any, 0.0, "part along z"),
        optional(
            "material",
            Kind::Table(&MATERIAL),
            "what it is made of, for the stiffness of a `hertz` law",
        ),
    ],
    choice: Some(SHAPES),
};

/// How the tip travels.
static FEED: Shape = Shape {
    keys: &[],
    choice: Some(Choice {
        key: "kind",
        default: Some("line"),
        text: "how the tip travels sideways; before and after, it rests",
        variants: &[
            Variant {
                name: "line",
                text: "at a constant velocity",
                keys: &[
                    number("y", LENGTH, Bound::Any, 0.0, "start"),
                    number("z", LENGTH, Bound::Any, 0.0, "start"),
                    number("velocity_y", VELOCITY, Bound::Any, 0.0, "velocity"),
                    number("velocity_z", VELOCITY, Bound::Any, 0.0, "velocity"),
                    required(
                        "duration",
                        Kind::Quantity(Unit::Of(Dimension::TIME), Bound::Above(0.0, 1e5)),
                        "how long",
                    ),
                ],
            },
            Variant {
                name: "path",
                text: "smoothly through the points of a file, at rest at both ends",
                keys: &[required(
                    "file",
                    Kind::Text,
                    "a CSV file with the header `t_s,y_m,z_m`, relative to this one",
                )],
            },
        ],
    }),
};

/// `surface`
pub(crate) static SURFACE: Shape = Shape {
    keys: &[
        required("tip", Kind::Table(&BODY), "shape of the tip, about its body"),
        required("workpiece", Kind::Table(&BODY), "shape of the workpiece where its body is at zero"),
        required("feed", Kind::Table(&FEED), "how the tip travels sideways"),
        number("error", LENGTH, Bound::Above(0.0, 1.0), 1e-8, "largest error of the gap along the feed"),
    ],
    choice: None,
};

/// `profile`
pub(crate) static PROFILE: Shape = Shape {
    keys: &[
        required("offset", Kind::Points(LENGTH), "[[time, offset], ...]"),
        optional(
            "rate",
            Kind::Points(VELOCITY),
            "[[time, rate], ...] at the same times; where absent that of a smooth curve, at rest at both ends",
        ),
    ],
    choice: None,
};
