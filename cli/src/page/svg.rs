//! Drawing: plots as SVG, in which every number has a place.

use std::fmt::Write as _;

use super::escape;
use crate::numbers::{plain, prefix};

pub(crate) const FONT: &str = "font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\"";
const INK: &str = "#1d2226";
const SOFT: &str = "#5a646c";
/// Pixels between ticks of a linear axis, about.
const TICK_EVERY: f64 = 70.0;

/// A rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

/// An axis of a plot.
#[derive(Clone, Debug)]
pub(crate) struct Scale {
    pub(crate) label: String,
    /// Values at the two ends.
    pub(crate) range: [f64; 2],
    pub(crate) log: bool,
}

impl Scale {
    /// Where a value lies between the ends, 0 to 1.
    pub(crate) fn share(&self, value: f64) -> f64 {
        let [from, to] = self.range;
        if self.log { (value / from).ln() / (to / from).ln() } else { (value - from) / (to - from) }
    }

    /// Marked values: with their text where they get one.
    fn ticks(&self, pixels: f64) -> Vec<(f64, String)> {
        let [low, high] = if self.range[0] < self.range[1] { self.range } else { [self.range[1], self.range[0]] };
        // Less than a decade is too short for the ticks of decades.
        if self.log && low > 0.0 && high > 10.0 * low {
            let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
            let few = (high / low).log10() < 2.5;
            let of_decade = |decade: i32| {
                (1..10).map(move |m| {
                    let value = f64::from(m) * 10_f64.powi(decade);
                    let named = m == 1 || (few && (m == 2 || m == 5));
                    (value, if named { tick(value) } else { String::new() })
                })
            };
            return decades.flat_map(of_decade).filter(|(value, _)| (low * 0.999..=high * 1.001).contains(value)).collect();
        }
        let rough = (high - low) / (pixels / TICK_EVERY).max(1.0);
        let decade = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * decade).find(|step| *step >= rough).unwrap_or(rough);
        let first = (low / step).ceil() as i64;
        let last = (high / step).floor() as i64;
        (first..=last).map(|i| i as f64 * step).map(|value| (value, tick(value))).collect()
    }
}

/// A number beside a tick, with a prefix where it is large or small.
fn tick(value: f64) -> String {
    if value == 0.0 || (1e-3..1e4).contains(&value.abs()) {
        return plain(value);
    }
    let (scale, prefix) = prefix(value);
    format!("{} {prefix}", plain(value / scale))
}

/// The frame of a plot with its axes.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    pub(crate) place: Place,
    pub(crate) x: Scale,
    pub(crate) y: Scale,
}

impl Frame {
    pub(crate) fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let Place { x: left, y: top, width, height } = self.place;
        [left + self.x.share(x) * width, top + (1.0 - self.y.share(y)) * height]
    }

    /// Axes, ticks and labels; drawn over what the plot holds.
    pub(crate) fn draw(&self, svg: &mut String, title: &str) {
        let Place { x, y, width, height } = self.place;
        let _ = write!(svg, "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"none\" stroke=\"{INK}\"/>");
        let bottom = y + height;
        for (value, text) in self.x.ticks(width) {
            let at = x + self.x.share(value) * width;
            let length = if text.is_empty() { 3 } else { 6 };
            let _ = write!(svg, "<path d=\"M{at:.1} {bottom}v{length}\" stroke=\"{INK}\"/>");
            text_at(svg, [at, bottom + 19.0], "middle", 12, SOFT, &text);
        }
        for (value, text) in self.y.ticks(height) {
            let at = y + (1.0 - self.y.share(value)) * height;
            let length = if text.is_empty() { 3 } else { 6 };
            let _ = write!(svg, "<path d=\"M{x} {at:.1}h-{length}\" stroke=\"{INK}\"/>");
            text_at(svg, [x - 9.0, at + 4.0], "end", 12, SOFT, &text);
        }
        text_at(svg, [x + 0.5 * width, bottom + 40.0], "middle", 13, INK, &self.x.label);
        let (middle, side) = (y + 0.5 * height, x - 62.0);
        let label = escape(&self.y.label);
        let _ = write!(
            svg,
            "<text transform=\"translate({side:.1} {middle:.1}) rotate(-90)\" text-anchor=\"middle\" font-size=\"13\" fill=\"{INK}\" {FONT}>{label}</text>"
        );
        text_at(svg, [x, y - 9.0], "start", 13, INK, title);
    }

    /// A line with a light edge, so that it stands out on any ground. Parts outside of the frame are cut off.
    pub(crate) fn line(&self, svg: &mut String, clip: &str, points: &[[f64; 2]], dashed: bool) {
        let mut path = String::new();
        for (i, point) in points.iter().filter(|point| point.iter().all(|v| v.is_finite())).enumerate() {
            // Far outside is as good as very far outside, and keeps the file in bounds.
            let [x, y] = self.at(*point).map(|v| v.clamp(-1e4, 1e4));
            let _ = write!(path, "{}{x:.1} {y:.1}", if i == 0 { "M" } else { "L" });
        }
        let dash = if dashed { " stroke-dasharray=\"7 5\"" } else { "" };
        for (colour, width) in [("#ffffff", 4.5), ("#000000", 2.0)] {
            let _ = write!(
                svg,
                "<path d=\"{path}\" clip-path=\"url(#{clip})\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"{dash}/>"
            );
        }
    }

    /// A region to cut lines off at.
    pub(crate) fn clip(&self, svg: &mut String, name: &str) {
        let Place { x, y, width, height } = self.place;
        let _ = write!(svg, "<clipPath id=\"{name}\"><rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"/></clipPath>");
    }
}

pub(crate) fn text_at(svg: &mut String, [x, y]: [f64; 2], anchor: &str, size: u32, colour: &str, text: &str) {
    if !text.is_empty() {
        let text = escape(text);
        let _ = write!(
            svg,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" font-size=\"{size}\" fill=\"{colour}\" {FONT}>{text}</text>"
        );
    }
}

/// A legend in rows from a corner on; gives its height.
pub(crate) fn legend(svg: &mut String, [x, y]: [f64; 2], entries: &[(String, String)]) -> f64 {
    for (i, (swatch, text)) in entries.iter().enumerate() {
        let top = y + 20.0 * i as f64;
        let _ = write!(svg, "<g transform=\"translate({x:.1} {top:.1})\">{swatch}</g>");
        text_at(svg, [x + 30.0, top + 11.0], "start", 12, INK, text);
    }
    20.0 * entries.len() as f64
}

/// An image of this size around a drawing.
pub(crate) fn image(width: f64, height: f64, body: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" height=\"{height:.0}\">\
         <rect width=\"{width:.0}\" height=\"{height:.0}\" fill=\"#ffffff\"/>{body}</svg>\n"
    )
}
