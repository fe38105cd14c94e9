//! Texts of files, and places in them.

use std::ops::Range;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// A place in one of the texts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Origin {
    /// Index into [`Sources`].
    pub(crate) source: usize,
    pub(crate) span: Range<usize>,
}

/// Name of the texts of overrides.
pub(crate) const OVERRIDE: &str = "--set";

/// A text with its name in reports.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    pub(crate) name: String,
    pub(crate) text: Arc<str>,
    /// Folder for relative file names in this text.
    pub(crate) directory: PathBuf,
}

/// Every text of a document: the file, its base machine, overrides.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sources(pub(crate) Vec<Source>);

impl Sources {
    pub(crate) fn add(&mut self, source: Source) -> usize {
        self.0.push(source);
        self.0.len() - 1
    }

    /// Line and column of a place, both from 1.
    pub(crate) fn position(&self, origin: &Origin) -> (usize, usize) {
        Cursor::new(self).position(origin)
    }
}

/// Path of a file that another one names, as short as possible: `a/../b` becomes `b`, unless `a` is a link.
pub(crate) fn beside(directory: &Path, name: &str) -> PathBuf {
    let path = directory.join(name);
    let mut short = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(short.components().next_back(), Some(Component::Normal(_))) => {
                short.pop();
            }
            part => short.push(part),
        }
    }
    let is_same =
        path.canonicalize().is_ok_and(|there| short.canonicalize().is_ok_and(|found| found == there));
    if is_same { short } else { path }
}

/// Finds lines and columns. If places come in the order of the text, any number of them costs one pass.
#[derive(Debug)]
pub(crate) struct Cursor<'a> {
    sources: &'a Sources,
    source: usize,
    at: usize,
    line: usize,
    column: usize,
    /// Number of bytes already passed.
    walked: usize,
}

impl<'a> Cursor<'a> {
    pub(crate) fn new(sources: &'a Sources) -> Self {
        Self { sources, source: 0, at: 0, line: 1, column: 1, walked: 0 }
    }

    /// Line and column, both from 1; the column counts characters.
    pub(crate) fn position(&mut self, origin: &Origin) -> (usize, usize) {
        let Some(source) = self.sources.0.get(origin.source) else { return (1, 1) };
        let mut start = origin.span.start.min(source.text.len());
        while !source.text.is_char_boundary(start) {
            start -= 1;
        }
        if self.source != origin.source || start < self.at {
            *self = Self { source: origin.source, walked: self.walked, ..Self::new(self.sources) };
        }
        for c in source.text[self.at..start].chars() {
            (self.line, self.column) =
                if c == '\n' { (self.line + 1, 1) } else { (self.line, self.column + 1) };
        }
        self.walked += start - self.at;
        self.at = start;
        (self.line, self.column)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_lines_and_columns_count_from_one_and_columns_in_characters() {
        let text = "ab\nµ = 1\n";
        let sources =
            Sources(vec![Source { name: "x".into(), text: text.into(), directory: PathBuf::new() }]);
        let at = |start| sources.position(&Origin { source: 0, span: start..start });
        assert_eq!([at(0), at(1), at(3), at(5), at(6)], [(1, 1), (1, 2), (2, 1), (2, 2), (2, 3)]);
        assert_eq!(at(1_000), (3, 1));
    }

    #[test]
    fn truth_a_path_has_no_detours() {
        let here = Path::new(env!("CARGO_MANIFEST_DIR")).with_file_name("scenarios");
        assert_eq!(beside(&here.join("sweeps"), "./../paper/rigid.toml"), here.join("paper/rigid.toml"));
        assert_eq!(beside(Path::new("sweeps"), "../absent.toml"), Path::new("sweeps/../absent.toml"));
    }

    #[test]
    fn regress_places_in_order_cost_one_walk() {
        let text = "a = 1\n".repeat(2_000);
        let sources =
            Sources(vec![Source { name: "x".into(), text: text.as_str().into(), directory: PathBuf::new() }]);
        let mut cursor = Cursor::new(&sources);
        for line in 0..2_000 {
            assert_eq!(cursor.position(&Origin { source: 0, span: 6 * line..6 * line + 1 }), (line + 1, 1));
        }
        assert!(cursor.walked < text.len());
    }
}
