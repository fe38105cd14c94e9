//! Drives.

use feeler_catalogue::{
    Absent, Bound, Dimension, Field, Form, Key, Kind, Record, Unit, field, form, optional, required,
};

use super::GROUND;
use crate::effects::EffectUse;

/// A drive: a force on one body and its reaction on another.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// The body that is pushed towards +x by a positive force.
    pub on: String,
    /// The body that carries the reaction.
    pub reacts_on: String,
    /// How a command becomes a force.
    pub kind: ActuatorKind,
    /// Effort limit, > 0; none where absent.
    pub limit_n: Option<f64>,
    /// Largest rate of the effort, > 0 (N/s; of the commanded velocity, m/s², for a velocity source).
    pub rate_limit_per_s: Option<f64>,
    /// Departures from the ideal drive.
    pub effects: Vec<EffectUse>,
}

impl Actuator {
    /// A drive whose force is its command, at once and without limit.
    pub fn ideal(on: impl Into<String>, reacts_on: impl Into<String>) -> Self {
        Self {
            on: on.into(),
            reacts_on: reacts_on.into(),
            kind: ActuatorKind::Force { bandwidth_hz: None },
            limit_n: None,
            rate_limit_per_s: None,
            effects: Vec::new(),
        }
    }
}

/// How a command becomes a force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ActuatorKind {
    /// A high-bandwidth current amplifier: the command is the force (N).
    Force {
        /// First-order bandwidth of the current loop, where it matters.
        bandwidth_hz: Option<f64>,
    },
    /// The paper's Fig. 2, a voltage amplifier: the command is a velocity `v_c`, and
    /// `tau df_a/dt + f_a = b_a (v_c - v)`.
    VelocitySource {
        /// `b_a`, force per velocity error.
        damping_n_s_per_m: f64,
        /// `tau`, > 0.
        time_constant_s: f64,
    },
}

impl ActuatorKind {
    /// Dimension of the command.
    pub fn command(&self) -> Dimension {
        match self {
            Self::Force { .. } => Dimension::FORCE,
            Self::VelocitySource { .. } => Dimension::VELOCITY,
        }
    }
}

const BODY: Kind = Kind::Name("a body or `ground`");

const FORCE: &[Field<Actuator>] = &[
    field!(
        Actuator: rate_limit_per_s,
        optional(
            "rate_limit",
            Kind::Quantity(Unit::Of(Dimension::FORCE_RATE), Bound::Positive),
            "largest rate of the force",
        )
    ),
    field!(
        Actuator: Actuator { kind: ActuatorKind::Force { bandwidth_hz }, .. } => *bandwidth_hz,
        optional(
            "bandwidth",
            Kind::Quantity(Unit::Of(Dimension::FREQUENCY), Bound::Positive),
            "first-order bandwidth of the current loop",
        )
    ),
];

const VELOCITY_SOURCE: &[Field<Actuator>] = &[
    field!(
        Actuator: Actuator { kind: ActuatorKind::VelocitySource { damping_n_s_per_m, .. }, .. } => *damping_n_s_per_m,
        required(
            "damping",
            Kind::Quantity(Unit::Of(Dimension::DAMPING), Bound::Positive),
            "b_a, force per velocity error",
        )
    ),
    field!(
        Actuator: Actuator { kind: ActuatorKind::VelocitySource { time_constant_s, .. }, .. } => *time_constant_s,
        required("time_constant", Kind::Quantity(Unit::Of(Dimension::TIME), Bound::Positive), "tau")
    ),
    field!(
        Actuator: rate_limit_per_s,
        optional(
            "rate_limit",
            Kind::Quantity(Unit::Of(Dimension::ACCELERATION), Bound::Positive),
            "largest rate of the commanded velocity",
        )
    ),
];

impl Record for Actuator {
    const FIELDS: &'static [Field<Self>] = &[
        field!(Actuator: on, required("on", BODY, "the body that a positive force pushes towards +x")),
        field!(
            Actuator: reacts_on,
            Key {
                name: "reacts_on",
                kind: BODY,
                absent: Absent::Word(GROUND),
                text: "the body that carries the reaction",
            }
        ),
        field!(
            Actuator: limit_n,
            optional("limit", Kind::Quantity(Unit::Of(Dimension::FORCE), Bound::Positive), "largest effort")
        ),
    ];
    const FORMS: &'static [Form<Self>] = &[
        form!(
            "force",
            "a current amplifier: the command is the force",
            Actuator: Actuator { kind: ActuatorKind::Force { .. }, .. },
            Actuator::blank(),
            FORCE
        ),
        form!(
            "velocity-source",
            "a voltage amplifier: tau df/dt + f = b_a (command - velocity)",
            Actuator: Actuator { kind: ActuatorKind::VelocitySource { .. }, .. },
            Actuator {
                kind: ActuatorKind::VelocitySource { damping_n_s_per_m: 1.0, time_constant_s: 1.0 },
                ..Actuator::blank()
            },
            VELOCITY_SOURCE
        ),
    ];

    fn blank() -> Self {
        Self::ideal(GROUND, GROUND)
    }
}
