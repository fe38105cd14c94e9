//! Shapes from their files.

use std::borrow::Cow;
use std::path::Path;

use feeler_geometry::{GeometryError, Shape, read_height_field, read_obj, read_stl};
use feeler_problem::Remedy;

use crate::file::{read_bytes, read_text};
use crate::keys::surface::ShapeFile;

/// Size of the largest shape in bytes: a scan of a few million triangles.
const LARGEST_SHAPE: u64 = 1 << 29;

/// Why a file is not a valid shape or path.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FileError {
    #[error("{source}")]
    Read {
        /// The format that the file should have.
        wanted: &'static str,
        source: std::io::Error,
    },
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    #[error("`{0}` is not a mesh format that Feeler reads")]
    Extension(String),
}

impl Remedy for FileError {
    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::Read { wanted, .. } => format!("name {wanted}, relative to this file").into(),
            Self::Geometry(error) => error.remedy(),
            Self::Extension(_) => "export it as STL or OBJ".into(),
        }
    }
}

const MESH: &str = "an STL or OBJ file";

pub(crate) fn text_of(path: &Path, wanted: &'static str) -> Result<String, FileError> {
    read_text(path, LARGEST_SHAPE).map_err(|source| FileError::Read { wanted, source })
}

impl ShapeFile {
    pub(crate) fn load(&self, path: &Path) -> Result<Shape, FileError> {
        Ok(match self {
            Self::Hull { scale_m, .. } => Shape::Hull { points_m: mesh(path, *scale_m)?.vertices_m },
            Self::Mesh { scale_m, .. } => Shape::Mesh(mesh(path, *scale_m)?),
            Self::HeightField { extents_m, .. } => {
                read_height_field(&text_of(path, "a CSV file of heights")?, *extents_m)?
            }
        })
    }
}

/// A mesh from an STL or OBJ file.
pub(crate) fn mesh(path: &Path, scale_m: f64) -> Result<feeler_geometry::Mesh, FileError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match extension.as_str() {
        "stl" => {
            let bytes =
                read_bytes(path, LARGEST_SHAPE).map_err(|source| FileError::Read { wanted: MESH, source })?;
            Ok(read_stl(&bytes, scale_m)?)
        }
        "obj" => Ok(read_obj(&text_of(path, MESH)?, scale_m)?),
        _ => Err(FileError::Extension(extension)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let all = [
            FileError::Read { wanted: MESH, source: std::io::ErrorKind::NotFound.into() },
            GeometryError::Hull { points: 3 }.into(),
            FileError::Extension("step".into()),
        ];
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("shapes.rs")),
            Vec::<String>::new()
        );
    }
}
