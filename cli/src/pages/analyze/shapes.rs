//! Mode shapes drawn.

use std::fmt::Write as _;

use feeler_analysis::ModeReport;

use super::verdict::class_name;
use crate::numbers::{plain, with_unit};
use crate::pages::parts::escape;

const WIDTH: f64 = 360.0;
const HEIGHT: f64 = 170.0;
const LEFT: f64 = 44.0;
const MIDDLE: f64 = 70.0;
/// Height of a displacement of 1.
const UNIT: f64 = 52.0;
/// Smallest quadrature part that is drawn.
const LATE: f64 = 0.02;
/// Width of a character in a body's name, for the widths of the bodies.
const NAME_WIDTH: f64 = 7.0;

/// One mode: its caption, and its bodies side by side, displaced.
pub(super) fn drawing(mode: &ModeReport) -> (String, String) {
    let class = if mode.rigid_body { "rigid-body motion" } else { class_name(mode.class) };
    let caption = format!(
        "{}, damping ratio {}: {class}",
        with_unit(mode.frequency_hz, "Hz"),
        plain(mode.damping_ratio)
    );
    let step = (WIDTH - LEFT - 10.0) / mode.shape.len().max(1) as f64;
    let x = |i: usize| LEFT + step * (i as f64 + 0.5);
    let y = |displacement: f64| MIDDLE - UNIT * displacement;
    let mut svg =
        format!("<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">", escape(&caption));
    for (value, label) in [(1.0, "1"), (0.0, "0"), (-1.0, "−1")] {
        let at = y(value);
        let _ = write!(
            svg,
            "<path class=\"shape-rest\" d=\"M{LEFT} {at}H{WIDTH}\"/><text x=\"{}\" y=\"{}\" \
             text-anchor=\"end\">{label}</text>",
            LEFT - 6.0,
            at + 4.0
        );
    }
    let _ = write!(
        svg,
        "<text x=\"12\" y=\"{MIDDLE}\" text-anchor=\"middle\" transform=\"rotate(-90 12 \
         {MIDDLE})\">displacement</text>"
    );
    // Names that would touch alternate between two lines.
    let crowded = mode.shape.iter().any(|body| NAME_WIDTH * body.body.chars().count() as f64 > step);
    for (i, body) in mode.shape.iter().enumerate() {
        let (at, top) = (x(i), y(body.in_phase));
        let _ = write!(
            svg,
            "<path class=\"shape-stem\" d=\"M{at:.1} {MIDDLE}V{top:.1}\"/><circle class=\"shape-body\" \
             cx=\"{at:.1}\" cy=\"{top:.1}\" r=\"5\"/>"
        );
        if body.quadrature.abs() > LATE {
            let _ = write!(
                svg,
                "<circle class=\"shape-late\" cx=\"{at:.1}\" cy=\"{:.1}\" r=\"4\"/>",
                y(body.quadrature)
            );
        }
        let below = MIDDLE + UNIT + 22.0 + if crowded && i % 2 == 1 { 15.0 } else { 0.0 };
        let _ = write!(
            svg,
            "<text x=\"{at:.1}\" y=\"{below}\" text-anchor=\"middle\">{}</text>",
            escape(&body.body)
        );
    }
    svg.push_str("</svg>");
    (caption, svg)
}
