//! Tries the ends of each axis on the scenario, so that wrong keys, units and values show before a thousand runs.

use std::path::Path;

use indexmap::IndexMap;

use super::super::document::Document;
use super::super::draft::{Draft, Setting};
use super::super::problem::{Located, Problems};
use super::super::read::join;
use super::super::source::Origin;
use super::super::tree::{Entry, Node, Table, Value};
use super::axes::{Axis, ReadAxis, setting};

/// Builds the scenario with the ends of each axis, as they were written, and notes what is wrong.
pub(super) fn try_ends(axes: &IndexMap<String, ReadAxis>, scenario: &Path, root: &Table, problems: &mut Problems) {
    let base = match Draft::load(scenario).and_then(|draft| draft.clone().build().map(|_| draft)) {
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
            return;
        }
    };
    let table = root.get("axes").and_then(|entry| entry.node.as_table());
    for (key, read) in axes {
        if let Some(entry) = table.and_then(|table| table.get(key)) {
            try_axis(key, &read.axis, entry, &base, problems);
        }
    }
}

/// What is wrong with one value: the message and its remedy.
type Wrong = (String, String);

fn try_axis(key: &str, axis: &Axis, entry: &Entry, base: &Draft, problems: &mut Problems) {
    let wrong = |setting: &Setting| -> Vec<Wrong> {
        let mut draft = base.clone();
        match draft.set_value(key, setting).and_then(|()| Document::build(draft)) {
            Ok(_) => Vec::new(),
            Err(error) => error.problems.into_iter().map(|problem| (problem.message, problem.remedy.unwrap_or_default())).collect(),
        }
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
