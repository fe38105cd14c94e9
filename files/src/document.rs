//! A checked file: the scenario it describes, and where each part of it was written.

use std::path::Path;

use feeler_catalogue::Keys;
use feeler_engine::Scenario;
use feeler_plant::assembly::assemble;
use feeler_plant::description::{Machine, Site};
use feeler_plant::problem::Problem;
use indexmap::IndexMap;

use super::build::{Builder, names};
use super::draft::{Draft, Setting};
use super::keys::cell::ARM_FILE;
use super::keys::{ABOUT, AXIS_KIND, EFFECTS, ELEMENTS, NAME, RUN_TABLE, TOLERANCE, TOP};
use super::problem::{FormatError, Problems};
use super::read::{Reader, Scope};
use super::source::OVERRIDE;
use super::tree::{Table, locate, node_at};

/// A checked machine or scenario file.
#[derive(Clone, Debug)]
pub struct Document {
    /// The described scenario, in SI.
    pub scenario: Scenario,
    /// Tolerances of believed values, as fractions, by dotted key.
    pub tolerance: IndexMap<String, f64>,
    draft: Draft,
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FilePlace {
    /// File, or `--set` for an override.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
}

impl Document {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// Every mistake at once.
    pub fn load(path: &Path) -> Result<Self, FormatError> {
        Draft::load(path)?.build()
    }

    /// Checks `text` as the content of `file_name`, against which relative names in it are resolved.
    ///
    /// # Errors
    /// Every mistake at once.
    pub fn parse(text: &str, file_name: &str) -> Result<Self, FormatError> {
        Draft::parse(text, file_name)?.build()
    }

    /// The file as it was written.
    pub fn text(&self) -> &str {
        &self.draft.sources.0[self.draft.main].text
    }

    /// The texts of the file and of its base files, in reading order.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.draft.sources.0.iter().map(|source| &*source.text)
    }

    /// Paths of the file and of its base files, in reading order.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let files = self.draft.sources.0.iter().filter(|source| source.name != OVERRIDE);
        files.map(|source| Path::new(source.name.as_str()))
    }

    /// The file with its overrides, to set further keys.
    pub fn draft(&self) -> &Draft {
        &self.draft
    }

    /// This document with some keys set, as for a variant of a sweep.
    ///
    /// # Errors
    /// Keys that do not exist, and all mistakes of the values.
    pub fn with<'a>(
        &self,
        settings: impl IntoIterator<Item = (&'a str, Setting)>,
    ) -> Result<Self, FormatError> {
        let mut draft = self.draft.clone();
        for (key, setting) in settings {
            draft.set_value(key, &setting)?;
        }
        draft.build()
    }

    /// The place of a key by its dotted path; `None` if the file does not have the key.
    pub fn place(&self, key: &str) -> Option<FilePlace> {
        let (origin, complete) = locate(&self.draft.root, key);
        let origin = origin.filter(|_| complete)?;
        let (line, column) = self.draft.sources.position(&origin);
        Some(FilePlace { file: self.draft.sources.0[origin.source].name.clone(), line, column })
    }

    /// Mistakes that only the engine finds, with their places in the file.
    pub fn locate_problems(&self, found: &[Problem]) -> FormatError {
        let mut problems = Problems::default();
        for problem in found {
            add_problem(&self.draft, &mut problems, problem.clone());
        }
        problems.into_error(self.draft.sources.clone())
    }

    pub(crate) fn build(draft: Draft) -> Result<Self, FormatError> {
        let mut problems = Problems::default();
        if let Some(entry) = draft.root.get(ARM_FILE.name) {
            refuse_arm(entry, &mut problems);
            return Err(problems.into_error(draft.sources));
        }
        let top = top_fields(&draft, &mut problems);
        let axis = top.value(&AXIS_KIND).unwrap_or_default();
        let name = draft.name(top.value(&NAME));
        let mut builder = Builder::new(&draft, &mut problems, axis);
        let machine = Machine { name, about: top.value(&ABOUT).unwrap_or_default(), ..builder.machine() };
        names::check(&draft.root, &mut problems);
        if let Err(found) = assemble(&machine) {
            // A part with mistakes of its own is not assembled correctly, so further problems with it are
            // dropped. The assembly may report two mistakes for one key.
            for problem in
                found.into_iter().filter(|problem| !problems.covers(&problem.key)).collect::<Vec<_>>()
            {
                add_problem(&draft, &mut problems, problem);
            }
        }
        let mut builder = Builder::new(&draft, &mut problems, axis);
        let controllers = builder.controllers(&machine);
        let run = builder.run(&machine, &controllers);
        let tolerance = tolerance(&draft.root, &machine, &mut problems);
        if !problems.is_empty() {
            return Err(problems.into_error(draft.sources));
        }
        Ok(Self { scenario: Scenario { machine, controllers, run }, tolerance, draft })
    }
}

impl Draft {
    /// Reads a file as [`Draft::load`] does, and sets the keys of `settings` in turn, as [`Draft::set`] does.
    ///
    /// # Errors
    /// The errors of both. If settings are wrong, all other mistakes are reported with them.
    pub fn load_with(path: &Path, settings: &[String]) -> Result<Self, FormatError> {
        let mut draft = Self::load(path)?;
        let wrong: Vec<FormatError> =
            settings.iter().filter_map(|setting| draft.set(setting).err()).collect();
        if wrong.is_empty() {
            return Ok(draft);
        }
        let sources = draft.sources.clone();
        let whole = draft.build().err();
        let omitted = whole.as_ref().map_or(0, |error| error.omitted);
        let problems = whole.into_iter().chain(wrong).flat_map(|error| error.problems).collect();
        Err(FormatError { problems, omitted, sources })
    }

    /// Checks everything and resolves it.
    ///
    /// # Errors
    /// Every mistake at once.
    pub fn build(self) -> Result<Document, FormatError> {
        Document::build(self)
    }
}

/// The mistake of a scenario of a whole arm where a single axis is needed.
pub(super) fn refuse_arm(entry: &super::tree::Entry, problems: &mut Problems) {
    let remedy = "`feeler run` simulates it; for this command, reduce it to one axis along the contact \
                  normal with `feeler reduce`";
    problems.add(
        &entry.key,
        ARM_FILE.name,
        "this is a scenario of a whole arm, but this command needs a single axis",
        remedy,
    );
}

fn add_problem(draft: &Draft, problems: &mut Problems, problem: Problem) {
    let origin = locate(&draft.root, &problem.key).0.unwrap_or(draft.top());
    // A list entry has its own place in the file, but the key of the list.
    let key =
        problem.key.trim_end_matches(|c: char| c.is_ascii_digit()).strip_suffix('.').unwrap_or(&problem.key);
    problems.add(&origin, key, problem.message, problem.remedy);
}

/// Keys at the top; element tables, `[run]` and `[tolerance]` are read elsewhere.
fn top_fields(draft: &Draft, problems: &mut Problems) -> feeler_catalogue::Contents {
    static SHAPE: Keys = Keys { keys: TOP, choice: None };
    let mut tables: Vec<&str> = ELEMENTS.iter().map(|element| element.table).collect();
    tables.extend([RUN_TABLE, TOLERANCE]);
    let at = draft.top();
    Reader { problems, scope: Scope::new(false) }.fields(&SHAPE, &tables, &draft.root, &at, "")
}

fn tolerance(root: &Table, machine: &Machine, problems: &mut Problems) -> IndexMap<String, f64> {
    let mut found = IndexMap::new();
    // If the machine has mistakes, it may lack the element.
    let is_whole = problems.is_empty();
    let Some(entry) = root.get(TOLERANCE) else { return found };
    let Some(table) = problems.table(&entry.node, TOLERANCE, format!("write [{TOLERANCE}]")) else {
        return found;
    };
    for (key, entry) in table {
        let path = format!("{TOLERANCE}.\"{key}\"");
        if !is_known(root, key) {
            let remedy = "name a key of an element in quotes, as in \"bodies.motor.mass\" = 0.05";
            problems.add(&entry.key, &path, format!("there is no `{key}` in this file"), remedy);
        } else if is_whole && let Some(remedy) = not_believed(machine, key) {
            let message = format!("a diagnosis takes `{key}` as it is: a tolerance of it has no effect");
            problems.add(&entry.key, &path, message, remedy);
        }
        let mut reader = Reader { problems, scope: Scope::new(false) };
        let number = feeler_catalogue::Dimension::NONE;
        let bound = feeler_catalogue::Bound::Within(0.0, 1e6);
        if let Some(value) = reader.quantity_of(&entry.node, number, bound, &path) {
            found.insert(key.clone(), value);
        }
    }
    found
}

/// Advice against a tolerance of a key that is not a believed value; `None` if the key may have one, as
/// parameters of effects may.
fn not_believed(machine: &Machine, path: &str) -> Option<String> {
    let of = |site: Site| Some((site, path.strip_prefix(&site.key(machine))?.strip_prefix('.')?));
    let Some((site, key)) = machine.sites().find_map(of) else { return Some("leave it out".into()) };
    let believed = machine.element(site).map_or_else(Vec::new, |(_, element)| element.believed());
    let is_effect = key.split('.').next() == Some(EFFECTS);
    if is_effect || believed.iter().any(|believed| believed.key.name == key) {
        return None;
    }
    let others: Vec<String> = believed.iter().map(|other| format!("`{}`", other.key.name)).collect();
    let others = if others.is_empty() { "nothing".into() } else { others.join(", ") };
    Some(format!("leave it out; of `{}`, {others} may have one", site.key(machine)))
}

/// Whether a dotted path names a key of an element of the file, written or at its default.
fn is_known(root: &Table, path: &str) -> bool {
    let segments: Vec<&str> = path.split('.').collect();
    let [table, name, key, ..] = segments.as_slice() else { return false };
    let Some(element) = ELEMENTS.iter().find(|element| element.table == *table) else { return false };
    let known = element.shape.all_keys().any(|known| known.name == *key);
    node_at(root, &[table, name]).is_some() && (known || locate(root, path).1)
}
