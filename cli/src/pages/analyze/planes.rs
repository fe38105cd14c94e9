//! Nyquist's curve, root loci, and the map of poles and zeros.

use std::f64::consts::TAU;

use feeler_analysis::{Curves, Locus, MarginReport, Report};
use feeler_lti::C64;

use crate::numbers::{plain, with_unit};
use crate::pages::parts::{Circle, CircleKind, Plane, PlaneKind, PlaneMark, PlanePath, PlaneShape, view_of};

/// Half the height of the Nyquist plot: it contains the point -1 and the whole unit circle. Resonances may
/// extend far beyond.
const NYQUIST_REACH: f64 = 1.6;
/// Width of a plane over its height.
const ASPECT: f64 = 1.84;
/// Poles nearer to the origin of the z plane than this decay almost immediately.
const FAST: f64 = 0.3;

/// The loop as a curve through the complex plane.
pub(crate) fn nyquist(report: &Report, curves: &Curves) -> Option<Plane> {
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
    // Both axes have the same scale.
    let view = [-ASPECT * NYQUIST_REACH, ASPECT * NYQUIST_REACH, -NYQUIST_REACH, NYQUIST_REACH];
    let mut circles =
        vec![Circle { centre: 0.0, radius: 1.0, kind: CircleKind::Unit, name: "modulus 1".into() }];
    let margins = report.margins().filter(|margins| margins.unstable_poles == 0);
    let disk = margins.and_then(|margins| disk(margins.disk));
    let avoided = if disk.is_some() { " The curve stays out of the shaded disk." } else { "" };
    circles.extend(disk);
    let minus_one = PlaneMark {
        name: "the critical point −1".into(),
        point: [-1.0, 0.0],
        at: None,
        shape: PlaneShape::Pole,
        colour: None,
    };
    Some(Plane {
        kind: PlaneKind::Nyquist,
        title: "Nyquist's curve".into(),
        caption: format!(
            "of the open loop: sampled in orange, continuous in blue, negative frequencies dashed. The \
             cross is −1 and the thin circle modulus 1.{avoided}{}",
            report.margins().map_or_else(String::new, count)
        ),
        x_label: "real part of the loop".into(),
        y_label: "imaginary part of the loop".into(),
        gain: String::new(),
        period_s: None,
        view,
        paths,
        marks: vec![minus_one],
        circles,
    })
}

/// The disk about -1 that a loop with this balanced disk margin avoids; `None` if the region is not a disk.
fn disk(alpha: f64) -> Option<Circle> {
    let half = 0.5 * alpha;
    if half <= 0.0 || half >= 1.0 {
        return None;
    }
    let (near, far) = ((1.0 - half) / (1.0 + half), (1.0 + half) / (1.0 - half));
    let name = format!("disk margin {}", plain(alpha));
    Some(Circle { centre: -0.5 * (near + far), radius: 0.5 * (far - near), kind: CircleKind::Disk, name })
}

/// Nyquist's count in words.
fn count(margins: &MarginReport) -> String {
    let (open, closed) = (margins.open_unstable_poles, margins.unstable_poles);
    let poles = |count: usize| format!("{count} unstable {}", if count == 1 { "pole" } else { "poles" });
    let sense = if closed < open { "counterclockwise" } else { "clockwise" };
    let turns = closed.abs_diff(open);
    let (open, closed) = (poles(open), poles(closed));
    format!(
        " Nyquist's count of the sampled loop: {open} of the open loop and {turns} {sense} turns about −1 \
         make {closed} of the closed one."
    )
}

/// Root loci: of the continuous loop, and of the sampled one.
pub(crate) fn loci(report: &Report, curves: &Curves) -> Vec<Plane> {
    let key = report.gain().map_or("", |gain| gain.key.rsplit('.').next().unwrap_or(&gain.key));
    let continuous = curves.locus.iter().map(|locus| {
        let title = format!("Root locus of the continuous loop over {key}:");
        plane(locus, title, key, "real part (1/s)", "imaginary part (Hz)", PlaneKind::S)
    });
    let sampled = curves.locus_sampled.iter().map(|locus| {
        let title = format!("Root locus of the sampled loop over {key}:");
        plane(locus, title, key, "real part of z", "imaginary part of z", PlaneKind::Z)
    });
    sampled.chain(continuous).collect()
}

/// Height of a view of the deciding roots, over the angle of the limit's frequency, and the largest height of
/// such a view.
const AROUND_LIMIT: f64 = 1.6;
const LARGEST_PART: f64 = 0.5;

/// The locus near z = 1, if the roots that decide the limit fill only a small part of the plane.
pub(super) fn near_the_limit(report: &Report, locus: Plane) -> Option<Plane> {
    let limit_hz = report.gain()?.sampled.edge_hz.filter(|hz| *hz > 0.0)?;
    let half = AROUND_LIMIT * TAU * limit_hz * locus.period_s?;
    if half > LARGEST_PART.min(0.5 * locus.view[3]) {
        return None;
    }
    let right = 1.0 + 0.5 * half;
    Some(Plane {
        title: "The same near z = 1,".into(),
        caption: format!("where the loop reaches its limit and oscillates at {}.", with_unit(limit_hz, "Hz")),
        view: [right - 2.0 * ASPECT * half, right, -half, half],
        ..locus
    })
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
    let mark = |name: &str, p: &C64, at, shape| PlaneMark {
        name: name.into(),
        point: place(p),
        at,
        shape,
        colour: None,
    };
    let mut marks: Vec<PlaneMark> =
        starts.map(|p| mark("pole at gain zero", p, Some(0.0), PlaneShape::Pole)).collect();
    marks.extend(locus.zeros.iter().map(|p| mark("zero", p, None, PlaneShape::Zero)));
    marks.extend(
        locus.present.iter().map(|p| mark("gain of the file", p, Some(locus.present_gain), PlaneShape::Now)),
    );
    let view = if kind == PlaneKind::Z { z_view(&marks) } else { s_view(&marks) };
    let farther = if kind == PlaneKind::S { beyond(&marks, view) } else { String::new() };
    let caption = format!(
        "crosses are poles at gain zero, circles zeros, green squares the gain of the file; the grey line \
         is the border of stability. Gains go up to {}. \
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
        circles: if kind == PlaneKind::Z { vec![Circle::border()] } else { Vec::new() },
    }
}

/// The roots that do not decay immediately, with the border of stability: near z = 1 for fast sampling,
/// otherwise the whole circle.
fn z_view(marks: &[PlaneMark]) -> [f64; 4] {
    let whole = [-1.25 * ASPECT, 1.25 * ASPECT, -1.25, 1.25];
    let lasting = || marks.iter().map(|m| m.point).filter(|[x, y]| (FAST..1.5).contains(&x.hypot(*y)));
    let [left, right, _, high] = view_of(lasting(), [1.0, 0.0]);
    let half = high.max(0.5 * (right - left) / ASPECT);
    if half > 0.6 || left < 0.0 {
        return whole;
    }
    let centre = 0.5 * (left + right);
    [centre - ASPECT * half, centre + ASPECT * half, -half, half]
}

/// The oscillating poles and zeros, and the real ones up to the same distance.
fn s_view(marks: &[PlaneMark]) -> [f64; 4] {
    let swings = || marks.iter().map(|m| m.point).filter(|p| p[1].abs() > 1e-9);
    let far = swings().map(|p| p[0].abs().max(0.15 * TAU * p[1].abs())).fold(0.0, f64::max);
    let near = marks.iter().map(|m| m.point).filter(|p| far <= 0.0 || p[0].abs() <= 4.0 * far);
    let mut view = view_of(near, [0.0, 0.0]);
    // Space on the right, in the unstable half plane.
    view[1] = view[1].max(0.35 * (view[1] - view[0])).max(-0.35 * view[0]);
    view
}

/// The points outside the frame, conjugate pairs once.
fn beyond(marks: &[PlaneMark], [left, right, low, high]: [f64; 4]) -> String {
    let inside = |[x, y]: [f64; 2]| x >= left && x <= right && y >= low && y <= high;
    let beyond_frame: Vec<String> = (marks.iter().filter(|mark| !inside(mark.point) && mark.point[1] >= 0.0))
        .map(|mark| {
            let [re, im_hz] = mark.point;
            let swings =
                if im_hz > 0.0 { format!(" and ±{}", with_unit(im_hz, "Hz")) } else { String::new() };
            format!("{} at {}{swings}", mark.name, with_unit(re, "1/s"))
        })
        .collect();
    if beyond_frame.is_empty() {
        String::new()
    } else {
        format!(" Beyond the frame: {}.", beyond_frame.join("; "))
    }
}

/// Poles and zeros of the plant.
pub(super) fn map(report: &Report) -> Plane {
    let mark = |name: &str, p: &[f64; 2], shape| PlaneMark {
        name: name.into(),
        point: [p[0], p[1] / TAU],
        at: None,
        shape,
        colour: None,
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
        circles: Vec::new(),
    }
}
