//! `surface` and `profile` of a contact.

use feeler_catalogue::{
    Bound, Choice, Dimension, Field, Form, Key, KeyKind, Keyed, Keys, Unit, Variant, chained, field, form,
    keys, number, optional, required, variants,
};
use feeler_geometry::{Material, Placement, Shape};

const LENGTH: Unit = Unit::Of(Dimension::LENGTH);
const VELOCITY: Unit = Unit::Of(Dimension::VELOCITY);

/// The key of every file of a surface.
pub(crate) const FILE: &str = "file";

/// A shape in a file.
#[derive(Debug)]
pub(crate) enum ShapeFile {
    Hull { file: String, scale_m: f64 },
    Mesh { file: String, scale_m: f64 },
    HeightField { file: String, extents_m: [f64; 2] },
}

const MESH_FILE: Key =
    required(FILE, KeyKind::Text, "the file, relative to this one: `.stl` (text or binary) or `.obj`");
const MESH: &[Field<ShapeFile>] = &[
    field!(ShapeFile: ShapeFile::Hull { file, .. } | ShapeFile::Mesh { file, .. } => *file, MESH_FILE),
    field!(ShapeFile: ShapeFile::Hull { scale_m, .. } | ShapeFile::Mesh { scale_m, .. } => *scale_m,
        number("scale", LENGTH, Bound::Positive, 1e-3, "length of the file's unit")),
];
const HEIGHT_FIELD: &[Field<ShapeFile>] = &[
    field!(ShapeFile: ShapeFile::HeightField { file, .. } => *file,
        required(FILE, KeyKind::Text,
            "a CSV file, relative to this one, without a header: one line per z, one height in m per y")),
    field!(ShapeFile: ShapeFile::HeightField { extents_m, .. } => extents_m[0],
        required("extent_y", KeyKind::Quantity(LENGTH, Bound::Positive), "length of a line")),
    field!(ShapeFile: ShapeFile::HeightField { extents_m, .. } => extents_m[1],
        required("extent_z", KeyKind::Quantity(LENGTH, Bound::Positive), "from the first line to the last")),
];

impl Keyed for ShapeFile {
    const FIELDS: &'static [Field<Self>] = &[];
    const FORMS: &'static [Form<Self>] = &[
        form!("hull", "the convex hull of the corners of a mesh file", ShapeFile: ShapeFile::Hull { .. },
            ShapeFile::Hull { file: String::new(), scale_m: 1.0 }, MESH),
        form!("mesh", "the triangles of a mesh file", ShapeFile: ShapeFile::Mesh { .. },
            ShapeFile::Mesh { file: String::new(), scale_m: 1.0 }, MESH),
        form!("height-field",
            "heights above the y-z plane towards the tip, flat in two triangles between its samples",
            ShapeFile: ShapeFile::HeightField { .. },
            ShapeFile::HeightField { file: String::new(), extents_m: [1.0; 2] }, HEIGHT_FIELD),
    ];
}

impl ShapeFile {
    pub(crate) fn file(&self) -> &str {
        let (Self::Hull { file, .. } | Self::Mesh { file, .. } | Self::HeightField { file, .. }) = self;
        file
    }
}

const NUMBERED: [Variant; Shape::FORMS.len()] = variants(Shape::FORMS);
const FILED: [Variant; ShapeFile::FORMS.len()] = variants(ShapeFile::FORMS);
const ALL: [Variant; NUMBERED.len() + FILED.len()] = chained(&NUMBERED, &FILED);

/// All shapes.
pub(crate) const SHAPES: Choice =
    Choice { key: "shape", default: None, text: "the shape, centred on its position", variants: &ALL };

static MATERIAL_KEYS: Keys = Keys { keys: keys!(Material::FIELDS), choice: None };
pub(crate) const MATERIAL: Key =
    optional("material", KeyKind::Table(&MATERIAL_KEYS), "material, for the stiffness of a `hertz` law");

const PLACE: &[Key] = keys!(Placement::FIELDS);
const SIDEWAYS: &str = "position sideways";

/// Position and orientation, and a shape.
static BODY: Keys = Keys {
    keys: &[
        Key { text: "position along the axis of motion; of a tip, ahead of its body", ..PLACE[0] },
        Key { text: SIDEWAYS, ..PLACE[1] },
        Key { text: SIDEWAYS, ..PLACE[2] },
        PLACE[3],
        PLACE[4],
        PLACE[5],
        MATERIAL,
    ],
    choice: Some(SHAPES),
};

/// The path of the tip.
#[derive(Debug)]
pub(crate) enum FeedKeys {
    Line { start_m: [f64; 2], velocity_m_per_s: [f64; 2], duration_s: f64 },
    Path { file: String },
}

const LINE: &[Field<FeedKeys>] = &[
    field!(FeedKeys: FeedKeys::Line { start_m, .. } => start_m[0],
        number("y", LENGTH, Bound::Any, 0.0, "start")),
    field!(FeedKeys: FeedKeys::Line { start_m, .. } => start_m[1],
        number("z", LENGTH, Bound::Any, 0.0, "start")),
    field!(FeedKeys: FeedKeys::Line { velocity_m_per_s, .. } => velocity_m_per_s[0],
        number("velocity_y", VELOCITY, Bound::Any, 0.0, "velocity")),
    field!(FeedKeys: FeedKeys::Line { velocity_m_per_s, .. } => velocity_m_per_s[1],
        number("velocity_z", VELOCITY, Bound::Any, 0.0, "velocity")),
    field!(FeedKeys: FeedKeys::Line { duration_s, .. } => *duration_s,
        required("duration", KeyKind::Quantity(Unit::Of(Dimension::TIME), Bound::Above(0.0, 1e5)),
            "how long")),
];
const PATH: &[Field<FeedKeys>] = &[field!(
    FeedKeys: FeedKeys::Path { file } => *file,
    required("file", KeyKind::Text, "a CSV file with the header `t_s,y_m,z_m`, relative to this one")
)];

impl Keyed for FeedKeys {
    const FIELDS: &'static [Field<Self>] = &[];
    const FORMS: &'static [Form<Self>] = &[
        form!("line", "at a constant velocity", FeedKeys: FeedKeys::Line { .. },
            FeedKeys::Line { start_m: [0.0; 2], velocity_m_per_s: [0.0; 2], duration_s: 1.0 }, LINE),
        form!("path", "smoothly through the points of a file, at rest at both ends",
            FeedKeys: FeedKeys::Path { .. }, FeedKeys::Path { file: String::new() }, PATH),
    ];
}

const FEEDS: [Variant; FeedKeys::FORMS.len()] = variants(FeedKeys::FORMS);
static FEED_KEYS: Keys = Keys {
    keys: &[],
    choice: Some(Choice {
        key: "kind",
        default: Some(FeedKeys::FORMS[0].name),
        text: "how the tip travels sideways; before and after, it rests",
        variants: &FEEDS,
    }),
};

pub(crate) const TIP: Key = required("tip", KeyKind::Table(&BODY), "shape of the tip, about its body");
pub(crate) const WORKPIECE: Key =
    required("workpiece", KeyKind::Table(&BODY), "shape of the workpiece where its body is at zero");
pub(crate) const FEED: Key = required("feed", KeyKind::Table(&FEED_KEYS), "how the tip travels sideways");
pub(crate) const ERROR: Key =
    number("error", LENGTH, Bound::Above(0.0, 1.0), 1e-8, "largest error of the gap along the feed");
static SURFACE_KEYS: Keys = Keys { keys: &[TIP, WORKPIECE, FEED, ERROR], choice: None };

pub(crate) const OFFSET: Key = required("offset", KeyKind::Points(LENGTH), "[[time, offset], ...]");
pub(crate) const RATE: Key = optional(
    "rate",
    KeyKind::Points(VELOCITY),
    "[[time, rate], ...] at the same times; if absent, that of a smooth curve at rest at both ends",
);
static PROFILE_KEYS: Keys = Keys { keys: &[OFFSET, RATE], choice: None };

pub(crate) const SURFACE: Key = optional(
    "surface",
    KeyKind::Table(&SURFACE_KEYS),
    "shapes whose distance is added to the gap while the tip travels sideways",
);
pub(crate) const PROFILE: Key =
    optional("profile", KeyKind::Table(&PROFILE_KEYS), "offset of the gap over time, as points");
