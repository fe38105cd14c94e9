//! The keys of a reference in files.

use feeler_catalogue::{
    Absent, Bound, Choice, Content, Dimension, Field, Form, Key, KeyKind, KeyRole, Keyed, Keys, Slot, Unit,
    Variant, chained, field, form, number, required, variants, words,
};

use super::prbs::{MAX_ORDER, MIN_ORDER};
use super::spec::{Between, ChirpSweep, Lines, ReferenceSpec};

words!(ChirpSweep {
    Linear = "linear", "constant hertz per second";
    Logarithmic = "logarithmic", "constant octaves per second";
});
words!(Lines {
    All = "all", "every multiple of 1 / period";
    Odd = "odd", "odd multiples: even distortion shows between them";
    OddSparse = "odd-sparse", "odd multiples with one in four omitted: odd distortion shows there";
});
words!(Between {
    Hold = "hold", "each value holds until the next";
    Linear = "linear", "straight lines";
});

const TIME: Unit = Unit::Of(Dimension::TIME);
const FREQUENCY: Unit = Unit::Of(Dimension::FREQUENCY);
const R: Unit = Unit::Reference;

/// A key whose value is one of some words; the first is the default.
const fn one_of(name: &'static str, words: &'static [feeler_catalogue::Word], text: &'static str) -> Key {
    Key { name, kind: KeyKind::Word(words), absent: Absent::Word(words[0].name), text }
}

const VALUE: Field<ReferenceSpec> = field!(ReferenceSpec: ReferenceSpec::Constant(value) => *value,
    required("value", KeyKind::Quantity(R, Bound::Any), "the value"));
const POINTS: Key = required("points", KeyKind::Points(R), "[[time, value], ...]");
const CORNERS: Field<ReferenceSpec> = field!(
    ReferenceSpec: ReferenceSpec::Steps(points) | ReferenceSpec::PiecewiseLinear(points) => *points,
    POINTS
);
pub(super) const AMPLITUDE: Field<ReferenceSpec> = field!(
    ReferenceSpec:
        ReferenceSpec::Chirp { amplitude, .. } | ReferenceSpec::Prbs { amplitude, .. } => *amplitude,
    required("amplitude", KeyKind::Quantity(R, Bound::Any), "amplitude about the mean")
);
pub(super) const RMS: Field<ReferenceSpec> = field!(
    ReferenceSpec: ReferenceSpec::Multisine { rms, .. } | ReferenceSpec::WhiteNoise { rms, .. } => *rms,
    required("rms", KeyKind::Quantity(R, Bound::Positive), "root mean square about the mean")
);
const OFFSET_KEY: Key = number("offset", R, Bound::Any, 0.0, "mean value");
pub(super) const OFFSET: Field<ReferenceSpec> = field!(
    ReferenceSpec: ReferenceSpec::Chirp { offset, .. }
        | ReferenceSpec::Multisine { offset, .. }
        | ReferenceSpec::WhiteNoise { offset, .. }
        | ReferenceSpec::Prbs { offset, .. }
        | ReferenceSpec::Table { offset, .. } => *offset,
    OFFSET_KEY
);
const BETWEEN_KEY: Key = one_of("between", Between::WORDS, "values between samples");
pub(super) const BAND: Field<ReferenceSpec> = Field {
    key: required("band", KeyKind::Range(FREQUENCY), "lowest and highest frequency"),
    role: KeyRole::Structure,
    get: |spec| match spec {
        ReferenceSpec::Multisine { low_hz, high_hz, .. }
        | ReferenceSpec::WhiteNoise { low_hz, high_hz, .. } => [*low_hz, *high_hz].content(),
        _ => None,
    },
    set: |spec, content| {
        if let (
            ReferenceSpec::Multisine { low_hz, high_hz, .. }
            | ReferenceSpec::WhiteNoise { low_hz, high_hz, .. },
            Content::Range(band),
        ) = (spec, content)
        {
            [*low_hz, *high_hz] = *band;
        }
    },
};

pub(super) const START: Field<ReferenceSpec> = field!(
    ReferenceSpec: ReferenceSpec::Chirp { start_hz, .. } => *start_hz,
    required("start", KeyKind::Quantity(FREQUENCY, Bound::NotNegative), "frequency at the start")
);
pub(super) const END: Field<ReferenceSpec> = field!(
    ReferenceSpec: ReferenceSpec::Chirp { end_hz, .. } => *end_hz,
    required("end", KeyKind::Quantity(FREQUENCY, Bound::Positive), "frequency at the end")
);
pub(super) const DURATION: Field<ReferenceSpec> = field!(
    ReferenceSpec: ReferenceSpec::Chirp { duration_s, .. } => *duration_s,
    required("duration", KeyKind::Quantity(TIME, Bound::Positive), "length of the sweep")
);
pub(super) const PERIOD: Field<ReferenceSpec> = field!(
    ReferenceSpec: ReferenceSpec::Multisine { period_s, .. } => *period_s,
    required("period", KeyKind::Quantity(TIME, Bound::Above(0.0, 1e4)), "its period")
);
pub(super) const CLOCK_PERIOD: Field<ReferenceSpec> = field!(
    ReferenceSpec: ReferenceSpec::Prbs { clock_period_s, .. } => *clock_period_s,
    required("clock_period", KeyKind::Quantity(TIME, Bound::Positive), "how long each chip is held")
);

/// The key of a field of the reference of a controller.
pub(super) fn key(field: &Field<ReferenceSpec>) -> String {
    format!("{}.{}", FOLLOWED.name, field.key.name)
}

const CHIRP: &[Field<ReferenceSpec>] = &[
    AMPLITUDE,
    START,
    END,
    DURATION,
    field!(ReferenceSpec: ReferenceSpec::Chirp { sweep, .. } => *sweep,
        one_of("sweep", ChirpSweep::WORDS, "how the frequency changes")),
    OFFSET,
];

const MULTISINE: &[Field<ReferenceSpec>] = &[
    RMS,
    BAND,
    PERIOD,
    field!(ReferenceSpec: ReferenceSpec::Multisine { lines, .. } => *lines,
        one_of("lines", Lines::WORDS, "which frequencies are excited")),
    OFFSET,
];

const PRBS: &[Field<ReferenceSpec>] = &[
    AMPLITUDE,
    CLOCK_PERIOD,
    field!(ReferenceSpec: ReferenceSpec::Prbs { order, .. } => *order,
        required("order", KeyKind::Count(MIN_ORDER as u64, MAX_ORDER as u64),
            "length of the shift register; it repeats after 2^order - 1 chips")),
    OFFSET,
];

const SAMPLES: &[Field<ReferenceSpec>] = &[
    Field {
        key: POINTS,
        role: KeyRole::Structure,
        get: |spec| match spec {
            ReferenceSpec::Table { times_s, values, .. } => {
                let pairs = times_s.iter().copied().zip(values.iter().copied());
                pairs.collect::<Vec<_>>().content()
            }
            _ => None,
        },
        set: |spec, content| {
            if let (ReferenceSpec::Table { times_s, values, .. }, Content::Points(points)) = (spec, content) {
                (*times_s, *values) = points.iter().copied().unzip();
            }
        },
    },
    field!(ReferenceSpec: ReferenceSpec::Table { between, .. } => *between, BETWEEN_KEY),
    OFFSET,
];

/// The table form of a reference.
impl Keyed for ReferenceSpec {
    const FIELDS: &'static [Field<Self>] = &[];
    const FORMS: &'static [Form<Self>] = &[
        form!("constant", "one value throughout the run", ReferenceSpec: ReferenceSpec::Constant(_),
            ReferenceSpec::Constant(0.0), &[VALUE] as &[Field<ReferenceSpec>]),
        form!("steps", "each value holds from its time until the next; zero before the first",
            ReferenceSpec: ReferenceSpec::Steps(_), ReferenceSpec::Steps(Vec::new()),
            &[CORNERS] as &[Field<ReferenceSpec>]),
        form!("ramp", "straight lines between points; the first and last values hold outside",
            ReferenceSpec: ReferenceSpec::PiecewiseLinear(_), ReferenceSpec::PiecewiseLinear(Vec::new()),
            &[CORNERS] as &[Field<ReferenceSpec>]),
        form!("chirp", "a sine of changing frequency, from t = 0", ReferenceSpec: ReferenceSpec::Chirp { .. },
            ReferenceSpec::Chirp { sweep: ChirpSweep::default(), amplitude: 1.0, start_hz: 1.0, end_hz: 1.0,
                duration_s: 1.0, offset: 0.0 }, CHIRP),
        form!("multisine", "periodic, flat over a band, of random phases and low crest factor",
            ReferenceSpec: ReferenceSpec::Multisine { .. },
            ReferenceSpec::Multisine { lines: Lines::default(), low_hz: 0.0, high_hz: 1.0, period_s: 1.0,
                rms: 1.0, offset: 0.0 }, MULTISINE),
        form!("white-noise", "Gaussian, flat over a band", ReferenceSpec: ReferenceSpec::WhiteNoise { .. },
            ReferenceSpec::WhiteNoise { low_hz: 0.0, high_hz: 1.0, rms: 1.0, offset: 0.0 },
            &[RMS, BAND, OFFSET] as &[Field<ReferenceSpec>]),
        form!("prbs", "a maximum-length pseudo-random binary sequence",
            ReferenceSpec: ReferenceSpec::Prbs { .. },
            ReferenceSpec::Prbs { order: MIN_ORDER, clock_period_s: 1.0, amplitude: 1.0, offset: 0.0 }, PRBS),
        form!("samples", "a list of samples", ReferenceSpec: ReferenceSpec::Table { .. },
            ReferenceSpec::samples(Vec::new(), Vec::new()), SAMPLES),
    ];
}

impl ReferenceSpec {
    /// The reference of a key with a value, points, or a table; `None` for a file of samples.
    pub fn of_content(content: &Content) -> Option<Self> {
        match content {
            Content::Number(value) => Some(Self::Constant(*value)),
            Content::Points(points) => Some(Self::Steps(points.clone())),
            Content::Table(table) => Self::read(table),
            _ => None,
        }
    }

    /// The content of a key for this reference.
    pub fn as_content(&self) -> Content {
        match self {
            Self::Constant(value) => Content::Number(*value),
            Self::Steps(points) => Content::Points(points.clone()),
            _ => Content::Table(self.contents()),
        }
    }
}

/// The key that names a file of samples.
pub const SAMPLES_PATH: Key = required("file", KeyKind::Text, "the file, relative to this one");

/// The form of a reference with samples in a file. The reader of the file fills it in.
pub const SAMPLES_FILE: Variant = Variant {
    name: "file",
    text: "samples from a CSV file with the header `t_s,value`",
    keys: &[SAMPLES_PATH, BETWEEN_KEY, OFFSET_KEY],
};

/// The table form of a `reference`.
pub static REFERENCE: Keys = Keys {
    keys: &[],
    choice: Some(Choice { key: "kind", default: None, text: "its shape", variants: &SHAPES }),
};

const FORMS: [Variant; ReferenceSpec::FORMS.len()] = variants(ReferenceSpec::FORMS);
const SHAPES: [Variant; FORMS.len() + 1] = chained(&FORMS, &[SAMPLES_FILE]);

/// The key of the quantity that a controller follows.
pub const FOLLOWED: Key = Key {
    name: crate::error::REFERENCE,
    kind: KeyKind::Reference(&REFERENCE),
    absent: Absent::Number(0.0),
    text: "what to follow: a value, [[time, value], ...] for steps, or a table with `kind`",
};
