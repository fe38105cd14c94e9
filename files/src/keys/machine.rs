//! Bodies, springs, contacts, actuators, sensors.

use feeler_catalogue::{
    Absent, Bound, Choice, Key, Kind, LONGEST_DELAY, Shape, Unit, Variant, Word, low_pass, number, optional,
    required, word,
};
use feeler_plant::effects::HostKind;
use feeler_plant::units::Dimension;

use super::Element;
use super::surface::{PROFILE, SURFACE};

const MASS: Unit = Unit::Of(Dimension::MASS);
const LENGTH: Unit = Unit::Of(Dimension::LENGTH);
const VELOCITY: Unit = Unit::Of(Dimension::VELOCITY);
const STIFFNESS: Unit = Unit::Of(Dimension::STIFFNESS);
const DAMPING: Unit = Unit::Of(Dimension::DAMPING);
const TIME: Unit = Unit::Of(Dimension::TIME);
const FREQUENCY: Unit = Unit::Of(Dimension::FREQUENCY);
const NUMBER: Unit = Unit::Of(Dimension::NONE);

const BODY: Kind = Kind::Name("a body or `ground`");

/// `[bodies.*]`
pub(crate) static BODIES: Element = Element {
    table: "bodies",
    singular: "body",
    text: "Lumped masses. `ground` is the fixed body and needs no entry. All springs are relaxed where every position is zero.",
    shape: Shape {
        keys: &[
            required("mass", Kind::Quantity(MASS, Bound::Within(1e-15, 1e12)), "mass"),
            number("position", LENGTH, Bound::Any, 0.0, "position at the start"),
            number("velocity", VELOCITY, Bound::Any, 0.0, "velocity at the start"),
        ],
        choice: None,
    },
    hosts: &[HostKind::Body],
};

/// `[springs.*]`
pub(crate) static SPRINGS: Element = Element {
    table: "springs",
    singular: "spring",
    text: "Springs and dampers between two bodies; without stiffness a viscous guide; with `rigid` a joint.",
    shape: Shape {
        keys: &[
            required(
                "between",
                Kind::Pair,
                "the two bodies; elongation is the position of the second minus that of the first",
            ),
            number("stiffness", STIFFNESS, Bound::NotNegative, 0.0, "stiffness"),
            number("damping", DAMPING, Bound::NotNegative, 0.0, "viscous damping"),
            Key {
                name: "rigid",
                kind: Kind::Flag,
                absent: Absent::Flag(false),
                text: "the two bodies move as one, and each keeps its own signals",
            },
        ],
        choice: None,
    },
    hosts: &[HostKind::Spring, HostKind::RigidSpring],
};

/// How tip and workpiece hold on to each other.
pub(crate) const ENGAGEMENTS: &[Word] = &[
    word("clamped", "attached where the bodies stand at the start; the gap counts as zero"),
    word("unilateral", "pushes only"),
    word("free", "absent"),
];

/// `[contacts.*]`
pub(crate) static CONTACTS: Element = Element {
    table: "contacts",
    singular: "contact",
    text: "Where the tool meets the workpiece: the force sensor is this spring, compressed by d = x_tip - x_work - gap.",
    shape: Shape {
        keys: &[
            required(
                "between",
                Kind::Pair,
                "tip and workpiece, in this order; the workpiece may be `ground`",
            ),
            Key {
                name: "engagement",
                kind: Kind::Word(ENGAGEMENTS),
                absent: Absent::Word("unilateral"),
                text: "how tip and workpiece hold on to each other",
            },
            optional(
                "stiffness",
                Kind::Quantity(Unit::PowerStiffness, Bound::Positive),
                "k; may be left out of a `hertz` law between materials",
            ),
            number("damping", DAMPING, Bound::NotNegative, 0.0, "linear damping c"),
            number(
                "gap",
                LENGTH,
                Bound::Any,
                0.0,
                "distance to close before they touch, where all positions are zero",
            ),
            optional(
                "surface",
                Kind::Table(&SURFACE),
                "shapes whose distance is added to the gap while the tip travels sideways",
            ),
            optional("profile", Kind::Table(&PROFILE), "what is added to the gap over time, written out"),
        ],
        choice: Some(Choice {
            key: "law",
            default: Some("kelvin-voigt"),
            text: "force against compression d and its rate d', for d > 0",
            variants: &[
                Variant { name: "kelvin-voigt", text: "k d + c d'", keys: &[] },
                Variant {
                    name: "hunt-crossley",
                    text: "k d^n (1 + alpha d')",
                    keys: &[
                        required(
                            "alpha",
                            Kind::Quantity(Unit::Of(Dimension::INVERSE_VELOCITY), Bound::NotNegative),
                            "alpha",
                        ),
                        number("exponent", NUMBER, Bound::Within(1.0, 5.0), 1.0, "n"),
                    ],
                },
                Variant { name: "hertz", text: "k d^1.5 + c d'", keys: &[] },
            ],
        }),
    },
    hosts: &[HostKind::Contact],
};

/// `[actuators.*]`
pub(crate) static ACTUATORS: Element = Element {
    table: "actuators",
    singular: "actuator",
    text: "Drives: a force on one body and its reaction on another.",
    shape: Shape {
        keys: &[
            required("on", BODY, "the body that a positive force pushes towards +x"),
            Key {
                name: "reacts_on",
                kind: BODY,
                absent: Absent::Word("ground"),
                text: "the body that carries the reaction",
            },
            optional("limit", Kind::Quantity(Unit::Of(Dimension::FORCE), Bound::Positive), "largest effort"),
        ],
        choice: Some(Choice {
            key: "kind",
            default: Some("force"),
            text: "how a command becomes a force",
            variants: &[
                Variant {
                    name: "force",
                    text: "a current amplifier: the command is the force",
                    keys: &[
                        optional(
                            "rate_limit",
                            Kind::Quantity(Unit::Of(Dimension::FORCE_RATE), Bound::Positive),
                            "largest rate of the force",
                        ),
                        optional(
                            "bandwidth",
                            Kind::Quantity(FREQUENCY, Bound::Positive),
                            "first-order bandwidth of the current loop",
                        ),
                    ],
                },
                Variant {
                    name: "velocity-source",
                    text: "a voltage amplifier: tau df/dt + f = b_a (command - velocity)",
                    keys: &[
                        required(
                            "damping",
                            Kind::Quantity(DAMPING, Bound::Positive),
                            "b_a, force per velocity error",
                        ),
                        required("time_constant", Kind::Quantity(TIME, Bound::Positive), "tau"),
                        optional(
                            "rate_limit",
                            Kind::Quantity(Unit::Of(Dimension::ACCELERATION), Bound::Positive),
                            "largest rate of the commanded velocity",
                        ),
                    ],
                },
            ],
        }),
    },
    hosts: &[HostKind::Actuator],
};

/// `[sensors.*]`
pub(crate) static SENSORS: Element = Element {
    table: "sensors",
    singular: "sensor",
    text: "What is measured: `gain` times the filtered, delayed signal, plus `bias` and noise, rounded to `resolution`.",
    shape: Shape {
        keys: &[
            required(
                "reads",
                Kind::Signal,
                "the signal, as in motor.position, tip.acceleration or tool.spring_force",
            ),
            optional(
                "relative_to",
                BODY,
                "the body it rides on, for position and velocity; absolute where absent",
            ),
            number("gain", NUMBER, Bound::Any, 1.0, "scale"),
            number("bias", Unit::Signal, Bound::Any, 0.0, "offset"),
            low_pass("analogue filter before sampling: a corner frequency, or a table"),
            number("delay", TIME, LONGEST_DELAY, 0.0, "pure delay"),
            optional("resolution", Kind::Quantity(Unit::Signal, Bound::Positive), "quantisation step"),
            number(
                "noise",
                Unit::Signal,
                Bound::NotNegative,
                0.0,
                "one sigma of white Gaussian noise per reading",
            ),
        ],
        choice: None,
    },
    hosts: &[HostKind::ForceSensor, HostKind::MotionSensor],
};
