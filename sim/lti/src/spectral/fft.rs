//! Transform of a real record.

use std::cell::RefCell;
use std::sync::Arc;

use realfft::{RealFftPlanner, RealToComplex};

use crate::domain::C64;
use crate::error::{LtiError, require_finite, require_positive};

thread_local! {
    /// The plan of the last transform: records usually have equal length, and a plan costs as much as several
    /// transforms.
    static LAST_PLAN: RefCell<Option<Arc<dyn RealToComplex<f64>>>> = const { RefCell::new(None) };
}

fn plan(samples: usize) -> Arc<dyn RealToComplex<f64>> {
    LAST_PLAN.with_borrow_mut(|last| {
        let fits = last.take().filter(|plan| plan.len() == samples);
        Arc::clone(last.insert(fits.unwrap_or_else(|| RealFftPlanner::new().plan_fft_forward(samples))))
    })
}

/// Unscaled discrete Fourier transform: lines 0 to n / 2 of a record of n samples.
pub(crate) fn transform(record: &[f64]) -> Vec<C64> {
    let plan = plan(record.len());
    let mut input = record.to_vec();
    let mut output = plan.make_output_vec();
    if plan.process(&mut input, &mut output).is_err() {
        unreachable!("the buffers are made for this plan");
    }
    output
}

/// Checks the requirements of all estimators: two records of equal length, finite, and a positive sample
/// time.
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
