//! Height fields from text.

use crate::error::GeometryError;
use crate::shape::Shape;

/// A height field from CSV without a header: one line per z, one number in metres per y, both rising.
///
/// # Errors
/// [`GeometryError::Line`] for invalid numbers and for lines of unequal length; [`GeometryError::Mesh`] for
/// less than two rows or columns.
pub fn read_height_field(text: &str, extents_m: [f64; 2]) -> Result<Shape, GeometryError> {
    let mut heights_m: Vec<Vec<f64>> = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let number = |field: &str| field.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        let row: Option<Vec<f64>> = line.split(',').map(number).collect();
        let line = i + 1;
        let row = row.ok_or_else(|| GeometryError::Line {
            line,
            what: "a field is not a finite number".into(),
            remedy: "write heights in metres, separated by commas",
        })?;
        if let Some(first) = heights_m.first().filter(|first| first.len() != row.len()) {
            return Err(GeometryError::Line {
                line,
                what: format!("{} heights where the first line has {}", row.len(), first.len()),
                remedy: "write as many heights in every line",
            });
        }
        heights_m.push(row);
    }
    let shape = Shape::HeightField { heights_m, extents_m };
    shape.build()?;
    Ok(shape)
}
