//! Dataset files.

use std::path::PathBuf;

use feeler_catalogue::{
    Bound, Dimension, Field, Key, KeyKind, Keyed, Keys, Unit, field, joined, keys, number, optional,
    required, words,
};
use feeler_plant::description::{Engagement, SignalName};

/// The key of its name.
pub const NAME: Key = optional("name", KeyKind::Text, "short name; the folder's if absent");
pub(crate) const ABOUT: Key = optional("about", KeyKind::Text, "what was measured");
/// The key of the machine's file.
pub const MACHINE: Key =
    required("machine", KeyKind::Text, "the file of the believed machine, relative to this one");

/// The table of the columns.
pub const COLUMNS: &str = "columns";
/// The list of the experiments.
pub const EXPERIMENTS: &str = "experiments";

/// The top of a dataset file; `[columns.*]` and `[[experiments]]` are tables of their own.
pub(crate) static DATASET: Keys = Keys { keys: &[NAME, ABOUT, MACHINE, CLOCK, RATE], choice: None };

/// The key of the unit of all clocks.
pub(crate) const CLOCK: Key = optional(
    "clock",
    KeyKind::Word(LogClock::WORDS),
    "unit of the clock of all files, if it differs from their headers",
);

/// The key of the rate of rows without a clock.
pub(crate) const RATE: Key = optional(
    "rate",
    KeyKind::Quantity(Unit::Of(Dimension::FREQUENCY), Bound::Positive),
    "rate of the rows of files in which no column is a clock",
);

/// Unit of the clock of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LogClock {
    Seconds,
    Milliseconds,
    Microseconds,
    Nanoseconds,
}

words!(LogClock {
    Seconds = "s", "seconds";
    Milliseconds = "ms", "milliseconds";
    Microseconds = "us", "microseconds";
    Nanoseconds = "ns", "nanoseconds";
});

/// A column of every file.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnSpec {
    /// Signal of the column in the machine.
    pub signal: SignalName,
    /// Time for which a command is held between controller samples.
    pub hold_s: Option<f64>,
    /// Standard deviation in the signal's own unit, if known.
    pub noise: Option<f64>,
    /// Resolution in the signal's own unit, if known.
    pub resolution: Option<f64>,
    /// Number of the column in the files, from one, in place of a name.
    pub number: Option<usize>,
    /// Factor on the numbers in the files, including their unit.
    pub scale: f64,
    /// Offset that is added after scaling, in the signal's own unit.
    pub offset: f64,
}

impl ColumnSpec {
    /// A column under its own name, with values in SI.
    pub fn plain(signal: SignalName) -> Self {
        Self { signal, hold_s: None, noise: None, resolution: None, number: None, scale: 1.0, offset: 0.0 }
    }

    /// Whether the numbers in the files are the signal in SI.
    pub fn is_si(&self) -> bool {
        self.scale.to_bits() == 1.0_f64.to_bits() && self.offset.to_bits() == 0
    }
}

/// One experiment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Experiment {
    /// The log, relative to the dataset.
    pub file: PathBuf,
    /// Engagement that replaces that of the machine's contacts.
    pub engagement: Option<Engagement>,
    /// Use of the experiment; by default the diagnosis splits the experiments.
    pub role: Option<ExperimentRole>,
    /// Experiments with the same name are repetitions of each other.
    pub repeat: Option<String>,
}

/// Use of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ExperimentRole {
    /// The experiment is fitted.
    Fit,
    /// The experiment is scored, never fitted.
    Check,
}

words!(ExperimentRole {
    Fit = "fit", "fitted";
    Check = "check", "scored, never fitted";
});

/// The key of a column's signal.
pub const SIGNAL: Key = required("signal", KeyKind::Signal, "its signal in the machine");

/// The key of the unit of a column's numbers.
pub const UNIT: Key =
    optional("unit", KeyKind::Text, "unit of the numbers in the file; if absent, the SI unit of the signal");

impl ColumnSpec {
    /// The key of the factor on its numbers.
    pub const SCALE: Field<Self> = field!(ColumnSpec: scale,
        number("scale", Unit::Of(Dimension::NONE), Bound::Any, 1.0,
            "factor on the numbers in the file, as for counts or a sign"));
}

/// All keys except signal and unit, on which these keys depend.
impl Keyed for ColumnSpec {
    const FIELDS: &'static [Field<Self>] = &[
        field!(
            ColumnSpec: hold_s,
            optional(
                "hold",
                KeyKind::Quantity(Unit::Of(Dimension::TIME), Bound::Positive),
                "time for which a command is held between controller samples; if absent, a force or voltage \
                 goes in straight lines from row to row (a diagnosis fits its instant, within half a row)",
            )
        ),
        field!(ColumnSpec: noise,
            optional("noise", KeyKind::Quantity(Unit::Signal, Bound::NotNegative),
                "standard deviation, if known")),
        field!(ColumnSpec: resolution,
            optional("resolution", KeyKind::Quantity(Unit::Signal, Bound::Positive),
                "smallest step of its values, if known")),
        field!(ColumnSpec: number,
            optional("column", KeyKind::Count(1, 1_000_000),
                "its number in the file, from 1, in place of its name")),
        ColumnSpec::SCALE,
        field!(ColumnSpec: offset,
            number("offset", Unit::Signal, Bound::Any, 0.0, "added to them after the factor")),
    ];
}

/// `[columns.*]`
pub(crate) static COLUMN: Keys =
    Keys { keys: joined!(&[SIGNAL, UNIT] as &[Key], keys!(ColumnSpec::FIELDS)), choice: None };

/// The key of an experiment's file.
pub const FILE: Key = required(
    "file",
    KeyKind::Text,
    "a log, relative to this file: CSV, MCAP, ROS 2 bag, Parquet, npz or npy",
);

/// All keys except the file, whose path is relative to the dataset.
impl Keyed for Experiment {
    const FIELDS: &'static [Field<Self>] = &[
        field!(Experiment: engagement,
            optional("engagement", KeyKind::Word(Engagement::WORDS),
                "overrides the engagement of the machine's contacts")),
        field!(Experiment: role,
            optional("role", KeyKind::Word(ExperimentRole::WORDS),
                "if absent, the diagnosis splits the experiments")),
        field!(Experiment: repeat,
            optional("repeat", KeyKind::Text, "experiments with the same name are repetitions")),
    ];
}

/// `[[experiments]]`
pub(crate) static EXPERIMENT: Keys =
    Keys { keys: joined!(&[FILE] as &[Key], keys!(Experiment::FIELDS)), choice: None };
