//! The random-phase multisine.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::Lines;
use crate::error::{finite, not_negative, positive};
use crate::{ControlError, Stream};

/// Draws of the phases of which the one with the smallest crest factor is kept.
const PHASE_DRAWS: u64 = 8;

/// Points per period of the highest line at which a crest factor is judged; with four the peak is underrated by at most 8 % or so.
const POINTS_PER_CYCLE: usize = 4;

/// Points at most at which a crest factor is judged, so that a long period does not make the choice slow.
const MOST_POINTS: usize = 4096;

/// An edge of the band this close to a line, in lines, is meant to be that line.
const EDGE_SLACK: f64 = 1e-9;

/// Odd lines per group of which the sparse grid leaves one out.
const GROUP: u64 = 4;

/// `sum_n A cos(2 pi n t / P + phi_n)`, `A = rms sqrt(2 / N)` for N lines.
#[derive(Clone, Debug)]
pub(super) struct Multisine {
    period_s: f64,
    /// Line of the first coefficient.
    first: u64,
    /// Lines from one coefficient to the next.
    stride: u64,
    /// `A exp(i phi_n)` as real and imaginary part; zero for lines left out.
    coefficients: Arc<[[f64; 2]]>,
}

impl Multisine {
    pub(super) fn new(lines: Lines, band_hz: [f64; 2], period_s: f64, rms: f64, stream: &Stream) -> Result<Self, ControlError> {
        let period_s = positive("reference.period", period_s)?;
        let rms = finite("reference.rms", rms)?;
        let [low_hz, high_hz] = [not_negative("reference.band", band_hz[0])?, positive("reference.band", band_hz[1])?];
        let stride = if lines == Lines::All { 1 } else { 2 };
        let lowest = ((low_hz * period_s - EDGE_SLACK).ceil().max(1.0)) as u64;
        let first = if stride == 2 { lowest | 1 } else { lowest };
        let last = (high_hz * period_s + EDGE_SLACK).floor() as u64;
        if last < first {
            return Err(ControlError::NoLines { period_s, low_hz, high_hz });
        }
        let count = (last - first) / stride + 1;
        let kept: Vec<bool> = (0..count).map(|k| lines != Lines::OddSparse || !is_left_out(k, count, stream)).collect();
        let amplitude = rms * (2.0 / kept.iter().filter(|&&kept| kept).count() as f64).sqrt();

        let draw = |draw: u64| {
            let phase = |k: u64| TAU * stream.uniform_at(draw * count + k);
            let coefficients = kept.iter().zip(0..).map(|(&kept, k)| {
                let (sin, cos) = phase(k).sin_cos();
                if kept { [amplitude * cos, amplitude * sin] } else { [0.0, 0.0] }
            });
            Self { period_s, first, stride, coefficients: coefficients.collect() }
        };
        let points = (POINTS_PER_CYCLE * last as usize).min(MOST_POINTS);
        let candidates = (0..PHASE_DRAWS).map(draw).map(|candidate| (candidate.peak(points), candidate));
        let best = candidates.min_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, multisine)| multisine).ok_or(ControlError::NoLines { period_s, low_hz, high_hz })
    }

    pub(super) fn value(&self, t_s: f64) -> f64 {
        // The share of the period keeps the phase exact in long runs.
        self.at_share((t_s / self.period_s).rem_euclid(1.0))
    }

    /// Horner's rule in `w = exp(2 pi i stride share)`, then the first line's own phase.
    fn at_share(&self, share: f64) -> f64 {
        let turn = |lines: u64| (TAU * (lines as f64 * share).fract()).sin_cos();
        let (w_im, w_re) = turn(self.stride);
        let (re, im) = self
            .coefficients
            .iter()
            .rev()
            .fold((0.0, 0.0), |(re, im), [c_re, c_im]| (re * w_re - im * w_im + c_re, re * w_im + im * w_re + c_im));
        let (first_im, first_re) = turn(self.first);
        re * first_re - im * first_im
    }

    fn peak(&self, points: usize) -> f64 {
        (0..points).map(|i| self.at_share(i as f64 / points as f64).abs()).fold(0.0, f64::max)
    }
}

/// Whether odd line `k` of `count` is the one that its group leaves out. A last group that is not full keeps all its lines.
fn is_left_out(k: u64, count: u64, stream: &Stream) -> bool {
    let group = k / GROUP;
    let full = (group + 1) * GROUP <= count;
    // Counted from the far end, so that these draws are not those of the phases.
    full && k % GROUP == (stream.uniform_at(u64::MAX / 2 + group) * GROUP as f64) as u64
}
