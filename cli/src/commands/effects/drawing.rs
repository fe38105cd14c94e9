//! The law of an effect as a small drawing.

use std::fmt::Write as _;

use feeler_plant::effects::{Curve, LawDrawing};

/// Edges of the plot within 240 x 150 pixels; the space above and below is for the texts of the axes.
const LEFT: f64 = 10.0;
const RIGHT: f64 = 230.0;
const TOP: f64 = 20.0;
const BOTTOM: f64 = 130.0;
/// Colours of medium lightness: at least 3.8 : 1 against white and against the book's dark pages.
const GREY: &str = "#808080";
const WITH: &str = "stroke=\"#1f77d0\"";
const LABEL: &str = "fill=\"#1f77d0\"";
const WITHOUT: &str = "stroke=\"#c26a00\" stroke-dasharray=\"5 4\"";

/// The drawing as SVG.
pub(super) fn svg(law: &LawDrawing) -> String {
    let lines =
        |curves: &[Curve]| curves.iter().map(|c| (c.width(), c.points(law.start))).collect::<Vec<_>>();
    let (with, without) = (lines(law.with), lines(law.without));
    let mut points = with.iter().chain(&without).flat_map(|(_, points)| points);
    let low = if points.any(|point| point.1 < 0.0) { -1.0 } else { 0.0 };
    let place = |(across, up): (f64, f64)| {
        let across = (across - law.start) / (1.0 - law.start);
        let up = (up - low) / (1.0 - low);
        (LEFT + across * (RIGHT - LEFT), BOTTOM - up * (BOTTOM - TOP))
    };
    let (x, y) = place((0.0, 0.0));
    let side = if law.start < 0.0 { "middle" } else { "start" };
    let [across, up] = law.axes;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"240\" height=\"150\" viewBox=\"0 0 240 150\" \
         font-family=\"sans-serif\" font-size=\"12\">\n\
         <title>{up} over {across}</title>\n\
         <path d=\"M{LEFT} {y}H{RIGHT}M{x} {BOTTOM}V{TOP}\" stroke=\"{GREY}\"/>\n\
         <text x=\"{x}\" y=\"13\" text-anchor=\"{side}\" fill=\"{GREY}\">{up}</text>\n\
         <text x=\"{RIGHT}\" y=\"145\" text-anchor=\"end\" fill=\"{GREY}\">{across}</text>\n"
    );
    for (style, lines) in [(WITHOUT, without), (WITH, with)] {
        for (width, line) in lines {
            let _ = write!(text, "<polyline fill=\"none\" stroke-width=\"{width}\" {style} points=\"");
            for (x, y) in line.into_iter().map(place) {
                let _ = write!(text, "{x:.1},{y:.1} ");
            }
            text.push_str("\"/>\n");
        }
    }
    for (across, up, label) in law.labels {
        let (x, y) = place((*across, *up));
        let _ = writeln!(text, "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"11\" {LABEL}>{label}</text>");
    }
    text + "</svg>\n"
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use feeler_plant::effects::LIBRARY;

    use super::svg;

    /// With `FEELER_UPDATE_DOCS=1` the drawings are written instead.
    #[test]
    fn truth_every_effect_has_its_drawing() {
        let images = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/images/effects");
        for definition in LIBRARY {
            let (name, text) = (format!("{}.svg", definition.kind), svg(&definition.law));
            let path = images.join(&name);
            if std::env::var_os("FEELER_UPDATE_DOCS").is_some() {
                std::fs::write(&path, &text).unwrap();
            }
            let committed = std::fs::read_to_string(&path).unwrap_or_default();
            assert!(committed == text, "{name} is stale; run this test with FEELER_UPDATE_DOCS=1");
        }
        let files = std::fs::read_dir(images).unwrap().count();
        assert_eq!(files, LIBRARY.len(), "docs/images/effects holds a drawing of no effect");
    }
}
