//! `feeler new`.

use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::Path;

use feeler_files::{TEMPLATES, template};

use crate::arguments::New;
use crate::terminal;
use crate::terminal::failure::BadInput;
use crate::terminal::table;

pub(crate) fn run(arguments: &New) -> crate::Result<()> {
    let Some(found) = arguments.template.as_deref().and_then(template) else {
        let rows = TEMPLATES.iter().map(|template| vec![template.name.to_owned(), template.about.to_owned()]);
        return terminal::print(&table(&["template", "what it is"], &[], rows));
    };
    let Some(path) = &arguments.out else { return terminal::print(found.text) };
    write_new(path, found.text)?;
    terminal::complain(&format!("wrote {}; run it with: feeler run {}", path.display(), path.display()));
    Ok(())
}

/// Writes a file that must not exist yet.
fn write_new(path: &Path, text: &str) -> crate::Result<()> {
    let write = || OpenOptions::new().write(true).create_new(true).open(path)?.write_all(text.as_bytes());
    write().map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => BadInput::error(
            format!("{} exists already, and may hold work", path.display()),
            "name another file with --out, or delete it",
        ),
        _ => BadInput::unwritable(path, &error),
    })
}
