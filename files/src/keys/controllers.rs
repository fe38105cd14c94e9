//! Controllers.

use feeler_control::Approach;
use feeler_plant::effects::HostKind;
use feeler_plant::units::Dimension;

use super::REFERENCE;
use super::machine::{LONGEST_DELAY, LOW_PASS};
use crate::shape::{
    Absent, Bound, Choice, Element, Key, Kind, Shape, Unit, Variant, Word, number, optional, required, word,
};

const TIME: Unit = Unit::Of(Dimension::TIME);
const FREQUENCY: Unit = Unit::Of(Dimension::FREQUENCY);
const FORCE: Unit = Unit::Of(Dimension::FORCE);

/// No controller is sampled a billion times a second.
const SHORTEST_PERIOD: Bound = Bound::Within(1e-9, 1e6);

const fn per(mass: i8, length: i8, time: i8) -> Unit {
    Unit::OutputPer(Dimension { mass, length, time, any_length: false })
}

const PER_FORCE: Unit = Unit::OutputPer(Dimension::FORCE);
const PER_FORCE_TIME: Unit = per(1, 1, -1);
const PER_FORCE_RATE: Unit = Unit::OutputPer(Dimension::FORCE_RATE);
const PER_LENGTH: Unit = Unit::OutputPer(Dimension::LENGTH);
const PER_LENGTH_TIME: Unit = per(0, 1, 1);
const PER_VELOCITY: Unit = Unit::OutputPer(Dimension::VELOCITY);

const DERIVATIVE_FILTER: Key = number(
    "derivative_filter",
    TIME,
    Bound::NotNegative,
    0.0,
    "time constant of the first-order filter on the derivative",
);
const ANTI_WINDUP: Key = Key {
    name: "anti_windup",
    kind: Kind::WordOrTable(ANTI_WINDUPS, &TRACKING),
    absent: Absent::Word("conditional"),
    text: "what the integrator does at the output limit; { tracking_time = ... } drives it back at that time constant",
};
const ANTI_WINDUPS: &[Word] = &[
    word("conditional", "it stops while the error would drive the output further"),
    word("off", "it winds up"),
];

static TRACKING: Shape = Shape {
    keys: &[required("tracking_time", Kind::Quantity(TIME, Bound::Positive), "tracking time constant")],
    choice: None,
};

static LEAD: Shape = Shape {
    keys: &[
        required("zero", Kind::Quantity(FREQUENCY, Bound::Positive), "frequency of the zero"),
        required(
            "pole",
            Kind::Quantity(FREQUENCY, Bound::Positive),
            "frequency of the pole; below the zero's it is a lag",
        ),
    ],
    choice: None,
};

static APPROACH: Shape = Shape {
    keys: &[
        required(
            "speed",
            Kind::Quantity(Unit::Of(Dimension::VELOCITY), Bound::Positive),
            "speed towards the workpiece",
        ),
        required(
            "until",
            Kind::Quantity(FORCE, Bound::Any),
            "the phase ends at the first sample whose reading is at least this",
        ),
        optional(
            "release",
            Kind::Quantity(FORCE, Bound::Any),
            "it starts again below this, at most `until`; where absent, contact latches",
        ),
        number(
            "bandwidth",
            FREQUENCY,
            Bound::Positive,
            Approach::DEFAULT_BANDWIDTH_HZ,
            "of the position loop that moves a force drive",
        ),
    ],
    choice: None,
};

/// `[controllers.*]`
pub(crate) static CONTROLLERS: Element = Element {
    table: "controllers",
    singular: "controller",
    text: "Sampled-data controllers. Every `period` one reads its sensors, computes, and after `delay` its output is applied and held. \
           Several on one actuator add.",
    shape: Shape {
        keys: &[
            required("drives", Kind::Name("an actuator"), "the actuator whose command it gives"),
            optional(
                "motion",
                Kind::Name("a sensor of position or velocity"),
                "sensor for damping, impedance and the approach; where absent, the first that reads position or velocity of the driven body",
            ),
            required(
                "period",
                Kind::Quantity(TIME, SHORTEST_PERIOD),
                "time between samples; t = 0 is a sample",
            ),
            number(
                "delay",
                TIME,
                LONGEST_DELAY,
                0.0,
                "from a sample to the instant at which its output is applied; any number",
            ),
            number(
                "jitter",
                TIME,
                Bound::NotNegative,
                0.0,
                "one sigma of each sample instant about its nominal time",
            ),
            number("offset", TIME, Bound::NotNegative, 0.0, "time of the first sample"),
            optional(
                "output_resolution",
                Kind::Quantity(Unit::Output, Bound::Positive),
                "step of the output",
            ),
            optional(
                "output_limit",
                Kind::Quantity(Unit::Output, Bound::Positive),
                "largest output, against which the anti-windup works",
            ),
            optional(
                "low_pass",
                Kind::QuantityOrTable("corner", FREQUENCY, &LOW_PASS),
                "discrete filter on the reading: a corner frequency, or a table",
            ),
            number(
                "velocity_filter",
                TIME,
                Bound::NotNegative,
                0.0,
                "time constant of the filter on a velocity got by differencing positions",
            ),
            optional(
                "approach",
                Kind::Table(&APPROACH),
                "the phase before contact: move at a set speed until the reading reaches a force",
            ),
            Key {
                name: "reference",
                kind: Kind::Reference(&REFERENCE),
                absent: Absent::Number(0.0),
                text: "what to follow: a value, [[time, value], ...] for steps, or a table with `kind`",
            },
        ],
        choice: Some(Choice {
            key: "law",
            default: None,
            text: "the control law",
            variants: &[
                Variant {
                    name: "explicit-force",
                    text: "u = feed_forward r + kp e + ki int(e) + kd de/dt - damping v, e = r - f",
                    keys: &[
                        required("reads", Kind::Name("a force sensor"), "the sensor it controls"),
                        number(
                            "feed_forward",
                            PER_FORCE,
                            Bound::Any,
                            0.0,
                            "from the reference to the output",
                        ),
                        number("kp", PER_FORCE, Bound::Any, 0.0, "proportional gain"),
                        number("ki", PER_FORCE_TIME, Bound::Any, 0.0, "integral gain"),
                        number("kd", PER_FORCE_RATE, Bound::Any, 0.0, "derivative gain"),
                        number(
                            "damping",
                            PER_VELOCITY,
                            Bound::Any,
                            0.0,
                            "joint damping, on the motion sensor's velocity",
                        ),
                        DERIVATIVE_FILTER,
                        optional(
                            "lead",
                            Kind::Table(&LEAD),
                            "lead compensator in series: { zero, pole }, gain 1 at zero frequency",
                        ),
                        ANTI_WINDUP,
                    ],
                },
                Variant {
                    name: "position",
                    text: "u = kp e + ki int(e) + kd de/dt - damping v, e = r - x",
                    keys: &[
                        required("reads", Kind::Name("a position sensor"), "the sensor it controls"),
                        number("kp", PER_LENGTH, Bound::Any, 0.0, "proportional gain"),
                        number("ki", PER_LENGTH_TIME, Bound::Any, 0.0, "integral gain"),
                        number("kd", PER_VELOCITY, Bound::Any, 0.0, "derivative gain, on the error"),
                        number("damping", PER_VELOCITY, Bound::Any, 0.0, "on the measured velocity alone"),
                        DERIVATIVE_FILTER,
                        ANTI_WINDUP,
                    ],
                },
                Variant {
                    name: "impedance",
                    text: "f_d = stiffness (x_r - x) + damping (v_r - v), u = f_d + force_gain (f_d - f)",
                    keys: &[
                        optional(
                            "reads",
                            Kind::Name("a force sensor"),
                            "the force sensor, where force_gain is not zero or there is an approach",
                        ),
                        number("stiffness", PER_LENGTH, Bound::Any, 0.0, "of the programmed spring"),
                        number("damping", PER_VELOCITY, Bound::Any, 0.0, "of the programmed damper"),
                        number(
                            "force_gain",
                            Unit::Of(Dimension::NONE),
                            Bound::Any,
                            0.0,
                            "of the inner force loop",
                        ),
                    ],
                },
                Variant {
                    name: "admittance",
                    text: "mass a_v + damping v_v + stiffness (x_v - x_0) = r - f; u = kp (x_v - x) + kd (v_v - v) + velocity_feed_forward v_v",
                    keys: &[
                        required("reads", Kind::Name("a force sensor"), "the force sensor"),
                        number("mass", Unit::Of(Dimension::MASS), Bound::NotNegative, 0.0, "virtual mass"),
                        number(
                            "damping",
                            Unit::Of(Dimension::DAMPING),
                            Bound::NotNegative,
                            0.0,
                            "virtual damping",
                        ),
                        number(
                            "stiffness",
                            Unit::Of(Dimension::STIFFNESS),
                            Bound::NotNegative,
                            0.0,
                            "virtual stiffness",
                        ),
                        number("kp", PER_LENGTH, Bound::Any, 0.0, "inner loop, on position"),
                        number("kd", PER_VELOCITY, Bound::Any, 0.0, "inner loop, on velocity"),
                        number(
                            "velocity_feed_forward",
                            PER_VELOCITY,
                            Bound::Any,
                            0.0,
                            "on the virtual body's velocity",
                        ),
                    ],
                },
                Variant {
                    name: "open-loop",
                    text: "the output is the reference: an excitation of the drive",
                    keys: &[],
                },
            ],
        }),
    },
    hosts: &[HostKind::Controller],
};
