//! The pages of the book and their contents: blocks, prose, links, headings and commands.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A fenced block of a page.
pub(crate) struct Block {
    pub(crate) line: usize,
    pub(crate) language: String,
    pub(crate) text: String,
}

pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

pub(crate) fn has_ending(file: &str, ending: &str) -> bool {
    Path::new(file).extension().is_some_and(|found| found == ending)
}

/// Files under a folder with a suffix, relative to the root.
pub(crate) fn files_under(folder: &str, end: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for entry in std::fs::read_dir(root().join(folder)).unwrap() {
        let entry = entry.unwrap();
        let path = format!("{folder}/{}", entry.file_name().to_str().unwrap());
        if entry.file_type().unwrap().is_dir() {
            found.append(&mut files_under(&path, end));
        } else if path.ends_with(end) {
            found.insert(path);
        }
    }
    found
}

pub(crate) fn chapters() -> BTreeSet<String> {
    let mut pages = files_under("docs", ".md");
    pages.remove("docs/SUMMARY.md");
    pages
}

pub(crate) fn pages() -> BTreeSet<String> {
    let mut pages = chapters();
    pages.append(&mut files_under("scenarios", ".md"));
    pages.extend(["README.md", "CONTRIBUTING.md", "ARCHITECTURE.md"].map(str::to_owned));
    pages
}

pub(crate) fn text_of(page: &str) -> String {
    std::fs::read_to_string(root().join(page)).unwrap_or_else(|error| panic!("{page}: {error}"))
}

pub(crate) fn blocks(text: &str) -> Vec<Block> {
    let mut found = Vec::new();
    let mut open: Option<Block> = None;
    for (index, line) in text.lines().enumerate() {
        match (open.take(), line.trim_start().strip_prefix("```")) {
            (Some(block), Some(_)) => found.push(block),
            (Some(mut block), None) => {
                block.text.push_str(line);
                block.text.push('\n');
                open = Some(block);
            }
            (None, Some(language)) => {
                let language = language.trim().to_owned();
                open = Some(Block { line: index + 1, language, text: String::new() });
            }
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "a fence is not closed");
    found
}

/// A page without its fenced blocks.
fn prose(text: &str) -> String {
    let mut fenced = false;
    let mut kept = String::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if !fenced {
            kept.push_str(line);
            kept.push('\n');
        }
    }
    kept
}

/// Targets of the links and pictures of a page.
pub(crate) fn links(text: &str) -> Vec<String> {
    let prose = prose(text);
    let mut found = Vec::new();
    for (at, _) in prose.match_indices("](") {
        let rest = &prose[at + 2..];
        if let Some(end) = rest.find(')') {
            found.push(rest[..end].to_owned());
        }
    }
    found
}

/// The link targets of a page's headings, in the form of GitHub and mdbook.
pub(crate) fn headings(text: &str) -> Vec<String> {
    let name = |heading: &str| {
        let kept = heading.trim().to_lowercase();
        let kept = kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect::<String>()
    };
    let prose = prose(text);
    let headings = prose.lines().filter(|line| line.starts_with('#'));
    headings.map(|line| name(line.trim_start_matches('#'))).collect()
}

/// Commands in the sentences of a page, with a value for each placeholder.
pub(crate) fn commands_in_prose(text: &str) -> Vec<String> {
    let prose = prose(text).split_whitespace().collect::<Vec<_>>().join(" ");
    let begins = prose.match_indices("`feeler ").map(|(at, _)| &prose[at + 1..]);
    let commands = begins.filter_map(|rest| rest.split('`').next());
    commands.map(|command| command.split(' ').map(filled).collect::<Vec<_>>().join(" ")).collect()
}

fn filled(word: &str) -> &str {
    match word {
        "COMMAND" => "run",
        "KIND" => "backlash",
        "N" => "1",
        word => word,
    }
}

/// Examples in the help pages, without their remarks.
pub(crate) fn examples(text: &str) -> Vec<String> {
    let lines = text.lines().filter(|line| line.starts_with("  feeler "));
    lines.filter_map(|line| line.trim().split("  ").next()).map(str::to_owned).collect()
}
