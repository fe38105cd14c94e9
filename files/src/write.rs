//! From a scenario back to a file: plain numbers in SI, and only differences from the defaults.

mod controllers;
mod driven;
mod machine;

use std::fmt::Write as _;

use feeler_catalogue::{Content, Contents, Keyed, Keys};
use feeler_engine::{RunSettings, Scenario};
use feeler_plant::description::{Axis, Machine};
use feeler_plant::effects::EffectUse;
use indexmap::IndexMap;

use super::document::Document;
use super::keys::{ABOUT, AXIS_KIND, EFFECTS, Element, NAME, RUN_TABLE, TOLERANCE};

pub use driven::{Commands, driven_to_toml, samples_csv};

/// The file of a scenario; reading it gives exactly the same scenario.
///
/// The mass that a controller's approach moves is not written, because the reader computes it from the
/// machine.
pub fn to_toml(scenario: &Scenario) -> String {
    let mut writer = Writer::default();
    writer.machine(&scenario.machine);
    for (name, controller) in &scenario.controllers {
        writer.controller(name, controller);
    }
    writer.run(&scenario.run);
    writer.text
}

/// The file of a machine alone.
pub fn machine_to_toml(machine: &Machine) -> String {
    let mut writer = Writer::default();
    writer.machine(machine);
    writer.text
}

impl Document {
    /// The file of this document, without its comments: as [`to_toml`], and with the tolerances.
    pub fn to_toml(&self) -> String {
        let mut writer = Writer { text: to_toml(&self.scenario) };
        writer.tolerance(&self.tolerance);
        writer.text
    }
}

#[derive(Default)]
struct Writer {
    text: String,
}

/// A number as text that is read back with the same bits.
fn number(value: f64) -> String {
    format!("{value:?}")
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// A key, in quotes if necessary.
fn key(name: &str) -> String {
    let bare = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    if bare { name.to_owned() } else { quoted(name) }
}

/// The content of a key, on one line.
fn inline(content: &Content) -> String {
    let list = |items: Vec<String>| format!("[{}]", items.join(", "));
    match content {
        Content::Number(value) => number(*value),
        Content::Count(count) => count.to_string(),
        Content::Flag(flag) => flag.to_string(),
        Content::Text(text) => quoted(text),
        Content::Word(word) => quoted(word),
        Content::Texts(texts) => list(texts.iter().map(|text| quoted(text)).collect()),
        Content::Pair(pair) => list(pair.iter().map(|text| quoted(text)).collect()),
        Content::Range(range) => list(range.iter().copied().map(number).collect()),
        Content::Numbers(numbers) => list(numbers.iter().copied().map(number).collect()),
        Content::Points(pairs) => list(
            pairs.iter().map(|(time, value)| format!("[{}, {}]", number(*time), number(*value))).collect(),
        ),
        Content::Table(table) => inline_table(None, table),
    }
}

/// A table of a shape on one line: the key of its form comes first.
fn inline_of(shape: &Keys, table: &Contents) -> String {
    let form = shape.choice.as_ref().map(|choice| choice.key).zip(table.variant);
    inline_table(form, table)
}

fn inline_table(form: Option<(&str, &str)>, table: &Contents) -> String {
    let form = form.map(|(key, form)| format!("{key} = {}", quoted(form)));
    let lines = table.iter().map(|(name, content)| format!("{name} = {}", inline(content)));
    format!("{{ {} }}", form.into_iter().chain(lines).collect::<Vec<_>>().join(", "))
}

impl Writer {
    fn line(&mut self, key: &str, value: impl AsRef<str>) {
        let _ = writeln!(self.text, "{key} = {}", value.as_ref());
    }

    fn header(&mut self, path: &[&str]) {
        if !self.text.is_empty() {
            self.text.push('\n');
        }
        let path: Vec<String> = path.iter().map(|segment| key(segment)).collect();
        let _ = writeln!(self.text, "[{}]", path.join("."));
    }

    fn number(&mut self, key: &str, value: f64) {
        self.line(key, number(value));
    }

    fn words(&mut self, key: &str, value: &str) {
        self.line(key, quoted(value));
    }

    /// The keys of a record, except the one of its form.
    fn record(&mut self, record: &impl Keyed) {
        for (name, content) in record.contents().iter() {
            self.line(name, inline(content));
        }
    }

    fn form<T: Keyed>(&mut self, element: &Element, record: &T) {
        if let Some((choice, form)) = element.shape.choice.as_ref().zip(record.form()) {
            self.words(choice.key, form.name);
        }
    }

    fn effects(&mut self, table: &str, element: &str, effects: &[EffectUse]) {
        for effect in effects {
            self.header(&[table, element, EFFECTS, effect.definition.name]);
            for (parameter, value) in effect.definition.parameters.iter().zip(&effect.values) {
                self.number(parameter.name, *value);
            }
        }
    }

    fn machine(&mut self, machine: &Machine) {
        self.words(NAME.name, &machine.name);
        if !machine.about.is_empty() {
            self.words(ABOUT.name, &machine.about);
        }
        if machine.axis == Axis::Rotational {
            self.words(AXIS_KIND.name, machine.axis.name());
        }
        self.elements(machine);
    }

    /// All keys of a run, so that it does not depend on defaults of the machine.
    fn run(&mut self, run: &RunSettings) {
        self.header(&[RUN_TABLE]);
        for field in RunSettings::FIELDS {
            if let Some(content) = (field.get)(run) {
                self.line(field.key.name, inline(&content));
            }
        }
    }

    fn tolerance(&mut self, tolerance: &IndexMap<String, f64>) {
        if !tolerance.is_empty() {
            self.header(&[TOLERANCE]);
        }
        for (path, share) in tolerance {
            self.number(&quoted(path), *share);
        }
    }
}
