//! Self-contained pages: text, tables and interactive charts in one file without network access.
//!
//! A [`Page`] collects sections in reading order and is rendered once. The vendored uPlot (MIT licence, see
//! `assets/uplot.LICENSE`) draws the charts from data in the page.

mod bars;
mod chart;
mod cividis;
mod decimate;
mod html;
mod plane;
mod scale;
pub(crate) mod svg;

use std::fmt::Write as _;

use serde_json::{Value, json};

pub(crate) use chart::{Chart, ChartKind, Gauge, Line, Mark, Series};
pub(crate) use cividis::of_share;
pub(crate) use decimate::{MOST_VALUES, by_extremes, by_steps};
pub(crate) use html::{escape, prose};
pub(crate) use plane::{Circle, CircleKind, Plane, PlaneKind, PlaneMark, PlanePath, PlaneShape, view_of};
use svg::Plot;

const UPLOT: &str = include_str!("../../../assets/uplot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("../../../assets/uplot.min.css");
const UPLOT_LICENCE: &str = include_str!("../../../assets/uplot.LICENSE");
const CHARTS_SCRIPT: &str = include_str!("../../../assets/charts.js");
const SCRIPT: &str = include_str!("../../../assets/page.js");
const PLANE_SCRIPT: &str = include_str!("../../../assets/plane.js");
const ZOOM_SCRIPT: &str = include_str!("../../../assets/zoom.js");
const MAP_SCRIPT: &str = include_str!("../../../assets/map.js");
const SCENE_SCRIPT: &str = include_str!("../../../assets/scene.js");
const STYLE: &str = include_str!("../../../assets/page.css");

/// Number of columns that are too many for a narrow screen.
const MANY_COLUMNS: usize = 6;

/// Assessment of a figure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Tone {
    #[default]
    Plain,
    /// The figure is as desired.
    Good,
    /// The figure needs a remedy.
    Bad,
    /// The figure is given for completeness.
    Quiet,
}

impl Tone {
    fn class(self) -> &'static str {
        match self {
            Self::Plain => "tile",
            Self::Good => "tile good",
            Self::Bad => "tile bad",
            Self::Quiet => "tile quiet",
        }
    }
}

/// A key figure: its name, the number with its unit, and a remark.
pub(crate) struct Tile {
    name: &'static str,
    value: String,
    remark: String,
    tone: Tone,
}

impl Tile {
    pub(crate) fn new(name: &'static str, value: impl Into<String>, remark: impl Into<String>) -> Self {
        Self { name, value: value.into(), remark: remark.into(), tone: Tone::Plain }
    }

    pub(crate) fn toned(self, tone: Tone) -> Self {
        Self { tone, ..self }
    }
}

/// A page before it is rendered.
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
            let _ = write!(body, "<p class=\"about\">{}</p>", prose(about));
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

    /// The most important sentence of the page.
    pub(crate) fn lead(&mut self, sentence: &str) {
        let _ = writeln!(self.body, "<p class=\"lead\">{}</p>", prose(sentence));
    }

    pub(crate) fn heading(&mut self, text: &str) {
        let _ = writeln!(self.body, "<h2>{}</h2>", escape(text));
    }

    pub(crate) fn paragraph(&mut self, text: &str) {
        let _ = writeln!(self.body, "<p>{}</p>", prose(text));
    }

    /// Numbered steps.
    pub(crate) fn steps(&mut self, steps: &[String]) {
        self.body.push_str("<ol>\n");
        for step in steps {
            let _ = writeln!(self.body, "<li>{}</li>", prose(step));
        }
        self.body.push_str("</ol>\n");
    }

    pub(crate) fn tiles(&mut self, tiles: &[Tile]) {
        self.body.push_str(&tiles_html(tiles));
    }

    pub(crate) fn chart(&mut self, chart: &Chart) {
        let (title, caption, index) = (escape(&chart.title), prose(&chart.caption), self.charts.len());
        if let Some(instead) = chart.instead() {
            let instead = prose(&instead);
            let _ = writeln!(
                self.body,
                "<figure><figcaption><b>{title}</b> {caption}</figcaption><p>{instead}</p></figure>"
            );
            return;
        }
        let label = of_drawing(&chart.title, &chart.y_label);
        let _ = writeln!(
            self.body,
            "<figure><figcaption><b>{title}</b> {caption}</figcaption><div class=\"chart\" \
             data-chart=\"{index}\" {label}></div></figure>"
        );
        self.charts.push(chart.to_json());
    }

    pub(crate) fn plane(&mut self, plane: &Plane) {
        let (title, caption, index) = (escape(&plane.title), prose(&plane.caption), self.planes.len());
        let label = of_drawing(&plane.title, &plane.y_label);
        let _ = writeln!(
            self.body,
            "<figure><figcaption><b>{title}</b> {caption}</figcaption><div class=\"plane\" \
             data-plane=\"{index}\" {label}></div></figure>"
        );
        self.planes.push(plane.to_json());
    }

    /// Drawings side by side, each an SVG element with its caption.
    pub(crate) fn drawings(&mut self, drawings: &[(String, String)]) {
        self.body.push_str("<div class=\"shapes\">");
        for (caption, svg) in drawings {
            let _ = write!(self.body, "<figure><figcaption>{}</figcaption>{svg}</figure>", prose(caption));
        }
        self.body.push_str("</div>\n");
    }

    /// A drawing with a text under the pointer for each of its parts. Returns the number of the map.
    pub(crate) fn map(&mut self, title: &str, caption: &str, svg: &str, hover: Value) -> usize {
        let data = self.hover(hover);
        self.map_like(title, caption, svg, data);
        data
    }

    fn hover(&mut self, hover: Value) -> usize {
        self.maps.push(hover);
        self.maps.len() - 1
    }

    /// A plot with texts under the pointer. A narrow screen shows it whole, with its legend below.
    pub(crate) fn plot(&mut self, title: &str, caption: &str, plot: &Plot, hover: Value) -> usize {
        let data = self.hover(hover);
        self.plot_like(title, caption, plot, data);
        data
    }

    /// A plot with the texts of another map.
    pub(crate) fn plot_like(&mut self, title: &str, caption: &str, plot: &Plot, other: usize) {
        let label = of_drawing(title, "map");
        let (title, caption, svg) = (escape(title), prose(caption), plot.alone());
        let _ = write!(
            self.body,
            "<figure class=\"plot\"><figcaption><b>{title}</b> {caption}</figcaption><div class=\"map\" \
             data-map=\"{other}\" {label}>{svg}</div><p class=\"told\" aria-live=\"polite\">&nbsp;</p>\
             <ul class=\"swatches\">"
        );
        for (swatch, name) in &plot.entries {
            let _ = write!(
                self.body,
                "<li><svg viewBox=\"0 0 24 14\" width=\"24\" height=\"14\" aria-hidden=\"true\">{swatch}\
                 </svg>{}</li>",
                escape(name)
            );
        }
        self.body.push_str("</ul></figure>\n");
    }

    /// A drawing with the texts of another map, whose number [`Self::map`] returned.
    pub(crate) fn map_like(&mut self, title: &str, caption: &str, svg: &str, other: usize) {
        let (label, least) = (of_drawing(title, "map"), legible(svg));
        let (title, caption) = (escape(title), prose(caption));
        let _ = writeln!(
            self.body,
            "<figure><figcaption><b>{title}</b> {caption}</figcaption><div class=\"map\" \
             data-map=\"{other}\" {label} {least}>{svg}</div><p class=\"told\" \
             aria-live=\"polite\">&nbsp;</p></figure>"
        );
    }

    /// An animated scene in space; `assets/scene.js` describes its parts.
    pub(crate) fn scene(&mut self, title: &str, caption: &str, scene: Value) {
        let (title, caption, index) = (escape(title), prose(caption), self.scenes.len());
        let _ = writeln!(
            self.body,
            "<figure><figcaption><b>{title}</b> {caption}</figcaption><div class=\"scene\" \
             data-scene=\"{index}\"></div></figure>"
        );
        self.scenes.push(scene);
    }

    /// A drawing across the page.
    pub(crate) fn picture(&mut self, title: &str, caption: &str, svg: &str) {
        let (label, least) = (of_drawing(title, "drawing"), legible(svg));
        let (title, caption) = (escape(title), prose(caption));
        let _ = writeln!(
            self.body,
            "<figure><figcaption><b>{title}</b> {caption}</figcaption><div class=\"map\" {label} \
             {least}>{svg}</div></figure>"
        );
    }

    /// A table; columns in `right` hold numbers. On a narrow screen a row of many columns wraps, each cell
    /// below its heading.
    pub(crate) fn table(&mut self, header: &[&str], right: &[usize], rows: &[Vec<String>]) {
        let kind = if header.len() < MANY_COLUMNS { "scroll" } else { "scroll cards" };
        self.table_of(kind, header, right, rows);
    }

    /// A table with a column for each of several things. On a narrow screen a row's title is above it.
    pub(crate) fn versus(&mut self, header: &[&str], rows: &[Vec<String>]) {
        self.table_of("scroll versus", header, &[], rows);
    }

    fn table_of(&mut self, kind: &str, header: &[&str], right: &[usize], rows: &[Vec<String>]) {
        let class = |column: usize| if right.contains(&column) { " class=\"number\"" } else { "" };
        let label = header.iter().filter(|name| !name.is_empty()).copied().collect::<Vec<_>>().join(", ");
        let label = escape(&label);
        let _ = write!(
            self.body,
            "<div class=\"{kind}\" style=\"--columns:{}\" tabindex=\"0\" role=\"region\" \
             aria-label=\"table: {label}\"><table><thead><tr>",
            header.len().saturating_sub(1)
        );
        for (i, name) in header.iter().enumerate() {
            // An empty header cell is an ordinary cell.
            let cell = if name.is_empty() { "td" } else { "th" };
            let _ = write!(self.body, "<{cell}{}>{}</{cell}>", class(i), escape(name));
        }
        self.body.push_str("</tr></thead><tbody>");
        let heads: Vec<String> =
            header.iter().map(|name| format!(" data-head=\"{}\"", escape(name))).collect();
        let wraps = kind.ends_with("cards");
        for row in rows {
            self.body.push_str("<tr>");
            for (i, cell) in row.iter().enumerate() {
                let head = heads.get(i).filter(|_| wraps).map_or("", String::as_str);
                let _ = write!(self.body, "<td{}{head}>{}</td>", class(i), prose(cell));
            }
            self.body.push_str("</tr>");
        }
        self.body.push_str("</tbody></table></div>\n");
    }

    /// A legend of colours.
    pub(crate) fn swatches(&mut self, entries: &[(&str, String)]) {
        self.body.push_str("<ul class=\"swatches\">");
        for (colour, text) in entries {
            let _ = write!(self.body, "<li><i style=\"background:{colour}\"></i>{}</li>", prose(text));
        }
        self.body.push_str("</ul>\n");
    }

    /// A long table, folded until the reader opens it.
    pub(crate) fn folded_table(
        &mut self,
        title: &str,
        header: &[&str],
        right: &[usize],
        rows: &[Vec<String>],
    ) {
        let _ = write!(self.body, "<details><summary>{}</summary>", escape(title));
        self.table(header, right, rows);
        self.body.push_str("</details>\n");
    }

    /// A verbatim text, folded on the screen if it is long.
    pub(crate) fn verbatim(&mut self, title: &str, text: &str) {
        let _ = writeln!(
            self.body,
            "<details open><summary>{}</summary><pre tabindex=\"0\" aria-label=\"text\" \
             role=\"region\">{}</pre></details>",
            escape(title),
            escape(text)
        );
    }

    /// The page as one file.
    pub(crate) fn render(self) -> String {
        let scripts = [
            (PLANE_SCRIPT, self.planes.is_empty()),
            (ZOOM_SCRIPT, self.maps.is_empty()),
            (MAP_SCRIPT, self.maps.is_empty()),
            (SCENE_SCRIPT, self.scenes.is_empty()),
        ];
        let scripts: Vec<&str> =
            scripts.iter().filter(|(_, is_idle)| !is_idle).map(|(script, _)| *script).collect();
        let data =
            json!({ "charts": self.charts, "planes": self.planes, "maps": self.maps, "scenes": self.scenes });
        document(&self.title, "", &self.body, &data, &scripts)
    }
}

/// A page that assembles its own body, from the data of its scripts and the scripts. These run after the
/// scripts for charts and planes.
pub(crate) fn own_page(title: &str, style: &str, body: &str, data: &Value, scripts: &[&str]) -> String {
    let scripts: Vec<&str> = std::iter::once(PLANE_SCRIPT).chain(scripts.iter().copied()).collect();
    // Browsers request an icon unless the page names one.
    let head = format!("<link rel=\"icon\" href=\"data:,\">\n<style>{style}</style>\n");
    document(title, &head, body, data, &scripts)
}

fn document(title: &str, head: &str, body: &str, data: &Value, scripts: &[&str]) -> String {
    let data = data.to_string().replace("</", "<\\/");
    let title = escape(title);
    let version = env!("CARGO_PKG_VERSION");
    let licence = UPLOT_LICENCE.trim();
    let scripts =
        scripts.iter().fold(String::new(), |all, script| all + "<script>\n" + script + "</script>\n");
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
         <style>{UPLOT_STYLE}\n{STYLE}</style>\n{head}</head>\n<body>\n<main>\n{body}\
         <noscript><p>The charts of this page need JavaScript.</p></noscript>\n\
         <footer>Made by feeler {version}. Charts: uPlot, MIT licence, copyright 2022 Leon \
         Sorokin.</footer>\n</main>\n\
         <script type=\"application/json\" id=\"data\">{data}</script>\n\
         <script>\n/* uPlot\n{licence}\n*/\n{UPLOT}</script>\n\
         <script>\n{CHARTS_SCRIPT}</script>\n<script>\n{SCRIPT}</script>\n{scripts}</body>\n</html>\n"
    )
}

/// Key figures side by side.
pub(crate) fn tiles_html(tiles: &[Tile]) -> String {
    if tiles.is_empty() {
        return String::new();
    }
    let mut body = String::from("<div class=\"tiles\">");
    for tile in tiles {
        let (name, value, remark) = (escape(tile.name), escape(&tile.value), prose(&tile.remark));
        let class = tile.tone.class();
        let _ = write!(
            body,
            "<div class=\"{class}\"><span>{name}</span><strong>{value}</strong><small>{remark}</small></div>"
        );
    }
    body + "</div>\n"
}

/// HTML attributes that name a drawing and make it reachable by keyboard.
fn of_drawing(title: &str, what: &str) -> String {
    let name = format!("{} {what}", title.trim_end_matches([',', '.', ':']));
    let name = escape(name.trim());
    format!("tabindex=\"0\" role=\"group\" aria-label=\"{name}\"")
}

/// Smallest size of letters on a narrow screen, px.
const LETTERS: f64 = 11.0;

/// The smallest width of a drawing at which its letters are legible, as a style. Narrower screens scroll.
fn legible(svg: &str) -> String {
    let number = |after: &str| {
        let digits =
            |rest: &str| rest.split(|c: char| !c.is_ascii_digit() && c != '.').next()?.parse::<f64>().ok();
        svg.match_indices(after).filter_map(|(i, _)| digits(&svg[i + after.len()..])).collect::<Vec<_>>()
    };
    let smallest = number("font-size=\"").into_iter().fold(f64::INFINITY, f64::min);
    let width = number("viewBox=\"0 0 ").first().copied().unwrap_or_default();
    if smallest.is_finite() {
        format!("style=\"--least:{:.0}px\"", (width * LETTERS / smallest).ceil())
    } else {
        String::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_drawing_s_letters_stay_legible() {
        let svg = "<svg viewBox=\"0 0 900 400\"><text font-size=\"13\">a</text><text \
                   font-size=\"12\">b</text></svg>";
        assert_eq!(legible(svg), "style=\"--least:825px\"");
        assert_eq!(legible("<svg viewBox=\"0 0 900 400\"></svg>"), "");
    }
}
