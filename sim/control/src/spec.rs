//! What the file says of one controller.

use crate::ReferenceSpec;
use crate::error::{ControlError, finite, not_negative, positive};

/// What the file says of one controller (SI: on a rotational axis read N m for N and rad for m).
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerSpec {
    /// The control law and its gains.
    pub law: Law,
    /// Time between samples, s.
    pub period_s: f64,
    /// From a sample to the instant at which its output is applied, s; any number, not only whole periods.
    pub delay_s: f64,
    /// One sigma of each sample instant about its nominal time, s.
    pub jitter_s: f64,
    /// Time of the first sample, s.
    pub offset_s: f64,
    /// The phase before contact, if there is one.
    pub approach: Option<Approach>,
    /// Step of the output (a converter's least significant bit), in units of the output.
    pub output_resolution: Option<f64>,
    /// Largest magnitude of the output, in units of the output; what the anti-windup works against.
    pub output_limit: Option<f64>,
    /// Low-pass that the controller applies to `Inputs::reading` before anything else.
    pub reading_low_pass: Option<LowPassSpec>,
    /// Time constant of the first-order low-pass on the velocity obtained by differencing a position sensor,
    /// s; zero for none.
    pub velocity_filter_s: f64,
    /// What the loop shall follow.
    pub reference: ReferenceSpec,
}

impl ControllerSpec {
    /// A controller with `law` every `period_s`, and nothing else: no delay, jitter, approach or limit, and a
    /// reference of zero.
    pub fn new(law: Law, period_s: f64) -> Self {
        Self {
            law,
            period_s,
            delay_s: 0.0,
            jitter_s: 0.0,
            offset_s: 0.0,
            approach: None,
            output_resolution: None,
            output_limit: None,
            reading_low_pass: None,
            velocity_filter_s: 0.0,
            reference: ReferenceSpec::Constant(0.0),
        }
    }

    /// Checks every number but the reference's, which [`crate::Reference::new`] checks.
    ///
    /// # Errors
    /// The first number that is out of its range, with its key.
    pub fn check(&self) -> Result<(), ControlError> {
        positive("period", self.period_s)?;
        not_negative("delay", self.delay_s)?;
        not_negative("jitter", self.jitter_s)?;
        not_negative("offset", self.offset_s)?;
        not_negative("velocity_filter", self.velocity_filter_s)?;
        self.output_resolution.map(|q| positive("output_resolution", q)).transpose()?;
        self.output_limit.map(|u| positive("output_limit", u)).transpose()?;
        let nyquist_hz = 0.5 / self.period_s;
        if let Some(filter) = &self.reading_low_pass {
            below_nyquist("low_pass", positive("low_pass", filter.cutoff_hz)?, nyquist_hz)?;
            filter.damping_ratio.map(|zeta| positive("low_pass.damping_ratio", zeta)).transpose()?;
        }
        if let Some(approach) = &self.approach {
            approach.check()?;
            if matches!(self.law, Law::Position(_)) {
                return Err(ControlError::ApproachNeedsForce);
            }
        }
        self.law.check()
    }
}

fn below_nyquist(key: &'static str, value: f64, bound: f64) -> Result<(), ControlError> {
    if value < bound {
        Ok(())
    } else {
        Err(ControlError::TooLarge { key, value, bound, why: "half the sample rate" })
    }
}

/// A control law.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Law {
    /// The output is the reference.
    OpenLoop,
    /// Explicit force control: the reading is a force, the reference the force wanted.
    ExplicitForce(ForceGains),
    /// Position control: the reading is a position, the reference the position wanted.
    Position(PositionGains),
    /// A programmed stiffness and damping about a reference position.
    Impedance(ImpedanceGains),
    /// A virtual body moved by the force error, tracked by an inner position loop.
    Admittance(AdmittanceGains),
}

impl Law {
    /// The law's name in the machine file.
    pub fn name(&self) -> &'static str {
        match self {
            Self::OpenLoop => "open-loop",
            Self::ExplicitForce(_) => "explicit-force",
            Self::Position(_) => "position",
            Self::Impedance(_) => "impedance",
            Self::Admittance(_) => "admittance",
        }
    }

    /// Whether the law cannot work without a motion sensor.
    pub fn needs_motion(&self) -> bool {
        match self {
            Self::OpenLoop | Self::Position(_) => false,
            Self::ExplicitForce(gains) => gains.damping != 0.0,
            Self::Impedance(_) | Self::Admittance(_) => true,
        }
    }

    fn check(&self) -> Result<(), ControlError> {
        match self {
            Self::OpenLoop => Ok(()),
            Self::ExplicitForce(g) => {
                finite("feed_forward", g.feed_forward)?;
                for (key, value) in [("kp", g.kp), ("ki", g.ki), ("kd", g.kd), ("damping", g.damping)] {
                    finite(key, value)?;
                }
                not_negative("derivative_filter", g.derivative_filter_s)?;
                if let Some(lead) = &g.lead {
                    positive("lead.zero", lead.zero_hz)?;
                    positive("lead.pole", lead.pole_hz)?;
                }
                g.anti_windup.check()
            }
            Self::Position(g) => {
                for (key, value) in [("kp", g.kp), ("ki", g.ki), ("kd", g.kd), ("damping", g.damping)] {
                    finite(key, value)?;
                }
                not_negative("derivative_filter", g.derivative_filter_s)?;
                g.anti_windup.check()
            }
            Self::Impedance(g) => {
                finite("stiffness", g.stiffness)?;
                finite("damping", g.damping)?;
                finite("force_gain", g.force_gain)?;
                Ok(())
            }
            Self::Admittance(g) => {
                not_negative("mass", g.mass)?;
                not_negative("damping", g.damping)?;
                not_negative("stiffness", g.stiffness)?;
                for (key, value) in
                    [("kp", g.kp), ("kd", g.kd), ("velocity_feed_forward", g.velocity_feed_forward)]
                {
                    finite(key, value)?;
                }
                if g.mass > 0.0 || g.damping > 0.0 {
                    Ok(())
                } else {
                    Err(ControlError::AdmittanceWithoutMassOrDamping)
                }
            }
        }
    }
}

/// Gains of explicit force control, `u = feed_forward r + C(z) e - damping v`, `e = r - f`, with `C` a PID in
/// series with an optional lead. Every gain is zero unless given. Units follow the drive: the output is a
/// force, or a velocity for a velocity source.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ForceGains {
    /// Gain from the reference to the output.
    pub feed_forward: f64,
    /// Proportional gain, output per N.
    pub kp: f64,
    /// Integral gain, output per N s.
    pub ki: f64,
    /// Derivative gain, output per N/s.
    pub kd: f64,
    /// Joint damping, output per m/s of the motion sensor.
    pub damping: f64,
    /// Time constant of the first-order filter on the derivative, s; zero for none.
    pub derivative_filter_s: f64,
    /// Lead (or lag) compensator in series with the PID.
    pub lead: Option<LeadSpec>,
    /// What the integrator does at the output limit.
    pub anti_windup: AntiWindup,
}

/// Gains of position control, `u = kp e + ki int(e) + kd de/dt - damping v`, `e = r - x`. Every gain is zero
/// unless given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PositionGains {
    /// Proportional gain, output per m.
    pub kp: f64,
    /// Integral gain, output per m s.
    pub ki: f64,
    /// Derivative gain on the error, output per m/s.
    pub kd: f64,
    /// Damping on the measured velocity alone (no kick when the reference steps), output per m/s.
    pub damping: f64,
    /// Time constant of the first-order filter on the derivative, s; zero for none.
    pub derivative_filter_s: f64,
    /// What the integrator does at the output limit.
    pub anti_windup: AntiWindup,
}

/// Gains of impedance control (Hogan, "Impedance Control", ASME J. Dyn. Sys. Meas. Control 107, 1985):
/// `f_d = stiffness (x_r - x) + damping (v_r - v)`, `u = f_d + force_gain (f_d - f)`.
///
/// With a force drive the force gain divides the apparent inertia by `1 + force_gain`; zero needs no force
/// sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImpedanceGains {
    /// Stiffness of the programmed spring, N/m.
    pub stiffness: f64,
    /// Damping of the programmed damper, N s/m.
    pub damping: f64,
    /// Gain of the inner force loop, dimensionless.
    pub force_gain: f64,
}

/// Gains of admittance control: `mass a_v + damping v_v + stiffness (x_v - x_0) = r - f` moves a virtual
/// body, and `u = kp (x_v - x) + kd (v_v - v) + velocity_feed_forward v_v` makes the axis follow it; `x_0` is
/// where the law starts.
///
/// `velocity_feed_forward = 1` and `kd = 0` suit a velocity source.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AdmittanceGains {
    /// Virtual mass, kg; may be zero where the damping is not.
    pub mass: f64,
    /// Virtual damping, N s/m.
    pub damping: f64,
    /// Virtual stiffness, N/m.
    pub stiffness: f64,
    /// Inner loop: output per m.
    pub kp: f64,
    /// Inner loop: output per m/s.
    pub kd: f64,
    /// Output per m/s of the virtual body's velocity.
    pub velocity_feed_forward: f64,
}

/// A lead compensator `(1 + s / w_z) / (1 + s / w_p)`: gain 1 at zero frequency, `pole_hz / zero_hz` at high
/// frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeadSpec {
    /// Frequency of the zero, Hz.
    pub zero_hz: f64,
    /// Frequency of the pole, Hz; below the zero's it is a lag.
    pub pole_hz: f64,
}

/// A low-pass of gain 1 at zero frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPassSpec {
    /// Cut-off (first order) or natural (second order) frequency, Hz.
    pub cutoff_hz: f64,
    /// Second order with this damping ratio; first order where absent.
    pub damping_ratio: Option<f64>,
}

/// What an integrator does while the output is at its limit (Astrom and Hagglund, "Advanced PID Control",
/// 2006, section 3.5).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AntiWindup {
    /// Stops while the output is beyond its limit and the error would drive it further (conditional
    /// integration).
    #[default]
    Conditional,
    /// Is driven back at the rate (limited output - unlimited output) / `tracking_time_s`.
    BackCalculation {
        /// Tracking time constant, s.
        tracking_time_s: f64,
    },
    /// Winds up.
    Off,
}

impl AntiWindup {
    fn check(self) -> Result<(), ControlError> {
        match self {
            Self::BackCalculation { tracking_time_s } => {
                positive("anti_windup.tracking_time", tracking_time_s).map(drop)
            }
            Self::Conditional | Self::Off => Ok(()),
        }
    }
}

/// The phase before contact: move at a set speed until the reading reaches a force.
///
/// With a force drive the axis follows the ramp `x_0 + speed (t - t_0)`, where `x_0` and `t_0` belong to the
/// first sample of the phase, by `u = M w^2 (x_0 + speed (t - t_0) - x) + 2 * 0.7 M w (speed - v)`,
/// `w = 2 pi bandwidth_hz`; with a velocity source the command is the speed itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Speed towards the workpiece, m/s.
    pub speed: f64,
    /// The phase ends at the first sample whose reading is at least this, N.
    pub until: f64,
    /// It starts again at the first sample whose reading is below this, N (hysteresis, so at most `until`);
    /// absent, contact latches.
    pub release: Option<f64>,
    /// Natural frequency of the approach's position loop, Hz.
    pub bandwidth_hz: f64,
    /// The mass that the approach's position loop believes it moves, kg. The caller fills it in from the
    /// machine.
    pub effective_mass: f64,
    /// The drive is a velocity source.
    pub velocity_drive: bool,
}

impl Approach {
    /// Natural frequency of the approach's position loop unless the file says otherwise, Hz.
    pub const DEFAULT_BANDWIDTH_HZ: f64 = 8.0;

    /// An approach that latches, with the default bandwidth and a force drive that moves `effective_mass`.
    pub fn new(speed: f64, until: f64, effective_mass: f64) -> Self {
        Self {
            speed,
            until,
            release: None,
            bandwidth_hz: Self::DEFAULT_BANDWIDTH_HZ,
            effective_mass,
            velocity_drive: false,
        }
    }

    fn check(&self) -> Result<(), ControlError> {
        finite("approach.speed", self.speed)?;
        finite("approach.until", self.until)?;
        if let Some(release) = self.release
            && (release.is_nan() || release > self.until)
        {
            let why = "the threshold that ends the approach";
            return Err(ControlError::TooLarge {
                key: "approach.release",
                value: release,
                bound: self.until,
                why,
            });
        }
        positive("approach.bandwidth", self.bandwidth_hz)?;
        if !self.velocity_drive {
            positive("approach.effective_mass", self.effective_mass)?;
        }
        Ok(())
    }
}
