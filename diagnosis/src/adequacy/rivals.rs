//! Tests whether a cause at another place predicts the check experiments as well, or better at longer
//! horizons.

use feeler_plant::effects::{ForceRipple, Gravity, Kind, Parameters};

use super::ahead::error;
use super::criteria::Criteria;
use super::horizons::{Horizon, share};
use crate::fit::candidates::Candidate;
use crate::fit::least_squares::Fitted;
use crate::fit::scored::Scored;
use crate::fit::wander::force_noise;
use crate::judge::Judge;
use crate::kinds::{Form, dossier};

/// Largest number of rivals whose longer predictions are compared.
const MOST_PREDICTED: usize = 4;
/// Ratio of a command's noise to the force at a corner of its law above which the corner is rounded.
const ROUNDS: f64 = 0.1;
/// With fewer periods within the stroke a ripple may stand for another force over position.
const FEW_PERIODS: f64 = 6.0;

fn form(cause: &Candidate) -> Option<Form> {
    dossier(cause.definition.kind).balance.map(|shown| shown.form)
}

/// Two causes that shape the force of one drive over its command, in words. Together they come close to any
/// such curve. On six seeds all five such answers hid an effect outside the library.
pub(super) fn shaped(accepted: &Scored) -> Option<String> {
    let shapes = |cause: &&Candidate| matches!(form(cause), Some(Form::Limit | Form::Deadband | Form::Gain));
    let mut shaping = accepted.causes.iter().filter(shapes);
    let (first, second) = (shaping.next()?, shaping.next()?);
    (first.site == second.site).then(|| {
        format!(
            "{} and {} together come close to any curve of a drive's force over its command, such as that of \
             a drive that sags",
            first.definition.kind, second.definition.kind
        )
    })
}

/// Gravity beside a ripple of few periods within the stroke, or beside a load if the stroke is less than half
/// a period of gravity, in words. Together they come close to any force over position. On six seeds all three
/// such answers hid the pull of a cable.
pub(super) fn over_position(accepted: &Scored, stroke_m: f64) -> Option<String> {
    let place = |kind: Kind| accepted.causes.iter().position(|cause| cause.definition.kind == kind);
    let gravity = place(Kind::Gravity)?;
    let ripple = place(Kind::ForceRipple).filter(|&ripple| {
        let ForceRipple { pitch, harmonic, .. } = ForceRipple::of(&accepted.values(ripple));
        stroke_m < FEW_PERIODS * pitch / harmonic
    });
    let is_part = || 2.0 * stroke_m < Gravity::of(&accepted.values(gravity)).period;
    let load = || place(Kind::ConstantLoad).filter(|_| is_part());
    let other = accepted.causes[ripple.or_else(load)?].definition.kind;
    Some(format!(
        "{} and {other} together come close to any force over position, such as the pull of a cable",
        Kind::Gravity
    ))
}

/// Gains and masses beside a limit or a dead band whose corners the noise of the measured command rounds, in
/// words. Near a corner the mean force is not the force of the mean command. A gain or a mass makes up for
/// part of the difference (errors in variables: Fuller, Measurement Error Models, 1987).
pub(super) fn rounded(judge: &Judge<'_>, accepted: &Scored) -> Vec<String> {
    let noises = judge.everything().into_iter().map(|r| force_noise(judge.dataset, r));
    let noise = noises.fold(0.0, f64::max);
    let Fitted { model, theta, .. } = &accepted.fitted;
    let over_corner = |(i, cause): (usize, &Candidate)| match form(cause)? {
        Form::Limit | Form::Deadband => Some((cause.definition.kind, noise / model.parameters(i, theta)[0])),
        _ => None,
    };
    let corners = accepted.causes.iter().enumerate().filter_map(over_corner);
    let mut corners = corners.filter(|(_, over)| *over > ROUNDS);
    let Some((corner, over)) = corners.next() else { return Vec::new() };
    let factors = accepted.causes.iter().filter(|cause| matches!(form(cause), Some(Form::Gain | Form::Mass)));
    let say = |cause: &Candidate| {
        format!(
            "the noise of the command, {} of the {corner}, rounds its corners: {} may only make up for that",
            share(over),
            cause.definition.kind
        )
    };
    factors.map(say).collect()
}

/// Rivals of another place that predict the check experiments as well, or better at longer horizons, in
/// words.
pub(super) fn as_good(
    judge: &Judge<'_>,
    accepted: &Scored,
    rivals: &[Scored],
    horizons: &[Horizon],
    criteria: &Criteria,
) -> Vec<String> {
    let elsewhere: Vec<(&Scored, Kind, &str)> = rivals
        .iter()
        .filter(|rival| rival.causes.len() == accepted.causes.len())
        .filter_map(|rival| {
            let [mine, theirs] = [accepted.beyond(rival), rival.beyond(accepted)];
            let [(_, mine), (_, theirs)] = [mine.last()?, theirs.last()?];
            (theirs.place != mine.place).then(|| (rival, theirs.definition.kind, theirs.place.name()))
        })
        .collect();
    let simple = accepted.fitted.model.effect_parameters();
    let mut found = Vec::new();
    for (rival, kind, place) in elsewhere.iter().take(MOST_PREDICTED) {
        let is_simple = rival.fitted.model.effect_parameters() <= simple;
        if is_simple && judge.check(rival, accepted) < criteria.rival_nats {
            found.push(format!("{kind} at the {place} predicts the check experiments as well"));
            continue;
        }
        let ahead = horizons.iter().skip(1).find_map(|horizon| {
            let own = horizon.after.filter(|own| {
                *own < criteria.lost && horizon.beyond(*own) > criteria.most_floors * horizon.floor
            })?;
            let task = &judge.search.task;
            let other = error(task, &rival.fitted, &rival.fitted.theta, &judge.checks(), horizon.seconds)?;
            (other < criteria.rival_share * own).then(|| horizon.name())
        });
        if let Some(horizon) = ahead {
            found.push(format!("{kind} at the {place} predicts better over {horizon}"));
        }
    }
    found
}

/// Sets with as many causes, one of them at another place, that explain as much with a value too small to be
/// a finding, in words. If a small true cause lies within a tolerance, the fit may find another cause in its
/// place.
pub(crate) fn as_good_but_small(
    judge: &Judge<'_>,
    accepted: &Scored,
    tried: &[&Scored],
    criteria: &Criteria,
) -> Vec<String> {
    let simple = accepted.fitted.model.effect_parameters();
    let elsewhere = |rival: &&Scored| {
        let [mine, theirs] = [accepted.beyond(rival), rival.beyond(accepted)];
        let [(_, mine), (_, theirs)] = [mine.last()?, theirs.last()?];
        (theirs.place != mine.place).then(|| theirs.named())
    };
    let does_as_well = |rival: &&&Scored| {
        rival.causes.len() == accepted.causes.len()
            && rival.fitted.model.effect_parameters() <= simple
            && judge.check(rival, accepted) < criteria.rival_nats
            && judge.gain(rival, accepted, &judge.everything()) < criteria.rival_nats
            && !judge.is_finding(rival)
    };
    let mut found: Vec<String> = tried.iter().filter(does_as_well).filter_map(elsewhere).collect();
    found.sort_unstable();
    found.dedup();
    found.truncate(MOST_PREDICTED);
    let say = |name: String| format!("{name} explains as much, at a value too small to be a finding");
    found.into_iter().map(say).collect()
}

#[cfg(test)]
mod tests {
    use feeler_files::Document;
    use indexmap::IndexMap;

    use super::*;
    use crate::fit::candidates::candidates;
    use crate::fit::model::Model;

    const ARM: &str = "axis = \"rotational\"\n[bodies.arm]\nmass = 2.0\n[springs.guide]\n\
        between = [\"ground\", \"arm\"]\ndamping = 1.0\n[actuators.drive]\non = \"arm\"\n\
        kind = \"force\"\n";

    #[test]
    fn truth_gravity_beside_a_ripple_of_few_periods_or_a_load_is_no_sure_cause() {
        let machine = Document::parse(ARM, "arm.toml").unwrap().scenario.machine;
        let all = candidates(&machine);
        let with = |kinds: &[Kind]| {
            let causes: Vec<Candidate> = kinds
                .iter()
                .map(|kind| *all.iter().find(|cause| cause.definition.kind == *kind).unwrap())
                .collect();
            let model = Model::calibration(&machine, &IndexMap::new()).unwrap();
            let model = causes.iter().fold(model, |model, cause| {
                let typical = cause.definition.parameters.iter().map(|parameter| parameter.typical);
                model.with(cause.site, cause.definition, &typical.collect::<Vec<f64>>())
            });
            let theta = model.start();
            let sigma = vec![0.0; theta.len()];
            let fitted = Fitted { model, theta, cost: 0.0, sigma };
            Scored { causes, fitted, misfits: Vec::new(), balanced: None }
        };
        let both = with(&[Kind::Gravity, Kind::ForceRipple]);
        let ForceRipple { pitch: pitch_m, .. } = ForceRipple::of(&both.values(1));
        assert!(over_position(&both, 2.0 * pitch_m).is_some_and(|told| told.contains("cable")));
        assert_eq!(over_position(&both, 10.0 * pitch_m), None);
        assert_eq!(over_position(&with(&[Kind::ForceRipple]), 2.0 * pitch_m), None);
        // Offset, slope and curvature of a force over part of a turn. Over a whole turn gravity is a sine.
        let loaded = with(&[Kind::ConstantLoad, Kind::Gravity]);
        let turn = Gravity::of(&loaded.values(1)).period;
        assert!(over_position(&loaded, 0.4 * turn).is_some_and(|told| told.contains("cable")));
        assert_eq!(over_position(&loaded, 0.6 * turn), None);
        assert_eq!(over_position(&with(&[Kind::Gravity]), 0.4 * turn), None);
    }
}
