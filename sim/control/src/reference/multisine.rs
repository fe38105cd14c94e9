//! The random-phase multisine.

use std::f64::consts::TAU;
use std::sync::Arc;

use feeler_lanes::{Lane, Pack};
use num_complex::Complex;

use super::keys::{BAND, PERIOD, RMS, key};
use super::spec::Lines;
use crate::error::{ControlError, finite, not_negative, positive};
use crate::noise::Stream;

/// Number of random draws of the phases; the one with the smallest crest factor is kept.
const PHASE_DRAWS: u64 = 8;

/// Smallest number of points per period of the highest line for a crest factor.
const POINTS_PER_CYCLE: u64 = 4;

/// Highest line: a bound on work, 200 s of a kilohertz. Phases for as many are chosen within seconds.
const HIGHEST_LINE: f64 = 2e5;

/// An edge of the band this close to a line, in lines, counts as that line.
const EDGE_SLACK: f64 = 1e-9;

/// Odd lines per group; the sparse grid omits one of them.
const GROUP: u64 = 4;

/// Lines that are summed side by side.
const WIDTH: usize = 8;

/// `sum_n A cos(2 pi n t / P + phi_n)`, `A = rms sqrt(2 / N)` for N lines.
#[derive(Clone, Debug)]
pub(super) struct Multisine {
    period_s: f64,
    /// Line of the first coefficient.
    first: u64,
    /// Lines from one coefficient to the next.
    stride: u64,
    /// `A exp(i phi_n)` as real and imaginary parts, eight lines to a pack; zero for omitted lines and after
    /// the last.
    coefficients: Arc<[[Pack<WIDTH>; 2]]>,
}

impl Multisine {
    pub(super) fn new(
        lines: Lines,
        band_hz: [f64; 2],
        period_s: f64,
        rms: f64,
        stream: &Stream,
    ) -> Result<Self, ControlError> {
        let period_s = positive(key(&PERIOD), period_s)?;
        let rms = finite(key(&RMS), rms)?;
        let [low_hz, high_hz] = [not_negative(key(&BAND), band_hz[0])?, positive(key(&BAND), band_hz[1])?];
        let highest = high_hz * period_s;
        if highest > HIGHEST_LINE {
            let why = "a multisine has 200 000 frequencies at most, one per cycle in its period";
            return Err(ControlError::TooLarge {
                key: key(&BAND),
                value: high_hz,
                bound: HIGHEST_LINE / period_s,
                why,
            });
        }
        let stride = if lines == Lines::All { 1 } else { 2 };
        let lowest = (low_hz * period_s - EDGE_SLACK).ceil().max(1.0) as u64;
        let first = if stride == 2 { lowest | 1 } else { lowest };
        let last = (highest + EDGE_SLACK).floor() as u64;
        if last < first {
            return Err(ControlError::NoLines { period_s, low_hz, high_hz });
        }
        let count = (last - first) / stride + 1;
        let kept: Vec<bool> =
            (0..count).map(|k| lines != Lines::OddSparse || !is_left_out(k, count, stream)).collect();
        let amplitude = rms * (2.0 / kept.iter().filter(|&&kept| kept).count() as f64).sqrt();

        let draws = (0..PHASE_DRAWS).map(|draw| {
            let line = |(&kept, k)| {
                let (sin, cos) = (TAU * stream.uniform_at(draw * count + k)).sin_cos();
                if kept { Complex::new(amplitude * cos, amplitude * sin) } else { Complex::default() }
            };
            kept.iter().zip(0..).map(line).collect::<Vec<_>>()
        });
        let mut peak = PeakMeter::new(first, stride, last);
        let best = draws.map(|draw| (peak.of(&draw), draw)).min_by(|a, b| a.0.total_cmp(&b.0));
        let chosen = best.map_or_else(Vec::new, |(_, draw)| draw);
        let packed = chosen.chunks(WIDTH).map(|chunk| {
            let part = |of: fn(&Complex<f64>) -> f64| Pack::from_fn(|i| chunk.get(i).map_or(0.0, of));
            [part(|c| c.re), part(|c| c.im)]
        });
        Ok(Self { period_s, first, stride, coefficients: packed.collect() })
    }

    /// Horner's rule in `w^8`, `w = exp(2 pi i stride t / P)`, on eight interleaved sums at once; these are
    /// then joined with their own phases.
    pub(super) fn value(&self, t_s: f64) -> f64 {
        // The share of the period keeps the phase exact in long runs.
        let share = (t_s / self.period_s).rem_euclid(1.0);
        let turn = |lines: u64| (TAU * (lines as f64 * share).fract()).sin_cos();
        let (sin, cos) = turn(self.stride * WIDTH as u64);
        let (w_re, w_im) = (Pack::splat(cos), Pack::splat(sin));
        let zero = Pack::<WIDTH>::zero();
        let (re, im) = self.coefficients.iter().rev().fold((zero, zero), |(re, im), &[c_re, c_im]| {
            (re * w_re - im * w_im + c_re, re * w_im + im * w_re + c_im)
        });
        (0..WIDTH)
            .map(|i| {
                let (sin, cos) = turn(self.first + self.stride * i as u64);
                re.lane(i) * cos - im.lane(i) * sin
            })
            .sum()
    }
}

/// Measures the peak of candidates on the same lines, at evenly spaced instants of one period.
struct PeakMeter {
    /// `exp(2 pi i k / n)` of the first half of n instants.
    turns: Vec<Complex<f64>>,
    sums: Vec<Complex<f64>>,
    first: u64,
    stride: u64,
}

impl PeakMeter {
    fn new(first: u64, stride: u64, last: u64) -> Self {
        let points = (POINTS_PER_CYCLE * last).next_power_of_two() as usize;
        let turns = (0..points / 2).map(|k| Complex::cis(TAU * k as f64 / points as f64)).collect();
        Self { turns, sums: vec![Complex::default(); points], first, stride }
    }

    /// The largest magnitude of the sum of `lines`.
    fn of(&mut self, lines: &[Complex<f64>]) -> f64 {
        self.sums.fill(Complex::default());
        let bins = self.sums.iter_mut().skip(self.first as usize).step_by(self.stride as usize);
        bins.zip(lines).for_each(|(bin, line)| *bin = *line);
        self.transform();
        self.sums.iter().fold(0.0, |peak: f64, sum| peak.max(sum.re.abs()))
    }

    /// `x[j] = sum_k x[k] exp(2 pi i j k / n)` in place, for n a power of two (Cooley and Tukey, Mathematics
    /// of Computation 19, 1965). A library with transforms of every length would be compiled into this crate,
    /// as most of its code.
    fn transform(&mut self) {
        let n = self.sums.len();
        for i in 0..n {
            let mirrored = i.reverse_bits() >> (usize::BITS - n.ilog2());
            if i < mirrored {
                self.sums.swap(i, mirrored);
            }
        }
        let mut half = 1;
        while half < n {
            for block in self.sums.chunks_exact_mut(2 * half) {
                let (low, high) = block.split_at_mut(half);
                let turns = self.turns.iter().step_by(n / (2 * half));
                for ((low, high), turn) in low.iter_mut().zip(high).zip(turns) {
                    let turned = *high * turn;
                    (*low, *high) = (*low + turned, *low - turned);
                }
            }
            half *= 2;
        }
    }
}

/// Whether odd line `k` of `count` is the one that its group omits. An incomplete last group keeps all its
/// lines.
fn is_left_out(k: u64, count: u64, stream: &Stream) -> bool {
    let group = k / GROUP;
    let full = (group + 1) * GROUP <= count;
    // Counted from the far end, so that these draws differ from those of the phases.
    full && k % GROUP == (stream.uniform_at(u64::MAX / 2 + group) * GROUP as f64) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest of the sums themselves, at the same instants; a few roundings of 20 lines each.
    #[test]
    fn truth_the_peak_is_that_of_the_sum_of_cosines() {
        for (first, stride, count) in [(1, 1, 1), (3, 2, 20), (7, 1, 100)] {
            let last = first + stride * (count - 1);
            let stream = Stream::new(5, "test");
            let lines: Vec<Complex<f64>> = (0..count)
                .map(|k| Complex::from_polar(1.0 + stream.uniform_at(k), TAU * stream.uniform_at(count + k)))
                .collect();
            let mut meter = PeakMeter::new(first, stride, last);
            let points = meter.sums.len() as u64;
            let at = |j: u64| {
                let turned = |(line, k): (&Complex<f64>, u64)| {
                    let turns = (j * (first + stride * k)) % points;
                    (line * Complex::cis(TAU * turns as f64 / points as f64)).re
                };
                lines.iter().zip(0..).map(turned).sum::<f64>()
            };
            let truth = (0..points).map(at).fold(0.0, |peak: f64, value| peak.max(value.abs()));
            let found = meter.of(&lines);
            assert!((found / truth - 1.0).abs() < 1e-13, "{count}: {found} {truth}");
        }
    }
}
