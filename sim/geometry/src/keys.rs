//! The keys of shapes, places and materials in files.

use feeler_catalogue::{
    Bound, Dimension, Field, Form, Key, KeyKind, Keyed, Unit, field, form, number, required,
};

use crate::hertz::Material;
use crate::shape::{Placement, Shape};

const LENGTH: Unit = Unit::Of(Dimension::LENGTH);
// Rotation components are pure numbers in rad; a text may say `deg`.
const ANGLE: Unit = Unit::Of(Dimension::NONE);

const fn length(name: &'static str, text: &'static str) -> Key {
    required(name, KeyKind::Quantity(LENGTH, Bound::Positive), text)
}

const RADIUS: Field<Shape> = field!(
    Shape:
        Shape::Ball { radius_m } | Shape::Capsule { radius_m, .. } | Shape::Cylinder { radius_m, .. }
            => *radius_m,
    length("radius", "radius")
);
const HALF_LENGTH: Field<Shape> = field!(
    Shape: Shape::Capsule { half_length_m, .. } | Shape::Cylinder { half_length_m, .. } => *half_length_m,
    length("half_length", "half the length of its axis, which lies along y")
);
const ROUND: &[Field<Shape>] = &[HALF_LENGTH, RADIUS];
const CUBOID: &[Field<Shape>] = &[
    field!(Shape: Shape::Cuboid { half_extents_m } => half_extents_m[0],
        length("half_x", "half its extent in x")),
    field!(Shape: Shape::Cuboid { half_extents_m } => half_extents_m[1],
        length("half_y", "half its extent in y")),
    field!(Shape: Shape::Cuboid { half_extents_m } => half_extents_m[2],
        length("half_z", "half its extent in z")),
];

/// The shapes with numerical keys.
impl Keyed for Shape {
    const FIELDS: &'static [Field<Self>] = &[];
    const FORMS: &'static [Form<Self>] = &[
        form!("ball", "a ball", Shape: Shape::Ball { .. }, Shape::Ball { radius_m: 1.0 },
            &[RADIUS] as &[Field<Shape>]),
        form!("capsule", "a cylinder with round ends", Shape: Shape::Capsule { .. },
            Shape::Capsule { half_length_m: 1.0, radius_m: 1.0 }, ROUND),
        form!("cuboid", "a box", Shape: Shape::Cuboid { .. }, Shape::Cuboid { half_extents_m: [1.0; 3] },
            CUBOID),
        form!("cylinder", "a cylinder with flat ends", Shape: Shape::Cylinder { .. },
            Shape::Cylinder { half_length_m: 1.0, radius_m: 1.0 }, ROUND),
    ];
}

impl Keyed for Placement {
    const FIELDS: &'static [Field<Self>] = &[
        field!(Placement: position_m[0], number("x", LENGTH, Bound::Any, 0.0, "position")),
        field!(Placement: position_m[1], number("y", LENGTH, Bound::Any, 0.0, "position")),
        field!(Placement: position_m[2], number("z", LENGTH, Bound::Any, 0.0, "position")),
        field!(Placement: rotation_rad[0],
            number("turn_x", ANGLE, Bound::Any, 0.0, "x component of the rotation vector: axis times angle")),
        field!(Placement: rotation_rad[1], number("turn_y", ANGLE, Bound::Any, 0.0, "y component")),
        field!(Placement: rotation_rad[2], number("turn_z", ANGLE, Bound::Any, 0.0, "z component")),
    ];

    fn blank() -> Option<Self> {
        Some(Self::default())
    }
}

impl Keyed for Material {
    const FIELDS: &'static [Field<Self>] = &[
        field!(Material: youngs_modulus_pa,
            required("youngs_modulus", KeyKind::Quantity(Unit::Pressure, Bound::Positive),
                "Young's modulus")),
        field!(Material: poisson_ratio,
            number("poisson_ratio", Unit::Of(Dimension::NONE), Bound::Within(0.0, 0.5), 0.3,
                "Poisson's ratio")),
    ];

    fn blank() -> Option<Self> {
        Some(Self { youngs_modulus_pa: 1.0, poisson_ratio: 0.0 })
    }
}
