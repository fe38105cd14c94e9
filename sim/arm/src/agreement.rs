//! How well an axis stands for the whole arm, in linear theory and in contact.

use std::f64::consts::{PI, TAU};

use nalgebra::{Complex, DMatrix, DVector};

use crate::error::ArmError;
use crate::flexible::{Arm, LinearArm, Others, VibrationMode};
use crate::linear_system::LinearSystem;
use crate::reduce::Reduction;

/// Part of the way from drive to tool from which on a mode counts as the one in which the arm as a whole moves on the contact.
const WHOLE_ARM: f64 = 0.3;
/// Frequencies at which a phase is followed, per factor of ten.
const PER_DECADE: f64 = 1500.0;
/// Where the phase is followed from, over the contact mode; there it is still near zero.
const FROM: f64 = 0.05;
/// How far, over the contact mode.
const TO: f64 = 100.0;

/// The same two landmarks of the whole arm and of its axis, the tool on a spring and damper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// Frequency of the mode in which the arm moves on the contact: whole arm, axis; Hz.
    pub contact_mode_hz: [f64; 2],
    /// Where the phase from drive force to contact force falls through -180 degrees: whole arm, axis; Hz. Not a number where it does not.
    pub phase_crossover_hz: [f64; 2],
}

impl Agreement {
    /// How far the axis may be from the arm in either landmark before it should not be trusted.
    pub const TRUSTED: f64 = 0.05;

    /// How far the axis's contact mode and phase crossover are from the arm's, over the arm's; infinite where only one of the two has one.
    pub fn misfits(&self) -> [f64; 2] {
        [self.contact_mode_hz, self.phase_crossover_hz].map(apart)
    }

    /// The larger of the two.
    pub fn worst(&self) -> f64 {
        let [mode, crossover] = self.misfits();
        mode.max(crossover)
    }

    /// Whether both are within [`Self::TRUSTED`].
    pub fn is_trusted(&self) -> bool {
        self.worst() <= Self::TRUSTED
    }
}

/// How far the second is from the first, over the first; zero where neither is a number, infinite where one is none.
pub(crate) fn apart([one, other]: [f64; 2]) -> f64 {
    match (one.is_nan(), other.is_nan()) {
        (true, true) => 0.0,
        (false, false) => (other / one - 1.0).abs(),
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

    /// Way of the tool and of the motor per drive force, something under the tool that resists with `touch` per way.
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

    /// Modes of the axis with the tool on a spring, slowest first; with a spring of zero those of the axis in the air.
    pub fn modes_in_contact(&self, contact_n_per_m: f64) -> Vec<VibrationMode> {
        self.system().modes(contact_n_per_m)
    }

    /// Frequency of the mode in which the axis moves on a contact of so much stiffness, N/m; not a number where there is none.
    pub fn contact_mode_hz(&self, contact_n_per_m: f64) -> f64 {
        contact_mode_hz(&self.modes_in_contact(contact_n_per_m))
    }

    /// Coordinates are those of motor, tool and branches.
    fn system(&self) -> LinearSystem {
        let n = 2 + self.branches.len();
        let masses = [self.motor_mass_kg, self.tip_mass_kg].into_iter().chain(self.branches.iter().map(|branch| branch.mass_kg));
        let mass = DMatrix::from_diagonal(&DVector::from_iterator(n, masses));
        let (mut stiffness, mut damping) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        damping[(0, 0)] = self.guide_damping_n_s_per_m;
        let mut join = |from: usize, to: usize, k: f64, c: f64| {
            let ends = DVector::from_fn(n, |row, _| f64::from(u8::from(row == from)) - f64::from(u8::from(row == to)));
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
}

/// The whole arm's landmarks in contact, against which axes are held.
pub(crate) struct WholeArm {
    contact: [f64; 2],
    grid_hz: Vec<f64>,
    contact_mode_hz: f64,
    phase_crossover_hz: f64,
}

impl WholeArm {
    /// The frequencies at which phases are followed are taken from an axis that has about the arm's contact mode.
    pub(crate) fn new(linear: &LinearArm, axis: &Reduction, contact: [f64; 2]) -> Self {
        let modes = axis.modes_in_contact(contact[0]);
        let own = modes.first().map_or(f64::NAN, |mode| mode.frequency_hz);
        let steps = (PER_DECADE * (TO / FROM).log10()) as u32;
        let grid_hz: Vec<f64> = (0..=steps).map(|i| own * FROM * (TO / FROM).powf(f64::from(i) / f64::from(steps))).collect();
        let response = linear.system.response_in_contact(contact, &grid_hz);
        Self {
            contact,
            contact_mode_hz: contact_mode_hz(&linear.system.modes(contact[0])),
            phase_crossover_hz: falls_through_hz(&grid_hz, &response, PI),
            grid_hz,
        }
    }

    /// An axis with its agreement.
    pub(crate) fn judged(&self, axis: Reduction) -> (Reduction, Agreement) {
        let agreement = self.agreement(&axis);
        (axis, agreement)
    }

    pub(crate) fn agreement(&self, axis: &Reduction) -> Agreement {
        let response: Vec<_> = self.grid_hz.iter().map(|f| axis.response_in_contact(self.contact, *f)).collect();
        Agreement {
            contact_mode_hz: [self.contact_mode_hz, axis.contact_mode_hz(self.contact[0])],
            phase_crossover_hz: [self.phase_crossover_hz, falls_through_hz(&self.grid_hz, &response, PI)],
        }
    }
}

impl Arm {
    /// Holds an axis against the whole arm, both linear about the pose, the tool on a spring (N/m) and damper (N s/m).
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
        Ok(WholeArm::new(&self.linear(q, normal, others)?, axis, contact).agreement(axis))
    }
}

/// Frequency of the first mode in which drive and tool move together; not a number where there is none.
fn contact_mode_hz(modes: &[VibrationMode]) -> f64 {
    modes.iter().find(|mode| mode.drive_share.abs() > WHOLE_ARM).map_or(f64::NAN, |mode| mode.frequency_hz)
}

/// The first frequency at which a phase that starts near zero has fallen by `turn`, rad; between the points of the grid a straight line.
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
