//! A guard along the motion of a linear mode as a polynomial in time: its first zero and its largest value.

use feeler_plant::motion::modes::{AT_ZERO, AT_ZERO_S};

/// Terms of the longest polynomial.
pub(super) const MOST_TERMS: usize = 31;
/// Sums of a polynomial that run side by side, each over every fourth term: a single chain of thirty sums
/// would wait for each of them.
pub(super) const STRANDS: usize = 4;
/// Terms of a polynomial with those that fill up its strands, which are zero.
pub(super) const PADDED_TERMS: usize = MOST_TERMS.next_multiple_of(STRANDS);
/// Longest part of a span in the search for a zero, times the mode's norm. Each part is then below 0.4 rad of
/// the fastest oscillation.
const PART_REACH: f64 = 0.375;
/// Number of parts of the longest span that a mode allows.
const MOST_PARTS: f64 = 8.0;

/// Powers of an instant, which join the strands of a polynomial.
#[derive(Clone, Copy)]
pub(super) struct Powers {
    first: f64,
    second: f64,
    pub(super) fourth: f64,
}

impl Powers {
    #[inline(always)]
    pub(super) fn of(s: f64) -> Self {
        let second = s * s;
        Self { first: s, second, fourth: second * second }
    }

    /// `a + b s + c s^2 + d s^3`.
    #[inline(always)]
    pub(super) fn join(self, [a, b, c, d]: [f64; STRANDS]) -> f64 {
        (a + b * self.first) + (c + d * self.first) * self.second
    }
}

/// A guard along the motion.
#[derive(Debug)]
pub(crate) struct Polynomial {
    /// Coefficients; those beyond the terms are zero.
    pub(super) c: [f64; PADDED_TERMS],
    pub(super) terms: usize,
    /// Sum of the magnitudes of the parts of the value at zero.
    pub(super) size: f64,
    /// Norm of the mode, 1/s.
    pub(super) rate: f64,
}

impl Polynomial {
    pub(crate) fn at(&self, s: f64) -> f64 {
        let powers = Powers::of(s);
        let mut sums = [0.0; STRANDS];
        for terms in self.strands().iter().rev() {
            for (sum, c) in sums.iter_mut().zip(terms) {
                *sum = *sum * powers.fourth + c;
            }
        }
        powers.join(sums)
    }

    fn strands(&self) -> &[[f64; STRANDS]] {
        let (strands, _) = self.c.as_chunks();
        &strands[..self.terms.div_ceil(STRANDS)]
    }

    fn value_and_slope(&self, s: f64) -> (f64, f64) {
        let powers = Powers::of(s);
        let (mut values, mut slopes) = ([0.0; STRANDS], [0.0; STRANDS]);
        let (first, others) = self.c[..].as_chunks::<STRANDS>().0.split_at(1);
        let count = self.terms.div_ceil(STRANDS) - 1;
        for (i, terms) in others[..count].iter().enumerate().rev() {
            for (j, c) in terms.iter().enumerate() {
                values[j] = values[j] * powers.fourth + c;
                slopes[j] = slopes[j] * powers.fourth + (STRANDS * (i + 1) + j) as f64 * c;
            }
        }
        // The term of power zero has no slope, so its strand begins with the third power.
        for (j, c) in first[0].iter().enumerate() {
            values[j] = values[j] * powers.fourth + c;
            if j > 0 {
                slopes[j] = slopes[j] * powers.fourth + j as f64 * c;
            }
        }
        let [third, zeroth, first, second] = slopes;
        (powers.join(values), powers.join([zeroth, first, second, third]))
    }

    /// The first instant in `[0, span]` at which the value, positive before, is no longer positive.
    ///
    /// A value at zero that is the rounded trace of an event counts as positive if it grows. Otherwise it has
    /// already crossed. `slope_size` gives the sum of the magnitudes of the parts of its slope at zero. It is
    /// called only if the sign of that slope may be rounding.
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
        let mut c = [0.0; PADDED_TERMS];
        for k in 1..self.terms {
            c[k - 1] = k as f64 * self.c[k];
        }
        Self { c, terms: (self.terms - 1).max(1), ..*self }
    }

    fn negative(&self) -> Self {
        Self { c: self.c.map(|c| -c), ..*self }
    }

    /// Whether the value is so far from zero that no sum of its terms reaches it. This is the most frequent
    /// case, decided without a search.
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
        let mut c = self.c.map(f64::abs);
        c[0] = 0.0;
        Self { c, ..*self }.at(span)
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
        let of = |s: f64| (s, self.value_and_slope(s));
        let (mut a, mut b) = (of(left), of(right));
        let ((_, (_, falls)), (_, (_, rises))) = (a, b);
        if falls >= 0.0 || rises <= 0.0 {
            return None;
        }
        for _ in 0..60 {
            // Both tangents lie below a convex function: if they meet above zero there is no dip.
            let ((from, (fa, da)), (to, (fb, db))) = (a, b);
            let lowest = (db * fa - da * fb + da * db * (to - from)) / (db - da);
            if lowest > 0.0 {
                return None;
            }
            let middle = of(0.5 * (from + to));
            let (s, (value, slope)) = middle;
            if value <= 0.0 {
                return Some(s);
            }
            if slope < 0.0 { a = middle } else { b = middle }
        }
        None
    }

    /// The zero between `a` (positive) and `b` (not positive), to machine precision: Newton from the secant's
    /// zero, kept inside the bracket.
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
        let mut all = [0.0; PADDED_TERMS];
        all[..c.len()].copy_from_slice(c);
        Polynomial { c: all, terms: c.len(), size: 1.0, rate: 3.0 }
    }

    /// The beginnings of `exp(s)`, with every number of terms: the slope of each is the one before it.
    #[test]
    fn truth_strands_give_value_and_slope() {
        let terms: Vec<f64> = (0..MOST_TERMS).map(|k| (1..=k).fold(1.0, |f, j| f / j as f64)).collect();
        for count in 2..=MOST_TERMS {
            let s = 0.7_f64;
            let sum = |count: usize| terms[..count].iter().rev().fold(0.0, |sum, term| sum * s + term);
            let found = polynomial(&terms[..count]);
            let (value, slope) = found.value_and_slope(s);
            assert!((value - sum(count)).abs() < 1e-15 && (slope - sum(count - 1)).abs() < 1e-15, "{count}");
            assert!((found.at(s) - value).abs() < 1e-15, "{count}");
        }
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
        // At a peak the value gives the instant only to the root of rounding; its slope gives it to machine
        // precision.
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
