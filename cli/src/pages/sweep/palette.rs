//! Names of outcomes, and colours that are distinct for all types of colour vision.

use feeler_studies::run::Outcome;

/// Okabe and Ito's colours: warm ones for problems, blues for success.
pub(crate) fn of_outcome(name: &str) -> &'static str {
    match Outcome::ALL.iter().find(|(_, known)| *known == name).map(|(outcome, _)| *outcome) {
        Some(Outcome::Settled) => "#0072b2",
        Some(Outcome::BouncesThenSettles) => "#56b4e9",
        Some(Outcome::Driven) => "#a6d8f5",
        Some(Outcome::Chatter) => "#e69f00",
        Some(Outcome::Unstable) => "#d55e00",
        Some(Outcome::LimitCycle) => "#cc79a7",
        Some(Outcome::Hunting) => "#f0e442",
        Some(Outcome::Oscillates) => "#009e73",
        Some(Outcome::FollowsSurface) => "#7fc7a6",
        Some(Outcome::NoContact) => "#dddddd",
        Some(Outcome::Undecided) => "#999999",
        // A run that failed has no outcome.
        None => "#000000",
    }
}

/// Names of outcomes in tables, each with its words.
pub(super) fn labels() -> impl Iterator<Item = (&'static str, &'static str)> {
    let known = Outcome::ALL.map(|(outcome, name)| (name, outcome.words()));
    known.into_iter().chain([("error", "failed"), ("done", "outcome not kept")])
}
