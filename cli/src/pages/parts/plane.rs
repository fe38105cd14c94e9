//! Planes as data; `assets/plane.js` draws them.

use serde_json::{Value, json};

use super::chart::column;

/// Coordinates of a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PlaneKind {
    /// Real part in 1/s, imaginary part in Hz.
    S,
    /// z of a sampled loop; the unit circle is the stability boundary.
    Z,
    /// The response of a loop, labelled with frequencies.
    Nyquist,
}

/// A curve through a plane, with a gain or a frequency for each point.
pub(crate) struct PlanePath {
    pub(crate) name: String,
    pub(crate) points: Vec<[f64; 2]>,
    pub(crate) at: Vec<f64>,
    pub(crate) colour: usize,
    pub(crate) dashed: bool,
}

/// The symbol of a single point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PlaneShape {
    /// A cross.
    Pole,
    /// A circle.
    Zero,
    /// A filled square: the present value of the file.
    Now,
}

/// A single point with a symbol.
pub(crate) struct PlaneMark {
    pub(crate) name: String,
    pub(crate) point: [f64; 2],
    pub(crate) at: Option<f64>,
    pub(crate) shape: PlaneShape,
    /// Index in the palette; `None` for the colour of the symbol.
    pub(crate) colour: Option<usize>,
}

/// The meaning of a circle in a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CircleKind {
    /// The stability boundary.
    Border,
    /// The unit circle of a Nyquist plot, as a scale.
    Unit,
    /// The region that the curve must avoid.
    Disk,
}

/// A circle about a point of the real axis.
pub(crate) struct Circle {
    pub(crate) centre: f64,
    pub(crate) radius: f64,
    pub(crate) kind: CircleKind,
    pub(crate) name: String,
}

impl Circle {
    /// The stability boundary of sampled loops.
    pub(crate) fn border() -> Self {
        Self { centre: 0.0, radius: 1.0, kind: CircleKind::Border, name: "border of stability".into() }
    }
}

/// A plane with its curves and points.
pub(crate) struct Plane {
    pub(crate) kind: PlaneKind,
    pub(crate) title: String,
    pub(crate) caption: String,
    pub(crate) x_label: String,
    pub(crate) y_label: String,
    /// Meaning of the values at the points, if they are gains.
    pub(crate) gain: String,
    /// Sampling period of a z plane, s.
    pub(crate) period_s: Option<f64>,
    /// Left, right, lower and upper limits.
    pub(crate) view: [f64; 4],
    pub(crate) paths: Vec<PlanePath>,
    pub(crate) marks: Vec<PlaneMark>,
    pub(crate) circles: Vec<Circle>,
}

impl Plane {
    pub(crate) fn to_json(&self) -> Value {
        let path = |path: &PlanePath| {
            let along = |axis: usize| column(&path.points.iter().map(|p| p[axis]).collect::<Vec<_>>());
            json!({
                "name": path.name,
                "x": along(0),
                "y": along(1),
                "at": column(&path.at),
                "colour": path.colour,
                "dashed": path.dashed,
            })
        };
        let mark = |mark: &PlaneMark| {
            let shape = match mark.shape {
                PlaneShape::Pole => "pole",
                PlaneShape::Zero => "zero",
                PlaneShape::Now => "now",
            };
            let [x, y] = mark.point;
            json!({
                "name": mark.name, "x": x, "y": y, "at": mark.at, "shape": shape, "colour": mark.colour,
            })
        };
        let circle = |circle: &Circle| {
            let kind = match circle.kind {
                CircleKind::Border => "border",
                CircleKind::Unit => "unit",
                CircleKind::Disk => "disk",
            };
            json!({ "centre": circle.centre, "radius": circle.radius, "kind": kind, "name": circle.name })
        };
        json!({
            "kind": if self.kind == PlaneKind::Nyquist { "nyquist" } else { "roots" },
            "circles": self.circles.iter().map(circle).collect::<Vec<_>>(),
            "x": self.x_label,
            "y": self.y_label,
            "gain": self.gain,
            "period_s": self.period_s,
            "view": self.view,
            "hint": "Point at a curve to read it (or use the arrow keys); draw a box to zoom, double-click \
                     to go back.",
            "paths": self.paths.iter().map(path).collect::<Vec<_>>(),
            "marks": self.marks.iter().map(mark).collect::<Vec<_>>(),
        })
    }
}

/// A view that contains the points and `about`, with a margin.
pub(crate) fn view_of(points: impl IntoIterator<Item = [f64; 2]>, about: [f64; 2]) -> [f64; 4] {
    let mut view = [about[0], about[0], about[1], about[1]];
    for [x, y] in points.into_iter().filter(|p| p[0].is_finite() && p[1].is_finite()) {
        view = [view[0].min(x), view[1].max(x), view[2].min(y), view[3].max(y)];
    }
    let room = |low: f64, high: f64| if high > low { 0.12 * (high - low) } else { 1.0 };
    let (wide, tall) = (room(view[0], view[1]), room(view[2], view[3]));
    [view[0] - wide, view[1] + wide, view[2] - tall, view[3] + tall]
}
