//! Every key of every file, one line each.
use feeler_catalogue::{Absent, Key, KeyKind, Keyed, Keys, keys, optional};
use feeler_engine::RunSettings;
use feeler_plant::description::Axis;
use feeler_plant::effects::HostKind;

pub(crate) mod arm;
pub(crate) mod cell;
mod controllers;
pub mod dataset;
mod machine;
pub(crate) mod surface;
pub(crate) mod sweep;

pub(crate) use arm::{ARM, JOINT};
pub(crate) use cell::{CELL, CELL_TABLES, HOLD, PLACED, SHARED, START};
pub(crate) use controllers::CONTROLLERS;
pub use controllers::EXAMPLE_KEY;
pub(crate) use dataset::{COLUMN, DATASET, EXPERIMENT};
pub(crate) use machine::{ACTUATORS, BODIES, CONTACTS, KIND, SENSORS, SPRINGS};
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
pub(crate) const RUN_TABLE: &str = RunSettings::TABLE;

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
    finding, as the logarithm of a factor: 0.05 is about 5 %, 0.5 allows factors from 0.61 to 1.65. For \
    dampings and effects the factor is one plus the number: 0.5 allows 0.67 to 1.5. Dotted keys in quotes, \
    as in \"bodies.motor.mass\" = 0.05";
/// The table of effects under an element.
pub(crate) const EFFECTS: &str = "effects";

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::fs;
    use std::path::Path;

    use feeler_control::ControllerSpec;
    use feeler_control::reference::{FOLLOWED, REFERENCE};
    use feeler_plant::description::GROUND;

    use super::arm::JOINTS;
    use super::*;

    /// Words between back-ticks that are no keys: a value of an argument, clauses of a specification, a
    /// column, a unit, and a field of results.
    const OTHER_WORDS: [&str; 6] = ["none", "gains", "overshoot", "load", "raw", EFFECTS];
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
                let (before, rest) = text.split_once("\nmod tests {").unwrap_or((&text, ""));
                let after = rest.split_once("\n}\n").map_or("", |(_, after)| after);
                take(&path, &format!("{before}\n{after}"));
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

    /// Adds the names of a table's keys, and the words that stand for their values.
    fn add_names(shape: &Keys, found: &mut HashSet<&'static str>) {
        let variants = shape.choice.iter().flat_map(|choice| choice.variants);
        found
            .extend(variants.map(|variant| variant.name).chain(shape.choice.iter().map(|choice| choice.key)));
        for key in shape.all_keys() {
            found.insert(key.name);
            match key.kind {
                KeyKind::Word(words) => found.extend(words.iter().map(|word| word.name)),
                KeyKind::WordOrTable(words, inner) => {
                    found.extend(words.iter().map(|word| word.name));
                    add_names(inner, found);
                }
                KeyKind::Table(inner) | KeyKind::QuantityOrTable(_, _, inner) | KeyKind::Reference(inner) => {
                    add_names(inner, found);
                }
                _ => {}
            }
        }
    }

    /// The words between back-ticks of a text: keys, alone or with a value as in `law = "hertz"`.
    fn quoted(text: &str) -> impl Iterator<Item = &str> {
        let is_name = |name: &&str| {
            !name.is_empty() && name.chars().all(|c| c.is_ascii_lowercase() || c == '_') && *name != "_"
        };
        let words = text.split('`').skip(1).step_by(2);
        words.map(|word| word.split_once(" = ").map_or(word, |(key, _)| key)).filter(is_name)
    }

    #[test]
    fn truth_a_key_between_back_ticks_is_declared() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let elements = ELEMENTS.iter().map(|element| &element.shape);
        let tables = [&RUN, &ARM, &JOINT, &DATASET, &COLUMN, &EXPERIMENT, &SWEEP, &AXIS, &KEEP, &REFINE];
        let mut known: HashSet<&str> = TOP.iter().map(|key| key.name).chain([GROUND]).collect();
        for shape in elements.chain(tables).chain([&CELL, &START, &HOLD, &PLACED]) {
            add_names(shape, &mut known);
        }
        // Other formats, formulas of effects, arguments of commands and the manual have words of their own.
        let others =
            ["logs/src", "sim/arm/src", "sim/plant/src/effects", "cli/src/arguments", "files/src/reference"];
        let (mut count, mut unknown) = (0, Vec::new());
        sources(root, &mut |path, text| {
            if others.iter().any(|folder| path.with_extension("").starts_with(root.join(folder))) {
                return;
            }
            for word in literals(text).into_iter().flat_map(quoted) {
                count += 1;
                if !known.contains(word) && !OTHER_WORDS.contains(&word) {
                    unknown.push(format!("{}: {word}", path.display()));
                }
            }
        });
        assert!(count > 50, "only {count} words were found");
        assert_eq!(unknown, Vec::<String>::new());
    }

    /// The string literals of code, without their quotes.
    fn literals(code: &str) -> Vec<&str> {
        let (mut found, mut at) = (Vec::new(), 0);
        while let Some(rest) = code.get(at..).filter(|rest| !rest.is_empty()) {
            at += if rest.starts_with("//") {
                rest.find('\n').unwrap_or(rest.len())
            } else if let Some(inner) = rest.strip_prefix('"') {
                let mut escaped = false;
                let ends = |c: char| {
                    let is_end = c == '"' && !escaped;
                    escaped = c == '\\' && !escaped;
                    is_end
                };
                let length = inner.find(ends).unwrap_or(inner.len());
                found.push(&inner[..length]);
                length + 2
            } else if let Some(hashes) = rest.strip_prefix('r').and_then(|rest| rest.split_once('"'))
                && hashes.0.chars().all(|c| c == '#')
            {
                let end = format!("\"{}", hashes.0);
                2 + 2 * hashes.0.len() + hashes.1.find(&end).unwrap_or(hashes.1.len()) + 1
            } else {
                let quoted = ["'\"'", "'\\\"'"].iter().find(|quoted| rest.starts_with(**quoted));
                quoted.map_or_else(|| rest.chars().next().map_or(1, char::len_utf8), |quoted| quoted.len())
            };
        }
        found
    }

    /// Tables with their keys.
    type Declared<'a> = [(&'a str, Vec<&'a str>)];

    /// The key that a literal of code spells: `springs.{name}.damping`, `run.step` or `output_limit`. A name
    /// of one word means other things too.
    fn spelt<'t>(literal: &'t str, declared: &Declared<'_>, is_declaring: bool) -> Option<&'t str> {
        let in_table = |(table, keys): &(&str, Vec<&str>)| {
            let of_element = literal.split_once(&format!("{table}.{{")).and_then(|(_, rest)| {
                Some(key_at_start(rest.split_once("}.")?.1)).filter(|key| keys.contains(key))
            });
            let of_table =
                literal.strip_prefix(table).and_then(|rest| rest.strip_prefix('.')).and_then(|rest| {
                    let key = key_at_start(rest);
                    let ends = [Some('='), None].contains(&rest[key.len()..].chars().next());
                    Some(key).filter(|key| ends && keys.contains(key))
                });
            of_element.or(of_table)
        };
        let is_key = declared.iter().any(|(_, keys)| keys.contains(&literal));
        let bare = Some(literal).filter(|name| is_key && !is_declaring && name.contains('_'));
        declared.iter().find_map(in_table).or(bare)
    }

    #[test]
    fn truth_code_takes_each_key_from_its_declaration() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let KeyKind::Table(approach) = ControllerSpec::APPROACH.key.kind else { panic!("no table") };
        let declared: Vec<_> = (ELEMENTS.iter().map(|element| (element.table, &element.shape)))
            .chain([(RUN_TABLE, &RUN), (JOINTS, &JOINT), (FOLLOWED.name, &REFERENCE)])
            .chain([(ControllerSpec::APPROACH.key.name, approach)])
            .map(|(table, shape)| (table, shape.all_keys().map(|key| key.name).collect::<Vec<_>>()))
            .collect();
        let (mut count, mut spelt_out) = (0, Vec::new());
        sources(root, &mut |path, text| {
            // Declarations give the names, and effects have parameters of the same names.
            let is_declaring = path.starts_with(root.join("sim/catalogue"))
                || text.contains("feeler_catalogue::{") && text.contains("Key")
                || path.parent().is_some_and(|folder| folder.ends_with("effects"));
            let all = literals(text);
            count += all.len();
            let found = all.iter().filter_map(|literal| spelt(literal, &declared, is_declaring));
            spelt_out.extend(found.map(|key| format!("{}: {key}", path.display())));
        });
        assert!(count > 5_000, "only {count} literals were found");
        assert_eq!(spelt_out, Vec::<String>::new());
    }

    #[test]
    fn truth_a_key_in_a_literal_is_found() {
        let declared = [("run", vec!["step"]), ("springs", vec!["damping"]), ("", vec!["output_limit"])];
        let of = |code| {
            literals(code).iter().find_map(|literal| spelt(literal, &declared, false)).map(str::to_owned)
        };
        for (code, key) in [
            ("format!(\"springs.{name}.damping\")", Some("damping")),
            ("Problem::new(\"run.step\", what)", Some("step")),
            ("format!(\"run.step={step}\")", Some("step")),
            ("(\"output_limit\", 1.0)", Some("output_limit")),
            ("// \"output_limit\"\n'\"', \"damping\", r#\"\"run.step\"\"#", None),
            ("see \"controllers.force.damping\"; run.step", None),
        ] {
            assert_eq!(of(code).as_deref(), key, "{code}");
        }
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
