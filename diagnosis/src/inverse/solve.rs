//! Bounded least squares of a balance of forces.

use nalgebra::{DMatrix, DVector};

use crate::fit::bounded::minimise;

/// Ridge, as a share of a term's square. It separates terms with the same effect.
const RIDGE: f64 = 1e-9;

/// One term of a balance: a series times a coefficient between bounds.
#[derive(Clone)]
pub(super) struct Term {
    pub(super) series: Vec<f64>,
    pub(super) low: f64,
    pub(super) high: f64,
}

/// The coefficients that minimise the squared distance of the terms' sum from the target; `None` if they
/// cannot be determined.
pub(super) fn solve(terms: &[Term], target: &[f64]) -> Option<Vec<f64>> {
    let n = terms.len();
    let sizes: Vec<f64> = terms.iter().map(|term| dot(&term.series, &term.series).sqrt()).collect();
    if sizes.iter().any(|size| !size.is_finite() || *size == 0.0) {
        return None;
    }
    // The solver starts from zero, which must lie within the bounds.
    let start: Vec<f64> = terms.iter().map(|term| 0.0_f64.clamp(term.low, term.high)).collect();
    let made = sum(terms, &start, target.len());
    let rest: Vec<f64> = target.iter().zip(&made).map(|(a, b)| a - b).collect();
    let a = DMatrix::from_fn(n, n, |i, j| {
        let ridge = if i == j { RIDGE } else { 0.0 };
        dot(&terms[i].series, &terms[j].series) / (sizes[i] * sizes[j]) + ridge
    });
    let b = DVector::from_fn(n, |i, _| dot(&terms[i].series, &rest) / sizes[i]);
    let bound = |of: fn(&Term) -> f64| -> Vec<f64> {
        terms.iter().zip(&start).zip(&sizes).map(|((term, start), size)| (of(term) - start) * size).collect()
    };
    let found = minimise(&a, &b, &bound(|term| term.low), &bound(|term| term.high))?;
    Some(start.iter().zip(found.iter()).zip(&sizes).map(|((start, x), size)| start + x / size).collect())
}

/// The rest of the target that terms with these coefficients leave.
pub(super) fn residual(terms: &[Term], coefficients: &[f64], target: &[f64]) -> Vec<f64> {
    let made = sum(terms, coefficients, target.len());
    made.iter().zip(target).map(|(a, b)| a - b).collect()
}

pub(super) fn squared(values: &[f64]) -> Vec<f64> {
    values.iter().map(|x| x * x).collect()
}

pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

pub(super) fn sum(terms: &[Term], coefficients: &[f64], rows: usize) -> Vec<f64> {
    let mut sum = vec![0.0; rows];
    for (term, coefficient) in terms.iter().zip(coefficients) {
        sum.iter_mut().zip(&term.series).for_each(|(sum, x)| *sum += coefficient * x);
    }
    sum
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ratio of the ridge to the smallest curvature of two terms that differ by 0.3.
    const RIDGED: f64 = 1e-6;

    #[test]
    fn truth_coefficients_come_back_and_a_held_one_takes_its_partner_along() {
        let series = |f: fn(f64) -> f64| (0..50).map(|k| f(0.1 * f64::from(k))).collect::<Vec<f64>>();
        let terms = |low: f64| {
            vec![
                Term { series: series(f64::sin), low: 1.0, high: 10.0 },
                Term { series: series(|t| t.sin() + 0.3 * t.cos()), low, high: f64::INFINITY },
            ]
        };
        let free = terms(f64::NEG_INFINITY);
        let target = sum(&free, &[2.0, -1.5], 50);
        let found = solve(&free, &target).unwrap();
        assert!((found[0] - 2.0).abs() < RIDGED && (found[1] + 1.5).abs() < RIDGED, "{found:?}");
        let held = solve(&terms(0.0), &target).unwrap();
        let alone = dot(&free[0].series, &target) / dot(&free[0].series, &free[0].series);
        assert!(held[1].abs() < RIDGED && (held[0] - alone.max(1.0)).abs() < RIDGED, "{held:?}");
    }
}
