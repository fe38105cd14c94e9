//! Scenarios of a whole arm: machine files that say `arm = "..."`.

mod arm_parts;
mod axis;

use std::path::{Path, PathBuf};

use feeler_arm::{ArmError, Target, inverse_kinematics, usual_starts};
use feeler_catalogue::{Contents, Keyed, Keys};
use feeler_engine::RunSettings;
use feeler_geometry::{Placement, Shape};
use feeler_manipulator::{Cell, CellSimulation, Hold, ManipulatorError, Part, Start};
use feeler_problem::{Problem, Remedy};
use nalgebra::Vector3;

#[cfg(test)]
pub(crate) use axis::{NOT_OF_SENSORS, OF_CONTACTS};

use super::build::shapes;
use super::document::Document;
use super::draft::Draft;
use super::keys::arm::JOINTS;
use super::keys::cell::{HOLD_TABLE, NORMAL, PLACE, POSE, SPEED, START_TABLE, TIP, WORKPIECE};
use super::keys::surface::{FILE, ShapeFile};
use super::keys::{ABOUT, CELL, CELL_TABLES, HOLD, NAME, PLACED, RUN_TABLE, SHARED, START};
use super::problem::{FormatError, Problems};
use super::read::{Reader, Scope, join};
use super::tree::{Table, locate, node_at};
use arm_parts::ArmParts;

/// Default rate of the record, Hz.
const RECORD_RATE_HZ: f64 = 1e3;
/// Longest run, s: the computation takes about as long as the simulated time.
const LONGEST_S: f64 = 1e3;
/// From this number of joints onwards, the tool's x axis can be aligned with the normal.
const POINTING: usize = 5;

/// A checked scenario of a whole arm.
#[derive(Clone, Debug)]
pub struct CellFile {
    pub name: String,
    /// Purpose of the scenario.
    pub about: String,
    /// The described arm, with workpiece and controller.
    pub cell: Cell,
    pub record_rate_hz: f64,
    /// Elements that the arm's files lack and that are not needed so far.
    pub doubts: Vec<Problem>,
    text: String,
}

impl CellFile {
    /// Reads and checks a file, the arm and every shape that it names.
    ///
    /// # Errors
    /// Every mistake at once; for the start and a URDF only the first.
    pub fn load(path: &Path) -> Result<Self, FormatError> {
        Self::build(Draft::load(path)?)
    }

    /// Checks a file in which keys may have been set.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn build(mut draft: Draft) -> Result<Self, FormatError> {
        let mut problems = Problems::default();
        let found = build(&mut draft, &mut problems);
        match found {
            Ok(Some(file)) if problems.is_empty() => Ok(file),
            Ok(_) => Err(problems.into_error(draft.sources)),
            Err(of_axis) => {
                let mut all = problems.into_error(draft.sources);
                all.problems.extend(of_axis.problems);
                Err(all)
            }
        }
    }

    /// The original text of the file.
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// The scenario, or `None` if there are problems; an error if the axis along the normal has mistakes.
fn build(draft: &mut Draft, problems: &mut Problems) -> Result<Option<CellFile>, FormatError> {
    let top = draft.top();
    let tables: Vec<&str> =
        CELL_TABLES.iter().map(|(table, ..)| *table).chain(SHARED).chain([JOINTS]).collect();
    let fields = Reader { problems, scope: Scope::new(false) }.fields(&CELL, &tables, &draft.root, &top, "");
    let arm = arm_parts::read(draft, &fields, problems);
    let start = table(draft, START_TABLE, &START, problems);
    let tip = part(draft, TIP, problems);
    let workpiece = part(draft, WORKPIECE, problems);
    let hold = table(draft, HOLD_TABLE, &HOLD, problems);
    let start = start.zip(arm.as_ref()).and_then(|(start, arm)| start_of(&start, arm, draft, problems));
    let hold = hold.as_ref().and_then(Hold::read);
    let held = hold.map_or(0.0, |hold| hold.bandwidth_hz);
    let others = if held > 0.0 { feeler_arm::Others::Held } else { feeler_arm::Others::Free };
    let reduction = start.as_ref().zip(arm.as_ref()).and_then(|(start, arm)| {
        let found = arm.arm.reduce(&start.pose, start.normal, others);
        found.map_err(|error| refuse_error(draft, problems, &join(START_TABLE, NORMAL.name), &error)).ok()
    });
    let scenario = axis::draft(draft, reduction.as_ref(), problems)
        .map(Document::build)
        .transpose()?
        .map(|document| document.scenario);
    let (Some(arm), Some(start), Some(tip), Some(workpiece), Some(hold), Some(scenario)) =
        (arm, start, tip, workpiece, hold, scenario)
    else {
        return Ok(None);
    };
    let stepped = node_at(&draft.root, &[RUN_TABLE, RunSettings::STEP.key.name]).is_some();
    if scenario.run.duration_s > LONGEST_S {
        let message = format!(
            "a run of {} s takes as long in good cases, and at most {LONGEST_S} s are simulated",
            scenario.run.duration_s
        );
        refuse(
            draft,
            problems,
            &RunSettings::key(&RunSettings::DURATION),
            message,
            "shorten it, or run the axis that `feeler reduce` makes",
        );
    }
    let cell = Cell {
        arm: arm.arm,
        joints: arm.joints,
        bodies: arm.bodies,
        start,
        tip,
        workpiece,
        hold,
        step_s: stepped.then_some(scenario.run.step_s),
        scenario,
    };
    if problems.is_empty() {
        check(&cell, draft, problems);
    }
    Ok(Some(CellFile {
        name: draft.name(fields.value(&NAME)),
        about: fields.value(&ABOUT).unwrap_or_default(),
        doubts: arm.doubts,
        record_rate_hz: cell.scenario.run.record_rate_hz.unwrap_or(RECORD_RATE_HZ),
        text: draft.sources.0[draft.main].text.to_string(),
        cell,
    }))
}

/// Records a mistake at a key.
fn refuse(
    draft: &Draft,
    problems: &mut Problems,
    key: &str,
    message: impl Into<String>,
    remedy: impl Into<String>,
) {
    let at = locate(&draft.root, key).0.unwrap_or(draft.top());
    problems.add(&at, key, message, remedy);
}

fn refuse_error(draft: &Draft, problems: &mut Problems, key: &str, error: &dyn Remedy) {
    refuse(draft, problems, key, error.to_string(), error.remedy());
}

/// Checks that need arm, tip and workpiece together.
fn check(cell: &Cell, draft: &Draft, problems: &mut Problems) {
    let found = cell.check_start().and_then(|()| CellSimulation::new(cell, RECORD_RATE_HZ, 1).map(drop));
    let Err(error) = found else { return };
    let [pose, place] = [POSE, PLACE].map(|key| join(START_TABLE, key.name));
    let key = match &error {
        ManipulatorError::Penetrates { .. } | ManipulatorError::SelfIntersects { .. } => {
            if locate(&draft.root, &pose).1 { pose } else { place }
        }
        _ => Some(error.place()).filter(|place| !place.is_empty()).unwrap_or_else(|| START_TABLE.into()),
    };
    refuse_error(draft, problems, &key, &error);
}

/// The fields of a table; if a required table is absent, its required keys are reported.
fn table(draft: &Draft, name: &str, keys: &'static Keys, problems: &mut Problems) -> Option<Contents> {
    let empty = Table::new();
    let top = draft.top();
    let (table, at) = match draft.root.get(name).map(|entry| &entry.node) {
        None => (&empty, &top),
        Some(node) => (problems.table(node, name, format!("write [{name}]"))?, &node.origin),
    };
    let before = problems.count();
    let fields = Reader { problems, scope: Scope::new(false) }.fields(keys, &[], table, at, name);
    (problems.count() == before).then_some(fields)
}

/// Reads a named shape with its position.
fn part(draft: &Draft, name: &str, problems: &mut Problems) -> Option<Part> {
    let fields = table(draft, name, &PLACED, problems)?;
    let place = Placement::read(&fields)?;
    let shape = match ShapeFile::read(&fields) {
        Some(written) => shape_of_file(draft, name, &written, problems)?,
        None => Shape::read(&fields)?,
    };
    Some(Part { shape, place }).filter(|part| sound(draft, part, name, problems))
}

/// Whether a shape can be built.
fn sound(draft: &Draft, part: &Part, name: &str, problems: &mut Problems) -> bool {
    let found = part.shape.outline(&Placement::default());
    found.map_err(|error| refuse_error(draft, problems, name, &error)).is_ok()
}

fn shape_of_file(draft: &Draft, name: &str, written: &ShapeFile, problems: &mut Problems) -> Option<Shape> {
    let key = join(name, FILE);
    let origin = locate(&draft.root, &key).0?;
    let path: PathBuf = draft.sources.0[origin.source].directory.join(written.file());
    let found = written.load(&path);
    let said = |error: shapes::FileError| {
        problems.add(&origin, key, format!("{}: {error}", path.display()), error.remedy());
    };
    found.map_err(said).ok()
}

fn start_of(fields: &Contents, parts: &ArmParts, draft: &Draft, problems: &mut Problems) -> Option<Start> {
    let normal: [f64; 3] = fields.value(&NORMAL)?;
    let chain = parts.arm.chain();
    let Some(along) = Vector3::from(normal).try_normalize(1e-12) else {
        refuse_error(draft, problems, &join(START_TABLE, NORMAL.name), &ArmError::Normal { normal });
        return None;
    };
    let pose = match (fields.value::<Vec<f64>>(&POSE), fields.value::<[f64; 3]>(&PLACE)) {
        (Some(pose), None) => chain.check_pose(&pose).map(|()| pose).map_err(|error| (POSE, error)),
        (None, Some(place)) => {
            let place_m = Vector3::from(place);
            let target = if chain.joints() >= POINTING {
                Target::Pointing(place_m, along)
            } else {
                Target::Position(place_m)
            };
            inverse_kinematics(chain, &target, &usual_starts(chain, place)).map_err(|error| (PLACE, error))
        }
        _ => {
            refuse(
                draft,
                problems,
                START_TABLE,
                format!("this needs either `{}` or `{}`", POSE.name, PLACE.name),
                "give the joints' positions, or where the tool is",
            );
            return None;
        }
    };
    let speed_m_per_s = fields.value(&SPEED)?;
    match pose {
        Ok(pose) => Some(Start { pose, normal: along.into(), speed_m_per_s }),
        Err((key, error)) => {
            refuse_error(draft, problems, &join(START_TABLE, key.name), &error);
            None
        }
    }
}
