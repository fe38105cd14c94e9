//! Tries the ends of each axis on the scenario, so that wrong keys, units and values are reported before a
//! thousand runs.
//!
//! A value that is wrong for the unchanged scenario may be right together with values of other axes. An
//! example is a level that must stay below another level. Such a value is not a mistake of the file; wrong
//! combinations become rows with their errors. The same applies to the end of a range if some combination of
//! all axes is right. A value in a list must be right in at least one combination.

use std::path::Path;

use feeler_engine::Scenario;
use indexmap::IndexMap;

use super::super::document::Document;
use super::super::draft::{Draft, Setting};
use super::super::keys::sweep::{AXES, SCENARIO};
use super::super::located::Located;
use super::super::problem::Problems;
use super::super::read::join;
use super::super::source::Origin;
use super::super::tree::{Entry, Node, Table, Value, place};
use super::axes::{ReadAxis, SweepAxis, setting};
use super::unit::unit_of_key;

/// Largest number of combinations of values that are tried for one axis.
const MOST_COMBINATIONS: usize = 1024;

/// Builds the scenario with the ends of each axis, as written, and records mistakes. Returns the unit of each
/// key; `None` if the scenario cannot be read.
pub(super) fn try_ends(
    axes: &IndexMap<String, ReadAxis>,
    scenario: &Path,
    root: &Table,
    problems: &mut Problems,
) -> Option<IndexMap<String, String>> {
    let (base, units) = match Draft::load(scenario)
        .and_then(|draft| draft.clone().build().map(|built| (draft, units(axes, &built.scenario))))
    {
        Ok(base) => base,
        Err(error) => {
            let first = error.problems.first().map_or_else(String::new, Located::to_string);
            let more = error.problems.len() + error.omitted;
            let message = if more > 1 { format!("{first}; and {} more", more - 1) } else { first };
            let remedy = if scenario.is_file() {
                format!("`feeler check {}` shows every mistake of it", scenario.display())
            } else {
                "name a scenario file, relative to this one".into()
            };
            problems.add(&place(root, SCENARIO.name), SCENARIO.name, message, remedy);
            return None;
        }
    };
    let table = root.get(AXES).and_then(|entry| entry.node.as_table());
    let tried: Vec<Tried<'_>> = (axes.iter())
        .filter_map(|(key, read)| {
            let entry = table?.get(key)?;
            Some(Tried { key, entry, ends: ends(&read.axis, &entry.node) })
        })
        .collect();
    let trial = Trial { base: &base, axes: &tried };
    let noted = problems.count();
    let doubtful: Vec<Doubtful> = (0..tried.len()).flat_map(|own| trial.axis(own, problems)).collect();
    // A value that is wrong only with the ends of other axes becomes a row with its error. It is a mistake if
    // it is in a list, or if no combination is right.
    if problems.count() > noted || doubtful.is_empty() {
        return Some(units);
    }
    if trial.combinations(None).any(|set| set.build().is_ok()) {
        for value in doubtful.into_iter().filter(|value| value.is_listed) {
            value.mistake.note(problems);
        }
    } else if let Some(value) = doubtful.into_iter().next() {
        let message =
            format!("every combination of the ends is invalid; the first: {}", value.mistake.message);
        Mistake { path: AXES.into(), message, ..value.mistake }.note(problems);
    }
    Some(units)
}

fn units(axes: &IndexMap<String, ReadAxis>, scenario: &Scenario) -> IndexMap<String, String> {
    axes.keys().map(|key| (key.clone(), unit_of_key(key, scenario))).collect()
}

/// An axis and those of its values that are tried, as written.
struct Tried<'a> {
    key: &'a str,
    entry: &'a Entry,
    ends: Vec<(Setting, Origin)>,
}

/// A mistake and its remedy.
type Said = (String, String);

/// A mistake, and its place in the report.
struct Mistake {
    origin: Origin,
    path: String,
    message: String,
    remedy: String,
}

impl Mistake {
    fn note(self, problems: &mut Problems) {
        problems.add(&self.origin, self.path, self.message, self.remedy);
    }
}

/// A value that is wrong with every end of the other axes, but may be right with values in between.
struct Doubtful {
    is_listed: bool,
    mistake: Mistake,
}

/// The scenario with some values set; `None` if a value cannot be set at all.
struct Set(Option<Draft>);

impl Set {
    fn build(self) -> Result<(), Vec<Located>> {
        self.0
            .map_or(Err(Vec::new()), |draft| Document::build(draft).map(drop).map_err(|error| error.problems))
    }
}

/// The kind of mistake of a value.
enum Wrong {
    /// The value itself is wrong, whatever the others are.
    Own(Vec<Located>),
    /// The value is wrong together with the ends of other axes.
    BesideOthers(Vec<Located>),
}

/// The axes of a sweep on its scenario.
struct Trial<'a> {
    base: &'a Draft,
    axes: &'a [Tried<'a>],
}

impl Trial<'_> {
    /// The scenario with every combination of the axes' ends. The axis `own` has a fixed setting.
    fn combinations<'b>(&'b self, own: Option<(usize, &'b Setting)>) -> impl Iterator<Item = Set> + 'b {
        let counts = move |i: usize| {
            if own.is_some_and(|(own, _)| own == i) { 1 } else { self.axes[i].ends.len().max(1) }
        };
        let count =
            (0..self.axes.len()).map(counts).try_fold(1_usize, usize::checked_mul).unwrap_or(usize::MAX);
        (0..count.min(MOST_COMBINATIONS)).map(move |combination| {
            let mut rest = combination;
            let mut draft = self.base.clone();
            let set = self.axes.iter().enumerate().try_for_each(|(i, axis)| {
                let chosen = rest % counts(i);
                rest /= counts(i);
                let held = own.filter(|(own, _)| *own == i).map(|(_, setting)| setting);
                held.or(axis.ends.get(chosen).map(|(setting, _)| setting))
                    .map_or(Ok(()), |setting| draft.set_value(axis.key, setting))
            });
            Set(set.is_ok().then_some(draft))
        })
    }

    fn wrong(&self, own: usize, setting: &Setting) -> Option<Wrong> {
        let mut draft = self.base.clone();
        let alone = match draft.set_value(self.axes[own].key, setting) {
            Err(error) => return Some(Wrong::Own(error.problems)),
            Ok(()) => Document::build(draft).err()?.problems,
        };
        let mut best: Option<Vec<Located>> = None;
        for set in self.combinations(Some((own, setting))) {
            match set.build() {
                Ok(()) => return None,
                // If a value cannot be set at all, another axis has the mistake.
                Err(found) if found.is_empty() => {}
                Err(found) if best.as_ref().is_none_or(|best| found.len() < best.len()) => best = Some(found),
                Err(_) => {}
            }
        }
        let best = best.unwrap_or(alone);
        // A mistake of a table refers to all of its keys together.
        let is_of = |axis: &Tried<'_>, problem: &Located| {
            axis.key
                .strip_prefix(problem.key.as_str())
                .is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let of_others = |problem: &Located| {
            self.axes.iter().enumerate().any(|(i, axis)| i != own && is_of(axis, problem))
        };
        let (beside_others, of_own): (Vec<Located>, Vec<Located>) = best.into_iter().partition(of_others);
        Some(if of_own.is_empty() { Wrong::BesideOthers(beside_others) } else { Wrong::Own(of_own) })
    }

    /// Records the mistakes of an axis, and returns its doubtful values.
    fn axis(&self, own: usize, problems: &mut Problems) -> Vec<Doubtful> {
        let Tried { key, entry, ends } = &self.axes[own];
        let path = join(AXES, &format!("\"{key}\""));
        let words = |found: Vec<Located>| {
            found.into_iter().map(|problem| (problem.message, problem.remedy)).collect()
        };
        let mut doubtful = Vec::new();
        let mut tried: Vec<(&Setting, &Origin, Vec<Said>)> = Vec::new();
        for (setting, origin) in ends {
            let found = match self.wrong(own, setting) {
                None => Vec::new(),
                Some(Wrong::Own(found)) => words(found),
                Some(Wrong::BesideOthers(found)) => {
                    let is_listed = matches!(entry.node.value, Value::Array(_));
                    doubtful.extend(found.into_iter().map(|problem| {
                        let message = format!("with {}: {}", shown(setting), problem.message);
                        let mistake = Mistake {
                            origin: origin.clone(),
                            path: path.clone(),
                            message,
                            remedy: problem.remedy,
                        };
                        Doubtful { is_listed, mistake }
                    }));
                    Vec::new()
                }
            };
            tried.push((setting, origin, found));
        }
        // A mistake that occurs with every value belongs to the key, and is reported once.
        let always =
            |mistake: &Said| tried.len() > 1 && tried.iter().all(|(_, _, found)| found.contains(mistake));
        let of_key = tried
            .first()
            .into_iter()
            .flat_map(|(_, _, found)| found.iter().filter(|mistake| always(mistake)));
        for (message, remedy) in of_key {
            problems.add(&entry.key, path.as_str(), message.as_str(), remedy.as_str());
        }
        for (setting, origin, found) in &tried {
            for (message, remedy) in found.iter().filter(|mistake| !always(mistake)) {
                problems.add(
                    origin,
                    path.as_str(),
                    format!("with {}: {message}", shown(setting)),
                    remedy.as_str(),
                );
            }
        }
        doubtful
    }
}

fn shown(setting: &Setting) -> String {
    match setting {
        Setting::Number(value) => value.to_string(),
        Setting::Text(text) => format!("\"{text}\""),
        Setting::Flag(flag) => flag.to_string(),
    }
}

/// First and last value of an axis as written, with their units; every value of a list.
fn ends(axis: &SweepAxis, node: &Node) -> Vec<(Setting, Origin)> {
    let written = |item: &Node| setting(item).map(|setting| (setting, item.origin.clone()));
    if let (SweepAxis::List(_), Value::Array(items)) = (axis, &node.value) {
        return items.iter().filter_map(written).collect();
    }
    let range =
        node.as_table().into_iter().flat_map(Table::values).find_map(|entry| match &entry.node.value {
            Value::Array(items) => Some(items),
            _ => None,
        });
    range.and_then(|items| Some(vec![written(items.first()?)?, written(items.last()?)?])).unwrap_or_default()
}
