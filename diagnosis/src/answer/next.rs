//! The next experiment: the template in which two look-alike causes differ most (Box and Hill 1967; Atkinson
//! and Fedorov's T-optimality 1975). The machine with one cause is simulated on each template. The machine
//! with the other cause is then fitted to the result, so that only differences beyond calibration count. A
//! template that would exceed the travel or speed of the records is reduced or skipped.

use feeler_plant::description::Engagement;

use crate::answer::templates::{Reach, Template, place_of, templates};
use crate::budget::Budget;
use crate::dataset::{Dataset, Record};
use crate::fit::least_squares::{Fitted, Task};
use crate::fit::scored::Scored;
use crate::fit::search::score;
use crate::judge::Judge;
use crate::predict::{Prediction, Predictor};
use crate::report::{MOST_ODDS, NextExperiment};

/// Share of the records' stroke below which a template without contact moves too little.
const LEAST_STROKE: f64 = 0.02;
/// Fitting steps of the rival on a template.
const STEPS: usize = 3;
/// Smallest odds between the causes at which a template separates them.
const LEAST_ODDS: f64 = 3.0;
/// Largest number of reductions of a template that moves too far.
const TRIES: usize = 6;
/// Safety factor on a proportional reduction of the command: friction and ends of travel are not
/// proportional.
const STEP_BELOW: f64 = 0.95;

/// The template that best separates `rival` from `accepted`; `None` if there is none.
pub(crate) fn next_experiment(
    judge: &Judge<'_>,
    accepted: &Scored,
    rival: &Scored,
) -> Option<NextExperiment> {
    let dataset = judge.dataset;
    if dataset.drives.len() != 1 || !dataset.loops.is_empty() {
        return None;
    }
    let spacing_s = dataset.records[0].spacing_s;
    let odds = |template: &Template| {
        Some(f64::midpoint(
            expected(judge, accepted, rival, template, spacing_s)?,
            expected(judge, rival, accepted, template, spacing_s)?,
        ))
    };
    let mut seen: Vec<(Engagement, Option<Reach>)> = Vec::new();
    let mut best: Option<(f64, Template, Reach, Reach)> = None;
    for template in templates(dataset, spacing_s) {
        let known = seen.iter().find(|(place, _)| *place == template.place).map(|(_, seen)| *seen);
        let reached = known.unwrap_or_else(|| {
            let reached = reached(judge, accepted, template.place);
            seen.push((template.place, reached));
            reached
        });
        let Some(reached) = reached else { continue };
        let Some((template, reach)) = within(judge, [accepted, rival], template, reached, spacing_s) else {
            continue;
        };
        let Some(nats) = odds(&template) else { continue };
        if best.as_ref().is_none_or(|(most, ..)| nats >= *most) {
            best = Some((nats, template, reach, reached));
        }
    }
    let (nats, best, reach, reached) = best?;
    let expected_odds = nats.exp().min(MOST_ODDS);
    if expected_odds < LEAST_ODDS {
        return None;
    }
    let kind = |scored: &Scored| scored.causes.last().map(|cause| cause.definition.kind);
    Some(NextExperiment {
        what: best.what(&dataset.machine, reach, reached),
        separates: [kind(accepted)?, kind(rival)?],
        expected_odds,
        engagement: match best.place {
            Engagement::Free => "free",
            Engagement::Clamped => "clamped",
            Engagement::Unilateral => "unilateral",
        },
        travel_m: reach.travel_m,
        top_speed_m_per_s: reach.top_speed_m_per_s,
        spacing_s,
        command: best.command(spacing_s),
    })
}

/// Travel and speed in the records with this engagement, predicted by the accepted machine along the measured
/// motion.
fn reached(judge: &Judge<'_>, accepted: &Scored, place: Engagement) -> Option<Reach> {
    let records = &judge.dataset.records;
    let of_place = (0..records.len()).filter(|&r| place_of(judge.dataset, &records[r]) == place);
    let Fitted { model, theta, .. } = &accepted.fitted;
    let predictions = of_place.filter_map(|r| judge.search.task.predict(model, theta, r));
    predictions.map(|prediction| Reach::of(&prediction)).reduce(Reach::with)
}

/// The template, reduced until neither machine exceeds the previous travel and speed, with the travel and
/// speed that it causes; `None` if it cannot be reduced enough.
fn within(
    judge: &Judge<'_>,
    machines: [&Scored; 2],
    mut template: Template,
    reached: Reach,
    spacing_s: f64,
) -> Option<(Template, Reach)> {
    for _ in 0..TRIES {
        let mut reach = Reach::NONE;
        for scored in machines {
            reach = reach.with(Reach::of(&run(judge.dataset, scored, &template, spacing_s)?));
        }
        let excess = reach.excess(reached);
        if excess <= 1.0 {
            return Some((template, reach));
        }
        template.peak_n *= STEP_BELOW / excess;
        // The command is zero, or a smaller template has the same effect.
        if template.peak_n <= template.least_n {
            return None;
        }
    }
    None
}

/// A template as a record that starts at the initial state of the records with its engagement.
fn record(template: &Template, spacing_s: f64) -> Record {
    let command = template.command(spacing_s);
    let series = template.start.iter().map(|&value| vec![value; command.len()]).collect();
    let record = Record::even("next experiment", spacing_s, vec![command], series);
    Record { engagement: template.engagement, ..record }
}

/// Predicted response of a machine to a template; `None` if it is not finite.
fn run(dataset: &Dataset, scored: &Scored, template: &Template, spacing_s: f64) -> Option<Prediction> {
    let rest = record(template, spacing_s);
    let Fitted { model, theta, .. } = &scored.fitted;
    let assembly = model.assembly(theta, rest.engagement)?;
    let seen = Predictor::with(assembly, model.leeway(theta), dataset, &rest).ok()?.free().ok()?;
    let is_finite = seen.series.iter().flatten().chain(seen.stroke.iter().flatten()).all(|x| x.is_finite());
    is_finite.then_some(seen)
}

/// Expected evidence for `truth` over `other` from a record of the template, nats.
fn expected(
    judge: &Judge<'_>,
    truth: &Scored,
    other: &Scored,
    template: &Template,
    spacing_s: f64,
) -> Option<f64> {
    let dataset = judge.dataset;
    let seen = run(dataset, truth, template, spacing_s)?;
    let [back, ahead] = Reach::of(&seen).travel_m;
    if template.place == Engagement::Free && ahead - back < LEAST_STROKE * judge.search.seen.stroke_m() {
        return None;
    }
    let imagined = Dataset {
        records: vec![Record { series: seen.series, ..record(template, spacing_s) }],
        ..dataset.clone()
    };
    let reference = truth_prediction(&imagined, truth)?;
    let task = Task {
        dataset: &imagined,
        weights: crate::fit::weights::Weights::new(&imagined, &[reference]),
        fitted: vec![0],
        budget: Budget::unlimited(),
        inverse: None,
    };
    let own = score(&task, truth.causes.clone(), truth.fitted.clone());
    let fitted = task.fit(&other.fitted.model, &other.fitted.theta, STEPS);
    let others = score(&task, other.causes.clone(), fitted);
    // Noise alone gives a mean square residual of one. The predicted record has no noise, so one is added.
    let misfits = own.misfits[0].iter().zip(&others.misfits[0]).zip(&task.weights.looks[0]);
    Some(misfits.map(|((a, b), looks)| 0.5 * looks * ((1.0 + b) / (1.0 + a)).ln()).sum())
}

fn truth_prediction(dataset: &Dataset, truth: &Scored) -> Option<crate::predict::Prediction> {
    let Fitted { model, theta, .. } = &truth.fitted;
    let assembly = model.assembly(theta, dataset.records[0].engagement)?;
    Predictor::with(assembly, model.leeway(theta), dataset, &dataset.records[0]).ok()?.anchored().ok()
}
