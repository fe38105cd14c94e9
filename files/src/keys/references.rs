//! References and excitations.

use feeler_catalogue::{
    Absent, Bound, Choice, Key, Kind, Shape, Unit, Variant, Word, number, required, word,
};
use feeler_plant::units::Dimension;

const TIME: Unit = Unit::Of(Dimension::TIME);
const FREQUENCY: Unit = Unit::Of(Dimension::FREQUENCY);
const R: Unit = Unit::Reference;

const OFFSET: Key = number("offset", R, Bound::Any, 0.0, "mean value");
const BAND: Key = required("band", Kind::Range(FREQUENCY), "lowest and highest frequency");
const RMS: Key = required("rms", Kind::Quantity(R, Bound::Positive), "root mean square about the mean");
const AMPLITUDE: Key = required("amplitude", Kind::Quantity(R, Bound::Any), "amplitude about the mean");

const BETWEEN: Key = words(
    "between",
    &[word("hold", "each value holds until the next"), word("linear", "straight lines")],
    "hold",
    "what lies between samples",
);

const fn words(name: &'static str, words: &'static [Word], default: &'static str, text: &'static str) -> Key {
    Key { name, kind: Kind::Word(words), absent: Absent::Word(default), text }
}

/// Orders of the pseudo-random sequences there are.
pub(crate) const PRBS_ORDERS: (u64, u64) = (2, 18);

/// The table form of a `reference`.
pub(crate) static REFERENCE: Shape = Shape {
    keys: &[],
    choice: Some(Choice {
        key: "kind",
        default: None,
        text: "its shape",
        variants: &[
            Variant {
                name: "constant",
                text: "one value for ever",
                keys: &[required("value", Kind::Quantity(R, Bound::Any), "the value")],
            },
            Variant {
                name: "steps",
                text: "each value from its time on; zero before the first",
                keys: &[required("points", Kind::Points(R), "[[time, value], ...]")],
            },
            Variant {
                name: "ramp",
                text: "straight lines between points; the first and last values hold outside",
                keys: &[required("points", Kind::Points(R), "[[time, value], ...]")],
            },
            Variant {
                name: "chirp",
                text: "a sine of moving frequency from t = 0 on",
                keys: &[
                    AMPLITUDE,
                    required(
                        "start",
                        Kind::Quantity(FREQUENCY, Bound::NotNegative),
                        "frequency at the start",
                    ),
                    required("end", Kind::Quantity(FREQUENCY, Bound::Positive), "frequency at the end"),
                    required("duration", Kind::Quantity(TIME, Bound::Positive), "length of the sweep"),
                    words(
                        "sweep",
                        &[
                            word("linear", "so many hertz per second"),
                            word("logarithmic", "so many octaves per second"),
                        ],
                        "linear",
                        "how the frequency moves",
                    ),
                    OFFSET,
                ],
            },
            Variant {
                name: "multisine",
                text: "periodic, flat over a band, of random phases and low crest factor",
                keys: &[
                    RMS,
                    BAND,
                    required("period", Kind::Quantity(TIME, Bound::Above(0.0, 1e4)), "its period"),
                    words(
                        "lines",
                        &[
                            word("all", "every multiple of 1 / period"),
                            word("odd", "odd ones: even distortion shows between them"),
                            word(
                                "odd-sparse",
                                "odd ones with one of four left out: odd distortion shows there",
                            ),
                        ],
                        "all",
                        "which frequencies are excited",
                    ),
                    OFFSET,
                ],
            },
            Variant { name: "white-noise", text: "Gaussian, flat over a band", keys: &[RMS, BAND, OFFSET] },
            Variant {
                name: "prbs",
                text: "a maximum-length pseudo-random binary sequence",
                keys: &[
                    AMPLITUDE,
                    required(
                        "clock_period",
                        Kind::Quantity(TIME, Bound::Positive),
                        "how long each chip is held",
                    ),
                    required(
                        "order",
                        Kind::Count(PRBS_ORDERS.0, PRBS_ORDERS.1),
                        "length of the shift register; it repeats after 2^order - 1 chips",
                    ),
                    OFFSET,
                ],
            },
            Variant {
                name: "samples",
                text: "samples written out",
                keys: &[required("points", Kind::Points(R), "[[time, value], ...]"), BETWEEN, OFFSET],
            },
            Variant {
                name: "file",
                text: "samples from a CSV file with the header `t_s,value`",
                keys: &[required("file", Kind::Text, "the file, relative to this one"), BETWEEN, OFFSET],
            },
        ],
    }),
};
