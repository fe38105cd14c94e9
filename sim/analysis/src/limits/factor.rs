//! Stability of a loop against one common factor on the gain of every drive, whatever the law.

use feeler_control::Law;

use crate::error::AnalysisError;
use crate::limits::stability::{Band, Edge, GainBands};
use crate::loops::control_loop::ControlLoop;
use crate::loops::sampled_loop::SampledLoop;

/// Largest factor of the search if the loop has much dead time.
const LARGEST_FACTOR: f64 = 1e3;

impl ControlLoop {
    /// Stable factors on the gain of every drive in the sampled loop, from zero onwards; 1 means the gains as
    /// they are. Edges are as exact as those of [`Self::sampled_bands`], and equal to them if one gain is the
    /// whole law.
    ///
    /// # Errors
    /// As [`Self::sampled_bands`].
    pub fn stable_factors(&self) -> Result<GainBands, AnalysisError> {
        let mut closing = (0..self.controllers().len())
            .filter(|&i| !matches!(self.controllers()[i].spec.law, Law::OpenLoop));
        if let (Some(only), None) = (closing.next(), closing.next())
            && let Ok(open) = self.open_loop(only)
            && open.samples > 0
        {
            let edge = |gain: f64, frequency_hz: f64| Edge { gain, frequency_hz, mode: None };
            let intervals = open.transfer()?.stable_gains_up_to(LARGEST_FACTOR)?;
            let bands = intervals.into_iter().map(|found| Band {
                lower: (found.lower > 0.0).then(|| edge(found.lower, found.lower_frequency_hz)),
                upper: (found.upper < LARGEST_FACTOR).then(|| edge(found.upper, found.upper_frequency_hz)),
            });
            return Ok(GainBands { bands: bands.collect() });
        }
        let sampled = SampledLoop::new(self)?;
        let matrix = |factor: f64| sampled.closed_loop_driven(factor);
        self.bands(sampled.domain()?, matrix, sampled.expand(), sampled.alias_s())
    }
}
