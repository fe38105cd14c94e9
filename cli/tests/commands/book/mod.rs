//! The book as its readers use it: every page is in the contents, and every link has a target. The commands
//! and files in it work.
//!
//! The language of a fenced block decides its test:
//! - `console`: lines that begin with `feeler` run, in a copy of `scenarios/`. A line `# long: ...` moves the
//!   rest of the block to `FEELER_BOOK_LONG=1 cargo test -p feeler --test commands book`.
//! - `output`: each line appears in the output of the block before it; `...` stands for any text.
//! - `toml`: parses. A first line `# NAME.toml` makes it a file for the commands after it. A scenario passes
//!   `feeler check`.
//! - `json` parses; `text` is formulas and sketches.
#![cfg(unix)]
#![expect(clippy::print_stdout, reason = "says which blocks need a program that is absent")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use rayon::prelude::*;

/// A fenced block of a page.
struct Block {
    line: usize,
    language: String,
    text: String,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn has_ending(file: &str, ending: &str) -> bool {
    Path::new(file).extension().is_some_and(|found| found == ending)
}

/// Files under a folder with a suffix, relative to the root.
fn files_under(folder: &str, end: &str) -> BTreeSet<String> {
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

fn chapters() -> BTreeSet<String> {
    let mut pages = files_under("docs", ".md");
    pages.remove("docs/SUMMARY.md");
    pages
}

fn pages() -> BTreeSet<String> {
    let mut pages = chapters();
    pages.append(&mut files_under("scenarios", ".md"));
    pages.extend(["README.md", "CONTRIBUTING.md", "ARCHITECTURE.md"].map(str::to_owned));
    pages
}

fn text_of(page: &str) -> String {
    std::fs::read_to_string(root().join(page)).unwrap_or_else(|error| panic!("{page}: {error}"))
}

fn blocks(text: &str) -> Vec<Block> {
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
fn links(text: &str) -> Vec<String> {
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

/// The link targets of a page's headings, as GitHub and mdbook make them.
fn headings(text: &str) -> Vec<String> {
    let name = |heading: &str| {
        let kept = heading.trim().to_lowercase();
        let kept = kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect::<String>()
    };
    let prose = prose(text);
    let headings = prose.lines().filter(|line| line.starts_with('#'));
    headings.map(|line| name(line.trim_start_matches('#'))).collect()
}

#[test]
fn truth_every_link_leads_somewhere() {
    let mut broken = Vec::new();
    for page in pages() {
        let text = text_of(&page);
        let folder = Path::new(&page).parent().unwrap().to_owned();
        for link in links(&text).into_iter().filter(|link| !link.contains("://")) {
            let (file, heading) = link.split_once('#').unwrap_or((&link, ""));
            let target = if file.is_empty() { PathBuf::from(&page) } else { folder.join(file) };
            if !root().join(&target).exists() {
                broken.push(format!("{page}: {link}: no such file"));
            } else if !heading.is_empty() && (file.is_empty() || has_ending(file, "md")) {
                let text = text_of(target.to_str().unwrap());
                if !headings(&text).iter().any(|name| name == heading) {
                    broken.push(format!("{page}: {link}: no such heading"));
                }
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// The book is rendered from `docs/` alone: a link out of it would be broken.
#[test]
fn truth_every_page_is_in_the_contents_and_stays_in_the_book() {
    let listed: Vec<String> =
        links(&text_of("docs/SUMMARY.md")).into_iter().map(|link| format!("docs/{link}")).collect();
    let once: BTreeSet<String> = listed.iter().cloned().collect();
    assert_eq!(listed.len(), once.len(), "a page is listed twice");
    assert_eq!(once, chapters(), "docs/SUMMARY.md and the pages under docs/ differ");
    for page in chapters() {
        let depth = page.matches('/').count() - 1;
        let text = text_of(&page);
        for link in links(&text) {
            assert!(!link.starts_with(&"../".repeat(depth + 1)), "{page}: {link} leads out of the book");
        }
        let glossary = links(&text).iter().any(|link| link.contains("glossary.md"));
        assert!(glossary || page.ends_with("glossary.md"), "{page}: no link to the glossary");
        assert!(text.starts_with("# "), "{page}: begins with no title");
    }
}

#[test]
fn truth_every_picture_of_the_book_is_shown() {
    let shown: BTreeSet<String> = pages()
        .iter()
        .flat_map(|page| {
            links(&text_of(page)).into_iter().map(|link| link.rsplit('/').next().unwrap().to_owned())
        })
        .collect();
    for end in [".png", ".svg"] {
        for picture in files_under("docs", end) {
            assert!(shown.contains(picture.rsplit('/').next().unwrap()), "{picture} is on no page");
        }
    }
}

/// Before its third section.
#[test]
fn truth_every_chapter_begins_with_a_command_and_a_picture() {
    for page in chapters() {
        let text = text_of(&page);
        let begins = text.split("\n## ").take(3).collect::<Vec<_>>().join("\n");
        let has = |marks: &[&str]| begins.lines().any(|line| marks.iter().any(|mark| line.starts_with(mark)));
        assert!(has(&["!["]), "{page} begins without a picture");
        assert!(has(&["feeler ", "cargo "]), "{page} begins without a command");
    }
}

/// A folder in which the commands of one page run, one after the other.
struct Reader {
    folder: tempfile::TempDir,
    page: String,
    printed: String,
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            std::fs::copy(entry.path(), target).unwrap();
        }
    }
}

impl Reader {
    fn new(page: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        copy(&root().join("scenarios"), &folder.path().join("scenarios"));
        Self { folder, page: page.to_owned(), printed: String::new() }
    }

    fn shell(&self, line: &str) -> Result<String, String> {
        let binary = Path::new(env!("CARGO_BIN_EXE_feeler")).parent().unwrap();
        let path = format!("{}:{}", binary.display(), std::env::var("PATH").unwrap_or_default());
        let output = Command::new("sh")
            .args(["-c", line])
            .env("PATH", path)
            .env("COLUMNS", "100")
            .current_dir(self.folder.path())
            .output()
            .map_err(|error| error.to_string())?;
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let said = format!("{}{}", text(&output.stdout), text(&output.stderr));
        if output.status.success() { Ok(said) } else { Err(format!("{}\n{said}", output.status)) }
    }

    fn console(&mut self, block: &Block) -> Result<(), String> {
        self.printed.clear();
        for line in block.text.replace("\\\n", " ").lines() {
            if line.starts_with("# long:") && std::env::var_os("FEELER_BOOK_LONG").is_none() {
                break;
            }
            let line = line.replace("cargo run --release -- ", "feeler ");
            if line.starts_with("feeler ") {
                let said = self.shell(&line).map_err(|said| format!("`{line}`: {said}"))?;
                self.printed.push_str(&said);
            }
        }
        Ok(())
    }

    fn output(&self, block: &Block) -> Result<(), String> {
        if self.printed.is_empty() {
            return Ok(());
        }
        let plain = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
        let printed: Vec<String> = self.printed.lines().map(plain).collect();
        for wanted in block.text.lines().map(plain).filter(|line| !line.is_empty()) {
            let parts: Vec<&str> = wanted.split("...").map(str::trim).collect();
            let holds = |line: &String| {
                let mut rest = line.as_str();
                parts.iter().all(|part| rest.find(part).map(|at| rest = &rest[at + part.len()..]).is_some())
            };
            if !printed.iter().any(holds) {
                return Err(format!("not printed: {wanted}\nprinted:\n{}", self.printed));
            }
        }
        Ok(())
    }

    fn python(&self, block: &Block) -> Result<(), String> {
        if self.shell("python3 -c 'import pyarrow'").is_err() {
            println!("skipped: {}:{}: no Python with pyarrow here", self.page, block.line);
            return Ok(());
        }
        std::fs::write(self.folder.path().join("block.py"), &block.text)
            .map_err(|error| error.to_string())?;
        self.shell("python3 block.py").map(|_| ())
    }

    fn toml(&self, block: &Block) -> Result<(), String> {
        let table = block.text.parse::<toml::Table>().map_err(|error| error.to_string())?;
        let first = block.text.lines().next().unwrap_or_default();
        let named = first.strip_prefix("# ").filter(|name| has_ending(name, "toml") && !name.contains(' '));
        let name = named.unwrap_or("snippet.toml");
        if named.is_some() || table.contains_key("run") {
            std::fs::write(self.folder.path().join(name), &block.text).map_err(|error| error.to_string())?;
            self.shell(&format!("feeler check {name}"))?;
        }
        Ok(())
    }

    fn block(&mut self, block: &Block) -> Result<(), String> {
        match block.language.as_str() {
            "console" => self.console(block),
            "output" => self.output(block),
            "toml" => self.toml(block),
            "json" => serde_json::from_str::<serde_json::Value>(&block.text)
                .map(|_| ())
                .map_err(|error| error.to_string()),
            "python" => self.python(block),
            "text" => Ok(()),
            "" if self.page == "ARCHITECTURE.md" => Ok(()),
            other => Err(format!("a block of kind `{other}`, which no test reads")),
        }
    }

    fn read(mut self) -> Vec<String> {
        let text = text_of(&self.page);
        let mut failed = Vec::new();
        for block in blocks(&text) {
            if let Err(why) = self.block(&block) {
                failed.push(format!("{}:{}: {why}", self.page, block.line));
            }
        }
        failed
    }
}

#[test]
fn truth_every_command_and_file_of_the_book_works() {
    let pages: Vec<String> = pages().into_iter().collect();
    let failed: Vec<String> = pages.par_iter().flat_map(|page| Reader::new(page).read()).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n\n"));
}

/// Names of the keys in the first column of the tables of a section.
fn keys_of(section: &str) -> BTreeSet<String> {
    let cells = section.lines().filter_map(|line| line.strip_prefix('|')?.split('|').next());
    cells.flat_map(|cell| cell.split('`').skip(1).step_by(2)).map(str::to_owned).collect()
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
        let Ok(json) = std::fs::read_to_string(reader.folder.path().join(file)) else { continue };
        let json: serde_json::Map<String, serde_json::Value> = serde_json::from_str(&json).unwrap();
        assert_eq!(keys_of(rest), json.keys().cloned().collect(), "{file}");
        compared += 1;
    }
    // All but the diagnosis, which takes minutes.
    assert!(compared >= 5, "{compared} files were compared");
}
