//! Texts that were read, and places in them.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

/// A place in one of the texts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Origin {
    /// Index into [`Sources`].
    pub(crate) source: usize,
    /// Bytes.
    pub(crate) span: Range<usize>,
}

/// A text under the name by which reports call it.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    pub(crate) name: String,
    pub(crate) text: Arc<str>,
    /// Where relative file names in it start from.
    pub(crate) directory: PathBuf,
}

/// Every text of a document: the file, the machine it builds on, overrides.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sources(pub(crate) Vec<Source>);

impl Sources {
    pub(crate) fn add(&mut self, source: Source) -> usize {
        self.0.push(source);
        self.0.len() - 1
    }

    /// Line and column, both from 1; the column counts characters.
    pub(crate) fn position(&self, origin: &Origin) -> (usize, usize) {
        let Some(source) = self.0.get(origin.source) else { return (1, 1) };
        let mut start = origin.span.start.min(source.text.len());
        while !source.text.is_char_boundary(start) {
            start -= 1;
        }
        let before = &source.text[..start];
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().map_or(0, |rest| rest.chars().count()) + 1;
        (line, column)
    }
}
