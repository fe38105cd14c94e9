//! Nyquist's curve, root loci, and the map of poles and zeros.

use std::f64::consts::TAU;

use feeler_analysis::{Curves, Locus, MarginReport, Report};
use feeler_lti::C64;

use crate::numbers::{plain, with_unit};
use crate::pages::parts::{Plane, PlaneKind, PlaneMark, PlanePath, PlaneShape, view_of};

/// Half of the least and of the largest width of Nyquist's plane; the point -1 decides, and resonances may
/// reach far.
const NYQUIST_REACH: [f64; 2] = [1.5, 4.0];

/// The loop as a curve through the complex plane.
pub(super) fn nyquist(report: &Report, curves: &Curves) -> Option<Plane> {
    let mut paths = Vec::new();
    let loops = [("sampled", &curves.open_sampled, 1), ("continuous", &curves.open, 0)];
    for (name, values, colour) in loops {
        let Some(values) = values else { continue };
        for (side, dashed) in [(1.0, false), (-1.0, true)] {
            let points = values.iter().map(|l| [l.re, side * l.im]).collect();
            let name = if dashed { format!("{name}, mirrored") } else { name.to_owned() };
            paths.push(PlanePath { name, points, at: curves.frequencies_hz.clone(), colour, dashed });
        }
    }
    if paths.is_empty() {
        return None;
    }
    let largest = paths
        .iter()
        .flat_map(|p| &p.points)
        .flatten()
        .filter(|v| v.is_finite())
        .fold(0.0_f64, |m, v| m.max(v.abs()));
    let reach = (1.1 * largest).clamp(NYQUIST_REACH[0], NYQUIST_REACH[1]);
    // The plane is twice as wide as high, and both directions have one scale.
    let view = [-1.84 * reach, 1.84 * reach, -reach, reach];
    let minus_one = PlaneMark {
        name: "the critical point −1".into(),
        point: [-1.0, 0.0],
        at: None,
        shape: PlaneShape::Pole,
    };
    Some(Plane {
        kind: PlaneKind::Nyquist,
        title: "Nyquist's curve".into(),
        caption: format!(
            "of the open loop: sampled in orange, continuous in blue, negative frequencies dashed; the cross is −1.{}",
            report.margins().map_or_else(String::new, count)
        ),
        x_label: "real part of the loop".into(),
        y_label: "imaginary part of the loop".into(),
        gain: String::new(),
        period_s: None,
        view,
        paths,
        marks: vec![minus_one],
    })
}

/// Nyquist's count in words.
fn count(margins: &MarginReport) -> String {
    let (open, closed) = (margins.open_unstable_poles, margins.unstable_poles);
    let poles = |count: usize| format!("{count} unstable {}", if count == 1 { "pole" } else { "poles" });
    let sense = if closed < open { "counterclockwise" } else { "clockwise" };
    let turns = closed.abs_diff(open);
    let (open, closed) = (poles(open), poles(closed));
    format!(
        " Nyquist's count of the sampled loop: {open} of the open loop and {turns} {sense} turns about −1 make {closed} of the closed one."
    )
}

/// Root loci: of the continuous loop, and of the sampled one.
pub(super) fn loci(report: &Report, curves: &Curves) -> Vec<Plane> {
    let key = report.gain().map_or("", |gain| gain.key.rsplit('.').next().unwrap_or(&gain.key));
    let continuous = curves.locus.iter().map(|locus| {
        let title = format!("Root locus of the continuous loop over {key}:");
        plane(locus, title, key, "real part (1/s)", "imaginary part (Hz)", PlaneKind::S)
    });
    let sampled = curves.locus_sampled.iter().map(|locus| {
        let title = format!("Root locus of the sampled loop over {key}:");
        plane(locus, title, key, "real part of z", "imaginary part of z", PlaneKind::Z)
    });
    continuous.chain(sampled).collect()
}

fn plane(locus: &Locus, title: String, key: &str, x_label: &str, y_label: &str, kind: PlaneKind) -> Plane {
    let place = |p: &C64| if kind == PlaneKind::S { [p.re, p.im / TAU] } else { [p.re, p.im] };
    let path = |branch: &Vec<C64>| PlanePath {
        name: String::new(),
        points: branch.iter().map(place).collect(),
        at: locus.gains.clone(),
        colour: 0,
        dashed: false,
    };
    let paths: Vec<PlanePath> = locus.branches.iter().map(path).collect();
    let starts = locus.branches.iter().filter_map(|branch| branch.first());
    let mark = |name: &str, p: &C64, at, shape| PlaneMark { name: name.into(), point: place(p), at, shape };
    let mut marks: Vec<PlaneMark> =
        starts.map(|p| mark("pole at gain zero", p, Some(0.0), PlaneShape::Pole)).collect();
    marks.extend(locus.zeros.iter().map(|p| mark("zero", p, None, PlaneShape::Zero)));
    marks.extend(
        locus.present.iter().map(|p| mark("gain of the file", p, Some(locus.present_gain), PlaneShape::Now)),
    );
    let view = if kind == PlaneKind::Z { [-2.3, 2.3, -1.25, 1.25] } else { s_view(&marks) };
    let farther = if kind == PlaneKind::S { beyond(&marks, view) } else { String::new() };
    let caption = format!(
        "crosses are poles at gain zero, circles zeros, green squares the gain of the file; the grey line is the border of stability. Gains go up to {}. \
         Under the pointer: gain, pole, frequency and damping.{farther}",
        plain(locus.gains.last().copied().unwrap_or_default())
    );
    Plane {
        kind,
        title,
        caption,
        x_label: x_label.into(),
        y_label: y_label.into(),
        gain: key.into(),
        period_s: locus.period_s,
        view,
        paths,
        marks,
    }
}

/// The poles and zeros that swing, and as much of the rest as lies no farther out.
fn s_view(marks: &[PlaneMark]) -> [f64; 4] {
    let swings = || marks.iter().map(|m| m.point).filter(|p| p[1].abs() > 1e-9);
    let far = swings().map(|p| p[0].abs().max(0.15 * TAU * p[1].abs())).fold(0.0, f64::max);
    let near = marks.iter().map(|m| m.point).filter(|p| far <= 0.0 || p[0].abs() <= 4.0 * far);
    let mut view = view_of(near, [0.0, 0.0]);
    // Room to the right, where instability shows.
    view[1] = view[1].max(0.35 * (view[1] - view[0])).max(-0.35 * view[0]);
    view
}

/// What lies outside the frame, of conjugate pairs once.
fn beyond(marks: &[PlaneMark], [left, right, low, high]: [f64; 4]) -> String {
    let inside = |[x, y]: [f64; 2]| x >= left && x <= right && y >= low && y <= high;
    let told: Vec<String> = (marks.iter().filter(|mark| !inside(mark.point) && mark.point[1] >= 0.0))
        .map(|mark| {
            let [re, im_hz] = mark.point;
            let swings =
                if im_hz > 0.0 { format!(" and ±{}", with_unit(im_hz, "Hz")) } else { String::new() };
            format!("{} at {}{swings}", mark.name, with_unit(re, "1/s"))
        })
        .collect();
    if told.is_empty() { String::new() } else { format!(" Beyond the frame: {}.", told.join("; ")) }
}

/// Poles and zeros of the plant.
pub(super) fn map(report: &Report) -> Plane {
    let mark = |name: &str, p: &[f64; 2], shape| PlaneMark {
        name: name.into(),
        point: [p[0], p[1] / TAU],
        at: None,
        shape,
    };
    let mut marks: Vec<PlaneMark> = report.poles.iter().map(|p| mark("pole", p, PlaneShape::Pole)).collect();
    marks.extend(report.zeros.iter().map(|p| mark("zero", p, PlaneShape::Zero)));
    let view = s_view(&marks);
    Plane {
        kind: PlaneKind::S,
        title: "Poles and zeros of the plant,".into(),
        caption: format!(
            "from {} to {}: poles are crosses, zeros circles.{}",
            report.input,
            report.output,
            beyond(&marks, view)
        ),
        x_label: "real part (1/s)".into(),
        y_label: "imaginary part (Hz)".into(),
        gain: String::new(),
        period_s: None,
        view,
        paths: Vec::new(),
        marks,
    }
}
