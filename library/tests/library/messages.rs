//! No program parses a message: mistake, place and remedy are data of every error.

#![expect(
    clippy::unwrap_used,
    reason = "a file or command of the repository that is not there fails the test"
)]

use std::fs;
use std::path::{Path, PathBuf};

/// Code patterns that inspect a message, or take the key of a problem apart.
const LOOKS: [&str; 14] = [
    "split_once(\"; \")",
    "split(\"; \")",
    "to_string().contains(",
    "to_string().starts_with(",
    "to_string().ends_with(",
    "to_string().split",
    "to_string().replace(\"; ",
    "message.contains(",
    "message.starts_with(",
    "why.contains(",
    "what.starts_with(",
    "remedy.contains(",
    ".key.find(",
    ".key.split",
];

/// Permitted exceptions: the TOML parser gives its errors only as text.
const EXCEPTIONS: [(&str, &str); 1] = [("files/src/parse.rs", "message.contains(word)")];

/// Every file of product code.
fn sources(folder: &Path, into: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && !["target", "tests", ".git", "benches", "examples"].contains(&name.as_str()) {
            sources(&path, into);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            into.push(path);
        }
    }
}

/// Lines of product code. Tests, which may inspect messages, are the module `tests` up to its closing brace.
pub(crate) fn product(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut is_test = false;
    text.lines().enumerate().filter(move |(_, line)| {
        is_test |= *line == "mod tests {";
        let is_product = !is_test;
        is_test &= *line != "}";
        is_product
    })
}

#[test]
fn truth_code_after_a_test_item_is_looked_at() {
    let text =
        "fn a() {}\n#[cfg(test)]\nmod fixture;\nfn b() {}\n#[cfg(test)]\nmod tests {\n    c();\n}\nfn d() {}";
    let kept: Vec<&str> = product(text).map(|(_, line)| line).filter(|line| line.starts_with("fn")).collect();
    assert_eq!(kept, ["fn a() {}", "fn b() {}", "fn d() {}"]);
}

#[test]
fn truth_no_message_is_taken_apart() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut files = Vec::new();
    sources(root, &mut files);
    assert!(files.len() > 300, "only {} files were found under {}", files.len(), root.display());
    let mut found = Vec::new();
    for file in files {
        let name = file.strip_prefix(root).unwrap().to_string_lossy().into_owned();
        let text = fs::read_to_string(&file).unwrap();
        for (number, line) in product(&text) {
            let is_allowed = EXCEPTIONS.iter().any(|(file, part)| name == *file && line.contains(part));
            let is_searched = line.contains(".contains(&") && line.contains(".message");
            if !is_allowed && (is_searched || LOOKS.iter().any(|look| line.contains(look))) {
                found.push(format!("{name}:{}: {}", number + 1, line.trim()));
            }
        }
    }
    assert!(found.is_empty(), "messages are looked into:\n{}", found.join("\n"));
}
