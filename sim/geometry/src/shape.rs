//! Shapes and their places.

use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::shape::SharedShape;
use parry3d_f64::utils::Array2;

use crate::error::GeometryError;
use crate::mesh::Mesh;

/// A shape, centred on its origin. Capsules and cylinders have their axis along y; a [`Placement`] turns
/// them.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    Ball {
        radius_m: f64,
    },
    /// All points within `radius_m` of a line.
    Capsule {
        /// Half the length of the line.
        half_length_m: f64,
        radius_m: f64,
    },
    /// A box.
    Cuboid {
        /// Half its extents in x, y and z.
        half_extents_m: [f64; 3],
    },
    Cylinder {
        half_length_m: f64,
        radius_m: f64,
    },
    /// The convex hull of points.
    Hull {
        /// The shape is the convex hull of these, m.
        points_m: Vec<[f64; 3]>,
    },
    /// A triangle mesh: a surface without an inside.
    Mesh(Mesh),
    /// A surface of heights over the y-z plane, rising towards -x. Between its samples it has two flat
    /// triangles per cell.
    HeightField {
        /// One row per z, one column per y, both rising; at least two of each, and all rows equally long.
        heights_m: Vec<Vec<f64>>,
        /// Extent in y and z, about the middle.
        extents_m: [f64; 2],
    },
}

/// Position and orientation of a shape.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    /// Position of its origin.
    pub position_m: [f64; 3],
    /// Axis of rotation times its angle.
    pub rotation_rad: [f64; 3],
}

impl Placement {
    /// Upright at a position.
    pub fn at(position_m: [f64; 3]) -> Self {
        Self { position_m, rotation_rad: [0.0; 3] }
    }

    pub(crate) fn pose(&self) -> Pose {
        Pose::from_parts(
            Vector::from_array(self.position_m),
            Rotation::from_scaled_axis(Vector::from_array(self.rotation_rad)),
        )
    }
}

fn size(what: &'static str, value: f64) -> Result<f64, GeometryError> {
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err(GeometryError::Size { what, value }) }
}

impl Shape {
    /// Its name in files and messages.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Ball { .. } => "ball",
            Self::Capsule { .. } => "capsule",
            Self::Cuboid { .. } => "cuboid",
            Self::Cylinder { .. } => "cylinder",
            Self::Hull { .. } => "hull",
            Self::Mesh(_) => "mesh",
            Self::HeightField { .. } => "height-field",
        }
    }

    /// The shape for Parry, and its pose in the frame of this shape.
    pub(crate) fn build(&self) -> Result<(SharedShape, Pose), GeometryError> {
        let shape = match self {
            Self::Ball { radius_m } => SharedShape::ball(size("the radius of a ball", *radius_m)?),
            Self::Capsule { half_length_m, radius_m } => SharedShape::capsule_y(
                size("the half length of a capsule", *half_length_m)?,
                size("the radius of a capsule", *radius_m)?,
            ),
            Self::Cuboid { half_extents_m } => {
                let [x, y, z] = half_extents_m.map(|h| size("a half extent of a cuboid", h));
                SharedShape::cuboid(x?, y?, z?)
            }
            Self::Cylinder { half_length_m, radius_m } => SharedShape::cylinder(
                size("the half length of a cylinder", *half_length_m)?,
                size("the radius of a cylinder", *radius_m)?,
            ),
            Self::Hull { points_m } => {
                let points: Vec<Vector> = points_m.iter().map(|p| Vector::from_array(*p)).collect();
                let hull = if spans_a_body(&points) { SharedShape::convex_hull(&points) } else { None };
                hull.ok_or(GeometryError::Hull { points: points.len() })?
            }
            Self::Mesh(mesh) => mesh.build()?,
            Self::HeightField { heights_m, extents_m } => return height_field(heights_m, *extents_m),
        };
        Ok((shape, Pose::IDENTITY))
    }
}

/// Whether the points span a body. Hulls of points that lie (nearly) in one plane fail in other ways.
fn spans_a_body(points: &[Vector]) -> bool {
    /// Thinnest body over its size.
    const FLAT: f64 = 1e-9;
    let Some(&first) = points.first() else { return false };
    let farthest =
        |distance: &dyn Fn(Vector) -> f64| points.iter().map(|p| distance(*p - first)).fold(0.0, f64::max);
    let length = farthest(&|d| d.length());
    let Some(along) = points.iter().map(|p| *p - first).find(|d| d.length() >= length && length > 0.0) else {
        return false;
    };
    let along = along / length;
    let width = farthest(&|d| d.cross(along).length());
    let Some(across) = points
        .iter()
        .map(|p| (*p - first).cross(along))
        .find(|d| d.length() >= width && width > FLAT * length)
    else {
        return false;
    };
    let normal = across / width;
    farthest(&|d| d.dot(normal).abs()) > FLAT * length && points.iter().all(|p| p.is_finite())
}

fn height_field(heights_m: &[Vec<f64>], extents_m: [f64; 2]) -> Result<(SharedShape, Pose), GeometryError> {
    let (rows, columns) = (heights_m.len(), heights_m.first().map_or(0, Vec::len));
    if rows < 2 || columns < 2 {
        return Err(GeometryError::Mesh {
            what: format!("a height field of {rows} rows and {columns} columns has no surface"),
            remedy: "write at least two lines of two heights",
        });
    }
    if let Some(row) =
        heights_m.iter().position(|row| row.len() != columns || row.iter().any(|h| !h.is_finite()))
    {
        let what = format!("there are not {columns} finite heights, as the first row has");
        let remedy = "write as many heights in every row";
        return Err(GeometryError::Line { line: row + 1, what, remedy });
    }
    let [y, z] = extents_m.map(|extent| size("an extent of a height field", extent));
    // Column by column, as Parry stores it; Parry's rows run along z, its columns along x, and its heights
    // along y.
    let data = (0..columns).flat_map(|column| heights_m.iter().map(move |row| row[column])).collect();
    let shape = SharedShape::heightfield(Array2::new(rows, columns, data), Vector::new(y?, 1.0, z?));
    // A quarter turn about z takes Parry's x to y, and its y, the height, to -x.
    Ok((shape, Pose::from_rotation(Rotation::from_rotation_z(std::f64::consts::FRAC_PI_2))))
}
