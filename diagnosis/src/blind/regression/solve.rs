//! Bounded least squares by coordinate descent.

/// Largest number of sweeps over all unknowns.
const ROUNDS: usize = 20_000;
/// Relative change of an unknown below which the sweeps end.
const STILL: f64 = 1e-10;

/// A regressor with the bounds of its coefficient.
#[derive(Clone, Debug)]
pub(super) struct Term {
    pub(super) series: Vec<f64>,
    pub(super) low: f64,
    pub(super) high: f64,
}

/// Coefficients within their bounds that minimise the squared distance of the terms' sum from `target`.
pub(super) fn solve(terms: &[Term], target: &[f64]) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let n = terms.len();
    let products: Vec<Vec<f64>> =
        terms.iter().map(|a| terms.iter().map(|b| dot(&a.series, &b.series)).collect()).collect();
    let right: Vec<f64> = terms.iter().map(|term| dot(&term.series, target)).collect();
    let mut found: Vec<f64> = terms.iter().map(|term| 0.0_f64.clamp(term.low, term.high)).collect();
    for _ in 0..ROUNDS {
        let mut moved: f64 = 0.0;
        for (i, term) in terms.iter().enumerate() {
            let (own, row) = (products[i][i], &products[i]);
            if own <= 0.0 {
                continue;
            }
            let others: f64 = (0..n).filter(|j| *j != i).map(|j| row[j] * found[j]).sum();
            let best = ((right[i] - others) / own).clamp(term.low, term.high);
            moved = moved.max((best - found[i]).abs() / (best.abs() + f64::MIN_POSITIVE));
            found[i] = best;
        }
        if moved < STILL {
            break;
        }
    }
    found
}

pub(super) fn sum(terms: &[Term], coefficients: &[f64], rows: usize) -> Vec<f64> {
    let mut sum = vec![0.0; rows];
    for (term, coefficient) in terms.iter().zip(coefficients) {
        sum.iter_mut().zip(&term.series).for_each(|(sum, x)| *sum += coefficient * x);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn terms(bounds: [[f64; 2]; 2]) -> Vec<Term> {
        let series = |f: fn(f64) -> f64| (0..50).map(|k| f(0.1 * f64::from(k))).collect();
        let [a, b] = bounds;
        vec![
            Term { series: series(f64::sin), low: a[0], high: a[1] },
            Term { series: series(|t| t.sin() + 0.3 * t.cos()), low: b[0], high: b[1] },
        ]
    }

    #[test]
    fn truth_coefficients_within_their_bounds_come_back() {
        let terms = terms([[-10.0, 10.0]; 2]);
        let target = sum(&terms, &[2.0, -1.5], 50);
        let found = solve(&terms, &target);
        // The sweeps end at a change below 1e-10. The changes left out form a geometric series.
        assert!((found[0] - 2.0).abs() < 1e-6 && (found[1] + 1.5).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn truth_a_held_unknown_takes_its_partner_along() {
        let terms = terms([[0.0, 10.0], [0.0, 10.0]]);
        let target = sum(&terms, &[2.0, -1.5], 50);
        let found = solve(&terms, &target);
        let alone = terms[0].series.iter().zip(&target).map(|(a, b)| a * b).sum::<f64>()
            / terms[0].series.iter().map(|a| a * a).sum::<f64>();
        assert!(found[1].abs() < 1e-12 && (found[0] - alone).abs() < 1e-9);
    }
}
