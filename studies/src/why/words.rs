//! The verdict in words.

use feeler_engine::Scenario;

use super::change::ChatterCause;
use super::explanation::{Explanation, LARGEST_SET, Lift, in_contact};
use super::linear;
use crate::numbers::{plain, two_digits};
use crate::run::{Measured, Outcome, Summary, nothing_can_touch};

/// The verdict on a run without chatter: the loop as set, how the run ends, and what would lift the limit
/// most.
pub(super) fn nothing_to_explain(
    scenario: &Scenario,
    baseline: &Measured,
    margin: Option<f64>,
    lifts: &[Lift],
) -> String {
    let (what, verdict) = (what(scenario), &baseline.summary.verdict);
    if let Some(why) = verdict.undecided {
        return format!(
            "Whether there is {what} to explain is undecided ({}): a longer `run.duration` may decide.",
            why.name()
        );
    }
    let ended = ended(scenario, &baseline.summary);
    let Some(margin) = margin else { return format!("No {what}: {ended}.") };
    let lift = lifts.first().map_or_else(String::new, |lift| {
        let to = lift.to.map_or_else(
            || "beyond every gain tried".to_owned(),
            |to| format!("to {} times the gain", plain(two_digits(to))),
        );
        format!(" What would lift this limit most: {}, {to}.", lift.change.words())
    });
    let below = linear::below_limit(scenario, margin);
    let is_still = if nothing_can_touch(scenario) { String::new() } else { format!("there is no {what}: ") };
    format!("By linear theory {below}. In simulation {is_still}{ended}.{lift}")
}

/// How a run ended, in words.
fn ended(scenario: &Scenario, summary: &Summary) -> String {
    let is_free = nothing_can_touch(scenario);
    let said = match summary.outcome {
        Outcome::Settled if is_free => "what the loop controls comes to rest",
        Outcome::Driven if is_free => "what the loop controls follows its moving reference to the end",
        Outcome::Settled => "the force settles, and the tool stays on the workpiece",
        Outcome::BouncesThenSettles if summary.bounces == 1 => "the force settles after one bounce",
        Outcome::BouncesThenSettles => return format!("the force settles after {} bounces", summary.bounces),
        Outcome::Driven => "the force follows its moving reference to the end",
        Outcome::FollowsSurface => "the force follows the moving surface to the end",
        Outcome::NoContact => "the tool does not touch, or leaves and does not return",
        _ => "the force comes to rest",
    };
    said.to_owned()
}

/// Sentences after the verdict: the change that raises the limit most, and the sufficient size of a change.
pub(super) fn beside(found: &Explanation) -> String {
    let lifts = found.lift.as_ref().map_or_else(String::new, |lift| {
        let to = lift.to.map_or_else(|| "beyond 50".to_owned(), |to| format!("to {to:.3}"));
        format!(
            " With {} it is gone too, and the limit rises most: from {:.3} {to} times the gain.",
            lift.change.words(),
            lift.from
        )
    });
    let chosen = found.smallest.first().map_or(&[][..], Vec::as_slice);
    let size = found.sizes.iter().find(|size| chosen.contains(&size.of));
    let enough =
        size.map_or_else(String::new, |size| format!(" This is enough to remove it: {}.", size.what));
    lifts + &enough
}

/// The verdict if no set of changes removes the chatter.
fn unexplained(found: &Explanation, scenario: &Scenario) -> String {
    if found.wrong_sign && found.baseline.outcome == Some(Outcome::NoContact) {
        return "The tool is pushed away from the workpiece: the force feedback has the wrong sign. Reverse \
                the sign of the gain or of the drive."
            .into();
    }
    let (what, in_contact) = (what(scenario), in_contact(scenario));
    let tried = format!("No change or set of up to {LARGEST_SET} changes removes the {what}");
    if found.wrong_sign {
        let upto =
            found.gain_margin.map_or_else(String::new, |margin| format!(" beyond {margin:.2} of its gain"));
        return format!(
            "{tried}: the feedback has the wrong sign, so the loop{in_contact}{upto} diverges without \
             oscillation; reverse the sign of the gain or of the drive."
        );
    }
    if found.undamped {
        return format!(
            "{tried}: a mode of the machine{in_contact} has no damping. Nothing dissipates the energy that \
             approach and feedback feed into it. Add damping to contact, guide or control."
        );
    }
    match (found.linear_stable, found.gain_margin) {
        (Some(false), Some(margin)) if margin > 0.0 && margin < 1.0 => {
            let above = linear::above_limit(scenario, margin);
            format!("{tried}: the gain itself is too high; by linear theory {above}.")
        }
        (Some(false), Some(_)) => {
            format!(
                "{tried}: by linear theory the loop{in_contact} is unstable, and no lower gain cures that."
            )
        }
        _ => format!("{tried}; its cause is none of those tried."),
    }
}

/// The explained motion: chatter, or the motion of a loop that touches nothing.
fn what(scenario: &Scenario) -> &'static str {
    if nothing_can_touch(scenario) { "motion" } else { "chatter" }
}

/// The verdict on chatter.
pub(super) fn sentence(found: &Explanation, scenario: &Scenario) -> String {
    let list = |words: Vec<&str>| match words.as_slice() {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
    };
    let Some(chosen) = found.smallest.first() else { return unexplained(found, scenario) };
    let (what, in_contact) = (what(scenario), in_contact(scenario));
    let causes = list(found.causes.iter().map(|cause| cause.words()).collect());
    let changes = list(chosen.iter().map(|change| change.words()).collect());
    let theory = match (found.linear_stable, found.gain_margin) {
        (Some(true), Some(margin)) => {
            format!("; by linear theory the loop{in_contact} is stable, up to {margin:.2} times its gain")
        }
        (Some(true), None) => format!("; by linear theory the loop{in_contact} is stable"),
        (Some(false), Some(margin)) if margin > 0.0 && margin < 1.0 => {
            format!("; by linear theory {}", linear::above_limit(scenario, margin))
        }
        (Some(false), Some(margin)) => {
            let at = if margin > 0.0 { "this gain and every lower one" } else { "every gain" };
            format!("; by linear theory the sampled loop{in_contact} is unstable at {at}")
        }
        _ => String::new(),
    };
    if found.causes == [ChatterCause::SensorNoise] && found.linear_stable != Some(false) {
        format!(
            "The oscillation is the response to sensor noise of a loop that settles by itself: with \
             {changes} it is gone{theory}."
        )
    } else if found.causes.len() > 1 {
        format!(
            "The {what} has {} causes, {causes}: it takes {changes} together to remove it{theory}.",
            found.causes.len()
        )
    } else if found.contributions.first().is_some_and(|trial| trial.only_by_period) {
        format!(
            "The growth is due to {causes}: it falls with the controller's period, and with {changes} it is \
             gone{theory}."
        )
    } else {
        format!("The {what} is due to {causes}: with {changes} it is gone{theory}.")
    }
}
