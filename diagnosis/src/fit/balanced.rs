//! Starts of fits where the forces balance. A balance finds believed values and causes together. A fit that
//! begins at the believed values, or beside other causes, may stop in a valley on its way.

use crate::fit::least_squares::{Fitted, Task};
use crate::fit::model::Model;
use crate::inverse::Balanced;

/// The point nearest to `theta` at which the forces balance, and its cost, if it predicts better there. The
/// causes of the balance are those of the model, in their order.
fn cheaper(task: &Task<'_>, model: &Model, theta: &[f64], found: &Balanced) -> Option<(Vec<f64>, f64)> {
    let there = model.with_values(&model.scaled(theta, &found.believed), &found.values);
    let cost = task.cost(model, &there);
    (cost < task.cost(model, theta)).then_some((there, cost))
}

/// Whichever predicts better: `theta`, or the point at which the forces balance.
pub(crate) fn better(task: &Task<'_>, model: &Model, theta: Vec<f64>, found: &Balanced) -> Vec<f64> {
    cheaper(task, model, &theta, found).map_or(theta, |(there, _)| there)
}

/// The screened model at the point where the forces balance, if it predicts better there. Screening moves
/// all but the cause linearly, and may promise more than it keeps. A cause keeps the rank that it promised.
pub(crate) fn lower(task: &Task<'_>, screened: &Fitted, found: &Balanced) -> Option<Fitted> {
    let (theta, cost) = cheaper(task, &screened.model, &screened.theta, found)?;
    Some(Fitted { theta, cost: cost.min(screened.cost), ..screened.clone() })
}
