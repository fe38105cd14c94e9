//! One mistake with its place.

use std::fmt;
use std::fmt::Write as _;
use std::ops::Range;

use serde::Serialize;

/// One mistake: its place and its remedy.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Located {
    /// File, or `--set` for an override.
    pub file: String,
    /// Line, from 1; 0 for the whole file.
    pub line: usize,
    /// Column in characters, from 1; 0 for the whole file.
    pub column: usize,
    /// Dotted path of the key; empty if there is none.
    pub key: String,
    /// The mistake in words.
    pub message: String,
    /// How to correct it.
    pub remedy: String,
    /// Bytes of the file.
    pub span: Range<usize>,
    #[serde(skip)]
    pub(crate) source: usize,
}

impl Located {
    /// File, line, column and key, as far as they apply.
    pub(crate) fn place(&self) -> String {
        let mut place = self.file.clone();
        if self.line > 0 {
            let _ = write!(place, ":{}:{}", self.line, self.column);
        }
        if !self.key.is_empty() {
            let _ = write!(place, ": {}", self.key);
        }
        place
    }
}

impl fmt::Display for Located {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.place())?;
        write!(f, "{} ({})", self.message, self.remedy)
    }
}
