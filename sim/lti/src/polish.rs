//! Improvement of approximate zeros by Newton's method on the determinant of the whole system.

use nalgebra::DMatrix;

use crate::domain::C64;
use crate::eigen::eigenvalues;
use crate::response::TransferEvaluator;

/// Largest number of Newton steps to polish a zero; two usually suffice.
const MAX_POLISH: usize = 8;
/// A polishing step larger than this share of the zero (or of the slowest scale) is not a correction; the
/// zero then stays unchanged.
const MAX_CORRECTION: f64 = 1e-2;
/// A Newton step below this share of a zero shows that the zero is correct.
const ALREADY_FOUND: f64 = 1e-3;
/// Sweeps of the joint improvement; poor starting points need one or two dozen.
const MAX_SWEEPS: usize = 100;
/// From this number of states onwards, the determinant follows from poles and response.
pub(crate) const MANY_STATES: usize = 24;
/// Closer to a pole than this, relative to the point, pole and zero of the response nearly cancel.
const BESIDE_POLE: f64 = 1e-6;

/// System matrices during reduction.
#[derive(Clone)]
pub(crate) struct Reduced {
    pub(crate) a: DMatrix<f64>,
    pub(crate) b: DMatrix<f64>,
    pub(crate) c: DMatrix<f64>,
    pub(crate) d: DMatrix<f64>,
}

/// A square system whose zeros are sought.
pub(crate) struct Polish<'a> {
    system: &'a Reduced,
    /// Poles and response of a system with many states, one input and one output.
    factored: Option<(Vec<C64>, TransferEvaluator)>,
}

impl<'a> Polish<'a> {
    pub(crate) fn new(system: &'a Reduced) -> Self {
        let Reduced { a, b, c, d } = system;
        let is_long = a.nrows() >= MANY_STATES && d.shape() == (1, 1);
        let factored = is_long.then(|| {
            let response = TransferEvaluator::of_balanced(a.clone(), b.clone(), c.clone(), d);
            Some((eigenvalues(a).ok()?, response))
        });
        Self { system, factored: factored.flatten() }
    }

    /// Improves all zeros: poor ones together, then each by itself.
    pub(crate) fn all(&self, zeros: &mut Vec<C64>) {
        self.improve_together(zeros);
        self.in_pairs(zeros);
    }

    /// Newton's step on the determinant; zero where it is singular, since the point is then exact.
    fn step(&self, point: C64) -> C64 {
        self.factored_step(point).unwrap_or_else(|| newton_step(self.system, point))
    }

    /// Newton's step from `det P(s) = det(s I - A) G(s)`, whose logarithmic derivative is that of the poles
    /// and of the response; `None` beside a pole.
    fn factored_step(&self, point: C64) -> Option<C64> {
        let (poles, response) = self.factored.as_ref()?;
        let beside = BESIDE_POLE * point.norm();
        if poles.iter().any(|pole| (point - pole).norm() <= beside) {
            return None;
        }
        let (value, slope) = response.with_derivative(point).ok()?;
        let of_poles: C64 = poles.iter().map(|pole| (point - pole).inv()).sum();
        let step = -(of_poles + slope[(0, 0)] / value[(0, 0)]).inv();
        step.is_finite().then_some(step)
    }

    /// Polishes zeros in conjugate pairs: those of the upper half plane, mirrored, and the real ones on the
    /// real axis.
    fn in_pairs(&self, zeros: &mut Vec<C64>) {
        let slowest = 1e-8 * self.system.a.norm();
        let mut polished = Vec::with_capacity(zeros.len());
        for &zero in zeros.iter().filter(|z| z.im >= 0.0) {
            let start = if zero.im <= 1e-14 * zero.norm() { C64::new(zero.re, 0.0) } else { zero };
            let better = self.polish(start, slowest);
            polished.push(better);
            if better.im > 0.0 {
                polished.push(better.conj());
            }
        }
        // Unequal counts mean that pairs were not exactly conjugate; the zeros then stay unchanged.
        if polished.len() == zeros.len() {
            *zeros = polished;
        }
    }

    /// Newton's method as long as its steps shrink; after that, rounding determines their size.
    fn polish(&self, start: C64, slowest: f64) -> C64 {
        let mut zero = start;
        let mut last = MAX_CORRECTION * start.norm().max(slowest);
        for _ in 0..MAX_POLISH {
            let step = self.step(zero);
            if step.norm() >= 0.5 * last {
                return zero;
            }
            zero += step;
            last = step.norm();
        }
        zero
    }

    /// If zeros differ by many decades, rounding of the large ones hides the small ones. All are then
    /// improved together by the method of Ehrlich (CACM 10, 1967) and Aberth (Math. Comp. 27, 1973): Newton's
    /// method on the determinant, divided by the other zeros.
    fn improve_together(&self, zeros: &mut [C64]) {
        let coarse = |z: &C64| !z.is_finite() || self.step(*z).norm() > ALREADY_FOUND * z.norm();
        if !zeros.iter().any(coarse) {
            return;
        }
        let scale = self.system.a.norm();
        for (k, zero) in zeros.iter_mut().enumerate() {
            // Any distinct starting points suffice; those off the axes may move either way.
            if !zero.is_finite() {
                *zero = C64::from_polar(scale, 1.0 + k as f64);
            }
            *zero *= C64::new(1.0, 1e-3 * (k + 1) as f64);
        }
        for _ in 0..MAX_SWEEPS {
            let mut settled = true;
            for k in 0..zeros.len() {
                let newton = self.step(zeros[k]);
                let others: C64 = (0..zeros.len())
                    .filter(|&j| j != k)
                    .map(|j| (zeros[k] - zeros[j]).inv())
                    .filter(|v| v.is_finite())
                    .sum();
                let step = newton / (C64::new(1.0, 0.0) + newton * others);
                if step.is_finite() {
                    zeros[k] += step;
                    settled &= step.norm() <= 8.0 * f64::EPSILON * zeros[k].norm();
                }
            }
            if settled {
                break;
            }
        }
        // Real zeros return to the axis up to rounding.
        for zero in zeros.iter_mut().filter(|z| z.im.abs() <= 1e-9 * z.norm()) {
            zero.im = 0.0;
        }
    }
}

/// Newton's step on det P(s), P = [s I - A, B; -C, D]: -1 / trace(P^-1 P'). It is zero if P is singular.
fn newton_step(system: &Reduced, point: C64) -> C64 {
    let n = system.a.nrows();
    let order = n + system.d.nrows();
    let mut p = DMatrix::from_fn(order, order, |i, j| {
        let value = match (i < n, j < n) {
            (true, true) => -system.a[(i, j)],
            (true, false) => system.b[(i, j - n)],
            (false, true) => -system.c[(i - n, j)],
            (false, false) => system.d[(i - n, j - n)],
        };
        C64::new(value, 0.0)
    });
    for i in 0..n {
        p[(i, i)] += point;
    }
    let Some(inverse) = p.try_inverse() else { return C64::new(0.0, 0.0) };
    let trace: C64 = (0..n).map(|i| inverse[(i, i)]).sum();
    let step = -trace.inv();
    if step.is_finite() { step } else { C64::new(0.0, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of equal masses on springs, driven at one body and read at another.
    fn chain(bodies: usize, read: usize) -> Reduced {
        let n = 2 * bodies;
        let mut a = DMatrix::zeros(n, n);
        for i in 0..bodies {
            a[(i, bodies + i)] = 300.0;
            a[(bodies + i, i)] = -600.0;
            a[(bodies + i, bodies + i)] = -0.5;
            for j in [i.wrapping_sub(1), i + 1].into_iter().filter(|j| *j < bodies) {
                a[(bodies + i, j)] = 300.0;
            }
        }
        let mut b = DMatrix::zeros(n, 1);
        b[(bodies, 0)] = 1.0;
        let mut c = DMatrix::zeros(1, n);
        c[(0, read)] = 1.0;
        Reduced { a, b, c, d: DMatrix::from_element(1, 1, 1e-3) }
    }

    /// Two ways to the same derivative. Both see a matrix changed by some n roundings, amplified by the
    /// distance of the point from poles and zeros, 0.1 of 1e3.
    #[test]
    fn truth_poles_and_response_give_the_step_of_the_whole_determinant() {
        for (bodies, read) in [(12, 0), (20, 3), (40, 1)] {
            let system = chain(bodies, read);
            let polish = Polish::new(&system);
            for point in [C64::new(-0.3, 77.0), C64::new(0.2, 412.0), C64::new(-40.0, 3.0)] {
                let (quick, plain) = (polish.factored_step(point).unwrap(), newton_step(&system, point));
                assert!((quick - plain).norm() < 1e-8 * plain.norm(), "{bodies} {point}: {quick} {plain}");
            }
        }
    }
}
