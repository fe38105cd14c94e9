//! Every public item has a comment. Members and variants have one where name and type leave something open:
//! rustc's `missing_docs`, which asks for all of them, is off.

use super::architecture::{LIBRARIES, product};

/// Items above which a comment stands.
const ITEMS: [&str; 7] = ["fn", "const", "static", "struct", "enum", "trait", "type"];

/// Whether a line declares a public item.
fn is_item(line: &str) -> bool {
    let mut words = line.split_whitespace();
    words.next() == Some("pub") && words.next().is_some_and(|word| ITEMS.contains(&word))
}

/// Whether a comment is above a line, over its attributes.
fn has_comment(above: &[&str]) -> bool {
    let mut within = false;
    for line in above.iter().rev().map(|line| line.trim()) {
        if line.starts_with("///") || line.starts_with("#[doc") {
            return true;
        }
        // An attribute may take several lines.
        within = !line.starts_with("#[") && (within || line.ends_with(")]"));
        if !within && !line.starts_with("#[") {
            return false;
        }
    }
    false
}

#[test]
fn truth_every_public_item_has_a_comment() {
    let mut items = 0;
    for (path, text) in LIBRARIES.iter().flat_map(|folder| product(folder)) {
        let lines: Vec<&str> = text.lines().collect();
        for (number, line) in lines.iter().enumerate().filter(|(_, line)| is_item(line)) {
            assert!(has_comment(&lines[..number]), "{}:{}: {line}", path.display(), number + 1);
            items += 1;
        }
    }
    assert!(items > 1000, "only {items} items were found");
}

#[test]
fn truth_an_item_without_a_comment_is_seen() {
    assert!(is_item("    pub const fn new() -> Self {") && is_item("pub struct Name;"));
    assert!(
        !is_item("pub(crate) fn name()") && !is_item("    pub name: String,") && !is_item("pub use a::B;")
    );
    assert!(has_comment(&["/// A name.", "#[derive(Clone)]", "#[expect(", "    lint,", ")]"]));
    assert!(!has_comment(&["/// Another.", "struct Other;", "", "#[derive(Clone)]"]));
    assert!(!has_comment(&["}", "#[expect(", "    lint,", ")]"]));
}
