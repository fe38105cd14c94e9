//! Triangle meshes from STL and OBJ.

use parry3d_f64::math::Vector;
use parry3d_f64::shape::SharedShape;

use crate::error::GeometryError;

/// Triangles between points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Corners.
    pub vertices_m: Vec<[f64; 3]>,
    /// Three corners each.
    pub triangles: Vec<[u32; 3]>,
}

/// Bytes before the triangles of a binary STL: its header and their number.
const STL_START: usize = 84;
/// Bytes per triangle: a normal, three corners, and two of padding.
const STL_TRIANGLE: usize = 50;

/// Remedy for a broken mesh.
const EXPORT: &str = "export the mesh again as triangles";

fn mesh_error<T>(what: impl Into<String>) -> Result<T, GeometryError> {
    Err(GeometryError::Mesh { what: what.into(), remedy: EXPORT })
}

impl Mesh {
    pub(crate) fn build(&self) -> Result<SharedShape, GeometryError> {
        if self.triangles.is_empty() {
            return mesh_error("the mesh has no triangles");
        }
        let count = self.vertices_m.len();
        if self.triangles.iter().flatten().any(|&corner| corner as usize >= count) {
            return mesh_error(format!("a triangle names a corner beyond the last of {count}"));
        }
        if self.vertices_m.iter().flatten().any(|x| !x.is_finite()) {
            return mesh_error("a corner of the mesh is not finite");
        }
        let vertices = self.vertices_m.iter().map(|v| Vector::from_array(*v)).collect();
        SharedShape::trimesh(vertices, self.triangles.clone())
            .map_err(|error| GeometryError::Mesh { what: error.to_string(), remedy: EXPORT })
    }
}

/// Reads an STL file, text or binary; `scale_m` is the length of its unit (1e-3 for millimetres).
///
/// # Errors
/// [`GeometryError::Mesh`] for a truncated file or one without triangles, [`GeometryError::Line`] for a text
/// that is not STL.
pub fn read_stl(bytes: &[u8], scale_m: f64) -> Result<Mesh, GeometryError> {
    let declared = bytes.get(80..STL_START).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize);
    let is_text =
        bytes.starts_with(b"solid") && declared.is_none_or(|n| bytes.len() != STL_START + n * STL_TRIANGLE);
    let mut mesh = Mesh::default();
    if is_text {
        let Ok(text) = std::str::from_utf8(bytes) else {
            return mesh_error("the STL is neither text nor a whole binary file");
        };
        for (i, line) in text.lines().enumerate() {
            if let Some(rest) = line.trim_start().strip_prefix("vertex") {
                mesh.vertices_m.push(corner(i, rest.split_whitespace(), scale_m)?);
            }
        }
    } else {
        let Some(count) = declared.filter(|n| bytes.len() >= STL_START + n * STL_TRIANGLE) else {
            return mesh_error(format!("the binary STL of {} bytes is cut short", bytes.len()));
        };
        for triangle in bytes[STL_START..].chunks_exact(STL_TRIANGLE).take(count) {
            let number = |k: usize| {
                f64::from(f32::from_le_bytes([
                    triangle[k],
                    triangle[k + 1],
                    triangle[k + 2],
                    triangle[k + 3],
                ]))
            };
            for first in [12, 24, 36] {
                mesh.vertices_m.push([0, 4, 8].map(|k| scale_m * number(first + k)));
            }
        }
    }
    if mesh.vertices_m.len() % 3 != 0 {
        return mesh_error(format!("{} corners do not make triangles", mesh.vertices_m.len()));
    }
    mesh.triangles = (0..mesh.vertices_m.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    mesh.build()?;
    Ok(mesh)
}

/// Reads corners (`v`) and faces (`f`) of an OBJ file; faces of more than three corners are divided into
/// triangles. `scale_m` is the length of its unit.
///
/// # Errors
/// [`GeometryError::Line`] for a syntax error, [`GeometryError::Mesh`] for a mesh without triangles.
pub fn read_obj(text: &str, scale_m: f64) -> Result<Mesh, GeometryError> {
    let mut mesh = Mesh::default();
    for (i, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => mesh.vertices_m.push(corner(i, words, scale_m)?),
            Some("f") => {
                let corners: Option<Vec<u32>> =
                    words.map(|word| index(word, mesh.vertices_m.len())).collect();
                let Some(corners) = corners.filter(|corners| corners.len() >= 3) else {
                    return Err(GeometryError::Line {
                        line: i + 1,
                        what: "this is not a face of three corners or more".into(),
                        remedy: "name three corners or more by their numbers, each above the face",
                    });
                };
                mesh.triangles
                    .extend((1..corners.len() - 1).map(|k| [corners[0], corners[k], corners[k + 1]]));
            }
            _ => {}
        }
    }
    mesh.build()?;
    Ok(mesh)
}

fn corner<'a>(
    line: usize,
    words: impl Iterator<Item = &'a str>,
    scale_m: f64,
) -> Result<[f64; 3], GeometryError> {
    let numbers: Vec<f64> =
        words.take(3).filter_map(|word| word.parse().ok()).filter(|x: &f64| x.is_finite()).collect();
    match numbers.as_slice() {
        [x, y, z] => Ok([x * scale_m, y * scale_m, z * scale_m]),
        _ => Err(GeometryError::Line {
            line: line + 1,
            what: "this corner has not three finite numbers".into(),
            remedy: "write x, y and z of the corner",
        }),
    }
}

/// A corner's number, as `7`, `7/1/2` or `-1` for the last one.
fn index(word: &str, corners: usize) -> Option<u32> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let corners = i64::try_from(corners).ok()?;
    let from_zero = if number < 0 { corners + number } else { number - 1 };
    u32::try_from(from_zero).ok().filter(|_| from_zero < corners)
}
