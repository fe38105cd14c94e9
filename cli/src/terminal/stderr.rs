//! Standard error: everything that is not a result.

use std::io::{self, IsTerminal, Write};

/// Prints a text to standard error; failures of that are ignored.
pub(crate) fn complain(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", text.trim_end());
}

/// Whether errors may be coloured.
pub(crate) fn has_colours() -> bool {
    io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none()
}
