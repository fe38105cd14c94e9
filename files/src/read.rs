//! From a table to fields, by its shape: unknown and missing keys, types, units and bounds.

mod values;

use feeler_catalogue::{
    Absent, Bound, Choice, Content, Contents, Dimension, Key, KeyKind, Keys, Unit, Variant,
};
use feeler_plant::names::{did_you_mean, list, nearest};

use super::problem::Problems;
use super::source::Origin;
use super::tree::{Node, Table, Value};

/// Units that follow from other keys.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scope {
    pub(crate) rotational: bool,
    pub(crate) signal: Dimension,
    pub(crate) output: Dimension,
    pub(crate) reference: Dimension,
    /// `n` of a contact law.
    pub(crate) exponent: f64,
}

impl Scope {
    pub(crate) fn new(rotational: bool) -> Self {
        let number = Dimension::NONE;
        Self { rotational, signal: number, output: number, reference: number, exponent: 1.0 }
    }

    pub(crate) fn dim(&self, unit: Unit) -> Dimension {
        match unit {
            Unit::Of(dimension) => dimension,
            Unit::Signal => self.signal,
            Unit::Pressure => Dimension::power_stiffness(2.0),
            Unit::PowerStiffness => Dimension::power_stiffness(self.exponent),
            Unit::Output => self.output,
            Unit::OutputPer(dimension) => self.output / dimension,
            Unit::Reference => self.reference,
            Unit::Swept => Dimension::NONE,
        }
    }
}

/// Reads tables and records their mistakes.
pub(crate) struct Reader<'a> {
    pub(crate) problems: &'a mut Problems,
    pub(crate) scope: Scope,
}

impl Reader<'_> {
    /// The fields of `table`, which is at `at` under `path`. Keys in `besides` are ignored.
    pub(crate) fn fields(
        &mut self,
        shape: &'static Keys,
        besides: &[&str],
        table: &Table,
        at: &Origin,
        path: &str,
    ) -> Contents {
        let chosen = shape.choice.as_ref().map(|choice| self.choose(choice, table, at, path));
        let mut fields = Contents::new(chosen.flatten().map(|variant| variant.name));
        let mut keys: Vec<&'static Key> = shape.keys.iter().collect();
        if let Some(Some(variant)) = chosen {
            keys.extend(variant.keys);
        }
        let known: Vec<_> = match chosen {
            Some(None) => shape.all_keys().collect(),
            // A message lists only the first keys, so those of this variant come before the common ones.
            Some(Some(variant)) => variant.keys.iter().chain(shape.keys).collect(),
            None => keys.clone(),
        };
        let misspelt = self.unknown(shape, &known, besides, table, path);
        for key in keys {
            let path = join(path, key.name);
            let field = match table.get(key.name) {
                Some(entry) => self.field(key, &entry.node, &path),
                // A misspelt key has been recorded, so it is not reported as missing too.
                None if key.absent == Absent::Required && misspelt.contains(&key.name) => None,
                None => self.absent(key, at, &path),
            };
            if let Some(field) = field {
                fields.insert(key.name, field);
            }
        }
        fields
    }

    /// The variant of a table; a problem is recorded if there is none.
    fn choose(
        &mut self,
        choice: &Choice,
        table: &Table,
        at: &Origin,
        path: &str,
    ) -> Option<&'static Variant> {
        let names = || choice.variants.iter().map(|variant| variant.name);
        if choice.key.is_empty() {
            // The key that is present selects the variant.
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

    /// Records the keys that do not exist, and returns the keys that they probably mean.
    fn unknown(
        &mut self,
        shape: &'static Keys,
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

    fn absent(&mut self, key: &Key, at: &Origin, path: &str) -> Option<Content> {
        match key.absent {
            Absent::Required => {
                let remedy = format!("add `{} = {}`: {}", key.name, self.example(key.kind), key.text);
                self.problems.add(at, path, format!("`{}` is missing", key.name), remedy);
                None
            }
            Absent::Nothing => None,
            Absent::Number(value) => Some(Content::Number(value)),
            Absent::Count(count) => Some(Content::Count(count)),
            Absent::Flag(flag) => Some(Content::Flag(flag)),
            Absent::Word(word) => Some(Content::Word(word)),
        }
    }

    fn example(&self, kind: KeyKind) -> String {
        match kind {
            KeyKind::Quantity(unit, _) => match self.scope.dim(unit).si_unit(self.scope.rotational) {
                unit if unit.is_empty() => "1.0".into(),
                unit => format!("\"... {unit}\""),
            },
            KeyKind::Count(..) => "1".into(),
            KeyKind::Flag => "true".into(),
            KeyKind::Pair | KeyKind::Signals => "[\"...\", \"...\"]".into(),
            KeyKind::Range(_) => "[..., ...]".into(),
            KeyKind::Numbers(_, count) => format!("[{}]", vec!["..."; count.max(1)].join(", ")),
            KeyKind::Points(_) => "[[0.0, ...], ...]".into(),
            _ => "\"...\"".into(),
        }
    }

    /// One value; `None` if it has a mistake, which is recorded.
    fn field(&mut self, key: &'static Key, node: &Node, path: &str) -> Option<Content> {
        match key.kind {
            KeyKind::Quantity(unit, bound) => self.quantity(node, unit, bound, path).map(Content::Number),
            KeyKind::Count(least, most) => self.count(node, least, most, path).map(Content::Count),
            KeyKind::Flag => match node.value {
                Value::Flag(flag) => Some(Content::Flag(flag)),
                _ => self.mistyped(node, "true or false", path),
            },
            KeyKind::Text | KeyKind::Name(_) => match &node.value {
                Value::Text(text) => Some(Content::Text(text.clone())),
                _ => self.mistyped(
                    node,
                    if let KeyKind::Name(what) = key.kind { what } else { "a text" },
                    path,
                ),
            },
            KeyKind::Pair => match &node.value {
                Value::Array(items) => match items.as_slice() {
                    [Node { value: Value::Text(a), .. }, Node { value: Value::Text(b), .. }] => {
                        Some(Content::Pair([a.clone(), b.clone()]))
                    }
                    _ => self.mistyped(node, "a list of two body names, as in [\"ground\", \"motor\"]", path),
                },
                _ => self.mistyped(node, "a list of two body names, as in [\"ground\", \"motor\"]", path),
            },
            KeyKind::Signal => self.signal(node, path).map(|signal| Content::Text(signal.to_string())),
            KeyKind::Signals => {
                let items = self.list(node, "a list of signals", path)?;
                let signals = items.iter().filter_map(|item| self.signal(item, path));
                Some(Content::Texts(signals.map(|signal| signal.to_string()).collect()))
            }
            KeyKind::Word(words) => self.word(node, words, path).map(Content::Word),
            KeyKind::Table(shape) => match &node.value {
                Value::Table(table) => {
                    Some(Content::Table(self.fields(shape, &[], table, &node.origin, path)))
                }
                _ => self.mistyped(node, "a table", path),
            },
            KeyKind::QuantityOrTable(short, unit, shape) => {
                if let Value::Table(table) = &node.value {
                    return Some(Content::Table(self.fields(shape, &[], table, &node.origin, path)));
                }
                let value = self.quantity(node, unit, Bound::Positive, path)?;
                let mut table = Contents::new(None);
                table.insert(short, Content::Number(value));
                Some(Content::Table(table))
            }
            KeyKind::WordOrTable(words, shape) => match &node.value {
                Value::Table(table) => {
                    Some(Content::Table(self.fields(shape, &[], table, &node.origin, path)))
                }
                _ => self.word(node, words, path).map(Content::Word),
            },
            KeyKind::Range(unit) => self.range(node, unit, path).map(Content::Range),
            KeyKind::Numbers(unit, count) => self.numbers(node, unit, count, path).map(Content::Numbers),
            KeyKind::Points(unit) => self.points(node, unit, path).map(Content::Points),
            KeyKind::Reference(shape) => match &node.value {
                Value::Array(_) => self.points(node, Unit::Reference, path).map(Content::Points),
                Value::Table(table) => {
                    Some(Content::Table(self.fields(shape, &[], table, &node.origin, path)))
                }
                _ => self.quantity(node, Unit::Reference, Bound::Any, path).map(Content::Number),
            },
        }
    }
}

pub(crate) fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}
