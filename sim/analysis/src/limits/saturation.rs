//! The frequency at which a drive reaches its limit.

use std::f64::consts::TAU;

use feeler_control::Reference;
use feeler_lti::{C64, TransferEvaluator};
use feeler_plant::assembly::Source;
use feeler_plant::description::Quantity;

use crate::error::AnalysisError;
use crate::loops::closed_loop::law_of_reference;
use crate::loops::control_loop::ControlLoop;
use crate::loops::late::Evaluator;

/// Frequency that counts as rest, as a share of half of the sampling rate.
const AT_REST: f64 = 1e-6;
/// Lowest frequency of the search, as the same share, and ratio of its steps. The search misses an excess
/// that is narrower than one step.
const LOWEST: f64 = 1e-3;
const STEPS: u32 = 2000;
/// Relative accuracy of the frequency found.
const ACCURACY: f64 = 1e-12;

impl ControlLoop {
    /// Lowest frequency at which the drive saturates under a reference as large as the final one in the file.
    /// Saturation means more command than the controller may give, or more force or force rate than the drive
    /// can make. Zero if the drive saturates at rest. Evaluated at half of the largest stable gain if there
    /// is one, else at the present gain.
    pub(crate) fn saturation_hz(
        &self,
        key: &str,
        largest_gain: Option<f64>,
    ) -> Result<Option<f64>, AnalysisError> {
        let (controller, gain) = self.gain_of_key(key)?;
        let own = &self.controllers()[controller];
        let drive = &self.assembly().drives[own.drive];
        let command_limit = own.spec.output_limit.unwrap_or(f64::INFINITY);
        if command_limit.is_infinite() && drive.limit.is_infinite() && drive.rate_limit.is_infinite() {
            return Ok(None);
        }
        let half = largest_gain
            .filter(|largest| *largest > 0.0)
            .map(|largest| self.at_half_of(controller, &gain, largest))
            .transpose()?;
        let demand = Demand::new(half.as_ref().unwrap_or(self), controller)?;
        // Ratio of the demand to the limit.
        let excess = |frequency_hz: f64| -> Result<f64, AnalysisError> {
            let [command, force] = demand.at(frequency_hz)?;
            Ok((command / command_limit)
                .max(force / drive.limit)
                .max(TAU * frequency_hz * force / drive.rate_limit))
        };
        let nyquist_hz = 0.5 / own.spec.period_s;
        let mut below = AT_REST * nyquist_hz;
        if excess(below)? > 1.0 {
            return Ok(Some(0.0));
        }
        for i in 0..=STEPS {
            let mut above = nyquist_hz * LOWEST.powf(1.0 - f64::from(i) / f64::from(STEPS));
            if excess(above)? <= 1.0 {
                below = above;
                continue;
            }
            while above > below * (1.0 + ACCURACY) {
                let middle = (below * above).sqrt();
                if middle <= below || middle >= above {
                    break;
                }
                if excess(middle)? > 1.0 { above = middle } else { below = middle }
            }
            return Ok(Some(above));
        }
        Ok(None)
    }
}

/// Demand of a reference on a drive.
struct Demand<'a> {
    whole: &'a ControlLoop,
    controller: usize,
    size: f64,
    around: Evaluator,
    made: Evaluator,
    law: TransferEvaluator,
}

impl<'a> Demand<'a> {
    fn new(whole: &'a ControlLoop, controller: usize) -> Result<Self, AnalysisError> {
        let own = &whole.controllers()[controller];
        let size = Reference::new(&own.spec.reference, 0, "")?.value(f64::MAX).abs();
        let around = whole.open_loop(controller)?.evaluator();
        // For a drive with force dynamics the limit applies to the force that it makes of the command.
        let force = whole.plant().output(Source::Drive(own.drive, Quantity::Force))?;
        let made = whole.response_to(controller, force)?.evaluator();
        Ok(Self {
            whole,
            controller,
            size,
            around,
            made,
            law: TransferEvaluator::new(&law_of_reference(own)?),
        })
    }

    /// Magnitudes of command and drive force at a frequency.
    fn at(&self, frequency_hz: f64) -> Result<[f64; 2], AnalysisError> {
        let own = &self.whole.controllers()[self.controller];
        let drive = &self.whole.assembly().drives[own.drive];
        let z = C64::cis(TAU * frequency_hz * own.spec.period_s);
        let command = self.law.at(z)?[(0, 0)] / (self.around.at(z)? + 1.0) * self.size;
        let force = if drive.limits_force() {
            (command * self.made.at(z)?).norm()
        } else {
            command.norm() * drive.gain
        };
        Ok([command.norm(), force])
    }
}
