//! The force bandwidth over a workspace.

use std::fmt::Write as _;
use std::sync::atomic::{AtomicUsize, Ordering};

use feeler_arm::{Agreement, ArmError, Others, Target, inverse_kinematics};
use nalgebra::Vector3;
use rayon::prelude::*;

use super::axis_file::ToolContact;
use super::error::ArmFileError;
use feeler_files::ArmFile;

/// Positions of the tool: a rectangle in x and y of the base at one height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// First and last x, m, and their number.
    pub x: (f64, f64, usize),
    /// First and last y, m, and their number.
    pub y: (f64, f64, usize),
    /// Height, m.
    pub z_m: f64,
}

/// Results at one position.
#[derive(Clone, Debug, PartialEq)]
pub struct MapPoint {
    /// Position of the tool, m.
    pub place_m: [f64; 3],
    /// The pose, and the axis's masses, stiffness and bandwidth there; otherwise the reason.
    pub found: Result<MapValues, NoAxis>,
}

/// Why a position of a map has no axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NoAxis {
    /// No pose within the joint limits brings the tool there.
    OutOfReach,
    /// The arm cannot move along the normal there.
    Singular,
    /// Anything else, in words.
    Other(String),
}

impl NoAxis {
    /// The reason as a remark on a place.
    pub fn reason(&self) -> &str {
        match self {
            Self::OutOfReach => "out of reach",
            Self::Singular => "the arm cannot move along the normal",
            Self::Other(why) => why,
        }
    }
}

/// Numbers of one place.
#[derive(Clone, Debug, PartialEq)]
pub struct MapValues {
    /// Joint positions, rad or m.
    pub pose: Vec<f64>,
    /// Mass along the normal.
    pub mass_kg: f64,
    /// Stiffness of all joints in series along the normal, with locked motors.
    pub stiffness_n_per_m: f64,
    /// Agreement of the axis with the whole arm in contact.
    pub agreement: Agreement,
}

/// The arm's axis and its force bandwidth at every position of a grid, with the tool's x axis along the
/// normal. Each pose starts from that of the previous position, the first from `start`. A position without an
/// axis has a reason. Any thread may call `progress` with the completed share.
///
/// # Errors
/// [`ArmError::Normal`].
pub fn bandwidth_map(
    file: &ArmFile,
    grid: &Grid,
    normal: [f64; 3],
    others: Others,
    contact: ToolContact,
    start: &[f64],
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Vec<MapPoint>, ArmFileError> {
    let step = |(from, to, count): (f64, f64, usize), i: usize| {
        if count < 2 { from } else { from + (to - from) * i as f64 / (count - 1) as f64 }
    };
    let mut poses = Vec::new();
    let mut last = start.to_vec();
    for i in 0..grid.x.2 {
        for k in 0..grid.y.2 {
            // Back and forth, so that consecutive positions are neighbours.
            let k = if i % 2 == 0 { k } else { grid.y.2 - 1 - k };
            let place_m = [step(grid.x, i), step(grid.y, k), grid.z_m];
            let target = tool_target(file, place_m, normal)?;
            let pose = inverse_kinematics(file.arm.chain(), &target, &[last.clone(), start.to_vec()]).ok();
            if let Some(pose) = &pose {
                last.clone_from(pose);
            }
            poses.push((place_m, pose));
        }
    }
    let done = AtomicUsize::new(0);
    let mut points: Vec<MapPoint> = (poses.par_iter())
        .map(|(place_m, pose)| {
            let found = match pose {
                Some(pose) => values(file, pose, normal, others, contact).map_err(reason),
                None => Err(NoAxis::OutOfReach),
            };
            progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / poses.len() as f64);
            MapPoint { place_m: *place_m, found }
        })
        .collect();
    points.sort_by(|a, b| a.place_m.partial_cmp(&b.place_m).unwrap_or(std::cmp::Ordering::Equal));
    Ok(points)
}

fn reason(error: ArmFileError) -> NoAxis {
    match error {
        ArmFileError::Arm(ArmError::Singular { .. }) => NoAxis::Singular,
        other => NoAxis::Other(other.to_string()),
    }
}

/// Reasons for positions without an axis, and the number for each, in alphabetical order.
pub fn without_axis(map: &[MapPoint]) -> Vec<(&str, usize)> {
    let mut reasons: Vec<&str> =
        map.iter().filter_map(|point| Some(point.found.as_ref().err()?.reason())).collect();
    reasons.sort_unstable();
    reasons.chunk_by(|a, b| a == b).map(|same| (same[0], same.len())).collect()
}

/// Target of the tool; its x axis is along the normal if the arm has enough joints.
///
/// # Errors
/// [`ArmError::Normal`].
pub fn tool_target(file: &ArmFile, place_m: [f64; 3], normal: [f64; 3]) -> Result<Target, ArmError> {
    let along = Vector3::from(normal).try_normalize(1e-12).ok_or(ArmError::Normal { normal })?;
    let place = Vector3::from(place_m);
    Ok(if file.arm.chain().joints() >= 5 { Target::Pointing(place, along) } else { Target::Position(place) })
}

fn values(
    file: &ArmFile,
    pose: &[f64],
    normal: [f64; 3],
    others: Others,
    contact: ToolContact,
) -> Result<MapValues, ArmFileError> {
    let touch = [contact.stiffness_n_per_m, contact.damping_n_s_per_m];
    let (axis, agreement) = file.arm.reduce_in_contact(pose, normal, others, touch)?;
    let stiffness_n_per_m = axis.static_stiffness_n_per_m;
    Ok(MapValues { pose: pose.to_vec(), mass_kg: axis.mass_kg, stiffness_n_per_m, agreement })
}

/// The map as comma-separated values, a row for each position. Numbers are SI, and `none` stands for one that
/// does not exist. A position without an axis has the reason in the last column.
pub fn map_csv(map: &[MapPoint]) -> String {
    let mut text = String::from(
        "x_m,y_m,z_m,mass_kg,stiffness_n_per_m,largest_ki_per_s,force_bandwidth_hz,\
         axis_force_bandwidth_hz,contact_mode_misfit,phase_crossover_misfit,stable_kp_misfit,\
         stable_ki_misfit,within_5_percent,without_axis\n",
    );
    for point in map {
        let [x, y, z] = point.place_m;
        let number = |value: f64| if value.is_nan() { "none".to_owned() } else { value.to_string() };
        let values = match &point.found {
            Err(why) => format!(",,,,,,,,,,\"{}\"", why.reason().replace('"', "'").replace('\n', " ")),
            Ok(v) => {
                let misfits = v.agreement.misfits().map(|misfit| format!("{misfit:.5}")).join(",");
                let [bandwidth, of_axis] = v.agreement.force_bandwidth_hz.map(number);
                let ki = number(v.agreement.largest_ki_per_s[0]);
                format!(
                    "{},{},{ki},{bandwidth},{of_axis},{misfits},{},",
                    v.mass_kg,
                    v.stiffness_n_per_m,
                    v.agreement.is_trusted()
                )
            }
        };
        let _ = writeln!(text, "{x},{y},{z},{values}");
    }
    text
}
