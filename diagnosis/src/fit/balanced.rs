//! Starts of fits where the forces balance. A balance finds believed values and causes together. A fit that
//! begins at the believed values, or beside other causes, may stop in a valley on its way.

use crate::fit::candidates::Candidate;
use crate::fit::least_squares::{Fitted, Task};
use crate::fit::model::Model;

/// The point nearest to `theta` at which the forces balance with these causes, in the order of the model's
/// trial effects. `None` if the balance does not show one of them.
fn point(task: &Task<'_>, model: &Model, theta: &[f64], causes: &[Candidate]) -> Option<Vec<f64>> {
    let found = task.inverse.as_ref()?.weigh(causes)?;
    Some(model.with_values(&model.scaled(theta, &found.believed), &found.values))
}

/// Whichever predicts better: `theta`, or the point at which the forces balance.
pub(crate) fn better(task: &Task<'_>, model: &Model, theta: Vec<f64>, causes: &[Candidate]) -> Vec<f64> {
    match point(task, model, &theta, causes) {
        Some(other) if task.cost(model, &other) < task.cost(model, &theta) => other,
        _ => theta,
    }
}

/// The screened model at the point where the forces balance, if it predicts better there. Screening moves
/// all but the cause linearly, and may promise more than it keeps.
pub(crate) fn lower(task: &Task<'_>, screened: &Fitted, causes: &[Candidate]) -> Option<Fitted> {
    let theta = point(task, &screened.model, &screened.theta, causes)?;
    // A cause keeps the rank that its screening promised.
    let cost = task.cost(&screened.model, &theta);
    (cost < task.cost(&screened.model, &screened.theta)).then(|| Fitted {
        theta,
        cost: cost.min(screened.cost),
        ..screened.clone()
    })
}
