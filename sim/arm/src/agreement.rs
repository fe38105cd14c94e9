//! How well the axis of two masses stands for the whole arm, in linear theory and in contact.

use std::f64::consts::{PI, TAU};

use nalgebra::Complex;

use crate::error::ArmError;
use crate::flexible::{Arm, Others};
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
        let motor = self.motor_mass_kg * s * s + self.guide_damping_n_s_per_m * s + joint;
        let tip = self.tip_mass_kg * s * s + joint + touch;
        touch * joint / (motor * tip - joint * joint)
    }

    /// Undamped frequencies of the two modes with the tool on a spring, Hz.
    pub fn modes_in_contact_hz(&self, contact_n_per_m: f64) -> [f64; 2] {
        let (m1, m2, k) = (self.motor_mass_kg, self.tip_mass_kg, self.stiffness_n_per_m);
        let sum = k / m1 + (k + contact_n_per_m) / m2;
        let product = k * contact_n_per_m / (m1 * m2);
        let upper = 0.5 * (sum + (sum * sum - 4.0 * product).max(0.0).sqrt());
        [(product / upper).sqrt() / TAU, upper.sqrt() / TAU]
    }
}

impl Arm {
    /// Holds the axis of two masses against the whole arm, both linear about the pose, the tool on a spring (N/m) and damper (N s/m).
    ///
    /// # Errors
    /// Those of [`Self::reduce`].
    pub fn agreement(&self, q: &[f64], normal: [f64; 3], others: Others, contact: [f64; 2]) -> Result<Agreement, ArmError> {
        let axis = self.reduce(q, normal, others)?;
        let modes = self.modes_in_contact(q, normal, others, contact[0])?;
        let whole = modes.iter().find(|mode| mode.drive_share.abs() > WHOLE_ARM).map_or(f64::NAN, |mode| mode.frequency_hz);
        let [own, _] = axis.modes_in_contact_hz(contact[0]);
        let steps = (PER_DECADE * (TO / FROM).log10()) as u32;
        let grid: Vec<f64> = (0..=steps).map(|i| own * FROM * (TO / FROM).powf(f64::from(i) / f64::from(steps))).collect();
        let full = self.response_in_contact(q, normal, others, contact, &grid)?;
        let reduced: Vec<_> = grid.iter().map(|f| axis.response_in_contact(contact, *f)).collect();
        Ok(Agreement { contact_mode_hz: [whole, own], phase_crossover_hz: [&full, &reduced].map(|values| half_turn_hz(&grid, values)) })
    }
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
