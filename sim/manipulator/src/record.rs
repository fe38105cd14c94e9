//! The record of a run.

use feeler_engine::{Event, EventKind, Observer, Trace};
use feeler_plant::assembly::Assembly;
use feeler_plant::motion::{Switch, SwitchState};

use crate::cell::Cell;
use crate::mode::SwitchChange;

/// Joint events that are kept.
const MOST_EVENTS: usize = 1_000_000;

/// A joint that reached the upper limit of its position.
pub const UPPER: &str = "upper limit";
/// A joint that reached the lower limit of its position.
pub const LOWER: &str = "lower limit";

/// A joint that stuck or broke loose, met or left a flank of its play, or reached the end of its travel.
#[derive(Clone, Debug, PartialEq)]
pub struct JointEvent {
    pub t_s: f64,
    pub joint: usize,
    /// `stick`, `slip`, `touch`, `lift`, or [`UPPER`] or [`LOWER`].
    pub what: &'static str,
}

/// The signals of a run.
#[derive(Clone, Debug, Default)]
pub struct CellRecord {
    /// Force, compression and command along the normal, readings, and whether a joint's torque was at its
    /// limit (`joints.limited`). All are at the rate of the measures, with the contact's events.
    pub measures: Trace,
    /// The measures with joints, tool, point of contact and normal, at the rate of the file.
    pub motion: Trace,
    pub joint_events: Vec<JointEvent>,
}

pub(crate) fn put(trace: &mut Trace, t_s: f64, row: &[f64]) {
    Observer::record(trace, t_s, row);
}

/// Names of the recorded signals: those of the measures, and the additional ones of the motion.
pub(crate) fn names(cell: &Cell, assembly: &Assembly) -> [Vec<String>; 2] {
    let contact = &assembly.contacts[0].name;
    let drive = assembly.drives.first().map_or("drive", |drive| drive.name.as_str());
    let controller = cell.scenario.controllers.keys().next().map_or("controller", String::as_str);
    let mut measures: Vec<String> = ["force", "spring_force", "compression", "contact"]
        .iter()
        .map(|quantity| format!("{contact}.{quantity}"))
        .collect();
    measures.extend([
        format!("{drive}.command"),
        format!("{controller}.output"),
        format!("{controller}.reference"),
        "joints.limited".into(),
    ]);
    measures.extend(assembly.sensors.iter().map(|sensor| format!("{}.reading", sensor.name)));
    let mut motion = Vec::new();
    for joint in &cell.joints {
        motion.extend(
            ["position", "motor", "velocity", "torque"]
                .map(|quantity| format!("joints.{}.{quantity}", joint.name)),
        );
    }
    let turns = ["x", "y", "z", "turn_x", "turn_y", "turn_z"].map(|axis| format!("tool.{axis}"));
    let points = ["point.x", "point.y", "point.z", "normal.x", "normal.y", "normal.z"].map(str::to_owned);
    motion.extend(turns.into_iter().chain(points));
    [measures, motion]
}

/// Records joints that have reached the end of their travel.
pub(crate) fn note_limits(record: &mut CellRecord, t_s: f64, before: &[i8], now: &[i8]) {
    for (joint, (was, is)) in before.iter().zip(now).enumerate() {
        if was != is && *is != 0 && record.joint_events.len() < MOST_EVENTS {
            record.joint_events.push(JointEvent { t_s, joint, what: if *is > 0 { UPPER } else { LOWER } });
        }
    }
}

/// Records a change of state as an event, if it is one.
pub(crate) fn note(record: &mut CellRecord, t_s: f64, change: SwitchChange, [from, to]: [SwitchState; 2]) {
    let Some(kind) = EventKind::of(Switch::Contact(0), from, to) else { return };
    match change {
        SwitchChange::Contact(_) => {
            record.measures.events.push(Event { t_s, kind, switch: Switch::Contact(0) });
        }
        SwitchChange::Flank(joint, ..) | SwitchChange::Slide(joint, _)
            if record.joint_events.len() < MOST_EVENTS =>
        {
            record.joint_events.push(JointEvent { t_s, joint, what: kind.name() });
        }
        _ => {}
    }
}
