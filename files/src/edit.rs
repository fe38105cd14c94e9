//! Settings that turn one scenario into another, and a user's file with settings applied, comments kept.

use std::collections::BTreeMap;
use std::path::Path;

use feeler_catalogue::{Absent, CORNER, DAMPING_RATIO, LOW_PASS};
use feeler_control::ANTI_WINDUP;
use feeler_engine::Scenario;
use toml_edit::{DocumentMut, Item, Table, TableLike, Value};

use super::document::Document;
use super::draft::Setting;
use super::keys::BASE;
use super::tree::{Value as Node, node_at};
use super::write::to_toml;

/// A key and its value.
pub type Assignment = (String, Setting);

/// The settings that turn `from` into `to`; `None` if a key would have to be removed, or holds several
/// values.
pub fn settings_between(from: &Scenario, to: &Scenario) -> Option<Vec<Assignment>> {
    let [before, mut after] = [from, to].map(|scenario| {
        let mut values = BTreeMap::new();
        if let Ok(table) = to_toml(scenario).parse::<toml::Table>() {
            flatten("", &table, &mut |key, value| drop(values.insert(key, value.clone())));
        }
        values
    });
    for key in before.keys() {
        if !after.contains_key(key) {
            let default = default_word(key)?;
            after.insert(key.clone(), default.into());
        }
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

/// The word that a key has where a file leaves it out.
fn default_word(key: &str) -> Option<&'static str> {
    let name = key.rsplit('.').next();
    let Absent::Word(word) = [ANTI_WINDUP].into_iter().find(|key| name == Some(key.name))?.absent else {
        return None;
    };
    Some(word)
}

/// An assignment in the form of `--set`.
pub fn assignment(key: &str, setting: &Setting) -> String {
    match setting {
        Setting::Number(value) => format!("{key}={value}"),
        Setting::Text(text) => format!("{key}={text}"),
        Setting::Flag(flag) => format!("{key}={flag}"),
    }
}

impl Document {
    /// The text of the file with keys set as `--set` sets them, and everything else unchanged. `None` if a
    /// path leads through something other than tables and lists. With the folder of the file, its base
    /// machine is found from another folder, too.
    pub fn with_settings(&self, settings: &[String], folder: Option<&Path>) -> Option<String> {
        let mut document: DocumentMut = self.text().parse().ok()?;
        if let (Some(folder), Some(base)) = (folder, document.get(BASE.name).and_then(Item::as_str)) {
            let path = folder.join(base).display().to_string();
            set(&mut document, BASE.name, Value::from(path)).ok()?;
        }
        let pairs = settings.iter().map(|setting| setting.split_once('='));
        let pairs: Vec<(&str, &str)> = pairs.collect::<Option<_>>()?;
        self.own_lists(&mut document, pairs.iter().map(|(key, _)| key.trim()));
        for (key, value) in pairs {
            let text = value.trim();
            set(&mut document, key.trim(), text.parse().unwrap_or_else(|_| Value::from(text))).ok()?;
        }
        Some(document.to_string())
    }

    /// Copies each list of another file, or of a `--set`, that contains an entry of `keys` into this file. A
    /// single entry cannot override that of a base machine.
    pub(super) fn own_lists<'k>(&self, document: &mut DocumentMut, keys: impl Iterator<Item = &'k str>) {
        let draft = self.draft();
        for key in keys {
            let mut ways = key.match_indices('.').map(|(end, _)| &key[..end]);
            let list = ways.find_map(|way| {
                let parts: Vec<&str> = way.split('.').collect();
                let node = node_at(&draft.root, &parts)?;
                matches!(node.value, Node::Array(_)).then_some((way, &node.origin))
            });
            let Some((way, origin)) = list.filter(|(_, origin)| origin.source != draft.main) else {
                continue;
            };
            if let Ok(written) = draft.sources.0[origin.source].text[origin.span.clone()].parse::<Value>() {
                // If the path is not a table, setting the entry reports it.
                let _ = set(document, way, written);
            }
        }
    }
}

/// The table of a dotted key, created if necessary, and the key's last part. The error names the part of its
/// path that is not a table.
fn table_of<'d, 'k>(
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

/// The value at a dotted key; entries of lists count from zero.
pub(super) fn value_mut<'d>(document: &'d mut DocumentMut, key: &str) -> Option<&'d mut Value> {
    let mut parts = key.split('.');
    let mut table: &mut dyn TableLike = document.as_table_mut();
    loop {
        let item = table.get_mut(parts.next()?)?;
        if !item.is_table_like() {
            return parts.try_fold(item.as_value_mut()?, |value, part| {
                value.as_array_mut()?.get_mut(part.parse::<usize>().ok()?)
            });
        }
        table = item.as_table_like_mut()?;
    }
}

/// Sets a value, in the place of the old value and with its comments. The error names the part of the path
/// that is not a table.
pub(super) fn set<'k>(document: &mut DocumentMut, key: &'k str, mut value: Value) -> Result<(), &'k str> {
    if let Some(old) = value_mut(document, key) {
        *value.decor_mut() = old.decor().clone();
        *old = value;
        return Ok(());
    }
    let (table, last) = table_of(document, key)?;
    table.insert(last, Item::Value(value));
    Ok(())
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
        let text = document.with_settings(&words, None).unwrap();
        assert_eq!(Document::parse(&text, "block.toml").unwrap().scenario, other);
        assert!(text.contains("# A block on a spring.") && text.contains("mass = 3    # weighed"), "{text}");
        other.machine.springs["leaf"].effects.clear();
        assert_eq!(settings_between(&document.scenario, &other), None);
    }
}
