//! Position servos.

use feeler_catalogue::{
    Absent, Bound, Dimension, Field, Key, KeyKind, KeyRole, LONGEST_DELAY, Unit, field, number, optional,
};

use super::{Actuator, ActuatorKind};

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

/// A parameter of a servo.
macro_rules! servo {
    ($member:ident, $key:expr) => {
        servo!($member, $key, KeyRole::Structure)
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
                kind: KeyKind::Quantity(Unit::Of($dimension), $bound),
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
        KeyRole::Believed,
        "force per position error"
    );
    /// The force of a servo per speed.
    pub const SERVO_KD: Field<Self> = servo_gain!(
        kd,
        Dimension::DAMPING,
        Bound::NotNegative,
        Absent::Number(0.0),
        KeyRole::Believed,
        "force per speed, against it"
    );
    /// Time between samples of a servo.
    pub const SERVO_PERIOD: Field<Self> = servo!(
        period_s,
        optional(
            "period",
            KeyKind::Quantity(Unit::Of(Dimension::TIME), Bound::Within(1e-9, 1e6)),
            "time between samples of the loop, whose output is held; without it the loop is continuous",
        )
    );
    /// Time from a sample of a servo until its output acts.
    pub const SERVO_COMPUTE_DELAY: Field<Self> = servo!(
        compute_delay_s,
        number(
            "compute_delay",
            Unit::Of(Dimension::TIME),
            LONGEST_DELAY,
            0.0,
            "time from a sample until its output acts; needs a period",
        )
    );
    /// Step of the position that a servo reads.
    pub const SERVO_RESOLUTION: Field<Self> = servo!(
        resolution_m,
        optional(
            "resolution",
            KeyKind::Quantity(Unit::Of(Dimension::LENGTH), Bound::Positive),
            "step of the position that the loop reads; needs a period",
        )
    );
    /// Step of the output of a servo.
    pub const SERVO_OUTPUT_RESOLUTION: Field<Self> = servo!(
        output_resolution_n,
        optional(
            "output_resolution",
            KeyKind::Quantity(Unit::Of(Dimension::FORCE), Bound::Positive),
            "step of the output; needs a period",
        )
    );
}

/// Keys of an actuator of this kind.
pub(super) const POSITION_SERVO: &[Field<Actuator>] = &[
    Actuator::SERVO_KP,
    Actuator::SERVO_KD,
    servo_gain!(
        ki,
        Dimension::STIFFNESS_RATE,
        Bound::NotNegative,
        Absent::Number(0.0),
        KeyRole::Structure,
        "rate of the force per position error; driven back at the limit with the time constant kp / ki"
    ),
    servo!(
        velocity_limit_m_per_s,
        optional(
            "velocity_limit",
            KeyKind::Quantity(Unit::Of(Dimension::VELOCITY), Bound::Positive),
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
    Actuator::SERVO_PERIOD,
    Actuator::SERVO_COMPUTE_DELAY,
    Actuator::SERVO_RESOLUTION,
    Actuator::SERVO_OUTPUT_RESOLUTION,
];
