//! Starting points of fits at which the forces balance. A balance finds believed values and causes together.
//! A fit from the believed values, or beside other causes, may stop in a local minimum.

use crate::fit::least_squares::{Fitted, Task};
use crate::fit::model::Model;
use crate::inverse::Balanced;

/// The point near `theta` at which the forces balance, and its cost, if it predicts better than `theta`. The
/// balance has the causes of the model, in the same order.
fn cheaper(task: &Task<'_>, model: &Model, theta: &[f64], found: &Balanced) -> Option<(Vec<f64>, f64)> {
    let there = model.with_values(&model.scaled(theta, &found.believed), &found.values);
    let reversing = model.reversing(&there, found.reversal);
    let costs = std::iter::once(there).chain(reversing).map(|point| (task.cost(model, &point), point));
    let (cost, there) = costs.min_by(|a, b| a.0.total_cmp(&b.0))?;
    (cost < task.cost(model, theta)).then_some((there, cost))
}

/// The point that predicts better: `theta`, or the one at which the forces balance.
pub(crate) fn better(task: &Task<'_>, model: &Model, theta: Vec<f64>, found: &Balanced) -> Vec<f64> {
    cheaper(task, model, &theta, found).map_or(theta, |(there, _)| there)
}

/// The screened model at the point where the forces balance, if it predicts better there. Screening is linear
/// in all unknowns but those of the cause, so its cost may be too low. The lower cost is kept for the
/// ranking.
pub(crate) fn lower(task: &Task<'_>, screened: &Fitted, found: &Balanced) -> Option<Fitted> {
    let (theta, cost) = cheaper(task, &screened.model, &screened.theta, found)?;
    Some(Fitted { theta, cost: cost.min(screened.cost), ..screened.clone() })
}
