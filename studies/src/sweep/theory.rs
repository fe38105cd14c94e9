//! Theory for the variants of a sweep, panel by panel.

use feeler_analysis::LimitCycle;
use feeler_files::Setting;

use super::Sweep;
use super::axes::{DrawnAxis, Panels};
use super::boundary::{LinearLimits, linear_limits};
use super::cycles::predicted_cycles;
use super::table::SweepTable;

/// Largest number of axis values at which cycles are predicted.
const MOST_VALUES: usize = 200;

/// Theory for a sweep.
#[derive(Clone, Debug)]
pub enum Theory {
    /// None: no axis runs over numbers.
    Nothing,
    /// Limits on a map of the first two axes, one per panel.
    Maps(Vec<MapTheory>),
    /// Cycles over the only axis, one list per panel.
    Diagrams(Vec<Vec<CyclesAt>>),
}

/// Limits of linear theory on a map.
#[derive(Clone, Debug, Default)]
pub struct MapTheory {
    /// The lines; `None` if cells differ in more than the two axes.
    pub limits: LinearLimits,
    /// Keys besides the two axes that differ between cells, and change the limit with them.
    pub varied: Vec<String>,
    /// Extension of the lines beyond the outermost values, as shares of the axes: half a cell of the finest
    /// grid.
    pub margins: [f64; 2],
}

/// Cycles that describing functions predict for a variant.
#[derive(Clone, Debug)]
pub struct CyclesAt {
    pub value: f64,
    pub row: usize,
    pub cycles: Vec<LimitCycle>,
}

impl Theory {
    /// The theory for the first `panels` panels of a sweep, with the drawn variants in `table`.
    pub fn of(sweep: &Sweep, table: &SweepTable, panels: usize) -> Self {
        let settings = Panels::of(&sweep.file);
        let settings = settings.settings().take(panels);
        match DrawnAxis::of(&sweep.file).as_slice() {
            [] => Self::Nothing,
            [axis] => Self::Diagrams(settings.map(|panel| cycles(sweep, table, axis, &panel)).collect()),
            [x, y, ..] => Self::Maps(settings.map(|panel| limits(sweep, [x, y], &panel)).collect()),
        }
    }
}

fn limits(sweep: &Sweep, axes: [&DrawnAxis; 2], panel: &[(String, Setting)]) -> MapTheory {
    let panels = Panels::of(&sweep.file);
    // Duration and noise of a run do not change the limit.
    let others = sweep
        .file
        .axes
        .keys()
        .filter(|key| !axes.iter().any(|axis| axis.key == **key) && !key.starts_with("run."));
    let varied: Vec<String> = others.filter(|key| !panels.has(key)).cloned().collect();
    let margins = axes.map(|axis| axis.last_index(&sweep.file).map_or(0.0, |last| 0.5 / last as f64));
    let limits = if varied.is_empty() {
        // The lines reach the edges of the plot.
        let [x, y] = [0, 1].map(|i| beyond(sweep, axes[i], margins[i]));
        linear_limits(&sweep.document, [&x, &y], panel)
    } else {
        LinearLimits::default()
    };
    MapTheory { limits, varied, margins }
}

/// An axis extended beyond its ends by a share of its length, on each side if the machine can be built there.
fn beyond(sweep: &Sweep, axis: &DrawnAxis, margin: f64) -> DrawnAxis {
    let end = |share: f64, otherwise: f64| {
        let value = axis.value(share);
        let builds = sweep.document.with([(axis.key.as_str(), Setting::Number(value))]).is_ok();
        if builds { value } else { otherwise }
    };
    DrawnAxis { range: [end(-margin, axis.range[0]), end(1.0 + margin, axis.range[1])], ..axis.clone() }
}

/// Cycles at the variants of a panel, by rising value; every n-th if there are many.
fn cycles(sweep: &Sweep, table: &SweepTable, axis: &DrawnAxis, panel: &[(String, Setting)]) -> Vec<CyclesAt> {
    let values = table.reals(&axis.key).unwrap_or_default();
    let mut rows: Vec<(f64, usize)> =
        table.rows_with(panel).into_iter().filter_map(|row| Some(((*values.get(row)?)?, row))).collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let step = rows.len().div_ceil(MOST_VALUES).max(1);
    let rows: Vec<(f64, usize)> = rows.into_iter().step_by(step).collect();
    let sorted: Vec<f64> = rows.iter().map(|(value, _)| *value).collect();
    let found = predicted_cycles(&sweep.document, axis, &sorted, panel);
    rows.into_iter().zip(found).map(|((value, row), cycles)| CyclesAt { value, row, cycles }).collect()
}
