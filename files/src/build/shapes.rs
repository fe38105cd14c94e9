//! Shapes and where they stand.

use std::path::Path;

use feeler_catalogue::Contents;
use feeler_geometry::{GeometryError, Place, Shape, read_height_field, read_obj, read_stl};

use feeler_problem::Remedy;

use crate::file::{read_bytes, read_text};

/// Bytes of the largest shape: a scan of some millions of triangles.
const LARGEST_SHAPE: u64 = 1 << 29;

/// Why a file gives no shape or path.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FileError {
    #[error(transparent)]
    Read(#[from] std::io::Error),
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    #[error("`{0}` is no mesh format that is read")]
    Extension(String),
}

impl FileError {
    /// What to do about it where `what` is wanted.
    pub(crate) fn remedy(&self, what: &str) -> String {
        match self {
            Self::Read(_) => format!("name {what}, relative to this file"),
            Self::Geometry(error) => error.remedy().into_owned(),
            Self::Extension(_) => "export it as STL or OBJ".into(),
        }
    }
}

pub(crate) fn text_of(path: &Path) -> Result<String, std::io::Error> {
    read_text(path, LARGEST_SHAPE)
}

/// Position and orientation.
pub(crate) fn place(fields: &Contents) -> Place {
    Place {
        position_m: ["x", "y", "z"].map(|key| fields.number(key)),
        rotation_rad: ["turn_x", "turn_y", "turn_z"].map(|key| fields.number(key)),
    }
}

/// What file a shape is read from; empty where from none.
pub(crate) fn file_of(fields: &Contents) -> &'static str {
    match fields.variant {
        Some("hull" | "mesh") => "an STL or OBJ file",
        Some("height-field") => "a CSV file of heights",
        _ => "",
    }
}

/// A shape that needs no file.
pub(crate) fn plain(fields: &Contents) -> Option<Shape> {
    let number = |key| fields.number(key);
    Some(match fields.variant? {
        "ball" => Shape::Ball { radius_m: number("radius") },
        "capsule" => Shape::Capsule { half_length_m: number("half_length"), radius_m: number("radius") },
        "cuboid" => Shape::Cuboid { half_extents_m: ["half_x", "half_y", "half_z"].map(number) },
        "cylinder" => Shape::Cylinder { half_length_m: number("half_length"), radius_m: number("radius") },
        _ => return None,
    })
}

/// A shape from its file.
pub(crate) fn from_file(fields: &Contents, path: &Path) -> Result<Shape, FileError> {
    if fields.variant == Some("height-field") {
        return Ok(read_height_field(
            &text_of(path)?,
            ["extent_y", "extent_z"].map(|key| fields.number(key)),
        )?);
    }
    let mesh = mesh(path, fields.number("scale"))?;
    Ok(if fields.variant == Some("hull") {
        Shape::Hull { points_m: mesh.vertices_m }
    } else {
        Shape::Mesh(mesh)
    })
}

/// A mesh from an STL or OBJ file.
pub(crate) fn mesh(path: &Path, scale_m: f64) -> Result<feeler_geometry::Mesh, FileError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match extension.as_str() {
        "stl" => Ok(read_stl(&read_bytes(path, LARGEST_SHAPE)?, scale_m)?),
        "obj" => Ok(read_obj(&text_of(path)?, scale_m)?),
        _ => Err(FileError::Extension(extension)),
    }
}
