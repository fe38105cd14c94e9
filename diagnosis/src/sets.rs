//! Sets of causes that are tried together. They are pairs that a balance of forces proposes, and the simpler
//! law in the place of one that contains it.

use rayon::prelude::*;

use crate::budget::Stage;
use crate::diagnose::{Judge, PARSIMONY};
use crate::fit::candidates::{Candidate, candidates};
use crate::fit::scored::Scored;
use crate::fit::search::score;
use crate::inverse::Balanced;
use crate::kinds::{apart, nearest, overlaps};

/// Evidence in a balance that a second cause must bring before the pair is fitted, nats.
const WORTH_FITTING: f64 = 6.0;
/// Pairs that are fitted.
const MOST_PAIRS: usize = 4;
/// Steps of their fit.
const STEPS: usize = 10;

impl Judge<'_> {
    /// Pairs of causes that a balance of forces proposes, fitted: those that bring more than either cause
    /// does by itself, the best first.
    pub(crate) fn proposed_pairs(&self) -> Vec<Scored> {
        let task = &self.search.task;
        let Some(inverse) = task.inverse.as_ref().filter(|_| self.weight > 0.0) else { return Vec::new() };
        let all = candidates(&self.dataset.machine);
        let singles: Vec<(Candidate, f64)> = all
            .par_iter()
            .filter_map(|candidate| Some((*candidate, inverse.weigh(&[*candidate])?.nats)))
            .collect();
        let best = singles.iter().map(|(_, nats)| *nats).fold(0.0, f64::max);
        let pairs: Vec<[Candidate; 2]> = (0..singles.len())
            .flat_map(|i| (0..i).map(move |j| (j, i)))
            .map(|(j, i)| [singles[j].0, singles[i].0])
            .filter(|[a, b]| a.site != b.site || !overlaps(a.definition.kind, b.definition.kind))
            .collect();
        let mut proposed: Vec<([Candidate; 2], Balanced)> = pairs
            .into_par_iter()
            .filter(|_| !task.budget.is_over(Stage::Screen))
            .filter_map(|pair| Some((pair, inverse.weigh(&pair)?)))
            .filter(|(_, balanced)| balanced.nats > best + WORTH_FITTING)
            .collect();
        proposed.sort_by(|a, b| b.1.nats.total_cmp(&a.1.nats));
        proposed.truncate(MOST_PAIRS);
        let fit = |(pair, balanced): ([Candidate; 2], Balanced)| {
            let calibrated = &self.search.calibrated.fitted;
            let model =
                pair.iter().zip(&balanced.values).fold(calibrated.model.clone(), |model, (cause, values)| {
                    model.with(cause.site, cause.definition, values)
                });
            let mut start = model.start();
            start[..calibrated.theta.len()].copy_from_slice(&calibrated.theta);
            score(task, pair.to_vec(), task.fit(&model, &start, STEPS))
        };
        let mut fitted: Vec<Scored> = proposed.into_par_iter().map(fit).collect();
        fitted.retain(|pair| self.is_finding(pair) && self.all(pair).is_finite());
        fitted.sort_by(|a, b| self.all(b).total_cmp(&self.all(a)));
        fitted
    }

    /// Several causes with one of them exchanged for each that is known to look like it, fitted.
    pub(crate) fn exchanged(&self, accepted: &Scored) -> Vec<Scored> {
        let task = &self.search.task;
        let Some(inverse) = task.inverse.as_ref().filter(|_| self.weight > 0.0 && accepted.causes.len() > 1)
        else {
            return Vec::new();
        };
        let all = candidates(&self.dataset.machine);
        let with = |i: usize, other: &Candidate| {
            let mut causes = accepted.causes.clone();
            let gone = causes.remove(i);
            let is_alike = apart(gone.definition.kind, other.definition.kind).is_some();
            let is_new = causes.iter().all(|cause| {
                cause.site != other.site || !overlaps(cause.definition.kind, other.definition.kind)
            });
            causes.push(*other);
            let values = inverse.weigh(&causes).filter(|_| is_alike && is_new)?.values.pop()?;
            Some(self.with_instead(accepted, i, *other, &values))
        };
        let indices = (0..accepted.causes.len()).flat_map(|i| all.iter().map(move |other| (i, other)));
        let pairs: Vec<(usize, &Candidate)> = indices.collect();
        let fits = pairs.into_par_iter().filter_map(|(i, other)| with(i, other));
        fits.filter(|scored| self.is_finding(scored)).collect()
    }

    /// The same causes with a simpler law in the place of one that contains it, where that loses little.
    pub(crate) fn simplified(&self, scored: Scored) -> Scored {
        let all = candidates(&self.dataset.machine);
        let mut best = scored;
        for i in 0..best.causes.len() {
            let outer = best.causes[i];
            let values = best.fitted.model.parameters(i, &best.fitted.theta);
            let simpler = all.iter().filter(|inner| inner.site == outer.site).flat_map(|inner| {
                nearest(outer.definition.kind, inner.definition.kind, &values)
                    .into_iter()
                    .map(move |v| (*inner, v))
            });
            let fits = simpler.map(|(inner, values)| self.with_instead(&best, i, inner, &values));
            let found = fits.max_by(|a, b| self.all(a).total_cmp(&self.all(b)));
            if let Some(found) = found.filter(|found| self.all(&best) - self.all(found) < PARSIMONY) {
                best = found;
            }
        }
        best
    }

    /// The same causes with `other` in the place of cause `i`.
    fn with_instead(&self, scored: &Scored, i: usize, other: Candidate, values: &[f64]) -> Scored {
        let task = &self.search.task;
        let (base, keep) = scored.fitted.model.without(i);
        let model = base.with(other.site, other.definition, values);
        let mut start = model.start();
        for (start, &kept) in start.iter_mut().zip(&keep) {
            *start = scored.fitted.theta[kept];
        }
        let mut causes = scored.causes.clone();
        causes.remove(i);
        causes.push(other);
        score(task, causes, task.fit(&model, &start, STEPS))
    }
}
