//! Drives as described in a file.

use feeler_catalogue::{
    Absent, Bound, Dimension, Field, Form, Key, KeyKind, Keyed, Unit, field, form, optional, required,
};

use super::motor::DC_MOTOR;
use super::servo::POSITION_SERVO;
use super::{DcMotor, GROUND, MotorInput, PositionServo, Quantity};
use crate::effects::EffectUse;

/// A drive: a force on one body and its reaction on another.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// The body that a positive force pushes towards +x.
    pub on: String,
    /// The body that carries the reaction.
    pub reacts_on: String,
    /// The law from command to force.
    pub kind: ActuatorKind,
    /// Effort limit, > 0; `None` without a limit.
    pub limit_n: Option<f64>,
    /// Largest rate of the effort, > 0 (N/s; of the commanded velocity, m/s², for a velocity source).
    pub rate_limit_per_s: Option<f64>,
    /// Departures from the ideal drive.
    pub effects: Vec<EffectUse>,
}

impl Actuator {
    /// A drive whose force is its command, immediately and without limit.
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

/// The law from command to force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ActuatorKind {
    /// A high-bandwidth current amplifier: the command is the force (N).
    Force {
        /// First-order bandwidth of the current loop; `None` for an ideal one.
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
    /// A servo with its own position loop: the command is the target of the position (m).
    PositionServo(PositionServo),
    /// A motor of direct current with its gear: the command is a voltage, a duty cycle or a current.
    DcMotor(DcMotor),
    /// The body moves as commanded, whatever forces act on it: the command is its position (m).
    Imposed,
    /// An input of the position servo between the same bodies: the speed of its target (m/s). The servo adds
    /// `kd` times this to its force.
    TargetVelocity,
    /// An input of the position servo between the same bodies: a force (N) that it adds to that of its loop.
    FeedForward,
}

impl ActuatorKind {
    /// Dimension of the command.
    pub fn command(&self) -> Dimension {
        match self {
            Self::Force { .. } | Self::FeedForward => Dimension::FORCE,
            Self::VelocitySource { .. } | Self::TargetVelocity => Dimension::VELOCITY,
            Self::PositionServo(_) | Self::Imposed => Dimension::LENGTH,
            Self::DcMotor(motor) => motor.input.command(),
        }
    }

    /// Whether the command is an input of a servo, without a force of its own.
    pub fn feeds_servo(&self) -> bool {
        matches!(self, Self::TargetVelocity | Self::FeedForward)
    }

    /// The quantity that names the command in a record, such as `servo.target` or `motor.voltage`.
    pub fn input(&self) -> Quantity {
        match self {
            Self::PositionServo(_) => Quantity::Target,
            Self::DcMotor(motor) if motor.input == MotorInput::Voltage => Quantity::Voltage,
            Self::DcMotor(motor) if motor.input == MotorInput::Current => Quantity::Current,
            _ => Quantity::Command,
        }
    }
}

const BODY: KeyKind = KeyKind::Name("a body or `ground`");

const FORCE: &[Field<Actuator>] = &[
    Actuator::RATE_LIMIT,
    field!(Actuator: Actuator { kind: ActuatorKind::Force { bandwidth_hz }, .. } => *bandwidth_hz,
        optional("bandwidth", KeyKind::Quantity(Unit::Of(Dimension::FREQUENCY), Bound::Positive),
            "first-order bandwidth of the current loop")),
];

const VELOCITY_SOURCE: &[Field<Actuator>] = &[
    field!(
        Actuator:
            Actuator { kind: ActuatorKind::VelocitySource { damping_n_s_per_m, .. }, .. }
                => *damping_n_s_per_m,
        required(
            "damping",
            KeyKind::Quantity(Unit::Of(Dimension::DAMPING), Bound::Positive),
            "b_a, force per velocity error",
        )
    ),
    field!(
        Actuator:
            Actuator { kind: ActuatorKind::VelocitySource { time_constant_s, .. }, .. } => *time_constant_s,
        required("time_constant", KeyKind::Quantity(Unit::Of(Dimension::TIME), Bound::Positive), "tau")
    ),
    field!(Actuator: rate_limit_per_s,
        optional("rate_limit", KeyKind::Quantity(Unit::Of(Dimension::ACCELERATION), Bound::Positive),
            "largest rate of the commanded velocity")),
];

impl Actuator {
    /// The pushed body.
    pub const ON: Field<Self> = field!(Actuator: on,
        required("on", BODY, "the body that a positive force pushes towards +x"));
    /// The body that carries the reaction.
    pub const REACTS_ON: Field<Self> = field!(Actuator: reacts_on,
        Key { name: "reacts_on", kind: BODY, absent: Absent::Word(GROUND),
            text: "the body that carries the reaction" });
    /// The largest effort of the drive.
    pub const LIMIT: Field<Self> = field!(Actuator: limit_n,
        optional("limit", KeyKind::Quantity(Unit::Of(Dimension::FORCE), Bound::Positive), "largest effort"));
    /// The largest rate of the drive's force.
    pub const RATE_LIMIT: Field<Self> = field!(Actuator: rate_limit_per_s,
        optional("rate_limit", KeyKind::Quantity(Unit::Of(Dimension::FORCE_RATE), Bound::Positive),
            "largest rate of the force"));
}

impl Keyed for Actuator {
    const FIELDS: &'static [Field<Self>] = &[Actuator::ON, Actuator::REACTS_ON, Actuator::LIMIT];
    const FORMS: &'static [Form<Self>] = &[
        form!("force", "a current amplifier: the command is the force",
            Actuator: Actuator { kind: ActuatorKind::Force { .. }, .. }, Actuator::ideal("", GROUND), FORCE),
        form!("velocity-source", "a voltage amplifier: tau df/dt + f = b_a (command - velocity)",
            Actuator: Actuator { kind: ActuatorKind::VelocitySource { .. }, .. },
            Actuator { kind: ActuatorKind::VelocitySource { damping_n_s_per_m: 1.0, time_constant_s: 1.0 },
                ..Actuator::ideal("", GROUND) }, VELOCITY_SOURCE),
        form!(
            "position-servo",
            "f = kp e + ki int(e) - kd v, e the command less the position",
            Actuator: Actuator { kind: ActuatorKind::PositionServo(_), .. },
            Actuator {
                kind: ActuatorKind::PositionServo(PositionServo { kp: 1.0, ..PositionServo::default() }),
                ..Actuator::ideal("", GROUND)
            },
            POSITION_SERVO
        ),
        form!("dc-motor", "L di/dt + R i = u - K_e N v, f = N K_t i; the command is u or i",
            Actuator: Actuator { kind: ActuatorKind::DcMotor(_), .. },
            Actuator { kind: ActuatorKind::DcMotor(DcMotor::default()), ..Actuator::ideal("", GROUND) },
            DC_MOTOR),
        form!("imposed", "the body moves as commanded, whatever forces act on it",
            Actuator: Actuator { kind: ActuatorKind::Imposed, .. },
            Actuator { kind: ActuatorKind::Imposed, ..Actuator::ideal("", GROUND) },
            &[] as &[Field<Actuator>]),
        form!("target-velocity",
            "the speed of the target of the position servo on the same bodies, which adds kd times it",
            Actuator: Actuator { kind: ActuatorKind::TargetVelocity, .. },
            Actuator { kind: ActuatorKind::TargetVelocity, ..Actuator::ideal("", GROUND) },
            &[] as &[Field<Actuator>]),
        form!("feed-forward",
            "a force that the position servo on the same bodies adds to that of its loop, within its limit",
            Actuator: Actuator { kind: ActuatorKind::FeedForward, .. },
            Actuator { kind: ActuatorKind::FeedForward, ..Actuator::ideal("", GROUND) },
            &[] as &[Field<Actuator>]),
    ];

    fn blank() -> Option<Self> {
        Some(Self::ideal("", GROUND))
    }
}
