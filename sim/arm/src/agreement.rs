//! Agreement of an axis with the whole arm, in linear theory and in contact.

use std::f64::consts::{PI, TAU};

use nalgebra::{Complex, DMatrix, DVector};

use crate::error::ArmError;
use crate::flexible::{Arm, LinearArm, Others};
use crate::linear_system::{ArmMode, LinearSystem};
use crate::reduce::Reduction;
use crate::sampled::{Edge, Lag, Law, SampledPlant};

/// Damping ratio that the motors' damping would give the contact mode of a rigid arm, in the analysis of
/// integral force control.
const DAMPING_RATIO: f64 = 0.7;
/// Share of the largest stable integral gain for the force bandwidth: a gain margin of two.
const GAIN_SHARE: f64 = 0.5;
/// Largest difference of each landmark from the whole arm's before further bodies are added.
const CLOSE: [f64; 4] = [0.002, 0.01, 0.02, 0.02];
/// Frequencies per decade at which a phase is followed.
const PER_DECADE: f64 = 1500.0;
/// First frequency of the phase, over the contact mode; the phase is still near zero there.
const FROM: f64 = 0.05;
/// Last frequency of the phase, over the contact mode.
const TO: f64 = 100.0;

/// The same landmarks of the whole arm and of its axis, with the tool on a spring and damper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// Frequency of the mode in which the arm moves on the contact: whole arm, axis; Hz.
    pub contact_mode_hz: [f64; 2],
    /// Frequency at which the phase from drive force to contact force falls through -180 degrees: whole arm,
    /// axis; Hz. It includes the damper and excludes the drives' bandwidths. NaN if it does not.
    pub phase_crossover_hz: [f64; 2],
    /// Largest stable gain of proportional control of the contact's spring force, sampled at 1 kHz, with the
    /// drives' bandwidths: whole arm, axis. Zero if no gain is stable, infinite if all are.
    pub largest_kp: [f64; 2],
    /// Largest stable gain of integral control, 1/s. The motors are damped by
    /// [`Self::motor_damping_n_s_per_m`] on the difference of their last two encoder positions.
    pub largest_ki_per_s: [f64; 2],
    /// Crossover frequency of that integral loop at half of its own largest stable gain: whole arm, axis; Hz.
    /// NaN if no gain is stable, or all are.
    pub force_bandwidth_hz: [f64; 2],
    /// `2 * 0.7 * omega * M` with the whole arm's contact mode `omega` and its rigid mass `M`. The damping
    /// ratio of one mass on the contact would be 0.7; those of the arm's own modes differ.
    pub motor_damping_n_s_per_m: f64,
}

/// A quantity in which an axis is compared with the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Landmark {
    /// The mode in which the arm moves on the contact.
    ContactMode,
    /// The frequency at which the phase falls through -180 degrees.
    PhaseCrossover,
    /// Largest stable gain of proportional force control.
    StableKp,
    /// Largest stable gain of integral force control with damped motors.
    StableKi,
}

impl Landmark {
    /// All landmarks, in the order of [`Agreement::misfits`].
    pub const ALL: [Self; 4] = [Self::ContactMode, Self::PhaseCrossover, Self::StableKp, Self::StableKi];

    /// Whether it is a largest stable gain, which may be zero or unlimited.
    pub fn is_gain(self) -> bool {
        matches!(self, Self::StableKp | Self::StableKi)
    }

    /// Its name in a sentence.
    pub fn name(self) -> &'static str {
        match self {
            Self::ContactMode => "contact mode",
            Self::PhaseCrossover => "phase crossover",
            Self::StableKp => "stable kp",
            Self::StableKi => "stable ki",
        }
    }
}

impl Agreement {
    /// Largest difference in any landmark at which the axis can be trusted.
    pub const TRUSTED: f64 = 0.05;

    /// The landmarks of the whole arm and of the axis, in the order of [`Landmark::ALL`].
    pub fn landmarks(&self) -> [[f64; 2]; 4] {
        [self.contact_mode_hz, self.phase_crossover_hz, self.largest_kp, self.largest_ki_per_s]
    }

    /// Relative difference of the axis from the arm in each of [`Landmark::ALL`]; infinite if only one of the
    /// two has it.
    pub fn misfits(&self) -> [f64; 4] {
        self.landmarks().map(apart)
    }

    /// The largest difference of a landmark.
    pub fn worst(&self) -> f64 {
        self.misfits().into_iter().fold(0.0, f64::max)
    }

    /// Difference of each landmark over its tolerance; above one, further bodies are added.
    pub(crate) fn over_close(&self) -> [f64; 4] {
        let mut over = self.misfits();
        over.iter_mut().zip(CLOSE).for_each(|(misfit, close)| *misfit /= close);
        over
    }

    pub(crate) fn farthest(&self) -> f64 {
        self.over_close().into_iter().fold(0.0, f64::max)
    }

    /// All differences as one number, to rank axes that are all outside the tolerance.
    pub(crate) fn distance(&self) -> f64 {
        self.over_close().into_iter().fold(0.0, f64::hypot)
    }

    /// Whether all differences are within [`Self::TRUSTED`].
    pub fn is_trusted(&self) -> bool {
        self.worst() <= Self::TRUSTED
    }
}

/// Relative difference of the second from the first. Zero if neither is positive and finite, or if both are
/// equal; infinite if only one is valid.
pub(crate) fn apart([one, other]: [f64; 2]) -> f64 {
    let is_one = |x: f64| x.is_finite() && x > 0.0;
    match (is_one(one), is_one(other)) {
        (true, true) => (other / one - 1.0).abs(),
        (false, false) if (one.is_nan(), one.is_infinite()) == (other.is_nan(), other.is_infinite()) => 0.0,
        _ => f64::INFINITY,
    }
}

impl Reduction {
    /// Force of a spring (N/m) and damper (N s/m) under the tool per drive force, at a frequency in Hz.
    pub fn response_in_contact(&self, contact: [f64; 2], frequency_hz: f64) -> Complex<f64> {
        let s = Complex::new(0.0, TAU * frequency_hz);
        let touch = contact[0] + contact[1] * s;
        touch * self.moved(touch, s)[0]
    }

    /// Displacement of the tool and of the motor per drive force, with a resistance `touch` per displacement
    /// under the tool.
    pub(crate) fn moved(&self, touch: Complex<f64>, s: Complex<f64>) -> [Complex<f64>; 2] {
        let mut joint = self.stiffness_n_per_m + self.damping_n_s_per_m * s;
        let mut motor = self.motor_mass_kg * s * s + self.guide_damping_n_s_per_m * s;
        let mut tip = self.tip_mass_kg * s * s + touch;
        for branch in &self.branches {
            // A star of mass and two springs as a triangle.
            let inertia = branch.mass_kg * s * s;
            let spring = branch.stiffness_n_per_m + branch.damping_n_s_per_m * s;
            let link = branch.to_tool_n_per_m + branch.to_tool_n_s_per_m * s;
            let sum = inertia + spring + link;
            motor += inertia * spring / sum;
            tip += inertia * link / sum;
            joint += spring * link / sum;
        }
        let (at_motor, at_tip) = (motor + joint, tip + joint);
        let determinant = at_motor * at_tip - joint * joint;
        [joint / determinant, at_tip / determinant]
    }

    /// Modes of the axis with the tool on a spring, slowest first; with zero stiffness those of the axis in
    /// the air.
    pub fn modes_in_contact(&self, contact_n_per_m: f64) -> Vec<ArmMode> {
        self.system().modes(contact_n_per_m)
    }

    /// Frequency of the mode in which the axis moves on a contact of this stiffness, N/m. It is the first
    /// that carries a large part of a slow drive force to it.
    pub fn contact_mode_hz(&self, contact_n_per_m: f64) -> f64 {
        self.system().contact_mode_hz(contact_n_per_m)
    }

    /// Coordinates are those of motor, tool and branches.
    fn system(&self) -> LinearSystem {
        let n = 2 + self.branches.len();
        let masses = [self.motor_mass_kg, self.tip_mass_kg]
            .into_iter()
            .chain(self.branches.iter().map(|branch| branch.mass_kg));
        let mass = DMatrix::from_diagonal(&DVector::from_iterator(n, masses));
        let (mut stiffness, mut damping) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        damping[(0, 0)] = self.guide_damping_n_s_per_m;
        let mut join = |from: usize, to: usize, k: f64, c: f64| {
            let ends = DVector::from_fn(n, |row, _| {
                f64::from(u8::from(row == from)) - f64::from(u8::from(row == to))
            });
            let square = &ends * ends.transpose();
            stiffness += k * &square;
            damping += c * &square;
        };
        join(0, 1, self.stiffness_n_per_m, self.damping_n_s_per_m);
        for (i, branch) in (2..).zip(&self.branches) {
            join(0, i, branch.stiffness_n_per_m, branch.damping_n_s_per_m);
            join(1, i, branch.to_tool_n_per_m, branch.to_tool_n_s_per_m);
        }
        let unit = |i: usize| DVector::from_fn(n, |row, _| if row == i { 1.0 } else { 0.0 });
        LinearSystem { mass, stiffness, damping, tip: unit(1), drive: unit(0), mass_kg: self.mass_kg }
    }

    /// Stable gains of force control on a contact (N/m, N s/m), with this damping of the motor (N s/m) for
    /// integral control.
    fn largest_gains(&self, contact: [f64; 2], damping_n_s_per_m: f64, first_hz: f64) -> Gains {
        let system = self.system();
        let lags = [(self.bandwidth_hz, system.drive.clone())];
        largest_gains(&system, &lags, contact, damping_n_s_per_m, first_hz)
    }
}

/// Stable gains and bandwidth of force control.
struct Gains {
    /// Largest stable gains: proportional, and integral, 1/s.
    largest: [Edge; 2],
    /// Crossover of the integral loop at half of its gain, Hz.
    bandwidth_hz: f64,
}

/// NaN for values that overflow.
fn largest_gains(
    system: &LinearSystem,
    lags: &[Lag],
    contact: [f64; 2],
    damping_n_s_per_m: f64,
    first_hz: f64,
) -> Gains {
    let Ok(plant) = SampledPlant::new(system, lags, contact, first_hz) else {
        return Gains { largest: [Edge::UNKNOWN; 2], bandwidth_hz: f64::NAN };
    };
    let largest = [plant.largest_kp(), plant.largest_ki_per_s(damping_n_s_per_m)];
    Gains { largest, bandwidth_hz: plant.crossover_hz(damping_n_s_per_m, GAIN_SHARE * largest[1].gain) }
}

/// The whole arm's landmarks in contact, with which axes are compared.
pub(crate) struct WholeArm {
    contact: [f64; 2],
    grid_hz: Vec<f64>,
    contact_mode_hz: f64,
    phase_crossover_hz: f64,
    motor_damping_n_s_per_m: f64,
    gains: Gains,
}

impl WholeArm {
    pub(crate) fn new(linear: &LinearArm, contact: [f64; 2]) -> Self {
        let contact_mode_hz = linear.system.contact_mode_hz(contact[0]);
        let steps = (PER_DECADE * (TO / FROM).log10()) as u32;
        let grid_hz: Vec<f64> = (0..=steps)
            .map(|i| contact_mode_hz * FROM * (TO / FROM).powf(f64::from(i) / f64::from(steps)))
            .collect();
        let response = linear.system.response_in_contact(contact, &grid_hz);
        let motor_damping_n_s_per_m = 2.0 * DAMPING_RATIO * TAU * contact_mode_hz * linear.system.mass_kg;
        Self {
            contact,
            contact_mode_hz,
            phase_crossover_hz: falls_through_hz(&grid_hz, &response, PI),
            motor_damping_n_s_per_m,
            gains: largest_gains(
                &linear.system,
                &linear.lags,
                contact,
                motor_damping_n_s_per_m,
                contact_mode_hz,
            ),
            grid_hz,
        }
    }

    /// Frequencies that determine the landmarks, Hz; NaN if there is none.
    pub(crate) fn frequencies_hz(&self) -> [f64; 4] {
        let [kp, ki] = self.gains.largest;
        [self.contact_mode_hz, self.phase_crossover_hz, kp.frequency_hz, ki.frequency_hz]
    }

    /// The edges that determine the stable gains, proportional and integral, if any.
    pub(crate) fn loops(&self) -> Vec<(Law, Edge)> {
        let [kp, ki] = self.gains.largest;
        let loops = [(Law::Proportional, kp), (Law::Integral(self.motor_damping_n_s_per_m), ki)];
        loops.into_iter().filter(|(_, edge)| edge.gain > 0.0 && edge.gain.is_finite()).collect()
    }

    pub(crate) fn judged(&self, axis: Reduction) -> (Reduction, Agreement) {
        let agreement = self.agreement(&axis);
        (axis, agreement)
    }

    pub(crate) fn agreement(&self, axis: &Reduction) -> Agreement {
        let response: Vec<_> =
            self.grid_hz.iter().map(|f| axis.response_in_contact(self.contact, *f)).collect();
        let gains = axis.largest_gains(self.contact, self.motor_damping_n_s_per_m, self.contact_mode_hz);
        Agreement {
            contact_mode_hz: [self.contact_mode_hz, axis.contact_mode_hz(self.contact[0])],
            phase_crossover_hz: [self.phase_crossover_hz, falls_through_hz(&self.grid_hz, &response, PI)],
            largest_kp: [self.gains.largest[0].gain, gains.largest[0].gain],
            largest_ki_per_s: [self.gains.largest[1].gain, gains.largest[1].gain],
            force_bandwidth_hz: [self.gains.bandwidth_hz, gains.bandwidth_hz],
            motor_damping_n_s_per_m: self.motor_damping_n_s_per_m,
        }
    }
}

impl Arm {
    /// Compares an axis with the whole arm, both linear about the pose, with the tool on a spring (N/m) and
    /// damper (N s/m).
    ///
    /// # Errors
    /// Those of [`Self::reduce`].
    pub fn agreement(
        &self,
        axis: &Reduction,
        q: &[f64],
        normal: [f64; 3],
        others: Others,
        contact: [f64; 2],
    ) -> Result<Agreement, ArmError> {
        Ok(WholeArm::new(&self.linear(q, normal, others)?, contact).agreement(axis))
    }
}

/// The first frequency at which a phase that starts near zero has fallen by `turn`, rad; linear between the
/// points of the grid.
pub(crate) fn falls_through_hz(grid: &[f64], values: &[Complex<f64>], turn: f64) -> f64 {
    let mut phase = values[0].arg();
    for (f, z) in grid.windows(2).zip(values.windows(2)) {
        let step = (z[1] / z[0]).arg();
        if phase + step <= -turn {
            return f[0] + (f[1] - f[0]) * (-turn - phase) / step;
        }
        phase += step;
    }
    f64::NAN
}
