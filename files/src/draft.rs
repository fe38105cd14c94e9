//! A file as a tree, before it becomes a document: with its base machine and overrides.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use feeler_plant::effects::{LIBRARY, find};
use feeler_plant::names::did_you_mean;
use toml::de::DeValue;

use super::file;
use super::gaps::Gaps;
use super::keys::arm::JOINTS;
use super::keys::cell::ARM_FILE;
use super::keys::{BASE, CELL, CELL_TABLES, EFFECTS, ELEMENTS, EXAMPLE_KEY, NAME, RUN_TABLE, TOLERANCE, TOP};
use super::kind::{FileKind, foreign, refuse_other};
use super::parse::parse_toml;
use super::problem::{FormatError, Problems, unreadable};
use super::read::join;
use super::source::{self, OVERRIDE, Origin, Source, Sources};
use super::tree::{Entry, Node, Table, Value, entry_mut, from_value, place};

/// Largest size of a file, bytes. Machine files are a few kilobytes; a larger file is of another kind.
const LARGEST_FILE: u64 = 16 << 20;

/// Floating-point numbers represent every integer below this.
const LARGEST_WHOLE: f64 = 9_007_199_254_740_992.0;

/// Largest number of files that build on each other.
const LONGEST_CHAIN: usize = 8;

/// A machine or scenario file as written: keys can still be set, nothing is checked yet.
#[derive(Clone, Debug)]
pub struct Draft {
    pub(crate) sources: Sources,
    pub(crate) root: Table,
    /// Index of the file itself among the sources.
    pub(crate) main: usize,
    /// Results for its surfaces from earlier builds.
    pub(crate) gaps: Gaps,
}

/// The value of an override.
#[derive(Clone, Debug, PartialEq)]
pub enum Setting {
    Number(f64),
    /// A word, a name, or a number with its unit.
    Text(String),
    Flag(bool),
}

impl Draft {
    /// Reads a file and its base machine.
    ///
    /// # Errors
    /// A file that cannot be read or is not TOML.
    pub fn load(path: &Path) -> Result<Self, FormatError> {
        load(path, Self::parse)
    }

    /// Reads `text` as the content of `file_name`. Relative names in it refer to that file.
    ///
    /// # Errors
    /// As [`Draft::load`].
    pub fn parse(text: &str, file_name: &str) -> Result<Self, FormatError> {
        let mut draft =
            Self { sources: Sources::default(), root: Table::new(), main: 0, gaps: Gaps::default() };
        let table = parse_toml(text, file_name, &mut draft.sources)?;
        refuse_other(&table, FileKind::Scenario, &draft.sources)?;
        draft.root = draft.on_base(table, 1)?;
        Ok(draft)
    }

    /// The name of the file: the stated one, or that of the file itself. The name of a base file is that of
    /// another file; two files of one name would share a folder of results.
    pub(crate) fn name(&self, stated: Option<String>) -> String {
        let source = place(&self.root, NAME.name).source;
        let is_own = source == self.main || self.sources.0[source].name == OVERRIDE;
        let stem = || Path::new(&self.sources.0[self.main].name).file_stem()?.to_str().map(str::to_owned);
        stated.filter(|_| is_own).or_else(stem).unwrap_or_default()
    }

    /// Merges a table over the base machine that it names.
    fn on_base(&mut self, table: Table, depth: usize) -> Result<Table, FormatError> {
        let Some(entry) = table.get(BASE.name) else { return Ok(table) };
        // The reader rejects a value that is not a text.
        let Some(name) = entry.node.as_text() else { return Ok(table) };
        let origin = entry.node.origin.clone();
        let refuse = |draft: &Self, message: String, remedy: &str| {
            Err(draft.refuse(&origin, BASE.name, message, remedy))
        };
        if depth >= LONGEST_CHAIN {
            return refuse(
                self,
                format!("more than {LONGEST_CHAIN} files build on each other"),
                "a file may not build on itself",
            );
        }
        let path = source::beside(&self.sources.0[origin.source].directory, name);
        let text = match read_text(&path) {
            Ok(text) => text,
            Err(error) => {
                let message = error.problems.first().map_or("", |problem| problem.message.as_str());
                let remedy = error.problems.first().filter(|_| path.exists());
                return refuse(
                    self,
                    format!("{}: {message}", path.display()),
                    remedy.map_or("name a file relative to this one", |problem| problem.remedy.as_str()),
                );
            }
        };
        let base = parse_toml(&text, &path.display().to_string(), &mut self.sources)?;
        let mut base = self.on_base(base, depth + 1)?;
        base.shift_remove(BASE.name);
        let mut over = table;
        over.shift_remove(BASE.name);
        lay_over(&mut base, over, 0);
        Ok(base)
    }

    /// Sets a key, as `controllers.force.kp=0.8`. The value is TOML; anything that is not TOML is a text, so
    /// that `contacts.tool.gap=5 mm` works.
    ///
    /// # Errors
    /// No `=`, or a path through elements that do not exist.
    pub fn set(&mut self, assignment: &str) -> Result<(), FormatError> {
        let source = self.override_source(assignment);
        let Some((key, value)) = assignment.split_once('=').filter(|(key, _)| !key.trim().is_empty()) else {
            let origin = Origin { source, span: 0..assignment.len() };
            return Err(self.refuse(
                &origin,
                "",
                format!("`{assignment}` sets nothing"),
                format!("write KEY=VALUE, as in {EXAMPLE_KEY}=0.8"),
            ));
        };
        let start = key.len() + 1 + (value.len() - value.trim_start().len());
        let span = start..start + value.trim().len();
        let node = match DeValue::parse(value.trim()) {
            Ok(parsed) => {
                let mut node = from_value(&parsed, source);
                node.replace(&|at: &mut Origin| at.span = at.span.start + start..at.span.end + start);
                node
            }
            Err(_) => Node { value: Value::Text(value.trim().to_owned()), origin: Origin { source, span } },
        };
        self.place(key.trim(), &Origin { source, span: 0..key.len() }, node)
    }

    /// Sets a key to a value.
    ///
    /// # Errors
    /// A path through elements that do not exist.
    pub(crate) fn set_value(&mut self, key: &str, setting: &Setting) -> Result<(), FormatError> {
        let (shown, value) = match setting {
            // Whole numbers stay whole, for keys that count.
            Setting::Number(number) if number.fract() == 0.0 && number.abs() < LARGEST_WHOLE => {
                (number.to_string(), Value::Integer(*number as i128))
            }
            Setting::Number(number) => (number.to_string(), Value::Float(*number)),
            Setting::Text(text) => (text.clone(), Value::Text(text.clone())),
            Setting::Flag(flag) => (flag.to_string(), Value::Flag(*flag)),
        };
        let source = self.override_source(&format!("{key}={shown}"));
        let origin = Origin { source, span: key.len() + 1..key.len() + 1 + shown.len() };
        self.place(key, &Origin { source, span: 0..key.len() }, Node { value, origin })
    }

    /// Whether this is a scenario of a whole arm, for [`super::CellFile`].
    pub fn has_arm(&self) -> bool {
        self.root.contains_key(ARM_FILE.name)
    }

    /// The arm file that a scenario of a whole arm names.
    pub fn arm_file(&self) -> Option<PathBuf> {
        let node = &self.root.get(ARM_FILE.name)?.node;
        let Value::Text(name) = &node.value else { return None };
        Some(self.sources.0[node.origin.source].directory.join(name))
    }

    /// The start of the file itself.
    pub(crate) fn top(&self) -> Origin {
        Origin { source: self.main, span: 0..0 }
    }

    fn override_source(&mut self, text: &str) -> usize {
        self.sources.add(Source { name: OVERRIDE.into(), text: text.into(), directory: Path::new("").into() })
    }

    fn refuse(&self, origin: &Origin, key: &str, message: String, remedy: impl Into<String>) -> FormatError {
        let mut problems = Problems::default();
        problems.add(origin, key, message, remedy);
        problems.into_error(self.sources.clone())
    }

    /// Inserts a node at a dotted path. Creates tables on the way, but not elements.
    fn place(&mut self, path: &str, at: &Origin, node: Node) -> Result<(), FormatError> {
        let segments: Vec<&str> = match path.split_once('.') {
            Some((TOLERANCE, rest)) => vec![TOLERANCE, rest.trim_matches('"')],
            _ => path.split('.').collect(),
        };
        self.check_path(path, &segments, at)?;
        // Its keys are in this draft already.
        if path == BASE.name {
            let remedy = format!(
                "change its keys one by one, or write a file that begins with another `{}`",
                BASE.name
            );
            return Err(self.refuse(at, path, "the base file cannot be exchanged".into(), remedy));
        }
        if segments.len() == 2
            && ELEMENTS.iter().any(|element| element.table == segments[0])
            && node.as_table().is_none()
        {
            let message = format!("`{path}` is a whole table, not {}", node.value.kind());
            return Err(self.refuse(
                at,
                path,
                message,
                format!("name one of its keys, as in `{path}.{}`", self.first_key(&segments)),
            ));
        }
        let Some((last, way)) = segments.split_last() else { return Ok(()) };
        let mut table = &mut self.root;
        let mut walked = String::new();
        for (depth, segment) in way.iter().enumerate() {
            walked = join(&walked, segment);
            let entry = table
                .entry((*segment).to_owned())
                .or_insert_with(|| Entry { key: at.clone(), node: Node::table(at.clone()) });
            let kind = entry.node.value.kind();
            let (message, remedy) = match &mut entry.node.value {
                Value::Table(inner) => {
                    table = inner;
                    continue;
                }
                Value::Array(items) => {
                    let last = items.len().saturating_sub(1);
                    if let Some(inside) = entry_mut(items, &segments[depth + 1..]) {
                        *inside = node;
                        return Ok(());
                    }
                    (
                        format!("`{walked}` is a list, and has no such entry"),
                        format!("entries count from zero: `{walked}.0` to `{walked}.{last}`"),
                    )
                }
                _ => (format!("`{walked}` is {kind}, not a table"), format!("set `{walked}` as a whole")),
            };
            return Err(self.refuse(at, path, message, remedy));
        }
        let key = at.clone();
        table.insert((*last).to_owned(), Entry { key, node });
        Ok(())
    }

    /// The first key of a table whose value is a number.
    fn first_key(&self, way: &[&str]) -> String {
        let mut table = Some(&self.root);
        for name in way {
            table = table.and_then(|table| table.get(*name)).and_then(|entry| entry.node.as_table());
        }
        let keys = table
            .into_iter()
            .flatten()
            .filter(|(_, entry)| matches!(entry.node.value, Value::Float(_) | Value::Integer(_)));
        keys.map(|(key, _)| key.clone()).next().unwrap_or_else(|| "KEY".into())
    }

    /// The dotted path of an element's key in the file, if exactly one path ends in `end`.
    fn path_of(&self, end: &str) -> Option<String> {
        let mut found = Vec::new();
        for element in ELEMENTS {
            if let Some(table) = self.root.get(element.table).and_then(|entry| entry.node.as_table()) {
                paths(table, element.table, &mut found);
            }
        }
        let ending = format!(".{end}");
        let mut alike = found.into_iter().filter(|path| path.ends_with(&ending));
        alike.next().filter(|_| alike.next().is_none())
    }

    fn check_path(&self, path: &str, segments: &[&str], at: &Origin) -> Result<(), FormatError> {
        let first = segments[0];
        let tables = ELEMENTS.iter().map(|element| element.table);
        let of_cell = CELL
            .keys
            .iter()
            .map(|key| key.name)
            .chain(CELL_TABLES.iter().map(|(table, ..)| *table))
            .chain([JOINTS]);
        let top = TOP.iter().map(|key| key.name).chain(tables).chain([RUN_TABLE, TOLERANCE]);
        let top = top.chain(of_cell.filter(|_| self.has_arm()));
        if !top.clone().any(|name| name == first) {
            return Err(self.refuse(
                at,
                path,
                format!("there is no `{first}` in a scenario"),
                self.path_of(path)
                    .map_or_else(|| did_you_mean(first, top), |whole| format!("did you mean `{whole}`?")),
            ));
        }
        let Some(element) = ELEMENTS.iter().find(|element| element.table == first) else { return Ok(()) };
        let names = self.root.get(first).and_then(|entry| entry.node.as_table());
        let names = names.into_iter().flat_map(|table| table.keys().map(String::as_str));
        match segments.get(1) {
            None => {
                return Err(self.refuse(
                    at,
                    path,
                    format!("`{first}` is a whole table"),
                    "name one of its elements and a key",
                ));
            }
            Some(name) if !names.clone().any(|known| known == *name) => {
                return Err(self.refuse(
                    at,
                    path,
                    format!("there is no {} `{name}`", element.singular),
                    did_you_mean(name, names),
                ));
            }
            Some(_) => {}
        }
        if let Some([EFFECTS, kind, ..]) = segments.get(2..)
            && find(kind).is_none()
        {
            let kinds = LIBRARY.iter().map(|definition| definition.name);
            return Err(self.refuse(
                at,
                path,
                format!("there is no effect `{kind}`"),
                did_you_mean(kind, kinds),
            ));
        }
        Ok(())
    }
}

/// Dotted paths of all keys in a table.
fn paths(table: &Table, at: &str, into: &mut Vec<String>) {
    for (key, entry) in table {
        let path = join(at, key);
        if let Some(inner) = entry.node.as_table() {
            paths(inner, &path, into);
        }
        into.push(path);
    }
}

/// Keys of `over` replace those of `base`. Element tables and their effects are merged key by key; values,
/// inline tables and lists are replaced whole.
pub(crate) fn lay_over(base: &mut Table, over: Table, depth: usize) {
    for (name, entry) in over {
        let merges = depth < 2 || name == EFFECTS || depth > 2;
        let below = base.get_mut(&name).and_then(|old| old.node.as_table_mut());
        match (below, entry.node.value) {
            (Some(below), Value::Table(table)) if merges => lay_over(below, table, depth + 1),
            (_, value) => {
                base.insert(name, Entry { node: Node { value, origin: entry.node.origin }, key: entry.key });
            }
        }
    }
}

/// The text of a file that Feeler reads: a machine, a sweep, a dataset's description.
///
/// # Errors
/// No such file, a folder, more than 16 MiB, or not UTF-8.
pub fn read_text(path: &Path) -> Result<String, FormatError> {
    let name = path.display().to_string();
    let missing = |error: io::Error| {
        let absent = error.kind() == ErrorKind::NotFound;
        let what = if absent { "there is no such file".into() } else { error.to_string() };
        unreadable(&name, what, &file::remedy_of_missing(path))
    };
    let metadata = fs::metadata(path).map_err(missing)?;
    if metadata.is_dir() {
        let (what, remedy) = if path.join("dataset.toml").is_file() {
            (
                "this is the folder of a dataset",
                "`feeler diagnose` takes it; name the machine file in it here",
            )
        } else {
            (
                "this is a folder without a dataset.toml",
                "name a file in it; `feeler import` takes a folder of logs",
            )
        };
        return Err(unreadable(&name, what.into(), remedy));
    }
    let refused = |error: io::Error| {
        let remedy = match error.kind() {
            ErrorKind::PermissionDenied => "give yourself permission to read it",
            _ => "name a TOML file: a text in UTF-8",
        };
        unreadable(&name, error.to_string(), remedy)
    };
    let bytes = file::read_bytes(path, LARGEST_FILE).map_err(refused)?;
    if let Some((what, remedy)) = foreign(&bytes, path) {
        return Err(unreadable(&name, format!("{what}, but a TOML file is needed"), &remedy));
    }
    file::text_of(bytes).map_err(refused)
}

/// Reads a file and passes its text and name to `parse`.
pub(super) fn load<T>(
    path: &Path,
    parse: impl FnOnce(&str, &str) -> Result<T, FormatError>,
) -> Result<T, FormatError> {
    parse(&read_text(path)?, &path.display().to_string())
}

/// A single text, and its mistakes.
pub(super) struct Sheet {
    pub(super) sources: Sources,
    pub(super) root: Table,
    pub(super) problems: Problems,
}

impl Sheet {
    pub(super) fn parse(text: &str, file_name: &str, wanted: FileKind) -> Result<Self, FormatError> {
        let mut sources = Sources::default();
        let root = parse_toml(text, file_name, &mut sources)?;
        refuse_other(&root, wanted, &sources)?;
        Ok(Self { sources, root, problems: Problems::default() })
    }

    /// The result, if there are no mistakes.
    pub(super) fn finish<T>(self, read: Option<T>) -> Result<T, FormatError> {
        read.filter(|_| self.problems.is_empty()).ok_or_else(|| self.problems.into_error(self.sources))
    }
}
