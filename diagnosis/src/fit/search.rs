//! The search: calibration, then single effects, then combinations.

use std::sync::Mutex;

use feeler_plant::description::Quantity;
use feeler_problem::Problem;
use rayon::prelude::*;

use crate::budget::{Budget, Stage};
use crate::dataset::{Channel, Dataset};
use crate::error::DiagnosisError;
use crate::fit::balanced;
use crate::fit::candidates::{Candidate, candidates};
use crate::fit::first_steps::{first_steps, further_steps};
use crate::fit::glance::glance;
use crate::fit::least_squares::{Fitted, Task};
use crate::fit::model::Model;
use crate::fit::nested;
use crate::fit::odds::{ACCEPT_ALL, evidence};
use crate::fit::scored::Scored;
use crate::fit::screen::{Linearised, Screened};
use crate::fit::weights::Weights;
use crate::inverse::{Balanced, Inverse};
use crate::kinds::{Glance, Seen, host_of};
use crate::predict::{Prediction, Predictor};

/// Steps of a full fit.
const STEPS: usize = 10;
/// Steps of calibration from each start.
const CALIBRATION_STEPS: usize = 6;
/// Reduction of the logarithm of the cost, as a share of the best candidate's. Evidence compares this
/// logarithm. Below the first share a candidate is dropped after its first steps, below the second it is not
/// fitted fully.
const PROMISING: f64 = 0.1;
const RIVAL: f64 = 0.2;
/// A candidate is fitted only if screening reduces the cost by this much. It is a fraction of the smallest
/// evidence that is accepted: a nat corresponds to a cost of about ten.
const WORTH_FITTING: f64 = 25.0;
/// Number of candidates that are fitted fully, at least one for every place.
const FULLY: usize = 7;

/// Number of dropped candidates that are still fitted fully, because others gained less than screening
/// promised.
const MOST_OVERLOOKED: usize = 4;

/// Everything that a search has tried.
pub(crate) struct Search<'a> {
    pub(crate) task: Task<'a>,
    pub(crate) calibrated: Scored,
    pub(crate) singles: Vec<Scored>,
    /// Single causes that were not fitted fully, and single causes that nothing in the records indicates.
    pub(crate) others: Vec<Scored>,
    pub(crate) silent: Vec<Candidate>,
    /// Single causes that were not tried because the time ran out.
    pub(crate) untried: Vec<Candidate>,
    /// Single causes whose fits the end of the time cut short.
    pub(crate) unfinished: Vec<Candidate>,
    /// Range that the fitted records cover.
    pub(crate) seen: Seen,
}

/// Calibrates the machine, then tries every single cause if `has_room` finds enough residual for one.
pub(crate) fn search<'a>(
    dataset: &'a Dataset,
    budget: Budget,
    progress: &dyn Fn(&str),
    has_room: impl Fn(&Task<'_>, &Scored) -> bool,
) -> Result<Search<'a>, DiagnosisError> {
    progress("calibrating");
    let mut model = Model::calibration(&dataset.machine, &dataset.tolerance)?;
    if dataset.first_sampled().is_some() {
        model = model.with_free_timing();
    }
    let start = model.start();
    let reference = dataset
        .records
        .iter()
        .map(|record| {
            let assembly = model.assembly(&start, record.engagement).ok_or_else(|| {
                let message = "no machine can be made of it with these values";
                let problem = Problem::new("", message, "check it by itself, and simplify its effects");
                DiagnosisError::Machine { problems: vec![problem] }
            })?;
            Predictor::with(assembly, model.leeway(&start), dataset, record)?.anchored()
        })
        .collect::<Result<Vec<Prediction>, _>>()?;
    let weights = Weights::new(dataset, &reference);
    let fitted = (0..dataset.records.len()).filter(|&r| !dataset.records[r].is_check).collect();
    let task = Task { dataset, weights, fitted, budget, inverse: Inverse::new(dataset) };
    let mut calibrated = score(&task, Vec::new(), calibrate(&task, &model));
    let mut glance = glance(&task, &calibrated);
    let mut all = candidates(&dataset.machine);
    // Causes whose motion the sensors on both bodies of a spring show are tried before the time runs out.
    all.sort_by_key(|candidate| glance.elongation(host_of(candidate.site)).is_none());
    let mut extended = if has_room(&task, &calibrated) {
        progress("trying single causes");
        extensions(&task, &calibrated, &all, &glance)
    } else {
        Extended { silent: all.clone(), ..Extended::default() }
    };
    // Every cause contains calibration. If the fit of a nearly zero cause is better, calibration had stopped
    // early.
    if let Some(better) = recalibrated(&task, &calibrated, &extended.fits) {
        calibrated = better;
        glance = self::glance(&task, &calibrated);
        // If time runs out, the fits from the worse calibration are kept.
        progress("trying single causes beside a better calibration");
        let again = extensions(&task, &calibrated, &all, &glance);
        if again.left() <= extended.left() {
            extended = again;
        }
    }
    let Extended { fits: singles, others, silent, untried, unfinished } = extended;
    let seen = seen(&glance, dataset);
    Ok(Search { task, calibrated, singles, others, silent, untried, unfinished, seen })
}

/// Range that the fitted records cover.
fn seen(glance: &Glance, dataset: &Dataset) -> Seen {
    let instant_s = if dataset.first_sampled().is_some() { glance.spacing_s } else { 0.0 };
    Seen {
        ends_m: glance.ends(),
        command_n: glance.command,
        speed_m_per_s: glance.speed,
        step_m: finest_step(dataset),
        instant_s,
    }
}

/// The finest step of an encoder, m, or zero if there is none.
fn finest_step(dataset: &Dataset) -> f64 {
    let finest = finest(dataset, |channel| channel.resolution);
    if finest.is_finite() { finest } else { 0.0 }
}

/// The least `size` of all channels of position, m: infinite without any, and zero if an accelerometer
/// resolves smaller motion.
pub(crate) fn finest(dataset: &Dataset, size: impl Fn(&Channel) -> f64) -> f64 {
    let of =
        |wanted: Quantity| dataset.channels.iter().filter(move |c| c.quantity(&dataset.machine) == wanted);
    if of(Quantity::Acceleration).next().is_some() {
        return 0.0;
    }
    of(Quantity::Position).map(size).fold(f64::INFINITY, f64::min)
}

/// Fits the values of the believed machine from several starts: the believed values, and those that balance
/// the forces. Each start is tried with softer and stiffer sticking guides, because dry friction causes local
/// minima.
fn calibrate(task: &Task<'_>, model: &Model) -> Fitted {
    let believed = model.start();
    let found = task.inverse.as_ref().and_then(|inverse| inverse.weigh(&[]));
    let balanced = found.as_ref().map(|found| model.scaled(&believed, &found.believed));
    let reversing =
        balanced.as_ref().zip(found).and_then(|(start, found)| model.reversing(start, found.reversal));
    let tried = std::iter::once(believed).chain(balanced).flat_map(|start| model.stiffer(&start));
    let starts: Vec<Vec<f64>> = tried.chain(reversing).collect();
    // Untried causes are worse than a slightly inaccurate calibration.
    let is_late = || task.budget.is_over(Stage::Calibrate);
    let begun = starts.into_par_iter().enumerate().filter(|(i, _)| *i == 0 || !is_late());
    let fits = begun.map(|(_, start)| task.fit(model, &start, CALIBRATION_STEPS));
    match fits.min_by(|a, b| a.cost.total_cmp(&b.cost)) {
        None => task.fit(model, &model.start(), STEPS),
        Some(best) if is_late() => best,
        Some(best) => task.fit(model, &best.theta, 2 * STEPS),
    }
}

/// Calibration from the solutions of fits with causes, if that costs clearly less.
fn recalibrated(task: &Task<'_>, calibrated: &Scored, fits: &[Scored]) -> Option<Scored> {
    let begin = |scored: &Scored| {
        let mut start = calibrated.fitted.theta.clone();
        let (model, theta) = (&scored.fitted.model, &scored.fitted.theta);
        calibrated.fitted.model.take_over(&mut start, model, theta, 0);
        calibrated.fitted.model.take_back(&mut start, model, theta);
        (task.cost(&calibrated.fitted.model, &start), start)
    };
    let (cost, start) = fits.iter().map(begin).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let is_worth = cost < calibrated.fitted.cost - WORTH_FITTING;
    is_worth.then(|| score(task, Vec::new(), task.fit(&calibrated.fitted.model, &start, STEPS)))
}

/// The results of adding one effect, for every candidate.
#[derive(Default)]
pub(crate) struct Extended {
    /// Candidates that were fitted fully.
    pub(crate) fits: Vec<Scored>,
    /// Candidates that were dropped after a few steps.
    pub(crate) others: Vec<Scored>,
    /// Candidates that nothing in the records indicates, or that allow no motion.
    pub(crate) silent: Vec<Candidate>,
    /// Candidates that were not tried because the time ran out.
    pub(crate) untried: Vec<Candidate>,
    /// Candidates whose fits the end of the time cut short.
    pub(crate) unfinished: Vec<Candidate>,
}

impl Extended {
    /// How many candidates the time did not suffice for.
    fn left(&self) -> usize {
        self.untried.len() + self.unfinished.len()
    }
}

pub(crate) fn score(task: &Task<'_>, causes: Vec<Candidate>, fitted: Fitted) -> Scored {
    let records: Vec<usize> = (0..task.dataset.records.len()).collect();
    let channels = task.dataset.channels.len();
    let misfits = task
        .misfits(&fitted.model, &fitted.theta, &records)
        .unwrap_or_else(|| vec![vec![f64::INFINITY; channels]; records.len()]);
    // A balance that does not involve a cause gains nothing from it.
    let balanced = task.inverse.as_ref().and_then(|inverse| inverse.weigh(&inverse.shown_of(&causes)));
    Scored { causes, fitted, misfits, balanced }
}

/// A candidate after its first steps, and its balance of forces.
type Begun = (Screened, Option<Balanced>);

/// Adds each candidate to `base`. All candidates are fitted for a few steps; the best ones, and the best of
/// every place, are fitted fully.
pub(crate) fn extensions(task: &Task<'_>, base: &Scored, all: &[Candidate], glance: &Glance) -> Extended {
    let Some(linearised) = Linearised::new(task, &base.fitted) else {
        return Extended { silent: all.to_vec(), ..Extended::default() };
    };
    let is_late = || task.budget.is_over(Stage::Screen);
    let beside = |candidate: Candidate| base.causes.iter().copied().chain([candidate]).collect::<Vec<_>>();
    let cut = Cut::default();
    let begin = |&candidate: &Candidate| {
        if is_late() {
            return (candidate, true, None);
        }
        let balanced = task.inverse.as_ref().and_then(|inverse| inverse.weigh(&beside(candidate)));
        let begun = first_steps(task, &linearised, base, candidate, balanced.as_ref(), glance);
        let is_late = is_late();
        cut.set(candidate, begun.is_some() && is_late);
        (candidate, begun.is_none() && is_late, begun.map(|begun| (begun, balanced)))
    };
    let begun: Vec<(Candidate, bool, Option<Begun>)> = all.par_iter().map(begin).collect();
    let without = |late: bool| -> Vec<Candidate> {
        let is_left = |(_, is_late, begun): &&(_, bool, Option<_>)| begun.is_none() && *is_late == late;
        begun.iter().filter(is_left).map(|(candidate, ..)| *candidate).collect()
    };
    let (silent, untried) = (without(false), without(true));
    // A linearised cost may become negative.
    let decline = |fitted: &Fitted| (base.fitted.cost / fitted.cost.max(1.0)).ln();
    let begun: Vec<_> =
        begun.into_iter().filter_map(|(candidate, _, begun)| Some((candidate, begun?))).collect();
    let steepest = begun.iter().map(|(_, (begun, _))| decline(&begun.fitted)).fold(0.0, f64::max);
    let goes_on = |begun: &Screened| {
        begun.bound < base.fitted.cost - WORTH_FITTING
            && (decline(&begun.fitted) > PROMISING * steepest || begun.fitted.cost > base.fitted.cost)
    };
    let go_on = |(candidate, (begun, balanced)): (Candidate, Begun)| {
        let is_worth = goes_on(&begun);
        let is_cut = is_worth && is_late();
        if is_cut {
            cut.set(candidate, true);
        }
        let goes_on = is_worth && !is_cut;
        let further =
            goes_on.then(|| further_steps(&linearised, &base.fitted.theta, &begun.fitted)).flatten();
        let fitted = further.unwrap_or(begun.fitted);
        let balanced = balanced.filter(|_| !task.budget.is_over(Stage::Fit));
        let lower = balanced.and_then(|found| balanced::lower(task, &fitted, &found));
        (candidate, lower.unwrap_or(fitted))
    };
    let mut screened: Vec<(Candidate, Fitted)> = begun.into_par_iter().map(go_on).collect();
    screened.sort_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
    let steepest = screened.first().map_or(0.0, |(_, fitted)| decline(fitted));
    let with = |candidate: Candidate, fitted: Fitted| score(task, beside(candidate), fitted);
    let mut places = Vec::new();
    let mut taken = 0;
    let (chosen, left): (Vec<_>, Vec<_>) = screened.into_iter().partition(|(candidate, fitted)| {
        let is_worth = base.fitted.cost - fitted.cost > WORTH_FITTING && decline(fitted) > RIVAL * steepest;
        let is_first = !places.contains(&candidate.place);
        let is_taken = is_worth && (taken < FULLY || is_first);
        if is_worth {
            places.push(candidate.place);
            taken += 1;
        }
        is_taken
    });
    let mut others: Vec<Scored> =
        left.into_par_iter().map(|(candidate, fitted)| with(candidate, fitted)).collect();
    let mut fits: Vec<Scored> = chosen
        .into_par_iter()
        .map(|(candidate, fitted)| {
            let is_late = task.budget.is_over(Stage::Fit);
            cut.set(candidate, is_late);
            with(candidate, if is_late { fitted } else { task.fit(&fitted.model, &fitted.theta, STEPS) })
        })
        .collect();
    overlooked(task, base, &mut fits, &mut others, &cut);
    let rescore = |old: &Scored, fitted: Fitted| score(task, old.causes.clone(), fitted);
    nested::lower(task, &mut fits, &mut others, STEPS, rescore);
    nested::enforce(task, &mut fits, &mut others, STEPS, rescore);
    Extended { fits, others, silent, untried, unfinished: cut.0.into_inner().unwrap_or_default() }
}

/// Candidates whose fits the end of the time cut short, gathered over threads.
#[derive(Default)]
struct Cut(Mutex<Vec<Candidate>>);

impl Cut {
    fn set(&self, candidate: Candidate, is_cut: bool) {
        if let Ok(mut cut) = self.0.lock() {
            cut.retain(|known| !known.is(&candidate));
            cut.extend(is_cut.then_some(candidate));
        }
    }
}

/// Fully fits dropped candidates if the preferred ones gained less than linear screening promised.
fn overlooked(task: &Task<'_>, base: &Scored, fits: &mut Vec<Scored>, others: &mut Vec<Scored>, cut: &Cut) {
    let records: Vec<usize> = (0..task.dataset.records.len()).collect();
    let gained = |scored: &Scored| evidence(task, base, scored, &records);
    let best = fits.iter().map(gained).fold(0.0, f64::max);
    others.sort_by(|a, b| gained(b).total_cmp(&gained(a)));
    let is_worth = |scored: &Scored| gained(scored) > (RIVAL * best).max(ACCEPT_ALL);
    let worth = others.iter().take(MOST_OVERLOOKED).take_while(|scored| is_worth(scored)).count();
    let again = |scored: Scored| {
        let is_late = task.budget.is_over(Stage::Fit);
        scored.causes.last().into_iter().for_each(|last| cut.set(*last, is_late));
        if is_late { scored } else { finished(task, &scored) }
    };
    let finished: Vec<Scored> =
        others.drain(..worth).collect::<Vec<_>>().into_par_iter().map(again).collect();
    fits.extend(finished);
}

/// Fully fits a model that was dropped after a few steps.
pub(crate) fn finished(task: &Task<'_>, scored: &Scored) -> Scored {
    score(task, scored.causes.clone(), task.fit(&scored.fitted.model, &scored.fitted.theta, STEPS))
}
