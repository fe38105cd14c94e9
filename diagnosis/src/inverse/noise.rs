//! The noise of a balance of forces. Friction is inexact near a reversal in proportion to its level, so rows
//! near reversals count less where friction is large.

use super::family::Family;
use super::rows::Moving;
use super::smooth::free;
use super::solve::{mean, residual, solve, squared};
use super::{Inverse, Shaped};

/// Share that friction lacks of its level, between classes of rows from clear motion to reversals.
const CLASSES: [f64; 4] = [0.02, 0.1, 0.3, 0.6];
/// Smallest number of rows that determine the noise of a class.
const FEWEST: usize = 12;

impl Inverse {
    /// Weighs each kept row by the inverse of its deviation. The deviation of a class of rows is that of the
    /// fitted experiments from a model that is flexible in mass, damping, friction and smooth forces.
    pub(super) fn weigh_rows(&mut self) {
        let classes = |rows: &Moving<'_>| -> Vec<usize> {
            let lacks = rows.thin(&rows.of_motion(0.0, |at| (1.0 - at.direction.abs()).abs()));
            lacks.iter().map(|lack| CLASSES.iter().filter(|bound| *lack > **bound).count()).collect()
        };
        let (fitted, checked) = (self.moving_fitted(&self.reversals), self.moving_checked(&self.reversals));
        let (mut terms, target) = self.balance(&fitted, &self.nothing(), Some(Family::Motion));
        for order in 0..2 {
            let of = |rows: &Moving<'_>| rows.thin([&rows.acceleration, &rows.speed][order]);
            terms.push(free(fitted.iter().flat_map(of).collect()));
        }
        let Some(found) = solve(&terms, &target) else { return };
        let squares = squared(&residual(&terms, &found, &target));
        let all: Vec<Vec<usize>> = fitted.iter().chain(&checked).map(classes).collect();
        let class: Vec<usize> = all[..fitted.len()].concat();
        let mut least = 0.0_f64;
        let variances: Vec<f64> = (0..=CLASSES.len())
            .map(|own| {
                let of_class = class.iter().zip(&squares).filter(|(class, _)| **class == own);
                let (count, sum) = of_class.fold((0, 0.0), |(count, sum), (_, x)| (count + 1, sum + x));
                if count >= FEWEST {
                    least = least.max(sum / count as f64);
                }
                least
            })
            .collect();
        let clear = variances.iter().copied().find(|variance| *variance > 0.0).unwrap_or(1.0);
        let weights = |class: &usize| (clear / variances[*class].max(clear)).sqrt();
        for (rows, classes) in self.fitted.iter_mut().chain(&mut self.checked).zip(&all) {
            rows.weights = classes.iter().map(weights).collect();
        }
    }

    /// Squares of a residual, reduced by what a lag adds. The balance adds the lag's time constant times the
    /// rate of all forces that follow from the motion, and so of their errors. It adds nothing to the noise
    /// of the command. A delay adds nothing either, and would look better than every lag.
    pub(super) fn without_lag(&self, shaped: &Shaped<'_>, rows: &[Moving<'_>], rest: &[f64]) -> Vec<f64> {
        let lag_s = shaped.lag_s();
        let mut squares = squared(rest);
        if lag_s > 0.0 {
            let (mut errors, mut from) = (Vec::new(), 0);
            for rows in rows {
                let own = &rest[from..from + rows.weights.len()];
                from += own.len();
                errors.extend(lagged(own, lag_s / rows.kept_s()));
            }
            let whole = mean(&squares).max(f64::MIN_POSITIVE);
            let of_motion = 1.0 - (self.command_noise / whole).min(1.0);
            let reduced = 1.0 - of_motion * (1.0 - mean(&squared(&errors)) / whole).max(0.0);
            for square in &mut squares {
                *square *= reduced;
            }
        }
        squares
    }
}

/// The series that a lag of some rows turns into another one: its inverse, by backward differences.
fn lagged(series: &[f64], rows: f64) -> Vec<f64> {
    let mut last = series.first().copied().unwrap_or(0.0);
    let mut next = |x: &f64| {
        last = (x + rows * last) / (1.0 + rows);
        last
    };
    series.iter().map(&mut next).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;

    /// A residual is an error plus the lag times its rate. The error comes back, whatever the lag.
    #[test]
    fn truth_the_error_behind_a_lag_comes_back() {
        let mut chance = Chance::seeded(3);
        let error: Vec<f64> = (0..500).map(|_| chance.deviate()).collect();
        for rows in [0.1, 1.0, 8.0] {
            let rate = |k: usize| error[k] - error[k.saturating_sub(1)];
            let rest: Vec<f64> = (0..error.len()).map(|k| error[k] + rows * rate(k)).collect();
            for (found, error) in lagged(&rest, rows).iter().zip(&error) {
                // Roundings, of a few hundred steps that shrink them.
                assert!((found - error).abs() < 1e-12, "{rows}");
            }
        }
    }
}
