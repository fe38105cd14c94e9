//! Drives as described in a file.

use feeler_catalogue::{
    Absent, Bound, Dimension, Field, Form, Key, Kind, LONGEST_DELAY, Record, Role, Unit, field, form, number,
    optional, required,
};

use super::{DcMotor, GROUND, MotorInput, Quantity};
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

/// The loop of a position servo: `f = kp e + ki int(e) - kd v`. The error `e` is the target minus the
/// position of the driven body relative to the reaction body. The speed `v` is that of the same relative
/// position. The actuator's limit bounds `f`.
///
/// Without a period the loop is continuous. With one it is sampled, and its output is held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PositionServo {
    /// Force per error, > 0, N/m.
    pub kp: f64,
    /// Force per speed, N s/m.
    pub kd: f64,
    /// Rate of the force per error, N/(m s). At the limit the integral decays with the time constant `kp /
    /// ki`.
    pub ki: f64,
    /// Largest speed of the target within the loop, m/s.
    pub velocity_limit_m_per_s: Option<f64>,
    /// Delay of the target, s.
    pub delay_s: f64,
    /// Half-width of the deadband of the error in the proportional and integral part, m.
    pub error_deadband_m: f64,
    /// Time between samples, s; `None` for a continuous loop.
    pub period_s: Option<f64>,
    /// Time from a sample until its output acts, s; for a sampled loop.
    pub compute_delay_s: f64,
    /// Resolution of the position that a sampled loop reads, m.
    pub resolution_m: Option<f64>,
    /// Resolution of the output of a sampled loop, N.
    pub output_resolution_n: Option<f64>,
}

const BODY: Kind = Kind::Name("a body or `ground`");

const FORCE: &[Field<Actuator>] = &[
    Actuator::RATE_LIMIT,
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
        Actuator:
            Actuator { kind: ActuatorKind::VelocitySource { damping_n_s_per_m, .. }, .. }
                => *damping_n_s_per_m,
        required(
            "damping",
            Kind::Quantity(Unit::Of(Dimension::DAMPING), Bound::Positive),
            "b_a, force per velocity error",
        )
    ),
    field!(
        Actuator:
            Actuator { kind: ActuatorKind::VelocitySource { time_constant_s, .. }, .. } => *time_constant_s,
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

impl Actuator {
    /// The largest effort of the drive.
    pub const LIMIT: Field<Self> = field!(
        Actuator: limit_n,
        optional("limit", Kind::Quantity(Unit::Of(Dimension::FORCE), Bound::Positive), "largest effort")
    );
    /// The largest rate of the drive's force.
    pub const RATE_LIMIT: Field<Self> = field!(
        Actuator: rate_limit_per_s,
        optional(
            "rate_limit",
            Kind::Quantity(Unit::Of(Dimension::FORCE_RATE), Bound::Positive),
            "largest rate of the force",
        )
    );
}

/// A parameter of a servo.
macro_rules! servo {
    ($member:ident, $key:expr) => {
        servo!($member, $key, Role::Structure)
    };
    ($member:ident, $key:expr, $role:expr) => {
        field!(
            Actuator: Actuator { kind: ActuatorKind::PositionServo(servo), .. } => servo.$member,
            $key,
            $role
        )
    };
}

/// A gain of a servo, whose key is its own name.
macro_rules! servo_gain {
    ($gain:ident, $dimension:expr, $bound:expr, $absent:expr, $role:expr, $text:expr) => {
        servo!(
            $gain,
            Key {
                name: stringify!($gain),
                kind: Kind::Quantity(Unit::Of($dimension), $bound),
                absent: $absent,
                text: $text,
            },
            $role
        )
    };
}

impl Actuator {
    /// The force of a servo per error.
    pub const SERVO_KP: Field<Self> = servo_gain!(
        kp,
        Dimension::STIFFNESS,
        Bound::Positive,
        Absent::Required,
        Role::Believed,
        "force per position error"
    );
    /// The force of a servo per speed.
    pub const SERVO_KD: Field<Self> = servo_gain!(
        kd,
        Dimension::DAMPING,
        Bound::NotNegative,
        Absent::Number(0.0),
        Role::Believed,
        "force per speed, against it"
    );
}

const POSITION_SERVO: &[Field<Actuator>] = &[
    Actuator::SERVO_KP,
    Actuator::SERVO_KD,
    servo_gain!(
        ki,
        Dimension::STIFFNESS_RATE,
        Bound::NotNegative,
        Absent::Number(0.0),
        Role::Structure,
        "rate of the force per position error; driven back at the limit with the time constant kp / ki"
    ),
    servo!(
        velocity_limit_m_per_s,
        optional(
            "velocity_limit",
            Kind::Quantity(Unit::Of(Dimension::VELOCITY), Bound::Positive),
            "largest speed of the target within the loop",
        )
    ),
    servo!(
        delay_s,
        number(
            "delay",
            Unit::Of(Dimension::TIME),
            LONGEST_DELAY,
            0.0,
            "delay of the target; need not be a multiple of the period"
        )
    ),
    servo!(
        error_deadband_m,
        number(
            "error_deadband",
            Unit::Of(Dimension::LENGTH),
            Bound::NotNegative,
            0.0,
            "half-width of the deadband of the error for kp and ki; it is subtracted from larger errors",
        )
    ),
    servo!(
        period_s,
        optional(
            "period",
            Kind::Quantity(Unit::Of(Dimension::TIME), Bound::Within(1e-9, 1e6)),
            "time between samples of the loop, whose output is held; without it the loop is continuous",
        )
    ),
    servo!(
        compute_delay_s,
        number(
            "compute_delay",
            Unit::Of(Dimension::TIME),
            LONGEST_DELAY,
            0.0,
            "time from a sample until its output acts; needs a period",
        )
    ),
    servo!(
        resolution_m,
        optional(
            "resolution",
            Kind::Quantity(Unit::Of(Dimension::LENGTH), Bound::Positive),
            "step of the position that the loop reads; needs a period",
        )
    ),
    servo!(
        output_resolution_n,
        optional(
            "output_resolution",
            Kind::Quantity(Unit::Of(Dimension::FORCE), Bound::Positive),
            "step of the output; needs a period",
        )
    ),
];

/// A parameter of a motor.
macro_rules! motor {
    ($member:ident, $key:expr) => {
        motor!($member, $key, Role::Structure)
    };
    ($member:ident, $key:expr, $role:expr) => {
        field!(Actuator: Actuator { kind: ActuatorKind::DcMotor(motor), .. } => motor.$member, $key, $role)
    };
}

const DC_MOTOR: &[Field<Actuator>] = &[
    motor!(
        input,
        Key {
            name: "input",
            kind: Kind::Word(MotorInput::WORDS),
            absent: Absent::Word(MotorInput::Voltage.name()),
            text: "the quantity that the command sets",
        }
    ),
    motor!(
        resistance_ohm,
        required(
            "resistance",
            Kind::Quantity(Unit::Of(Dimension::RESISTANCE), Bound::Positive),
            "of the winding",
        ),
        Role::Believed
    ),
    motor!(
        torque_constant,
        required(
            "torque_constant",
            Kind::Quantity(Unit::Of(Dimension::FORCE_PER_CURRENT), Bound::Positive),
            "force per current on the motor's side of the gear",
        ),
        Role::Believed
    ),
    motor!(
        back_emf_constant,
        optional(
            "back_emf_constant",
            Kind::Quantity(Unit::Of(Dimension::FORCE_PER_CURRENT), Bound::Positive),
            "voltage per speed on the motor's side of the gear; by default the torque constant",
        )
    ),
    motor!(
        gear_ratio,
        number(
            "gear_ratio",
            Unit::Of(Dimension::NONE),
            Bound::Positive,
            1.0,
            "travel of the motor per travel of the driven body",
        )
    ),
    motor!(
        supply_voltage_v,
        optional(
            "supply_voltage",
            Kind::Quantity(Unit::Of(Dimension::VOLTAGE), Bound::Positive),
            "largest voltage at the winding; a duty cycle is a share of it",
        )
    ),
    motor!(
        current_limit_a,
        optional(
            "current_limit",
            Kind::Quantity(Unit::Of(Dimension::CURRENT), Bound::Positive),
            "largest current",
        )
    ),
    motor!(
        rotor_inertia,
        number(
            "rotor_inertia",
            Unit::Of(Dimension::MASS),
            Bound::NotNegative,
            0.0,
            "on the motor's side of the gear; times the square of the ratio it adds to the driven body",
        )
    ),
    motor!(
        inductance_h,
        number("inductance", Unit::Of(Dimension::INDUCTANCE), Bound::NotNegative, 0.0, "of the winding",)
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
        Actuator::LIMIT,
    ];
    const FORMS: &'static [Form<Self>] = &[
        form!(
            "force",
            "a current amplifier: the command is the force",
            Actuator: Actuator { kind: ActuatorKind::Force { .. }, .. },
            Actuator::ideal("", GROUND),
            FORCE
        ),
        form!(
            "velocity-source",
            "a voltage amplifier: tau df/dt + f = b_a (command - velocity)",
            Actuator: Actuator { kind: ActuatorKind::VelocitySource { .. }, .. },
            Actuator {
                kind: ActuatorKind::VelocitySource { damping_n_s_per_m: 1.0, time_constant_s: 1.0 },
                ..Actuator::ideal("", GROUND)
            },
            VELOCITY_SOURCE
        ),
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
        form!(
            "dc-motor",
            "L di/dt + R i = u - K_e N v, f = N K_t i; the command is u or i",
            Actuator: Actuator { kind: ActuatorKind::DcMotor(_), .. },
            Actuator { kind: ActuatorKind::DcMotor(DcMotor::default()), ..Actuator::ideal("", GROUND) },
            DC_MOTOR
        ),
        form!(
            "imposed",
            "the body moves as commanded, whatever forces act on it",
            Actuator: Actuator { kind: ActuatorKind::Imposed, .. },
            Actuator { kind: ActuatorKind::Imposed, ..Actuator::ideal("", GROUND) },
            &[] as &[Field<Actuator>]
        ),
        form!(
            "target-velocity",
            "the speed of the target of the position servo on the same bodies, which adds kd times it",
            Actuator: Actuator { kind: ActuatorKind::TargetVelocity, .. },
            Actuator { kind: ActuatorKind::TargetVelocity, ..Actuator::ideal("", GROUND) },
            &[] as &[Field<Actuator>]
        ),
        form!(
            "feed-forward",
            "a force that the position servo on the same bodies adds to that of its loop, within its limit",
            Actuator: Actuator { kind: ActuatorKind::FeedForward, .. },
            Actuator { kind: ActuatorKind::FeedForward, ..Actuator::ideal("", GROUND) },
            &[] as &[Field<Actuator>]
        ),
    ];

    fn blank() -> Option<Self> {
        Some(Self::ideal("", GROUND))
    }
}
