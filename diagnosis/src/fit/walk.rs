//! Steps along an unknown, up to the point where the cost has risen.
//!
//! The normal matrix consists of slopes over a thousandth of each value. If an impact or a reversal moves to
//! another row, slopes over so short a step are steep, and the cost appears to have a narrow minimum. Longer
//! steps show how far the value may really be off.

use crate::fit::least_squares::{Fitted, Task};

/// Rise of the cost over one deviation below which it is flatter than its slopes indicate; the expected rise
/// is one.
const FLAT: f64 = 0.25;
/// Rise of the cost over a true standard deviation.
const RISE: f64 = 1.0;
/// Largest number of doublings of a step.
const DOUBLINGS: i32 = 10;

/// Factor on one deviation of unknown `i` at which the cost has risen by one, or the unknown is at its bound.
/// `step` is a step of one deviation, with the other unknowns following. `worth` is the weight of a reading
/// by fitted record and channel; `here` is the cost at the fitted values.
pub(super) fn stretch(
    task: &Task<'_>,
    fitted: &Fitted,
    worth: &[Vec<f64>],
    here: f64,
    i: usize,
    step: &[f64],
) -> f64 {
    let Fitted { model, theta, .. } = fitted;
    let rise = |by: f64| {
        let (low, high) = model.unknowns[i].bounds;
        if !(low..=high).contains(&(theta[i] + by * step[i])) {
            return f64::INFINITY;
        }
        let rows = theta.iter().zip(step).zip(&model.unknowns);
        let there: Vec<f64> = rows
            .map(|((theta, step), unknown)| (theta + by * step).clamp(unknown.bounds.0, unknown.bounds.1))
            .collect();
        // Without a prediction the value is excluded.
        cost(task, fitted, worth, &there).map_or(f64::INFINITY, |there| there - here)
    };
    [-1.0, 1.0].map(|side| reach(|by| rise(side * by))).into_iter().fold(1.0, f64::max)
}

/// Steps double. The result is the first step that raises the cost by one, and whose double does too. A
/// single jump of a rough cost does not count. The result is one if the cost rises as expected.
fn reach(rise: impl Fn(f64) -> f64) -> f64 {
    let has_risen = |by: f64| rise(by) >= RISE;
    if rise(1.0) >= FLAT && has_risen(2.0) {
        return 1.0;
    }
    let steps = (1..DOUBLINGS).map(|doublings| 2.0_f64.powi(doublings));
    let mut risen = false;
    for by in steps {
        let there = has_risen(by);
        if risen && there {
            return 0.5 * by;
        }
        risen = there;
    }
    2.0_f64.powi(DOUBLINGS - 1)
}

/// Cost over the fitted records, with each reading weighted by `worth`.
pub(super) fn cost(task: &Task<'_>, fitted: &Fitted, worth: &[Vec<f64>], theta: &[f64]) -> Option<f64> {
    let misfits = task.misfits(&fitted.model, theta, &task.fitted)?;
    let of_record = |((&r, misfits), worth): ((&usize, &Vec<f64>), &Vec<f64>)| {
        let readings = |c: usize| task.dataset.records[r].count(c) as f64;
        let rows = misfits.iter().zip(worth).enumerate();
        rows.map(|(c, (misfit, worth))| worth * readings(c) * misfit).sum::<f64>()
    };
    let sum = task.fitted.iter().zip(&misfits).zip(worth).map(of_record).sum::<f64>();
    let cost = sum + Task::prior_cost(&fitted.model, theta);
    cost.is_finite().then_some(cost)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_cost_as_steep_as_its_slopes_say_is_not_stretched() {
        // Integers and their squares are exact.
        assert_eq!(reach(|by| by * by).to_bits(), 1.0_f64.to_bits());
        assert_eq!(reach(|_| f64::INFINITY).to_bits(), 1.0_f64.to_bits());
    }

    /// A cost with jumps of a hundredth that rises by one over 24 deviations.
    #[test]
    fn truth_a_cost_flatter_than_its_slopes_is_followed_until_it_rises() {
        let rough = |by: f64| (by / 24.0).powi(2) + 0.01 * (50.0 * by).sin();
        // The first power of two above 24.
        assert_eq!(reach(rough).to_bits(), 32.0_f64.to_bits());
        // A jump at one deviation that is gone at two does not end the steps.
        let jump = |by: f64| (by / 24.0).powi(2) + if by < 1.5 { 2.0 } else { 0.0 };
        assert_eq!(reach(jump).to_bits(), 32.0_f64.to_bits());
        // A cost that never rises ends at the longest step.
        assert_eq!(reach(|_| 0.0).to_bits(), 512.0_f64.to_bits());
    }
}
