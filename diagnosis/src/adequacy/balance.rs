//! Checks an answer against the balance of forces, if one counts. A further smooth force may balance clearly
//! better, or other causes may balance as well.

use rayon::prelude::*;

use super::criteria::Criteria;
use super::horizons::share;
use crate::budget::Stage;
use crate::fit::candidates::{Candidate, candidates};
use crate::fit::scored::{Scored, distinct};
use crate::inverse::{Family, Smooth};
use crate::judge::{Asked, Judge};
use crate::kinds::dossier;

/// Largest number of rival sets that are named.
const MOST_NAMED: usize = 2;

/// Balances that differ by less than this are equal but for rounding and for the search of reversals, nats.
const SAME_NATS: f64 = 0.1;

/// The smooth force beyond the accepted causes, if it is large enough to matter.
pub(super) fn beyond(judge: &Judge<'_>, accepted: &Scored, criteria: &Criteria) -> Option<Smooth> {
    let inverse = judge.search.task.inverse.as_ref().filter(|_| judge.weight > 0.0)?;
    let found = inverse.beyond(&accepted.causes);
    // Drag, a lag or a delay resembles a drive whose force falls with speed.
    let is_other = |smooth: &Smooth| {
        let causes = || with_one_more(judge, &accepted.causes, |_| true);
        let own = || inverse.evidence(&accepted.causes).unwrap_or(f64::INFINITY);
        !matches!(smooth.family, Family::Fading { .. })
            || own() + smooth.evidence() > causes() + criteria.rival_nats
    };
    let found = found.into_iter().filter(|smooth| matters(smooth, criteria) && is_other(smooth));
    found.max_by(|a, b| a.nats.total_cmp(&b.nats))
}

/// Whether a smooth force is large enough to count; see [`Criteria::smooth_nats`].
fn matters(smooth: &Smooth, criteria: &Criteria) -> bool {
    smooth.share > criteria.smooth_share
        && smooth.nats > criteria.smooth_nats
        && smooth.left * smooth.share.max(0.0).sqrt() > criteria.smooth_force
}

/// The largest evidence of some causes with one more of the library in the balance of forces, nats.
fn with_one_more(judge: &Judge<'_>, causes: &[Candidate], is_asked: impl Fn(&Candidate) -> bool) -> f64 {
    let Some(inverse) = &judge.search.task.inverse else { return f64::NEG_INFINITY };
    let mut all = candidates(&judge.dataset.machine);
    all.retain(|cause| is_asked(cause) && !cause.is_covered_by(causes));
    let evidence = |cause: Candidate| inverse.evidence(&[causes, &[cause]].concat());
    let found = all.into_par_iter().filter_map(evidence);
    found.max_by(f64::total_cmp).unwrap_or(f64::NEG_INFINITY)
}

/// A smooth force instead of accepted causes elsewhere. It balances the forces better, or only as well.
pub(super) struct Replacing {
    pub(super) smooth: Smooth,
    pub(super) is_better: bool,
}

/// The smooth force that balances the check experiments best instead of accepted causes elsewhere, if it
/// balances them as well as these. `beyond` is the one in addition to them.
pub(super) fn instead(
    judge: &Judge<'_>,
    accepted: &Scored,
    beyond: Option<Smooth>,
    criteria: &Criteria,
) -> Option<Replacing> {
    let task = &judge.search.task;
    let is_late = task.budget.is_over(Stage::Compose);
    let inverse = task.inverse.as_ref().filter(|_| judge.weight > 0.0 && !is_late)?;
    let found = inverse.instead(&accepted.causes).into_iter();
    let found = found.filter(|instead| matters(&instead.smooth, criteria));
    let best = found.max_by(|a, b| a.gain.total_cmp(&b.gain))?;
    if best.gain < -criteria.rival_nats {
        return None;
    }
    let place = best.smooth.family.place();
    let is_missing = beyond.is_some_and(|beyond| beyond.family.place() == place);
    // The library may have a cause there that balances as well.
    let own = inverse.evidence(&accepted.causes)?;
    let is_unknown = || {
        own + best.gain > with_one_more(judge, &best.kept, |cause| cause.place == place) + criteria.rival_nats
    };
    let is_better = (is_missing || best.gain > criteria.further_nats) && is_unknown();
    Some(Replacing { smooth: best.smooth, is_better })
}

/// Describes a smooth force instead of causes at other places.
pub(super) fn replacing(Replacing { smooth, is_better }: &Replacing) -> String {
    let how = if *is_better { "better than" } else { "as well as" };
    format!(
        "a smooth force at the {}, {}, balances the forces {how} the causes elsewhere",
        smooth.family.place().name(),
        smooth.family.told()
    )
}

/// Ratio of the missing force to the drive force, after calibration and with the accepted causes. `None` if
/// the balance does not show all of them.
pub(super) fn missing(judge: &Judge<'_>, accepted: &Scored) -> Option<[f64; 2]> {
    let inverse = judge.search.task.inverse.as_ref().filter(|_| judge.weight > 0.0)?;
    inverse.missing(&accepted.causes)
}

/// Whether the accepted causes balance the forces except for a small share.
pub(super) fn is_small(missing: Option<[f64; 2]>, criteria: &Criteria) -> bool {
    missing.is_some_and(|[_, left]| left < criteria.small_force)
}

/// Describes a smooth force.
pub(super) fn told(smooth: Smooth) -> String {
    format!(
        "a further smooth force at the {}, {}, would remove {} of the variance that these causes leave in \
         the balance of forces",
        smooth.family.place().name(),
        smooth.family.told(),
        share(smooth.share)
    )
}

/// Other sets of causes that balance the check experiments as well or better, the best first. They have no
/// more causes than the accepted set and do not consist of accepted ones only. Sets whose balances agree to
/// machine precision count as equal, even if their fits differ. Example: if damping and friction are hardly
/// known, an added mass balances the forces as well as a gain.
pub(crate) fn as_good<'b>(
    judge: &Judge<'_>,
    accepted: &Scored,
    tried: &'b [Scored],
    criteria: &Criteria,
) -> Vec<&'b Scored> {
    let Some(own) = accepted.balanced.as_ref().filter(|_| !accepted.causes.is_empty()) else {
        return Vec::new();
    };
    let simple = accepted.fitted.model.effect_parameters();
    let is_other = |rival: &&Scored| {
        let is_within = |cause| accepted.causes.iter().any(|own| own.is(cause));
        rival.causes.len() <= accepted.causes.len()
            && rival.fitted.model.effect_parameters() <= simple
            && !rival.causes.iter().all(is_within)
    };
    let nats = |rival: &Scored| rival.balanced.as_ref().map_or(f64::NEG_INFINITY, |balanced| balanced.nats);
    let is_same =
        |rival: &Scored| own.nats > criteria.further_nats && (nats(rival) - own.nats).abs() < SAME_NATS;
    let is_as_good = |rival: &Scored| {
        judge.weight > 0.0
            && nats(rival) > own.nats - criteria.rival_nats
            && judge.is_finding(rival)
            && judge.is_meant(rival)
    };
    let mut found: Vec<&Scored> =
        tried.iter().filter(is_other).filter(|rival| is_same(rival) || is_as_good(rival)).collect();
    found.sort_by(|a, b| nats(b).total_cmp(&nats(a)));
    let mut named = distinct(found);
    named.truncate(MOST_NAMED);
    named
}

/// Describes the best set with one cause more than the accepted ones that is in doubt. It gains clearly, but
/// too little to be accepted. Or it gains enough, but with implausible values. Or it gains clearly with a
/// delay that the unknown timing of commands may hide.
pub(crate) fn further(
    judge: &Judge<'_>,
    accepted: &Scored,
    tried: &[&Scored],
    most: &Criteria,
) -> Vec<String> {
    let is_more = |more: &&&Scored| {
        let has = |own: &Candidate| more.causes.iter().any(|cause| cause.is(own));
        more.causes.len() == accepted.causes.len() + 1 && accepted.causes.iter().all(has)
    };
    let brings =
        |more: &Scored| [judge.check(accepted, more), judge.gain(accepted, more, &judge.everything())];
    let asked = Asked::beside(accepted);
    let added = |more: &Scored| more.beyond(accepted).first().map(|(_, cause)| **cause);
    let is_late = |more: &Scored| added(more).is_some_and(|cause| dossier(cause.definition.kind).is_late());
    let enough = |more: &&&Scored| {
        let [check, all] = brings(more);
        let is_clear = || judge.weight > 0.0 && check > most.further_nats && all > 2.0 * most.further_nats;
        let is_enough = || check >= asked.check && all >= asked.all;
        let is_named = judge.is_finding(more) || is_late(more);
        is_named && if judge.is_meant(more) { is_clear() } else { is_enough() }
    };
    if accepted.causes.is_empty() {
        return Vec::new();
    }
    let best =
        tried.iter().filter(is_more).filter(enough).max_by(|a, b| brings(a)[1].total_cmp(&brings(b)[1]));
    let said = best.and_then(|more| {
        let cause = added(more)?;
        let name = cause.named();
        let but = if !judge.is_finding(more) {
            "is as short as the unknown timing of commands (state `hold`)"
        } else if judge.is_meant(more) {
            "too little to be accepted"
        } else {
            "with values that cannot be meant"
        };
        Some(format!("a further {name} would explain more, but {but}"))
    });
    said.into_iter().collect()
}

pub(super) fn named(rivals: &[&Scored]) -> Vec<String> {
    let kinds = |rival: &Scored| rival.causes.iter().map(Candidate::named).collect::<Vec<_>>().join(" with ");
    rivals.iter().map(|rival| format!("{} balances the forces as well", kinds(rival))).collect()
}
