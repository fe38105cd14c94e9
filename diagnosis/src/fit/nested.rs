//! A model that contains another one must not fit worse. It does if its optimiser stopped early; the
//! comparison would then judge the optimiser.

use crate::fit::least_squares::{Fitted, Task};
use crate::fit::scored::Scored;
use crate::kinds::{contains, embed, nearest};

/// Largest cost by which a containing model may be worse: the difference between two converged fits of one
/// machine.
const SLACK: f64 = 0.5;

/// Refits every model that fits worse than a model that it contains, starting from that model's solution. All
/// models share their causes except the last. `others` holds laws after a few steps; they stay at that
/// solution.
pub(crate) fn enforce(
    task: &Task<'_>,
    fits: &mut [Scored],
    others: &mut [Scored],
    steps: usize,
    rescore: impl Fn(&Scored, Fitted) -> Scored,
) {
    let lifted = |outer: &Scored, inner: &Scored, steps: usize| {
        let (big, small) = (outer.causes.last()?, inner.causes.last()?);
        if big.site != small.site || outer.fitted.cost <= inner.fitted.cost + SLACK {
            return None;
        }
        let last = inner.causes.len() - 1;
        let values = embed(big.definition.kind, small.definition.kind, &inner.values(last))?;
        let (base, _) = inner.fitted.model.without(last);
        let model = base.with(big.site, big.definition, &values);
        let mut start = model.start();
        model.take_over(&mut start, &inner.fitted.model, &inner.fitted.theta, last);
        let fitted = task.fit(&model, &start, steps);
        (fitted.cost < outer.fitted.cost).then(|| rescore(outer, fitted))
    };
    for outer in 0..fits.len() {
        for inner in 0..fits.len() {
            if let Some(better) = lifted(&fits[outer], &fits[inner], steps) {
                fits[outer] = better;
            }
        }
    }
    for outer in others {
        for inner in &*fits {
            if let Some(better) = lifted(outer, inner, 0) {
                *outer = better;
            }
        }
    }
}

/// Refits every simpler law from the solution of a fitted law that contains it. The fit of a simpler law may
/// have stopped far from its optimum, so that it would explain too little. `others` holds laws after a few
/// steps; those that improve move to `fits`.
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
        let values = outer.values(last);
        let (base, _) = outer.fitted.model.without(last);
        let inners: Vec<Scored> = fits.iter().chain(others.iter()).cloned().collect();
        for inner in inners {
            let Some(small) = inner.causes.last().filter(|small| small.site == big.site) else { continue };
            let from = nearest(big.definition.kind, small.definition.kind, &values);
            // How bristles of the outer law bend is the presliding of the inner law.
            let begin = |values: &Vec<f64>| {
                let model = base.with(small.site, small.definition, values);
                let mut start = model.start();
                model.take_over(&mut start, &outer.fitted.model, &outer.fitted.theta, last);
                let starts = model.stiffer_after(&start, &outer.fitted);
                starts.into_iter().map(move |start| (model.clone(), start))
            };
            let begun =
                from.iter().flat_map(begin).map(|(model, start)| (task.cost(&model, &start), model, start));
            let best = begun.min_by(|a, b| a.0.total_cmp(&b.0));
            // If an inner law costs more at this start than its own fit, that fit is fine. A law that is only
            // similar to the outer one must be refitted first, because the outer fit changed believed values
            // too.
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
