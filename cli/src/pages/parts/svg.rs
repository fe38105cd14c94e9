//! Plots as SVG. A frame converts values to positions.

use std::fmt::Write as _;

use super::html::escape;
pub(crate) use super::scale::Scale;

pub(crate) const FONT: &str = "font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\"";
pub(crate) const INK: &str = "#1d2226";
const SOFT: &str = "#5a646c";

/// A rectangle in pixels of the drawing, from its upper left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
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

    /// Draws axes, ticks and labels, over the contents of the plot.
    pub(crate) fn draw(&self, svg: &mut String, title: &str) {
        let Place { x, y, width, height } = self.place;
        let _ = write!(
            svg,
            "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"none\" stroke=\"{INK}\"/>"
        );
        let bottom = y + height;
        svg.push_str("<g class=\"ticks\">");
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
        svg.push_str("</g>");
        text_at(svg, [x + 0.5 * width, bottom + 40.0], "middle", 13, INK, &self.x.title());
        let (middle, side) = (y + 0.5 * height, x - 62.0);
        let label = escape(&self.y.title());
        let _ = write!(
            svg,
            "<text transform=\"translate({side:.1} {middle:.1}) rotate(-90)\" text-anchor=\"middle\" \
             font-size=\"13\" fill=\"{INK}\" {FONT}>{label}</text>"
        );
        text_at(svg, [x, y - 9.0], "start", 13, INK, title);
    }

    /// Draws a line with a light edge, visible on any background. Parts outside the frame are clipped.
    pub(crate) fn line(&self, svg: &mut String, clip: &str, points: &[[f64; 2]], dashed: bool) {
        let mut path = String::new();
        for (i, point) in points.iter().filter(|point| point.iter().all(|v| v.is_finite())).enumerate() {
            // Clamping coordinates far outside the frame keeps the file small.
            let [x, y] = self.at(*point).map(|v| v.clamp(-1e4, 1e4));
            let _ = write!(path, "{}{x:.1} {y:.1}", if i == 0 { "M" } else { "L" });
        }
        let dash = if dashed { " stroke-dasharray=\"7 5\"" } else { "" };
        for (colour, width) in [("#ffffff", 4.5), (INK, 2.0)] {
            let _ = write!(
                svg,
                "<path d=\"{path}\" clip-path=\"url(#{clip})\" fill=\"none\" stroke=\"{colour}\" \
                 stroke-width=\"{width}\"{dash}/>"
            );
        }
    }

    /// Draws contents that the page can zoom within the frame. `assets/zoom.js` reads the position of the
    /// frame and, for each scale, its ends, whether it is logarithmic, and the factor of its ticks.
    pub(crate) fn zoomable(&self, svg: &mut String, clip: &str, class: &str, contents: &str) {
        let Place { x, y, width, height } = self.place;
        let of = |scale: &Scale| {
            let [from, to] = scale.range;
            format!("{from:e} {to:e} {} {:e}", u8::from(scale.log), scale.factor())
        };
        let (across, up) = (of(&self.x), of(&self.y));
        let _ = write!(
            svg,
            "<g clip-path=\"url(#{clip})\"><g class=\"zoomed{class}\" \
             data-frame=\"{x} {y} {width} {height} {across} {up}\">{contents}</g></g>"
        );
    }

    /// Defines the region that clips lines.
    pub(crate) fn clip(&self, svg: &mut String, name: &str) {
        let Place { x, y, width, height } = self.place;
        let _ = write!(
            svg,
            "<clipPath id=\"{name}\"><rect x=\"{x}\" y=\"{y}\" width=\"{width}\" \
             height=\"{height}\"/></clipPath>"
        );
    }
}

/// Largest number of letters in a line of a legend.
const LEGEND_LETTERS: usize = 26;

pub(crate) fn text_at(svg: &mut String, [x, y]: [f64; 2], align: &str, size: u32, colour: &str, text: &str) {
    if !text.is_empty() {
        let text = escape(text);
        let _ = write!(
            svg,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{align}\" font-size=\"{size}\" \
             fill=\"{colour}\" {FONT}>{text}</text>"
        );
    }
}

/// The colour of a legend entry. Its edge is visible on any page.
pub(crate) fn swatch(colour: &str) -> String {
    format!("<rect width=\"24\" height=\"14\" fill=\"{colour}\" stroke=\"{SOFT}\" stroke-width=\"0.5\"/>")
}

/// Draws a legend in rows below its upper left corner. Returns its height.
pub(crate) fn legend(svg: &mut String, [x, y]: [f64; 2], entries: &[(String, String)]) -> f64 {
    let mut top = y;
    for (swatch, text) in entries {
        let _ = write!(svg, "<g transform=\"translate({x:.1} {top:.1})\">{swatch}</g>");
        for line in lines(text, LEGEND_LETTERS) {
            text_at(svg, [x + 30.0, top + 11.0], "start", 12, INK, &line);
            top += 20.0;
        }
    }
    top - y
}

/// A plot at a position with room for its axes, and its legend: swatches with their names.
pub(crate) struct Plot {
    pub(crate) place: Place,
    pub(crate) body: String,
    pub(crate) entries: Vec<(String, String)>,
}

impl Plot {
    /// Space right of the plot, without and with a legend, and below it.
    const RIGHT: f64 = 20.0;
    const LEGEND: f64 = 228.0;
    const BELOW: f64 = 56.0;

    /// The plot without its legend.
    pub(crate) fn alone(&self) -> String {
        let Place { x, y, width, height } = self.place;
        image(x + width + Self::RIGHT, y + height + Self::BELOW, &self.body)
    }

    /// The plot with the legend beside it.
    pub(crate) fn with_legend(&self) -> String {
        let Place { x, y, width, height } = self.place;
        let mut body = self.body.clone();
        legend(&mut body, [x + width + 24.0, y + 4.0], &self.entries);
        image(x + width + Self::LEGEND, y + height + Self::BELOW, &body)
    }
}

/// A text in lines of at most `width` characters, unless a word is longer.
pub(crate) fn lines(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// An image of this size around a drawing.
pub(crate) fn image(width: f64, height: f64, body: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
         width=\"{width:.0}\" height=\"{height:.0}\">\
         <rect width=\"{width:.0}\" height=\"{height:.0}\" fill=\"#ffffff\"/>{body}</svg>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::lines;

    #[test]
    fn truth_names_break_between_words() {
        assert_eq!(lines("with the effects found", 10), ["with the", "effects", "found"]);
        assert_eq!(lines("calibration", 4), ["calibration"]);
    }
}
