//! Runs the counterfactuals and chooses the cause among them.

use std::sync::atomic::{AtomicUsize, Ordering};

use feeler_engine::Scenario;
use rayon::prelude::*;

use super::change::{ChatterCause, Counterfactual, SLOWER, SLOWER_STILL, affords, arriving_later, slow_down};
use super::explanation::{Explanation, LARGEST_SET, Lift, Trial, is_cured, is_troubled};
use super::words::{beside, nothing_to_explain, sentence};
use super::{linear, remedy};
use crate::run::{Measured, Outcome, PreparedRun, RunError};

/// The verdict also names a change that raises the stability limit by more than this factor.
const LIFTS: f64 = 2.0;

/// Largest share of the amplitude that a cure may leave in a noisy run. Between parts of a run, the
/// oscillation of a loop near its limit varies by less.
const LEFT_BY_CURE: f64 = 0.5;

pub(super) struct WhySearch<'a> {
    scenario: Scenario,
    baseline: Measured,
    runs: AtomicUsize,
    progress: &'a (dyn Fn(usize) + Sync),
}

impl<'a> WhySearch<'a> {
    pub(super) fn new(scenario: &Scenario, progress: &'a (dyn Fn(usize) + Sync)) -> Result<Self, RunError> {
        let baseline = PreparedRun::new(scenario.clone())?.measure(0)?;
        progress(1);
        Ok(Self { scenario: scenario.clone(), baseline, runs: AtomicUsize::new(1), progress })
    }

    pub(super) fn explain(&self) -> Explanation {
        let baseline = trial_of(
            &self.scenario,
            &[],
            true,
            &Ok(self.baseline.clone()),
            linear::gain_margin(&self.scenario),
        );
        let linear_stable = linear::is_stable_in_contact(&self.scenario);
        // A tool that pushes itself away does not chatter, but needs an explanation too.
        let is_pushed_away =
            self.baseline.summary.outcome == Outcome::NoContact && self.baseline.summary.contact_time_s > 0.0;
        let wrong_sign = (is_troubled(&self.baseline) || is_pushed_away)
            && linear_stable == Some(false)
            && linear::has_wrong_sign(&self.scenario);
        let chatters = is_troubled(&self.baseline) || wrong_sign;
        let mut explanation = Explanation {
            gain_margin: baseline.gain_margin,
            baseline,
            chatters,
            linear_stable,
            wrong_sign,
            undamped: chatters && linear::is_undamped(&self.scenario),
            singles: Vec::new(),
            smallest: Vec::new(),
            contributions: Vec::new(),
            causes: Vec::new(),
            verdict: String::new(),
            lift: None,
            lifts: Vec::new(),
            sizes: Vec::new(),
            remedies: Vec::new(),
        };
        if !chatters {
            // The margin of the trial is absent if it is infinite, too.
            let margin = linear::gain_margin(&self.scenario).filter(|margin| *margin > 1.0);
            let is_limited = margin.filter(|margin| margin.is_finite());
            explanation.lifts =
                is_limited.map_or_else(Vec::new, |margin| linear::lifts(&self.scenario, margin));
            explanation.verdict =
                nothing_to_explain(&self.scenario, &self.baseline, margin, &explanation.lifts);
            return explanation;
        }
        explanation.singles =
            Counterfactual::ALL.par_iter().map(|change| self.trial(&[*change], true)).collect();
        let mut smallest = self.smallest(&explanation.singles);
        let weights: Vec<f64> =
            Counterfactual::ALL.iter().map(|change| weight(*change, &explanation)).collect();
        let weigh = |change: &Counterfactual| {
            Counterfactual::ALL.iter().position(|known| known == change).map_or(0.0, |i| weights[i])
        };
        let mean = |set: &Vec<Counterfactual>| set.iter().map(weigh).sum::<f64>() / set.len() as f64;
        smallest.sort_by(|a, b| mean(b).total_cmp(&mean(a)));
        for set in &mut smallest {
            set.sort_by(|a, b| weigh(b).total_cmp(&weigh(a)));
        }
        if let Some(chosen) = smallest.first() {
            explanation.contributions = self.contributions(chosen);
            for change in chosen {
                if !explanation.causes.contains(&change.cause()) {
                    explanation.causes.push(change.cause());
                }
            }
        }
        explanation.smallest = smallest;
        explanation.lift = lift(&explanation);
        let (remedies, sizes) = remedy::remedies(&self.scenario, &explanation, &self.baseline);
        (explanation.remedies, explanation.sizes) = (remedies, sizes);
        explanation.verdict = sentence(&explanation, &self.scenario) + &beside(&explanation);
        explanation
    }

    /// All sets of changes that cure, of the smallest size possible. `singles` are the trials of single
    /// changes.
    fn smallest(&self, singles: &[Trial]) -> Vec<Vec<Counterfactual>> {
        let cures = |trials: Vec<Trial>| -> Vec<Vec<Counterfactual>> {
            trials.into_iter().filter(|trial| trial.cured).map(|trial| trial.changes).collect()
        };
        let applied: Vec<Trial> = singles.iter().filter(|trial| trial.applies).cloned().collect();
        let useful: Vec<Counterfactual> = applied.iter().map(|trial| trial.changes[0]).collect();
        let mut smallest = cures(applied);
        for size in 2..=LARGEST_SET {
            if !smallest.is_empty() {
                break;
            }
            let sets = combinations(&useful, size);
            smallest = cures(sets.par_iter().map(|set| self.trial(set, false)).collect());
        }
        smallest
    }

    /// The trial of a set. If it has several changes, also the trials with one of them omitted.
    fn contributions(&self, chosen: &[Counterfactual]) -> Vec<Trial> {
        let mut sets = vec![chosen.to_vec()];
        if chosen.len() > 1 {
            sets.extend((0..chosen.len()).map(|left_out| {
                let mut set = chosen.to_vec();
                set.remove(left_out);
                set
            }));
        }
        sets.par_iter().map(|set| self.trial(set, true)).collect()
    }

    fn trial(&self, changes: &[Counterfactual], with_theory: bool) -> Trial {
        let changed =
            changes.iter().fold(self.scenario.clone(), |scenario, change| change.applied(&scenario));
        if changed == self.scenario {
            return trial_of(&self.scenario, changes, false, &Ok(self.baseline.clone()), None);
        }
        if !changes.contains(&Counterfactual::SlowerApproach) {
            return self.trial_with(changes, &changed, with_theory);
        }
        let first = self.trial_with(changes, &arriving_later(&changed, &self.baseline, SLOWER), with_theory);
        if changes.len() > 1 || first.cured {
            return first;
        }
        let affordable = |times: &&f64| affords(**times, &self.scenario, &self.baseline);
        let mut slower = SLOWER_STILL.iter().filter(affordable).map(|&times| {
            let mut slower = self.scenario.clone();
            slow_down(&mut slower, times);
            self.trial_with(changes, &arriving_later(&slower, &self.baseline, times), with_theory)
        });
        slower.find(|trial| trial.cured).unwrap_or(first)
    }

    fn trial_with(&self, changes: &[Counterfactual], changed: &Scenario, with_theory: bool) -> Trial {
        let set_off_otherwise =
            changes.contains(&Counterfactual::SlowerApproach) || changes.contains(&Counterfactual::NoNoise);
        let margin = if with_theory || set_off_otherwise { linear::gain_margin(changed) } else { None };
        let result = PreparedRun::new(changed.clone()).and_then(|candidate| candidate.measure(0));
        (self.progress)(self.runs.fetch_add(1, Ordering::Relaxed) + 1);
        let trial = trial_of(&self.scenario, changes, true, &result, margin);
        // The speed of arrival and noise do not change the loop in contact. So an unstable loop has only not
        // begun to grow yet.
        let only_later = set_off_otherwise && margin.is_some_and(|margin| margin < 1.0);
        // Loss of contact bounds the growth, but does not cause it.
        let lasts = |outcome: Outcome| matches!(outcome, Outcome::Unstable | Outcome::Chatter);
        let grows = trial.outcome.is_some_and(lasts) && lasts(self.baseline.summary.outcome);
        let only_by_period = grows
            && changes.contains(&Counterfactual::ContinuousController)
            && linear::grows_only_by_period(&self.scenario, changed);
        let by_chance = is_noisy(changed) && self.oscillates_in_noise() && self.is_as_large(&result);
        let cured = trial.cured && !only_later && !by_chance;
        Trial { cured: cured || only_by_period, only_by_period, ..trial }
    }

    /// Whether the scenario oscillates in contact with noise.
    fn oscillates_in_noise(&self) -> bool {
        is_noisy(&self.scenario) && self.baseline.summary.outcome == Outcome::Oscillates
    }

    /// Whether a run has an amplitude similar to that of the scenario.
    fn is_as_large(&self, result: &Result<Measured, RunError>) -> bool {
        let size =
            |measured: &Measured| measured.summary.verdict.amplitudes_n.into_iter().fold(0.0, f64::max);
        result.as_ref().is_ok_and(|measured| size(measured) > LEFT_BY_CURE * size(&self.baseline))
    }
}

fn is_noisy(scenario: &Scenario) -> bool {
    scenario.machine.sensors.values().any(|sensor| sensor.noise > 0.0)
}

fn trial_of(
    scenario: &Scenario,
    changes: &[Counterfactual],
    applies: bool,
    result: &Result<Measured, RunError>,
    gain_margin: Option<f64>,
) -> Trial {
    let measured = result.as_ref().ok();
    let oscillation = measured.and_then(|measured| measured.summary.oscillation);
    let grows = measured.filter(|measured| measured.summary.outcome == Outcome::Unstable);
    Trial {
        changes: changes.to_vec(),
        applies,
        outcome: measured.map(|measured| measured.summary.outcome),
        cured: measured.is_some_and(|measured| is_cured(scenario, measured)),
        only_by_period: false,
        amplitude_n: oscillation
            .map(|o| o.amplitude_n)
            .or(grows.map(|measured| measured.summary.verdict.amplitudes_n[2])),
        controlled: measured.and_then(|measured| measured.summary.controlled.clone()),
        frequency_hz: oscillation.map(|o| o.frequency_hz),
        gain_margin: gain_margin.filter(|margin| margin.is_finite()),
        error: result.as_ref().err().map(ToString::to_string),
    }
}

fn combinations(changes: &[Counterfactual], size: usize) -> Vec<Vec<Counterfactual>> {
    let Some((first, rest)) = changes.split_first() else {
        return if size == 0 { vec![Vec::new()] } else { Vec::new() };
    };
    if size == 0 {
        return vec![Vec::new()];
    }
    let with =
        combinations(rest, size - 1).into_iter().map(|set| std::iter::once(*first).chain(set).collect());
    with.chain(combinations(rest, size)).collect()
}

/// Weight of a change as evidence for its cause. The documentation of the module has the rules.
fn weight(change: Counterfactual, found: &Explanation) -> f64 {
    let linear_stable = found.linear_stable.unwrap_or(false);
    let own = |cause: ChatterCause| match cause {
        ChatterCause::NumericalArtefact => 100.0,
        ChatterCause::SensorNoise
            if found.baseline.outcome == Some(Outcome::Oscillates) && found.linear_stable != Some(false) =>
        {
            60.0
        }
        // Noise may only trigger a motion that another property sustains.
        ChatterCause::SensorNoise => 10.0,
        ChatterCause::StictionOrQuantiser | ChatterCause::FreePlay => 50.0,
        ChatterCause::Saturation => 40.0,
        ChatterCause::LossOfContact => 20.0,
        _ => 0.0,
    };
    let base = own(change.cause());
    if base > 0.0 {
        // A cure by the approach shows only that an impact triggered the chatter.
        return if change == Counterfactual::SlowerApproach { base - 5.0 } else { base };
    }
    let before = found.gain_margin.unwrap_or(f64::INFINITY);
    let trial = found.singles.iter().find(|trial| trial.changes == [change]);
    let after = trial.and_then(|trial| trial.gain_margin).unwrap_or(if trial.is_some_and(|t| t.cured) {
        f64::INFINITY
    } else {
        before
    });
    let gain = if before > 0.0 { (after / before).clamp(1e-3, 1e3).log10() } else { 0.0 };
    // The weight of a linear cause is the rise of the limit without it. In a stable loop linear causes come
    // last.
    gain + if linear_stable { 0.0 } else { 30.0 }
}

/// The change that raises the limit of the loop's gain most, if it raises it by more than `LIFTS`.
fn lift(found: &Explanation) -> Option<Lift> {
    let from = found.gain_margin.filter(|margin| *margin > 0.0)?;
    // Without a gain margin, the limit is unbounded if the change is a cure. Else it is unknown and counts as
    // zero.
    let to = |trial: &Trial| trial.gain_margin.or(trial.cured.then_some(f64::INFINITY)).unwrap_or(0.0);
    let of_loop = |trial: &&Trial| trial.applies && trial.changes != [Counterfactual::BilateralContact];
    let best = found.singles.iter().filter(of_loop).max_by(|a, b| to(a).total_cmp(&to(b)))?;
    let is_chosen = found.smallest.first().is_some_and(|chosen| *chosen == best.changes);
    let to = best.gain_margin;
    (to.is_none_or(|to| to > LIFTS * from) && best.cured && !is_chosen).then(|| Lift {
        change: best.changes[0],
        from,
        to,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_combinations_are_counted() {
        assert_eq!(combinations(&Counterfactual::ALL, 1).len(), 15);
        assert_eq!(combinations(&Counterfactual::ALL, 2).len(), 105);
        assert_eq!(combinations(&Counterfactual::ALL, 3).len(), 455);
    }
}
