//! Drives in numbers: from a command to a force.

use std::sync::Arc;

use super::{NodeId, Ripple};
use crate::description::{Actuator, ActuatorKind, DcMotor, Knot, MotorInput, PositionServo, Profile};

/// A drive. A command gets its noise, then passes delay, deadband, gain, limit and rate limit (all exact on
/// held commands), then the lags.
///
/// The command of a continuous servo is a target. The deadband applies to its error, the limit to its force,
/// and the lags follow the force. For a sampled servo, everything that acts on a target is stored separately
/// ([`TargetChain`]). The rest is a drive whose held command is the force.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    pub name: String,
    /// Pushed node.
    pub on: NodeId,
    pub reacts_on: NodeId,
    /// A force with its own dynamics against the speed; `None` if the command is the force.
    pub velocity_source: Option<VelocitySource>,
    /// The position loop of a servo.
    pub servo: Option<Servo>,
    /// The motor, whose current is a signal.
    pub motor: Option<Motor>,
    /// The imposed motion of the driven body; `None` if its motion is not imposed.
    pub imposed: Option<Arc<Profile>>,
    /// The servo that takes the command as an input of its own. The drive then has no force.
    pub feeds: Option<ServoFeed>,
    /// Delay of the command, s.
    pub delay: f64,
    /// Half-width of the deadband of commands (for a servo: of errors). Beyond it the width is subtracted.
    pub deadband: f64,
    /// Scale on the command.
    pub gain: f64,
    /// Largest effort, N; infinite without a limit.
    pub limit: f64,
    /// Largest command after its gain, if the limit applies to the force; infinite without a limit.
    pub command_limit: f64,
    /// Largest rate of the (scaled, limited) command per second; infinite without a limit.
    pub rate_limit: f64,
    /// Time in which the drive moves from one (scaled, limited) command to the next, s; zero if it jumps.
    pub interval: f64,
    /// First-order lags in series, s, each > 0.
    pub lags: Vec<f64>,
    /// Standard deviation of the noise on every command.
    pub noise: f64,
    /// Bound on the force that depends on the speed.
    pub line: Option<SpeedLine>,
    /// Heat that weakens the force.
    pub warming: Option<Warming>,
    /// Cogging forces added to the drive force.
    pub ripples: Vec<Ripple>,
}

/// An input of a servo besides its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ServoFeed {
    /// Index of the servo's drive.
    pub servo: usize,
    /// Whether the input is the speed of the target; otherwise it is a force.
    pub is_velocity: bool,
}

impl ServoFeed {
    /// Force of a servo per unit of this input.
    pub fn gain(self, servo: &Servo) -> f64 {
        if self.is_velocity { servo.kd } else { 1.0 }
    }
}

/// `tau df/dt + f = gain u - damping v`: the paper's Fig. 2, where `gain` is the damping, and the winding of
/// a motor. Without a time constant the force follows immediately.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocitySource {
    /// Force per unit of the command, N.
    pub gain: f64,
    /// Damping `b_a`, N s/m.
    pub damping: f64,
    /// Time constant `tau` of the lag, s.
    pub time_constant: f64,
}

/// `f = kp e + ki int(e) - kd v`, where `e` is the target less the stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Servo {
    /// Gain on the error, N/m, > 0.
    pub kp: f64,
    /// Gain on the integral of the error, N/(m s).
    pub ki: f64,
    /// Gain on the speed, N s/m.
    pub kd: f64,
    /// Its sampling; `None` if it is continuous.
    pub sampling: Option<ServoSampling>,
}

/// Sampling of a servo.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoSampling {
    /// Time between samples, s.
    pub period: f64,
    /// Time from a sample to its output, s.
    pub delay: f64,
    /// Resolution of the position reading, m.
    pub resolution: Option<f64>,
    /// Step of the output, N.
    pub output_resolution: Option<f64>,
    /// Index of the sensor that it reads.
    pub encoder: usize,
    /// From the command to the target of the loop.
    pub target: TargetChain,
}

/// Processing of a target on its way to a sampled loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetChain {
    /// Delay of the target, s.
    pub delay: f64,
    pub gain: f64,
    /// Half-width of the deadband of the error, m.
    pub error_deadband: f64,
    /// Largest speed of the target within the loop, m/s; infinite without a limit.
    pub rate_limit: f64,
    /// Time in which the loop moves from one target to the next, s.
    pub interval: f64,
}

impl TargetChain {
    /// A chain that changes nothing.
    pub const NONE: Self =
        Self { delay: 0.0, gain: 1.0, error_deadband: 0.0, rate_limit: f64::INFINITY, interval: 0.0 };

    /// Largest speed towards a target that arrives at a distance, m/s.
    pub fn pace(&self, distance: f64) -> f64 {
        pace(distance, self.interval, self.rate_limit)
    }
}

/// Speed towards a command at a distance that is to be reached in an interval, within a limit.
fn pace(distance: f64, interval: f64, rate_limit: f64) -> f64 {
    if interval > 0.0 { (distance.abs() / interval).min(rate_limit) } else { rate_limit }
}

/// The motor of a drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// Gear ratio times torque constant, `N K_t`, N/A.
    pub force_per_current: f64,
}

/// Bounds on a force, `-force - slope v` and `force - slope v`: the force that the supply voltage allows at a
/// speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedLine {
    /// Largest force at rest, N.
    pub force: f64,
    /// Reduction of the force for each m/s, N s/m.
    pub slope: f64,
}

/// Heat `h` of a winding under the force `f` of the cold drive, `tau h' + h = (f / force)^2`. It leaves
/// `f / (1 + h)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warming {
    /// Cold force that the heat halves in the end, N.
    pub force: f64,
    /// Time constant `tau` of the heat, s.
    pub time_constant: f64,
    /// Heat `h` at the start.
    pub heat: f64,
}

impl Drive {
    /// The drive of an actuator between two nodes, with the initial stroke `stroke_m`.
    pub(super) fn new(name: &str, actuator: &Actuator, [on, reacts_on]: [NodeId; 2]) -> Self {
        let plain = Self {
            name: name.into(),
            on,
            reacts_on,
            velocity_source: None,
            servo: None,
            motor: None,
            imposed: None,
            feeds: None,
            delay: 0.0,
            deadband: 0.0,
            gain: 1.0,
            limit: actuator.limit_n.unwrap_or(f64::INFINITY),
            command_limit: f64::INFINITY,
            rate_limit: actuator.rate_limit_per_s.unwrap_or(f64::INFINITY),
            interval: 0.0,
            lags: Vec::new(),
            noise: 0.0,
            line: None,
            warming: None,
            ripples: Vec::new(),
        };
        match &actuator.kind {
            ActuatorKind::Force { bandwidth_hz } => {
                let lags = bandwidth_hz.map(|f| 1.0 / (std::f64::consts::TAU * f)).into_iter().collect();
                Self { lags, ..plain }
            }
            ActuatorKind::VelocitySource { damping_n_s_per_m: damping, time_constant_s: time_constant } => {
                let (gain, damping, time_constant) = (*damping, *damping, *time_constant);
                Self { velocity_source: Some(VelocitySource { gain, damping, time_constant }), ..plain }
            }
            ActuatorKind::PositionServo(servo) => plain.with_servo(servo),
            ActuatorKind::DcMotor(motor) => plain.with_motor(motor),
            ActuatorKind::Imposed | ActuatorKind::TargetVelocity | ActuatorKind::FeedForward => plain,
        }
    }

    fn with_servo(self, servo: &PositionServo) -> Self {
        let sampling = servo.period_s.map(|period| ServoSampling {
            period,
            delay: servo.compute_delay_s,
            resolution: servo.resolution_m,
            output_resolution: servo.output_resolution_n,
            encoder: 0,
            target: TargetChain::NONE,
        });
        Self {
            servo: Some(Servo { kp: servo.kp, ki: servo.ki, kd: servo.kd, sampling }),
            delay: servo.delay_s,
            deadband: servo.error_deadband_m,
            rate_limit: servo.velocity_limit_m_per_s.unwrap_or(f64::INFINITY),
            ..self
        }
    }

    fn with_motor(self, motor: &DcMotor) -> Self {
        let force_per_current = motor.gear_ratio * motor.torque_constant;
        let force_per_volt = force_per_current / motor.resistance_ohm;
        let damping = force_per_volt * motor.gear_ratio * motor.back_emf();
        let supply = motor.supply_voltage_v;
        let limit = motor.current_limit_a.map_or(self.limit, |most| self.limit.min(most * force_per_current));
        let driven = Self { motor: Some(Motor { force_per_current }), limit, ..self };
        let time_constant = motor.inductance_h / motor.resistance_ohm;
        let winding = |gain, command_limit, driven| Self {
            velocity_source: Some(VelocitySource { gain, damping, time_constant }),
            command_limit,
            ..driven
        };
        match motor.input {
            MotorInput::Voltage => winding(force_per_volt, supply.unwrap_or(f64::INFINITY), driven),
            MotorInput::Duty => winding(force_per_volt * supply.unwrap_or(1.0), 1.0, driven),
            MotorInput::Current => Self {
                gain: force_per_current,
                line: supply.map(|volts| SpeedLine { force: volts * force_per_volt, slope: damping }),
                ..driven
            },
        }
    }

    /// Holds the driven body at a position until its motion is known.
    pub(super) fn impose(&mut self, position_m: f64) {
        let knot = Knot { t_s: 0.0, offset_m: position_m, rate_m_per_s: 0.0 };
        self.imposed = Profile::new(&[knot]).ok().map(Arc::new);
    }

    /// The loop of a servo, if it is continuous.
    pub(crate) fn continuous_servo(&self) -> Option<&Servo> {
        self.servo.as_ref().filter(|servo| servo.sampling.is_none())
    }

    /// The sampling of a servo, if it is sampled.
    pub fn sampling(&self) -> Option<&ServoSampling> {
        self.servo.as_ref()?.sampling.as_ref()
    }

    /// Separates the processing of the target of a sampled servo, which reads the sensor `encoder`. From then
    /// on the command of the drive is its force.
    pub(super) fn sample_by(&mut self, encoder: usize) {
        let Self { delay, gain, deadband, rate_limit, interval, .. } = *self;
        let Some(sampling) = self.servo.as_mut().and_then(|servo| servo.sampling.as_mut()) else { return };
        sampling.encoder = encoder;
        sampling.target = TargetChain { delay, gain, error_deadband: deadband, rate_limit, interval };
        (self.delay, self.gain, self.deadband, self.rate_limit) = (0.0, 1.0, 0.0, f64::INFINITY);
        self.interval = 0.0;
    }

    /// Makes the loop of a sampled servo continuous: its target acts as on the sampled one.
    pub fn make_continuous(&mut self) {
        let Some(sampling) = self.servo.as_mut().and_then(|servo| servo.sampling.take()) else { return };
        let TargetChain { delay, gain, error_deadband, rate_limit, interval } = sampling.target;
        (self.delay, self.gain) = (delay, gain);
        (self.deadband, self.rate_limit, self.interval) = (error_deadband, rate_limit, interval);
    }

    /// Adds the effect of interpolation between commands on a small motion, for linear theory. Commands come
    /// every `period_s`; `None` means no faster than the interval. The effect is then a delay of half the
    /// interval.
    ///
    /// Commands that come every `T`, shorter than the interval `I`, each move the drive by `T / I` of the
    /// remaining distance. This is a first-order lag with the time constant `I - T / 2`.
    pub fn linearise_interpolation(&mut self, period_s: Option<f64>) {
        let late = |interval: f64| match period_s.filter(|period_s| *period_s < interval) {
            Some(period_s) => (interval - 0.5 * period_s, true),
            None => (0.5 * interval, false),
        };
        if self.interval > 0.0 {
            match late(self.interval) {
                (tau, true) => self.lags.push(tau),
                (delay, false) => self.delay += delay,
            }
        }
        // A target has no lags, so only its delay grows.
        if let Some(sampling) = self.servo.as_mut().and_then(|servo| servo.sampling.as_mut()) {
            sampling.target.delay += late(sampling.target.interval).0;
        }
    }

    /// Whether the drive acts on a command that moves towards the one received.
    pub fn ramps(&self) -> bool {
        self.rate_limit.is_finite() || self.interval > 0.0
    }

    /// Largest rate of the command towards one that arrives at a distance.
    pub fn pace(&self, distance: f64) -> f64 {
        pace(distance, self.interval, self.rate_limit)
    }

    /// Whether the limit applies to a force with its own dynamics, and not to the held command.
    pub fn limits_force(&self) -> bool {
        self.velocity_source.is_some() || self.continuous_servo().is_some()
    }

    /// Whether the command is the force.
    pub fn commands_force(&self) -> bool {
        self.velocity_source.is_none()
            && self.servo.is_none()
            && self.motor.is_none()
            && self.imposed.is_none()
            && self.feeds.is_none()
    }

    /// Largest held command after its gain.
    pub fn held_limit(&self) -> f64 {
        if self.limits_force() { self.command_limit } else { self.limit }
    }

    /// Half-width of the deadband of held commands.
    pub fn held_deadband(&self) -> f64 {
        if self.continuous_servo().is_some() { 0.0 } else { self.deadband }
    }

    /// A held command after deadband, gain and limit.
    pub fn held(&self, command: f64) -> f64 {
        let (deadband, limit) = (self.held_deadband(), self.held_limit());
        let beyond = command - command.clamp(-deadband, deadband);
        (beyond * self.gain).clamp(-limit, limit)
    }

    /// A command as received: for a sampled servo its target, for any other drive [`Self::held`].
    pub fn received(&self, command: f64) -> f64 {
        self.sampling().map_or_else(|| self.held(command), |sampling| sampling.target.gain * command)
    }

    /// Delay of a command as received, s.
    pub fn received_late(&self) -> f64 {
        self.sampling().map_or(self.delay, |sampling| sampling.target.delay)
    }
}
