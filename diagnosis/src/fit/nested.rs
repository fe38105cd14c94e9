//! A model that contains another must not fit worse. Where an optimiser has stopped early it would, and the
//! comparison would be the optimiser's.

use crate::fit::least_squares::{Fitted, Task};
use crate::fit::scored::Scored;
use crate::kinds::{contains, embed, nearest};

/// Cost by which a containing model may lag: the difference of two converged fits of the same machine.
const SLACK: f64 = 0.5;

/// Refits every model that fits worse than one that it contains, from that one's solution. All share the
/// causes but the last.
pub(crate) fn enforce(
    task: &Task<'_>,
    fits: &mut [Scored],
    steps: usize,
    rescore: impl Fn(&Scored, Fitted) -> Scored,
) {
    for outer in 0..fits.len() {
        for inner in 0..fits.len() {
            let (Some(big), Some(small)) = (fits[outer].causes.last(), fits[inner].causes.last()) else {
                continue;
            };
            if big.site != small.site || fits[outer].fitted.cost <= fits[inner].fitted.cost + SLACK {
                continue;
            }
            let last = fits[inner].causes.len() - 1;
            let values = fits[inner].fitted.model.parameters(last, &fits[inner].fitted.theta);
            let Some(values) = embed(big.definition.kind, small.definition.kind, &values) else { continue };
            let (base, _) = fits[inner].fitted.model.without(last);
            let model = base.with(big.site, big.definition, &values);
            let mut start = model.start();
            model.take_over(&mut start, &fits[inner].fitted.model, &fits[inner].fitted.theta, last);
            let fitted = task.fit(&model, &start, steps);
            if fitted.cost < fits[outer].fitted.cost {
                fits[outer] = rescore(&fits[outer], fitted);
            }
        }
    }
}

/// Fits every law that a fitted one contains also from where that one ended. A simple law may have stopped
/// far from its best, and would then seem to explain less than it does. `others` are those left after a few
/// steps; what gains moves from there to `fits`.
pub(crate) fn lower(
    task: &Task<'_>,
    fits: &mut Vec<Scored>,
    others: &mut Vec<Scored>,
    steps: usize,
    rescore: impl Fn(&Scored, Fitted) -> Scored,
) {
    let outers: Vec<Scored> = fits.clone();
    for outer in &outers {
        let Some(big) = outer.causes.last() else { continue };
        let last = outer.causes.len() - 1;
        let values = outer.fitted.model.parameters(last, &outer.fitted.theta);
        let (base, _) = outer.fitted.model.without(last);
        let inners: Vec<Scored> = fits.iter().chain(others.iter()).cloned().collect();
        for inner in inners {
            let Some(small) = inner.causes.last().filter(|small| small.site == big.site) else { continue };
            let from = nearest(big.definition.kind, small.definition.kind, &values);
            let begin = |values: &Vec<f64>| {
                let model = base.with(small.site, small.definition, values);
                let mut start = model.start();
                model.take_over(&mut start, &outer.fitted.model, &outer.fitted.theta, last);
                (task.cost(&model, &start), model, start)
            };
            let best = from.iter().map(begin).min_by(|a, b| a.0.total_cmp(&b.0));
            // An inner law that starts above where it ended has stopped well. One that the outer law only
            // resembles must first leave the believed values that this one has fitted.
            let is_inner = contains(big.definition.kind, small.definition.kind);
            let Some((_, model, start)) = best.filter(|(cost, ..)| !is_inner || *cost < inner.fitted.cost)
            else {
                continue;
            };
            let fitted = task.fit(&model, &start, steps);
            if fitted.cost + SLACK < inner.fitted.cost {
                let better = rescore(&inner, fitted);
                let is_it = |other: &Scored| other.causes.last().is_some_and(|cause| cause.is(small));
                others.retain(|other| !is_it(other));
                fits.retain(|other| !is_it(other));
                fits.push(better);
            }
        }
    }
}
