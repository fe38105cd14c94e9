//! The tables of the book that repeat definitions of the program: keys of results, and outcomes.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use feeler_studies::run::{Outcome, Undecided};

use super::page::{blocks, root, text_of};
use super::reader::Reader;

/// A key of a result, and the comment above it where it is written.
struct Key {
    name: String,
    text: String,
    /// Whether files without a value lack the key.
    may_be_absent: bool,
}

/// The keys of the type, or of the `json!`, whose first line begins with `begin`.
fn keys(source: &str, begin: &str) -> Vec<Key> {
    let mut lines = source.lines().skip_while(|line| !line.trim_start().starts_with(begin));
    let head = lines.next().unwrap_or_else(|| panic!("no line begins with `{begin}`"));
    let depth = |line: &str| line.len() - line.trim_start().len();
    let mut found = Vec::new();
    let (mut text, mut attributes) = (Vec::new(), String::new());
    for line in lines.take_while(|line| depth(line) != depth(head) || !line.trim_start().starts_with('}')) {
        let part = line.trim();
        if depth(line) != depth(head) + 4 {
            continue;
        }
        if let Some(comment) = part.strip_prefix("//") {
            text.push(comment.trim_start_matches('/').trim());
        } else if part.starts_with("#[") {
            attributes.push_str(part);
        } else if let Some((name, _)) = part.split_once(':') {
            let renamed = attributes.split_once("rename = \"").and_then(|(_, rest)| rest.split('"').next());
            let name = renamed.unwrap_or(name.trim_start_matches("pub ").trim_matches('"')).to_owned();
            let may_be_absent = attributes.contains("skip_serializing_if");
            let nothing = if may_be_absent { "absent" } else { "`null`" };
            if !attributes.contains("(skip)") {
                assert!(!text.is_empty(), "`{name}` of `{begin}` has no comment");
                found.push(Key { name, text: text.join(" ").replace("`None`", nothing), may_be_absent });
            }
            text.clear();
            attributes.clear();
        }
    }
    assert!(!found.is_empty(), "`{begin}` has no keys");
    found
}

/// File and first line of the definition that a mark of a page names: `keys of FILE: LINE`.
fn keys_of(mark: &str) -> Option<Vec<Key>> {
    let (file, begin) = mark.strip_prefix("keys of ")?.split_once(": ")?;
    Some(keys(&text_of(file), begin))
}

fn table(header: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut text = format!("| {} |\n|{}\n", header.join(" | "), "---|".repeat(header.len()));
    for row in rows {
        let _ = writeln!(text, "| {} |", row.join(" | ").replace('\n', " "));
    }
    text
}

/// The table that belongs below a mark.
fn generated(mark: &str) -> String {
    if let Some(keys) = keys_of(mark) {
        let rows = keys.into_iter().map(|key| vec![format!("`{}`", key.name), key.text]);
        return table(&["key", "meaning"], rows);
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

/// With `FEELER_UPDATE_DOCS=1` the tables are written instead.
#[test]
fn truth_the_tables_of_results_are_those_of_their_definitions() {
    for page in ["docs/json.md", "docs/outcomes.md"] {
        let committed = text_of(page);
        let (mut text, mut rest) = (String::new(), committed.as_str());
        while let Some((before, after)) = rest.split_once("<!-- ") {
            let (mark, after) = after.split_once(" -->\n").unwrap();
            let (_, after) = after.split_once("<!-- end -->").unwrap();
            let _ = write!(text, "{before}<!-- {mark} -->\n\n{}\n<!-- end -->", generated(mark));
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

#[test]
fn truth_the_keys_of_results_are_those_of_their_files() {
    let page = "docs/json.md";
    let text = text_of(page);
    let mut reader = Reader::new(page);
    for block in blocks(&text) {
        reader.block(&block).unwrap_or_else(|why| panic!("{page}:{}: {why}", block.line));
    }
    let mut compared = 0;
    for section in text.split("\n## `").skip(1) {
        let (file, rest) = section.split_once('`').unwrap();
        let Ok(json) = std::fs::read_to_string(reader.folder().join(file)) else { continue };
        let json: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&json).unwrap();
        let (_, mark) = rest.split_once("<!-- ").unwrap();
        let defined = keys_of(mark.split_once(" -->").unwrap().0).unwrap();
        let defined: BTreeMap<String, bool> =
            defined.into_iter().map(|key| (key.name, key.may_be_absent)).collect();
        for name in json.keys() {
            assert!(defined.contains_key(name), "{file} has `{name}`, which has no definition");
        }
        for (name, may_be_absent) in defined {
            assert!(may_be_absent || json.contains_key(&name), "{file} has no `{name}`");
        }
        compared += 1;
    }
    // All but the diagnosis, which takes minutes.
    assert!(compared >= 5, "{compared} files were compared");
}
