//! Runs a whole arm, and measures it as an axis.

use std::time::Instant;

use feeler_engine::{Event, EventKind, RunEnd, Trace};
use feeler_manipulator::{CellSimulation, JointEvent, LOWER, UPPER};
use feeler_plant::motion::Switch;
use serde::Serialize;

use super::error::RunError;
use super::record::event::EventRecord;
use super::summary::{FinishedRun, Summary};
use super::{Progress, SLICES};
use crate::run::measure::contact::{self, ContactRun};
use crate::run::measure::force_loop::ForceLoop;
use crate::run::measure::saturation::Limits;
use crate::run::measure::standing::Standing;
use feeler_files::CellFile;

/// Smallest rate of the measures.
const MEASURE_RATE_HZ: f64 = 1e4;
/// Largest number of joint events in the summary; a hunting joint has many.
const MOST_JOINT_EVENTS: usize = 1000;
/// The column that shows whether a joint's torque is at its limit.
const LIMITED: &str = "joints.limited";

/// All results of a run of a whole arm.
#[derive(Clone, Debug)]
pub struct CellRun {
    /// The record for the measures, at 10 kHz or more, with the contact's events.
    pub record: Trace,
    /// The record with joints, tool, point of contact and normal, at the rate of the file.
    pub motion: Trace,
    /// The contact, with its intervals of pushing.
    pub contact: ContactRun,
    /// The force loop whose reference the measures refer to.
    pub force_loop: Option<ForceLoop>,
    /// Whether a joint or the controller was at its limit, for each row of the record.
    pub saturated: Vec<bool>,
    pub summary: CellSummary,
}

/// A joint that reached the end of its travel, where a stop with the stiffness of its gear holds it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LimitMet {
    /// Name of the joint.
    pub joint: String,
    /// `upper limit` or `lower limit`.
    pub what: &'static str,
    /// The limit, rad or m.
    pub position: f64,
    /// First time at the limit, s.
    pub t_s: f64,
}

/// Results of a run of a whole arm.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CellSummary {
    /// The figures of an axis. Energies are not kept. Saturation counts the time at which a joint's torque or
    /// the controller was at its limit. Events are those of the contact and the first thousand of the joints.
    #[serde(flatten)]
    pub figures: Summary,
    /// Mean force over the last tenth of the run.
    pub final_force_n: f64,
    /// Largest distance of the tool from the line along the normal through its start.
    pub sideways_m: f64,
    /// Number of joint events: sticking, breaking loose, meeting or leaving a flank, or reaching the end of
    /// travel.
    pub joint_events: usize,
    /// Joints that reached an end of their travel, with the first time of each.
    pub limits: Vec<LimitMet>,
    /// Longest step, s.
    pub step_s: f64,
    /// Time for preparation, run and measures, s, per simulated second.
    pub wall_s_per_simulated_s: f64,
}

/// Runs a scenario of a whole arm, and calls `progress` from time to time.
///
/// # Errors
/// Mistakes of arm, shapes and wiring that appear only together. A motion that diverges is a result.
pub fn run_cell(file: &CellFile, progress: &mut dyn FnMut(Progress)) -> Result<CellRun, RunError> {
    let started = Instant::now();
    let cell = &file.cell;
    let duration_s = cell.scenario.run.duration_s;
    let every = (MEASURE_RATE_HZ / file.record_rate_hz).ceil().max(1.0);
    let rate_hz = file.record_rate_hz * every;
    let mut simulation = CellSimulation::new(cell, rate_hz, every as u64)?;
    let rows = (duration_s * rate_hz).floor();
    // Slices end at instants of the record, so slicing does not change any bit.
    let slices =
        (1..SLICES).map(|slice| (rows * slice as f64 / SLICES as f64).floor() / rate_hz).chain([duration_s]);
    let mut finished = simulation.run_to(0.0);
    for until_s in slices.filter(|until_s| *until_s > 0.0) {
        if finished.end.is_some() {
            break;
        }
        finished = simulation.run_to(until_s);
        progress(Progress { t_s: simulation.time_s(), duration_s });
    }
    if finished.end == Some(RunEnd::Completed) {
        simulation.finish();
    }
    let standing = Standing::of_arm(&simulation, cell);
    let (assembly, step_s) = (simulation.assembly().clone(), simulation.step_s());
    let found = simulation.into_record();
    let mut record = found.measures;
    with_slips(&mut record, &found.joint_events);
    let scenario = &cell.scenario;
    let contacts = contact::contacts(scenario, &assembly, &record, &[], finished.end_s);
    let force_loop = ForceLoop::find(scenario);
    let mut limits = Limits::of(scenario, &assembly, &record);
    for (flag, limited) in limits.saturated.iter_mut().zip(record.column(LIMITED).unwrap_or_default()) {
        *flag |= *limited > 0.5;
    }
    let summed = FinishedRun {
        scenario,
        assembly: &assembly,
        record: &record,
        contacts: &contacts,
        force_loop: force_loop.as_ref(),
        limits: &limits,
        end: finished.end,
        end_s: finished.end_s,
        is_longest: false,
        is_last: true,
        standing: &standing,
        steps: finished.steps,
        energy: None,
    };
    let mut figures = summed.summary();
    figures.name.clone_from(&file.name);
    figures.events = events(&figures.events, &found.joint_events, file);
    figures.wall_s = started.elapsed().as_secs_f64();
    let force_n =
        contacts.first().and_then(|contact| record.column(&contact.force_signal())).unwrap_or_default();
    let last = &force_n[force_n.len() - force_n.len().div_ceil(10)..];
    let summary = CellSummary {
        final_force_n: last.iter().sum::<f64>() / last.len().max(1) as f64,
        sideways_m: sideways_m(file, &found.motion),
        joint_events: found.joint_events.len(),
        limits: limits_met(&found.joint_events, file),
        step_s,
        wall_s_per_simulated_s: if figures.simulated_s > 0.0 {
            figures.wall_s / figures.simulated_s
        } else {
            0.0
        },
        figures,
    };
    let contact = contacts
        .into_iter()
        .next()
        .ok_or(feeler_manipulator::ManipulatorError::Count { what: "contact", count: 0 })?;
    Ok(CellRun { record, motion: found.motion, contact, force_loop, saturated: limits.saturated, summary })
}

/// Adds the dry-friction events of the joints to a record as those of the axis's guide: they separate hunting
/// from other oscillations.
fn with_slips(record: &mut Trace, joints: &[JointEvent]) {
    let kind = |what| match what {
        "stick" => Some(EventKind::Stick),
        "slip" => Some(EventKind::Slip),
        _ => None,
    };
    let slips = joints.iter().filter_map(|event| {
        Some(Event { t_s: event.t_s, kind: kind(event.what)?, switch: Switch::Friction(0) })
    });
    record.events.extend(slips);
    record.events.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
}

/// Events of the contact, and those of the joints with their names.
fn events(of_axis: &[EventRecord], joints: &[JointEvent], file: &CellFile) -> Vec<EventRecord> {
    let name = |joint: usize| file.cell.joints[joint].name.clone();
    let slips = [EventKind::Stick, EventKind::Slip].map(EventKind::name);
    let mut events: Vec<EventRecord> =
        of_axis.iter().filter(|event| !slips.contains(&event.what)).cloned().collect();
    events.extend(joints.iter().take(MOST_JOINT_EVENTS).map(|event| EventRecord {
        t_s: event.t_s,
        what: event.what,
        on: name(event.joint),
    }));
    events.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    events
}

fn limits_met(joints: &[JointEvent], file: &CellFile) -> Vec<LimitMet> {
    let mut met: Vec<LimitMet> = Vec::new();
    for event in joints.iter().filter(|event| [LOWER, UPPER].contains(&event.what)) {
        let joint = &file.cell.arm.chain().joints[event.joint];
        if !met.iter().any(|known| known.joint == joint.name && known.what == event.what) {
            let position = joint.limits[usize::from(event.what == UPPER)];
            met.push(LimitMet { joint: joint.name.clone(), what: event.what, position, t_s: event.t_s });
        }
    }
    met
}

/// Largest distance of the tool from the line along the normal through its start.
fn sideways_m(file: &CellFile, motion: &Trace) -> f64 {
    let columns = ["tool.x", "tool.y", "tool.z"].map(|name| motion.column(name).unwrap_or_default());
    let length = file.cell.start.normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    let normal = file.cell.start.normal.map(|x| x / length);
    let home = columns.map(|column| column.first().copied().unwrap_or(0.0));
    let off = |row: usize| {
        let way: [f64; 3] = std::array::from_fn(|axis| columns[axis][row] - home[axis]);
        let along: f64 = way.iter().zip(normal).map(|(a, b)| a * b).sum();
        way.iter().zip(normal).map(|(a, b)| (a - along * b).powi(2)).sum::<f64>().sqrt()
    };
    (0..motion.t_s.len()).map(off).fold(0.0, f64::max)
}
