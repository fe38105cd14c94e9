//! The schemas accept every file of the library, and reject mistakes.

#![expect(clippy::unwrap_used, reason = "a file that cannot be read fails the test")]

use std::path::{Path, PathBuf};

use feeler_files::{FOLDERS, TEMPLATES, cell_schema, dataset_schema, schema, sweep_schema};
use serde_json::{Value, json};

/// Whether a text matches one of the schemas' patterns.
fn matches(pattern: &str, text: &str) -> bool {
    match pattern {
        "^.+\\.[a-z_]+$" => text.rsplit_once('.').is_some_and(|(element, quantity)| {
            !element.is_empty()
                && !quantity.is_empty()
                && quantity.chars().all(|c| c.is_ascii_lowercase() || c == '_')
        }),
        "^[+-]?[0-9.]" => {
            text.trim_start_matches(['+', '-']).starts_with(|c: char| c.is_ascii_digit() || c == '.')
        }
        other => panic!("a pattern that this test does not know: {other}"),
    }
}

fn of_type(name: &str, value: &Value) -> bool {
    match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "number" => value.is_number(),
        "integer" => value.is_i64() || value.is_u64(),
        other => panic!("a type that this test does not know: {other}"),
    }
}

/// Whether a value meets a schema, by the keywords of JSON Schema draft 07 that the schemas use.
fn admits(schema: &Value, value: &Value) -> bool {
    meets(schema, schema, value)
}

/// Whether a value meets a part of the schema `root`, which holds the definitions.
fn meets(root: &Value, schema: &Value, value: &Value) -> bool {
    let admits = |schema: &Value, value: &Value| meets(root, schema, value);
    let Some(rules) = schema.as_object() else { return schema.as_bool().unwrap() };
    let list = |rule: &Value| rule.as_array().unwrap().clone();
    let number = |compare: fn(f64, f64) -> bool, rule: &Value| {
        value.as_f64().is_none_or(|v| compare(v, rule.as_f64().unwrap()))
    };
    let length = |compare: fn(u64, u64) -> bool, rule: &Value| {
        value.as_array().is_none_or(|v| compare(v.len() as u64, rule.as_u64().unwrap()))
    };
    let properties = rules.get("properties").and_then(Value::as_object);
    rules.iter().all(|(keyword, rule)| match keyword.as_str() {
        "$schema" | "title" | "description" | "default" | "definitions" | "then" | "else" => true,
        "$ref" => admits(root.pointer(rule.as_str().unwrap().trim_start_matches('#')).unwrap(), value),
        "type" => match rule {
            Value::Array(names) => names.iter().any(|name| of_type(name.as_str().unwrap(), value)),
            name => of_type(name.as_str().unwrap(), value),
        },
        "const" => value == rule,
        "minimum" => number(|v, least| v >= least, rule),
        "maximum" => number(|v, most| v <= most, rule),
        "exclusiveMinimum" => number(|v, least| v > least, rule),
        "minItems" => length(|v, least| v >= least, rule),
        "maxItems" => length(|v, most| v <= most, rule),
        "pattern" => value.as_str().is_none_or(|text| matches(rule.as_str().unwrap(), text)),
        "anyOf" => list(rule).iter().any(|schema| admits(schema, value)),
        "oneOf" => list(rule).iter().filter(|schema| admits(schema, value)).count() == 1,
        "required" => list(rule)
            .iter()
            .all(|key| value.as_object().is_none_or(|v| v.contains_key(key.as_str().unwrap()))),
        "properties" => rule
            .as_object()
            .unwrap()
            .iter()
            .all(|(key, schema)| value.get(key).is_none_or(|inner| admits(schema, inner))),
        "additionalProperties" => value.as_object().is_none_or(|v| {
            v.iter()
                .filter(|(key, _)| properties.is_none_or(|known| !known.contains_key(*key)))
                .all(|(_, inner)| admits(rule, inner))
        }),
        "items" => value.as_array().is_none_or(|v| match rule {
            Value::Array(schemas) => v.iter().zip(schemas).all(|(inner, schema)| admits(schema, inner)),
            schema => v.iter().all(|inner| admits(schema, inner)),
        }),
        "additionalItems" => {
            let named = rules.get("items").and_then(Value::as_array).map_or(0, Vec::len);
            value.as_array().is_none_or(|v| v.iter().skip(named).all(|inner| admits(rule, inner)))
        }
        "if" => rules
            .get(if admits(rule, value) { "then" } else { "else" })
            .is_none_or(|schema| admits(schema, value)),
        other => panic!("a keyword that this test does not know: {other}"),
    })
}

fn read(text: &str) -> Value {
    serde_json::to_value(toml::from_str::<toml::Table>(text).unwrap()).unwrap()
}

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "toml") {
            found.push(path);
        }
    }
}

#[test]
fn truth_every_shipped_file_meets_its_schema() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios"));
    let mut found = Vec::new();
    for theme in std::fs::read_dir(root).unwrap().map(|entry| entry.unwrap().path()) {
        if theme.is_dir() {
            files(&theme, &mut found);
        }
    }
    let [machine, arm, sweep, dataset] = [schema(), cell_schema(), sweep_schema(), dataset_schema()];
    let mut overlays = 0;
    for path in &found {
        let value = read(&std::fs::read_to_string(path).unwrap());
        // An arm file is not a machine file, and has no schema.
        if value.get("urdf").is_some() {
            continue;
        }
        let (name, schema) = if value.get("axes").is_some() {
            ("sweep", &sweep)
        } else if value.get("experiments").is_some() {
            ("dataset", &dataset)
        } else if value.get("arm").is_some() {
            ("arm", &arm)
        } else {
            overlays += usize::from(value.get("machine").is_some());
            ("machine", &machine)
        };
        assert!(admits(schema, &value), "{} does not meet the {name} schema", path.display());
    }
    assert!(found.len() > 80 && overlays > 50, "{} files, {overlays} of them overlays", found.len());
    for template in TEMPLATES {
        assert!(admits(&machine, &read(template.text)), "{}", template.name);
    }
}

#[test]
fn truth_the_schema_refuses_what_the_reader_refuses() {
    let schema = schema();
    let overlay = |rest: Value| {
        let mut file = json!({ "machine": "m.toml" });
        file.as_object_mut().unwrap().extend(rest.as_object().unwrap().clone());
        file
    };
    assert!(admits(&schema, &json!({ "bodies": { "a": { "mass": 1.0 } } })));
    assert!(!admits(&schema, &json!({ "bodies": { "a": {} } })), "a mass is missing");
    assert!(
        admits(&schema, &overlay(json!({ "bodies": { "a": { "position": "5 mm" } } }))),
        "it is in the machine"
    );
    assert!(!admits(&schema, &overlay(json!({ "bodies": { "a": { "mas": 1.0 } } }))), "a misspelt key");
    assert!(admits(&schema, &overlay(json!({ "controllers": { "c": { "kp": 1.0 } } }))));
    assert!(
        !admits(&schema, &overlay(json!({ "controllers": { "c": { "kp": true } } }))),
        "a gain is a number"
    );
    assert!(!admits(&schema, &overlay(json!({ "controllers": { "c": { "law": "none" } } }))), "no such law");
}

/// Once every part was written in full wherever it occurred, which took a megabyte.
#[test]
fn regress_what_a_schema_repeats_is_defined_once() {
    for (schema, most) in [(schema(), 250_000), (cell_schema(), 150_000)] {
        let text = schema.to_string();
        assert!(text.len() < most, "{} bytes", text.len());
        for (name, definition) in schema["definitions"].as_object().unwrap() {
            let uses = text.matches(&format!("\"#/definitions/{name}\"")).count();
            assert!(uses > 1, "{name} is used {uses} times");
            let copies = text.matches(&definition.to_string()).count();
            assert!(copies == 1, "{name} is written {copies} times");
        }
    }
}

#[test]
fn truth_every_template_names_its_schema() {
    let folders = FOLDERS.iter().flat_map(|folder| folder.files.iter().copied());
    for (name, text) in TEMPLATES.iter().map(|template| (template.name, template.text)).chain(folders) {
        let kind = if name.starts_with("sweep") {
            "sweep"
        } else if name.starts_with("dataset") {
            "dataset"
        } else {
            "machine"
        };
        assert!(text.starts_with(&format!("#:schema ./{kind}.schema.json\n")), "{name}");
    }
}
