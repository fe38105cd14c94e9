//! Sets of causes that are tried together: pairs that a balance of forces proposes, and sets in which a cause
//! is exchanged or a law simplified.

use rayon::prelude::*;

use crate::budget::Stage;
use crate::fit::balanced::better;
use crate::fit::candidates::{Candidate, candidates};
use crate::fit::scored::Scored;
use crate::fit::search::score;
use crate::inverse::Balanced;
use crate::judge::{Judge, PARSIMONY};
use crate::kinds::{apart, contains, nearest};

/// Evidence in a balance that a second cause must add before the pair is fitted, nats.
const WORTH_FITTING: f64 = 6.0;
/// Evidence that a pair may gain from its own reversals of friction, nats.
const ROUGH: f64 = 20.0;
/// Largest number of pairs that are fitted.
const MOST_PAIRS: usize = 4;
/// Share of a cause's evidence that another cause must have alone to be tried in its place.
const RIVAL_SHARE: f64 = 0.6;
/// Largest number of exchanges that are fitted.
const MOST_EXCHANGES: usize = 8;
/// Number of steps of these fits.
const STEPS: usize = 10;

/// Whether a pair differs from another only by a simpler law, which that of the other contains.
fn is_simpler(pair: &[Candidate; 2], other: &[Candidate; 2]) -> bool {
    [(0, 0), (0, 1), (1, 0), (1, 1)].into_iter().any(|(i, j)| {
        let (inner, outer) = (&pair[1 - i], &other[1 - j]);
        pair[i].is(&other[j])
            && inner.site == outer.site
            && contains(outer.definition.kind, inner.definition.kind)
    })
}

impl Judge<'_> {
    /// Fits the pairs of causes that a balance of forces proposes. These gain more in the balance than any
    /// single cause. The best fit comes first. Also returns whether the time sufficed to weigh all pairs.
    pub(crate) fn proposed_pairs(&self) -> (Vec<Scored>, bool) {
        let task = &self.search.task;
        let Some(inverse) = task.inverse.as_ref().filter(|_| self.weight > 0.0) else {
            return (Vec::new(), true);
        };
        let all = candidates(&self.dataset.machine);
        let singles: Vec<(Candidate, f64)> = all
            .par_iter()
            .filter_map(|candidate| Some((*candidate, inverse.weigh(&[*candidate])?.nats)))
            .collect();
        let best = singles.iter().map(|(_, nats)| *nats).fold(0.0, f64::max);
        let pairs: Vec<[Candidate; 2]> = (0..singles.len())
            .flat_map(|i| (0..i).map(move |j| (j, i)))
            .map(|(j, i)| [singles[j].0, singles[i].0])
            .filter(|[a, b]| !a.is_covered_by(&[*b]))
            .collect();
        let mut proposed: Vec<([Candidate; 2], Balanced)> = pairs
            .into_par_iter()
            .filter(|_| !task.budget.is_over(Stage::Screen))
            .filter(|pair| {
                let rough = inverse.weigh_roughly(pair);
                rough.is_some_and(|rough| rough.nats > best + WORTH_FITTING - ROUGH)
            })
            .filter_map(|pair| Some((pair, inverse.weigh(&pair)?)))
            .filter(|(_, balanced)| balanced.nats > best + WORTH_FITTING)
            .collect();
        let is_in_time = !task.budget.is_over(Stage::Screen);
        proposed.sort_by(|a, b| b.1.nats.total_cmp(&a.1.nats));
        let is_needed = |(pair, balanced): &&([Candidate; 2], Balanced)| {
            !proposed.iter().any(|(simpler, other)| {
                other.nats > balanced.nats - WORTH_FITTING && is_simpler(simpler, pair)
            })
        };
        let proposed: Vec<_> = proposed.iter().filter(is_needed).take(MOST_PAIRS).cloned().collect();
        let fit = |(pair, balanced): ([Candidate; 2], Balanced)| {
            let calibrated = &self.search.calibrated.fitted;
            let model =
                pair.iter().zip(&balanced.values).fold(calibrated.model.clone(), |model, (cause, values)| {
                    model.with(cause.site, cause.definition, values)
                });
            let mut start = model.start();
            start[..calibrated.theta.len()].copy_from_slice(&calibrated.theta);
            let start = better(task, &model, start, &balanced);
            score(task, pair.to_vec(), task.fit(&model, &start, STEPS))
        };
        let mut fitted: Vec<Scored> = proposed.into_par_iter().map(fit).collect();
        fitted.retain(|pair| self.is_finding(pair) && self.all(pair).is_finite());
        fitted.sort_by(|a, b| self.all(b).total_cmp(&self.all(a)));
        (fitted, is_in_time)
    }

    /// Fits the accepted causes with one of them exchanged. The new cause is a known look-alike, or is nearly
    /// as good alone.
    pub(crate) fn exchanged(&self, accepted: &Scored) -> Vec<Scored> {
        if accepted.causes.len() < 2 {
            return Vec::new();
        }
        let all = candidates(&self.dataset.machine);
        let indices = (0..accepted.causes.len()).flat_map(|i| all.iter().map(move |other| (i, other)));
        let mut starts: Vec<(usize, Candidate, Vec<f64>, f64)> = indices
            .filter_map(|(i, other)| {
                let (values, alone) = self.start_instead(accepted, i, other)?;
                Some((i, *other, values, alone))
            })
            .collect();
        starts.sort_by(|a, b| b.3.total_cmp(&a.3));
        starts.truncate(MOST_EXCHANGES);
        let fits = starts
            .into_par_iter()
            .map(|(i, other, values, _)| self.with_instead(accepted, i, other, &values));
        fits.filter(|scored| self.is_finding(scored) && self.all(scored).is_finite()).collect()
    }

    /// Starting values of a cause in the place of cause `i`, and its evidence alone; `None` if nothing
    /// indicates it there.
    fn start_instead(&self, accepted: &Scored, i: usize, other: &Candidate) -> Option<(Vec<f64>, f64)> {
        let gone = &accepted.causes[i];
        let mut causes: Vec<Candidate> = accepted.causes.clone();
        causes.remove(i);
        if other.is(gone) || other.is_covered_by(&causes) {
            return None;
        }
        let single = |of: &Candidate| self.search.singles.iter().find(|single| single.causes[0].is(of));
        let alone = single(other).map(|single| (single, self.all(single)));
        let own = single(gone).map_or(f64::INFINITY, |single| self.all(single));
        if let Some((single, nats)) = alone
            && nats > RIVAL_SHARE * own
        {
            return Some((single.values(0), nats));
        }
        let is_alike = apart(gone.definition.kind, other.definition.kind).is_some();
        let inverse = self.search.task.inverse.as_ref().filter(|_| is_alike && self.weight > 0.0)?;
        causes.push(*other);
        let values = inverse.weigh(&causes)?.values.pop()?;
        Some((values, alone.map_or(0.0, |(_, nats)| nats)))
    }

    /// The causes with simpler laws in place of laws that contain them, if that loses little evidence.
    pub(crate) fn simplified(&self, scored: Scored) -> Scored {
        let all = candidates(&self.dataset.machine);
        let mut best = scored;
        for i in 0..best.causes.len() {
            let outer = best.causes[i];
            let values = best.values(i);
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

    /// The causes with `other` in place of cause `i`, fitted.
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
        let found = task.inverse.as_ref().and_then(|inverse| inverse.weigh(&causes));
        let start = match found {
            Some(found) => better(task, &model, start, &found),
            None => start,
        };
        let starts = model.stiffer_after(&start, &scored.fitted);
        let is_only = starts.len() == 1;
        let cost = |start: &[f64]| if is_only { 0.0 } else { task.cost(&model, start) };
        let costs = starts.into_iter().map(|start| (cost(&start), start));
        let start = costs.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(start, |(_, start)| start);
        score(task, causes, task.fit(&model, &start, STEPS))
    }
}
