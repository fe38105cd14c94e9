//! Multisines: periodic excitations with chosen lines.

use std::f64::consts::TAU;

use crate::error::{LtiError, require_finite};

/// A sum of cosines at whole multiples (lines) of one over the period.
#[derive(Debug, Clone, PartialEq)]
pub struct Multisine {
    samples_per_period: usize,
    lines: Vec<usize>,
    amplitude: f64,
    phases_rad: Vec<f64>,
}

impl Multisine {
    /// A multisine with equal amplitudes and root mean square `rms` at the given lines, one phase (rad) each.
    /// With random phases, uniform over a turn, its values are nearly normally distributed, and a nonlinear
    /// system shows its best linear approximation.
    ///
    /// # Errors
    /// [`LtiError::RecordLengths`] unless there is a phase for each line; [`LtiError::OutOfRange`] for a line
    /// not between 1 and below half the samples; [`LtiError::NotFinite`].
    pub fn new(
        samples_per_period: usize,
        lines: Vec<usize>,
        rms: f64,
        phases_rad: Vec<f64>,
    ) -> Result<Self, LtiError> {
        if lines.len() != phases_rad.len() {
            return Err(LtiError::RecordLengths { left: lines.len(), right: phases_rad.len() });
        }
        if let Some(&line) = lines.iter().find(|&&line| line == 0 || 2 * line >= samples_per_period) {
            return Err(LtiError::OutOfRange {
                quantity: "line",
                value: line as f64,
                range: "[1, samples per period / 2)",
            });
        }
        require_finite("root mean square", [&rms])?;
        require_finite("phases (rad)", &phases_rad)?;
        let amplitude = rms * (2.0 / lines.len().max(1) as f64).sqrt();
        Ok(Self { samples_per_period, lines, amplitude, phases_rad })
    }

    /// The excited lines.
    pub fn lines(&self) -> &[usize] {
        &self.lines
    }

    /// One sample; the sequence is periodic.
    pub fn sample(&self, index: usize) -> f64 {
        let n = self.samples_per_period;
        let cosine =
            |(line, phase): (&usize, &f64)| (TAU * (line * (index % n) % n) as f64 / n as f64 + phase).cos();
        self.amplitude * self.lines.iter().zip(&self.phases_rad).map(cosine).sum::<f64>()
    }

    /// One period.
    pub fn period(&self) -> Vec<f64> {
        (0..self.samples_per_period).map(|i| self.sample(i)).collect()
    }
}
