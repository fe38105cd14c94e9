//! Tests whether every fitted value is a finding, and whether it is plausible. It must be possible for the
//! believed machine, not at a bound, and distinguishable from zero.

use feeler_plant::effects::{Parameter, Place, Scale, Trait};
use feeler_plant::units::Dimension;

use super::criteria::Criteria;
use super::horizons::share;
use crate::fit::candidates::Candidate;
use crate::fit::least_squares::Fitted;
use crate::fit::missing::moving_mass;
use crate::fit::scored::Scored;
use crate::judge::Judge;
use crate::kinds::{Element, dossier};
use crate::report::AttemptOutcome;

/// Smallest ratio of the part of an effect beyond a believed value's limit to the part within the limit.
const LEAST_REST: f64 = 0.1;
/// Larger ratios are not printed as numbers.
const MOST_TIMES: f64 = 1000.0;
/// A value this close to the end of its range, on its own scale, counts as being at the end.
const AT_END: f64 = 1e-3;
/// A value with a narrower range than this was read off the records, so that no residual determines it.
const READ_OFF: f64 = 0.01;
/// Deviation of a logarithm above which the 90 % interval of the value includes zero.
const UNKNOWN: f64 = 1.0 / 1.645;

/// Reasons why accepted values are not plausible, in words.
pub(super) fn doubts(judge: &Judge<'_>, accepted: &Scored, criteria: &Criteria) -> Vec<String> {
    let mut found = impossible(judge, accepted, criteria);
    found.extend(hardly_known(accepted));
    found
}

/// Values beyond what the believed machine and its records allow, in words.
fn impossible(judge: &Judge<'_>, accepted: &Scored, criteria: &Criteria) -> Vec<String> {
    let (model, theta) = (&accepted.fitted.model, &accepted.fitted.theta);
    let mut found = Vec::new();
    for (i, cause) in accepted.causes.iter().enumerate() {
        let values = model.parameters(i, theta);
        for (k, parameter) in cause.definition.parameters.iter().enumerate() {
            let name = format!("{} of {}", parameter.name, cause.definition.kind);
            found.extend(
                beyond(judge, cause, parameter, values[k], criteria).map(|limit| format!("{name} {limit}")),
            );
            let Some(u) = unknown(accepted, i, k) else { continue };
            let (low, high) = model.unknowns[u].bounds;
            if (theta[u] - low).min(high - theta[u]) < AT_END {
                found.push(format!("{name} is at the end of its possible range"));
            }
        }
    }
    found
}

/// Causes with a size that may be zero, in words. The first parameter is the size of the effect.
fn hardly_known(accepted: &Scored) -> impl Iterator<Item = String> {
    accepted.causes.iter().enumerate().filter_map(|(i, cause)| {
        let size = cause.definition.parameters.first().filter(|size| size.scale == Scale::Log)?;
        let is_hardly = accepted.fitted.sigma[unknown(accepted, i, 0)?] > UNKNOWN;
        let name = format!("{} of {}", size.name, cause.definition.kind);
        is_hardly.then(|| format!("the interval of {name} includes zero"))
    })
}

/// The unknown of parameter `k` of cause `i`; `None` if the parameter is not fitted.
fn unknown(accepted: &Scored, i: usize, k: usize) -> Option<usize> {
    let model = &accepted.fitted.model;
    let is_fitted = |u: &usize| {
        let (low, high) = model.unknowns[*u].bounds;
        high - low >= READ_OFF
    };
    model.unknown_of(i, k).filter(is_fitted)
}

impl Judge<'_> {
    pub(crate) fn is_finding(&self, scored: &Scored) -> bool {
        self.no_departure(scored).is_none()
    }

    /// Why the fitted values of a set do not depart from the believed machine; `None` if they do.
    pub(crate) fn no_departure(&self, scored: &Scored) -> Option<AttemptOutcome> {
        let Fitted { model, theta, .. } = &scored.fitted;
        scored.causes.iter().enumerate().find_map(|(i, cause)| {
            let element = Element::at(cause.site, &model.believed, &self.dataset.tolerance);
            let known = dossier(cause.definition.kind);
            let mut values = model.parameters(i, theta);
            // The part that the calibrated value took over belongs to the effect.
            let taken = known.adds_to.and_then(|key| model.excess(cause.site, key.name, theta));
            let is_rest = taken.is_some_and(|(excess, limit)| limit && values[0] < LEAST_REST * excess);
            values[0] += taken.map_or(0.0, |(excess, _)| excess);
            if model.is_believed(i, theta) {
                return Some(AttemptOutcome::WithinTolerance);
            }
            let late_rows = self.dataset.is_sampled_at(cause.site).then(|| model.leeway(theta).late_rows);
            let seen = self.search.seen.beside(late_rows);
            let is_trivial = |element: &Element<'_>| (known.is_trivial)(&values, element, seen);
            if !is_trivial(&element) {
                return is_rest.then_some(AttemptOutcome::NoEffect);
            }
            let is_small = is_trivial(&element.known_exactly());
            Some(if is_small { AttemptOutcome::NoEffect } else { AttemptOutcome::WithinTolerance })
        })
    }

    /// Whether every value of a set of causes is plausible.
    pub(crate) fn is_meant(&self, scored: &Scored) -> bool {
        doubts(self, scored, &Criteria::default()).is_empty()
    }

    /// Whether every value of a set of causes is possible. A cause may be absent.
    pub(crate) fn is_possible(&self, scored: &Scored) -> bool {
        impossible(self, scored, &Criteria::default()).is_empty()
    }
}

/// Why a value is larger or smaller than the believed machine and its records allow. Masses of a base or a
/// workpiece and readings of a sensor are not limited by the drive's body and command.
fn beyond(
    judge: &Judge<'_>,
    cause: &Candidate,
    parameter: &Parameter,
    value: f64,
    most: &Criteria,
) -> Option<String> {
    let is_along_drive = matches!(cause.place, Place::Drive | Place::Guide | Place::Transmission);
    let over = |value: f64, limit: f64, most: f64, what: &str| {
        let ratio = value.abs() / limit;
        let times = if ratio > MOST_TIMES { "over 1000".into() } else { format!("{ratio:.1}") };
        (value.is_finite() && limit > 0.0 && ratio > most).then(|| format!("is {times} times {what}"))
    };
    match parameter.dimension {
        Dimension::FORCE if is_along_drive && is_pushed(judge) => {
            let command = judge.search.seen.command_n;
            let is_nothing = value.abs() < most.least_force * command;
            let nothing =
                is_nothing.then(|| format!("is below {} of the largest command", share(most.least_force)));
            nothing.or_else(|| over(value, command, most.most_force, "the largest command"))
        }
        Dimension::MASS if is_along_drive => {
            let moved = moving_mass(judge.dataset, &judge.search.calibrated);
            over(value, moved, most.most_ratio, "the mass that moves")
        }
        Dimension::TIME if is_along_drive => {
            let row_s =
                judge.dataset.records.iter().map(|record| record.spacing_s).fold(f64::INFINITY, f64::min);
            (value.abs() < most.least_rows * row_s).then(|| format!("is {:.3} of a row", value.abs() / row_s))
        }
        // No machine has a negative gain: a sign is reversed.
        Dimension::NONE if cause.definition.has(Trait::LikeUnits) && value < 0.0 => {
            Some(format!("is {value:.3}: a sign is reversed"))
        }
        // Units of a firmware may be off by decades.
        Dimension::NONE if cause.definition.has(Trait::LikeUnits) => {
            let ratio = value.max(1.0 / value.max(f64::MIN_POSITIVE));
            (ratio > most.most_ratio).then(|| format!("is {value:.3}"))
        }
        _ => None,
    }
}

/// Whether the first command is a force.
fn is_pushed(judge: &Judge<'_>) -> bool {
    judge.dataset.drives.first().is_some_and(|driven| judge.dataset.is_forced(driven.drive))
}
