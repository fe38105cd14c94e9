//! A model that contains another must not fit worse. Where an optimiser has stopped early it would, and the
//! comparison would be the optimiser's.

use crate::fit::least_squares::{Fitted, Task};
use crate::fit::search::Scored;

/// Cost by which a containing model may lag: what two converged fits of the same machine differ by.
const SLACK: f64 = 0.5;
/// Speed over which a Stribeck law falls when it starts as Coulomb's, m/s.
const STRIBECK_SPEED_M_PER_S: f64 = 0.01;

/// Parameters with which the law `outer` is the law `inner` with parameters `values`; none where it does not
/// contain it.
fn embed(outer: &str, inner: &str, values: &[f64]) -> Option<Vec<f64>> {
    match (outer, inner) {
        ("asymmetric-friction", "coulomb-friction") => Some(vec![values[0], 0.0]),
        ("stribeck-friction", "coulomb-friction") => Some(vec![values[0], values[0], STRIBECK_SPEED_M_PER_S]),
        ("hertz-contact", "contact-stiffness") => Some(vec![1.0, values[0]]),
        _ => None,
    }
}

/// Whether the law `outer` contains the law `inner`.
pub(crate) fn contains(outer: &str, inner: &str) -> bool {
    embed(outer, inner, &[1.0]).is_some()
}

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
