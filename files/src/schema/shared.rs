//! Parts of a schema that occur several times, each defined once.

use std::collections::HashMap;

use serde_json::{Map, Value, json};

/// Smallest length of a part that is worth a reference, characters.
const LEAST_LETTERS: usize = 60;

/// A schema with a definition for each part that occurs several times.
pub(super) fn defined_once(schema: &Value) -> Value {
    let mut parts = Parts::default();
    parts.count(schema);
    let mut whole = parts.inner(schema);
    if let (Some(object), false) = (whole.as_object_mut(), parts.definitions.is_empty()) {
        object.insert("definitions".into(), Value::Object(parts.definitions));
    }
    whole
}

#[derive(Default)]
struct Parts {
    /// Number of occurrences of each part, by its text. Occurrences inside a repeated part count once.
    uses: HashMap<String, usize>,
    /// Names of the definitions, by the text of the part.
    names: HashMap<String, String>,
    definitions: Map<String, Value>,
}

impl Parts {
    fn count(&mut self, value: &Value) {
        if is_schema(value) {
            let uses = self.uses.entry(value.to_string()).or_default();
            *uses += 1;
            if *uses > 1 {
                return;
            }
        }
        match value {
            Value::Object(object) => object.values().for_each(|inner| self.count(inner)),
            Value::Array(items) => items.iter().for_each(|inner| self.count(inner)),
            _ => {}
        }
    }

    /// A part, or a reference to its definition.
    fn part(&mut self, value: &Value) -> Value {
        if !is_schema(value) {
            return self.inner(value);
        }
        let text = value.to_string();
        if text.len() < LEAST_LETTERS || self.uses.get(&text).is_none_or(|uses| *uses < 2) {
            return self.inner(value);
        }
        let name = if let Some(name) = self.names.get(&text) {
            name.clone()
        } else {
            let name = format!("part-{}", self.names.len() + 1);
            self.names.insert(text, name.clone());
            let definition = self.inner(value);
            self.definitions.insert(name.clone(), definition);
            name
        };
        json!({ "$ref": format!("#/definitions/{name}") })
    }

    /// A value with its parts replaced.
    fn inner(&mut self, value: &Value) -> Value {
        match value {
            Value::Object(object) => {
                object.iter().map(|(key, inner)| (key.clone(), self.part(inner))).collect()
            }
            Value::Array(items) => items.iter().map(|inner| self.part(inner)).collect(),
            other => other.clone(),
        }
    }
}

/// Whether a value is a schema, and not a map from keys to schemas, which holds no lists and no texts.
fn is_schema(value: &Value) -> bool {
    let holds = |key: &str| value.get(key).is_some_and(|inner| inner.is_array() || inner.is_string());
    ["type", "anyOf", "oneOf"].iter().any(|key| holds(key))
}
