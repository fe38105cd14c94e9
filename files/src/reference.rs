//! The written reference of the formats, made from the lines that declare them.

use std::fmt::Write as _;

use feeler_catalogue::{Absent, Bound, Choice, Key, Kind, Shape, Unit, Word};
use feeler_manipulator::joint_effects;
use feeler_plant::effects::{self, LIBRARY};

use super::cell::{NOT_OF_SENSORS, OF_CONTACTS};
use super::keys::{
    ARM, AXIS, CELL, CELL_TABLES, COLUMN, DATASET, ELEMENTS, EXPERIMENT, JOINT, KEEP, REFERENCE, REFINE, RUN,
    SWEEP, TOLERANCE_TEXT, TOP,
};

/// The reference as Markdown; `docs/format.md` is this text.
pub fn reference_markdown() -> String {
    let mut text = String::from(INTRODUCTION);
    section(
        &mut text,
        2,
        "Machine and scenario",
        "One file may hold both.",
        &Shape { keys: TOP, choice: None },
    );
    for element in ELEMENTS {
        section(&mut text, 3, &format!("`[{}.NAME]`", element.table), element.text, &element.shape);
        nested(&mut text, &element.shape);
    }
    section(&mut text, 3, "A `reference` as a table", "`reference = { kind = \"...\", ... }`", &REFERENCE);
    section(&mut text, 3, "`[run]`", "How to run it.", &RUN);
    let _ = write!(text, "\n### `[tolerance]`\n\n{TOLERANCE_TEXT}.\n");
    effects(&mut text);
    section(
        &mut text,
        2,
        "Arm",
        "A robot arm for `feeler reduce`: a URDF, and the drives of its joints, of which a URDF says nothing.",
        &ARM,
    );
    section(
        &mut text,
        3,
        "`[joints.NAME]`",
        "One for each joint that moves; of a joint that slides read kg, N and m.",
        &JOINT,
    );
    let about = CELL_TEXT
        .replace("CONTACT-EFFECTS", &quoted(&OF_CONTACTS))
        .replace("SENSOR-EXCEPTIONS", &quoted(&NOT_OF_SENSORS.map(|(kind, _)| kind)));
    section(&mut text, 2, "Scenario of a whole arm", &about, &CELL);
    for (table, shape, about) in CELL_TABLES.iter().filter(|(table, ..)| *table != "workpiece") {
        let both = if *table == "tip" { "`[tip]`, `[workpiece]`".to_owned() } else { format!("`[{table}]`") };
        let more = CELL_TABLES
            .iter()
            .find(|(other, ..)| *table == "tip" && *other == "workpiece")
            .map_or("", |(.., text)| text);
        section(&mut text, 3, &both, &format!("{about} {more}").trim_end().replace("  ", " "), shape);
    }
    let _ = write!(
        text,
        "\n### `[joints.NAME]` of a whole arm\n\nThe keys of an arm file's joints, and `effects`, as in `[joints.lift.effects.{}]`, in rad and N m where the \
         joint turns: {}. Coulomb friction adds to `dry_friction`.\n",
        effects::Kind::Backlash,
        quoted(&joint_effects().collect::<Vec<_>>())
    );
    section(
        &mut text,
        2,
        "Sweep",
        "A scenario, `[axes]` over its keys, and what to `[keep]` of each run.",
        &SWEEP,
    );
    section(&mut text, 3, "`[axes]`", "`\"key.path\" = [...]` lists values; tables make them.", &AXIS);
    section(&mut text, 3, "`[keep]`", "What is kept of each run.", &KEEP);
    section(
        &mut text,
        3,
        "`[refine]`",
        "Where this table stands, a grid of one or two axes is made finer along boundaries, and only there.",
        &REFINE,
    );
    section(
        &mut text,
        2,
        "Dataset",
        "What was measured on the real machine: `dataset.toml` in a folder of CSV, Parquet or MCAP files.",
        &DATASET,
    );
    section(&mut text, 3, "`[columns.NAME]`", "A column of the files, by its header.", &COLUMN);
    section(&mut text, 3, "`[[experiments]]`", "One for each file.", &EXPERIMENT);
    text
}

const INTRODUCTION: &str = "\
# File formats

This page is made from the declarations that the parser reads by; a test keeps the two alike.

Files are TOML. A plain number is SI; a text carries a unit, as in `\"1.2 kN/mm\"`, `\"5 mm\"`, `\"12 N s/m\"`, `\"1 kHz\"`, `\"2 deg\"`, `\"10 %\"`. Units are
products of g, m, s, min, Hz, N, J, W, rad, deg, rpm with the prefixes n, u, m, c, k, M, G; factors are separated by a space, `*` or `·`; powers are written
`m2` or `m^2`; there is at most one `/`, and a denominator of several factors stands in parentheses. Where two units are given below, the one in
parentheses is that of a rotational axis.

Signals are named `element.quantity`: `motor.position`, `velocity`, `acceleration` of a body; `tool.force` (the total that acts), `spring_force` (its elastic
part), `compression`, `gap` and `gap_rate` (how far the two are apart along the axis, below zero where they press, and its rate), `contact` (1 or 0) of a contact;
of a contact with a `surface` also `point_x`, `point_y`, `point_z`, where on the workpiece the tip meets it when it goes along the axis, and `normal_x`,
`normal_y`, `normal_z`, the unit vector from the tip into the workpiece there, in the frame in which `surface` places the shapes; `force` and `spring_force` of a spring; `command` and `force` of an actuator; `reading` of a sensor;
`output` and `reference` of a controller.

A number that must obey a rule has it beside its unit. A dash in the column `default` means that there is no such thing unless it is given.
";

/// With words in capitals where effects are listed.
const CELL_TEXT: &str = "\
A machine file that says `arm = ...`: `feeler run` simulates the whole arm, with flexible joints, against a workpiece in space ([arms.md](arms.md)). It has the
tables below, and of those of an axis:

- `[contacts.NAME]`, exactly one, without `between`, `engagement`, `surface` and `profile`: the law between tip and workpiece, which pushes only. `gap` is how much
  farther away the surface is than its shape says. Effects: CONTACT-EFFECTS.
- `[sensors.NAME]` that read the contact's `force` or `spring_force`: what a sensor in the wrist feels of it against the normal, with every effect of a force sensor
  but SENSOR-EXCEPTIONS; or `motor.position` or `motor.velocity`: the tool's way along the normal from its start and its rate, as the joints' encoders tell it. One
  of the latter, `encoder`, is there without being written.
- `[controllers.NAME]`, exactly one, without `drives`: its output is a force along the normal, which the Jacobian's transpose turns into torques of the joints.
- `[run]`: `duration`, `step` (the longest step; where absent, from the fastest mode), `seed`, and `record_rate` (1 kHz where absent).

Lengths and speeds of the tables below are in m and m/s: what stands in parentheses does not apply. A height field rises along its own -x, and turns with the workpiece.";

fn section(text: &mut String, level: usize, title: &str, about: &str, shape: &Shape) {
    let _ = write!(text, "\n{} {title}\n\n{about}\n", "#".repeat(level));
    if !shape.keys.is_empty() {
        table(text, shape.keys);
    }
    if let Some(choice) = &shape.choice {
        variants(text, choice);
    }
}

fn variants(text: &mut String, choice: &Choice) {
    if !choice.key.is_empty() {
        let default =
            choice.default.map_or_else(|| "required".into(), |default| format!("`{default}` where absent"));
        let _ = write!(text, "\n`{}`, {default}: {}.\n", choice.key, choice.text);
    }
    for variant in choice.variants {
        let name = if choice.key.is_empty() {
            format!("`{}`", variant.name)
        } else {
            format!("`{} = \"{}\"`", choice.key, variant.name)
        };
        let _ = write!(text, "\n{name}: {}.\n", variant.text);
        if !variant.keys.is_empty() {
            table(text, variant.keys);
        }
    }
}

/// Tables within the tables of an element.
fn nested(text: &mut String, shape: &Shape) {
    let mut seen = Vec::new();
    for key in shape.all_keys() {
        let (Kind::Table(inner) | Kind::QuantityOrTable(_, _, inner) | Kind::WordOrTable(_, inner)) =
            key.kind
        else {
            continue;
        };
        if !seen.contains(&key.name) {
            seen.push(key.name);
            inner_table(text, key.name, inner, &mut Vec::new());
        }
    }
}

/// A table within a table, and those within it; a shape that has been described is named only.
fn inner_table(
    text: &mut String,
    name: &str,
    shape: &'static Shape,
    described: &mut Vec<(*const Shape, String)>,
) {
    if let Some((_, before)) = described.iter().find(|(known, _)| std::ptr::eq(*known, shape)) {
        let _ = write!(text, "\n`{name}` as a table: as `{before}`.\n");
        return;
    }
    described.push((shape, name.to_owned()));
    let _ = write!(text, "\n`{name}` as a table:\n");
    if !shape.keys.is_empty() {
        table(text, shape.keys);
    }
    if let Some(choice) = &shape.choice {
        variants(text, choice);
    }
    for key in shape.all_keys() {
        if let Kind::Table(inner) = key.kind {
            inner_table(text, &format!("{name}.{}", key.name), inner, described);
        }
    }
}

fn table(text: &mut String, keys: &[Key]) {
    text.push_str("\n| key | value | default | meaning |\n|---|---|---|---|\n");
    for key in keys {
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} |",
            key.name,
            value(key.kind),
            default(key.absent),
            escaped(key.text)
        );
    }
}

fn default(absent: Absent) -> String {
    match absent {
        Absent::Required => "required".into(),
        Absent::Nothing => "-".into(),
        Absent::Number(value) => format!("{value}"),
        Absent::Count(count) => count.to_string(),
        Absent::Flag(flag) => flag.to_string(),
        Absent::Word(word) => format!("`{word}`"),
    }
}

fn value(kind: Kind) -> String {
    match kind {
        Kind::Quantity(unit, bound) => quantity(unit, bound),
        Kind::Count(least, most) if most == u64::MAX => format!("whole number from {least}"),
        Kind::Count(least, most) => format!("whole number from {least} to {most}"),
        Kind::Flag => "`true` or `false`".into(),
        Kind::Text => "text".into(),
        Kind::Name(what) => format!("name of {what}"),
        Kind::Pair => "two names of bodies".into(),
        Kind::Signal => "signal".into(),
        Kind::Signals => "list of signals".into(),
        Kind::Word(words) => choices(words),
        Kind::Table(_) => "table".into(),
        Kind::QuantityOrTable(_, unit, _) => format!("{}, or table", quantity(unit, Bound::Positive)),
        Kind::WordOrTable(words, _) => format!("{}, or table", choices(words)),
        Kind::Range(unit) => format!("two numbers, {}", unit.words()),
        Kind::Numbers(unit, count) => {
            let form = if count > 0 { format!("list of {count} numbers") } else { "list of numbers".into() };
            if unit.words().is_empty() { form } else { format!("{form}, {}", unit.words()) }
        }
        Kind::Points(unit) => format!("pairs of s and {}", unit.words()),
        Kind::Reference(_) => "number, pairs of time and value, or table".into(),
    }
}

fn quantity(unit: Unit, bound: Bound) -> String {
    let unit = match unit.words() {
        empty if empty.is_empty() => "number".into(),
        unit => unit,
    };
    match bound {
        Bound::Any => unit,
        bound => format!(
            "{unit}, {}",
            bound.words().trim_start_matches("must ").trim_start_matches("be ").trim_start_matches("lie ")
        ),
    }
}

fn choices(words: &[Word]) -> String {
    let each: Vec<String> =
        words.iter().map(|word| format!("`{}` ({})", word.name, escaped(word.text))).collect();
    each.join(", ")
}

fn escaped(text: &str) -> String {
    text.replace('|', "\\|")
}

/// Names of effects, each in backticks.
fn quoted(kinds: &[effects::Kind]) -> String {
    kinds.iter().map(|kind| format!("`{kind}`")).collect::<Vec<_>>().join(", ")
}

fn effects(text: &mut String) {
    let _ = write!(
        text,
        "\n## Effects\n\nAn effect sits under the element that it disturbs: `[springs.guide.effects.{}]`. \
         Its page, with the model and the source, is shown by `feeler effects KIND`.\n\n| effect | under | parameters | what it does |\n|---|---|---|---|\n",
        effects::Kind::CoulombFriction
    );
    for definition in LIBRARY {
        let parameters: Vec<String> = (definition.parameters.iter())
            .map(|parameter| {
                let unit = Unit::Of(parameter.dimension).words();
                let default =
                    parameter.default.map_or_else(String::new, |value| format!(", {value} where absent"));
                let colon = if unit.is_empty() { "" } else { " " };
                format!("`{}`{colon}{unit}: {}{default}", parameter.name, escaped(parameter.text))
            })
            .collect();
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} |",
            definition.kind,
            definition.sits_under(),
            parameters.join("; "),
            escaped(definition.summary)
        );
    }
}
