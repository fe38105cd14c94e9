//! The outcome of a run in plain words.

use feeler_engine::Scenario;
use feeler_plant::description::{Engagement, SignalName};
use feeler_problem::Problem;
use feeler_studies::Doubts;
use feeler_studies::run::{ContactSummary, Oscillation, Outcome, Summary};

use crate::numbers::{count, plain, with_unit};
use crate::units::Units;

/// Rates below this are given as a period.
const SLOW_HZ: f64 = 1.0;

/// One or two sentences on the outcome of a run.
pub(crate) fn outcome(summary: &Summary, units: Units) -> String {
    if let Some(signal) = &summary.controlled {
        return of_motion(summary, signal, judged_unit(Some(signal), units));
    }
    let reference = summary.response.and_then(|response| response.final_reference_n);
    let oscillation = summary.oscillation.unwrap_or_default();
    match summary.outcome {
        Outcome::Settled => format!(
            "The force settles{}: the tool touches and stays in contact.",
            at_and_within(summary, reference, units)
        ),
        Outcome::BouncesThenSettles => {
            format!(
                "The tool bounces {} and then settles{}.",
                times(summary.bounces),
                at_and_within(summary, reference, units)
            )
        }
        Outcome::Chatter => chatter(&oscillation),
        Outcome::Unstable if summary.bounces > 0 => match summary.verdict.growth_per_s {
            Some(rate) if rate > 0.0 => {
                format!(
                    "The motion is unstable: every bounce is harder than the last, by a factor of e every \
                     {}.",
                    with_unit(1.0 / rate, "s")
                )
            }
            _ => "The motion is unstable: it grows without bound.".to_owned(),
        },
        Outcome::Unstable => match summary.verdict.growth_per_s {
            Some(rate) if rate > 0.0 => {
                format!(
                    "The motion is unstable: its amplitude grows by a factor of e every {}.",
                    with_unit(1.0 / rate, "s")
                )
            }
            _ => "The motion is unstable: it grows without bound.".to_owned(),
        },
        Outcome::LimitCycle => format!(
            "The force oscillates between the drive's limits at {}, with an amplitude of {}, and does not \
             decay.",
            rate(oscillation.frequency_hz),
            with_unit(oscillation.amplitude_n, units.force)
        ),
        Outcome::Hunting => format!(
            "The axis hunts: it sticks and breaks loose at {}, and the force oscillates with an amplitude of \
             {}.",
            rate(oscillation.frequency_hz),
            with_unit(oscillation.amplitude_n, units.force)
        ),
        Outcome::Oscillates => format!(
            "The force oscillates in contact at {}, with an amplitude of {}, and does not decay.",
            rate(oscillation.frequency_hz),
            with_unit(oscillation.amplitude_n, units.force)
        ),
        Outcome::Driven if summary.response.is_none() => {
            "The drive follows its commands to the end of the run; nothing regulates the force.".to_owned()
        }
        Outcome::Driven => format!(
            "The reference moves until the end of the run, and the force follows it without loss of \
             contact{}.",
            follows(summary, units)
        ),
        Outcome::FollowsSurface => format!(
            "The surface moves to the end of the run, and contact is kept{}.",
            follows(summary, units)
        ),
        Outcome::NoContact if summary.bounces > 0 => {
            format!(
                "The tool touches, leaves after {} in contact, and does not return.",
                with_unit(summary.contact_time_s, "s")
            )
        }
        Outcome::NoContact if summary.contacts.is_empty() => {
            "Nothing can touch in this scenario; the axis moves freely.".to_owned()
        }
        Outcome::NoContact => "The tool does not touch the workpiece in this run.".to_owned(),
        Outcome::Undecided => format!("Undecided: {}.{}", lacks(summary), so_far(summary, units)),
    }
}

/// The tracking error of the force over the tail of the run, as the end of a sentence.
fn follows(summary: &Summary, units: Units) -> String {
    let found = summary.response.and_then(|response| response.tracking);
    found.map_or_else(String::new, |tracking| {
        format!(
            ": after {}, the force stays within {} of its reference",
            with_unit(summary.verdict.tail_s[0], "s"),
            with_unit(tracking.largest_error_n, units.force)
        )
    })
}

/// Largest and mean distance from the reference, of a force that follows.
pub(crate) fn tracking(summary: &Summary, units: Units) -> Option<(f64, String)> {
    let found = summary.response?.tracking?;
    let from_s = with_unit(summary.verdict.tail_s[0], "s");
    let mean = with_unit(found.rms_error_n, units.force);
    Some((found.largest_error_n, format!("at most, after {from_s}; {mean} root mean square")))
}

/// The outcome of a run in words.
pub(crate) struct Account<'d> {
    pub(crate) sentences: Vec<String>,
    /// The doubt about the file that they give as the probable reason.
    pub(crate) doubt: Option<&'d Problem>,
}

/// The outcome of a run and its probable reason; `doubts` are those about the file. For an undecided run the
/// reason comes first, because a longer run would not help.
pub(crate) fn account<'d>(
    scenario: &Scenario,
    summary: &Summary,
    units: Units,
    doubts: &'d Doubts,
) -> Account<'d> {
    let (reason, doubt) = reason(scenario, summary, doubts).unzip();
    let sentences = match reason {
        Some(reason) if summary.outcome == Outcome::Undecided => {
            let otherwise = format!("If that is meant: {}.{}", lacks(summary), so_far(summary, units));
            vec![format!("Undecided. {reason}"), otherwise]
        }
        reason => std::iter::once(outcome(summary, units)).chain(reason).collect(),
    };
    Account { sentences, doubt: doubt.flatten() }
}

/// Reason why a run ends without contact or undecided, as far as the file shows it, and its doubt.
fn reason<'d>(
    scenario: &Scenario,
    summary: &Summary,
    doubts: &'d Doubts,
) -> Option<(String, Option<&'d Problem>)> {
    let undecided = summary.outcome == Outcome::Undecided;
    if !(summary.outcome == Outcome::NoContact || undecided) || summary.contacts.is_empty() {
        return None;
    }
    let contacts = &scenario.machine.contacts;
    let reference = summary.response.and_then(|response| response.final_reference_n);
    let is_free = contacts.values().all(|contact| contact.engagement == Engagement::Free);
    // A controller may render a wall where nothing can touch.
    if is_free && summary.controlled.is_none() {
        return Some(("Every contact of the file is set free.".to_owned(), None));
    }
    let doubt = if undecided { doubts.all.first() } else { doubts.preventing_contact() };
    if let Some(doubt) = doubt {
        let reason = format!("Probable reason: {}. Remedy: {}.", doubt.message, doubt.remedy);
        return Some((reason, Some(doubt)));
    }
    if undecided {
        return None;
    }
    if reference.is_some_and(|reference| reference <= 0.0) {
        let reason = "Reason: the reference does not end above zero, and a contact only pushes.";
        return Some((reason.to_owned(), None));
    }
    scenario
        .controllers
        .is_empty()
        .then(|| ("Reason: the file has no controller, so no drive is commanded.".to_owned(), None))
}

/// The unit of the signal by which a run is judged: a force, or a motion without contact.
pub(crate) fn judged_unit(controlled: Option<&str>, units: Units) -> &'static str {
    let signal = controlled.and_then(|signal| signal.parse::<SignalName>().ok());
    signal.map_or(units.force, |signal| units.unit(signal.quantity))
}

/// One or two sentences on a loop without contact, judged by the motion that it controls.
fn of_motion(summary: &Summary, signal: &str, unit: &'static str) -> String {
    let oscillation = summary.oscillation.unwrap_or_default();
    let swings = format!(
        "`{signal}` oscillates at {}, by {} either way, and does not decay",
        rate(oscillation.frequency_hz),
        with_unit(oscillation.amplitude_n, unit)
    );
    let at = summary
        .oscillation_hz
        .map_or_else(String::new, |frequency_hz| format!(", oscillating at {}", rate(frequency_hz)));
    match summary.outcome {
        Outcome::Settled => format!("Nothing is touched, and `{signal}` settles."),
        Outcome::Unstable => format!("Nothing is touched, and `{signal}` diverges{at}."),
        Outcome::LimitCycle => {
            format!("Nothing is touched, and {swings}: a limit cycle between limits or through free play.")
        }
        Outcome::Hunting => {
            format!("Nothing is touched, and {swings}: the axis sticks and breaks loose again.")
        }
        Outcome::Oscillates => format!("Nothing is touched, and {swings}."),
        Outcome::Driven => {
            format!("Nothing is touched, and `{signal}` follows a reference that moves to the end.")
        }
        Outcome::BouncesThenSettles
        | Outcome::Chatter
        | Outcome::FollowsSurface
        | Outcome::NoContact
        | Outcome::Undecided => {
            let so_far = summary.oscillation_hz.map_or_else(String::new, |frequency_hz| {
                let swings = with_unit(summary.verdict.amplitudes_n[2], unit);
                format!(" So far `{signal}` oscillates at {}, by {swings} either way.", rate(frequency_hz))
            });
            format!("Undecided: {}.{so_far}", lacks(summary))
        }
    }
}

/// The outcome of a run in one or two words.
pub(crate) fn label(summary: &Summary) -> &'static str {
    match summary.outcome {
        Outcome::NoContact if summary.bounces > 0 => "contact lost",
        Outcome::Driven if summary.response.is_none() => "follows its commands",
        outcome => outcome.words(),
    }
}

/// Reports a force that is at rest outside the band about its reference; `None` if it is inside, or not at
/// rest.
pub(crate) fn rests_outside(summary: &Summary, units: Units) -> Option<String> {
    let rests = matches!(summary.outcome, Outcome::Settled | Outcome::BouncesThenSettles);
    let response = summary.response.filter(|response| rests && response.settling_time_s.is_none())?;
    let error = response.steady_error_n?;
    let side = if error < 0.0 { "below" } else { "above" };
    let band = with_unit(response.band_n, units.force);
    Some(format!(
        "rests {} {side} the reference, outside its band of {band}",
        with_unit(error.abs(), units.force)
    ))
}

/// Time of the largest force of a contact, and whether the force was a pull.
pub(crate) fn when(contact: &ContactSummary) -> String {
    format!("at {}{}", with_unit(contact.peak_at_s, "s"), if contact.peak_is_pull { ", a pull" } else { "" })
}

fn chatter(oscillation: &Oscillation) -> String {
    let leaves = match oscillation.impacts_per_s {
        often if often >= SLOW_HZ => {
            format!("it leaves the workpiece {} times a second", plain(often.round()))
        }
        seldom => format!("it leaves the workpiece every {}", with_unit(1.0 / seldom, "s")),
    };
    let pattern = match oscillation.impacts_per_period {
        Some(1) => "",
        Some(2) => "; its period has doubled",
        Some(_) => "; several impacts make one period",
        None => "; its impacts do not repeat within the run",
    };
    format!("The tool chatters at {}: {leaves}{pattern}.", rate(oscillation.frequency_hz))
}

fn rate(frequency_hz: f64) -> String {
    with_unit(frequency_hz, "Hz")
}

/// Whether a response starts at the first touch, and not at the last step of the reference.
fn starts_at_touch(summary: &Summary, starts_at_s: f64) -> bool {
    let first = summary.main_contact.and_then(|i| summary.contacts[i].first_contact_s);
    first.is_some_and(|first| first >= starts_at_s)
}

/// The reference of an overshoot, and the time from which it is measured if that is not the first touch. The
/// peak force is that of the whole run.
pub(crate) fn overshoot_of(summary: &Summary, units: Units) -> String {
    let Some(response) = summary.response else { return String::new() };
    let Some(reference) = response.final_reference_n else { return String::new() };
    let since = if starts_at_touch(summary, response.starts_at_s) { "" } else { ", after its last step" };
    format!("of {}{since}", with_unit(reference, units.force))
}

fn at_and_within(summary: &Summary, reference_n: Option<f64>, units: Units) -> String {
    let at = reference_n
        .map_or_else(String::new, |reference| format!(" at {}", with_unit(reference, units.force)));
    match (summary.settling_time_s, summary.response) {
        (Some(time), Some(response)) => {
            let since = if starts_at_touch(summary, response.starts_at_s) {
                "first touch"
            } else {
                "the last step of the reference"
            };
            format!("{at} within {} of {since}", with_unit(time, "s"))
        }
        (None, Some(response)) => {
            let error = response.steady_error_n.unwrap_or_default();
            let side = if error < 0.0 { "below" } else { "above" };
            match reference_n {
                Some(reference) => {
                    format!(
                        ", but {} {side} its reference of {}",
                        with_unit(error.abs(), units.force),
                        with_unit(reference, units.force)
                    )
                }
                None => String::new(),
            }
        }
        _ => String::new(),
    }
}

fn times(bounces: usize) -> String {
    match bounces {
        1 => "once".into(),
        2 => "twice".into(),
        many => count(many, "time", "times"),
    }
}

/// Force at the end of an undecided run, as a further sentence.
fn so_far(summary: &Summary, units: Units) -> String {
    let Some(response) = summary.response else { return String::new() };
    let [_, _, swings] = summary.verdict.amplitudes_n;
    let mean = response.final_reference_n.zip(response.steady_error_n).map(|(wanted, error)| wanted + error);
    mean.filter(|mean| (mean + swings).is_finite() && swings > 0.0).map_or_else(String::new, |mean| {
        let [mean, swings] = [mean, swings].map(|force| with_unit(force, units.force));
        format!(" So far the force is {mean} at the end, and oscillates by {swings} either way.")
    })
}

/// Evidence that an undecided run lacks.
fn lacks(summary: &Summary) -> String {
    let why = summary.verdict.undecided;
    if let Some(why) = why.filter(|why| !why.may_be_decided()) {
        return why.words().to_owned();
    }
    let why = why.map_or_else(String::new, |why| format!("{}; ", why.words()));
    let touches_at_s = summary.verdict.touches_at_s;
    let touch =
        touches_at_s.map_or_else(String::new, |at_s| format!("it would touch at {}; ", with_unit(at_s, "s")));
    // The verdict needs some time after the touch.
    let longer = with_unit(2.0 * touches_at_s.unwrap_or(summary.simulated_s), "s");
    format!("{why}{touch}lengthen run.duration, for example by --set 'run.duration={longer}'")
}
