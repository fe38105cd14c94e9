//! The required size of a change: the mildest after which the force settles in simulation, and its settings.

use feeler_engine::Scenario;
use feeler_files::{Assignment, Document, Setting, assignment, rounded, settings_between, to_toml};
use rayon::prelude::*;

use super::explanation::is_at_rest;
use crate::run::PreparedRun;

/// Digits that are enough for any remedy.
const DIGITS: usize = 4;

/// Bisections, by ratio, of the step between an insufficient and a sufficient size: of a factor of four, to a
/// fifth.
const HALVINGS: usize = 3;

/// Number of sizes that are tried at once.
const AT_ONCE: usize = 4;
/// The search goes below the first share by this factor.
const BELOW: f64 = 4.0;

/// A scenario that can be written to a file, so that a trial equals a file with the settings.
pub(super) struct Written {
    pub(super) scenario: Scenario,
    document: Option<Document>,
}

/// A changed scenario, and the `--set` arguments that make it from the first scenario; empty if no settings
/// do so.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Changed {
    pub(super) scenario: Scenario,
    pub(super) settings: Vec<Assignment>,
}

impl Written {
    pub(super) fn new(scenario: &Scenario) -> Self {
        let document = Document::parse(&to_toml(scenario), "scenario.toml").ok();
        // A scenario that cannot be written is tried directly, and has no settings.
        let document = document.filter(|document| document.scenario == *scenario);
        Self { scenario: scenario.clone(), document }
    }

    /// The scenario with a change, its numbers rounded as in a file; `None` if nothing changes.
    pub(super) fn with(&self, change: impl Fn(&mut Scenario)) -> Option<Changed> {
        let mut wanted = self.scenario.clone();
        change(&mut wanted);
        if wanted == self.scenario {
            return None;
        }
        let written = self.document.as_ref().zip(settings_between(&self.scenario, &wanted));
        let written = written.and_then(|(document, settings)| {
            let settings: Vec<Assignment> =
                settings.into_iter().map(|(key, setting)| (key, in_digits(setting))).collect();
            let set =
                document.with(settings.iter().map(|(key, setting)| (key.as_str(), setting.clone()))).ok()?;
            Some(Changed { scenario: set.scenario, settings })
        });
        Some(written.unwrap_or(Changed { scenario: wanted, settings: Vec::new() }))
    }
}

impl Changed {
    /// Its `--set` arguments.
    pub(super) fn words(&self) -> Vec<String> {
        self.settings.iter().map(|(key, setting)| assignment(key, setting)).collect()
    }

    /// Length of the run that shows the force at rest, s; `None` if even the longest does not.
    fn rest_seen_s(&self) -> Option<f64> {
        let measured =
            PreparedRun::new(self.scenario.clone()).and_then(|candidate| candidate.measure(0)).ok()?;
        is_at_rest(&self.scenario, &measured).then_some(measured.summary.simulated_s)
    }

    /// Whether a run of its own length, without extension, shows that the force comes to rest.
    fn settles(&self) -> bool {
        self.rest_seen_s().is_some_and(|seen_s| self.is_within_run(seen_s))
    }

    fn is_within_run(&self, seen_s: f64) -> bool {
        // Runs grow by doubling.
        seen_s < 1.5 * self.scenario.run.duration_s
    }
}

/// A change after which the force comes to rest; if that takes longer than the run, the run becomes longer.
pub(super) fn at_rest(written: &Written, change: impl Fn(&mut Scenario)) -> Option<Changed> {
    let changed = written.with(&change)?;
    let seen_s = changed.rest_seen_s()?;
    if changed.is_within_run(seen_s) {
        return Some(changed);
    }
    let longer = written.with(|scenario| {
        change(scenario);
        scenario.run.duration_s = seen_s;
    })?;
    longer.settles().then_some(longer)
}

fn in_digits(setting: Setting) -> Setting {
    match setting {
        Setting::Number(value) => Setting::Number(rounded(value, DIGITS)),
        other => other,
    }
}

/// The mildest of a family of changes after which the force settles within the run, with its size; `sizes` go
/// from mild to strong. If none does, the first that does in a longer run.
pub(super) fn mildest(
    written: &Written,
    sizes: &[f64],
    change: impl Fn(&mut Scenario, f64) + Sync,
) -> Option<(f64, Changed)> {
    let at = |size: f64| written.with(|scenario| change(scenario, size));
    let attempt = |size: &f64| {
        let changed = at(*size)?;
        let seen_s = changed.rest_seen_s()?;
        Some((changed, seen_s))
    };
    let within = |(changed, seen_s): &(Changed, f64)| changed.is_within_run(*seen_s);
    let mut tried: Vec<Option<(Changed, f64)>> = Vec::new();
    // The strongest are tried only if the others do not suffice.
    for sizes in sizes.chunks(AT_ONCE) {
        tried.par_extend(sizes.par_iter().map(attempt));
        if tried.iter().any(Option::is_some) {
            break;
        }
    }
    let Some(first) = tried.iter().position(|found| found.as_ref().is_some_and(within)) else {
        let mut resting =
            sizes.iter().zip(&tried).filter(|(_, found)| found.is_some()).map(|(size, _)| *size);
        return resting.find_map(|size| Some((size, at_rest(written, |s| change(s, size))?)));
    };
    let (mut strong, mut found) = (sizes[first], tried.into_iter().nth(first)??.0);
    // Below the first of some shares there is no size of no effect, as one is of a factor.
    let least = if strong > 1.0 { 1.0 } else { strong / BELOW };
    let mut mild = first.checked_sub(1).map_or(least, |before| sizes[before]);
    for _ in 0..HALVINGS {
        let middle = (mild * strong).sqrt();
        match at(middle).filter(Changed::settles) {
            Some(settles) => (strong, found) = (middle, settles),
            None => mild = middle,
        }
    }
    Some((strong, found))
}
