//! Sweep files: a scenario, and axes over its keys.

mod axes;
mod ends;
mod refine;
mod unit;

use std::path::{Path, PathBuf};

use feeler_catalogue::{Contents, Keyed};
use indexmap::IndexMap;

pub use axes::SweepAxis;
pub use refine::Refine;
pub(crate) use unit::unit_of_key;

use super::draft::{Sheet, load};
use super::keys::cell::ARM_FILE;
use super::keys::sweep::{
    ABOUT, AXES, KEEP_TABLE, Keep, NAME, POINTS, REFINE_TABLE, SAMPLES, SAMPLING, SCENARIO, SEED, Sampling,
};
use super::keys::{KEEP, REFINE, SWEEP};
use super::problem::{FormatError, Problems};
use super::read::{Reader, Scope};
use super::source::{self, Origin, Sources};
use super::tree::{Table, place};
use crate::kind::FileKind;
use axes::read_axes;
use ends::try_ends;

/// Largest number of axes of a Sobol sequence: one more than the number of polynomials that define it.
pub const MOST_DIMENSIONS: usize = 21;
/// Largest number of runs of a sweep. The error for more runs shows how their number follows.
const MOST_RUNS: f64 = 1e8;

/// Default number of impacts and strobes per run in a bifurcation diagram over a single numerical axis.
const TAIL_OF_ONE_AXIS: usize = 64;

/// A checked sweep file.
#[derive(Clone, Debug)]
pub struct SweepFile {
    /// Short name; empty if there is none.
    pub name: String,
    /// Purpose of the sweep.
    pub about: String,
    /// The scenario, relative to the sweep file.
    pub scenario: PathBuf,
    /// Key paths and their values.
    pub axes: IndexMap<String, SweepAxis>,
    /// The SI unit of each key; empty for a pure number.
    pub units: IndexMap<String, String>,
    /// Sampling method of the points.
    pub sampling: Sampling,
    /// Number of drawn points; for a grid the product of the axes' counts.
    pub samples: u64,
    pub seed: u64,
    /// Data kept of each run.
    pub keep: Keep,
    /// Whether a grid is refined along boundaries.
    pub refine: Option<Refine>,
}

impl SweepFile {
    /// Reads and checks a sweep file and the scenario that it names, and tries the ends of each axis.
    ///
    /// # Errors
    /// Every mistake at once.
    pub fn load(path: &Path) -> Result<Self, FormatError> {
        load(path, Self::parse)
    }

    /// Checks `text` as the content of `file_name`, against which the scenario's name is resolved.
    ///
    /// # Errors
    /// Every mistake at once.
    pub fn parse(text: &str, file_name: &str) -> Result<Self, FormatError> {
        let mut sheet = Sheet::parse(text, file_name, FileKind::Sweep)?;
        let file = Self::read(&sheet.root, &sheet.sources, &mut sheet.problems);
        sheet.finish(file)
    }

    /// The contents of a file. The result is valid only if no problem was recorded.
    fn read(root: &Table, sources: &Sources, problems: &mut Problems) -> Option<Self> {
        if let Some(entry) = root.get(ARM_FILE.name) {
            super::document::refuse_arm(entry, problems);
            return None;
        }
        let mut reader = Reader { problems, scope: Scope::new(false) };
        let fields = reader.fields(&SWEEP, &[AXES, KEEP_TABLE, REFINE_TABLE], root, &Origin::default(), "");
        let mut table = |name: &str, shape| {
            let Some(entry) = root.get(name) else { return Contents::default() };
            let table = reader.problems.table(&entry.node, name, format!("write [{name}]"));
            table.map_or_else(Contents::default, |table| {
                reader.fields(shape, &[], table, &entry.node.origin, name)
            })
        };
        let (keep, refine) = (table(KEEP_TABLE, &KEEP), table(REFINE_TABLE, &REFINE));
        let read = read_axes(&mut reader, root);
        let refine = Refine::read(&refine, root, &read, problems);
        let scenario =
            fields.value(&SCENARIO).map(|name: String| source::beside(&sources.0[0].directory, &name));
        let units = scenario
            .as_ref()
            .and_then(|scenario| try_ends(&read, scenario, root, problems))
            .unwrap_or_default();
        let axes: IndexMap<String, SweepAxis> =
            read.into_iter().map(|(key, read)| (key, read.axis)).collect();
        let drawn = axes.values().any(|axis| axis.count().is_none());
        let by_axes = if drawn { Sampling::Random } else { Sampling::Grid };
        let sampling = fields.value(&SAMPLING).unwrap_or(by_axes);
        let runs: f64 = axes.values().filter_map(SweepAxis::count).map(|count| count as f64).product();
        // A list is not an axis of a diagram: each of its values has a separate diagram.
        let drawn_over_one = axes.values().filter(|axis| !matches!(axis, SweepAxis::List(_))).count() == 1;
        let tail = if drawn_over_one { TAIL_OF_ONE_AXIS } else { 0 };
        let mut kept = Keep { outcome: true, traces: false, tail };
        kept.take(&keep);
        let file = Self {
            name: fields.value(&NAME).unwrap_or_default(),
            about: fields.value(&ABOUT).unwrap_or_default(),
            scenario: scenario.unwrap_or_default(),
            axes,
            units,
            sampling,
            samples: if sampling == Sampling::Grid {
                runs as u64
            } else {
                fields.value(&SAMPLES).unwrap_or(1)
            },
            seed: fields.value(&SEED).unwrap_or(1),
            keep: kept,
            refine,
        };
        file.check_sampling(root, runs, problems);
        file.check_refinement(root, problems);
        Some(file)
    }

    fn check_sampling(&self, root: &Table, runs: f64, problems: &mut Problems) {
        let mut add =
            |key: &str, message: &str, remedy: &str| problems.add(&place(root, key), key, message, remedy);
        let samples = root.contains_key(SAMPLES.name);
        if self.sampling != Sampling::Grid {
            if !samples {
                add(
                    SAMPLES.name,
                    "`samples` is missing",
                    "add the number of points to draw, as in `samples = 1000`",
                );
            }
            // Draws can choose from a list, but not from values with a fixed spacing.
            let spaced = |axis: &SweepAxis| matches!(axis, SweepAxis::Linear { .. } | SweepAxis::Log { .. });
            for (key, axis) in self.axes.iter().filter(|(_, axis)| spaced(axis)) {
                let way = if matches!(axis, SweepAxis::Log { .. }) { "log_uniform" } else { "uniform" };
                let message =
                    format!("points are drawn at random, but the values of \"{key}\" have a fixed spacing");
                add(
                    AXES,
                    &message,
                    &format!(
                        "write {{ {way} = [from, to] }} without `{}`, or `{} = \"{}\"` without `{}`",
                        POINTS.name,
                        SAMPLING.name,
                        Sampling::Grid.name(),
                        SAMPLES.name
                    ),
                );
            }
            if self.sampling == Sampling::Sobol && self.axes.len() > MOST_DIMENSIONS {
                let message = format!(
                    "a Sobol sequence has at most {MOST_DIMENSIONS} dimensions (got {} axes)",
                    self.axes.len()
                );
                add(AXES, &message, "use `sampling = \"latin-hypercube\"`");
            }
            return;
        }
        if self.axes.values().any(|axis| axis.count().is_none()) {
            add(
                SAMPLING.name,
                "a grid has no distributions",
                "use `linear` or `log` with `points`, or another sampling",
            );
        }
        if samples {
            add(
                SAMPLES.name,
                "a grid has as many samples as its axes give",
                "remove it, or choose another sampling",
            );
        }
        if runs > MOST_RUNS {
            let counts: Vec<String> =
                self.axes.values().filter_map(SweepAxis::count).map(|count| count.to_string()).collect();
            let message =
                format!("{} = {runs:.3e} runs, and at most {MOST_RUNS:.0e} are taken", counts.join(" * "));
            add(AXES, &message, "use fewer points, or another sampling with `samples`");
        }
    }

    fn check_refinement(&self, root: &Table, problems: &mut Problems) {
        if self.refine.is_none() {
            return;
        }
        let divides = |axis: &SweepAxis| match axis {
            SweepAxis::Linear { points, .. } | SweepAxis::Log { points, .. } => *points >= 2,
            _ => false,
        };
        if self.axes.len() > 2 || self.sampling != Sampling::Grid || !self.axes.values().all(divides) {
            let message = "only a grid of one or two axes, each `linear` or `log` with 2 points or more, \
                           can be refined";
            problems.add(
                &place(root, REFINE_TABLE),
                REFINE_TABLE,
                message,
                "remove [refine], or the other axes",
            );
        }
        if !self.keep.outcome {
            let message = "[refine] needs the outcome, which is not kept";
            problems.add(&place(root, KEEP_TABLE), "keep.outcome", message, "keep it, or remove [refine]");
        }
    }
}
