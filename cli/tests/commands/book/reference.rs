//! The tables of the book that repeat definitions of the program: keys of results, and outcomes.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use feeler_studies::run::{Outcome, Undecided};

use super::definitions::Definitions;
use super::keys::{Shown, misfits, rows};
use super::page::{blocks, root, text_of};
use super::reader::Reader;

fn table(header: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut text = format!("| {} |\n|{}\n", header.join(" | "), "---|".repeat(header.len()));
    for row in rows {
        let _ = writeln!(text, "| {} |", row.join(" | ").replace('\n', " "));
    }
    text
}

/// The table for a mark in the section `heading`.
fn generated(mark: &str, heading: &str, definitions: &Definitions, shown: &mut Shown) -> String {
    if let Some(shape) = definitions.of_mark(mark) {
        let escaped =
            |cells: Vec<String>| cells.into_iter().map(|cell| cell.replace('|', "\\|")).collect::<Vec<_>>();
        let rows = rows(&shape, heading, shown).into_iter().map(escaped);
        return table(&["key", "type", "unit", "meaning"], rows);
    }
    match mark {
        "outcomes" => {
            let row = |(outcome, name): (Outcome, &str)| {
                vec![format!("`{name}`"), outcome.words().to_owned(), outcome.meaning().to_owned()]
            };
            table(&["name", "words", "meaning"], Outcome::ALL.into_iter().map(row))
        }
        "remarks" => {
            let row = |why: Undecided| vec![format!("`{}`", why.name()), why.words().to_owned()];
            table(&["remark", "meaning"], Undecided::ALL.into_iter().map(row))
        }
        _ => panic!("a table of `{mark}` has no definition"),
    }
}

/// The file that the last section of a text names.
fn heading(text: &str) -> &str {
    text.rsplit_once("\n## `").and_then(|(_, rest)| rest.split('`').next()).unwrap_or_default()
}

/// With `FEELER_UPDATE_DOCS=1` the tables are written instead.
#[test]
fn truth_the_tables_of_results_are_those_of_their_definitions() {
    let definitions = Definitions::read();
    for page in ["docs/json.md", "docs/outcomes.md"] {
        let committed = text_of(page);
        let (mut text, mut rest) = (String::new(), committed.as_str());
        let mut shown = Shown::new();
        while let Some((before, after)) = rest.split_once("<!-- ") {
            let (mark, after) = after.split_once(" -->\n").unwrap();
            let (_, after) = after.split_once("<!-- end -->").unwrap();
            text.push_str(before);
            let table = generated(mark, heading(&text), &definitions, &mut shown);
            let _ = write!(text, "<!-- {mark} -->\n\n{table}\n<!-- end -->");
            rest = after;
        }
        text.push_str(rest);
        if std::env::var_os("FEELER_UPDATE_DOCS").is_some() {
            std::fs::write(root().join(page), &text).unwrap();
        }
        let is_fresh = text_of(page) == text;
        assert!(is_fresh, "{page} is stale: FEELER_UPDATE_DOCS=1 cargo test -p feeler --test commands book");
    }
}

/// The page of results names every command without `--json`, and no other.
#[test]
fn truth_every_command_has_json_but_those_that_the_page_excuses() {
    let help = text_of("docs/commands.md");
    let commands: Vec<(&str, bool)> = (help.split("\n## `feeler ").skip(1))
        .filter(|section| !section.contains("<COMMAND>"))
        .map(|section| (section.split('`').next().unwrap(), section.contains(" --json")))
        .collect();
    let without: BTreeSet<&str> = commands.iter().filter(|(_, has)| !has).map(|(name, _)| *name).collect();
    let page = text_of("docs/json.md");
    let (_, excused) = page.split_once("have none: ").unwrap();
    let excused: BTreeSet<&str> = excused.split_once('.').unwrap().0.split('`').skip(1).step_by(2).collect();
    assert_eq!(without, excused);
    assert!(commands.len() > 20, "{} commands were read", commands.len());
}

#[test]
fn truth_the_keys_of_results_are_those_of_their_files() {
    let page = "docs/json.md";
    let text = text_of(page);
    let mut reader = Reader::new(page);
    for block in blocks(&text) {
        reader.block(&block).unwrap_or_else(|why| panic!("{page}:{}: {why}", block.line));
    }
    let definitions = Definitions::read();
    let (mut compared, mut wrong) = (0, Vec::new());
    for section in text.split("\n## `").skip(1) {
        let (file, rest) = section.split_once('`').unwrap();
        let Ok(json) = std::fs::read_to_string(reader.folder().join(file)) else { continue };
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        let (_, mark) = rest.split_once("<!-- ").unwrap();
        let shape = definitions.of_mark(mark.split_once(" -->").unwrap().0).unwrap();
        misfits(&json, &shape, file, &mut wrong);
        compared += 1;
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    // All files are compared except the diagnosis and the scores of a bench, which take minutes.
    assert!(compared >= 17, "{compared} files were compared");
}

/// A check that accepts every file would be useless.
#[test]
fn truth_a_key_too_many_a_key_too_few_and_another_type_are_found() {
    let shape =
        Definitions::read().of_mark("keys of cli/src/commands/effects/as_json.rs: Parameter").unwrap();
    let found = |change: &dyn Fn(&mut serde_json::Value)| {
        let mut value = serde_json::json!({
            "name": "level", "unit": "N", "text": "", "null": null, "typical": 1,
            "bounds": [0, 1], "default": 2,
        });
        change(&mut value);
        let mut wrong = Vec::new();
        misfits(&value, &shape, "file", &mut wrong);
        wrong.join("; ")
    };
    assert_eq!(found(&|_| ()), "");
    assert_eq!(found(&|value| value["more"] = 1.into()), "file.more has no definition");
    let lacks = found(&|value| drop(value.as_object_mut().unwrap().remove("unit")));
    assert_eq!(lacks, "file.unit is absent");
    assert_eq!(found(&|value| value["name"] = 1.into()), "file.name is not Text");
    assert_eq!(found(&|value| value["bounds"][1] = "1".into()), "file.bounds[] is not Number");
}
