//! Measured frequency response of a simulated arm, with a multisine on the drive.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use nalgebra::Complex;

use crate::agreement::{apart, falls_through_hz};
use crate::error::ArmError;
use crate::flexible::{Arm, Others};
use crate::flexible_arm::{FlexibleArm, Wall};
use crate::reduce::Reduction;

/// Lines of the multisine per contact mode, which sets their spacing.
const LINES_PER_MODE: f64 = 16.0;
/// First line over the contact mode, last over the phase crossover.
const BAND: [f64; 2] = [0.3, 1.4];
/// Force that presses the tool on, N: small, so that the arm stays linear.
const PRESS_N: f64 = 0.2;
/// Largest reduction of that force by all lines together, as a share; the tool stays in contact.
const SWING: f64 = 0.5;
/// Time constants of the slowest mode before the evaluation.
const SETTLED: f64 = 7.0;
/// Longest wait, s.
const LONGEST_S: f64 = 30.0;
/// Largest product of step and fastest angular frequency: the fourth-order steps are stable up to 2.8.
const STABLE: f64 = 1.0;
/// Fewest steps per period of the fastest line.
const PER_PERIOD: f64 = 40.0;

/// Result of a measurement on the simulated arm, and the linear theory of the axis.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredArm {
    /// Lines of the multisine, Hz.
    pub frequencies_hz: Vec<f64>,
    /// Force of the contact per drive force at each line.
    pub response: Vec<Complex<f64>>,
    /// Frequency at which the phase falls through -90 degrees, the contact mode: simulated arm, axis; Hz.
    pub contact_mode_hz: [f64; 2],
    /// Frequency at which the phase falls through -180 degrees: simulated arm, axis; Hz.
    pub phase_crossover_hz: [f64; 2],
    pub simulated_s: f64,
}

impl MeasuredArm {
    /// Relative difference of the axis from the simulated arm in both frequencies.
    pub fn misfits(&self) -> [f64; 2] {
        [self.contact_mode_hz, self.phase_crossover_hz].map(apart)
    }
}

impl Arm {
    /// Simulates the arm with a multisine on the drive, the tool lightly pressed on a spring (N/m) and damper
    /// (N s/m). Compares an axis with the measured response. The simulation has all links, joints and motors
    /// with all terms of the equations, but no dry friction and no limits of the drives.
    ///
    /// # Errors
    /// Those of [`Self::reduce`], and [`ArmError::Diverged`].
    pub fn measure_in_contact(
        &self,
        axis: &Reduction,
        q: &[f64],
        normal: [f64; 3],
        others: Others,
        contact: [f64; 2],
    ) -> Result<MeasuredArm, ArmError> {
        let linear = self.linear(q, normal, others)?;
        let agreement = self.agreement(axis, q, normal, others, contact)?;
        let [mode_hz, own_mode_hz] = agreement.contact_mode_hz;
        let mode_hz = if mode_hz.is_finite() { mode_hz } else { own_mode_hz };
        let crossover_hz =
            agreement.phase_crossover_hz.into_iter().filter(|f| f.is_finite()).fold(2.0 * mode_hz, f64::max);
        let spacing_hz = mode_hz / LINES_PER_MODE;
        let (first, last) =
            ((BAND[0] * LINES_PER_MODE).ceil() as u32, (BAND[1] * crossover_hz / spacing_hz).ceil() as u32);
        let lines: Vec<u32> = (first..=last).collect();
        let frequencies_hz: Vec<f64> = lines.iter().map(|line| f64::from(*line) * spacing_hz).collect();
        let modes = linear.system.modes(contact[0]);
        let fastest = TAU * modes.last().map_or(mode_hz, |mode| mode.frequency_hz);
        let slowest = modes
            .iter()
            .map(|mode| mode.damping_ratio * TAU * mode.frequency_hz)
            .fold(f64::INFINITY, f64::min);
        let (period_s, settle_s) = (1.0 / spacing_hz, (SETTLED / slowest).min(LONGEST_S));
        let steps = (period_s * (fastest / STABLE).max(PER_PERIOD * frequencies_hz[frequencies_hz.len() - 1]))
            .ceil() as u32;
        let step_s = period_s / f64::from(steps);
        let periods = 1 + (settle_s / period_s).ceil() as u32;
        let sizes = linear.system.response_in_contact(contact, &frequencies_hz);
        let amplitude_n = SWING * PRESS_N / sizes.iter().map(|z| z.norm()).sum::<f64>();
        let count = f64::from(last - first + 1);
        // Schroeder's phases: there is no instant at which all lines add up.
        let phase = |i: f64| -PI * i * (i - 1.0) / count;
        let drive: Vec<f64> = (0..steps)
            .map(|step| {
                let line = |(i, line): (usize, &u32)| {
                    (TAU * f64::from(*line) * f64::from(step) / f64::from(steps) + phase(i as f64)).cos()
                };
                PRESS_N + amplitude_n * lines.iter().enumerate().map(line).sum::<f64>()
            })
            .collect();
        let wall = Wall { gap_m: 0.0, stiffness_n_per_m: contact[0], damping_n_s_per_m: contact[1] };
        let mut arm = FlexibleArm::new(self, q, normal, others, wall)?;
        arm.press(contact[0], PRESS_N);
        let mut forces = vec![0.0; drive.len()];
        for period in 0..periods {
            for (force, drive) in forces.iter_mut().zip(&drive) {
                if period + 1 == periods {
                    *force = arm.force_n();
                }
                arm.step(step_s, *drive)?;
            }
        }
        let line = |values: &[f64], line: u32| {
            let turn = |k: usize| -TAU * f64::from(line) * k as f64 / f64::from(steps);
            values.iter().enumerate().map(|(k, x)| Complex::from_polar(*x, turn(k))).sum::<Complex<f64>>()
        };
        let held = |f: f64| {
            let half = PI * f * step_s;
            Complex::from_polar(half.sin() / half, -half)
        };
        let response: Vec<Complex<f64>> = (lines.iter().zip(&frequencies_hz))
            .map(|(n, f)| line(&forces, *n) / (line(&drive, *n) * held(*f)))
            .collect();
        let own: Vec<Complex<f64>> =
            frequencies_hz.iter().map(|f| axis.response_in_contact(contact, *f)).collect();
        let both =
            |turn: f64| [&response, &own].map(|values| falls_through_hz(&frequencies_hz, values, turn));
        Ok(MeasuredArm {
            contact_mode_hz: both(FRAC_PI_2),
            phase_crossover_hz: both(PI),
            simulated_s: f64::from(periods) * period_s,
            frequencies_hz,
            response,
        })
    }
}
