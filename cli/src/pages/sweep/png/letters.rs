//! Letters as outlines from a font of the system.

use fontdb::{Database, Family, Query};
use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, OutlineBuilder};

/// The families of the drawings (`svg::FONT`).
const FAMILIES: [Family<'_>; 4] =
    [Family::Name("DejaVu Sans"), Family::Name("Helvetica"), Family::Name("Arial"), Family::SansSerif];

/// The file of a font, and the index of the face in it.
pub(super) struct Letters {
    file: Vec<u8>,
    index: u32,
}

impl Letters {
    /// The first available family, or else any font; `None` on a system without fonts.
    pub(super) fn of_system() -> Option<Self> {
        let mut fonts = Database::new();
        fonts.load_system_fonts();
        let query = Query { families: &FAMILIES, ..Query::default() };
        let found = fonts.query(&query).or_else(|| fonts.faces().next().map(|face| face.id))?;
        fonts.with_face_data(found, |file, index| Self { file: file.to_vec(), index })
    }

    /// The outlines of a line of text from the origin to the right, and its length. Characters that the font
    /// lacks are left out.
    pub(super) fn line(&self, text: &str, size: f32) -> Option<(Path, f32)> {
        let face = Face::parse(&self.file, self.index).ok()?;
        let scale = size / f32::from(face.units_per_em());
        let mut pen = Pen { path: PathBuilder::new(), scale, x: 0.0 };
        for glyph in text.chars().filter_map(|letter| face.glyph_index(letter)) {
            face.outline_glyph(glyph, &mut pen);
            pen.x += scale * f32::from(face.glyph_hor_advance(glyph).unwrap_or_default());
        }
        let length = pen.x;
        Some((pen.path.finish()?, length))
    }
}

/// Draws outlines. Their coordinates grow upward from the baseline, those of the drawing downward.
struct Pen {
    path: PathBuilder,
    scale: f32,
    /// Start of the current letter.
    x: f32,
}

impl Pen {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + self.scale * x, -self.scale * y)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}
