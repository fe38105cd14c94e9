//! Motors of direct current.

use feeler_catalogue::{
    Absent, Bound, Dimension, Field, Key, KeyKind, KeyRole, Unit, field, number, optional, required, words,
};

use super::{Actuator, ActuatorKind};

/// A DC motor with a gear: `L di/dt + R i = u - K_e N v`, `f = N K_t i`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DcMotor {
    /// The quantity that the command sets.
    pub input: MotorInput,
    /// `R`, > 0, ohm.
    pub resistance_ohm: f64,
    /// `K_t`, > 0, N m/A.
    pub torque_constant: f64,
    /// `K_e`, V s/rad; equal to `K_t` by default.
    pub back_emf_constant: Option<f64>,
    /// `N`, turns of the motor per turn of the driven body.
    pub gear_ratio: f64,
    /// Largest voltage; a duty cycle is a share of it. `None` without a limit.
    pub supply_voltage_v: Option<f64>,
    /// Largest current, A.
    pub current_limit_a: Option<f64>,
    /// Inertia of the rotor on the motor's side of the gear, kg m^2. It adds `N^2` times this to the driven
    /// body.
    pub rotor_inertia: f64,
    /// `L`, H.
    pub inductance_h: f64,
}

impl DcMotor {
    /// `K_e`, by default equal to `K_t`.
    pub fn back_emf(&self) -> f64 {
        self.back_emf_constant.unwrap_or(self.torque_constant)
    }
}

impl Default for DcMotor {
    fn default() -> Self {
        Self {
            input: MotorInput::Voltage,
            resistance_ohm: 1.0,
            torque_constant: 1.0,
            back_emf_constant: None,
            gear_ratio: 1.0,
            supply_voltage_v: None,
            current_limit_a: None,
            rotor_inertia: 0.0,
            inductance_h: 0.0,
        }
    }
}

/// The quantity that commands a motor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MotorInput {
    /// The voltage at the winding.
    #[default]
    Voltage,
    /// The voltage at the winding as a share of the supply voltage, from -1 to 1.
    Duty,
    /// The current, which an amplifier holds within the limits of the supply voltage.
    Current,
}

words!(MotorInput {
    Voltage = "voltage", "the voltage at the winding";
    Duty = "duty", "the share of the supply voltage, from -1 to 1";
    Current = "current", "the current, kept as far as the supply voltage allows";
});

impl MotorInput {
    /// Dimension of the command.
    pub fn command(self) -> Dimension {
        match self {
            Self::Voltage => Dimension::VOLTAGE,
            Self::Duty => Dimension::NONE,
            Self::Current => Dimension::CURRENT,
        }
    }
}

/// A parameter of a motor.
macro_rules! motor {
    ($member:ident, $key:expr) => {
        motor!($member, $key, KeyRole::Structure)
    };
    ($member:ident, $key:expr, $role:expr) => {
        field!(Actuator: Actuator { kind: ActuatorKind::DcMotor(motor), .. } => motor.$member, $key, $role)
    };
}

impl Actuator {
    /// Quantity that the command of a motor sets.
    pub const MOTOR_INPUT: Field<Self> = motor!(
        input,
        Key {
            name: "input",
            kind: KeyKind::Word(MotorInput::WORDS),
            absent: Absent::Word(MotorInput::Voltage.name()),
            text: "the quantity that the command sets",
        }
    );
    /// Largest voltage of a motor.
    pub const SUPPLY_VOLTAGE: Field<Self> = motor!(
        supply_voltage_v,
        optional(
            "supply_voltage",
            KeyKind::Quantity(Unit::Of(Dimension::VOLTAGE), Bound::Positive),
            "largest voltage at the winding; a duty cycle is a share of it",
        )
    );
    /// Inductance of a motor.
    pub const INDUCTANCE: Field<Self> = motor!(
        inductance_h,
        number("inductance", Unit::Of(Dimension::INDUCTANCE), Bound::NotNegative, 0.0, "of the winding",)
    );
}

/// Keys of an actuator of this kind.
pub(super) const DC_MOTOR: &[Field<Actuator>] = &[
    Actuator::MOTOR_INPUT,
    motor!(
        resistance_ohm,
        required(
            "resistance",
            KeyKind::Quantity(Unit::Of(Dimension::RESISTANCE), Bound::Positive),
            "of the winding",
        ),
        KeyRole::Believed
    ),
    motor!(
        torque_constant,
        required(
            "torque_constant",
            KeyKind::Quantity(Unit::Of(Dimension::FORCE_PER_CURRENT), Bound::Positive),
            "force per current on the motor's side of the gear",
        ),
        KeyRole::Believed
    ),
    motor!(
        back_emf_constant,
        optional(
            "back_emf_constant",
            KeyKind::Quantity(Unit::Of(Dimension::FORCE_PER_CURRENT), Bound::Positive),
            "voltage per speed on the motor's side of the gear, in V s/m (V s/rad), which is the same unit; \
             by default the torque constant",
        )
    ),
    motor!(
        gear_ratio,
        number(
            "gear_ratio",
            Unit::Of(Dimension::NONE),
            Bound::Positive,
            1.0,
            "travel of the motor per travel of the driven body; on a screw of lead p it is 2 pi / p, with \
             the constants and the inertia as plain SI numbers",
        )
    ),
    Actuator::SUPPLY_VOLTAGE,
    motor!(
        current_limit_a,
        optional(
            "current_limit",
            KeyKind::Quantity(Unit::Of(Dimension::CURRENT), Bound::Positive),
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
    Actuator::INDUCTANCE,
];
