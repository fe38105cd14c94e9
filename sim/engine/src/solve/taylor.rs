//! The flow of a linear mode as a Taylor polynomial in time, and the first zero of a guard along it.

use feeler_lanes::dispatch;
use feeler_plant::motion::modes::{AT_ZERO, AT_ZERO_S};

use crate::solve::flow::{BLOCK, Flow};

/// Terms of the longest polynomial.
const MOST_TERMS: usize = 31;
/// Remainder of a polynomial relative to the motion.
const REMAINDER: f64 = 1e-18;
/// Longest part of a span in the search for a zero, times the mode's norm. Each part is then below 0.4 rad of
/// the fastest oscillation.
const PART_REACH: f64 = 0.375;
/// Number of parts of the longest span that a [`Flow`] allows.
const MOST_PARTS: f64 = 8.0;

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
        self.coefficients.resize(stride * MOST_TERMS, 0.0);
        self.coefficients[..n].copy_from_slice(&xi[..n]);
        // Sizes of all terms so far at the end of the span, and the power of time there.
        self.sizes.clear();
        self.sizes.extend(xi[..n].iter().map(|x| x.abs()));
        let mut power = 1.0;
        // Bound of a term by the norm alone, and whether it has been negligible.
        let (mut bound, mut is_enough) = (1.0, false);
        for k in 1..MOST_TERMS {
            let (known, next) = self.coefficients.split_at_mut(k * stride);
            let next = &mut next[..stride];
            // Not fused: bodies of equal speed must cancel exactly, otherwise sticking bodies come loose.
            let last = &known[(k - 1) * stride..][..n];
            for (block, next) in next.chunks_exact_mut(BLOCK).enumerate() {
                let mut sums = [0.0; BLOCK];
                for (column, x) in flow.columns.chunks_exact(stride).zip(last) {
                    for (sum, a) in sums.iter_mut().zip(&column[block * BLOCK..][..BLOCK]) {
                        *sum += a * x;
                    }
                }
                next.copy_from_slice(&sums);
            }
            if k == 1 {
                for (i, c) in next[..n].iter_mut().enumerate() {
                    *c += flow.derivative_row(i)[n..].iter().zip(&xi[n..]).map(|(a, u)| a * u).sum::<f64>();
                }
            }
            power *= span_s;
            // The norm of a mode does not bound chains of integrations: a ramping force moves a position by
            // the third power of time. Their terms appear whatever the norm, so each is checked.
            let mut is_negligible = true;
            for (size, c) in self.sizes.iter_mut().zip(next) {
                *c /= k as f64;
                let term = (*c * power).abs();
                is_negligible &= term <= REMAINDER * *size;
                *size += term;
            }
            bound *= reach / k as f64;
            is_enough |= bound < REMAINDER;
            if is_enough && is_negligible {
                self.terms = k + 1;
                break;
            }
        }
    }

    /// Whether no state changes.
    pub(crate) fn is_constant(&self) -> bool {
        self.coefficients[self.stride..][..self.states].iter().all(|slope| *slope == 0.0)
    }

    /// Writes the states at `s` into the front of `xi`.
    pub(crate) fn evaluate(&self, s: f64, xi: &mut [f64]) {
        let n = self.states;
        xi[..n].copy_from_slice(&self.coefficients[(self.terms - 1) * self.stride..][..n]);
        for k in (0..self.terms - 1).rev() {
            for (x, c) in xi[..n].iter_mut().zip(&self.coefficients[k * self.stride..]) {
                *x = *x * s + c;
            }
        }
    }

    /// Whether a linear functional surely stays positive up to `span_s`, at most the span of the expansion.
    /// Then it starts above the sum of the magnitudes of all its terms, and above the trace of an event.
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
            Polynomial { c: [0.0; MOST_TERMS], terms: self.terms, size: 0.0, rate: self.rate };
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

/// A guard along the motion.
#[derive(Debug)]
pub(crate) struct Polynomial {
    c: [f64; MOST_TERMS],
    terms: usize,
    /// Sum of the magnitudes of the parts of the value at zero.
    size: f64,
    /// Norm of the mode, 1/s.
    rate: f64,
}

impl Polynomial {
    pub(crate) fn at(&self, s: f64) -> f64 {
        self.c[..self.terms].iter().rev().fold(0.0, |sum, c| sum * s + c)
    }

    fn slope(&self, s: f64) -> f64 {
        (1..self.terms).rev().fold(0.0, |sum, k| sum * s + k as f64 * self.c[k])
    }

    /// Value and slope at once: two chains of sums side by side take little longer than one.
    fn value_and_slope(&self, s: f64) -> (f64, f64) {
        let sums =
            |(value, slope): (f64, f64), k: usize| (value * s + self.c[k], slope * s + k as f64 * self.c[k]);
        let (value, slope) = (1..self.terms).rev().fold((0.0, 0.0), sums);
        (value * s + self.c[0], slope)
    }

    /// The first instant in `[0, span]` at which the value, positive before, is no longer positive.
    ///
    /// A value at zero that is the rounded trace of an event counts as positive if it grows. If it does not,
    /// it has already crossed. `slope_size` gives the sum of the magnitudes of the parts of its slope at
    /// zero. It is called if the sign of that slope may be rounding.
    pub(crate) fn first_crossing(&self, span: f64, slope_size: impl FnOnce() -> f64) -> Option<f64> {
        let start = self.c[0];
        let trace = AT_ZERO * self.size + AT_ZERO_S * self.c[1].abs();
        if start < -trace {
            return Some(0.0);
        }
        let mut left = 0.0;
        if start <= trace {
            left = self.leave_zero(span, slope_size())?;
            if left < 0.0 {
                return Some(0.0);
            }
        }
        if self.stays_positive(start, span) {
            return None;
        }
        let parts = self.parts(span);
        for part in 1..=parts as usize {
            let right = span * part as f64 / parts;
            if right <= left {
                continue;
            }
            if self.at(right) <= 0.0 {
                return Some(self.refine(left, right));
            }
            if let Some(low) = self.dip(left, right) {
                return Some(self.refine(left, low));
            }
            left = right;
        }
        None
    }

    /// The largest value in `[0, span]`, and its instant.
    pub(crate) fn largest(&self, span: f64) -> (f64, f64) {
        let mut best = (0.0, self.c[0]);
        let mut evaluate = |s: f64| {
            let value = self.at(s);
            if value > best.1 {
                best = (s, value);
            }
        };
        evaluate(span);
        let slope = self.derivative();
        let parts = self.parts(span);
        let mut left = 0.0;
        for part in 1..=parts as usize {
            let right = span * part as f64 / parts;
            // The value has a maximum where its slope changes from positive to negative. A slope that is
            // negative at both ends may have been positive in between.
            let rising = if slope.at(left) > 0.0 { Some(left) } else { slope.negative().dip(left, right) };
            if let Some(rising) = rising {
                let falling = if slope.at(right) <= 0.0 { Some(right) } else { slope.dip(rising, right) };
                if let Some(falling) = falling {
                    evaluate(slope.refine(rising, falling));
                }
            }
            left = right;
        }
        best
    }

    /// Number of parts of a span in each of which the value has at most one minimum.
    fn parts(&self, span: f64) -> f64 {
        (self.rate * span / PART_REACH).ceil().clamp(1.0, MOST_PARTS)
    }

    fn derivative(&self) -> Self {
        let mut c = [0.0; MOST_TERMS];
        for k in 1..self.terms {
            c[k - 1] = k as f64 * self.c[k];
        }
        Self { c, terms: (self.terms - 1).max(1), ..*self }
    }

    fn negative(&self) -> Self {
        Self { c: self.c.map(|c| -c), ..*self }
    }

    /// Whether the value is so far from zero that no sum of its terms reaches it: the most frequent case,
    /// decided without a search.
    fn stays_positive(&self, start: f64, span: f64) -> bool {
        self.swing(span) < start
    }

    /// Whether the sum of its terms may exceed a level.
    pub(crate) fn may_exceed(&self, level: f64, span: f64) -> bool {
        self.c[0] + self.swing(span) > level
    }

    /// Sum of the magnitudes of all terms but the first at the end of a span: an upper bound on the change of
    /// the value.
    fn swing(&self, span: f64) -> f64 {
        self.c[1..self.terms].iter().rev().fold(0.0, |sum, c| (sum + c.abs()) * span)
    }

    /// For a value of zero at the start: the first evaluated instant with a positive value. A negative number
    /// if the value falls at once, `None` if it stays at zero.
    fn leave_zero(&self, span: f64, slope_size: f64) -> Option<f64> {
        // Just after the start the sign is that of the lowest power of time whose term matters at the end of
        // the span.
        let mut power = 1.0;
        for (k, c) in self.c[..self.terms].iter().enumerate().skip(1) {
            power *= span;
            let term = c * power;
            // A guide breaks loose at a balance of forces, where only their rounding remains.
            let size = if k == 1 { self.size + slope_size * span } else { self.size };
            if term.abs() > AT_ZERO * size {
                if term < 0.0 {
                    return Some(-1.0);
                }
                let mut s = span / MOST_PARTS;
                for _ in 0..200 {
                    if self.at(s) > 0.0 {
                        return Some(s);
                    }
                    s *= 0.5;
                }
                return Some(-1.0);
            }
        }
        None
    }

    /// An instant between two positive values at which the value is negative, if its single minimum is
    /// negative.
    fn dip(&self, left: f64, right: f64) -> Option<f64> {
        let (mut a, mut b) = (left, right);
        if self.slope(a) >= 0.0 || self.slope(b) <= 0.0 {
            return None;
        }
        for _ in 0..60 {
            let middle = 0.5 * (a + b);
            if self.at(middle) <= 0.0 {
                return Some(middle);
            }
            // Both tangents lie below a convex function: if they meet above zero there is no dip.
            let ((fa, da), (fb, db)) = (self.value_and_slope(a), self.value_and_slope(b));
            let lowest = (db * fa - da * fb + da * db * (b - a)) / (db - da);
            if lowest > 0.0 {
                return None;
            }
            if self.slope(middle) < 0.0 { a = middle } else { b = middle }
        }
        None
    }

    /// The zero between `a` (positive) and `b` (not positive), to rounding: Newton from the secant's zero,
    /// kept inside the bracket.
    fn refine(&self, a: f64, b: f64) -> f64 {
        let (mut a, mut b) = (a, b);
        let (at_a, at_b) = (self.at(a), self.at(b));
        let secant = a + (b - a) * at_a / (at_a - at_b);
        let mut s = if secant > a && secant < b { secant } else { 0.5 * (a + b) };
        for _ in 0..100 {
            let (value, slope) = self.value_and_slope(s);
            if value > 0.0 {
                a = s;
            } else {
                b = s;
            }
            let newton = s - value / slope;
            let next = if newton > a && newton < b { newton } else { 0.5 * (a + b) };
            if (next - s).abs() <= f64::EPSILON * b || b - a <= f64::EPSILON * b {
                return next;
            }
            s = next;
        }
        s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polynomial(c: &[f64]) -> Polynomial {
        let mut all = [0.0; MOST_TERMS];
        all[..c.len()].copy_from_slice(c);
        Polynomial { c: all, terms: c.len(), size: 1.0, rate: 3.0 }
    }

    #[test]
    fn truth_first_zero_of_a_quadratic() {
        // (s - 0.3)(s - 0.7) is positive until 0.3.
        let root = polynomial(&[0.21, -1.0, 1.0]).first_crossing(1.0, || 0.0).unwrap();
        assert!((root - 0.3).abs() < 4.0 * f64::EPSILON);
    }

    /// Forces of 100 N balance to 1e-14 N where a guide breaks loose, and the sign of that remainder is
    /// arbitrary. The growing force decides.
    #[test]
    fn regress_a_slope_that_is_rounding_does_not_decide() {
        let at_rest = |slope: f64, bend: f64| Polynomial { size: 0.0, ..polynomial(&[0.0, slope, bend]) };
        assert_eq!(at_rest(-1e-14, 5.0).first_crossing(1e-3, || 100.0), None);
        assert_eq!(at_rest(1e-14, -5.0).first_crossing(1e-3, || 100.0), Some(0.0));
        assert_eq!(at_rest(-1e-3, 5.0).first_crossing(1e-3, || 100.0), Some(0.0));
    }

    /// Maxima of a sine and of `s - s^3`, and one between two falling ends.
    #[test]
    fn truth_the_largest_value_is_that_of_the_peak() {
        let sine: Vec<f64> = (0..30)
            .map(|k| (1..=k).fold(1.0, |f, j| f / f64::from(j)) * [0.0, 1.0, 0.0, -1.0][k as usize % 4])
            .collect();
        let (s, value) = polynomial(&sine).largest(2.0);
        // At a peak the value gives the instant only to the root of rounding; its slope gives it to rounding.
        assert!(
            (s - std::f64::consts::FRAC_PI_2).abs() < 1e-14 && (value - 1.0).abs() < 2.0 * f64::EPSILON,
            "{s} {value}"
        );
        let (s, value) = polynomial(&[0.0, 1.0, 0.0, -1.0]).largest(1.0);
        assert!(
            (s - 3_f64.recip().sqrt()).abs() < 1e-15 && (value - 2.0 / 27_f64.sqrt()).abs() < 1e-15,
            "{s} {value}"
        );
        // Slope -(s - 0.2)(s - 0.3): falls at both ends of the first part, and rises in between by 0.1^3 / 6.
        let (s, value) = polynomial(&[0.0, -0.06, 0.25, -1.0 / 3.0]).largest(0.375);
        assert!(s == 0.0 && value == 0.0, "{s} {value}");
        let (s, value) = polynomial(&[0.0, 0.0, -0.02, 0.5, -1.0]).largest(0.375);
        assert!((s - (1.5 + (2.25_f64 - 0.64).sqrt()) / 8.0).abs() < 1e-14 && value > 0.0, "{s} {value}");
        assert_eq!(polynomial(&[3.0, -1.0]).largest(2.0), (0.0, 3.0));
        assert_eq!(polynomial(&[3.0, 1.0]).largest(2.0), (2.0, 5.0));
    }

    #[test]
    fn truth_dip_between_looks_is_seen() {
        // Negative only between 0.06 - 1e-3 and 0.06 + 1e-3, inside the first part.
        let root = polynomial(&[0.06 * 0.06 - 1e-6, -0.12, 1.0]).first_crossing(1.0, || 0.0).unwrap();
        assert!((root - 0.059).abs() < 1e-14);
    }

    #[test]
    fn truth_a_guard_that_starts_at_zero_and_grows_has_not_crossed() {
        assert_eq!(polynomial(&[-1e-17, 1.0]).first_crossing(1.0, || 0.0), None);
        assert_eq!(polynomial(&[1e-17, -1.0]).first_crossing(1.0, || 0.0), Some(0.0));
        // It grows, then falls: the second zero is the crossing.
        let root = polynomial(&[0.0, 1.0, -2.0]).first_crossing(1.0, || 0.0).unwrap();
        assert!((root - 0.5).abs() < 4.0 * f64::EPSILON);
    }
}
