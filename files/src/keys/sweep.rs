//! Sweep files.

use feeler_catalogue::{
    Absent, Bound, Choice, Dimension, Field, Key, KeyKind, Keyed, Keys, Unit, Variant, field, keys, optional,
    required, word, words,
};

/// Largest number of points of an axis, and of samples of a sweep.
pub(crate) const MOST_POINTS: u64 = 10_000_000;

pub(crate) const SCENARIO: Key =
    required("scenario", KeyKind::Text, "the scenario file, relative to this one");
pub(crate) const NAME: Key = optional("name", KeyKind::Text, "short name");
pub(crate) const ABOUT: Key = optional("about", KeyKind::Text, "what it is for");
pub(crate) const SAMPLING: Key = optional(
    "sampling",
    KeyKind::Word(Sampling::WORDS),
    "how points are chosen; if absent, a grid, or random draws if an axis is a distribution",
);
pub(crate) const SAMPLES: Key =
    optional("samples", KeyKind::Count(1, MOST_POINTS), "number of points to draw; not for a grid");
pub(crate) const SEED: Key = Key {
    name: "seed",
    kind: KeyKind::Count(0, u64::MAX),
    absent: Absent::Count(1),
    text: "seed of the draws",
};

/// The table of the axes.
pub(crate) const AXES: &str = "axes";
/// The table of the data to keep.
pub(crate) const KEEP_TABLE: &str = "keep";
/// The table of the refinement.
pub(crate) const REFINE_TABLE: &str = "refine";

/// The top of a sweep file; its tables are separate.
pub(crate) static SWEEP: Keys =
    Keys { keys: &[SCENARIO, NAME, ABOUT, SAMPLING, SAMPLES, SEED], choice: None };

/// The sampling method of a sweep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sampling {
    /// Every combination of the axes.
    #[default]
    Grid,
    /// Independent draws.
    Random,
    /// Each axis divided into slices, with one draw from each.
    LatinHypercube,
    /// A low-discrepancy sequence.
    Sobol,
}

/// The data kept of each run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Keep {
    /// The outcome with its measures.
    pub outcome: bool,
    /// The recorded signals.
    pub traces: bool,
    /// Number of last impacts and strobes to keep.
    pub tail: usize,
}

words!(Sampling {
    Grid = "grid", "every combination of the axes";
    Random = "random", "independent draws";
    LatinHypercube = "latin-hypercube", "each axis divided into `samples` slices, with one draw from each";
    Sobol = "sobol", "a low-discrepancy sequence";
});

pub(crate) const POINTS: Key = required(
    "points",
    KeyKind::Count(1, MOST_POINTS),
    "number of values, both ends included; 1 only if both ends are equal",
);
pub(crate) const AXIS_TOLERANCE: Key = optional(
    "tolerance",
    KeyKind::Quantity(Unit::Swept, Bound::Positive),
    "with [refine], the tolerance of an edge, in the unit of the key",
);

/// The table form of an axis; the present key decides the variant.
pub(crate) static AXIS: Keys = Keys {
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
                    required("linear", KeyKind::Range(Unit::Swept), "first and last value"),
                    POINTS,
                    AXIS_TOLERANCE,
                ],
            },
            Variant {
                name: "log",
                text: "values with a constant ratio",
                keys: &[
                    required("log", KeyKind::Range(Unit::Swept), "first and last value, of the same sign"),
                    POINTS,
                    Key {
                        text: "with [refine], the tolerance of an edge as a ratio, as in \"2 %\"",
                        ..AXIS_TOLERANCE
                    },
                ],
            },
            Variant {
                name: "uniform",
                text: "drawn uniformly",
                keys: &[required("uniform", KeyKind::Range(Unit::Swept), "smallest and largest value")],
            },
            Variant {
                name: "log_uniform",
                text: "drawn with a uniform logarithm",
                keys: &[required(
                    "log_uniform",
                    KeyKind::Range(Unit::Swept),
                    "smallest and largest value, of the same sign",
                )],
            },
        ],
    }),
};

impl Keyed for Keep {
    const FIELDS: &'static [Field<Self>] = &[
        field!(Keep: outcome,
            Key { name: "outcome", kind: KeyKind::Flag, absent: Absent::Flag(true),
                text: "settled, chatter, unstable or no-contact, with its measures" }),
        field!(
            Keep: tail,
            optional(
                "tail",
                KeyKind::Count(0, 1000),
                "number of last impacts and strobes of each run, for bifurcation diagrams; default 64 \
                 with one numeric axis, else 0",
            )
        ),
        field!(Keep: traces,
            Key { name: "traces", kind: KeyKind::Flag, absent: Absent::Flag(false),
                text: "the recorded signals of every run" }),
    ];
}

/// `[keep]`
pub(crate) static KEEP: Keys = Keys { keys: keys!(Keep::FIELDS), choice: None };

pub(crate) const TOLERANCE: Key = optional(
    "tolerance",
    KeyKind::Quantity(Unit::Of(Dimension::NONE), Bound::Above(0.0, 1.0)),
    "tolerance of an edge, as a share of each axis without its own; without any tolerance, four halvings",
);
pub(crate) const LEVELS: Key = optional(
    "levels",
    KeyKind::Count(1, 12),
    "instead of tolerances: how many times the grid is halved along boundaries; default 4",
);
/// Boundaries of the outcome itself.
pub(crate) const BY_OUTCOME: &str = "outcome";
const BY_STABILITY: &str = "stability";
pub(crate) const BY: Key = Key {
    name: "by",
    kind: KeyKind::Word(&[
        word(BY_STABILITY, "whether the force settles"),
        word(BY_OUTCOME, "the outcome itself; chatter and limit cycles then have a boundary too"),
    ]),
    absent: Absent::Word(BY_STABILITY),
    text: "property that changes across a boundary",
};

/// `[refine]`
pub(crate) static REFINE: Keys = Keys { keys: &[TOLERANCE, LEVELS, BY], choice: None };
