//! Distance of a loop from instability: gain, phase, delay and disk margins, sensitivity peaks.
//!
//! Sources: Astrom and Murray, Feedback Systems, chapter 10; Seiler, Packard and Gahinet, IEEE Control
//! Systems Magazine 40 (2020), for the disk margin.

use std::f64::consts::TAU;

use crate::domain::{C64, TimeDomain};
use crate::error::LtiError;
use crate::loop_transfer::{LoopPoint, LoopTransfer};
use crate::search::{bisect, maximum};

/// Crossings are bisected to this relative width of the frequency.
const CROSSING: f64 = 1e-15;
/// An end of the frequency range counts as real if its imaginary part is below this share.
const REAL: f64 = 1e-9;

/// A frequency at which the loop is real and negative: multiplied by `factor` it would pass through -1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GainMargin {
    /// The factor: above 1 the possible rise of the gain, below 1 the possible fall.
    pub factor: f64,
    pub frequency_hz: f64,
}

/// A frequency at which the loop has modulus 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseMargin {
    /// Phase above -180 degrees, in (-pi, pi].
    pub margin_rad: f64,
    pub frequency_hz: f64,
    /// Additional delay (s) that would move the loop to -1 at this frequency.
    pub delay_s: f64,
}

impl PhaseMargin {
    /// The margin in degrees.
    pub fn margin_deg(&self) -> f64 {
        self.margin_rad.to_degrees()
    }
}

/// Largest value of a sensitivity function, and its frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensitivityPeak {
    pub value: f64,
    pub frequency_hz: f64,
}

/// Balanced disk margin: gain and phase may vary together within it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiskMargin {
    /// Size alpha of the disk, 1 / max |S - 1/2|, in [0, 2].
    pub alpha: f64,
    /// The frequency at which it is smallest, Hz.
    pub frequency_hz: f64,
}

/// The margins of a loop. They measure robustness only if the closed loop is stable.
#[derive(Debug, Clone, PartialEq)]
pub struct Margins {
    /// Whether the closed loop is stable, by Nyquist's count.
    pub closed_loop_stable: bool,
    /// Every crossing of the negative real axis, by rising frequency.
    pub gain: Vec<GainMargin>,
    /// Every crossing of the unit circle, by rising frequency.
    pub phase: Vec<PhaseMargin>,
    /// Largest |S| = |1 / (1 + L)|; 1 / Ms is the smallest distance from -1.
    pub sensitivity: SensitivityPeak,
    /// Largest |T| = |L / (1 + L)|.
    pub complementary_sensitivity: SensitivityPeak,
    pub disk: DiskMargin,
}

impl Margins {
    /// The smallest rise of gain that reaches -1; `None` if there is none.
    pub fn smallest_increase(&self) -> Option<GainMargin> {
        self.gain.iter().copied().filter(|m| m.factor > 1.0).min_by(|a, b| a.factor.total_cmp(&b.factor))
    }

    /// The smallest fall of gain that reaches -1; `None` if there is none.
    pub fn smallest_decrease(&self) -> Option<GainMargin> {
        self.gain.iter().copied().filter(|m| m.factor < 1.0).max_by(|a, b| a.factor.total_cmp(&b.factor))
    }

    /// The crossing of the unit circle nearest to -1.
    pub fn smallest_phase(&self) -> Option<PhaseMargin> {
        self.phase.iter().copied().min_by(|a, b| a.margin_rad.abs().total_cmp(&b.margin_rad.abs()))
    }

    /// The crossing of the unit circle that reaches -1 with the least additional delay.
    pub fn smallest_delay(&self) -> Option<PhaseMargin> {
        self.phase.iter().copied().min_by(|a, b| a.delay_s.total_cmp(&b.delay_s))
    }
}

impl<T: TimeDomain> LoopTransfer<T> {
    /// Margins, peaks and crossings of the loop.
    ///
    /// # Errors
    /// [`LtiError::AtPole`].
    ///
    /// # Example
    /// ```
    /// use feeler_lti::{LoopTransfer, StateSpace};
    /// use nalgebra::dmatrix;
    /// // 10 / s with a delay of 50 ms: phase margin pi/2 - 0.5 at 10 rad/s.
    /// let integrator = StateSpace::new(dmatrix![0.0], dmatrix![10.0], dmatrix![1.0], dmatrix![0.0])?;
    /// let margins = LoopTransfer::continuous(&integrator, 0.05)?.margins()?;
    /// let phase = margins.smallest_phase().expect("it crosses");
    /// assert!((phase.margin_rad - (std::f64::consts::FRAC_PI_2 - 0.5)).abs() < 1e-12);
    /// assert!(margins.closed_loop_stable);
    /// # Ok::<(), feeler_lti::LtiError>(())
    /// ```
    pub fn margins(&self) -> Result<Margins, LtiError> {
        let points = self.sampled(1.0)?;
        let closed_loop_stable = self.count_from(&points) == 0;
        // Arcs about poles on the boundary are not frequencies.
        let on_axis: Vec<LoopPoint> = points.into_iter().filter(|p| p.s.re.abs() <= 0.0).collect();
        let mut gain = Vec::new();
        let mut phase = Vec::new();
        for end in [on_axis.first(), on_axis.last()].into_iter().flatten() {
            let is_end_of_band = end.s.im.abs() <= 0.0 || end.s.im >= self.domain().nyquist_rad_per_s();
            if is_end_of_band && end.value.im.abs() <= REAL * end.value.norm() && end.value.re < 0.0 {
                gain.push(GainMargin { factor: -1.0 / end.value.re, frequency_hz: end.s.im / TAU });
            }
        }
        for pair in on_axis.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            if a.s.im >= b.s.im {
                continue;
            }
            if (a.value.im > 0.0) != (b.value.im > 0.0)
                && a.value.im.abs() > REAL * a.value.norm()
                && b.value.im.abs() > REAL * b.value.norm()
            {
                let w = bisect(a.s.im, b.s.im, CROSSING, |w| Ok(self.at_frequency(w)?.im))?;
                let value = self.at_frequency(w)?;
                if value.re < 0.0 {
                    gain.push(GainMargin { factor: -1.0 / value.re, frequency_hz: w / TAU });
                }
            }
            if (a.value.norm() > 1.0) != (b.value.norm() > 1.0) {
                let w = bisect(a.s.im, b.s.im, CROSSING, |w| Ok(self.at_frequency(w)?.norm() - 1.0))?;
                let margin_rad = (-self.at_frequency(w)?).arg();
                let lag = if margin_rad >= 0.0 { margin_rad } else { margin_rad + TAU };
                phase.push(PhaseMargin { margin_rad, frequency_hz: w / TAU, delay_s: lag / w });
            }
        }
        gain.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        let one = C64::new(1.0, 0.0);
        let disk = self.peak(&on_axis, |l| 0.5 * ((one - l) / (one + l)).norm())?;
        Ok(Margins {
            closed_loop_stable,
            gain,
            phase,
            sensitivity: self.peak(&on_axis, |l| (one + l).inv().norm())?,
            complementary_sensitivity: self.peak(&on_axis, |l| (l / (one + l)).norm())?,
            disk: DiskMargin { alpha: 1.0 / disk.value, frequency_hz: disk.frequency_hz },
        })
    }

    /// Largest value of a function of the loop, refined between the neighbours of its largest sample.
    fn peak(&self, points: &[LoopPoint], f: impl Fn(C64) -> f64) -> Result<SensitivityPeak, LtiError> {
        let values: Vec<f64> = points.iter().map(|p| f(p.value)).collect();
        let best = (0..values.len()).max_by(|&i, &j| values[i].total_cmp(&values[j])).unwrap_or(0);
        let (left, right) =
            (points[best.saturating_sub(1)].s.im, points[(best + 1).min(points.len() - 1)].s.im);
        let (w, value) = maximum(left, right, |w| Ok::<_, LtiError>(f(self.at_frequency(w)?)))?;
        // A peak at the end of the band, or at a jump over a pole, is not between samples.
        let (w, value) = if value >= values[best] { (w, value) } else { (points[best].s.im, values[best]) };
        Ok(SensitivityPeak { value, frequency_hz: w / TAU })
    }
}

/// An interval of gains with which a loop is stable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoopGainInterval {
    /// Lower end; 0 if the interval begins there.
    pub lower: f64,
    pub upper: f64,
    /// Frequency of the motion at the lower end, Hz.
    pub lower_frequency_hz: f64,
    /// Frequency of the motion at the upper end, Hz.
    pub upper_frequency_hz: f64,
}

impl<T: TimeDomain> LoopTransfer<T> {
    /// Every interval of stable gains in (0, `upper`], with exact delays. Candidates are the gains that move
    /// a real, negative value of the response to -1; Nyquist's count decides between them. An end at `upper`
    /// is the end of the search.
    ///
    /// # Errors
    /// [`LtiError::OutOfRange`] unless `upper` is positive and finite; [`LtiError::AtPole`].
    pub fn stable_gains_up_to(&self, upper: f64) -> Result<Vec<LoopGainInterval>, LtiError> {
        crate::error::require_positive("largest gain", upper)?;
        // The response scaled by the largest gain covers all frequencies that can matter.
        let points = self.sampled(upper)?;
        let mut edges = vec![(0.0, 0.0)];
        let nyquist = self.domain().nyquist_rad_per_s();
        for pair in points.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            if a.s.re.abs() <= 0.0
                && b.s.re.abs() <= 0.0
                && a.s.im < b.s.im
                && (a.value.im > 0.0) != (b.value.im > 0.0)
            {
                let w = bisect(a.s.im, b.s.im, CROSSING, |w| Ok(self.at_frequency(w)?.im))?;
                edges.push((-1.0 / self.at_frequency(w)?.re, w));
            }
        }
        for end in [points.first(), points.last()].into_iter().flatten() {
            if end.s.re.abs() <= 0.0 && (end.s.im.abs() <= 0.0 || end.s.im >= nyquist) {
                edges.push((-1.0 / self.at_frequency(end.s.im)?.re, end.s.im));
            }
        }
        edges.retain(|(gain, _)| *gain >= 0.0 && *gain < upper);
        edges.push((upper, 0.0));
        edges.sort_by(|a, b| a.0.total_cmp(&b.0));
        edges.dedup_by(|a, b| (a.0 - b.0).abs() <= 1e-9 * b.0);
        let mut intervals: Vec<LoopGainInterval> = Vec::new();
        for pair in edges.windows(2) {
            let ((lower, w_lower), (upper, w_upper)) = (pair[0], pair[1]);
            let inside = if lower > 0.0 { (lower * upper).sqrt() } else { 0.5 * upper };
            if self.closed_loop_unstable_poles(inside)? > 0 {
                continue;
            }
            match intervals.last_mut() {
                // A real value without a change of stability is not an edge.
                Some(last) if last.upper >= lower => {
                    (last.upper, last.upper_frequency_hz) = (upper, w_upper / TAU);
                }
                _ => {
                    intervals.push(LoopGainInterval {
                        lower,
                        upper,
                        lower_frequency_hz: w_lower / TAU,
                        upper_frequency_hz: w_upper / TAU,
                    });
                }
            }
        }
        Ok(intervals)
    }
}
