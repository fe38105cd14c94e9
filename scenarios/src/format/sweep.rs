//! Sweep files: a scenario, and axes over its keys.

use std::path::{Path, PathBuf};

use indexmap::IndexMap;

use super::document::Document;
use super::draft::{Draft, Setting, parse_toml, read_text};
use super::keys::{AXIS, KEEP, REFINE, SWEEP};
use super::problem::{FormatError, Located, Problems};
use super::read::{Fields, Reader, Scope, join};
use super::shape::{Kind, Shape, Unit};
use super::source::{Origin, Sources};
use super::tree::{Entry, Node, Table, Value};

/// Most runs of a sweep; more is refused with the arithmetic.
const MOST_RUNS: f64 = 1e8;

/// Impacts and strobes that a bifurcation diagram shows of each run unless the file says otherwise.
const TAIL_OF_ONE_AXIS: usize = 64;

/// A sweep file that has been checked.
#[derive(Clone, Debug)]
pub struct SweepFile {
    /// Short name, empty where none is given.
    pub name: String,
    /// What it is for.
    pub about: String,
    /// The scenario, as found from the sweep file.
    pub scenario: PathBuf,
    /// Key paths and their values.
    pub axes: IndexMap<String, Axis>,
    /// How points are chosen.
    pub sampling: Sampling,
    /// How many points are drawn; on a grid the product of the axes' counts.
    pub samples: u64,
    /// Seed of the draws.
    pub seed: u64,
    /// What is kept of each run.
    pub keep: Keep,
    /// Whether a grid is made finer along boundaries.
    pub refine: Option<Refine>,
}

/// How a grid of one or two axes is made finer where neighbours differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refine {
    /// How often the spacing is halved.
    pub levels: u32,
    /// What changes across a boundary: the outcome itself, or only whether the force settles.
    pub by_outcome: bool,
}

/// Values that an axis takes, in SI.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Axis {
    /// Evenly spaced, both ends included.
    Linear {
        /// First value.
        from: f64,
        /// Last value.
        to: f64,
        /// How many.
        points: u64,
    },
    /// Of equal ratio, both ends included and of the same sign.
    Log {
        /// First value.
        from: f64,
        /// Last value.
        to: f64,
        /// How many.
        points: u64,
    },
    /// These.
    List(Vec<Setting>),
    /// Drawn uniformly.
    Uniform {
        /// Smallest value.
        from: f64,
        /// Largest value.
        to: f64,
    },
    /// Drawn with a uniform logarithm.
    LogUniform {
        /// Smallest value.
        from: f64,
        /// Largest value.
        to: f64,
    },
}

impl Axis {
    /// How many values it has; none for a distribution.
    pub fn count(&self) -> Option<u64> {
        match self {
            Self::Linear { points, .. } | Self::Log { points, .. } => Some(*points),
            Self::List(values) => Some(values.len() as u64),
            Self::Uniform { .. } | Self::LogUniform { .. } => None,
        }
    }

    /// The value at `share` of the way, from 0 to 1; that of a list is the one whose slice holds `share`.
    pub fn at(&self, share: f64) -> Setting {
        let ratio = |from: f64, to: f64| from * (to / from).powf(share);
        match self {
            Self::Linear { from, to, .. } | Self::Uniform { from, to } => Setting::Number(from + share * (to - from)),
            Self::Log { from, to, .. } | Self::LogUniform { from, to } => Setting::Number(ratio(*from, *to)),
            Self::List(values) => values[((share * values.len() as f64) as usize).min(values.len() - 1)].clone(),
        }
    }

    /// The value of a grid at `index`, which is below [`Axis::count`]; the first and the last are those written, to the bit.
    pub fn point(&self, index: u64) -> Setting {
        match self {
            Self::List(values) => values[(index as usize).min(values.len() - 1)].clone(),
            Self::Linear { to, points, .. } | Self::Log { to, points, .. } if index > 0 && index + 1 >= *points => Setting::Number(*to),
            Self::Log { from, .. } if index == 0 => Setting::Number(*from),
            Self::Linear { points, .. } | Self::Log { points, .. } => self.at(index as f64 / (points.max(&2) - 1) as f64),
            Self::Uniform { .. } | Self::LogUniform { .. } => self.at(0.5),
        }
    }
}

/// How the points of a sweep are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Sampling {
    /// Every combination of the axes.
    #[default]
    Grid,
    /// Independent draws.
    Random,
    /// Each axis cut into slices, each of which is drawn from once.
    LatinHypercube,
    /// A low-discrepancy sequence.
    Sobol,
}

/// What is kept of each run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Keep {
    /// The outcome with its measures.
    pub outcome: bool,
    /// The recorded signals.
    pub traces: bool,
    /// How many of the last impacts and strobes.
    pub tail: usize,
}

impl SweepFile {
    /// Reads and checks a sweep file and the scenario that it names, and tries the ends of each axis.
    ///
    /// # Errors
    /// Every mistake at once.
    pub fn load(path: &Path) -> Result<Self, FormatError> {
        Self::parse(&read_text(path)?, &path.display().to_string())
    }

    /// Checks `text` as the content of `file_name`, against which the scenario's name is resolved.
    ///
    /// # Errors
    /// Every mistake at once.
    pub fn parse(text: &str, file_name: &str) -> Result<Self, FormatError> {
        let mut sources = Sources::default();
        let root = parse_toml(text, file_name, &mut sources)?;
        let mut problems = Problems::default();
        if let Some(entry) = root.get("arm") {
            super::document::refuse_arm(entry, &mut problems);
            return Err(problems.into_error(sources));
        }
        let top = Origin::default();
        let mut reader = Reader { problems: &mut problems, scope: Scope::new(false) };
        let fields = reader.fields(&SWEEP, &["axes", "keep", "refine"], &root, &top, "");
        let mut table = |name: &str, shape| match root.get(name).map(|entry| &entry.node) {
            None => Fields::default(),
            Some(Node { value: Value::Table(table), origin }) => reader.fields(shape, &[], table, origin, name),
            Some(node) => refuse(&mut reader, node, name),
        };
        let (keep, refine) = (table("keep", &KEEP), table("refine", &REFINE));
        let axes = read_axes(&mut reader, &root, &top);
        let scenario = sources.0[0].directory.join(fields.text("scenario").unwrap_or_default());
        let drawn = axes.values().any(|axis| axis.count().is_none());
        let sampling = match fields.text("sampling") {
            Some("grid") => Sampling::Grid,
            Some("random") => Sampling::Random,
            Some("latin-hypercube") => Sampling::LatinHypercube,
            Some("sobol") => Sampling::Sobol,
            _ if drawn => Sampling::Random,
            _ => Sampling::Grid,
        };
        let place = |key: &str| root.get(key).map_or(&top, |entry| &entry.node.origin);
        if sampling == Sampling::Grid && drawn {
            problems.add(
                place("sampling"),
                "sampling",
                "a grid has no distributions",
                "use `linear` or `log` with `points`, or another sampling",
            );
        }
        if sampling == Sampling::Grid && root.contains_key("samples") {
            problems.add(
                place("samples"),
                "samples",
                "a grid has as many samples as its axes give",
                "remove it, or choose another sampling",
            );
        }
        if sampling != Sampling::Grid && !root.contains_key("samples") {
            problems.add(place("sampling"), "samples", "`samples` is missing", "add `samples = 1000`: how many points to draw");
        }
        let refine = root.contains_key("refine").then(|| Refine {
            levels: refine.count("levels").map_or(1, |levels| levels as u32),
            by_outcome: refine.text("by") == Some("outcome"),
        });
        let divides = |axis: &Axis| matches!(axis, Axis::Linear { points, .. } | Axis::Log { points, .. } if *points >= 2);
        if refine.is_some() && (axes.len() > 2 || sampling != Sampling::Grid || !axes.values().all(divides)) {
            problems.add(
                place("refine"),
                "refine",
                "only a grid of one or two axes, each `linear` or `log` with 2 points or more, can be refined",
                "remove [refine], or the other axes",
            );
        }
        if refine.is_some() && keep.get("outcome").is_some() && !keep.flag("outcome") {
            problems.add(place("keep"), "keep.outcome", "[refine] follows the outcome, which is not kept", "keep it, or remove [refine]");
        }
        let runs: f64 = axes.values().filter_map(Axis::count).map(|count| count as f64).product();
        if sampling == Sampling::Grid && runs > MOST_RUNS {
            let counts: Vec<String> = axes.values().filter_map(Axis::count).map(|count| count.to_string()).collect();
            let message = format!("{} = {runs:.3e} runs, and at most {MOST_RUNS:.0e} are taken", counts.join(" * "));
            problems.add(place("axes"), "axes", message, "use fewer points, or another sampling with `samples`");
        }
        if problems.is_empty() {
            try_ends(&axes, &scenario, &root, &mut problems);
        }
        if !problems.is_empty() {
            return Err(problems.into_error(sources));
        }
        let tail = keep.count("tail").map_or(if axes.len() == 1 { TAIL_OF_ONE_AXIS } else { 0 }, |tail| tail as usize);
        let samples = if sampling == Sampling::Grid { runs as u64 } else { fields.count("samples").unwrap_or(1) };
        Ok(Self {
            name: fields.text("name").unwrap_or_default().into(),
            about: fields.text("about").unwrap_or_default().into(),
            scenario,
            axes,
            sampling,
            samples,
            seed: fields.count("seed").unwrap_or(1),
            keep: Keep { outcome: keep.get("outcome").is_none() || keep.flag("outcome"), traces: keep.flag("traces"), tail },
            refine,
        })
    }
}

fn refuse(reader: &mut Reader<'_>, node: &Node, path: &str) -> Fields {
    reader.problems.add(&node.origin, path, format!("this must be a table, not {}", node.value.kind()), format!("write [{path}]"));
    Fields::default()
}

fn read_axes(reader: &mut Reader<'_>, root: &Table, top: &Origin) -> IndexMap<String, Axis> {
    let remedy = "add [axes] with lines such as \"controllers.force.kp\" = { log = [0.05, 5.0], points = 64 }";
    let mut axes = IndexMap::new();
    match root.get("axes").map(|entry| &entry.node) {
        None => reader.problems.add(top, "axes", "`axes` is missing", remedy),
        Some(Node { value: Value::Table(table), origin }) => {
            if table.is_empty() {
                reader.problems.add(origin, "axes", "there are no axes", remedy);
            }
            for (key, entry) in table {
                if let Some(axis) = read_axis(reader, key, entry) {
                    axes.insert(key.clone(), axis);
                }
            }
        }
        Some(node) => drop(refuse(reader, node, "axes")),
    }
    axes
}

fn read_axis(reader: &mut Reader<'_>, key: &str, entry: &Entry) -> Option<Axis> {
    let path = join("axes", &format!("\"{key}\""));
    let node = &entry.node;
    let table = match &node.value {
        Value::Array(items) => return read_list(reader, items, node, &path),
        Value::Table(table) => table,
        other => {
            let message = format!("this must be a list or a table, not {}", other.kind());
            reader.problems.add(&node.origin, path, message, "write [...], or { linear = [from, to], points = n }");
            return None;
        }
    };
    // An unquoted key is a table of tables.
    if table.values().all(|entry| entry.node.as_table().is_some()) && !table.is_empty() {
        reader.problems.add(&entry.key, path, "an axis's key needs quotes", "write \"controllers.force.kp\" = { ... }");
        return None;
    }
    let fields = reader.fields(&AXIS, &[], table, &node.origin, &path);
    let variant = fields.variant?;
    let [from, to] = fields.range(variant)?;
    let points = || fields.count("points");
    if variant.starts_with("log") && from * to <= 0.0 {
        reader.problems.add(
            &node.origin,
            path,
            format!("from {from} to {to} there is no ratio"),
            "give two numbers of the same sign, or a linear axis",
        );
        return None;
    }
    match variant {
        "linear" => Some(Axis::Linear { from, to, points: points()? }),
        "log" => Some(Axis::Log { from, to, points: points()? }),
        "uniform" => Some(Axis::Uniform { from, to }),
        _ => Some(Axis::LogUniform { from, to }),
    }
}

fn read_list(reader: &mut Reader<'_>, items: &[Node], node: &Node, path: &str) -> Option<Axis> {
    if items.is_empty() {
        reader.problems.add(&node.origin, path, "the list is empty", "give at least one value");
        return None;
    }
    let mut values = Vec::with_capacity(items.len());
    for item in items {
        let Some(value) = setting(item) else {
            let message = format!("an axis has no {}", item.value.kind().trim_start_matches("a "));
            reader.problems.add(&item.origin, path, message, "give numbers, texts with units, or words");
            return None;
        };
        values.push(value);
    }
    Some(Axis::List(values))
}

/// A value as it was written.
fn setting(item: &Node) -> Option<Setting> {
    match &item.value {
        Value::Float(value) => Some(Setting::Number(*value)),
        Value::Integer(value) => Some(Setting::Number(*value as f64)),
        Value::Text(text) => Some(Setting::Text(text.clone())),
        Value::Flag(flag) => Some(Setting::Flag(*flag)),
        Value::Date | Value::Array(_) | Value::Table(_) => None,
    }
}

/// Builds the scenario with the ends of each axis, as they were written, so that wrong keys, units and values show before a thousand runs.
fn try_ends(axes: &IndexMap<String, Axis>, scenario: &Path, root: &Table, problems: &mut Problems) {
    let base = match Draft::load(scenario).and_then(|draft| draft.clone().build().map(|_| draft)) {
        Ok(base) => base,
        Err(error) => {
            let origin = root.get("scenario").map(|entry| entry.node.origin.clone()).unwrap_or_default();
            let first = error.problems.first().map_or_else(String::new, Located::to_string);
            let remedy = "every mistake of a scenario shows when it is checked by itself";
            problems.add(&origin, "scenario", first, remedy);
            return;
        }
    };
    let table = root.get("axes").and_then(|entry| entry.node.as_table());
    for (key, axis) in axes {
        let Some(entry) = table.and_then(|table| table.get(key)) else { continue };
        for (setting, origin) in ends(axis, &entry.node) {
            let mut draft = base.clone();
            let tried = draft.set_value(key, &setting).and_then(|()| Document::build(draft));
            let Err(error) = tried else { continue };
            let path = join("axes", &format!("\"{key}\""));
            for problem in &error.problems {
                let remedy = problem.remedy.clone().unwrap_or_default();
                problems.add(&origin, path.as_str(), format!("with {}: {}", shown(&setting), problem.message), remedy);
            }
        }
    }
}

fn shown(setting: &Setting) -> String {
    match setting {
        Setting::Number(value) => value.to_string(),
        Setting::Text(text) => format!("\"{text}\""),
        Setting::Flag(flag) => flag.to_string(),
    }
}

/// First and last value of an axis as written, with their units; every value of a list.
fn ends(axis: &Axis, node: &Node) -> Vec<(Setting, Origin)> {
    if let Axis::List(values) = axis {
        let Value::Array(items) = &node.value else { return Vec::new() };
        return values.iter().cloned().zip(items.iter().map(|item| item.origin.clone())).collect();
    }
    let range = node.as_table().into_iter().flat_map(Table::values).find_map(|entry| match &entry.node.value {
        Value::Array(items) => Some(items),
        _ => None,
    });
    let written = |item: &Node| setting(item).map(|setting| (setting, item.origin.clone()));
    range.and_then(|items| Some(vec![written(items.first()?)?, written(items.last()?)?])).unwrap_or_default()
}

/// The SI unit of the number at a key path, on a translational axis; empty where it has none, or one that depends on more than the key.
pub fn unit_of_key(path: &str) -> String {
    let parts: Vec<&str> = path.split('.').collect();
    let of = |shape: &'static Shape, name: &str| {
        shape.all_keys().find(|key| key.name == name).and_then(|key| match key.kind {
            Kind::Quantity(Unit::Of(dimension), _) => Some(dimension.si_unit(false).to_owned()),
            Kind::Quantity(Unit::PowerStiffness, _) => Some("N/m".to_owned()),
            _ => None,
        })
    };
    let found = match parts.as_slice() {
        [_, _, super::keys::EFFECTS, kind, parameter] => crate::sweep::unit_of_effect(kind, parameter).map(str::to_owned),
        ["run", name] => of(&super::keys::RUN, name),
        ["contacts", _, "stiffness"] => Some("N/m".to_owned()),
        [table, _, name] => {
            let element = super::keys::ELEMENTS.iter().find(|element| element.table == *table);
            element.and_then(|element| of(&element.shape, name))
        }
        _ => None,
    };
    found.unwrap_or_default()
}
