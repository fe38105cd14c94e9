//! Tries the ends of each axis on the scenario, so that wrong keys, units and values show before a thousand runs.
//!
//! A value that is wrong for the scenario as it is may be right together with those of other axes, as a level that has to stay below another: then it
//! is no mistake of the file, and the combinations that are wrong are rows with their errors.

use std::path::Path;

use feeler_plant::description;
use indexmap::IndexMap;

use super::super::document::Document;
use super::super::draft::{Draft, Setting};
use super::super::problem::{Located, Problems};
use super::super::read::join;
use super::super::source::Origin;
use super::super::tree::{Entry, Node, Table, Value};
use super::axes::{Axis, ReadAxis, setting};

/// Combinations of an axis's values with those of others that are tried at most.
const MOST_COMBINATIONS: usize = 1024;

/// Builds the scenario with the ends of each axis, as they were written, and notes what is wrong. Gives what its axis is; none where it cannot be read.
pub(super) fn try_ends(
    axes: &IndexMap<String, ReadAxis>,
    scenario: &Path,
    root: &Table,
    problems: &mut Problems,
) -> Option<description::Axis> {
    let (base, kind) = match Draft::load(scenario).and_then(|draft| draft.clone().build().map(|built| (draft, built.scenario.machine.axis)))
    {
        Ok(base) => base,
        Err(error) => {
            let origin = root.get("scenario").map(|entry| entry.node.origin.clone()).unwrap_or_default();
            let first = error.problems.first().map_or_else(String::new, Located::to_string);
            let more = error.problems.len() + error.omitted;
            let message = if more > 1 { format!("{first}; and {} more", more - 1) } else { first };
            let remedy = if scenario.is_file() {
                format!("`feeler check {}` shows every mistake of it", scenario.display())
            } else {
                "name a scenario file, relative to this one".into()
            };
            problems.add(&origin, "scenario", message, remedy);
            return None;
        }
    };
    let table = root.get("axes").and_then(|entry| entry.node.as_table());
    for (key, read) in axes {
        if let Some(entry) = table.and_then(|table| table.get(key)) {
            let others = axes.iter().filter(|(other, _)| *other != key).filter_map(|(other, read)| {
                let values = ends(&read.axis, &table?.get(other)?.node).into_iter().map(|(setting, _)| setting);
                Some((other.as_str(), values.collect()))
            });
            let base = Base { draft: &base, others: others.collect() };
            try_axis(key, &read.axis, entry, &base, problems);
        }
    }
    Some(kind)
}

/// What is wrong with one value: the message and its remedy.
type Wrong = (String, String);

/// What the values of an axis are tried on.
struct Base<'a> {
    draft: &'a Draft,
    /// Every other axis with the values that are tried of it.
    others: Vec<(&'a str, Vec<Setting>)>,
}

impl Base<'_> {
    /// Whether a draft can be built with some combination of the other axes' values, of which each may also stay as it is. `left` are the
    /// combinations that may still be tried.
    fn has_room_for(&self, draft: &Draft, left: &mut usize) -> bool {
        let combinations =
            self.others.iter().map(|(_, values)| values.len() + 1).try_fold(1_usize, usize::checked_mul).unwrap_or(usize::MAX);
        for combination in 1..combinations.min(*left + 1) {
            *left -= 1;
            let mut rest = combination;
            let mut draft = draft.clone();
            let set = self.others.iter().try_for_each(|(key, values)| {
                let chosen = rest % (values.len() + 1);
                rest /= values.len() + 1;
                chosen.checked_sub(1).map_or(Ok(()), |i| draft.set_value(key, &values[i]))
            });
            if set.is_ok() && Document::build(draft).is_ok() {
                return true;
            }
        }
        false
    }
}

fn try_axis(key: &str, axis: &Axis, entry: &Entry, base: &Base<'_>, problems: &mut Problems) {
    let mut left = MOST_COMBINATIONS;
    let mut wrong = |setting: &Setting| -> Vec<Wrong> {
        let mut draft = base.draft.clone();
        let found = match draft.set_value(key, setting) {
            Err(error) => error,
            Ok(()) => match Document::build(draft.clone()) {
                Err(error) if !base.has_room_for(&draft, &mut left) => error,
                _ => return Vec::new(),
            },
        };
        found.problems.into_iter().map(|problem| (problem.message, problem.remedy.unwrap_or_default())).collect()
    };
    let tried: Vec<(Setting, Origin, Vec<Wrong>)> = ends(axis, &entry.node)
        .into_iter()
        .map(|(setting, origin)| {
            let found = wrong(&setting);
            (setting, origin, found)
        })
        .collect();
    let path = join("axes", &format!("\"{key}\""));
    // What is wrong with every value is wrong with the key, and said once.
    let always = |mistake: &Wrong| tried.len() > 1 && tried.iter().all(|(_, _, found)| found.contains(mistake));
    let of_key: Vec<&Wrong> = tried.first().map_or_else(Vec::new, |(_, _, found)| found.iter().filter(|mistake| always(mistake)).collect());
    for (message, remedy) in of_key {
        problems.add(&entry.key, path.as_str(), message.as_str(), remedy.as_str());
    }
    for (setting, origin, found) in &tried {
        for (message, remedy) in found.iter().filter(|mistake| !always(mistake)) {
            problems.add(origin, path.as_str(), format!("with {}: {message}", shown(setting)), remedy.as_str());
        }
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
fn ends(axis: &Axis, node: &Node) -> Vec<(Setting, Origin)> {
    let written = |item: &Node| setting(item).map(|setting| (setting, item.origin.clone()));
    if let (Axis::List(_), Value::Array(items)) = (axis, &node.value) {
        return items.iter().filter_map(written).collect();
    }
    let range = node.as_table().into_iter().flat_map(Table::values).find_map(|entry| match &entry.node.value {
        Value::Array(items) => Some(items),
        _ => None,
    });
    range.and_then(|items| Some(vec![written(items.first()?)?, written(items.last()?)?])).unwrap_or_default()
}
