//! Sweep files.

use feeler_catalogue::{
    Absent, Bound, Choice, Key, Kind, Shape, Unit, Variant, Word, optional, required, word,
};
use feeler_plant::units::Dimension;

/// Most points of an axis and samples of a sweep; more is refused.
pub(crate) const MOST_POINTS: u64 = 10_000_000;

const SAMPLINGS: &[Word] = &[
    word("grid", "every combination of the axes"),
    word("random", "independent draws"),
    word("latin-hypercube", "each axis cut into `samples` slices, each slice drawn from once"),
    word("sobol", "a low-discrepancy sequence"),
];

/// The top of a sweep file; `[axes]` and `[keep]` are tables of their own.
pub(crate) static SWEEP: Shape = Shape {
    keys: &[
        required("scenario", Kind::Text, "the scenario file, relative to this one"),
        optional("name", Kind::Text, "short name"),
        optional("about", Kind::Text, "what it is for"),
        optional(
            "sampling",
            Kind::Word(SAMPLINGS),
            "how points are chosen; where absent, a grid, or random draws where an axis is a distribution",
        ),
        optional("samples", Kind::Count(1, MOST_POINTS), "how many points to draw, except on a grid"),
        Key {
            name: "seed",
            kind: Kind::Count(0, u64::MAX),
            absent: Absent::Count(1),
            text: "seed of the draws",
        },
    ],
    choice: None,
};

const fn points(least: u64) -> Key {
    required(
        "points",
        Kind::Count(least, MOST_POINTS),
        "how many values, both ends included; one only where these are equal",
    )
}

/// The table form of an axis; the variant is told by which of these keys is there.
pub(crate) static AXIS: Shape = Shape {
    keys: &[],
    choice: Some(Choice {
        key: "",
        default: None,
        text: "kind of axis",
        variants: &[
            Variant {
                name: "linear",
                text: "evenly spaced values",
                keys: &[
                    required("linear", Kind::Range(Unit::Swept), "first and last value"),
                    points(1),
                    optional(
                        "tolerance",
                        Kind::Quantity(Unit::Swept, Bound::Positive),
                        "with [refine], how closely an edge is located, in the unit of the key",
                    ),
                ],
            },
            Variant {
                name: "log",
                text: "values of equal ratio",
                keys: &[
                    required("log", Kind::Range(Unit::Swept), "first and last value, of the same sign"),
                    points(1),
                    optional(
                        "tolerance",
                        Kind::Quantity(Unit::Swept, Bound::Positive),
                        "with [refine], how closely an edge is located, as a ratio: \"2 %\"",
                    ),
                ],
            },
            Variant {
                name: "uniform",
                text: "drawn uniformly",
                keys: &[required("uniform", Kind::Range(Unit::Swept), "smallest and largest value")],
            },
            Variant {
                name: "log_uniform",
                text: "drawn with a uniform logarithm",
                keys: &[required(
                    "log_uniform",
                    Kind::Range(Unit::Swept),
                    "smallest and largest value, of the same sign",
                )],
            },
        ],
    }),
};

/// `[keep]`
pub(crate) static KEEP: Shape = Shape {
    keys: &[
        Key {
            name: "outcome",
            kind: Kind::Flag,
            absent: Absent::Flag(true),
            text: "settled, chatter, unstable or no-contact, with its measures",
        },
        optional(
            "tail",
            Kind::Count(0, 1000),
            "how many of the last impacts and strobes of each run, for bifurcation diagrams; where absent, 64 with one axis of numbers and none with more",
        ),
        Key {
            name: "traces",
            kind: Kind::Flag,
            absent: Absent::Flag(false),
            text: "the recorded signals of every run",
        },
    ],
    choice: None,
};

/// `[refine]`
pub(crate) static REFINE: Shape = Shape {
    keys: &[
        optional(
            "tolerance",
            Kind::Quantity(Unit::Of(Dimension::NONE), Bound::Above(0.0, 1.0)),
            "how closely an edge is located, as a share of each axis that has no tolerance of its own; an axis without any is halved four times",
        ),
        optional(
            "levels",
            Kind::Count(1, 12),
            "instead of tolerances, how often the spacing of the grid is halved along boundaries; 4 where nothing is said",
        ),
        Key {
            name: "by",
            kind: Kind::Word(&[
                word("stability", "whether the force settles"),
                word("outcome", "the outcome itself, so that chatter and limit cycles part too"),
            ]),
            absent: Absent::Word("stability"),
            text: "what changes across a boundary",
        },
    ],
    choice: None,
};
