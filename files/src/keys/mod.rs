//! Every key of every file, one line each.
use feeler_catalogue::{Absent, Key, KeyKind, Keyed, Keys, keys, optional};
use feeler_engine::RunSettings;
use feeler_plant::description::Axis;
use feeler_plant::effects::HostKind;

pub(crate) mod arm;
pub(crate) mod cell;
mod controllers;
pub(crate) mod dataset;
mod machine;
pub(crate) mod surface;
pub(crate) mod sweep;

pub(crate) use arm::{ARM, JOINT};
pub(crate) use cell::{CELL, CELL_TABLES, HOLD, PLACED, SHARED, START};
pub(crate) use controllers::CONTROLLERS;
pub use controllers::EXAMPLE_KEY;
pub(crate) use dataset::{COLUMN, DATASET, EXPERIMENT};
pub(crate) use machine::{ACTUATORS, BODIES, CONTACTS, KIND, LAW, SENSORS, SPRINGS};
pub(crate) use sweep::{AXIS, KEEP, REFINE, SWEEP};

/// A table of named elements, as `[bodies.NAME]`.
#[derive(Debug)]
pub(crate) struct Element {
    pub(crate) table: &'static str,
    /// Word for a single element.
    pub(crate) singular: &'static str,
    pub(crate) text: &'static str,
    pub(crate) shape: Keys,
    /// Kinds of the element in the effects library; some depend on the element's own keys.
    pub(crate) hosts: &'static [HostKind],
}

/// The table of how to run.
pub(crate) const RUN_TABLE: &str = "run";

/// `[run]`
pub(crate) static RUN: Keys = Keys { keys: keys!(RunSettings::FIELDS), choice: None };

/// Tables of named elements, in the order of the manual.
pub(crate) static ELEMENTS: [&Element; 6] =
    [&BODIES, &SPRINGS, &CONTACTS, &ACTUATORS, &SENSORS, &CONTROLLERS];

pub(crate) const NAME: Key = optional(
    "name",
    KeyKind::Text,
    "short name; that of the file itself if absent, never that of a base file",
);
pub(crate) const ABOUT: Key = optional("about", KeyKind::Text, "what it is for, in one or two sentences");
pub(crate) const AXIS_KIND: Key = Key {
    name: "axis",
    kind: KeyKind::Word(Axis::WORDS),
    absent: Absent::Word(Axis::Translational.name()),
    text: "kind of coordinate",
};
pub(crate) const BASE: Key =
    optional("machine", KeyKind::Text, "a base file, relative to this one; keys here replace its keys");

/// Keys at the top of a machine or scenario.
pub(crate) static TOP: &[Key] = &[NAME, ABOUT, AXIS_KIND, BASE];

/// The table of tolerances.
pub(crate) const TOLERANCE: &str = "tolerance";
/// Meaning of `[tolerance]`.
pub(crate) const TOLERANCE_TEXT: &str = "how far a believed value may be off before that counts as a \
    finding, as the logarithm of a factor: 0.05 is about 5 %, 0.5 allows factors from 0.61 to 1.65. Dotted \
    keys in quotes, as in \"bodies.motor.mass\" = 0.05";
/// The table of effects under an element.
pub(crate) const EFFECTS: &str = "effects";

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    const NOT_PRODUCT: [&str; 5] = ["target", "tests", "benches", "blind", ".git"];

    /// Passes every source file of product code below a folder, without its tests.
    fn sources(folder: &Path, take: &mut dyn FnMut(&Path, &str)) {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                if !NOT_PRODUCT.iter().any(|name| path.ends_with(name)) {
                    sources(&path, take);
                }
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = fs::read_to_string(&path).unwrap();
                take(&path, text.split("#[cfg(test)]\nmod").next().unwrap_or_default());
            }
        }
    }

    fn key_at_start(text: &str) -> &str {
        &text[..text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len())]
    }

    /// The keys of a table that a text names, as in `controllers.force.kp`, `controllers.{name}.kp` and
    /// `run.step`.
    fn named<'t>(text: &'t str, table: &str, has_elements: bool) -> Vec<&'t str> {
        let of_place = |(at, _): (usize, _)| {
            // Code reads members with the same names.
            let before = text[..at].chars().next_back()?;
            let rest = text[at + table.len()..].strip_prefix('.').filter(|_| "\"`'".contains(before))?;
            let is_name = |c: char| c.is_alphanumeric() || "_-{}".contains(c);
            let rest = if has_elements {
                rest.trim_start_matches(is_name).strip_prefix('.').filter(|_| rest.starts_with(is_name))?
            } else {
                rest
            };
            Some(key_at_start(rest)).filter(|key| !key.is_empty())
        };
        text.match_indices(table).filter_map(of_place).collect()
    }

    #[test]
    fn truth_a_key_that_a_message_names_is_declared() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let tables = ELEMENTS.iter().map(|element| (element.table, &element.shape, true));
        let tables: Vec<_> = tables.chain([(RUN_TABLE, &RUN, false)]).collect();
        let (mut count, mut unknown) = (0, Vec::new());
        sources(root, &mut |path, text| {
            for (table, shape, has_elements) in &tables {
                for key in named(text, table, *has_elements) {
                    let is_choice = shape.choice.as_ref().is_some_and(|choice| choice.key == key);
                    count += 1;
                    if !is_choice && key != EFFECTS && shape.all_keys().all(|known| known.name != key) {
                        unknown.push(format!("{}: {table}: {key}", path.display()));
                    }
                }
            }
        });
        assert!(count > 30, "only {count} keys were found");
        assert_eq!(unknown, Vec::<String>::new());
    }

    #[test]
    fn truth_keys_are_found_in_texts_and_not_in_code() {
        let found = |text| named(text, CONTROLLERS.table, true);
        assert_eq!(found("see `controllers.force.kp`"), ["kp"]);
        assert_eq!(found("format!(\"controllers.{name}.low_pass.corner\")"), ["low_pass"]);
        assert_eq!(found("scenario.controllers.x.spec, \"controllers.{name}\""), [""; 0]);
        assert_eq!(named("'run.step=1', self.run.step_s", RUN_TABLE, false), ["step"]);
    }
}
