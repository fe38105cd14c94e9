//! Self-contained pages: text, tables and interactive charts in one file that needs no network.
//!
//! A [`Page`] is put together from sections in reading order and rendered once. Charts are drawn by the
//! vendored uPlot (MIT licence, see `assets/uplot.LICENSE`) from data that the page carries with it.

mod chart;
mod cividis;
mod decimate;
mod html;
mod plane;
mod scale;
pub(crate) mod svg;

use std::fmt::Write as _;

use serde_json::{Value, json};

pub(crate) use chart::{Chart, ChartKind, Line, Mark, Series};
pub(crate) use cividis::of_share;
pub(crate) use decimate::{by_extremes, by_steps};
pub(crate) use html::escape;
pub(crate) use plane::{Plane, PlaneKind, PlaneMark, PlanePath, PlaneShape, view_of};

const UPLOT: &str = include_str!("../../../assets/uplot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("../../../assets/uplot.min.css");
const UPLOT_LICENCE: &str = include_str!("../../../assets/uplot.LICENSE");
const SCRIPT: &str = include_str!("../../../assets/page.js");
const PLANE_SCRIPT: &str = include_str!("../../../assets/plane.js");
const MAP_SCRIPT: &str = include_str!("../../../assets/map.js");
const SCENE_SCRIPT: &str = include_str!("../../../assets/scene.js");
const STYLE: &str = include_str!("../../../assets/page.css");

/// A figure that stands on its own: its name, the number with its unit, and a remark.
pub(crate) struct Tile {
    pub(crate) name: &'static str,
    pub(crate) value: String,
    pub(crate) remark: String,
}

/// A page under way.
pub(crate) struct Page {
    title: String,
    body: String,
    charts: Vec<Value>,
    planes: Vec<Value>,
    maps: Vec<Value>,
    scenes: Vec<Value>,
}

impl Page {
    pub(crate) fn new(title: &str, about: &str) -> Self {
        let mut body = format!("<header><h1>{}</h1>", escape(title));
        if !about.is_empty() {
            let _ = write!(body, "<p class=\"about\">{}</p>", escape(about));
        }
        body.push_str("</header>\n");
        Self {
            title: title.to_owned(),
            body,
            charts: Vec::new(),
            planes: Vec::new(),
            maps: Vec::new(),
            scenes: Vec::new(),
        }
    }

    /// The sentence that matters most.
    pub(crate) fn lead(&mut self, sentence: &str) {
        let _ = writeln!(self.body, "<p class=\"lead\">{}</p>", escape(sentence));
    }

    pub(crate) fn heading(&mut self, text: &str) {
        let _ = writeln!(self.body, "<h2>{}</h2>", escape(text));
    }

    pub(crate) fn paragraph(&mut self, text: &str) {
        let _ = writeln!(self.body, "<p>{}</p>", escape(text));
    }

    pub(crate) fn tiles(&mut self, tiles: &[Tile]) {
        self.body.push_str("<div class=\"tiles\">");
        for tile in tiles {
            let (name, value, remark) = (escape(tile.name), escape(&tile.value), escape(&tile.remark));
            let _ = write!(
                self.body,
                "<div class=\"tile\"><span>{name}</span><strong>{value}</strong><small>{remark}</small></div>"
            );
        }
        self.body.push_str("</div>\n");
    }

    pub(crate) fn chart(&mut self, chart: &Chart) {
        let caption = escape(&chart.caption);
        let _ = writeln!(
            self.body,
            "<figure><figcaption><b>{}</b> {caption}</figcaption><div class=\"chart\" data-chart=\"{}\"></div></figure>",
            escape(&chart.title),
            self.charts.len()
        );
        self.charts.push(chart.to_json());
    }

    pub(crate) fn plane(&mut self, plane: &Plane) {
        let (title, caption, index) = (escape(&plane.title), escape(&plane.caption), self.planes.len());
        let _ = writeln!(
            self.body,
            "<figure><figcaption><b>{title}</b> {caption}</figcaption><div class=\"plane\" data-plane=\"{index}\"></div></figure>"
        );
        self.planes.push(plane.to_json());
    }

    /// Drawings side by side, each an SVG element with its caption.
    pub(crate) fn drawings(&mut self, drawings: &[(String, String)]) {
        self.body.push_str("<div class=\"shapes\">");
        for (caption, svg) in drawings {
            let _ = write!(self.body, "<figure><figcaption>{}</figcaption>{svg}</figure>", escape(caption));
        }
        self.body.push_str("</div>\n");
    }

    /// A drawing, with what its parts say under the pointer.
    pub(crate) fn map(&mut self, title: &str, caption: &str, svg: &str, hover: Value) -> usize {
        self.maps.push(hover);
        let data = self.maps.len() - 1;
        self.map_like(title, caption, svg, data);
        data
    }

    /// A map with the places of another, whose number [`Self::map`] gave.
    pub(crate) fn map_like(&mut self, title: &str, caption: &str, svg: &str, other: usize) {
        let _ = writeln!(
            self.body,
            "<figure><figcaption><b>{}</b> {}</figcaption><div class=\"map\" data-map=\"{other}\">{svg}</div><p class=\"told\">&nbsp;</p></figure>",
            escape(title),
            escape(caption),
        );
    }

    /// A scene in space that moves; `assets/scene.js` says what it is made of.
    pub(crate) fn scene(&mut self, title: &str, caption: &str, scene: Value) {
        let (title, caption, index) = (escape(title), escape(caption), self.scenes.len());
        let _ = writeln!(
            self.body,
            "<figure><figcaption><b>{title}</b> {caption}</figcaption><div class=\"scene\" data-scene=\"{index}\"></div></figure>"
        );
        self.scenes.push(scene);
    }

    /// A drawing across the page, on white ground.
    pub(crate) fn picture(&mut self, title: &str, caption: &str, svg: &str) {
        let (title, caption) = (escape(title), escape(caption));
        let _ = writeln!(
            self.body,
            "<figure><figcaption><b>{title}</b> {caption}</figcaption><div class=\"map\">{svg}</div></figure>"
        );
    }

    /// A table; columns named in `right` hold numbers.
    pub(crate) fn table(&mut self, header: &[&str], right: &[usize], rows: &[Vec<String>]) {
        let class = |column: usize| if right.contains(&column) { " class=\"number\"" } else { "" };
        self.body.push_str("<div class=\"scroll\"><table><thead><tr>");
        for (i, name) in header.iter().enumerate() {
            let _ = write!(self.body, "<th{}>{}</th>", class(i), escape(name));
        }
        self.body.push_str("</tr></thead><tbody>");
        for row in rows {
            self.body.push_str("<tr>");
            for (i, cell) in row.iter().enumerate() {
                let _ = write!(self.body, "<td{}>{}</td>", class(i), escape(cell));
            }
            self.body.push_str("</tr>");
        }
        self.body.push_str("</tbody></table></div>\n");
    }

    /// Bars of lengths relative to the largest finite one, each with its name and number; infinite ones are
    /// hatched across the whole width.
    pub(crate) fn bars(&mut self, bars: &[(String, f64, String)]) {
        let largest =
            bars.iter().map(|(_, size, _)| size.abs()).filter(|size| size.is_finite()).fold(0.0, f64::max);
        self.body.push_str("<div class=\"bars\">");
        for (name, size, text) in bars {
            let (width, class) = match *size {
                size if size.is_infinite() => (100.0, "unlimited"),
                size if largest > 0.0 => {
                    (100.0 * size.abs() / largest, if size < 0.0 { "out" } else { "in" })
                }
                _ => (0.0, "in"),
            };
            let (name, text) = (escape(name), escape(text));
            let _ = write!(
                self.body,
                "<span>{name}</span><i class=\"{class}\" style=\"--size:{width:.2}%\"></i><span class=\"number\">{text}</span>"
            );
        }
        self.body.push_str("</div>\n");
    }

    /// A text as it was written, folded away on the screen where it is long.
    pub(crate) fn verbatim(&mut self, title: &str, text: &str) {
        let _ = writeln!(
            self.body,
            "<details open><summary>{}</summary><pre>{}</pre></details>",
            escape(title),
            escape(text)
        );
    }

    /// The page as one file.
    pub(crate) fn render(self) -> String {
        let map_script =
            if self.maps.is_empty() { String::new() } else { format!("<script>\n{MAP_SCRIPT}</script>\n") };
        let data =
            json!({ "charts": self.charts, "planes": self.planes, "maps": self.maps, "scenes": self.scenes })
                .to_string()
                .replace("</", "<\\/");
        let title = escape(&self.title);
        let version = env!("CARGO_PKG_VERSION");
        let licence = UPLOT_LICENCE.trim();
        let plane_script = if self.planes.is_empty() {
            String::new()
        } else {
            format!("<script>\n{PLANE_SCRIPT}</script>\n")
        };
        let scene_script = if self.scenes.is_empty() {
            String::new()
        } else {
            format!("<script>\n{SCENE_SCRIPT}</script>\n")
        };
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
             <style>{UPLOT_STYLE}\n{STYLE}</style>\n</head>\n<body>\n<main>\n{}\
             <noscript><p>The charts of this page need JavaScript.</p></noscript>\n\
             <footer>Made by feeler {version}. Charts: uPlot, MIT licence, copyright 2022 Leon Sorokin.</footer>\n</main>\n\
             <script type=\"application/json\" id=\"data\">{data}</script>\n\
             <script>\n/* uPlot\n{licence}\n*/\n{UPLOT}</script>\n<script>\n{SCRIPT}</script>\n{plane_script}{map_script}{scene_script}</body>\n</html>\n",
            self.body
        )
    }
}
