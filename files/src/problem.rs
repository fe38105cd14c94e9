//! Mistakes with their places.

use std::borrow::Cow;

use feeler_problem::{Problem, Remedy};
use thiserror::Error;

use super::located::Located;
use super::report;
use super::source::{Cursor, Origin, Sources};
use super::tree::{Node, Table};

/// Largest number of mistakes that are kept. Further ones are only counted: such a file is probably of
/// another kind.
pub(crate) const MOST_PROBLEMS: usize = 1000;

/// Every mistake of a file, in the order of its lines.
#[derive(Clone, Debug, Error)]
#[error("{}", self.report(false))]
pub struct FormatError {
    pub problems: Vec<Located>,
    /// Number of further mistakes after the first thousand.
    pub omitted: usize,
    pub(crate) sources: Sources,
}

impl FormatError {
    /// One report with the affected lines, for a terminal with or without colours.
    pub fn report(&self, coloured: bool) -> String {
        report::render(&self.problems, self.omitted, &self.sources, coloured)
    }

    /// The problems as data.
    pub fn to_json(&self) -> serde_json::Value {
        serde_json::json!({ "problems": self.problems, "omitted": self.omitted })
    }
}

impl Remedy for FormatError {
    fn remedy(&self) -> Cow<'_, str> {
        self.problems.first().map_or("", |problem| problem.remedy.as_str()).into()
    }

    fn place(&self) -> String {
        self.problems.first().map_or_else(String::new, Located::place)
    }

    fn problems(&self) -> Vec<Problem> {
        let problem = |found: &Located| Problem::new(found.place(), &found.message, &found.remedy);
        self.problems.iter().map(problem).collect()
    }

    fn report(&self, coloured: bool) -> String {
        Self::report(self, coloured)
    }
}

/// Mistakes as they are found.
#[derive(Debug, Default)]
pub(crate) struct Problems {
    found: Vec<(Origin, String, String, String)>,
    omitted: usize,
}

impl Problems {
    pub(crate) fn add(
        &mut self,
        origin: &Origin,
        key: impl Into<String>,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) {
        if self.found.len() >= MOST_PROBLEMS {
            self.omitted += 1;
            return;
        }
        self.found.push((origin.clone(), key.into(), message.into(), remedy.into()));
    }

    /// The table of a node; any other value is a mistake with this remedy.
    pub(crate) fn table<'n>(
        &mut self,
        node: &'n Node,
        path: &str,
        remedy: impl Into<String>,
    ) -> Option<&'n Table> {
        let table = node.as_table();
        if table.is_none() {
            self.mistyped(node, path, "a table", remedy);
        }
        table
    }

    /// The node of a key at the top of a file; its absence is a mistake.
    pub(crate) fn required<'n>(&mut self, root: &'n Table, key: &str, remedy: &str) -> Option<&'n Node> {
        let found = root.get(key).map(|entry| &entry.node);
        if found.is_none() {
            self.add(&Origin::default(), key, format!("`{key}` is missing"), remedy);
        }
        found
    }

    /// Records that a node has a value of a wrong type.
    pub(crate) fn mistyped(&mut self, node: &Node, path: &str, expected: &str, remedy: impl Into<String>) {
        let message = format!("this must be {expected}, not {}", node.value.kind());
        self.add(&node.origin, path, message, remedy);
    }

    pub(crate) fn add_error(&mut self, origin: &Origin, key: impl Into<String>, error: &dyn Remedy) {
        self.add(origin, key, error.to_string(), error.remedy());
    }

    /// Whether a problem with this key, or with a table that contains it, has been recorded.
    pub(crate) fn covers(&self, key: &str) -> bool {
        self.found.iter().any(|(_, noted, ..)| {
            key.strip_prefix(noted.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        })
    }

    pub(crate) fn count(&self) -> usize {
        self.found.len() + self.omitted
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// The error of these mistakes, each once, in the order of files and lines.
    pub(crate) fn into_error(mut self, sources: Sources) -> FormatError {
        self.found.sort_by(|(a, a_key, ..), (b, b_key, ..)| {
            (a.source, a.span.start, a_key).cmp(&(b.source, b.span.start, b_key))
        });
        let mut cursor = Cursor::new(&sources);
        let mut problems: Vec<Located> = (self.found.into_iter())
            .map(|(origin, key, message, remedy)| {
                let (line, column) = cursor.position(&origin);
                let file =
                    sources.0.get(origin.source).map_or_else(String::new, |source| source.name.clone());
                Located { file, line, column, key, message, remedy, span: origin.span, source: origin.source }
            })
            .collect();
        problems.dedup_by(|a, b| a == b);
        FormatError { problems, omitted: self.omitted, sources }
    }
}

/// The error for a file that cannot be read at all.
pub(crate) fn unreadable(file: &str, message: String, remedy: &str) -> FormatError {
    let remedy = remedy.to_owned();
    let problem = Located {
        file: file.into(),
        line: 0,
        column: 0,
        key: String::new(),
        message,
        remedy,
        span: 0..0,
        source: usize::MAX,
    };
    FormatError { problems: vec![problem], omitted: 0, sources: Sources::default() }
}

#[cfg(test)]
mod tests {
    #[test]
    fn prop_every_error_says_what_to_do() {
        let all = ["mass = = 3", "[bodies.tip]\nmas = 1.0"]
            .map(|text| crate::Document::parse(text, "a.toml").unwrap_err());
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("problem.rs")),
            Vec::<String>::new()
        );
    }
}
