//! The diagnosis: calibrate, try causes, compose, judge.

use feeler_plant::effects::Place;
use indexmap::IndexMap;

use crate::candidates::candidates;
use crate::dataset::Dataset;
use crate::error::DiagnosisError;
use crate::fit::Fitted;
use crate::gap;
use crate::odds::{gain, probabilities};
use crate::report::{Attempt, Cause, Diagnosis, Estimate, Verdict, Where};
use crate::search::{Scored, Search, extensions, glance, score, search};
use crate::tolerance::is_within;
use crate::unknown;

/// Evidence on the check experiments that a cause must bring, nats.
const ACCEPT: f64 = 12.0;
/// Evidence that a further cause must bring, nats: the first may be slightly wrong in ways that a second patches.
const ACCEPT_FURTHER: f64 = 40.0;
/// A cause with fewer parameters is preferred to one that brings less than this more, nats: real friction differs a little from every law.
const PARSIMONY: f64 = 30.0;
/// Most causes at once.
const MOST_CAUSES: usize = 3;
/// Softening of the odds.
const TEMPERATURE: f64 = 4.0;
/// Causes within this much evidence of the best look alike to these records, nats.
const LOOK_ALIKE: f64 = 12.0;
/// Probability that the set of rivals listed holds.
const CREDIBLE: f64 = 0.99;
/// Steps when an effect is taken out again.
const REMOVAL_STEPS: usize = 6;
/// 90 % of a normal distribution, in standard deviations.
const NINETY_PERCENT: f64 = 1.645;
/// Largest gap in units of the floor at which nothing is missing.
const NO_GAP_POINTS: usize = 4000;

/// Says where the gap between a machine and its records lies, what causes it, and how far it closes.
///
/// `progress` is told what is being done.
///
/// # Errors
/// Where the machine has no motion as it is described.
pub fn diagnose(dataset: &Dataset, progress: &dyn Fn(&str)) -> Result<Diagnosis, DiagnosisError> {
    progress("calibrating and trying single causes");
    let found = search(dataset)?;
    let judge = Judge { dataset, search: &found };
    let mut ranked: Vec<&Scored> = found.singles.iter().filter(|scored| judge.is_finding(scored)).collect();
    ranked.sort_by(|a, b| judge.all(b).total_cmp(&judge.all(a)));
    prefer_simple(&mut ranked, |scored| judge.all(scored));
    let mut attempts: Vec<Scored> = found.singles.clone();
    let mut accepted = found.calibrated.clone();
    let mut rivals: Vec<Scored> = Vec::new();
    if let Some(best) = ranked.first().filter(|best| judge.check(&found.calibrated, best) > ACCEPT && judge.all(best) > ACCEPT) {
        accepted = (*best).clone();
        rivals = ranked.iter().map(|scored| (*scored).clone()).collect();
    }
    // A force over position that no effect of the library makes: the sine that is no ripple describes it better than any cause.
    let shape = found.singles.iter().filter(|scored| !judge.is_finding(scored) && scored.causes[0].definition.kind == "force-ripple");
    let shape = shape.max_by(|a, b| judge.all(a).total_cmp(&judge.all(b)));
    if let Some(shape) = shape.filter(|shape| gain(&accepted, shape, &judge.everything()) > ACCEPT_FURTHER) {
        return Ok(judge.position_force(shape, &attempts));
    }
    let glimpse = glance(&found.task, &accepted);
    while !accepted.causes.is_empty() && accepted.causes.len() < MOST_CAUSES && !unknown::is_adequate(&accepted) {
        progress("trying a further cause");
        let left: Vec<_> = candidates(&dataset.machine)
            .into_iter()
            .filter(|c| !accepted.causes.iter().any(|a| a.site == c.site && a.definition.kind == c.definition.kind))
            .collect();
        let mut further: Vec<Scored> = extensions(&found.task, &accepted, &left, &glimpse);
        further.retain(|scored| judge.is_finding(scored));
        further.sort_by(|a, b| judge.all(b).total_cmp(&judge.all(a)));
        prefer_simple(&mut further, |scored| judge.all(scored));
        attempts.extend(further.iter().cloned());
        let Some(best) = further.first() else { break };
        if judge.check(&accepted, best) < ACCEPT_FURTHER || gain(&accepted, best, &judge.everything()) < ACCEPT_FURTHER {
            break;
        }
        accepted = judge.prune(best.clone());
        rivals = further;
    }
    Ok(judge.answer(&accepted, &rivals, &attempts))
}

/// Brings the simplest of those nearly as good as the best to the front of a ranking.
fn prefer_simple<T: std::borrow::Borrow<Scored>>(ranked: &mut [T], evidence: impl Fn(&Scored) -> f64) {
    let Some(best) = ranked.first().map(|first| evidence(first.borrow())) else { return };
    let near = ranked.iter().take_while(|scored| best - evidence((*scored).borrow()) < PARSIMONY).count();
    let simplest = (0..near).min_by_key(|&i| ranked[i].borrow().fitted.theta.len()).unwrap_or(0);
    ranked[..=simplest].rotate_right(1);
}

struct Judge<'a> {
    dataset: &'a Dataset,
    search: &'a Search<'a>,
}

impl Judge<'_> {
    fn everything(&self) -> Vec<usize> {
        (0..self.dataset.records.len()).collect()
    }

    fn checks(&self) -> Vec<usize> {
        (0..self.dataset.records.len()).filter(|&r| self.dataset.records[r].is_check).collect()
    }

    fn all(&self, scored: &Scored) -> f64 {
        gain(&self.search.calibrated, scored, &self.everything())
    }

    fn check(&self, old: &Scored, new: &Scored) -> f64 {
        gain(old, new, &self.checks())
    }

    fn is_finding(&self, scored: &Scored) -> bool {
        let fitted = &scored.fitted;
        (0..scored.causes.len()).all(|i| !is_within(&fitted.model, &fitted.theta, i, &self.dataset.tolerance, self.search.stroke_m))
    }

    /// Takes out effects whose removal costs nothing.
    fn prune(&self, mut scored: Scored) -> Scored {
        let mut i = 0;
        while i < scored.causes.len() && scored.causes.len() > 1 {
            let without = self.without(&scored, i);
            if self.check(&without, &scored) < ACCEPT {
                scored = without;
                i = 0;
            } else {
                i += 1;
            }
        }
        scored
    }

    fn without(&self, scored: &Scored, effect: usize) -> Scored {
        let (model, keep) = scored.fitted.model.without(effect);
        let start: Vec<f64> = keep.iter().map(|&i| scored.fitted.theta[i]).collect();
        let fitted = self.search.task.fit(&model, &start, REMOVAL_STEPS);
        let mut causes = scored.causes.clone();
        causes.remove(effect);
        score(&self.search.task, causes, fitted)
    }

    fn answer(&self, accepted: &Scored, rivals: &[Scored], attempts: &[Scored]) -> Diagnosis {
        let task = &self.search.task;
        let checks = self.checks();
        let calibrated = &self.search.calibrated;
        let errors = |fitted: &Fitted| gap::square_errors(task, &fitted.model, &fitted.theta, &checks);
        let refit = errors(&calibrated.fitted).unwrap_or_else(|| vec![f64::INFINITY; checks.len()]);
        let before =
            gap::square_errors(task, &calibrated.fitted.model, &calibrated.fitted.model.start(), &checks).unwrap_or_else(|| refit.clone());
        let after = errors(&accepted.fitted).unwrap_or_else(|| refit.clone());
        let floor = gap::square_floors(task, &checks);
        let figures = gap::gap(&before, &refit, &after, &floor);

        // Odds among models that differ in their last cause; those of earlier causes are settled by acceptance.
        let evidence: Vec<f64> = rivals.iter().map(|rival| self.all(rival)).collect();
        let odds = probabilities(&evidence, TEMPERATURE);
        let adequate = unknown::is_adequate(accepted);
        let own = rivals.iter().zip(&odds).find(|(rival, _)| same(rival, accepted)).map_or(1.0, |(_, p)| *p);
        let known = if adequate { 1.0 } else { 0.5 };
        let mut effects: Vec<Cause> = (0..accepted.causes.len())
            .map(|i| self.cause(accepted, i, known * if i + 1 == accepted.causes.len() { own } else { 0.95 }, true))
            .collect();
        let mut look_alikes = Vec::new();
        let mut sum = own;
        for (rival, &p) in rivals.iter().zip(&odds) {
            let Some(last) = rival.causes.len().checked_sub(1).filter(|_| !same(rival, accepted)) else { continue };
            let best = evidence.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            if let Some(mine) = accepted.causes.last().filter(|_| best - self.all(rival) < LOOK_ALIKE && look_alikes.len() < 2) {
                look_alikes.push([mine.definition.kind, rival.causes[last].definition.kind]);
            }
            if sum < CREDIBLE && p > 0.005 {
                sum += p;
                effects.push(self.cause(rival, last, known * p, false));
            }
        }
        self.credit(accepted, &refit, &after, &mut effects);
        let verdict = verdict(accepted, adequate, own);
        let places = self.places(accepted, &effects, verdict);
        let mut tried: Vec<Attempt> = attempts
            .iter()
            .map(|scored| Attempt { causes: self.names(scored), gain_check: self.check(calibrated, scored), gain_all: self.all(scored) })
            .collect();
        tried.sort_by(|a, b| b.gain_all.total_cmp(&a.gain_all));
        let mut portrait = unknown::portrait(task, calibrated, 8, None);
        let thin = portrait.len().div_ceil(NO_GAP_POINTS).max(1);
        portrait = portrait.into_iter().step_by(thin).collect();
        Diagnosis {
            verdict,
            gap: figures,
            places,
            effects,
            look_alikes,
            attempts: tried,
            warnings: self.dataset.warnings.iter().map(ToString::to_string).collect(),
            portrait,
            machine: accepted.fitted.model.machine(&accepted.fitted.theta),
        }
    }

    /// The answer where a force over position is missing that is no effect of the library.
    fn position_force(&self, shape: &Scored, attempts: &[Scored]) -> Diagnosis {
        let mut answer = self.answer(&self.search.calibrated, &[], attempts);
        answer.verdict = Verdict::UnknownCause;
        let values = shape.fitted.model.parameters(0, &shape.fitted.theta);
        let evidence = format!(
            "a force that depends on position and hardly repeats over the stroke, about {:.2} N over {:.4} m, explains what no effect of the library does",
            values[0], self.search.stroke_m
        );
        let mut found = answer.places.iter().find(|place| place.place == Place::Guide.name()).or(answer.places.first()).cloned();
        if let Some(place) = &mut found {
            place.place = Place::Guide.name();
            place.probability = 0.85;
            place.evidence = evidence;
        }
        answer.places = found.into_iter().collect();
        answer
    }

    fn names(&self, scored: &Scored) -> String {
        let name = |cause: &crate::candidates::Candidate| format!("{}@{}", cause.definition.kind, cause.site.key(&self.dataset.machine));
        scored.causes.iter().map(name).collect::<Vec<_>>().join("+")
    }

    fn cause(&self, scored: &Scored, i: usize, probability: f64, accepted: bool) -> Cause {
        let candidate = scored.causes[i];
        let fitted = &scored.fitted;
        let rotational = self.dataset.machine.axis == feeler_plant::description::Axis::Rotational;
        let values = fitted.model.parameters(i, &fitted.theta);
        let mut parameters = IndexMap::new();
        for (k, parameter) in candidate.definition.parameters.iter().enumerate() {
            let spread = fitted
                .model
                .unknowns
                .iter()
                .position(|unknown| unknown.parameter_of(i) == Some(k))
                .map_or(0.0, |u| NINETY_PERCENT * fitted.model.unknowns[u].spread(fitted.theta[u], fitted.sigma[u]));
            let unit = parameter.dimension.si_unit(rotational).to_owned();
            parameters.insert(parameter.name, Estimate { value: values[k], ci90: [values[k] - spread, values[k] + spread], unit });
        }
        Cause {
            kind: candidate.definition.kind,
            on: candidate.site.key(&self.dataset.machine),
            place: candidate.place.name(),
            probability,
            parameters,
            credit: 0.0,
            accepted,
        }
    }

    /// Shapley's share of each accepted effect in what all of them close; of two or more, from the order of removal.
    fn credit(&self, accepted: &Scored, refit: &[f64], after: &[f64], effects: &mut [Cause]) {
        let n = accepted.causes.len();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        match n {
            0 => {}
            1 => effects[0].credit = 1.0,
            _ => {
                let whole = mean(refit) - mean(after);
                let checks = self.checks();
                let losses: Vec<f64> = (0..n)
                    .map(|i| {
                        let without = self.without(accepted, i);
                        let errors = gap::square_errors(&self.search.task, &without.fitted.model, &without.fitted.theta, &checks);
                        errors.map_or(0.0, |errors| (mean(&errors) - mean(after)).max(0.0))
                    })
                    .collect();
                // For two, Shapley's value is the mean of what each adds alone and last; with equal interaction shares it is this for more.
                let interaction = (whole - losses.iter().sum::<f64>()) / n as f64;
                for (effect, loss) in effects.iter_mut().zip(&losses) {
                    effect.credit = if whole > 0.0 { ((loss + interaction) / whole).clamp(0.0, 1.0) } else { 0.0 };
                }
            }
        }
    }

    fn places(&self, accepted: &Scored, effects: &[Cause], verdict: Verdict) -> Vec<Where> {
        let pointer = unknown::point(
            &self.search.task,
            if accepted.causes.is_empty() || verdict == Verdict::UnknownCause { accepted } else { &self.search.calibrated },
        );
        let mut chances: IndexMap<&'static str, f64> = IndexMap::new();
        for effect in effects {
            let chance = chances.entry(effect.place).or_insert(0.0);
            *chance = if effect.accepted { chance.max(effect.probability) } else { *chance + effect.probability }.min(1.0);
        }
        if verdict == Verdict::UnknownCause {
            let rest = if accepted.causes.is_empty() { 0.7 } else { 0.4 };
            let chance = chances.entry(pointer.place.name()).or_insert(0.0);
            *chance = chance.max(rest);
        }
        let mut places: Vec<Where> = chances
            .into_iter()
            .map(|(place, probability)| Where {
                place,
                probability,
                channel: self.dataset.channels.get(pointer.channel).map_or_else(String::new, |channel| channel.column.clone()),
                band_hz: [0.0, 0.5 / self.dataset.records[0].spacing_s],
                phase: if pointer.is_contact { "contact" } else { "free" },
                evidence: pointer.evidence.clone(),
            })
            .collect();
        places.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        places
    }
}

fn same(a: &Scored, b: &Scored) -> bool {
    a.causes.len() == b.causes.len()
        && a.causes.iter().zip(&b.causes).all(|(a, b)| a.site == b.site && a.definition.kind == b.definition.kind)
}

fn verdict(accepted: &Scored, adequate: bool, own: f64) -> Verdict {
    match (accepted.causes.is_empty(), adequate) {
        (true, true) => Verdict::NoGap,
        (_, false) => Verdict::UnknownCause,
        (false, true) if own < 0.9 => Verdict::Ambiguous,
        (false, true) => Verdict::Explained,
    }
}
