//! Nyquist curves and root loci of several loops in common planes.

use crate::pages::analyze::{loci, nyquist};
use crate::pages::parts::{Page, Plane, PlaneKind, PlaneShape};

use crate::pages::compare::taken::Taken;

/// The colours of the curves, in order.
const INKS: [&str; 6] =
    ["var(--first)", "var(--second)", "var(--third)", "var(--fourth)", "var(--fifth)", "var(--sixth)"];

/// All Nyquist curves in one plane, and root loci with a common plane: the continuous ones, and those with
/// the same sampling period.
pub(super) fn draw(taken: &[Taken], page: &mut Page) {
    let mut curves: Vec<(usize, Plane)> = Vec::new();
    let mut roots: Vec<Vec<(usize, Plane)>> = Vec::new();
    for (i, one) in taken.iter().enumerate() {
        let Some((report, found)) = one.theory() else { continue };
        curves.extend(nyquist(report, found).map(|plane| (i, sampled(plane))));
        let Some(plane) = loci(report, found).into_iter().next() else { continue };
        let same = |other: &Vec<(usize, Plane)>| {
            other.iter().any(|(_, other)| {
                other.kind == plane.kind && other.period_s == plane.period_s && other.gain == plane.gain
            })
        };
        match roots.iter_mut().find(|other| same(other)) {
            Some(other) => other.push((i, plane)),
            None => roots.push(vec![(i, plane)]),
        }
    }
    let caption = "of the open loops, sampled where they are, gains as set; negative frequencies dashed. The \
                   cross is −1, the thin circle modulus 1.";
    one_plane(curves, "Nyquist's curves", caption, taken, page);
    for planes in roots {
        let loops =
            if planes.iter().any(|(_, plane)| plane.kind == PlaneKind::Z) { "sampled" } else { "continuous" };
        let caption = format!(
            "of the {loops} loops: crosses are poles at gain zero, circles zeros, squares the gain of each \
             file; the grey line is the border of stability."
        );
        one_plane(planes, "Root loci", &caption, taken, page);
    }
}

/// The curve of the sampled loop; the continuous curve if there is no sampled one.
fn sampled(mut plane: Plane) -> Plane {
    let is_sampled = |name: &str| name.starts_with("sampled");
    if plane.paths.iter().any(|path| is_sampled(&path.name)) {
        plane.paths.retain(|path| is_sampled(&path.name));
    }
    plane
}

/// Curves in one plane, each in its colour, with a legend.
fn one_plane(planes: Vec<(usize, Plane)>, title: &str, caption: &str, taken: &[Taken], page: &mut Page) {
    let legend: Vec<(&str, String)> =
        planes.iter().map(|(i, _)| (INKS[i % INKS.len()], taken[*i].name.clone())).collect();
    let mut all: Option<Plane> = None;
    for (i, mut plane) in planes {
        let colour = i % INKS.len();
        for path in &mut plane.paths {
            path.name = format!("{} {}", taken[i].name, path.name).trim().into();
            path.colour = colour;
        }
        // All loops share the critical point.
        let is_common = plane.kind == PlaneKind::Nyquist;
        for mark in plane.marks.iter_mut().filter(|_| !is_common) {
            mark.name = format!("{}: {}", taken[i].name, mark.name);
            mark.colour = Some(colour);
        }
        // A disk margin belongs to one loop only.
        plane.circles.truncate(1);
        if let Some(all) = &mut all {
            all.paths.append(&mut plane.paths);
            all.marks.extend(plane.marks.into_iter().filter(|_| !is_common));
            let ([left, right, low, high], of) = (all.view, plane.view);
            all.view = [left.min(of[0]), right.max(of[1]), low.min(of[2]), high.max(of[3])];
        } else {
            all = Some(Plane { title: title.into(), caption: caption.into(), ..plane });
        }
    }
    if let Some(mut all) = all {
        // The mark of the present gain is drawn over the other marks.
        all.marks.sort_by_key(|mark| mark.shape == PlaneShape::Now);
        page.plane(&all);
        page.swatches(&legend);
    }
}
