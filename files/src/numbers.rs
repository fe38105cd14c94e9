//! The numbers of a file that can be changed, and the file with some numbers changed: comments, order and
//! units are kept.

use toml_edit::{DocumentMut, Value as Toml};

use super::document::Document;
use super::edit::{flatten, set, value_mut};
use super::keys::TOLERANCE;
use super::problem::{FormatError, Problems};
use super::read::join;
use super::source::Origin;
use super::sweep::unit_of_key;
use super::tree::Value;
use super::units;

/// Significant digits of numbers that are written into a file.
const DIGITS: usize = 6;
/// Largest number of entries of a list whose numbers can be changed one by one; a longer list is data.
const MOST_LISTED: usize = 64;

/// A number of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    pub key: String,
    /// Value of the number, SI.
    pub value: f64,
    /// SI unit of the number; empty if it has none.
    pub unit: String,
}

/// A new value for a number of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    pub key: String,
    /// The new value, SI.
    pub value: f64,
}

impl Document {
    /// Every number of the file and of its base machine, in their order, except tolerances and lists of more
    /// than 64 entries. Entries of lists count from zero, as in `controllers.force.reference.1.0`.
    pub fn numbers(&self) -> Vec<Number> {
        let mut found = Vec::new();
        for (name, entry) in self.draft().root.iter().filter(|(name, _)| *name != TOLERANCE) {
            self.gather(name.clone(), &entry.node.value, &mut found);
        }
        found
    }

    fn gather(&self, key: String, value: &Value, found: &mut Vec<Number>) {
        let value = match value {
            Value::Table(inner) => {
                for (name, entry) in inner {
                    self.gather(join(&key, name), &entry.node.value, found);
                }
                return;
            }
            Value::Array(items) if items.len() <= MOST_LISTED => {
                for (index, item) in items.iter().enumerate() {
                    self.gather(join(&key, &index.to_string()), &item.value, found);
                }
                return;
            }
            Value::Integer(whole) => *whole as f64,
            Value::Float(value) => *value,
            Value::Text(text) => match units::parse_any(text) {
                Ok(value) => value,
                Err(_) => return,
            },
            _ => return,
        };
        let unit = self.unit(&key);
        found.push(Number { key, value, unit });
    }

    /// The SI unit of the number at a key; empty if it has none.
    pub fn unit(&self, key: &str) -> String {
        unit_of_key(key, &self.scenario)
    }

    /// Every key of the scenario with its content, without defaults: equivalent documents give the same list.
    pub fn keys(&self) -> Vec<(String, String)> {
        let mut found = Vec::new();
        // The text written here is valid TOML.
        let written = toml::from_str(&self.to_toml()).unwrap_or_default();
        flatten("", &written, &mut |key, value| found.push((key, value.to_string())));
        found
    }

    /// The text of the file with some numbers changed. A number with a unit keeps the unit. A number of the
    /// base machine gets a key in this file, which overrides it; a list is overridden as a whole.
    ///
    /// # Errors
    /// A path that leads through something other than tables and lists.
    pub fn edited(&self, edits: &[Edit]) -> Result<String, FormatError> {
        let changed = parsed(self.text()).and_then(|mut document| {
            self.own_lists(&mut document, edits.iter().map(|edit| edit.key.as_str()));
            changed(document, edits)
        });
        changed.map_err(|(key, message)| {
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
/// The key and the reason, if the text is not TOML or the key leads through something other than tables and
/// lists.
pub fn with_numbers(text: &str, edits: &[Edit]) -> Result<String, (String, String)> {
    changed(parsed(text)?, edits)
}

fn parsed(text: &str) -> Result<DocumentMut, (String, String)> {
    text.parse().map_err(|e: toml_edit::TomlError| (String::new(), e.to_string()))
}

fn changed(mut document: DocumentMut, edits: &[Edit]) -> Result<String, (String, String)> {
    for Edit { key, value } in edits {
        let number = value_mut(&mut document, key)
            .map_or_else(|| rounded(*value, DIGITS).into(), |before| written(*value, before));
        set(&mut document, key, number).map_err(|part| (key.clone(), format!("`{part}` is not a table")))?;
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
    use super::super::draft::Draft;
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

    /// Entries keep their units and places. A list of the base machine, or of a `--set`, is written as a
    /// whole.
    #[test]
    fn truth_entries_of_lists_are_numbers_too() {
        let folder = tempfile::tempdir().unwrap();
        let load = |name: &str, set: &[&str]| {
            let set: Vec<String> = set.iter().map(|set| (*set).to_owned()).collect();
            Draft::load_with(&folder.path().join(name), &set).unwrap().build().unwrap()
        };
        let axis = |points: &str| {
            format!(
                "{TEXT}\n[actuators.drive]\non = \"tip\"\n\n[controllers.a]\nlaw = \"open-loop\"\n\
                 drives = \"drive\"\nperiod = \"1 ms\"\nreference = {points} # a step\n"
            )
        };
        let text = axis("[[0.0, 0.0], [\"100 ms\",  \"2 kN\"]]");
        std::fs::write(folder.path().join("axis.toml"), &text).unwrap();
        std::fs::write(folder.path().join("over.toml"), "machine = \"axis.toml\"\n").unwrap();
        let (own, over) = (load("axis.toml", &[]), load("over.toml", &[]));
        for (key, value, unit) in [("1.0", 0.1, "s"), ("1.1", 2000.0, "N")] {
            let key = format!("controllers.a.reference.{key}");
            let found = own.numbers().into_iter().find(|number| number.key == key);
            assert_eq!(found, Some(Number { key, value, unit: unit.into() }));
        }
        let [first, second, third] = [0, 1, 2].map(|i| format!("controllers.a.reference.{i}.1"));
        let edits = [edit(&second, 3e3), edit(&first, 1e3)];
        let changed = "[[0.0, 1000.0], [\"100 ms\",  \"3 kN\"]]";
        assert_eq!(own.edited(&edits).unwrap(), axis(changed));
        let written = format!("machine = \"axis.toml\"\n\n[controllers.a]\nreference = {changed}\n");
        assert_eq!(over.edited(&edits).unwrap(), written);
        let set = [format!("{second}=3 kN"), format!("{first}=1 kN")];
        let written = over.with_settings(&set, None).unwrap();
        assert!(written.ends_with("reference = [[0.0, \"1 kN\"], [\"100 ms\",  \"3 kN\"]]\n"), "{written}");
        let longer = load("axis.toml", &["controllers.a.reference=[[0.0, 0.0], [0.1, 1.0], [0.2, 2.0]]"]);
        let written = longer.edited(&[edit(&third, 3.0)]).unwrap();
        assert_eq!(written, axis("[[0.0, 0.0], [0.1, 1.0], [0.2, 3.0]]"));
        let beyond = Draft::load_with(&folder.path().join("axis.toml"), &[format!("{third}=1")]).unwrap_err();
        let [problem] = beyond.problems.as_slice() else { panic!("{beyond:?}") };
        assert!(problem.remedy.contains("`controllers.a.reference.1`"), "{beyond:?}");
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
