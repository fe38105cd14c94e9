//! JSON Schemas of the files, in draft 07, which TOML plugins of editors read.

mod shared;

use crate::keys::Element;
use feeler_catalogue::{Absent, Bound, Key, KeyKind, Keys, Unit, Variant, Word};
use feeler_manipulator::joint_effects;
use feeler_plant::effects::{self, Definition, HostKind, LIBRARY, Parameter};
use serde_json::{Map, Value, json};

use super::build::bound_of;
use super::keys::arm::JOINTS;
use super::keys::cell::{ARM_FILE, START_TABLE, TIP, WORKPIECE};
use super::keys::dataset::{COLUMNS, EXPERIMENTS};
use super::keys::sweep::{AXES, KEEP_TABLE, REFINE_TABLE};
use super::keys::{
    AXIS, BASE, CELL, CELL_TABLES, COLUMN, CONTACTS, CONTROLLERS, DATASET, EFFECTS, ELEMENTS, EXPERIMENT,
    JOINT, KEEP, REFINE, RUN, RUN_TABLE, SHARED, SWEEP, TOLERANCE, TOLERANCE_TEXT, TOP,
};

const DIALECT: &str = "http://json-schema.org/draft-07/schema#";

/// How much of a table a file contains.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    /// All required keys.
    Whole,
    /// Changes to the table of its base machine.
    Changes,
}

/// Schema of machine and scenario files. A file that names a `machine` overrides its keys, and may omit the
/// others.
pub fn schema() -> Value {
    let mut properties = properties(TOP);
    for element in ELEMENTS {
        properties.insert(element.table.into(), json!({ "description": element.text, "type": "object" }));
    }
    properties.insert(RUN_TABLE.into(), described(of_shape(&RUN, &Map::new()), "settings of the run"));
    let share = json!({ "type": "number", "minimum": 0.0 });
    properties.insert(
        TOLERANCE.into(),
        json!({ "description": TOLERANCE_TEXT, "type": "object", "additionalProperties": share }),
    );
    let elements = |part: Part| {
        let tables = ELEMENTS.iter().map(|element| {
            (
                element.table.to_owned(),
                json!({ "description": element.text, "additionalProperties": of_element(element, part) }),
            )
        });
        json!({ "properties": tables.collect::<Map<_, _>>() })
    };
    shared::defined_once(&json!({
        "$schema": DIALECT,
        "title": "feeler machine and scenario",
        "type": "object",
        "properties": properties,
        "additionalProperties": false,
        "if": { "required": [BASE.name] },
        "then": elements(Part::Changes),
        "else": elements(Part::Whole),
    }))
}

/// Schema of scenarios of a whole arm: machine files with `arm = "..."`.
pub fn cell_schema() -> Value {
    let mut properties = properties(CELL.keys);
    for (table, shape, text) in CELL_TABLES {
        properties.insert(table.into(), described(changes_of(shape, Map::new()), text));
    }
    let effects = joint_effects().map(effects::Kind::definition);
    let effects: Map<String, Value> =
        effects.map(|definition| (definition.name.into(), of_effect(definition, Part::Changes))).collect();
    let effects = json!({
        "description": "departures from the ideal",
        "type": "object",
        "properties": effects,
        "additionalProperties": false,
    });
    let joint = changes_of(&JOINT, [(EFFECTS.to_owned(), effects)].into_iter().collect());
    properties.insert(JOINTS.into(), named("drives and effects of joints", &joint));
    for element in ELEMENTS.iter().filter(|element| SHARED.contains(&element.table)) {
        let schema = named(element.text, &of_element(element, Part::Changes));
        properties.insert(element.table.into(), schema);
    }
    properties.insert(RUN_TABLE.into(), described(of_shape(&RUN, &Map::new()), "settings of the run"));
    // A file without a base must have all required keys.
    let whole: Map<String, Value> = CELL_TABLES
        .iter()
        .map(|(table, shape, _)| ((*table).to_owned(), of_shape(shape, &Map::new())))
        .collect();
    shared::defined_once(&json!({
        "$schema": DIALECT,
        "title": "feeler scenario of a whole arm",
        "type": "object",
        "properties": properties,
        "additionalProperties": false,
        "if": { "required": [BASE.name] },
        "then": {},
        "else": {
            "properties": whole,
            "required":
                [ARM_FILE.name, START_TABLE, TIP, WORKPIECE, CONTACTS.table, CONTROLLERS.table],
        },
    }))
}

/// Schema of sweep files.
pub fn sweep_schema() -> Value {
    let list =
        json!({ "type": "array", "minItems": 1, "items": { "type": ["number", "string", "boolean"] } });
    let axis = json!({ "anyOf": [list, of_shape(&AXIS, &Map::new())] });
    let mut properties = properties(SWEEP.keys);
    properties.insert(AXES.into(), named("key paths, in quotes, and their values", &axis));
    properties
        .insert(KEEP_TABLE.into(), described(of_shape(&KEEP, &Map::new()), "the data kept of each run"));
    properties.insert(
        REFINE_TABLE.into(),
        described(of_shape(&REFINE, &Map::new()), "refines a grid along boundaries"),
    );
    let required = required(SWEEP.keys).into_iter().chain([AXES]).collect::<Vec<_>>();
    shared::defined_once(&json!({
        "$schema": DIALECT, "title": "feeler sweep", "type": "object",
        "properties": properties, "required": required, "additionalProperties": false,
    }))
}

/// Schema of dataset files.
pub fn dataset_schema() -> Value {
    let mut properties = properties(DATASET.keys);
    let column = of_shape(&COLUMN, &Map::new());
    properties.insert(COLUMNS.into(), named("columns of the CSV files", &column));
    let experiment = of_shape(&EXPERIMENT, &Map::new());
    properties.insert(
        EXPERIMENTS.into(),
        json!({
            "description": "experiments, one for each file",
            "type": "array",
            "minItems": 1,
            "items": experiment,
        }),
    );
    let required = required(DATASET.keys).into_iter().chain([COLUMNS, EXPERIMENTS]).collect::<Vec<_>>();
    shared::defined_once(&json!({
        "$schema": DIALECT, "title": "feeler dataset", "type": "object",
        "properties": properties, "required": required, "additionalProperties": false,
    }))
}

/// A table of named entries with the same schema.
fn named(text: &str, entry: &Value) -> Value {
    json!({ "description": text, "type": "object", "additionalProperties": entry })
}

fn described(mut schema: Value, text: &str) -> Value {
    if let Some(object) = schema.as_object_mut() {
        object.insert("description".into(), text.into());
    }
    schema
}

fn of_element(element: &Element, part: Part) -> Value {
    let fits = |definition: &&&Definition| {
        definition.hosts.iter().any(|host: &HostKind| element.hosts.contains(host))
    };
    let kinds: Map<String, Value> = LIBRARY
        .iter()
        .filter(fits)
        .map(|definition| (definition.name.into(), of_effect(definition, part)))
        .collect();
    let effects = json!({
        "description": "departures from the ideal",
        "type": "object",
        "properties": kinds,
        "additionalProperties": false,
    });
    let besides = [(EFFECTS.to_owned(), effects)].into_iter().collect();
    match part {
        Part::Whole => of_shape(&element.shape, &besides),
        Part::Changes => changes_of(&element.shape, besides),
    }
}

/// Any keys of a table. Their content depends on the variant, which may be in the other file. The content of
/// any variant is therefore valid.
fn changes_of(shape: &Keys, besides: Map<String, Value>) -> Value {
    let mut admitted = besides;
    for key in shape.all_keys() {
        if admitted.contains_key(key.name) {
            continue;
        }
        let mut forms: Vec<Value> = Vec::new();
        for form in shape.all_keys().filter(|other| other.name == key.name).map(of_key) {
            if !forms.contains(&form) {
                forms.push(form);
            }
        }
        let schema = if forms.len() == 1 {
            forms.swap_remove(0)
        } else {
            json!({ "description": texts(shape, key.name), "anyOf": forms })
        };
        admitted.insert(key.name.into(), schema);
    }
    if let Some(choice) = &shape.choice {
        let words = choice
            .variants
            .iter()
            .map(|variant| json!({ "const": variant.name, "description": variant.text }));
        admitted.insert(
            choice.key.into(),
            json!({ "description": choice.text, "oneOf": words.collect::<Vec<_>>() }),
        );
    }
    json!({ "type": "object", "properties": admitted, "additionalProperties": false })
}

/// The meaning of a key in each variant that has it.
fn texts(shape: &Keys, name: &str) -> String {
    let mut texts: Vec<&str> = Vec::new();
    for key in shape.all_keys().filter(|key| key.name == name) {
        if !texts.contains(&key.text) {
            texts.push(key.text);
        }
    }
    texts.join("; or: ")
}

fn of_effect(definition: &Definition, part: Part) -> Value {
    let parameter = |parameter: &Parameter| {
        let quantity = of_quantity(Unit::Of(parameter.dimension), bound_of(parameter));
        let unit = Unit::Of(parameter.dimension).words();
        let text =
            if unit.is_empty() { parameter.text.to_owned() } else { format!("{}, {unit}", parameter.text) };
        let mut quantity = described(quantity, &text);
        if let (Some(object), Some(default)) = (quantity.as_object_mut(), parameter.default) {
            object.insert("default".into(), default.into());
        }
        (parameter.name.to_owned(), quantity)
    };
    let properties: Map<String, Value> = definition.parameters.iter().map(parameter).collect();
    let needed = |parameter: &&Parameter| part == Part::Whole && parameter.default.is_none();
    let required: Vec<&str> =
        definition.parameters.iter().filter(needed).map(|parameter| parameter.name).collect();
    json!({
        "description": definition.summary, "type": "object",
        "properties": properties, "required": required, "additionalProperties": false,
    })
}

/// A table: one object, or one for each variant.
fn of_shape(shape: &Keys, besides: &Map<String, Value>) -> Value {
    let object = |variant: Option<(&str, &Variant, bool)>| {
        let mut properties = properties(shape.keys);
        let mut required = required(shape.keys);
        properties.extend(besides.clone());
        let mut description = Value::Null;
        if let Some((key, variant, default)) = variant {
            properties.extend(self::properties(variant.keys));
            required.extend(self::required(variant.keys));
            if !key.is_empty() {
                properties.insert(key.into(), json!({ "description": variant.text, "const": variant.name }));
                if !default {
                    required.push(shape.choice.as_ref().map_or("", |choice| choice.key));
                }
            }
            description = variant.text.into();
        }
        let mut object = json!({
            "type": "object",
            "properties": properties,
            "required": required,
            "additionalProperties": false,
        });
        if let (Some(object), Value::String(_)) = (object.as_object_mut(), &description) {
            object.insert("description".into(), description);
        }
        object
    };
    match &shape.choice {
        None => object(None),
        Some(choice) => {
            let variants = choice.variants.iter();
            let each = variants.map(|v| object(Some((choice.key, v, choice.default == Some(v.name)))));
            json!({ "oneOf": each.collect::<Vec<_>>() })
        }
    }
}

fn properties(keys: &[Key]) -> Map<String, Value> {
    keys.iter().map(|key| (key.name.to_owned(), of_key(key))).collect()
}

fn required(keys: &[Key]) -> Vec<&'static str> {
    keys.iter().filter(|key| key.absent == Absent::Required).map(|key| key.name).collect()
}

fn of_key(key: &Key) -> Value {
    let unit = match key.kind {
        KeyKind::Quantity(unit, _)
        | KeyKind::QuantityOrTable(_, unit, _)
        | KeyKind::Range(unit)
        | KeyKind::Numbers(unit, _)
        | KeyKind::Points(unit) => unit.words(),
        _ => String::new(),
    };
    let text = if unit.is_empty() { key.text.to_owned() } else { format!("{}, {unit}", key.text) };
    let mut schema = described(of_kind(key.kind), &text);
    let default = match key.absent {
        Absent::Required | Absent::Nothing => return schema,
        Absent::Number(value) => json!(value),
        Absent::Count(count) => json!(count),
        Absent::Flag(flag) => json!(flag),
        Absent::Word(word) => json!(word),
    };
    if let Some(object) = schema.as_object_mut() {
        object.insert("default".into(), default);
    }
    schema
}

fn of_kind(kind: KeyKind) -> Value {
    let nested = |shape: &Keys| of_shape(shape, &Map::new());
    let signal = json!({ "type": "string", "pattern": "^.+\\.[a-z_]+$" });
    match kind {
        KeyKind::Quantity(unit, bound) => of_quantity(unit, bound),
        KeyKind::Count(least, most) => json!({ "type": "integer", "minimum": least, "maximum": most }),
        KeyKind::Flag => json!({ "type": "boolean" }),
        KeyKind::Text | KeyKind::Name(_) => json!({ "type": "string" }),
        KeyKind::Pair => {
            json!({ "type": "array", "items": { "type": "string" }, "minItems": 2, "maxItems": 2 })
        }
        KeyKind::Signal => signal,
        KeyKind::Signals => json!({ "type": "array", "items": signal }),
        KeyKind::Word(words) => of_words(words),
        KeyKind::Table(shape) => nested(shape),
        KeyKind::QuantityOrTable(_, unit, shape) => {
            json!({ "anyOf": [of_quantity(unit, Bound::Positive), nested(shape)] })
        }
        KeyKind::WordOrTable(words, shape) => json!({ "anyOf": [of_words(words), nested(shape)] }),
        KeyKind::Range(unit) => {
            json!({ "type": "array", "items": of_quantity(unit, Bound::Any), "minItems": 2, "maxItems": 2 })
        }
        KeyKind::Numbers(unit, 0) => json!({ "type": "array", "items": of_quantity(unit, Bound::Any) }),
        KeyKind::Numbers(unit, count) => {
            let items = of_quantity(unit, Bound::Any);
            json!({ "type": "array", "items": items, "minItems": count, "maxItems": count })
        }
        KeyKind::Points(unit) => of_points(unit),
        KeyKind::Reference(shape) => {
            let number = of_quantity(Unit::Reference, Bound::Any);
            json!({ "anyOf": [number, of_points(Unit::Reference), nested(shape)] })
        }
    }
}

fn of_words(words: &[Word]) -> Value {
    let each = words.iter().map(|word| json!({ "const": word.name, "description": word.text }));
    json!({ "oneOf": each.collect::<Vec<_>>() })
}

fn of_points(unit: Unit) -> Value {
    let pair = [
        of_quantity(Unit::Of(feeler_plant::units::Dimension::TIME), Bound::Any),
        of_quantity(unit, Bound::Any),
    ];
    let point = json!({ "type": "array", "items": pair, "additionalItems": false, "minItems": 2 });
    json!({ "type": "array", "minItems": 1, "items": point })
}

/// A number within its bounds, or a text that begins with one.
fn of_quantity(unit: Unit, bound: Bound) -> Value {
    let mut number = json!({ "type": "number" });
    let mut limit = |key: &str, value: f64| {
        number[key] = value.into();
    };
    match bound {
        Bound::Any => {}
        Bound::Positive => limit("exclusiveMinimum", 0.0),
        Bound::NotNegative => limit("minimum", 0.0),
        Bound::AtLeast(least) => limit("minimum", least),
        Bound::Within(least, most) => {
            limit("minimum", least);
            limit("maximum", most);
        }
        Bound::Above(least, most) => {
            limit("exclusiveMinimum", least);
            limit("maximum", most);
        }
    }
    let about = format!("a number with a unit such as {}", unit.words());
    let text = json!({ "type": "string", "pattern": "^[+-]?[0-9.]", "description": about });
    json!({ "anyOf": [number, text] })
}
