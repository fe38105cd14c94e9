//! A small plotter: curves on linear or logarithmic axes, as one self-contained SVG.

use std::fmt::Write as _;

/// Division of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisScale {
    Linear,
    Logarithmic,
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureAxis {
    /// Its quantity, with its unit.
    pub label: String,
    pub scale: AxisScale,
    pub range: (f64, f64),
}

/// Style of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    Line,
    Dashed,
    /// Crosses, as for poles.
    Cross,
    Circle,
    /// Small dots, as for measurements.
    Dot,
}

/// Points and their style; parts outside the axes are clipped.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureCurve {
    /// Name in the legend; empty for none.
    pub name: String,
    pub points: Vec<(f64, f64)>,
    pub mark: Mark,
    pub colour: &'static str,
}

/// Axes and the curves on them.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    pub x: FigureAxis,
    pub y: FigureAxis,
    pub curves: Vec<FigureCurve>,
}

/// A figure: panels one below the other, and a caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// File name without extension, as `fig07`.
    pub name: String,
    pub caption: String,
    pub panels: Vec<Panel>,
}

const WIDTH: f64 = 640.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = 20.0;
const PANEL: f64 = 250.0;
const GAP: f64 = 62.0;
const TOP: f64 = 34.0;
/// Width that one entry of the legend takes.
const LEGEND: f64 = 220.0;
/// Characters of caption on a line.
const CAPTION_CHARACTERS: usize = 92;

impl FigureAxis {
    /// An evenly divided axis.
    pub fn linear(label: &str, range: (f64, f64)) -> Self {
        Self { label: label.into(), scale: AxisScale::Linear, range }
    }

    /// An axis divided by decades.
    pub fn logarithmic(label: &str, range: (f64, f64)) -> Self {
        Self { label: label.into(), scale: AxisScale::Logarithmic, range }
    }

    /// Position of a value between the ends, 0 to 1.
    fn place(&self, value: f64) -> f64 {
        let (low, high) = self.range;
        match self.scale {
            AxisScale::Linear => (value - low) / (high - low),
            AxisScale::Logarithmic => (value / low).ln() / (high / low).ln(),
        }
    }

    /// Values with a grid line, and whether each has a number.
    fn ticks(&self) -> Vec<(f64, bool)> {
        let (low, high) = self.range;
        match self.scale {
            AxisScale::Linear => {
                let rough = (high - low) / 6.0;
                let power = 10_f64.powf(rough.log10().floor());
                let step = [1.0, 2.0, 5.0, 10.0]
                    .into_iter()
                    .map(|m| m * power)
                    .find(|s| *s >= rough)
                    .unwrap_or(10.0 * power);
                // Phases are read in quarters of a turn.
                let step = if self.label.contains('\u{b0}') {
                    if high - low > 400.0 { 90.0 } else { 45.0 }
                } else {
                    step
                };
                let (first, last) = ((low / step).ceil() as i64, (high / step + 1e-9).floor() as i64);
                (first..=last).map(|i| (i as f64 * step, true)).collect()
            }
            AxisScale::Logarithmic => {
                let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
                // With few decades there are numbers at 2 and 5 as well.
                let few = high / low < 200.0;
                let numbered = move |m: i32| m == 1 || (few && (m == 2 || m == 5));
                let all =
                    decades.flat_map(|d| (1..10).map(move |m| (f64::from(m) * 10_f64.powi(d), numbered(m))));
                all.filter(|(v, _)| *v >= low * (1.0 - 1e-9) && *v <= high * (1.0 + 1e-9)).collect()
            }
        }
    }
}

fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".into()
    } else if !(1e-3..1e5).contains(&size) {
        format!("{value:.0e}")
    } else {
        let text = format!("{value:.4}");
        text.trim_end_matches('0').trim_end_matches('.').replace('-', "\u{2212}")
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

impl Figure {
    /// The figure as SVG text.
    pub fn svg(&self) -> String {
        let lines = wrapped(&self.caption, CAPTION_CHARACTERS);
        let height = TOP + self.panels.len() as f64 * (PANEL + GAP) + lines.len() as f64 * 17.0 + 10.0;
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" width=\"{WIDTH}\" \
             height=\"{height}\" \
             font-family=\"Helvetica, Arial, sans-serif\" font-size=\"13\">\n<title>{}</title>\n<rect \
             width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
            escaped(&self.caption)
        );
        // One legend above all panels, which have the same curves, so that it hides none of them.
        let named =
            self.panels.iter().take(1).flat_map(|panel| &panel.curves).filter(|curve| !curve.name.is_empty());
        for (i, curve) in named.enumerate() {
            let at = LEFT + LEGEND * i as f64;
            let _ = match curve.mark {
                Mark::Dot => writeln!(
                    out,
                    "<circle cx=\"{}\" cy=\"17\" r=\"2.2\" fill=\"{}\"/>",
                    at + 8.0,
                    curve.colour
                ),
                _ => writeln!(
                    out,
                    "<rect x=\"{at}\" y=\"15\" width=\"16\" height=\"4\" fill=\"{}\"/>",
                    curve.colour
                ),
            };
            let _ = writeln!(out, "<text x=\"{}\" y=\"21\">{}</text>", at + 22.0, escaped(&curve.name));
        }
        for (i, panel) in self.panels.iter().enumerate() {
            panel.draw(&mut out, TOP + i as f64 * (PANEL + GAP), &format!("{}-{i}", self.name));
        }
        let first = TOP + self.panels.len() as f64 * (PANEL + GAP) + 12.0;
        for (i, line) in lines.iter().enumerate() {
            let _ =
                writeln!(out, "<text x=\"12\" y=\"{}\">{}</text>", first + 17.0 * i as f64, escaped(line));
        }
        out.push_str("</svg>\n");
        out
    }
}

fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        if lines.last().is_some_and(|line| !line.is_empty() && line.len() + word.len() >= width) {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines
}

impl Panel {
    fn draw(&self, out: &mut String, top: f64, id: &str) {
        let width = WIDTH - LEFT - RIGHT;
        let x = |v: f64| LEFT + width * self.x.place(v);
        let y = |v: f64| top + PANEL * (1.0 - self.y.place(v));
        let _ = writeln!(
            out,
            "<clipPath id=\"{id}\"><rect x=\"{LEFT}\" y=\"{top}\" width=\"{width}\" \
             height=\"{PANEL}\"/></clipPath>"
        );
        for (v, numbered) in self.x.ticks() {
            let grey = if numbered { "#bbb" } else { "#eee" };
            let at = x(v);
            let _ = writeln!(out, "<path d=\"M{at:.1} {top}v{PANEL}\" stroke=\"{grey}\"/>");
            if numbered {
                let below = top + PANEL + 17.0;
                let _ = writeln!(
                    out,
                    "<text x=\"{at:.1}\" y=\"{below}\" text-anchor=\"middle\">{}</text>",
                    number(v)
                );
            }
        }
        for (v, numbered) in self.y.ticks() {
            let grey = if numbered { "#bbb" } else { "#eee" };
            let at = y(v);
            let _ = writeln!(out, "<path d=\"M{LEFT} {at:.1}h{width}\" stroke=\"{grey}\"/>");
            if numbered {
                let _ = writeln!(
                    out,
                    "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                    LEFT - 7.0,
                    at + 4.5,
                    number(v)
                );
            }
        }
        let _ = writeln!(
            out,
            "<rect x=\"{LEFT}\" y=\"{top}\" width=\"{width}\" height=\"{PANEL}\" fill=\"none\" \
             stroke=\"#333\"/>"
        );
        let (middle_x, middle_y) = (LEFT + 0.5 * width, top + 0.5 * PANEL);
        let label = top + PANEL + 37.0;
        let _ = writeln!(
            out,
            "<text x=\"{middle_x}\" y=\"{label}\" text-anchor=\"middle\">{}</text>",
            escaped(&self.x.label)
        );
        let turned = format!("transform=\"rotate(-90 20 {middle_y})\" text-anchor=\"middle\"");
        let _ = writeln!(out, "<text x=\"20\" y=\"{middle_y}\" {turned}>{}</text>", escaped(&self.y.label));
        let _ = writeln!(out, "<g clip-path=\"url(#{id})\">");
        for curve in &self.curves {
            curve.draw(out, &x, &y);
        }
        out.push_str("</g>\n");
    }
}

impl FigureCurve {
    fn draw(&self, out: &mut String, x: &impl Fn(f64) -> f64, y: &impl Fn(f64) -> f64) {
        // Coordinates far outside the axes only increase a file's size.
        let place = |(a, b): &(f64, f64)| (x(*a).clamp(-1e4, 1e4), y(*b).clamp(-1e4, 1e4));
        let points = self.points.iter().filter(|(a, b)| a.is_finite() && b.is_finite()).map(place);
        let colour = self.colour;
        match self.mark {
            Mark::Line | Mark::Dashed => {
                let path: Vec<String> = points.map(|(a, b)| format!("{a:.1},{b:.1}")).collect();
                let dash = if self.mark == Mark::Dashed { " stroke-dasharray=\"6 4\"" } else { "" };
                let _ = writeln!(
                    out,
                    "<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.7\"{dash} \
                                   points=\"{}\"/>",
                    path.join(" ")
                );
            }
            Mark::Cross => points.for_each(|(a, b)| {
                let _ = writeln!(
                    out,
                    "<path d=\"M{:.1} {:.1}l10 10m0 -10l-10 10\" stroke=\"{colour}\" \
                                   stroke-width=\"2\"/>",
                    a - 5.0,
                    b - 5.0
                );
            }),
            Mark::Circle => points.for_each(|(a, b)| {
                let _ = writeln!(
                    out,
                    "<circle cx=\"{a:.1}\" cy=\"{b:.1}\" r=\"5\" fill=\"none\" \
                                       stroke=\"{colour}\" stroke-width=\"2\"/>"
                );
            }),
            Mark::Dot => points.for_each(|(a, b)| {
                let _ = writeln!(out, "<circle cx=\"{a:.1}\" cy=\"{b:.1}\" r=\"2.2\" fill=\"{colour}\"/>");
            }),
        }
    }
}
