//! Checks an answer against all conditions.

use super::criteria::Criteria;
use super::tolerance::Doubted;
use super::{
    Adequacy, Condition, Shortfall, ahead, balance, held, horizons, plausible, residual, rivals, tolerance,
};
use crate::fit::scored::Scored;
use crate::judge::Judge;

/// Errors of an answer that the conditions use.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sizes {
    /// Error of predictions that the noise of all channels alone leaves, over each channel's variation.
    pub(crate) floor: f64,
    /// Share of the error beyond `floor` that the accepted causes remove; `None` if the error with
    /// the accepted causes is hardly above the floor.
    pub(crate) closed: Option<f64>,
    /// Upper end of the 90 % interval of that share; `None` if the error of calibration alone is hardly above
    /// the floor.
    pub(crate) most_closed: Option<f64>,
    /// Force missing on the check experiments after calibration and with the accepted effects, beyond the
    /// part due to noise, N.
    pub(crate) missing_force_n: [f64; 2],
}

/// Checks an answer against all conditions. `rivals` are the causes that were compared with the accepted
/// ones, `balanced` those that balance the forces as well.
pub(crate) fn assess(
    judge: &Judge<'_>,
    accepted: &Scored,
    rivals: &[Scored],
    balanced: &[&Scored],
    sizes: Sizes,
) -> Adequacy {
    let criteria = Criteria::default();
    let task = &judge.search.task;
    let calibrated = &judge.search.calibrated;
    let checks = judge.checks();
    let horizons = ahead::horizons(task, calibrated, accepted, &checks, sizes.floor);
    let residual = residual::of(task, accepted, &checks, &criteria);
    let mut shortfalls = Vec::new();
    let mut short = |condition: Condition, found: Vec<String>| {
        shortfalls.extend(found.into_iter().map(|what| Shortfall { condition, what }));
    };
    let missing = sizes.missing_force_n;
    let is_found = !accepted.causes.is_empty();
    // If the balance of forces counts, its missing force excludes the noise of the command.
    let shares = balance::missing(judge, accepted);
    let is_balanced = balance::is_small(shares, &criteria);
    let missing = shares.map_or(missing, |shares| shares.map(|share| share * residual.drive_force_n));
    let is_noise = !is_found && residual.is_noise(&criteria) && horizons::are_fair(&horizons, &criteria);
    let missing = if is_noise { [0.0; 2] } else { missing };
    if !is_found {
        let limits = accepted.fitted.model.at_limits(&accepted.fitted.theta).len();
        short(Condition::Left, horizons::beyond_noise(&horizons, limits, &criteria).into_iter().collect());
    }
    short(
        Condition::Left,
        horizons::left(&horizons, missing, residual.drive_force_n, [is_found, is_balanced], &criteria),
    );
    if task.dataset.machine.contacts.is_empty() {
        short(Condition::Left, horizons::lost(&horizons, &criteria).into_iter().collect());
    }
    let unclosed = sizes.closed.filter(|_| is_found);
    let unclosed = unclosed.and_then(|closed| horizons::unclosed(closed, &criteria));
    let removes_little = unclosed.is_some();
    short(Condition::Left, unclosed.filter(|_| !is_balanced).into_iter().collect());
    short(Condition::Residual, residual.shortfalls(missing[0], &criteria));
    let smooth = balance::beyond(judge, accepted, &criteria);
    short(Condition::Residual, smooth.map(balance::told).into_iter().collect());
    let instead = balance::instead(judge, accepted, smooth, &criteria);
    let is_replaced = instead.as_ref().is_some_and(|instead| instead.is_better);
    let against = if is_replaced { Condition::Residual } else { Condition::Rivals };
    short(against, instead.iter().map(balance::replacing).collect());
    short(Condition::Rivals, balance::named(balanced));
    let doubts = tolerance::limits(task.dataset, accepted);
    short(Condition::Tolerance, doubts.iter().map(|doubt| doubt.what.clone()).collect());
    if is_found {
        let partly = sizes.most_closed.and_then(|most| horizons::partly_closed(most, &criteria));
        short(Condition::Rivals, partly.into_iter().collect());
        for (is_little, what) in horizons::worsened(&horizons, &criteria) {
            short(if is_little { Condition::Far } else { Condition::Horizons }, vec![what]);
        }
        let free_run = horizons.iter().find(|horizon| horizon.seconds.is_none());
        let strayed = held::strayed(task.dataset, free_run.and_then(|horizon| horizon.after));
        short(Condition::Horizons, strayed.into_iter().collect());
        short(Condition::Rivals, residual::untested(&residual.traces).into_iter().collect());
        short(Condition::Plausible, plausible::doubts(judge, accepted, &criteria));
        short(Condition::Rivals, rivals::shaped(accepted).into_iter().collect());
        let stroke_m = judge.search.seen.stroke_m();
        let series = rivals::over_position(accepted, stroke_m).filter(|_| task.dataset.drives.len() == 1);
        short(Condition::Rivals, series.into_iter().collect());
        short(Condition::Rivals, rivals::rounded(judge, accepted));
        short(Condition::Rivals, rivals::as_good(judge, accepted, rivals, &horizons, &criteria));
    }
    // A smooth force shows the place of an error that no cause removes. Causes that remove most of it show
    // the place themselves, unless a smooth force elsewhere balances better.
    let smooth = match (is_found, removes_little) {
        _ if is_replaced => instead.map(|instead| instead.smooth),
        (false, _) => smooth,
        (true, true) => balance::beyond(judge, calibrated, &criteria).or(smooth),
        (true, false) => None,
    };
    Adequacy {
        criteria,
        horizons,
        drive_force_n: residual.drive_force_n,
        residual: residual.traces,
        shortfalls,
        doubts: doubts.into_iter().filter(|doubt| doubt.about != Doubted::Early).collect(),
        smooth: smooth.map(|smooth| smooth.family.place()),
        is_replaced,
        is_balanced,
        is_noise,
    }
}
