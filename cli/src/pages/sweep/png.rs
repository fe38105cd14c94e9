//! SVGs as pixels.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

use crate::terminal::failure::Failure;

/// Pixels per unit of the drawing.
const SCALE: f32 = 2.0;

/// Writes drawings as PNG, each to its path, on all processors. Letters are those of the system's sans-serif
/// font, which is looked up once.
pub(super) fn write(drawings: &[(&str, PathBuf)]) -> crate::Result<()> {
    let mut options = Options::default();
    if !drawings.is_empty() {
        options.fontdb_mut().load_system_fonts();
    }
    drawings.par_iter().try_for_each(|(svg, path)| draw(svg, path, &options))
}

fn draw(svg: &str, path: &Path, options: &Options<'_>) -> crate::Result<()> {
    let tree = Tree::from_str(svg, options).map_err(Failure::internal)?;
    let (width, height) = (tree.size().width() * SCALE, tree.size().height() * SCALE);
    let mut pixels = Pixmap::new(width.ceil() as u32, height.ceil() as u32)
        .ok_or_else(|| Failure::internal("the drawing has no size"))?;
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixels.as_mut());
    crate::terminal::write(path, &pixels.encode_png().map_err(Failure::internal)?)
}
