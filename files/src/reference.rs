//! The manual of the file formats, generated from the declarations. A test compares and updates it.

mod prose;

use std::fmt::Write as _;
use std::path::Path;

use feeler_catalogue::{Absent, Bound, Choice, Key, KeyKind, Keys, Unit, Word};
use feeler_control::reference::REFERENCE;
use feeler_manipulator::joint_effects;
use feeler_plant::description::Quantity;
use feeler_plant::effects::{self, ABOVE_ZERO, Definition, LIBRARY};

use super::cell::{NOT_OF_SENSORS, OF_CONTACTS};
use super::keys::cell::{TIP, WORKPIECE};
use super::keys::{
    ARM, AXIS, CELL, CELL_TABLES, COLUMN, DATASET, ELEMENTS, EXPERIMENT, JOINT, KEEP, REFINE, RUN, SWEEP,
    TOLERANCE_TEXT, TOP,
};
use prose::{CELL_TEXT, DISCRETE, EFFECTS_INTRODUCTION, INTRODUCTION};

/// The reference as Markdown; `docs/format.md` is this text.
fn reference_markdown() -> String {
    let mut text = String::from(INTRODUCTION);
    section(
        &mut text,
        2,
        "Machine and scenario",
        "One file may hold both.",
        &Keys { keys: TOP, choice: None },
    );
    for element in ELEMENTS {
        section(&mut text, 3, &format!("`[{}.NAME]`", element.table), element.text, &element.shape);
        nested(&mut text, &element.shape);
    }
    section(&mut text, 3, "A `reference` as a table", "`reference = { kind = \"...\", ... }`", &REFERENCE);
    text.push_str(DISCRETE);
    section(&mut text, 3, "`[run]`", "Settings of the run.", &RUN);
    let _ = write!(text, "\n### `[tolerance]`\n\n{TOLERANCE_TEXT}.\n");
    effects(&mut text);
    section(
        &mut text,
        2,
        "Arm",
        "A robot arm for `feeler reduce`: a URDF, and the drives of its joints.",
        &ARM,
    );
    section(
        &mut text,
        3,
        "`[joints.NAME]`",
        "One table for each moving joint. For a sliding joint, read kg, N and m.",
        &JOINT,
    );
    let about = CELL_TEXT
        .replace("CONTACT-EFFECTS", &quoted(&OF_CONTACTS))
        .replace("SENSOR-EXCEPTIONS", &quoted(&NOT_OF_SENSORS.map(|(kind, _)| kind)));
    section(&mut text, 2, "Scenario of a whole arm", &about, &CELL);
    for (table, shape, about) in CELL_TABLES.iter().filter(|(table, ..)| *table != WORKPIECE) {
        let is_tip = *table == TIP;
        let both = if is_tip { format!("`[{TIP}]`, `[{WORKPIECE}]`") } else { format!("`[{table}]`") };
        let more = CELL_TABLES.iter().find(|(other, ..)| is_tip && *other == WORKPIECE);
        let more = more.map_or("", |(.., text)| text);
        section(&mut text, 3, &both, &format!("{about} {more}").trim_end().replace("  ", " "), shape);
    }
    let _ = write!(
        text,
        "\n### `[joints.NAME]` of a whole arm\n\nThe keys of an arm file's joints, and `effects`, as in \
         `[joints.lift.effects.{}]`, in rad and N m for a revolute joint. Possible effects: {}. Coulomb \
         friction adds to `dry_friction`.\n",
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
    section(&mut text, 3, "`[axes]`", "`\"key.path\" = [...]` lists values; a table generates them.", &AXIS);
    section(&mut text, 3, "`[keep]`", "The data kept of each run.", &KEEP);
    section(
        &mut text,
        3,
        "`[refine]`",
        "With this table, a grid of one or two axes is refined along boundaries, and only there.",
        &REFINE,
    );
    section(
        &mut text,
        2,
        "Dataset",
        "Measurements of a real machine: `dataset.toml` in a folder of logs.",
        &DATASET,
    );
    section(&mut text, 3, "`[columns.NAME]`", "A column of the files, by its header.", &COLUMN);
    section(&mut text, 3, "`[[experiments]]`", "One entry for each file.", &EXPERIMENT);
    wrapped(&text)
}

/// The pages of all effects as Markdown; `docs/effects.md` is this text.
fn effects_markdown() -> String {
    let mut text = EFFECTS_INTRODUCTION
        .replace("EXAMPLE", &effects::Kind::CoulombFriction.to_string())
        .replace("BY-SYMPTOM", effects::BY_SYMPTOM.trim_end());
    for definition in LIBRARY {
        let (first, rest) = definition.summary.split_at(1);
        let _ = write!(text, "\n## `{}`\n\n{}{rest}. ", definition.kind, first.to_uppercase());
        let _ = writeln!(text, "It sits under {}.\n", definition.sits_under());
        let _ = writeln!(text, "![law of {0}](images/effects/{0}.svg)\n", definition.kind);
        parameters(&mut text, definition);
        for line in definition.documentation().lines() {
            match line.strip_prefix("## ") {
                Some(title) => drop(writeln!(text, "### {title}\n")),
                None => drop(writeln!(text, "{line}")),
            }
        }
    }
    wrapped(&text)
}

/// The table of an effect's parameters.
fn parameters(text: &mut String, definition: &Definition) {
    text.push_str("| parameter | unit | default | typical | bounds | meaning |\n|---|---|---|---|---|---|\n");
    for parameter in definition.parameters {
        let (low, high) = parameter.bounds;
        let low = if low > 0.0 && low <= ABOVE_ZERO { "above 0".to_owned() } else { short(low) };
        let unit = Unit::Of(parameter.dimension).words();
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} | {low} to {} | {} |",
            parameter.name,
            if unit.is_empty() { "1" } else { unit.as_str() },
            parameter.default.map_or_else(|| "required".to_owned(), short),
            short(parameter.typical),
            short(high),
            escaped(parameter.text)
        );
    }
    text.push('\n');
}

/// A number with at most four decimals.
fn short(value: f64) -> String {
    if value.is_infinite() {
        return "any".to_owned();
    }
    if value != 0.0 && !(1e-3..1e6).contains(&value.abs()) {
        return format!("{value:e}");
    }
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// The text with its paragraphs and lists wrapped at `COLUMNS`.
fn wrapped(text: &str) -> String {
    let mut all = String::new();
    let mut paragraph = String::new();
    let mut fenced = false;
    for line in text.lines() {
        let fence = line.starts_with("```");
        let alone = fence || fenced || line.is_empty() || line.starts_with(['|', '#']);
        if alone || line.starts_with("- ") {
            fill(&mut all, &mut paragraph);
        }
        fenced ^= fence;
        if alone {
            all.push_str(line);
            all.push('\n');
        } else {
            let space = if paragraph.is_empty() { "" } else { " " };
            paragraph.push_str(space);
            paragraph.push_str(line.trim_start());
        }
    }
    fill(&mut all, &mut paragraph);
    all
}

/// Ends a paragraph. An operator stays on the line of its left operand, since it would start a list at the
/// beginning of a line.
fn fill(all: &mut String, paragraph: &mut String) {
    let indent = if paragraph.starts_with("- ") { "\n  " } else { "\n" };
    let mut columns = 0;
    for word in paragraph.split_whitespace() {
        let width = word.chars().count();
        let operator = matches!(word, "+" | "-" | "*" | "=");
        if columns + 1 + width > COLUMNS && !operator {
            all.push_str(indent);
            columns = indent.len() - 1;
        } else if columns > 0 {
            all.push(' ');
            columns += 1;
        }
        all.push_str(word);
        columns += width;
    }
    if columns > 0 {
        all.push('\n');
    }
    paragraph.clear();
}

/// Width of the page outside tables.
const COLUMNS: usize = 98;

fn section(text: &mut String, level: usize, title: &str, about: &str, shape: &Keys) {
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
            choice.default.map_or_else(|| "required".into(), |default| format!("`{default}` if absent"));
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
fn nested(text: &mut String, shape: &Keys) {
    let mut seen = Vec::new();
    for key in shape.all_keys() {
        let (KeyKind::Table(inner) | KeyKind::QuantityOrTable(_, _, inner) | KeyKind::WordOrTable(_, inner)) =
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

/// A table within a table, and the tables within that one. Each shape is described once and named afterwards.
fn inner_table(
    text: &mut String,
    name: &str,
    shape: &'static Keys,
    described: &mut Vec<(*const Keys, String)>,
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
        if let KeyKind::Table(inner) = key.kind {
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

fn value(kind: KeyKind) -> String {
    match kind {
        KeyKind::Quantity(unit, bound) => quantity(unit, bound),
        KeyKind::Count(least, most) if most == u64::MAX => format!("whole number from {least}"),
        KeyKind::Count(least, most) => format!("whole number from {least} to {most}"),
        KeyKind::Flag => "`true` or `false`".into(),
        KeyKind::Text => "text".into(),
        KeyKind::Name(what) => format!("name of {what}"),
        KeyKind::Pair => "two names of bodies".into(),
        KeyKind::Signal => "signal".into(),
        KeyKind::Signals => "list of signals".into(),
        KeyKind::Word(words) => choices(words),
        KeyKind::Table(_) => "table".into(),
        KeyKind::QuantityOrTable(_, unit, _) => format!("{}, or table", quantity(unit, Bound::Positive)),
        KeyKind::WordOrTable(words, _) => format!("{}, or table", choices(words)),
        KeyKind::Range(unit) => format!("two numbers, {}", unit.words()),
        KeyKind::Numbers(unit, count) => {
            let form = if count > 0 { format!("list of {count} numbers") } else { "list of numbers".into() };
            if unit.words().is_empty() { form } else { format!("{form}, {}", unit.words()) }
        }
        KeyKind::Points(unit) => format!("pairs of s and {}", unit.words()),
        KeyKind::Reference(_) => "number, pairs of time and value, or table".into(),
    }
}

fn quantity(unit: Unit, bound: Bound) -> String {
    let unit = match unit.words() {
        empty if empty.is_empty() => "number".into(),
        unit => unit,
    };
    match bound {
        Bound::Any => unit,
        bound => format!("{unit}, {}", bound.range()),
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
         `feeler effects KIND` shows its page, with model and source.\n\n\
         | effect | under | parameters | what it does |\n|---|---|---|---|\n",
        effects::Kind::CoulombFriction
    );
    for definition in LIBRARY {
        let parameters: Vec<String> = (definition.parameters.iter())
            .map(|parameter| {
                let unit = Unit::Of(parameter.dimension).words();
                let default =
                    parameter.default.map_or_else(String::new, |value| format!(", default {value}"));
                let colon = if unit.is_empty() { "" } else { " " };
                format!("`{}`{colon}{unit}: {}{default}", parameter.name, escaped(parameter.text))
            })
            .collect();
        let _ = writeln!(
            text,
            "| `{}` | {} | {} | {} |",
            definition.kind,
            definition.sits_under(),
            parameters.join("<br>"),
            escaped(definition.summary)
        );
    }
}

/// With `FEELER_UPDATE_DOCS=1` the pages are written instead.
#[test]
fn truth_the_written_reference_is_that_of_the_declarations() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    for (name, text) in [("format.md", reference_markdown()), ("effects.md", effects_markdown())] {
        let path = docs.join(name);
        if std::env::var_os("FEELER_UPDATE_DOCS").is_some() {
            std::fs::write(&path, &text).unwrap();
        }
        let committed = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(committed == text, "docs/{name} is stale; run this test with FEELER_UPDATE_DOCS=1");
    }
}

#[test]
fn truth_the_written_reference_lists_every_signal() {
    let page = reference_markdown();
    let (_, signals) = page.split_once("\n## Signals\n").unwrap();
    let (signals, _) = signals.split_once("\n## ").unwrap();
    for (_, name) in Quantity::ALL {
        assert!(signals.contains(&format!("`{name}`")), "`{name}` is not in the table of signals");
    }
}
