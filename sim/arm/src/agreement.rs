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

impl Reduction {
    /// Force of a spring (N/m) and damper (N s/m) under the tool per drive force, at a frequency in Hz.
    pub fn response_in_contact(&self, contact: [f64; 2], frequency_hz: f64) -> Complex<f64> {
        let s = Complex::new(0.0, TAU * frequency_hz);
        let joint = self.stiffness_n_per_m + self.damping_n_s_per_m * s;
        let touch = contact[0] + contact[1] * s;
        let mut motor = self.motor_mass_kg * s * s + self.guide_damping_n_s_per_m * s + joint;
        for branch in &self.branches {
            let (inertia, spring) = (branch.mass_kg * s * s, branch.stiffness_n_per_m + branch.damping_n_s_per_m * s);
            motor += inertia * spring / (inertia + spring);
        }
        let tip = self.tip_mass_kg * s * s + joint + touch;
        touch * joint / (motor * tip - joint * joint)
    }

    /// Modes of the axis with the tool on a spring, slowest first; with a spring of zero those of the axis in the air.
    pub fn modes_in_contact(&self, contact_n_per_m: f64) -> Vec<VibrationMode> {
        self.system().modes(contact_n_per_m)
    }

    /// Coordinates are those of motor, tool and branches.
    fn system(&self) -> LinearSystem {
        let n = 2 + self.branches.len();
        let masses = [self.motor_mass_kg, self.tip_mass_kg].into_iter().chain(self.branches.iter().map(|branch| branch.mass_kg));
        let mass = DMatrix::from_diagonal(&DVector::from_iterator(n, masses));
        let (mut stiffness, mut damping) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        damping[(0, 0)] = self.guide_damping_n_s_per_m;
        let tool = (self.stiffness_n_per_m, self.damping_n_s_per_m);
        let branches = self.branches.iter().map(|branch| (branch.stiffness_n_per_m, branch.damping_n_s_per_m));
        for (i, (k, c)) in std::iter::once(tool).chain(branches).enumerate() {
            for (matrix, number) in [(&mut stiffness, k), (&mut damping, c)] {
                let mut ends = DVector::zeros(n);
                (ends[0], ends[i + 1]) = (1.0, -1.0);
                *matrix += number * &ends * ends.transpose();
            }
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
            phase_crossover_hz: half_turn_hz(&grid_hz, &response),
            grid_hz,
        }
    }

    pub(crate) fn agreement(&self, axis: &Reduction) -> Agreement {
        let response: Vec<_> = self.grid_hz.iter().map(|f| axis.response_in_contact(self.contact, *f)).collect();
        Agreement {
            contact_mode_hz: [self.contact_mode_hz, contact_mode_hz(&axis.modes_in_contact(self.contact[0]))],
            phase_crossover_hz: [self.phase_crossover_hz, half_turn_hz(&self.grid_hz, &response)],
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

/// The first frequency at which a phase that starts near zero has fallen to -180 degrees.
fn half_turn_hz(grid: &[f64], values: &[Complex<f64>]) -> f64 {
    let mut phase = values[0].arg();
    for (f, z) in grid.windows(2).zip(values.windows(2)) {
        let step = (z[1] / z[0]).arg();
        if phase + step <= -PI {
            return f[0] + (f[1] - f[0]) * (-PI - phase) / step;
        }
        phase += step;
    }
    f64::NAN
}
