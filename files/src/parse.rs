//! The tree of a text, or the mistakes of its TOML with their usual causes.

use std::path::Path;

use toml::de::DeTable;

use super::problem::{FormatError, Problems};
use super::source::{Origin, Source, Sources};
use super::tree::{Table, from_table};

/// The tree of a text, which is added to the sources.
pub(crate) fn parse_toml(text: &str, file_name: &str, sources: &mut Sources) -> Result<Table, FormatError> {
    let directory = Path::new(file_name).parent().unwrap_or(Path::new("")).to_owned();
    let source = sources.add(Source { name: file_name.into(), text: text.into(), directory });
    let (table, errors) = DeTable::parse_recoverable(text);
    if errors.is_empty() {
        return Ok(from_table(table.get_ref(), source));
    }
    let mut problems = Problems::default();
    for error in errors {
        let span = error.span().unwrap_or(0..0);
        problems.add(&Origin { source, span }, "", error.message(), hint(error.message()));
    }
    Err(problems.into_error(sources.clone()))
}

/// The usual cause of a TOML parser's message.
fn hint(message: &str) -> &'static str {
    let hints = [
        ("duplicate", "write it once"),
        ("string", "put texts between quotes, and close each one on its own line"),
        ("array", "close the list with `]`, and separate its values by commas"),
        ("table", "write a table as [table.name] on a line of its own, or as { key = value, ... }"),
        ("key", "write key = value, the key without spaces or in quotes"),
        ("newline", "write one key = value on each line"),
        ("number", "write numbers as 12, 1.5 or 2e5; with a unit they are texts: \"5 mm\""),
    ];
    let found = hints.iter().find(|(word, _)| message.contains(word));
    found.map_or("write lines such as mass = 12.0 or gap = \"5 mm\" under [table.name]", |(_, hint)| hint)
}
