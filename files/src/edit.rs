//! Settings that turn one scenario into another, and a user's file with settings in it, comments kept.

use std::collections::BTreeMap;
use std::path::Path;

use feeler_catalogue::{CORNER, DAMPING_RATIO};
use feeler_engine::Scenario;
use toml_edit::{DocumentMut, Item, Table, TableLike, Value};

use super::draft::Setting;
use super::write::to_toml;

/// The key of the base file.
const BASE: &str = "machine";
/// The key of a filter.
const LOW_PASS: &str = "low_pass";

/// A key and its value.
pub type Assignment = (String, Setting);

/// The settings that turn `from` into `to`; `None` if a key would have to be removed, or holds several
/// values.
pub fn settings_between(from: &Scenario, to: &Scenario) -> Option<Vec<Assignment>> {
    let [before, after] = [from, to].map(|scenario| {
        let mut values = BTreeMap::new();
        if let Ok(table) = to_toml(scenario).parse::<toml::Table>() {
            flatten("", &table, &mut |key, value| drop(values.insert(key, value.clone())));
        }
        values
    });
    if before.keys().any(|key| !after.contains_key(key)) {
        return None;
    }
    // A first-order filter is a plain number in most files.
    let corner = format!("{LOW_PASS}.{}", CORNER.name);
    let is_first_order = |key: &str| {
        let filter = key.strip_suffix(CORNER.name).filter(|_| key.ends_with(&corner));
        filter.is_some_and(|filter| !after.contains_key(&format!("{filter}{}", DAMPING_RATIO.name)))
    };
    let shown: BTreeMap<String, String> = (after.keys().filter(|key| is_first_order(key)))
        .map(|key| (key.clone(), key.trim_end_matches(CORNER.name).trim_end_matches('.').to_owned()))
        .collect();
    let changed = after.into_iter().filter(|(key, value)| before.get(key) != Some(value));
    changed.map(|(key, value)| Some((shown.get(&key).cloned().unwrap_or(key), setting(&value)?))).collect()
}

/// An assignment in the form of `--set`.
pub fn assignment(key: &str, setting: &Setting) -> String {
    match setting {
        Setting::Number(value) => format!("{key}={value}"),
        Setting::Text(text) => format!("{key}={text}"),
        Setting::Flag(flag) => format!("{key}={flag}"),
    }
}

/// The text of a file with keys set as `--set` sets them, and everything else unchanged. `None` if it is not
/// TOML, or if a path leads through something other than a table. With the folder of the file, its base
/// machine is found from another folder, too.
pub fn with_settings(text: &str, settings: &[String], folder: Option<&Path>) -> Option<String> {
    let mut document: DocumentMut = text.parse().ok()?;
    if let (Some(folder), Some(base)) = (folder, document.get(BASE).and_then(Item::as_str)) {
        let path = folder.join(base).display().to_string();
        set(&mut document, BASE, Value::from(path))?;
    }
    for setting in settings {
        let (key, value) = setting.split_once('=')?;
        let text = value.trim();
        set(&mut document, key.trim(), text.parse().unwrap_or_else(|_| Value::from(text)))?;
    }
    Some(document.to_string())
}

/// The table of a dotted key, created if necessary, and the key's last part. The error names the part of its
/// path that is not a table.
pub(super) fn table_of<'d, 'k>(
    document: &'d mut DocumentMut,
    key: &'k str,
) -> Result<(&'d mut dyn TableLike, &'k str), &'k str> {
    let (way, last) = key.rsplit_once('.').map_or((None, key), |(way, last)| (Some(way), last));
    let mut table: &mut dyn TableLike = document.as_table_mut();
    for part in way.into_iter().flat_map(|way| way.split('.')) {
        let mut made = Table::new();
        made.set_implicit(true);
        table = table.entry(part).or_insert(Item::Table(made)).as_table_like_mut().ok_or(part)?;
    }
    Ok((table, last))
}

fn set(document: &mut DocumentMut, key: &str, mut value: Value) -> Option<()> {
    let (table, last) = table_of(document, key).ok()?;
    if let Some(old) = table.get_mut(last).and_then(Item::as_value_mut) {
        *value.decor_mut() = old.decor().clone();
        *old = value;
    } else {
        table.insert(last, Item::Value(value));
    }
    Some(())
}

/// Every value of a table except tables, with its dotted key.
pub(super) fn flatten(path: &str, table: &toml::Table, take: &mut dyn FnMut(String, &toml::Value)) {
    for (name, value) in table {
        let key = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        match value {
            toml::Value::Table(inner) => flatten(&key, inner, take),
            value => take(key, value),
        }
    }
}

fn setting(value: &toml::Value) -> Option<Setting> {
    match value {
        toml::Value::Float(number) => Some(Setting::Number(*number)),
        toml::Value::Integer(count) => Some(Setting::Number(*count as f64)),
        toml::Value::String(text) => Some(Setting::Text(text.clone())),
        toml::Value::Boolean(flag) => Some(Setting::Flag(*flag)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::Document;
    use super::*;

    const FILE: &str = r#"# A block on a spring.
[bodies.block]
mass = "2 kg"    # weighed

# Soft.
[springs.leaf]
between = ["ground", "block"]
stiffness = 100.0
[springs.leaf.effects.constant-load]
force = 3.0
"#;

    #[test]
    fn truth_settings_lead_from_one_scenario_to_the_other_and_leave_comments_alone() {
        let document = Document::parse(FILE, "block.toml").unwrap();
        let mut other = document.scenario.clone();
        other.machine.bodies["block"].mass_kg = 3.0;
        other.machine.springs["leaf"].damping_n_s_per_m = 7.5;
        let settings = settings_between(&document.scenario, &other).unwrap();
        let words: Vec<String> = settings.iter().map(|(key, value)| assignment(key, value)).collect();
        assert_eq!(words, ["bodies.block.mass=3", "springs.leaf.damping=7.5"]);
        let text = with_settings(FILE, &words, None).unwrap();
        assert_eq!(Document::parse(&text, "block.toml").unwrap().scenario, other);
        assert!(text.contains("# A block on a spring.") && text.contains("mass = 3    # weighed"), "{text}");
        other.machine.springs["leaf"].effects.clear();
        assert_eq!(settings_between(&document.scenario, &other), None);
    }
}
