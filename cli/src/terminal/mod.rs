//! The terminal and the folder of results: printing and writing, in one place.

pub(crate) mod failure;
pub(crate) mod progress;
pub(crate) mod results;
mod stderr;
mod table;
mod wrap;

pub(crate) use stderr::{complain, has_colours, warn};
pub(crate) use table::table;
pub(crate) use wrap::wrapped;

use std::borrow::Cow;
use std::fmt::Write as _;
use std::fs;
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};

use feeler_studies::write_whole;
use serde::Serialize;

use failure::{BadInput, Failure};

/// Whether a character controls the terminal, or changes the writing direction and so the order of a line.
fn steers(c: char) -> bool {
    let turns = matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || (c.is_control() && !matches!(c, '\n' | '\t'))
}

/// A value as JSON for people and programs.
pub(crate) fn json(value: &impl Serialize) -> crate::Result<String> {
    serde_json::to_string_pretty(value).map_err(Failure::internal)
}

/// Prints a text to standard output.
pub(crate) fn print(text: &str) -> crate::Result<()> {
    // Names come from files, and the output goes to a terminal: no character may control the terminal.
    let text: Cow<str> =
        if text.contains(steers) { text.replace(steers, "\u{fffd}").into() } else { text.into() };
    let mut out = io::stdout().lock();
    let end = if text.ends_with('\n') { "" } else { "\n" };
    let written = out
        .write_all(text.as_bytes())
        .and_then(|()| out.write_all(end.as_bytes()))
        .and_then(|()| out.flush());
    written.map_err(|error| match error.kind() {
        io::ErrorKind::BrokenPipe => Failure::Unheard,
        _ => BadInput::error(
            format!("cannot write to standard output: {error}"),
            "make room there, or send it elsewhere",
        ),
    })
}

/// Makes a folder if it is absent. A long command makes it first, so that an unwritable folder is an error
/// before the run starts.
pub(crate) fn make_folder(path: &Path) -> crate::Result<()> {
    fs::create_dir_all(path).map_err(|error| BadInput::unwritable(path, &error))
}

/// Writes files into a folder, created if absent, and returns a sentence for the end of a printed text.
pub(crate) fn write_all(folder: &Path, files: &[(impl AsRef<str>, String)]) -> crate::Result<String> {
    make_folder(folder)?;
    let mut said = String::from("\n\nwrote");
    for (name, text) in files {
        let path = folder.join(name.as_ref());
        write(&path, text.as_bytes())?;
        let _ = write!(said, "\n  {}", path.display());
    }
    Ok(said)
}

/// Writes a file completely or not at all, so that several processes may write the same file. An existing
/// `path` is replaced.
pub(crate) fn write(path: &Path, content: &[u8]) -> crate::Result<()> {
    replace(path, content).map_err(|error| BadInput::unwritable(path, &error))
}

fn replace(path: &Path, content: &[u8]) -> io::Result<()> {
    write_whole(path, &|error| error, |mut file| {
        file.write_all(content)?;
        Ok(file)
    })
}

/// Replaces a file by a text, after copying it to the path that is returned.
pub(crate) fn rewrite(path: &Path, text: &str) -> io::Result<PathBuf> {
    let name = |number: usize| {
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(if number == 0 { ".bak".to_owned() } else { format!(".bak{number}") });
        path.with_file_name(name)
    };
    let mut number = 0;
    // An existing copy may be the only one of its contents.
    let mut copy = loop {
        match fs::OpenOptions::new().write(true).create_new(true).open(name(number)) {
            Ok(copy) => break copy,
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => number += 1,
            Err(error) => return Err(error),
        }
    };
    copy.write_all(&fs::read(path)?)?;
    copy.sync_all()?;
    replace(path, text.as_bytes())?;
    Ok(name(number))
}

/// Writes a file that the user may have edited. Another text that it replaces is copied first, to the path
/// that is returned. A device takes the text as it is.
pub(crate) fn write_kept(path: &Path, text: &str) -> crate::Result<Option<PathBuf>> {
    if path.exists() && !path.is_file() {
        return fs::write(path, text).map(|()| None).map_err(|error| BadInput::unwritable(path, &error));
    }
    if fs::read(path).is_ok_and(|old| old != text.as_bytes()) {
        return rewrite(path, text).map(Some).map_err(|error| BadInput::unwritable(path, &error));
    }
    write(path, text.as_bytes()).map(|()| None)
}

/// As [`write_kept`], and tells where the earlier text is.
pub(crate) fn write_and_tell(path: &Path, text: &str) -> crate::Result<()> {
    if let Some(backup) = write_kept(path, text)? {
        complain(&format!("{} is new; what it was is in {}", path.display(), backup.display()));
    }
    Ok(())
}

/// A word of a command, quoted for a shell.
pub(crate) fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=+:@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// A path as a word of a command; equivalent paths give the same word.
pub(crate) fn quoted_path(path: &Path) -> String {
    let plain: PathBuf = path.components().filter(|part| *part != Component::CurDir).collect();
    quoted(&plain.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_words_are_quoted_where_a_shell_would_take_them_apart() {
        for (word, expected) in
            [("a/b.toml", "a/b.toml"), ("my file", "'my file'"), ("it's", "'it'\\''s'"), ("", "''")]
        {
            assert_eq!(quoted(word), expected);
        }
    }

    #[test]
    fn truth_a_path_is_the_same_however_it_was_typed() {
        for typed in ["maps/a.toml", "./maps/a.toml", "maps//a.toml", "././maps/./a.toml"] {
            assert_eq!(quoted_path(Path::new(typed)), "maps/a.toml");
        }
        assert_eq!(quoted_path(Path::new("./../a b.toml")), "'../a b.toml'");
    }
}
