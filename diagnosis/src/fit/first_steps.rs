//! The first steps of a fit with one effect in addition to a base, from the best of its starts.

use feeler_plant::effects::Parameter;

use crate::budget::Stage;
use crate::fit::candidates::Candidate;
use crate::fit::least_squares::{Fitted, Task};
use crate::fit::model::Model;
use crate::fit::scored::Scored;
use crate::fit::screen::{Linearised, Screened, Screening, Trial};
use crate::inverse::Balanced;
use crate::kinds::{Element, Glance, dossier};

/// Numbers of first and of further steps.
const FIRST_STEPS: usize = 2;
const FURTHER_STEPS: usize = 4;
/// Number of starts per candidate that are fitted, and the number if all predict worse than the base.
const BEST_STARTS: usize = 3;
const POOR_STARTS: usize = 2;
/// Starts are equal if all their values differ by less than this, as a fraction.
const NEIGHBOURS: f64 = 0.16;

/// A start with its cost. Only the best ones keep their predictions.
struct Start {
    model: Model,
    theta: Vec<f64>,
    cost: f64,
    trial: Option<Trial>,
}

impl Start {
    fn of(linearised: &Linearised<'_>, model: Model, theta: Vec<f64>) -> Option<Self> {
        let trial = linearised.trial(&model, &theta)?;
        Some(Self { cost: trial.cost, model, theta, trial: Some(trial) })
    }

    /// Inserts a start into others, which are sorted by cost.
    fn insert(self, others: &mut Vec<Self>) {
        let place = others.partition_point(|other| other.cost <= self.cost);
        others.insert(place, self);
        others.iter_mut().skip(BEST_STARTS).for_each(|start| start.trial = None);
    }
}

/// The first steps with one effect in addition to `base`.
pub(crate) fn first_steps(
    task: &Task<'_>,
    linearised: &Linearised<'_>,
    base: &Scored,
    candidate: Candidate,
    balanced: Option<&Balanced>,
    glance: &Glance,
) -> Option<Screened> {
    let element = Element::at(candidate.site, &task.dataset.machine, &task.dataset.tolerance);
    let mut values = (dossier(candidate.definition.kind).starts)(&element, glance);
    values.extend(balanced.and_then(|found| balanced_start(found, candidate)));
    let mut starts: Vec<Start> = Vec::new();
    for values in values {
        if task.budget.is_over(Stage::Screen) {
            break;
        }
        let model = base.fitted.model.with(candidate.site, candidate.definition, &values);
        let mut theta = model.start();
        theta[..base.fitted.theta.len()].copy_from_slice(&base.fitted.theta);
        if let Some(start) = Start::of(linearised, model, theta) {
            start.insert(&mut starts);
        }
    }
    // If the candidate makes a guide stick, how it preslides decides as much as the level.
    let fresh = |model: &Model| model.has_free_presliding() && !base.fitted.model.has_free_presliding();
    if let Some(Start { model, theta, .. }) = starts.first().filter(|start| fresh(&start.model)) {
        let (model, theta) = (model.clone(), theta.clone());
        let reversing = balanced.and_then(|found| model.reversing(&theta, found.reversal));
        let others = model.stiffer(&theta).into_iter().filter(|other| *other != theta);
        for other in others.chain(reversing) {
            if let Some(start) = Start::of(linearised, model.clone(), other) {
                start.insert(&mut starts);
            }
        }
    }
    let mut apart: Vec<Start> = Vec::new();
    for start in starts {
        let most = if start.cost < base.fitted.cost { BEST_STARTS } else { POOR_STARTS };
        if apart.len() < most && apart.iter().all(|other| !are_neighbours(&start.model, &other.model)) {
            apart.push(start);
        }
    }
    let begin = |start: Start| linearised.begin(start.model, start.theta, start.trial);
    let mut begun: Vec<Screening> = apart.into_iter().filter_map(begin).collect();
    for _ in 0..FIRST_STEPS {
        // The best one goes on, and each that may still become better.
        let best = begun.iter().map(|screening| screening.costs()[0]).fold(f64::INFINITY, f64::min);
        begun.retain(|screening| screening.costs()[1] <= best);
        for screening in &mut begun {
            linearised.advance(screening, 1);
        }
    }
    let best = begun.into_iter().min_by(|a, b| a.costs()[0].total_cmp(&b.costs()[0]));
    best.map(|screening| linearised.end(screening))
}

/// Further steps after the first ones, if they reach a lower cost. The unknowns of the base start anew.
pub(crate) fn further_steps(linearised: &Linearised<'_>, base: &[f64], begun: &Fitted) -> Option<Fitted> {
    let mut start = begun.theta.clone();
    start[..base.len()].copy_from_slice(base);
    let mut further = linearised.begin(begun.model.clone(), start, None)?;
    linearised.advance(&mut further, FURTHER_STEPS);
    Some(linearised.end(further).fitted).filter(|further| further.cost < begun.cost)
}

/// Values of a candidate, the last cause of a balance of forces, if they are a valid start.
fn balanced_start(found: &Balanced, candidate: Candidate) -> Option<Vec<f64>> {
    let values = found.values.last()?;
    let parameters = candidate.definition.parameters;
    let is_within = |(value, parameter): (&f64, &Parameter)| {
        let (low, high) = parameter.bounds;
        value.is_finite() && (low..=high).contains(value) && Some(*value) != parameter.null
    };
    values.iter().zip(parameters).all(is_within).then(|| values.clone())
}

/// Whether two starts of a candidate are so close that their fits reach the same point.
fn are_neighbours(a: &Model, b: &Model) -> bool {
    let values =
        |model: &Model| model.tried.last().map(|tried| tried.effect.values.clone()).unwrap_or_default();
    values(a).iter().zip(values(b)).all(|(a, b)| (a - b).abs() <= NEIGHBOURS * a.abs().max(b.abs()))
}
