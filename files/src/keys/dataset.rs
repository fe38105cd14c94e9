//! Dataset files.

use feeler_catalogue::{Bound, Kind, Shape, Unit, Word, optional, required, word};
use feeler_plant::units::Dimension;

use feeler_plant::description::ENGAGEMENTS;

const ROLES: &[Word] = &[word("fit", "fitted"), word("check", "scored, never fitted")];

/// The top of a dataset file; `[columns.*]` and `[[experiments]]` are tables of their own.
pub(crate) static DATASET: Shape = Shape {
    keys: &[
        optional("name", Kind::Text, "short name; the folder's where absent"),
        optional("about", Kind::Text, "what was measured"),
        required("machine", Kind::Text, "the machine file, relative to this one: what is believed"),
    ],
    choice: None,
};

/// `[columns.*]`
pub(crate) static COLUMN: Shape = Shape {
    keys: &[
        required("signal", Kind::Signal, "what it is in the machine"),
        optional(
            "hold",
            Kind::Quantity(Unit::Of(Dimension::TIME), Bound::Positive),
            "time for which a command is held between controller samples",
        ),
        optional("noise", Kind::Quantity(Unit::Signal, Bound::NotNegative), "one sigma, where known"),
        optional(
            "resolution",
            Kind::Quantity(Unit::Signal, Bound::Positive),
            "smallest step of its values, where known",
        ),
    ],
    choice: None,
};

/// `[[experiments]]`
pub(crate) static EXPERIMENT: Shape = Shape {
    keys: &[
        required(
            "file",
            Kind::Text,
            "a CSV (commas, a header row), Parquet or MCAP file (JSON messages), relative to this one: `t_s` first, evenly sampled",
        ),
        optional("engagement", Kind::Word(ENGAGEMENTS), "overrides that of the machine's contacts"),
        optional("role", Kind::Word(ROLES), "where absent, the tool splits"),
        optional("repeat", Kind::Text, "experiments that share this name repeat each other"),
    ],
    choice: None,
};
