//! Drawings of a sweep as pixels. Only the parts of SVG that the drawings use are supported; anything else is
//! an error.

mod letters;

use std::collections::BTreeMap;
use std::path::PathBuf;

use rayon::prelude::*;
use roxmltree::{Document, Node};
use tiny_skia::{
    Color, FillRule, LineCap, Mask, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, StrokeDash, Transform,
};

use crate::terminal::failure::Failure;
use letters::Letters;

/// Pixels per unit of the drawing.
const SCALE: f32 = 2.0;

/// Writes drawings as PNG, each to its path, in parallel.
pub(super) fn write(drawings: &[(&str, PathBuf)]) -> crate::Result<()> {
    let letters = if drawings.is_empty() { None } else { Letters::of_system() };
    drawings.par_iter().try_for_each(|(svg, path)| {
        let pixels = drawn(svg, letters.as_ref()).map_err(Failure::internal)?;
        crate::terminal::write(path, &pixels.encode_png().map_err(Failure::internal)?)
    })
}

fn drawn(svg: &str, letters: Option<&Letters>) -> Result<Pixmap, String> {
    let document = Document::parse(svg).map_err(|error| error.to_string())?;
    let image = document.root_element();
    let [width, height] =
        [number(image, "width")?, number(image, "height")?].map(|side| (SCALE * side) as u32);
    let pixels = Pixmap::new(width, height).ok_or("the drawing has no size")?;
    let mut canvas = Canvas { pixels, letters, clips: BTreeMap::new() };
    let place = Place { transform: Transform::from_scale(SCALE, SCALE), clip: None };
    image.children().try_for_each(|child| canvas.draw(child, &place))?;
    Ok(canvas.pixels)
}

struct Canvas<'a> {
    pixels: Pixmap,
    letters: Option<&'a Letters>,
    clips: BTreeMap<&'a str, Mask>,
}

/// Position and clip of an element that is drawn.
#[derive(Clone)]
struct Place<'a> {
    transform: Transform,
    clip: Option<&'a str>,
}

impl<'a> Canvas<'a> {
    fn draw(&mut self, node: Node<'a, '_>, around: &Place<'a>) -> Result<(), String> {
        if !node.is_element() {
            return Ok(());
        }
        let mut place = around.clone();
        for (name, numbers) in transforms(node)? {
            place.transform = match (name, numbers.as_slice()) {
                ("translate", [x, y]) => place.transform.pre_translate(*x, *y),
                ("rotate", [degrees]) => place.transform.pre_concat(Transform::from_rotate(*degrees)),
                _ => return Err(format!("no `{name}` in drawings as pixels")),
            };
        }
        if let Some(clip) = node.attribute("clip-path") {
            place.clip = Some(clip.trim_start_matches("url(#").trim_end_matches(')'));
        }
        match node.tag_name().name() {
            "g" => node.children().try_for_each(|child| self.draw(child, &place)),
            "clipPath" => self.define_clip(node),
            "rect" => self.shape(node, &rectangle(node)?, &place),
            "path" => match outline(node.attribute("d").unwrap_or_default())? {
                Some(path) => self.shape(node, &path, &place),
                None => Ok(()),
            },
            "text" => self.text(node, &place),
            other => Err(format!("no `{other}` in drawings as pixels")),
        }
    }

    /// A clip is a rectangle in the coordinates of the whole drawing.
    fn define_clip(&mut self, node: Node<'a, '_>) -> Result<(), String> {
        let inside = node.first_element_child().ok_or("a clip without a shape")?;
        let mut mask = Mask::new(self.pixels.width(), self.pixels.height()).ok_or("no room for a clip")?;
        let scale = Transform::from_scale(SCALE, SCALE);
        mask.fill_path(&rectangle(inside)?, FillRule::Winding, true, scale);
        self.clips.insert(node.attribute("id").unwrap_or_default(), mask);
        Ok(())
    }

    fn shape(&mut self, node: Node<'a, '_>, path: &Path, place: &Place<'a>) -> Result<(), String> {
        let clip = place.clip.and_then(|name| self.clips.get(name));
        let is_smooth = node.attribute("shape-rendering") != Some("crispEdges");
        if let Some(paint) = paint(node, "fill", "#000000", is_smooth)? {
            self.pixels.fill_path(path, &paint, FillRule::Winding, place.transform, clip);
        }
        if let Some(paint) = paint(node, "stroke", "none", is_smooth)? {
            let dashes = node.attribute("stroke-dasharray").map(numbers).transpose()?;
            let stroke = Stroke {
                width: number_or(node, "stroke-width", 1.0)?,
                line_cap: node.attribute("stroke-linecap").map_or(LineCap::Butt, |_| LineCap::Round),
                dash: dashes.and_then(|dashes| StrokeDash::new(dashes, 0.0)),
                ..Stroke::default()
            };
            self.pixels.stroke_path(path, &paint, &stroke, place.transform, clip);
        }
        Ok(())
    }

    fn text(&mut self, node: Node<'a, '_>, place: &Place<'a>) -> Result<(), String> {
        let size = number(node, "font-size")?;
        let line = self.letters.and_then(|letters| letters.line(node.text().unwrap_or_default(), size));
        let Some((path, length)) = line else { return Ok(()) };
        let before = match node.attribute("text-anchor") {
            Some("middle") => 0.5 * length,
            Some("end") => length,
            _ => 0.0,
        };
        let (x, y) = (number_or(node, "x", 0.0)?, number_or(node, "y", 0.0)?);
        let transform = place.transform.pre_translate(x - before, y);
        self.shape(node, &path, &Place { transform, ..place.clone() })
    }
}

/// The colour of a property, if it has one.
fn paint(
    node: Node<'_, '_>,
    of: &str,
    default: &str,
    is_smooth: bool,
) -> Result<Option<Paint<'static>>, String> {
    let colour = node.attribute(of).unwrap_or(default);
    if colour == "none" {
        return Ok(None);
    }
    let digits = colour.strip_prefix('#').filter(|digits| digits.len() == 6);
    let [_, red, green, blue] = digits
        .and_then(|digits| u32::from_str_radix(digits, 16).ok())
        .ok_or_else(|| format!("no colour `{colour}` in drawings as pixels"))?
        .to_be_bytes();
    let mut colour = Color::from_rgba8(red, green, blue, u8::MAX);
    colour.apply_opacity(number_or(node, &format!("{of}-opacity"), 1.0)?);
    let mut paint = Paint { anti_alias: is_smooth, ..Paint::default() };
    paint.set_color(colour);
    Ok(Some(paint))
}

fn rectangle(node: Node<'_, '_>) -> Result<Path, String> {
    let [x, y] = [number_or(node, "x", 0.0)?, number_or(node, "y", 0.0)?];
    let [width, height] = [number(node, "width")?, number(node, "height")?];
    Rect::from_xywh(x, y, width, height)
        .map(PathBuilder::from_rect)
        .ok_or_else(|| "a rectangle without size".into())
}

/// A path of straight lines; `None` without any.
fn outline(text: &str) -> Result<Option<Path>, String> {
    let mut path = PathBuilder::new();
    let starts = text.char_indices().filter(|(_, c)| c.is_ascii_alphabetic()).map(|(i, _)| i);
    let starts: Vec<usize> = starts.chain([text.len()]).collect();
    for ends in starts.windows(2) {
        let (command, values) = text[ends[0]..ends[1]].split_at(1);
        let last = path.last_point().unwrap_or_default();
        match (command, numbers(values)?.as_slice()) {
            ("M", [x, y]) => path.move_to(*x, *y),
            ("L", [x, y]) => path.line_to(*x, *y),
            ("h", [by]) => path.line_to(last.x + by, last.y),
            ("v", [by]) => path.line_to(last.x, last.y + by),
            ("z", []) => path.close(),
            _ => return Err(format!("no `{command}{values}` in drawings as pixels")),
        }
    }
    Ok(path.finish())
}

/// The transforms of an element in order, with their numbers.
fn transforms<'a>(node: Node<'a, '_>) -> Result<Vec<(&'a str, Vec<f32>)>, String> {
    let text = node.attribute("transform").unwrap_or_default();
    let parts = text.split(')').filter_map(|part| part.trim().split_once('('));
    parts.map(|(name, values)| Ok((name, numbers(values)?))).collect()
}

fn numbers(text: &str) -> Result<Vec<f32>, String> {
    text.split_whitespace().map(|word| word.parse().map_err(|_| format!("no number: `{word}`"))).collect()
}

fn number(node: Node<'_, '_>, key: &str) -> Result<f32, String> {
    let text = node.attribute(key).ok_or_else(|| format!("`{}` without `{key}`", node.tag_name().name()))?;
    text.parse().map_err(|_| format!("no number: `{text}`"))
}

fn number_or(node: Node<'_, '_>, key: &str, default: f32) -> Result<f32, String> {
    if node.has_attribute(key) { number(node, key) } else { Ok(default) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pages::parts::svg::{image, legend, swatch, text_at};

    /// Colour in the middle of a place of the drawing.
    fn at(pixels: &Pixmap, [x, y]: [f32; 2]) -> [u8; 4] {
        let colour = pixels.pixel((SCALE * x) as u32, (SCALE * y) as u32).unwrap().demultiply();
        [colour.red(), colour.green(), colour.blue(), colour.alpha()]
    }

    const WHITE: [u8; 4] = [255; 4];
    const RED: [u8; 4] = [255, 0, 0, 255];

    #[test]
    fn truth_shapes_lines_and_clips_are_where_they_are_drawn() {
        let body = "<clipPath id=\"plot\"><rect x=\"10\" y=\"10\" width=\"20\" height=\"20\"/></clipPath>\
                    <g clip-path=\"url(#plot)\"><path d=\"M0 0h40v20h-40z\" fill=\"#ff0000\"/></g>\
                    <path d=\"M50 10L90 10\" stroke=\"#ff0000\" stroke-width=\"4\" stroke-dasharray=\"8 8\"/>\
                    <g transform=\"translate(50 30) rotate(90)\"><rect width=\"8\" height=\"4\" \
                    fill=\"#ff0000\"/></g><path d=\"M80 35h.01\" stroke=\"#ff0000\" stroke-width=\"8\" \
                    stroke-linecap=\"round\" stroke-opacity=\"0.5\"/>";
        let pixels = drawn(&image(100.0, 50.0, body), None).unwrap();
        assert_eq!((pixels.width(), pixels.height()), (200, 100));
        // A point inside the path and its clip, one outside the clip, and one outside the path.
        assert_eq!(
            [[15.0, 15.0], [5.0, 5.0], [15.0, 25.0]].map(|place| at(&pixels, place)),
            [RED, WHITE, WHITE]
        );
        // The points are in a dash, in a gap and in a dash.
        assert_eq!(
            [[54.0, 10.0], [62.0, 10.0], [70.0, 10.0]].map(|place| at(&pixels, place)),
            [RED, WHITE, RED]
        );
        // A quarter turn maps right to down, and down to left.
        assert_eq!([[48.0, 36.0], [52.0, 32.0]].map(|place| at(&pixels, place)), [RED, WHITE]);
        // Half red over white, with one rounding.
        let dot = at(&pixels, [80.0, 35.0]);
        assert!(dot[0] == 255 && dot[1].abs_diff(128) <= 1 && dot[1] == dot[2], "{dot:?}");
        assert_eq!(at(&pixels, [80.0, 30.0]), WHITE);
    }

    #[test]
    fn truth_text_lies_on_its_side_of_its_place() {
        // A machine without fonts draws no letters.
        let Some(letters) = Letters::of_system() else { return };
        // Ink within 20 units to the left and right of the middle of the drawing, down to the baseline.
        let ink = |anchor: &str| {
            let mut body = String::new();
            text_at(&mut body, [50.0, 20.0], anchor, 12, "#ff0000", "HHH");
            let pixels = drawn(&image(100.0, 30.0, &body), Some(&letters)).unwrap();
            let count = |xs: std::ops::Range<u16>| {
                let places = xs.flat_map(|x| (0..30_u16).map(move |y| [f32::from(x), f32::from(y)]));
                places.filter(|place| at(&pixels, *place) != WHITE).count()
            };
            [count(0..50), count(50..100)]
        };
        let [before, after] = ink("middle");
        assert!(before > 20 && after > 20, "{before} {after}");
        assert!(ink("start")[0] < 3 && ink("end")[1] < 3);
    }

    #[test]
    fn regress_what_has_no_pixels_is_an_error() {
        assert!(drawn(&image(10.0, 10.0, "<circle r=\"1\"/>"), None).is_err());
        assert!(drawn(&image(10.0, 10.0, "<path d=\"M0 0c1 1 1 1 1 1\"/>"), None).is_err());
        let mut body = String::new();
        legend(&mut body, [1.0, 1.0], &[(swatch("#ff0000"), "chatter".into())]);
        assert_eq!(at(&drawn(&image(40.0, 20.0, &body), None).unwrap(), [12.0, 8.0]), RED);
    }
}
