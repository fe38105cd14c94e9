//! Errors if no gains meet a specification.

use feeler_plant::description::Axis;

use super::error::{TuneError, refused};
use super::simulated::Trouble;
use super::spec::Spec;
use super::theory::Figures;

/// The error if no gains meet the limits of theory.
pub(super) fn nothing_meets(spec: &Spec, nearest: Option<Figures>) -> TuneError {
    let asked: Vec<&str> = spec.limits_of(true).map(|limit| limit.of.name()).collect();
    let near = nearest.map_or_else(
        || "every loop tried is unstable".to_owned(),
        |figures| {
            let gain_db =
                figures.gain_margin.map_or("no end of".into(), |m| format!("{:.1} dB", 20.0 * m.log10()));
            let phase = figures.phase_margin_deg.map_or("any".into(), |phase| format!("{phase:.1} deg"));
            format!(
                "the nearest has a phase margin of {phase}, a gain margin of {gain_db} and a disk margin of \
                 {:.2}",
                figures.disk_margin
            )
        },
    );
    refused(
        format!("no gains meet --spec ({}): {near}", asked.join(", ")),
        "lower a limit, free more gains by `gains`, or add +lead, +filter or +notch",
    )
}

/// The error if gains meet the limits of theory, but no run does.
pub(super) fn nothing_settles(trouble: Option<Trouble>, spec: &Spec, axis: Axis) -> TuneError {
    match trouble {
        Some(Trouble::Misses(limit, value)) => refused(
            format!(
                "no gains meet --spec in simulation: the {} is {}, and {} is allowed",
                limit.of.name(),
                value.map_or("none".into(), |value| limit.of.with_unit(value, axis)),
                limit.of.with_unit(limit.bound, axis)
            ),
            if spec.gains.is_none() {
                "raise this limit, slow the approach (the impact counts too), or free more gains by `gains`"
            } else {
                "raise this limit, or slow the approach: the impact counts too"
            },
        ),
        Some(Trouble::Ends(outcome)) => refused(
            format!(
                "no gains that theory allows come to rest in simulation: the best ends as {}",
                outcome.name()
            ),
            "see `feeler why FILE` for the cause and its remedy",
        ),
        Some(Trouble::Near(what, trouble)) => {
            let ends = match *trouble {
                Trouble::Ends(outcome) => format!("ends as {}", outcome.name()),
                _ => "fails".to_owned(),
            };
            refused(
                format!("no gains that theory allows rest safely in simulation: with {what} the best {ends}"),
                "ask for more margin, or see `feeler why FILE` for what chatters",
            )
        }
        Some(Trouble::Fails(why)) => refused(format!("no run succeeds: {why}"), "see `feeler run FILE`"),
        None => refused("no gains were tried", "widen the limits on gains"),
    }
}
