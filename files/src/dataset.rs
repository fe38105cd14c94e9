//! Dataset files: measurements on the real machine.

use std::path::{Path, PathBuf};

use feeler_catalogue::Keyed;
use feeler_plant::assembly::resolve;
use feeler_plant::description::{Axis, SignalName};
use indexmap::IndexMap;

use super::build::Builder;
use super::document::Document;
use super::draft::{Draft, Sheet, load};
use super::followed::{self, followed_by};
use super::keys::dataset::{
    ABOUT, CLOCK, COLUMNS, ColumnSpec, EXPERIMENTS, Experiment, FILE, LogClock, MACHINE, NAME, RATE, SIGNAL,
    UNIT,
};
use super::keys::{COLUMN, DATASET, EXPERIMENT};
use super::kind::FileKind;
use super::located::Located;
use super::problem::{FormatError, Problems, unreadable};
use super::read::{Reader, Scope, join};
use super::source::Origin;
use super::tree::{Table, Value, place};

/// A checked dataset file with its believed machine. The series themselves are not read here.
#[derive(Clone, Debug)]
pub struct DatasetFile {
    /// Short name; by default the name of the folder.
    pub name: String,
    /// Description of the measurements.
    pub about: String,
    /// The machine file, relative to the dataset.
    pub machine_path: PathBuf,
    /// The believed machine.
    pub machine: Document,
    /// Unit of all clocks, if it differs from the headers.
    pub clock: Option<LogClock>,
    /// Rate of rows without a clock, Hz.
    pub rate_hz: Option<f64>,
    /// Columns by their name in the files.
    pub columns: IndexMap<String, ColumnSpec>,
    pub experiments: Vec<Experiment>,
}

impl DatasetFile {
    /// Reads `dataset.toml` in a folder, or a file under another name, and the machine that it names.
    ///
    /// # Errors
    /// Every mistake at once.
    pub fn load(path: &Path) -> Result<Self, FormatError> {
        let file = path.join("dataset.toml");
        if path.is_dir() && !file.exists() {
            let name = path.display();
            let remedy = format!("`feeler import {name} --out DIR` makes a dataset of the logs in it");
            return Err(unreadable(&name.to_string(), "this folder holds no dataset.toml".into(), &remedy));
        }
        load(if path.is_dir() { &file } else { path }, Self::parse)
    }

    /// Checks `text` as the content of `file_name`, against which other names in it are resolved.
    ///
    /// # Errors
    /// Every mistake at once.
    pub fn parse(text: &str, file_name: &str) -> Result<Self, FormatError> {
        let mut sheet = Sheet::parse(text, file_name, FileKind::Dataset)?;
        let file = Self::read(&sheet.root, &sheet.sources.0[0].directory, &mut sheet.problems);
        sheet.finish(file)
    }

    fn read(root: &Table, directory: &Path, problems: &mut Problems) -> Option<Self> {
        let mut reader = Reader { problems, scope: Scope::new(false) };
        let fields = reader.fields(&DATASET, &[COLUMNS, EXPERIMENTS], root, &Origin::default(), "");
        let machine_path = directory.join(fields.value::<String>(&MACHINE).unwrap_or_default());
        let machine = fields.get(MACHINE.name).and_then(|_| load_machine(&machine_path, root, problems));
        let columns = columns(root, machine.as_ref(), problems);
        let experiments = experiments(root, directory, problems);
        let folder = directory.file_name().map(|name| name.to_string_lossy().into_owned());
        Some(Self {
            name: fields.value(&NAME).or(folder).unwrap_or_default(),
            about: fields.value(&ABOUT).unwrap_or_default(),
            machine_path,
            machine: machine?,
            clock: fields.value(&CLOCK),
            rate_hz: fields.value(&RATE),
            columns,
            experiments,
        })
    }
}

fn load_machine(path: &Path, root: &Table, problems: &mut Problems) -> Option<Document> {
    let error = match Document::load(path) {
        Ok(machine) => return Some(machine),
        Err(error) => error,
    };
    let first = error.problems.first().map_or_else(String::new, Located::to_string);
    let remedy = "every mistake of a machine shows when it is checked by itself";
    problems.add(&place(root, MACHINE.name), MACHINE.name, first, remedy);
    None
}

fn columns(
    root: &Table,
    machine: Option<&Document>,
    problems: &mut Problems,
) -> IndexMap<String, ColumnSpec> {
    let mut found = IndexMap::new();
    let remedy = format!("add [{COLUMNS}.NAME] with a signal for each column of the files");
    let columns = problems.required(root, COLUMNS, &remedy);
    let columns = columns.and_then(|node| problems.table(node, COLUMNS, remedy));
    for (name, entry) in columns.into_iter().flatten() {
        let path = join(COLUMNS, name);
        let Some(table) = problems.table(&entry.node, &path, format!("write [{path}]")) else { continue };
        let written = table.get(SIGNAL.name).map(|entry| &entry.node);
        let signal = written.and_then(|node| node.as_text()).and_then(|text| text.parse::<SignalName>().ok());
        let own_name = |signal| match machine {
            Some(machine) => followed::plain(signal, &machine.scenario.machine),
            None => signal,
        };
        let signal = signal.map(own_name);
        let mut scope = Scope::new(false);
        if let (Some(signal), Some(machine), Some(node)) = (&signal, machine, written) {
            let followed = followed_by(signal);
            let problem = match followed {
                Some(controller) => followed::problem(machine, controller),
                None => resolve(&machine.scenario.machine, signal).err(),
            };
            if let Some(problem) = problem {
                problems.add(&node.origin, join(&path, SIGNAL.name), problem.message, problem.remedy);
            }
            scope = followed.map_or_else(
                || signal_scope(machine.draft(), machine.scenario.machine.axis, signal),
                |controller| followed::scope(machine, controller),
            );
        }
        let mut reader = Reader { problems, scope };
        let fields = reader.fields(&COLUMN, &[], table, &entry.node.origin, &path);
        let unit = table.get(UNIT.name).and_then(|entry| reader.unit(&entry.node, &join(&path, UNIT.name)));
        if let Some(signal) = fields.value(&SIGNAL) {
            let mut column = ColumnSpec::plain(own_name(signal));
            column.take(&fields);
            let scale = ColumnSpec::SCALE.key.name;
            if let Some(entry) = table.get(scale).filter(|_| column.scale.abs() <= 0.0) {
                let message = "with a factor of zero every reading is the same";
                let remedy = "write the factor from the numbers in the file to SI, or leave it out";
                reader.problems.add(&entry.node.origin, join(&path, scale), message, remedy);
            }
            column.scale *= unit.unwrap_or(1.0);
            found.insert(name.clone(), column);
        }
    }
    if let Some(machine) = machine {
        followed::name_commands(&mut found, &machine.scenario);
    }
    found
}

/// Units on the machine's axis; for a reading, those of the signal that the sensor reads.
fn signal_scope(draft: &Draft, axis: Axis, signal: &SignalName) -> Scope {
    let mut unheard = Problems::default();
    let builder = Builder::new(draft, &mut unheard, axis);
    Scope { signal: builder.measured_dim(signal), ..Scope::new(axis == Axis::Rotational) }
}

fn experiments(root: &Table, directory: &Path, problems: &mut Problems) -> Vec<Experiment> {
    let remedy = format!("add [[{EXPERIMENTS}]] with a file for each");
    let mut found = Vec::new();
    let Some(node) = problems.required(root, EXPERIMENTS, &remedy) else { return found };
    let Value::Array(items) = &node.value else {
        problems.mistyped(node, EXPERIMENTS, "a list", remedy);
        return found;
    };
    for (index, item) in items.iter().enumerate() {
        let path = format!("{EXPERIMENTS}[{index}]");
        let Some(table) = problems.table(item, &path, remedy.as_str()) else { continue };
        let mut reader = Reader { problems, scope: Scope::new(false) };
        let fields = reader.fields(&EXPERIMENT, &[], table, &item.origin, &path);
        let Some(file) = fields.value::<String>(&FILE) else { continue };
        let file = directory.join(file);
        let origin = table.get(FILE.name).map_or(&item.origin, |entry| &entry.node.origin);
        let mut refuse = |message: String, remedy: &str| {
            problems.add(origin, join(&path, FILE.name), message, remedy);
        };
        if !file.is_file() {
            let shown = file.display();
            let message = if file.is_dir() {
                format!("{shown} is a folder")
            } else {
                format!("there is no file {shown}")
            };
            refuse(message, "name a log relative to this file");
        }
        if found.iter().any(|other: &Experiment| other.file == file) {
            refuse("this file is an experiment already".into(), "name each file once");
        }
        let mut experiment = Experiment { file, engagement: None, role: None, repeat: None };
        experiment.take(&fields);
        found.push(experiment);
    }
    found
}
