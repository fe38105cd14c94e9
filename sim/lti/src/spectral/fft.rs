//! Transform of a real record.

use realfft::RealFftPlanner;

use crate::domain::C64;
use crate::error::{LtiError, require_finite, require_positive};

/// Unscaled discrete Fourier transform: lines 0 to n / 2 of a record of n samples.
pub(crate) fn transform(record: &[f64]) -> Vec<C64> {
    let plan = RealFftPlanner::<f64>::new().plan_fft_forward(record.len());
    let mut input = record.to_vec();
    let mut output = plan.make_output_vec();
    if plan.process(&mut input, &mut output).is_err() {
        unreachable!("the buffers are made for this plan");
    }
    output
}

/// Checks what all estimators need: two records of equal length, finite, and a positive sample time.
pub(crate) fn require_pair(input: &[f64], output: &[f64], period_s: f64) -> Result<(), LtiError> {
    require_positive("sample time (s)", period_s)?;
    if input.len() != output.len() {
        return Err(LtiError::RecordLengths { left: input.len(), right: output.len() });
    }
    require_finite("input record", input)?;
    require_finite("output record", output)
}

/// Fails with [`LtiError::RecordTooShort`].
pub(crate) fn require_samples(needed: usize, found: usize) -> Result<(), LtiError> {
    if found >= needed { Ok(()) } else { Err(LtiError::RecordTooShort { needed, found }) }
}
