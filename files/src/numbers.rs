//! The numbers of a file that can be changed, and the file with some of them changed: comments, order and
//! units stay.

use toml_edit::{DocumentMut, Item, Value as Toml};

use super::document::Document;
use super::edit::{flatten, table_of};
use super::keys::TOLERANCE;
use super::problem::{FormatError, Problems};
use super::source::Origin;
use super::sweep::unit_of_key;
use super::tree::{Table, Value};
use super::units;

/// Significant digits of numbers that are written into a file.
const DIGITS: usize = 6;

/// A number of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// Its dotted path.
    pub key: String,
    /// Its value, SI.
    pub value: f64,
    /// Its SI unit; empty if it has none.
    pub unit: String,
}

/// A new value for a number of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    /// Its dotted path.
    pub key: String,
    /// The new value, SI.
    pub value: f64,
}

impl Document {
    /// Every number of the file and of its base machine, in their order, except those of lists and
    /// tolerances.
    pub fn numbers(&self) -> Vec<Number> {
        let mut found = Vec::new();
        self.gather(&self.draft().root, "", &mut found);
        found
    }

    fn gather(&self, table: &Table, path: &str, found: &mut Vec<Number>) {
        for (name, entry) in table {
            let key = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            let value = match &entry.node.value {
                Value::Table(inner) if key != TOLERANCE => {
                    self.gather(inner, &key, found);
                    continue;
                }
                Value::Integer(whole) => *whole as f64,
                Value::Float(value) => *value,
                Value::Text(text) => match units::parse_any(text) {
                    Ok(value) => value,
                    Err(_) => continue,
                },
                _ => continue,
            };
            let unit = unit_of_key(&key, &self.scenario);
            found.push(Number { key, value, unit });
        }
    }

    /// Every key of the scenario with its content, without defaults: equivalent documents give the same list.
    pub fn keys(&self) -> Vec<(String, String)> {
        let mut found = Vec::new();
        // The text written here is valid TOML.
        let written = toml::from_str(&self.to_toml()).unwrap_or_default();
        flatten("", &written, &mut |key, value| found.push((key, value.to_string())));
        found
    }

    /// The text of the file with some numbers changed. A number with a unit keeps its unit. A number of the
    /// base machine gets a key in this file, which overrides it.
    ///
    /// # Errors
    /// A path that leads through something other than tables.
    pub fn edited(&self, edits: &[Edit]) -> Result<String, FormatError> {
        with_numbers(self.text(), edits).map_err(|(key, message)| {
            let mut problems = Problems::default();
            let remedy = "change it in the file by hand";
            problems.add(&Origin { source: self.draft().main, span: 0..0 }, &key, message, remedy);
            problems.into_error(self.draft().sources.clone())
        })
    }
}

/// The text of a file with some numbers changed.
///
/// # Errors
/// The key and the reason, if the text is no TOML or the key leads through something other than tables.
pub fn with_numbers(text: &str, edits: &[Edit]) -> Result<String, (String, String)> {
    let mut document: DocumentMut =
        text.parse().map_err(|e: toml_edit::TomlError| (String::new(), e.to_string()))?;
    for edit in edits {
        let (table, last) = table_of(&mut document, &edit.key)
            .map_err(|part| (edit.key.clone(), format!("`{part}` is not a table")))?;
        if let Some(value) = table.get_mut(last).and_then(Item::as_value_mut) {
            let mut changed = written(edit.value, value);
            *changed.decor_mut() = value.decor().clone();
            *value = changed;
        } else {
            table.insert(last, Item::Value(rounded(edit.value, DIGITS).into()));
        }
    }
    Ok(document.to_string())
}

/// A number in the form of the value that it replaces: with a unit if that has one.
fn written(value: f64, before: &Toml) -> Toml {
    let unit = before.as_str().and_then(|text| {
        let (_, unit) = units::number_and_unit(text).ok().filter(|(_, unit)| !unit.is_empty())?;
        let one = units::parse_any(&format!("1 {unit}")).ok()?;
        Some(format!("{} {unit}", rounded(value / one, DIGITS)))
    });
    unit.map_or_else(|| rounded(value, DIGITS).into(), Toml::from)
}

/// A number rounded to `digits` significant digits, at least one.
pub fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"# An axis.

[bodies.tip]   # what moves
mass = "500 g"   # weighed

[springs.wall]
between = ["ground", "tip"]
stiffness = 2e4
[springs.wall.effects]
coulomb-friction = { level = 3.0 } # guessed
"#;

    fn edit(key: &str, value: f64) -> Edit {
        Edit { key: key.into(), value }
    }

    #[test]
    fn truth_comments_order_and_units_stay() {
        let edits = [
            edit("bodies.tip.mass", 0.7),
            edit("springs.wall.stiffness", 31_234.567_8),
            edit("springs.wall.effects.coulomb-friction.level", 4.25),
            edit("springs.wall.damping", 12.0),
        ];
        let expected = TEXT
            .replace("500 g", "700 g")
            .replace("2e4\n", "31234.6\ndamping = 12.0\n")
            .replace("3.0", "4.25");
        assert_eq!(with_numbers(TEXT, &edits).unwrap(), expected);
        assert_eq!(with_numbers(TEXT, &[]).unwrap(), TEXT);
    }

    #[test]
    fn truth_a_key_of_another_file_is_written_over_here() {
        let text = "machine = \"axis.toml\"\n";
        let found = with_numbers(text, &[edit("controllers.force.kp", 0.8)]).unwrap();
        assert_eq!(found, "machine = \"axis.toml\"\n\n[controllers.force]\nkp = 0.8\n");
        assert!(with_numbers(text, &[edit("machine.x.y", 1.0)]).is_err());
    }

    #[test]
    fn truth_every_number_has_its_value_and_unit() {
        let document = Document::parse(TEXT, "axis.toml").unwrap();
        let found = document.numbers();
        let of = |key: &str| found.iter().find(|number| number.key == key).unwrap();
        assert!((of("bodies.tip.mass").value - 0.5).abs() < 1e-15 && of("bodies.tip.mass").unit == "kg");
        assert_eq!(of("springs.wall.effects.coulomb-friction.level").unit, "N");
        assert_eq!(found.len(), 3);
    }
}
