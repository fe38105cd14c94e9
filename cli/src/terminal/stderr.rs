//! Standard error: everything that is not a result.

use std::io::{self, IsTerminal, Write};

use feeler_problem::Problem;

/// Prints a text to standard error; failures to print are ignored.
pub(crate) fn complain(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", text.trim_end());
}

/// Prints doubtful values of a file that may be mistakes.
pub(crate) fn warn(doubts: &[Problem]) {
    for Problem { key, message, remedy, .. } in doubts {
        complain(&format!("warning: {key}: {message}; {remedy}"));
    }
}

/// Whether errors may be coloured.
pub(crate) fn has_colours() -> bool {
    io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none()
}
