//! Requirements on the errors of every crate, for their tests.

use std::collections::HashSet;
use std::mem::discriminant;

use crate::remedy::Remedy;

/// Remedies that name no action.
const EMPTY_WORDS: [&str; 9] = [
    "correct it",
    "fix it",
    "change it",
    "change the value",
    "check the input",
    "try again",
    "there is none",
    "see the documentation",
    "this is a mistake of feeler itself",
];

/// Violations among the errors that a crate can return; empty if there are none. `errors` holds each variant
/// at least once, and `source` is the text of the file that declares only this enum.
pub fn violations<E: Remedy>(errors: &[E], source: &str) -> Vec<String> {
    let mut found = Vec::new();
    let variants = source.lines().filter(|line| line.trim_start().starts_with("#[error(")).count();
    let shown = errors.iter().map(discriminant).collect::<HashSet<_>>().len();
    if shown != variants {
        found.push(format!("{shown} of {variants} variants are tried"));
    }
    for error in errors {
        for problem in error.problems() {
            let (what, remedy) = (problem.message.trim(), problem.remedy.trim());
            let is_idle = remedy.is_empty() || EMPTY_WORDS.iter().any(|word| remedy.starts_with(word));
            let broken = [
                (what.is_empty(), "says nothing"),
                (is_idle, "names no action"),
                (!remedy.is_empty() && what.contains(remedy), "says its remedy twice"),
                (remedy.split_whitespace().count() < 2, "has a remedy of one word"),
            ];
            found.extend(
                broken.iter().filter(|(is, _)| *is).map(|(_, why)| format!("`{what}` / `{remedy}` {why}")),
            );
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;
    use std::fmt;

    use super::*;

    #[derive(Debug)]
    struct Said(&'static str, &'static str);

    impl fmt::Display for Said {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str(self.0)
        }
    }

    impl std::error::Error for Said {}

    impl Remedy for Said {
        fn remedy(&self) -> Cow<'_, str> {
            self.1.into()
        }
    }

    #[test]
    fn truth_an_error_that_does_not_help_is_found() {
        let one = "#[error(\"a variant\")]";
        let of = |what, remedy| violations(&[Said(what, remedy)], one);
        assert!(of("the mass is zero", "write a mass above zero").is_empty());
        for (what, remedy) in [
            ("the mass is zero", ""),
            ("the mass is zero", "correct it"),
            ("the mass is zero; write a mass above zero", "write a mass above zero"),
            ("", "write a mass above zero"),
            ("the mass is zero", "heavier"),
        ] {
            assert!(!of(what, remedy).is_empty(), "{what} / {remedy}");
        }
        assert_eq!(violations::<Said>(&[], one), ["0 of 1 variants are tried"]);
    }
}
