//! Each picture of the book is drawn by `.ci/pictures`, by a command that its page shows.

use std::collections::BTreeMap;

use super::page::{blocks, has_ending, links, pages, text_of};

/// Pictures with a program of their own that takes hours: `benches/peers/run` and the tests that write
/// docs/effects.md draw them.
const ELSEWHERE: [&str; 2] = ["work-precision.svg", "effects/"];

/// Options that only say where files go.
const PLACES: [&str; 3] = ["--out", "--map-out", "--code"];

/// The command without places, quotes and redirections, so that script and page can be compared.
fn plain(command: &str) -> String {
    let mut kept = Vec::new();
    let mut words = command.split(" # ").next().unwrap_or_default().split_whitespace();
    while let Some(word) = words.next() {
        if PLACES.contains(&word) {
            words.next();
        } else if word.starts_with(['>', '&']) || word.starts_with("2>") {
            break;
        } else {
            let word = word.replace(['"', '\''], "").replace("$so101", "../shared/data/so101");
            let word = word.trim_end_matches(')').trim_start_matches("$out/").trim_start_matches("out/");
            kept.push(word.to_owned());
        }
    }
    kept.join(" ")
}

fn joined(text: &str) -> String {
    text.replace("\\\n", " ")
}

/// The command that makes each picture: the last one before it in the script.
fn drawn() -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let mut last = String::new();
    for line in joined(&text_of(".ci/pictures")).lines().map(str::trim) {
        if let Some((_, arguments)) = line.split_once("\"$feeler\" ") {
            last = plain(&format!("feeler {arguments}"));
        }
        let words: Vec<&str> = line.split_whitespace().collect();
        let mut names = words.iter().map(|word| word.rsplit('/').next().unwrap().trim_matches('"'));
        let Some(picture) = names.rfind(|word| has_ending(word, "png") || has_ending(word, "svg")) else {
            continue;
        };
        match words[0] {
            "live" => {
                found.insert(picture.to_owned(), plain(&format!("feeler live {}", words[5..].join(" "))))
            }
            "page" | "part" | "cp" => found.insert(picture.to_owned(), last.clone()),
            _ => None,
        };
    }
    found
}

#[test]
fn truth_every_picture_is_drawn_by_a_command_of_its_page() {
    let drawn = drawn();
    let mut wrong = Vec::new();
    for page in pages() {
        let text = text_of(&page);
        let shown: Vec<String> = blocks(&text)
            .iter()
            .filter(|block| block.language == "console")
            .flat_map(|block| joined(&block.text).lines().map(plain).collect::<Vec<_>>())
            .map(|command| command.replace("cargo run --release -- ", "feeler "))
            .collect();
        for link in links(&text) {
            let is_picture = has_ending(&link, "png") || has_ending(&link, "svg");
            if !is_picture || ELSEWHERE.iter().any(|part| link.contains(part)) {
                continue;
            }
            match drawn.get(link.rsplit('/').next().unwrap()) {
                None => wrong.push(format!("{page}: .ci/pictures does not draw {link}")),
                Some(command) if !shown.contains(command) => {
                    wrong.push(format!("{page}: {link} is of `{command}`, which the page does not show"));
                }
                Some(_) => {}
            }
        }
    }
    assert!(!drawn.is_empty());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
