//! The commands in groups by purpose, as `feeler --help` lists them.

use std::fmt::Write as _;

/// Names of the commands under their headings.
const GROUPS: [(&str, &[&str]); 4] = [
    ("Everyday", &["new", "check", "run", "live", "compare"]),
    ("Analysis", &["analyze", "tune", "why", "sweep", "merge", "frf", "reduce"]),
    ("Records of real machines", &["import", "diagnose", "replay"]),
    (
        "Reference and maintenance",
        &["effects", "schema", "completions", "validate", "figures", "blind", "fit-landmarks"],
    ),
];
/// Width of the names, and of a line.
const NAMES: usize = 15;
const COLUMNS: usize = 80;

/// The help of `feeler` itself, with all its commands in groups.
pub(super) fn template(all: &clap::Command) -> String {
    let mut text = String::from("{about-with-newline}\n{usage-heading} {usage}\n");
    for (heading, names) in GROUPS {
        let _ = write!(text, "\n{heading}:\n");
        for name in names {
            let about = all.find_subcommand(name).and_then(clap::Command::get_about);
            let about = about.map(ToString::to_string).unwrap_or_default();
            entry(&mut text, name, &about);
        }
    }
    text.push_str("\nOptions:\n{options}{after-help}");
    text
}

/// A name with its description, on as many lines as that needs.
fn entry(text: &mut String, name: &str, about: &str) {
    let _ = write!(text, "  {name:NAMES$}");
    let mut column = 2 + NAMES;
    for (i, word) in about.split(' ').enumerate() {
        let letters = word.chars().count();
        if i > 0 && column + 1 + letters > COLUMNS {
            let _ = write!(text, "\n  {:NAMES$}", "");
            column = 2 + NAMES;
        } else if i > 0 {
            text.push(' ');
            column += 1;
        }
        text.push_str(word);
        column += letters;
    }
    text.push('\n');
}

#[cfg(test)]
mod tests {
    use clap::Subcommand as _;

    use super::*;
    use crate::arguments::Command;

    #[test]
    fn truth_every_command_is_in_one_group_and_every_line_fits() {
        let all = Command::augment_subcommands(clap::Command::new("feeler"));
        let mut known: Vec<&str> = all.get_subcommands().map(clap::Command::get_name).collect();
        let mut listed: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect();
        known.sort_unstable();
        listed.sort_unstable();
        assert_eq!(listed, known);
        assert!(template(&all).lines().all(|line| line.chars().count() <= COLUMNS));
    }
}
