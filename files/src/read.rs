//! From a table to fields, by its shape: unknown and missing keys, types, units and bounds.

mod values;

use std::collections::HashMap;

use feeler_plant::description::SignalName;
use feeler_plant::names::{did_you_mean, list, nearest};
use feeler_plant::units::Dimension;

use super::dimension::Dim;
use super::problem::Problems;
use super::shape::{Absent, Bound, Choice, Key, Kind, Shape, Unit, Variant};
use super::source::Origin;
use super::tree::{Node, Table, Value};

/// Units that follow from other keys.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scope {
    pub(crate) rotational: bool,
    pub(crate) signal: Dim,
    pub(crate) output: Dim,
    pub(crate) reference: Dim,
    /// `n` of a contact law.
    pub(crate) exponent: f64,
}

impl Scope {
    pub(crate) fn new(rotational: bool) -> Self {
        let number = Dim::from(Dimension::NONE);
        Self { rotational, signal: number, output: number, reference: number, exponent: 1.0 }
    }

    fn dim(&self, unit: Unit) -> Dim {
        match unit {
            Unit::Of(dimension) => dimension.into(),
            Unit::Signal => self.signal,
            Unit::PowerStiffness => Dim::power_stiffness(self.exponent),
            Unit::Output => self.output,
            Unit::OutputPer(dimension) => self.output / dimension.into(),
            Unit::Reference => self.reference,
            Unit::Swept => Dimension::NONE.into(),
        }
    }
}

/// What was read of a key.
#[derive(Clone, Debug)]
pub(crate) enum Field {
    Number(f64),
    Count(u64),
    Flag(bool),
    Text(String),
    Word(&'static str),
    Pair([String; 2]),
    Signal(SignalName),
    Signals(Vec<SignalName>),
    Range([f64; 2]),
    Numbers(Vec<f64>),
    Points(Vec<(f64, f64)>),
    Table(Fields),
}

/// What was read of a table. Where a key was wrong, its field is absent, and a problem has been noted.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fields {
    /// The word of the shape's choice.
    pub(crate) variant: Option<&'static str>,
    values: HashMap<&'static str, Field>,
}

/// Accessors by kind. A key that was wrong gives a harmless stand-in: the file as a whole is refused then,
/// and nothing sees it.
impl Fields {
    pub(crate) fn get(&self, key: &str) -> Option<&Field> {
        self.values.get(key)
    }

    pub(crate) fn number(&self, key: &str) -> f64 {
        self.optional(key).unwrap_or(1.0)
    }

    pub(crate) fn optional(&self, key: &str) -> Option<f64> {
        if let Some(Field::Number(value)) = self.get(key) { Some(*value) } else { None }
    }

    pub(crate) fn count(&self, key: &str) -> Option<u64> {
        if let Some(Field::Count(value)) = self.get(key) { Some(*value) } else { None }
    }

    pub(crate) fn flag(&self, key: &str) -> bool {
        matches!(self.get(key), Some(Field::Flag(true)))
    }

    pub(crate) fn text(&self, key: &str) -> Option<&str> {
        match self.get(key) {
            Some(Field::Text(text)) => Some(text),
            Some(Field::Word(word)) => Some(word),
            _ => None,
        }
    }

    pub(crate) fn pair(&self, key: &str) -> [String; 2] {
        if let Some(Field::Pair(pair)) = self.get(key) { pair.clone() } else { Default::default() }
    }

    pub(crate) fn table(&self, key: &str) -> Option<&Fields> {
        if let Some(Field::Table(fields)) = self.get(key) { Some(fields) } else { None }
    }

    pub(crate) fn range(&self, key: &str) -> Option<[f64; 2]> {
        if let Some(Field::Range(range)) = self.get(key) { Some(*range) } else { None }
    }

    pub(crate) fn numbers(&self, key: &str) -> Option<&[f64]> {
        if let Some(Field::Numbers(numbers)) = self.get(key) { Some(numbers) } else { None }
    }

    pub(crate) fn points(&self, key: &str) -> Vec<(f64, f64)> {
        if let Some(Field::Points(points)) = self.get(key) { points.clone() } else { Vec::new() }
    }
}

/// Reads tables and notes what is wrong with them.
pub(crate) struct Reader<'a> {
    pub(crate) problems: &'a mut Problems,
    pub(crate) scope: Scope,
}

impl Reader<'_> {
    /// The fields of `table`, which stands at `at` under `path`. Keys in `besides` are left to others.
    pub(crate) fn fields(
        &mut self,
        shape: &'static Shape,
        besides: &[&str],
        table: &Table,
        at: &Origin,
        path: &str,
    ) -> Fields {
        let chosen = shape.choice.as_ref().map(|choice| self.choose(choice, table, at, path));
        let mut fields = Fields::default();
        let mut keys: Vec<&'static Key> = shape.keys.iter().collect();
        if let Some(Some(variant)) = chosen {
            fields.variant = Some(variant.name);
            keys.extend(variant.keys);
        }
        let known = if matches!(chosen, Some(None)) { shape.all_keys().collect() } else { keys.clone() };
        let misspelt = self.unknown(shape, &known, besides, table, path);
        for key in keys {
            let path = join(path, key.name);
            let field = match table.get(key.name) {
                Some(entry) => self.field(key, &entry.node, &path),
                // A key that is there under a wrong name has been noted, and is not missing as well.
                None if key.absent == Absent::Required && misspelt.contains(&key.name) => None,
                None => self.absent(key, at, &path),
            };
            if let Some(field) = field {
                fields.values.insert(key.name, field);
            }
        }
        fields
    }

    /// The variant that a table names; where there is none, a problem is noted.
    fn choose(
        &mut self,
        choice: &Choice,
        table: &Table,
        at: &Origin,
        path: &str,
    ) -> Option<&'static Variant> {
        let names = || choice.variants.iter().map(|variant| variant.name);
        if choice.key.is_empty() {
            // Told by which key is there.
            let found: Vec<_> =
                choice.variants.iter().filter(|variant| table.contains_key(variant.name)).collect();
            if let [one] = found.as_slice() {
                return Some(one);
            }
            let remedy = format!("give one of {}", list(names()));
            self.problems.add(
                at,
                path,
                if found.is_empty() { "says nothing" } else { "says two things" },
                remedy,
            );
            return None;
        }
        let path = join(path, choice.key);
        let Some(entry) = table.get(choice.key) else {
            let default = choice
                .default
                .and_then(|default| choice.variants.iter().find(|variant| variant.name == default));
            if default.is_none() {
                let remedy = format!("add `{} = \"...\"`: {}", choice.key, list(names()));
                self.problems.add(at, &path, format!("`{}` is missing", choice.key), remedy);
            }
            return default;
        };
        let Some(text) = entry.node.as_text() else {
            let message = format!("this must be a text, not {}", entry.node.value.kind());
            self.problems.add(&entry.node.origin, &path, message, format!("one of {}", list(names())));
            return None;
        };
        let found = choice.variants.iter().find(|variant| variant.name == text);
        if found.is_none() {
            self.problems.add(
                &entry.node.origin,
                &path,
                format!("there is no {} `{text}`", choice.key),
                did_you_mean(text, names()),
            );
        }
        found
    }

    /// Notes the keys that do not exist, and gives those that they may stand for.
    fn unknown(
        &mut self,
        shape: &'static Shape,
        keys: &[&'static Key],
        besides: &[&str],
        table: &Table,
        path: &str,
    ) -> Vec<&'static str> {
        let mut meant = Vec::new();
        let choice = shape.choice.as_ref().map(|choice| choice.key).filter(|key| !key.is_empty());
        let known = || keys.iter().map(|key| key.name).chain(choice).chain(besides.iter().copied());
        for (name, entry) in table {
            if known().any(|key| key == name) {
                continue;
            }
            let elsewhere = shape.variant_of(name).zip(choice);
            let (message, remedy) = if let Some((variant, choice)) = elsewhere {
                let message =
                    format!("`{name}` has no meaning here: it belongs to {choice} = \"{}\"", variant.name);
                (message, format!("remove it, or set {choice} = \"{}\"", variant.name))
            } else {
                let absent = keys.iter().map(|key| key.name).filter(|key| !table.contains_key(*key));
                meant.extend(absent.filter(|key| nearest(name, known()) == Some(*key)));
                (format!("there is no key `{name}` here"), did_you_mean(name, known()))
            };
            self.problems.add(&entry.key, join(path, name), message, remedy);
        }
        meant
    }

    fn absent(&mut self, key: &Key, at: &Origin, path: &str) -> Option<Field> {
        match key.absent {
            Absent::Required => {
                let remedy = format!("add `{} = {}`: {}", key.name, self.example(key.kind), key.text);
                self.problems.add(at, path, format!("`{}` is missing", key.name), remedy);
                None
            }
            Absent::Nothing => None,
            Absent::Number(value) => Some(Field::Number(value)),
            Absent::Count(count) => Some(Field::Count(count)),
            Absent::Flag(flag) => Some(Field::Flag(flag)),
            Absent::Word(word) => Some(Field::Word(word)),
        }
    }

    fn example(&self, kind: Kind) -> String {
        match kind {
            Kind::Quantity(unit, _) => match self.scope.dim(unit).si_unit(self.scope.rotational) {
                unit if unit.is_empty() => "1.0".into(),
                unit => format!("\"... {unit}\""),
            },
            Kind::Count(..) => "1".into(),
            Kind::Flag => "true".into(),
            Kind::Pair | Kind::Signals => "[\"...\", \"...\"]".into(),
            Kind::Range(_) => "[..., ...]".into(),
            Kind::Numbers(_, count) => format!("[{}]", vec!["..."; count.max(1)].join(", ")),
            Kind::Points(_) => "[[0.0, ...], ...]".into(),
            _ => "\"...\"".into(),
        }
    }

    /// One value. `None` where it is wrong; the problem is noted.
    fn field(&mut self, key: &'static Key, node: &Node, path: &str) -> Option<Field> {
        match key.kind {
            Kind::Quantity(unit, bound) => self.quantity(node, unit, bound, path).map(Field::Number),
            Kind::Count(least, most) => self.count(node, least, most, path).map(Field::Count),
            Kind::Flag => match node.value {
                Value::Flag(flag) => Some(Field::Flag(flag)),
                _ => self.mistyped(node, "true or false", path),
            },
            Kind::Text | Kind::Name(_) => match &node.value {
                Value::Text(text) => Some(Field::Text(text.clone())),
                _ => self.mistyped(node, if let Kind::Name(what) = key.kind { what } else { "a text" }, path),
            },
            Kind::Pair => match &node.value {
                Value::Array(items) => match items.as_slice() {
                    [Node { value: Value::Text(a), .. }, Node { value: Value::Text(b), .. }] => {
                        Some(Field::Pair([a.clone(), b.clone()]))
                    }
                    _ => self.mistyped(node, "a list of two body names, as in [\"ground\", \"motor\"]", path),
                },
                _ => self.mistyped(node, "a list of two body names, as in [\"ground\", \"motor\"]", path),
            },
            Kind::Signal => self.signal(node, path).map(Field::Signal),
            Kind::Signals => {
                let items = self.list(node, "a list of signals", path)?;
                Some(Field::Signals(items.iter().filter_map(|item| self.signal(item, path)).collect()))
            }
            Kind::Word(words) => self.word(node, words, path).map(Field::Word),
            Kind::Table(shape) => match &node.value {
                Value::Table(table) => Some(Field::Table(self.fields(shape, &[], table, &node.origin, path))),
                _ => self.mistyped(node, "a table", path),
            },
            Kind::QuantityOrTable(short, unit, shape) => {
                if let Value::Table(table) = &node.value {
                    return Some(Field::Table(self.fields(shape, &[], table, &node.origin, path)));
                }
                let value = self.quantity(node, unit, Bound::Positive, path)?;
                let values = [(short, Field::Number(value))].into();
                Some(Field::Table(Fields { variant: None, values }))
            }
            Kind::WordOrTable(words, shape) => match &node.value {
                Value::Table(table) => Some(Field::Table(self.fields(shape, &[], table, &node.origin, path))),
                _ => self.word(node, words, path).map(Field::Word),
            },
            Kind::Range(unit) => self.range(node, unit, path).map(Field::Range),
            Kind::Numbers(unit, count) => self.numbers(node, unit, count, path).map(Field::Numbers),
            Kind::Points(unit) => self.points(node, unit, path).map(Field::Points),
            Kind::Reference(shape) => match &node.value {
                Value::Array(_) => self.points(node, Unit::Reference, path).map(Field::Points),
                Value::Table(table) => Some(Field::Table(self.fields(shape, &[], table, &node.origin, path))),
                _ => self.quantity(node, Unit::Reference, Bound::Any, path).map(Field::Number),
            },
        }
    }
}

/// A dotted path.
pub(crate) fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}
