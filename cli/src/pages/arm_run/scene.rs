//! The arm as an animated drawing of lines.

use feeler_files::CellFile;
use feeler_manipulator::link_capsules;
use feeler_studies::run::CellRun;
use serde_json::{Value, json};

/// Largest number of instants in the scene.
const MOST_FRAMES: usize = 1200;

/// Input of `assets/scene.js`: the radii of the links, the lines of workpiece (in the base's frame) and tip
/// (in the tool's frame), and data for each instant. These are the time, the points of the skeleton from base
/// to tool, and the tool's orientation as a quaternion. The contact force follows, with its point and normal.
pub(super) fn scene(file: &CellFile, result: &CellRun) -> crate::Result<Value> {
    let cell = &file.cell;
    let chain = cell.arm.chain();
    let trace = &result.motion;
    let stride = trace.t_s.len().div_ceil(MOST_FRAMES).max(1);
    let column = |name: String| trace.column(&name).unwrap_or_default();
    let joints: Vec<&[f64]> =
        chain.joints.iter().map(|joint| column(format!("joints.{}.position", joint.name))).collect();
    let force = column(result.contact.force_signal());
    let contact = ["point.x", "point.y", "point.z", "normal.x", "normal.y", "normal.z"]
        .map(|name| column(name.to_owned()));
    let mut frames = Vec::new();
    for row in (0..trace.t_s.len()).step_by(stride) {
        let q: Vec<f64> = joints.iter().map(|column| column[row]).collect();
        let skeleton = chain.skeleton(&q);
        let points: Vec<Value> = skeleton
            .iter()
            .flat_map(|frame| frame.translation.vector.iter().copied().collect::<Vec<_>>())
            .map(|x| digits(x, 6))
            .collect();
        let turn = skeleton.last().map(|tool| tool.rotation.coords).unwrap_or_default();
        let turn: Vec<Value> = turn.iter().map(|x| digits(*x, 6)).collect();
        let at: Vec<Value> = contact.iter().map(|column| digits(column[row], 6)).collect();
        frames.push(json!([digits(trace.t_s[row], 6), points, turn, digits(force[row], 3), at]));
    }
    let lines = |lines: Vec<[[f64; 3]; 2]>| {
        lines
            .into_iter()
            .map(|line| line.concat().into_iter().map(|x| digits(x, 5)).collect::<Vec<_>>())
            .collect::<Vec<_>>()
    };
    let workpiece = cell.workpiece.shape.outline(&cell.workpiece.place)?;
    let tip: Vec<[[f64; 3]; 2]> = cell.tip.shape.outline(&cell.tip.place)?;
    let ball = if let feeler_geometry::Shape::Ball { radius_m } = cell.tip.shape {
        json!([cell.tip.place.position_m, radius_m])
    } else {
        Value::Null
    };
    // Radii of the base and of each link; shapes in the URDF are not drawn.
    let mut radii: Vec<f64> = link_capsules(chain).iter().map(|body| body.radius_m).collect();
    // A thicker tool would hide its tip.
    if let (Some(last), feeler_geometry::Shape::Ball { radius_m }) = (radii.last_mut(), &cell.tip.shape) {
        *last = last.min(*radius_m);
    }
    let names: Vec<&str> = chain.joints.iter().map(|joint| joint.name.as_str()).collect();
    Ok(json!({
        "frames": frames,
        "radii": radii,
        "names": names,
        "workpiece": lines(workpiece),
        "tip": lines(tip),
        "ball": ball,
        "largest": result.summary.figures.peak_force_n,
    }))
}

/// A number with this many decimals; `null` if it is not finite.
fn digits(value: f64, decimals: i32) -> Value {
    let scale = 10_f64.powi(decimals);
    Value::from((value * scale).round() / scale)
}
