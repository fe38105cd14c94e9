//! Sample instants of a controller.

use crate::error::ControlError;
use crate::noise::Stream;
use crate::spec::ControllerSpec;

/// Largest jitter as a share of the period: below one half, so that samples keep their order.
const LARGEST_JITTER_IN_PERIODS: f64 = 0.49;

/// The sample instants of one controller: sample `k` is at `offset + k period` plus a normal draw with the
/// standard deviation `jitter`.
///
/// A draw is limited to 0.49 of the period, so instants stay in order; no instant is before zero.
#[derive(Clone, Debug)]
pub struct SampleClock {
    offset_s: f64,
    period_s: f64,
    jitter_s: f64,
    stream: Stream,
}

impl SampleClock {
    /// The clock of the controller `name` in a run with `seed`.
    ///
    /// # Errors
    /// Those of [`ControllerSpec::check`].
    pub fn new(spec: &ControllerSpec, seed: u64, name: &str) -> Result<Self, ControlError> {
        spec.check()?;
        let stream = Stream::new(seed, &format!("{name}/jitter"));
        Ok(Self { offset_s: spec.offset_s, period_s: spec.period_s, jitter_s: spec.jitter_s, stream })
    }

    /// The instant of sample `k`, s. The nominal time is computed from `k`, so it does not drift.
    #[inline]
    pub fn sample_time_s(&self, k: u64) -> f64 {
        let nominal_s = self.offset_s + k as f64 * self.period_s;
        if self.jitter_s > 0.0 {
            let bound_s = LARGEST_JITTER_IN_PERIODS * self.period_s;
            (nominal_s + (self.jitter_s * self.stream.normal_at(k)).clamp(-bound_s, bound_s)).max(0.0)
        } else {
            nominal_s
        }
    }
}
