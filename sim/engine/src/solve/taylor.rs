//! The flow of a linear mode as a Taylor polynomial in time.

use feeler_lanes::dispatch;
use feeler_plant::motion::modes::{AT_ZERO, AT_ZERO_S};

use crate::solve::flow::{BLOCK, Flow};
use crate::solve::polynomial::{MOST_TERMS, PADDED_TERMS, Polynomial, Powers, STRANDS};

/// Remainder of a polynomial relative to the motion.
const REMAINDER: f64 = 1e-18;
/// `x(s) = sum_k c_k s^k` from a state and held inputs.
#[derive(Debug, Default)]
pub(crate) struct Series {
    /// Coefficients of the states, power by power, padded.
    coefficients: Vec<f64>,
    stride: usize,
    terms: usize,
    states: usize,
    /// Norm of the mode, 1/s.
    rate: f64,
    /// Scratch of an expansion.
    sizes: Vec<f64>,
}

impl Series {
    /// Expands the motion from `xi` (states, inputs, 1) for spans up to `span_s`.
    pub(crate) fn expand(&mut self, flow: &Flow, xi: &[f64], span_s: f64) {
        dispatch(
            #[inline(always)]
            || self.expand_by_blocks(flow, xi, span_s),
        );
    }

    #[inline(always)]
    fn expand_by_blocks(&mut self, flow: &Flow, xi: &[f64], span_s: f64) {
        let (n, stride) = (flow.states, flow.states.next_multiple_of(BLOCK));
        self.states = n;
        self.stride = stride;
        self.rate = flow.rate;
        let reach = flow.rate * span_s;
        self.terms = MOST_TERMS;
        self.coefficients.resize(stride * PADDED_TERMS, 0.0);
        self.coefficients[..n].copy_from_slice(&xi[..n]);
        self.coefficients[n..stride].fill(0.0);
        // Sizes of all terms so far at the end of the span, and the power of time there.
        self.sizes.clear();
        self.sizes.extend(self.coefficients[..stride].iter().map(|x| x.abs()));
        let mut power = 1.0;
        // Bound of a term by the norm alone, and whether it has been negligible.
        let (mut bound, mut is_enough) = (1.0, false);
        for k in 1..MOST_TERMS {
            let (known, next) = self.coefficients.split_at_mut(k * stride);
            let last = &known[(k - 1) * stride..][..n];
            let share = 1.0 / k as f64;
            power *= span_s;
            // The norm of a mode does not bound chains of integrations: a ramping force moves a position by
            // the third power of time. Their terms appear whatever the norm, so each is checked.
            let mut is_negligible = true;
            let next = next.chunks_exact_mut(BLOCK).zip(self.sizes.chunks_exact_mut(BLOCK));
            for (block, (next, sizes)) in next.enumerate() {
                // Not fused: bodies of equal speed must cancel exactly, otherwise sticking bodies come loose.
                let mut sums = [0.0; BLOCK];
                for (column, x) in flow.columns.chunks_exact(stride).zip(last) {
                    for (sum, a) in sums.iter_mut().zip(&column[block * BLOCK..][..BLOCK]) {
                        *sum += a * x;
                    }
                }
                if k == 1 {
                    for (i, sum) in (block * BLOCK..n).zip(&mut sums) {
                        *sum +=
                            flow.derivative_row(i)[n..].iter().zip(&xi[n..]).map(|(a, u)| a * u).sum::<f64>();
                    }
                }
                let terms = sums.map(|sum| sum * share);
                next.copy_from_slice(&terms);
                for (size, c) in sizes.iter_mut().zip(terms) {
                    let term = (c * power).abs();
                    is_negligible &= term <= REMAINDER * *size;
                    *size += term;
                }
            }
            bound *= reach / k as f64;
            is_enough |= bound < REMAINDER;
            if is_enough && is_negligible {
                self.terms = k + 1;
                break;
            }
        }
        let padded = self.terms.next_multiple_of(STRANDS);
        self.coefficients[self.terms * stride..padded * stride].fill(0.0);
    }

    /// Whether no state changes.
    pub(crate) fn is_constant(&self) -> bool {
        self.coefficients[self.stride..][..self.states].iter().all(|slope| *slope == 0.0)
    }

    /// Writes the states at `s` into the front of `xi`.
    pub(crate) fn evaluate(&self, s: f64, xi: &mut [f64]) {
        dispatch(
            #[inline(always)]
            || self.evaluate_by_blocks(s, xi),
        );
    }

    #[inline(always)]
    fn evaluate_by_blocks(&self, s: f64, xi: &mut [f64]) {
        let powers = Powers::of(s);
        let coefficients = &self.coefficients[..self.terms.next_multiple_of(STRANDS) * self.stride];
        for (block, out) in xi[..self.states].chunks_mut(BLOCK).enumerate() {
            let mut sums = [[0.0_f64; BLOCK]; STRANDS];
            for terms in coefficients.rchunks_exact(STRANDS * self.stride) {
                for (sums, term) in sums.iter_mut().zip(terms.chunks_exact(self.stride)) {
                    for (sum, c) in sums.iter_mut().zip(&term[block * BLOCK..][..BLOCK]) {
                        *sum = sum.mul_add(powers.fourth, *c);
                    }
                }
            }
            let at = |i: usize| powers.join(sums.map(|sums| sums[i]));
            let whole: [f64; BLOCK] = std::array::from_fn(at);
            out.copy_from_slice(&whole[..out.len()]);
        }
    }

    /// Whether a linear functional surely stays positive up to `span_s`, at most the span of the expansion.
    /// It does if it starts above the sum of the magnitudes of all its terms, and above the trace of an
    /// event.
    pub(crate) fn stays_positive(&self, row: &[f64], xi: &[f64], width: usize, span_s: f64) -> bool {
        let n = self.states;
        let (mut start, mut size, mut swing) = (0.0, 0.0, 0.0);
        for (j, (r, x)) in row[..width].iter().zip(&xi[..width]).enumerate() {
            start += r * x;
            size += (r * x).abs();
            if j < n {
                swing += r.abs() * (self.sizes[j] - x.abs());
            }
        }
        start > (1.0 + AT_ZERO + AT_ZERO_S / span_s) * swing + 2.0 * AT_ZERO * size
    }

    /// The polynomial of a linear functional of states and held inputs.
    pub(crate) fn functional(&self, row: &[f64], xi: &[f64], width: usize) -> Polynomial {
        let n = self.states;
        let mut polynomial =
            Polynomial { c: [0.0; PADDED_TERMS], terms: self.terms, size: 0.0, rate: self.rate };
        // Most rows hold one or two states.
        for (j, r) in row[..n].iter().enumerate().filter(|(_, r)| **r != 0.0) {
            for (c, of_power) in polynomial
                .c
                .iter_mut()
                .zip(self.coefficients[..self.terms * self.stride].chunks_exact(self.stride))
            {
                *c += r * of_power[j];
            }
        }
        for (r, x) in row[..width].iter().zip(&xi[..width]) {
            polynomial.size += (r * x).abs();
        }
        polynomial.c[0] += row[n..width].iter().zip(&xi[n..width]).map(|(r, u)| r * u).sum::<f64>();
        polynomial
    }
}
