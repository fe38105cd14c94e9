//! Margins of a loop, as programs read them.

use std::f64::consts::TAU;

use feeler_lti::{LoopTransfer, Margins, SensitivityPeak};
use serde::Serialize;

use crate::error::AnalysisError;

/// Factors below this are zero up to rounding: no gain stabilises.
const NO_GAIN: f64 = 1e-9;
/// A response at this share of the peak's frequency counts as the response at rest. A peak that exceeds it by
/// less than [`FLAT`] is not a resonance.
const TOWARDS_REST: f64 = 1e-3;
const FLAT: f64 = 1e-6;

/// Margins of the sampled loop broken at its controller.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MarginReport {
    /// Factor by which the gain may rise; `None` if no rise destabilises or the loop is unstable.
    pub gain: Option<f64>,
    /// Frequency at which the loop oscillates with that gain, Hz; `None` without one.
    pub gain_hz: Option<f64>,
    /// Factor by which the gain of a stable loop may fall, or to which that of an unstable loop must fall.
    /// `None` if no fall destabilises the one or stabilises the other.
    pub gain_decrease: Option<f64>,
    /// Smallest phase margin; `None` if the loop is unstable.
    pub phase_deg: Option<f64>,
    /// Additional delay that the loop tolerates, s; `None` if the loop is unstable.
    pub delay_s: Option<f64>,
    /// Crossover with the smallest phase margin, Hz; `None` without a margin.
    pub crossover_hz: Option<f64>,
    /// Balanced disk margin, 0 to 2.
    pub disk: f64,
    /// Largest modulus of the sensitivity.
    pub sensitivity_peak: f64,
    /// Frequency of that peak, Hz.
    pub sensitivity_peak_hz: f64,
    /// Largest modulus of the complementary sensitivity.
    pub complementary_sensitivity_peak: f64,
    /// Frequency of that peak, Hz; zero if the modulus is largest at rest, so that nothing resonates.
    pub complementary_sensitivity_peak_hz: f64,
    /// Unstable poles of the closed loop by Nyquist's count: those of the open loop plus the clockwise
    /// encirclements of -1.
    pub unstable_poles: usize,
    /// Unstable poles of the open loop, from which the count starts.
    pub open_unstable_poles: usize,
    /// Clockwise encirclements of -1 by the open loop over all frequencies; negative if counterclockwise.
    pub encirclements: isize,
}

impl MarginReport {
    /// The margins of a loop.
    ///
    /// # Errors
    /// [`AnalysisError::Lti`].
    pub fn new<T: feeler_lti::TimeDomain>(open: &LoopTransfer<T>) -> Result<Self, AnalysisError> {
        let margins: Margins = open.margins()?;
        let unstable_poles = open.closed_loop_unstable_poles(1.0)?;
        let stable = unstable_poles == 0;
        let phase = margins.smallest_phase();
        let (sensitivity, complementary) = (margins.sensitivity, margins.complementary_sensitivity);
        Ok(Self {
            gain: margins.smallest_increase().filter(|_| stable).map(|m| m.factor),
            gain_hz: margins.smallest_increase().filter(|_| stable).map(|m| m.frequency_hz),
            gain_decrease: if stable {
                margins.smallest_decrease().map(|m| m.factor)
            } else {
                stabilising(open, &margins, unstable_poles)?
            },
            phase_deg: phase.filter(|_| stable).map(|p| p.margin_deg()),
            delay_s: margins.smallest_delay().filter(|_| stable).map(|p| p.delay_s),
            crossover_hz: phase.map(|p| p.frequency_hz),
            disk: margins.disk.alpha,
            sensitivity_peak: sensitivity.value,
            sensitivity_peak_hz: sensitivity.frequency_hz,
            complementary_sensitivity_peak: complementary.value,
            complementary_sensitivity_peak_hz: if is_at_rest(open, &complementary) {
                0.0
            } else {
                complementary.frequency_hz
            },
            unstable_poles,
            open_unstable_poles: open.unstable_poles(),
            encirclements: unstable_poles.cast_signed() - open.unstable_poles().cast_signed(),
        })
    }
}

/// The largest factor below one at which an unstable loop becomes stable.
fn stabilising<T: feeler_lti::TimeDomain>(
    open: &LoopTransfer<T>,
    margins: &Margins,
    unstable_poles: usize,
) -> Result<Option<f64>, AnalysisError> {
    let telling = |factor: &f64| (NO_GAIN..1.0).contains(factor);
    let mut factors: Vec<f64> = margins.gain.iter().map(|margin| margin.factor).filter(telling).collect();
    factors.sort_by(|a, b| b.total_cmp(a));
    // At each factor at most one pair becomes stable.
    for i in unstable_poles.saturating_sub(1) / 2..factors.len() {
        let below = 0.5 * (factors[i] + factors.get(i + 1).copied().unwrap_or(0.0));
        if open.closed_loop_unstable_poles(below)? == 0 {
            return Ok(Some(factors[i]));
        }
    }
    Ok(None)
}

/// Whether the modulus is largest at rest and only falls from there: then there is no peak.
fn is_at_rest<T: feeler_lti::TimeDomain>(open: &LoopTransfer<T>, peak: &SensitivityPeak) -> bool {
    let lower = open.at_frequency(TAU * peak.frequency_hz * TOWARDS_REST).map(|l| (l / (l + 1.0)).norm());
    peak.frequency_hz <= 0.0 || lower.is_ok_and(|lower| lower > peak.value * (1.0 - FLAT))
}
