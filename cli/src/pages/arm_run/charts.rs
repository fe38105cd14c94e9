//! Charts of force, commands, joints and torques.

use std::ops::Range;

use feeler_engine::Trace;
use feeler_files::CellFile;
use feeler_studies::run::CellRun;

use crate::pages::parts::{Chart, ChartKind, MOST_VALUES, Page, Series, by_extremes};

/// Largest number of shaded contact spans; more would be narrower than a pixel.
const MOST_BANDS: usize = 4_000;
/// Cycles in the close-up.
const CYCLES: f64 = 6.0;
const TIME: &str = "time (s)";
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// A signal with its name, its unit, and the factor of that unit.
struct Curve {
    signal: String,
    name: String,
    unit: &'static str,
    factor: f64,
    /// Whether the change since the start is shown.
    from_start: bool,
    dashed: bool,
}

impl Curve {
    fn new(signal: impl Into<String>, name: &str, unit: &'static str) -> Self {
        Self { signal: signal.into(), name: name.into(), unit, factor: 1.0, from_start: false, dashed: false }
    }
}

/// Charts over the whole run.
pub(super) fn whole_run(page: &mut Page, file: &CellFile, result: &CellRun) {
    let joints =
        || file.cell.joints.iter().map(|joint| joint.name.as_str()).zip(&file.cell.arm.chain().joints);
    forces(page, file, result, &(0..result.record.t_s.len()), "run");
    let slides = |joint: &feeler_arm::Joint| joint.kind == feeler_arm::JointKind::Prismatic;
    let any_slides = joints().any(|(_, joint)| slides(joint));
    let moved = joints().map(|(name, joint)| {
        let (unit, factor) = if slides(joint) { ("mm", 1e3) } else { ("deg", DEGREES) };
        Curve { factor, from_start: true, ..Curve::new(format!("joints.{name}.position"), name, unit) }
    });
    let torques = joints().map(|(name, joint)| {
        Curve::new(format!("joints.{name}.torque"), name, if slides(joint) { "N" } else { "N m" })
    });
    let way = [("tool.x", "x"), ("tool.y", "y"), ("tool.z", "z")].map(|(signal, name)| Curve {
        factor: 1e3,
        from_start: true,
        ..Curve::new(signal, name, "mm")
    });
    let rows = 0..result.motion.t_s.len();
    let charts = [
        (
            "Joints,",
            "change of position since the start, of the links.",
            if any_slides { "change (deg; mm where it slides)" } else { "change (deg)" },
            moved.collect::<Vec<_>>(),
        ),
        (
            "Torques of the drives,",
            "after their lags, at the joints.",
            if any_slides { "torque (N m; N where it slides)" } else { "torque (N m)" },
            torques.collect(),
        ),
        ("Tool,", "displacement since the start, base frame.", "displacement (mm)", way.into()),
    ];
    for (title, caption, label, curves) in charts {
        let Some(mut chart) = over_time(&result.motion, title, label, &rows, curves) else { continue };
        chart.caption = caption.into();
        chart.together = Some("run");
        chart.bands = bands(result, &rows, &result.motion);
        page.chart(&chart);
    }
}

/// The last cycles of a sustained oscillation.
pub(super) fn close_up(page: &mut Page, file: &CellFile, result: &CellRun) {
    let Some(oscillation) =
        result.summary.figures.oscillation.filter(|oscillation| oscillation.frequency_hz > 0.0)
    else {
        return;
    };
    let t_s = &result.record.t_s;
    let from_s = t_s.last().copied().unwrap_or(0.0) - CYCLES / oscillation.frequency_hz;
    page.heading("The last cycles");
    forces(page, file, result, &(t_s.partition_point(|&t| t < from_s)..t_s.len()), "end");
}

fn forces(page: &mut Page, file: &CellFile, result: &CellRun, rows: &Range<usize>, together: &'static str) {
    let scenario = &file.cell.scenario;
    let mut force = vec![Curve::new(result.contact.force_signal(), "force", "N")];
    let reading =
        result.force_loop.as_ref().and_then(|found| scenario.machine.sensors.get_index(found.sensor));
    force.extend(reading.map(|(name, _)| Curve::new(format!("{name}.reading"), "reading", "N")));
    force.extend(
        result
            .force_loop
            .as_ref()
            .map(|found| Curve { dashed: true, ..Curve::new(found.reference_signal(), "reference", "N") }),
    );
    let drive = scenario.machine.actuators.keys().next().map_or("drive", String::as_str);
    let command = vec![Curve::new(format!("{drive}.command"), "command", "N")];
    let depth = vec![Curve {
        factor: 1e3,
        ..Curve::new(format!("{}.compression", result.contact.name), "compression", "mm")
    }];
    let charts = [
        (
            "Contact force.",
            "Contact force along the normal, its reading at the wrist, and the reference.",
            "force (N)",
            force,
        ),
        ("Command.", "Commanded force along the normal.", "force (N)", command),
        (
            "Compression.",
            "Depth of the tip in the workpiece; below zero the distance between them.",
            "compression (mm)",
            depth,
        ),
    ];
    for (title, caption, label, curves) in charts {
        let Some(mut chart) = over_time(&result.record, title, label, rows, curves) else { continue };
        chart.caption = caption.into();
        chart.together = Some(together);
        chart.bands = bands(result, rows, &result.record);
        page.chart(&chart);
    }
}

/// Spans of time in which the tip pressed on the workpiece.
fn bands(result: &CellRun, rows: &Range<usize>, trace: &Trace) -> Vec<[f64; 2]> {
    let Some([from_s, .., to_s]) = trace.t_s.get(rows.clone()) else { return Vec::new() };
    let shown = result.contact.intervals.iter().filter(|span| span.end_s >= *from_s && span.start_s <= *to_s);
    shown.map(|span| [span.start_s.max(*from_s), span.end_s.min(*to_s)]).take(MOST_BANDS).collect()
}

fn over_time(
    trace: &Trace,
    title: &str,
    label: &str,
    rows: &Range<usize>,
    curves: Vec<Curve>,
) -> Option<Chart> {
    let found: Vec<(Curve, &[f64])> = curves
        .into_iter()
        .filter_map(|curve| Some((trace.column(&curve.signal)?.get(rows.clone())?, curve)))
        .map(|(c, curve)| (curve, c))
        .collect();
    let columns: Vec<&[f64]> = found.iter().map(|(_, column)| *column).collect();
    let kept = by_extremes(&columns, rows.len(), MOST_VALUES / trace.names.len().max(1));
    let mut chart = Chart::new(ChartKind::Line, title, TIME, label);
    chart.x = kept.iter().map(|&row| trace.t_s[rows.start + row]).collect();
    chart.series = (found.into_iter())
        .map(|(curve, column)| {
            let origin = if curve.from_start { column.first().copied().unwrap_or(0.0) } else { 0.0 };
            let series = Series::new(
                curve.name,
                curve.unit,
                kept.iter().map(|&row| (column[row] - origin) * curve.factor).collect(),
            );
            if curve.dashed { series.dashed() } else { series }
        })
        .collect();
    (!chart.series.is_empty()).then(|| chart.without_rounding())
}
