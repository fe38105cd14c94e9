//! The book as readers use it: every page is in the contents, every link has a target, and the commands and
//! files work.
//!
//! The language of a fenced block decides its test:
//! - `console`: each line runs, in a folder with `scenarios/` and `logs/`. A server is asked for its page.
//!   Only the lines of a short list are not run ([`reader::NOT_RUN`]). After a line `# long: ...` commands
//!   run with `FEELER_BOOK_LONG=1 cargo test -p feeler --test commands book`; otherwise only their
//!   arguments are checked. `FEELER_BOOK_LONG=bench-axis` runs the pages with this in their path. After
//!   `# needs: PATH` the same holds without this file or folder, and after `# needs: network` without one.
//! - `output`: each line appears in the output of the block before it, if all its commands ran. `...` stands
//!   for any text.
//! - `toml`: passes `feeler check`. A first line `# NAME.toml` makes it a file for the commands after it. Any
//!   other block is laid on the file that the page wrote last ([`reader`] names the exceptions).
//! - `json` parses, `python` runs. `text` is formulas and help, on pages of a short list.
#![cfg(unix)]

mod definitions;
mod keys;
mod page;
mod pictures;
mod reader;
mod reference;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use page::{
    blocks, chapters, commands_in_prose, examples, files_under, has_ending, headings, links, pages, root,
    text_of,
};
use rayon::prelude::*;
use reader::{NOT_RUN, Reader, long_pages};

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

/// The book is rendered from `docs/` alone, so a link to a file outside would be broken.
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

/// Both must come before the first section.
#[test]
fn truth_every_chapter_begins_with_a_command_and_a_picture() {
    for page in chapters() {
        let text = text_of(&page);
        let begins = text.split("\n## ").next().unwrap();
        let has = |marks: &[&str]| begins.lines().any(|line| marks.iter().any(|mark| line.starts_with(mark)));
        assert!(has(&["!["]), "{page} begins without a picture");
        assert!(has(&["feeler ", "cargo "]), "{page} begins without a command");
    }
}

#[test]
fn truth_every_command_and_file_of_the_book_works() {
    let mut pages: Vec<String> = pages().into_iter().collect();
    if let Some(part) = long_pages().filter(|part| part != "1") {
        pages.retain(|page| page.contains(&part));
        assert!(!pages.is_empty(), "no page has {part} in its path");
    }
    let failed: Vec<String> = pages.par_iter().flat_map(|page| Reader::new(page).read()).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n\n"));
}

/// Commands within sentences, and the examples in help texts.
#[test]
fn truth_every_command_that_is_not_in_a_block_is_understood() {
    let mut commands: Vec<(String, String)> = Vec::new();
    for page in pages() {
        commands.extend(commands_in_prose(&text_of(&page)).into_iter().map(|line| (page.clone(), line)));
    }
    let help = "docs/commands.md";
    commands.extend(examples(&text_of(help)).into_iter().map(|line| (help.to_owned(), line)));
    let reader = Reader::new(help);
    let wrong =
        |(page, line): &(String, String)| reader.understands(line).err().map(|why| format!("{page}: {why}"));
    let wrong: Vec<String> = commands.par_iter().filter_map(wrong).collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

/// A command in the list must still be on a page, and its script must exist.
#[test]
fn truth_the_commands_that_are_not_run_exist() {
    let lines: BTreeSet<String> = pages()
        .iter()
        .flat_map(|page| blocks(&text_of(page)))
        .flat_map(|block| block.text.lines().map(str::to_owned).collect::<Vec<_>>())
        .collect();
    for (command, _) in NOT_RUN {
        let is_shown =
            lines.iter().any(|line| line.split(" # ").next().is_some_and(|line| line.trim() == command));
        assert!(is_shown, "{command} is on no page");
        for word in command.split(' ').filter(|word| word.starts_with("benches/")) {
            assert!(root().join(word).exists(), "{word} does not exist");
        }
    }
}
