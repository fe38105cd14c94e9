//! The keys of a result: a table of them, and a comparison with the keys of a file.

use std::collections::BTreeMap;

use serde_json::Value;

use super::definitions::{Field, Shape};

/// For each type, by name, the heading under which it is shown.
pub(crate) type Shown = BTreeMap<String, String>;

/// Units by the endings of keys. An ending that is part of a longer one comes after it.
const UNITS: [(&str, &str); 14] = [
    ("_n_s_per_m", "N s/m"),
    ("_n_per_m", "N/m"),
    ("_m_per_s", "m/s"),
    ("_per_s", "1/s"),
    ("_hz", "Hz"),
    ("_kg", "kg"),
    ("_deg", "°"),
    ("_db", "dB"),
    ("_nats", "nats"),
    ("_n", "N"),
    ("_m", "m"),
    ("_s", "s"),
    ("joule", "J"),
    ("seconds", "s"),
];
/// Units that comments of keys may state after a comma.
const WRITTEN: [&str; 13] =
    ["N s/m", "N/m", "m/s", "rad/s", "1/s", "Hz", "kg", "degrees", "nats", "J", "N", "m", "s"];

/// Key, type, unit and meaning of each key of a result, which the section `heading` of a page shows.
pub(crate) fn rows(shape: &Shape, heading: &str, shown: &mut Shown) -> Vec<Vec<String>> {
    let (path, root) = inner(shape).unwrap_or_else(|| panic!("{heading} has no keys"));
    let Shape::Object(id, fields) = root else { panic!("{heading} has no keys") };
    shown.insert(id.clone(), heading.to_owned());
    let mut found = Vec::new();
    // Only rows of the same table may refer to its types.
    add(fields, &path, &mut shown.clone(), &mut found);
    found
}

fn add(fields: &[Field], path: &str, shown: &mut Shown, found: &mut Vec<Vec<String>>) {
    for field in fields {
        if let (true, Shape::Object(id, fields)) = (field.is_flat, &field.shape) {
            // A type that has no table of its own is part of this one.
            let Some(table) = shown.get(id) else {
                add(fields, path, shown, found);
                continue;
            };
            let key = format!("every key of `{table}`");
            found.push(vec![key, String::new(), String::new(), field.text.clone()]);
            continue;
        }
        let key = if path.is_empty() { field.name.clone() } else { format!("{path}.{}", field.name) };
        let absent = if field.may_be_absent { " or absent" } else { "" };
        found.push(vec![
            format!("`{key}`"),
            described(&field.shape, shown, false) + absent,
            unit(field).to_owned(),
            field.text.clone(),
        ]);
        let Some((end, named)) = inner(&field.shape) else { continue };
        let (Shape::Object(id, _) | Shape::OneOf(id, _)) = named else { continue };
        if shown.contains_key(id) {
            continue;
        }
        let key = key + &end;
        shown.insert(id.clone(), key.clone());
        if let Shape::Object(_, fields) = named {
            add(fields, &key, shown, found);
        }
    }
}

fn unit(field: &Field) -> &'static str {
    for (end, unit) in UNITS {
        if let Some(before) = field.name.strip_suffix(end) {
            // Seconds per something other than a second have no unit here.
            return if before.contains("_per_") { "" } else { unit };
        }
    }
    let says =
        |unit: &&&str| [".", ",", ";", ":"].iter().any(|end| field.text.contains(&format!(", {unit}{end}")));
    WRITTEN.iter().find(says).copied().unwrap_or_default()
}

/// The object or the choice within a shape, and the path to it.
fn inner(shape: &Shape) -> Option<(String, &Shape)> {
    match shape {
        Shape::Object(..) | Shape::OneOf(..) => Some((String::new(), shape)),
        Shape::OrNull(shape) => inner(shape),
        Shape::List(shape) => after("[]", shape),
        Shape::Several(shapes) => shapes.iter().find_map(|shape| after("[]", shape)),
        Shape::Map(shape) => after(".NAME", shape),
        _ => None,
    }
}

fn after<'a>(step: &str, shape: &'a Shape) -> Option<(String, &'a Shape)> {
    inner(shape).map(|(path, found)| (format!("{step}{path}"), found))
}

/// A shape in words, in singular or plural.
fn described(shape: &Shape, shown: &Shown, many: bool) -> String {
    let end = if many { "s" } else { "" };
    let one = |shape: &Shape| described(shape, shown, false);
    let all = |shape: &Shape| described(shape, shown, true);
    match shape {
        Shape::Number => format!("number{end}"),
        Shape::Integer => format!("integer{end}"),
        Shape::Flag => "true or false".to_owned(),
        Shape::Text => format!("text{end}"),
        Shape::NumberOrText => format!("number{end} or text{end}"),
        Shape::OneOf(id, names) => match shown.get(id) {
            Some(place) => format!("text{end} like `{place}`"),
            None => choice(names),
        },
        Shape::OrNull(shape) if many => format!("{}, each possibly `null`", all(shape)),
        Shape::OrNull(shape) => match &**shape {
            Shape::OneOf(id, names) if !shown.contains_key(id) => {
                choice(&[names.as_slice(), &["null".to_owned()]].concat())
            }
            shape => format!("{} or `null`", one(shape)),
        },
        Shape::List(shape) => format!("list{end} of {}", all(shape)),
        Shape::Several(shapes) if shapes.iter().all(|shape| *shape == shapes[0]) => {
            let many = if many { "lists of " } else { "" };
            format!("{many}{} {}", shapes.len(), all(&shapes[0]))
        }
        Shape::Several(shapes) => {
            format!("list{end} ({})", shapes.iter().map(one).collect::<Vec<_>>().join("; "))
        }
        Shape::Map(shape) => format!("{} by name", all(shape)),
        Shape::Object(id, _) => match shown.get(id) {
            Some(place) => format!("object{end} like `{place}`"),
            None => format!("object{end}"),
        },
    }
}

/// Names in the form "`a`, `b` or `c`".
fn choice(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match quoted.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
        None => String::new(),
    }
}

/// Collects the differences between a value and its shape: other types, and keys that either lacks.
pub(crate) fn misfits(value: &Value, shape: &Shape, path: &str, found: &mut Vec<String>) {
    let fits = match (shape, value) {
        // A number that is not finite is written as `null`.
        (Shape::Number, Value::Number(_) | Value::Null)
        | (Shape::NumberOrText, Value::Number(_) | Value::String(_))
        | (Shape::Flag, Value::Bool(_))
        | (Shape::Text, Value::String(_))
        | (Shape::OrNull(_), Value::Null) => true,
        (Shape::Integer, Value::Number(number)) => !number.is_f64(),
        (Shape::OneOf(_, names), Value::String(text)) => names.contains(text),
        (Shape::OrNull(shape), value) => {
            misfits(value, shape, path, found);
            true
        }
        (Shape::List(shape), Value::Array(values)) => {
            for value in values {
                misfits(value, shape, &format!("{path}[]"), found);
            }
            true
        }
        (Shape::Several(shapes), Value::Array(values)) => {
            for (value, shape) in values.iter().zip(shapes) {
                misfits(value, shape, &format!("{path}[]"), found);
            }
            values.len() == shapes.len()
        }
        (Shape::Map(shape), Value::Object(values)) => {
            for value in values.values() {
                misfits(value, shape, &format!("{path}.NAME"), found);
            }
            true
        }
        (Shape::Object(_, fields), Value::Object(values)) => {
            let fields = flat(fields);
            let unknown = values.keys().filter(|name| !fields.iter().any(|field| field.name == **name));
            found.extend(unknown.map(|name| format!("{path}.{name} has no definition")));
            for field in fields {
                let path = format!("{path}.{}", field.name);
                match values.get(&field.name) {
                    Some(value) => misfits(value, &field.shape, &path, found),
                    None if field.may_be_absent => {}
                    None => found.push(format!("{path} is absent")),
                }
            }
            true
        }
        _ => false,
    };
    if !fits {
        found.push(format!("{path} is not {shape:?}"));
    }
}

/// The keys of an object, including those of its flattened objects.
fn flat(fields: &[Field]) -> Vec<&Field> {
    let mut found = Vec::new();
    for field in fields {
        match &field.shape {
            Shape::Object(_, fields) if field.is_flat => found.append(&mut flat(fields)),
            _ => found.push(field),
        }
    }
    found
}
