//! A TOML document as an owned tree, with the place of every key and value.

use indexmap::IndexMap;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::source::Origin;

/// A value and its place.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) value: Value,
    pub(crate) origin: Origin,
}

#[derive(Clone, Debug)]
pub(crate) enum Value {
    Text(String),
    Integer(i128),
    Float(f64),
    Flag(bool),
    Date,
    Array(Vec<Node>),
    Table(Table),
}

/// A key's place and its value.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) key: Origin,
    pub(crate) node: Node,
}

/// Keys in the order of the file.
pub(crate) type Table = IndexMap<String, Entry>;

impl Value {
    /// Type of the value, with an article.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Text(_) => "a text",
            Self::Integer(_) | Self::Float(_) => "a number",
            Self::Flag(_) => "true or false",
            Self::Date => "a date",
            Self::Array(_) => "a list",
            Self::Table(_) => "a table",
        }
    }
}

impl Node {
    pub(crate) fn table(origin: Origin) -> Self {
        Self { value: Value::Table(Table::new()), origin }
    }

    pub(crate) fn as_table(&self) -> Option<&Table> {
        if let Value::Table(table) = &self.value { Some(table) } else { None }
    }

    pub(crate) fn as_table_mut(&mut self) -> Option<&mut Table> {
        if let Value::Table(table) = &mut self.value { Some(table) } else { None }
    }

    pub(crate) fn as_text(&self) -> Option<&str> {
        if let Value::Text(text) = &self.value { Some(text) } else { None }
    }
}

/// The tree of a parsed document.
pub(crate) fn from_table(table: &DeTable<'_>, source: usize) -> Table {
    let entry = |(key, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
        let key: &Spanned<std::borrow::Cow<'_, str>> = key;
        (
            key.get_ref().to_string(),
            Entry { key: Origin { source, span: key.span() }, node: from_value(value, source) },
        )
    };
    table.iter().map(entry).collect()
}

/// The tree of a parsed value. The parser limits the depth of its input, and so the recursion here.
pub(crate) fn from_value(value: &Spanned<DeValue<'_>>, source: usize) -> Node {
    let origin = Origin { source, span: value.span() };
    let value = match value.get_ref() {
        DeValue::String(text) => Value::Text(text.to_string()),
        // An integer outside the range of every key is still a number: as a float it violates the key's
        // bound.
        DeValue::Integer(integer) => i128::from_str_radix(integer.as_str(), integer.radix())
            .map_or(Value::Float(f64::INFINITY), Value::Integer),
        DeValue::Float(float) => Value::Float(float.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(flag) => Value::Flag(*flag),
        DeValue::Datetime(_) => Value::Date,
        DeValue::Array(items) => Value::Array(items.iter().map(|item| from_value(item, source)).collect()),
        DeValue::Table(table) => Value::Table(from_table(table, source)),
    };
    Node { value, origin }
}

impl Node {
    /// Changes the places of a node and of all that it contains.
    pub(crate) fn replace(&mut self, change: &impl Fn(&mut Origin)) {
        change(&mut self.origin);
        match &mut self.value {
            Value::Array(items) => items.iter_mut().for_each(|item| item.replace(change)),
            Value::Table(table) => {
                for entry in table.values_mut() {
                    change(&mut entry.key);
                    entry.node.replace(change);
                }
            }
            Value::Text(_) | Value::Integer(_) | Value::Float(_) | Value::Flag(_) | Value::Date => {}
        }
    }
}

/// Place of the deepest existing part of a dotted path, and whether this is the whole path. Entries of lists
/// count from zero.
pub(crate) fn locate(root: &Table, path: &str) -> (Option<Origin>, bool) {
    let mut segments = path.split('.');
    let Some(mut node) = segments.next().and_then(|first| root.get(first)).map(|entry| &entry.node) else {
        return (None, false);
    };
    for segment in segments {
        let below = match &node.value {
            Value::Table(table) => table.get(segment).map(|entry| &entry.node),
            Value::Array(items) => segment.parse().ok().and_then(|i: usize| items.get(i)),
            _ => None,
        };
        let Some(below) = below else { return (Some(node.origin.clone()), false) };
        node = below;
    }
    (Some(node.origin.clone()), true)
}

/// Place of a key of a table; the start of the file if the key is absent.
pub(crate) fn place(table: &Table, key: &str) -> Origin {
    table.get(key).map_or_else(Origin::default, |entry| entry.node.origin.clone())
}

pub(crate) fn node_at<'a>(root: &'a Table, path: &[&str]) -> Option<&'a Node> {
    let (last, way) = path.split_last()?;
    let mut table = root;
    for segment in way {
        table = table.get(*segment)?.node.as_table()?;
    }
    table.get(*last).map(|entry| &entry.node)
}

/// The entry of a list, or of a list within it; entries count from zero.
pub(crate) fn entry_mut<'a>(items: &'a mut [Node], path: &[&str]) -> Option<&'a mut Node> {
    let (first, rest) = path.split_first()?;
    let entry = items.get_mut(first.parse::<usize>().ok()?)?;
    if rest.is_empty() {
        return Some(entry);
    }
    if let Value::Array(inner) = &mut entry.value { entry_mut(inner, rest) } else { None }
}
