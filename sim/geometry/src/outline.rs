//! Outlines of shapes as lines, for drawings.

use std::collections::HashMap;
use std::f64::consts::TAU;

use parry3d_f64::math::{Pose, Vector};

use crate::error::GeometryError;
use crate::shape::{Placement, Shape};

/// Straight pieces of a circle.
const PIECES: usize = 48;
/// Largest number of lines of a shape; beyond it only the sharper edges are drawn.
const MOST_LINES: usize = 3000;
/// Cosine of the angle between two faces beyond which their edge is sharp.
const SHARP: f64 = 0.94;
/// Cosine of the angle between two faces up to which they count as one plane.
const FLAT: f64 = 1.0 - 1e-9;
/// Lines of a height field in either direction.
const MOST_FIELD_LINES: usize = 24;

type Segment = [[f64; 3]; 2];

impl Shape {
    /// Lines that show the shape at a place, m.
    ///
    /// # Errors
    /// Those of the shape's numbers.
    pub fn outline(&self, place: &Placement) -> Result<Vec<Segment>, GeometryError> {
        let (built, frame) = self.build()?;
        let pose = place.pose();
        let lines = match self {
            Self::Ball { radius_m } => [[0, 1], [1, 2], [2, 0]]
                .into_iter()
                .flat_map(|plane| circle(plane, *radius_m, [0.0; 3]))
                .collect(),
            Self::Capsule { half_length_m, radius_m } => {
                let mut lines = round(*half_length_m, *radius_m);
                for end in [-half_length_m, *half_length_m] {
                    let half = |segment: &Segment| {
                        (segment[0][1] - end) * end >= 0.0 && (segment[1][1] - end) * end >= 0.0
                    };
                    lines.extend(
                        [[0, 1], [1, 2]]
                            .into_iter()
                            .flat_map(|plane| circle(plane, *radius_m, [0.0, end, 0.0]))
                            .filter(half),
                    );
                }
                lines
            }
            Self::Cylinder { half_length_m, radius_m } => round(*half_length_m, *radius_m),
            Self::Cuboid { half_extents_m } => cuboid(*half_extents_m),
            Self::Hull { .. } => match built.as_convex_polyhedron() {
                Some(hull) => {
                    let (corners, triangles) = hull.to_trimesh();
                    edges(&corners.iter().map(Vector::to_array).collect::<Vec<_>>(), &triangles)
                }
                None => Vec::new(),
            },
            Self::Mesh(mesh) => edges(&mesh.vertices_m, &mesh.triangles),
            Self::HeightField { heights_m, extents_m } => field(heights_m, *extents_m),
        };
        // Height fields are described in the frame of the shape, which differs from Parry's.
        let pose = if matches!(self, Self::HeightField { .. }) { pose } else { pose * frame };
        Ok(lines.into_iter().map(|line| line.map(|point| placed(&pose, point))).collect())
    }
}

fn placed(pose: &Pose, point: [f64; 3]) -> [f64; 3] {
    pose.transform_point(Vector::from_array(point)).to_array()
}

/// A circle in the plane of two axes.
fn circle([a, b]: [usize; 2], radius: f64, centre: [f64; 3]) -> Vec<Segment> {
    let at = |i: usize| {
        let (sin, cos) = (TAU * i as f64 / PIECES as f64).sin_cos();
        let mut point = centre;
        point[a] += radius * cos;
        point[b] += radius * sin;
        point
    };
    (0..PIECES).map(|i| [at(i), at(i + 1)]).collect()
}

/// Ends and flanks of a round shape about y.
fn round(half_length: f64, radius: f64) -> Vec<Segment> {
    let mut lines: Vec<Segment> =
        [-half_length, half_length].into_iter().flat_map(|y| circle([0, 2], radius, [0.0, y, 0.0])).collect();
    for (x, z) in [(radius, 0.0), (-radius, 0.0), (0.0, radius), (0.0, -radius)] {
        lines.push([[x, -half_length, z], [x, half_length, z]]);
    }
    lines
}

fn cuboid(half: [f64; 3]) -> Vec<Segment> {
    let corner =
        |i: usize| std::array::from_fn(|axis| if i >> axis & 1 == 1 { half[axis] } else { -half[axis] });
    (0..8)
        .flat_map(|i| {
            (0..3).filter(move |axis| i >> axis & 1 == 0).map(move |axis| [corner(i), corner(i | 1 << axis)])
        })
        .collect()
}

/// Edges of triangles, each once, without those inside a plane. If there are too many, only those between
/// faces at an angle, up to the limit.
fn edges(corners: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<Segment> {
    // Files repeat the corners of neighbours.
    let mut known: HashMap<[u64; 3], usize> = HashMap::new();
    let same: Vec<usize> = corners
        .iter()
        .enumerate()
        .map(|(i, corner)| *known.entry(corner.map(f64::to_bits)).or_insert(i))
        .collect();
    let normal = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|corner| Vector::from_array(corners[corner as usize]));
        (b - a).cross(c - a).normalize_or_zero()
    };
    let mut found: HashMap<(usize, usize), (f64, usize)> = HashMap::new();
    let mut order = Vec::new();
    let mut first: HashMap<(usize, usize), Vector> = HashMap::new();
    for triangle in triangles {
        let own = normal(triangle);
        for k in 0..3 {
            let (a, b) = (same[triangle[k] as usize], same[triangle[(k + 1) % 3] as usize]);
            let edge = (a.min(b), a.max(b));
            let entry = found.entry(edge).or_insert_with(|| {
                order.push(edge);
                first.insert(edge, own);
                (-1.0, 0)
            });
            entry.1 += 1;
            if entry.1 == 2 {
                entry.0 = first[&edge].dot(own);
            }
        }
    }
    let below = if order.len() > MOST_LINES { SHARP } else { FLAT };
    let mut kept: Vec<(usize, usize)> =
        order.into_iter().filter(|edge| found[edge].1 != 2 || found[edge].0 < below).collect();
    if kept.len() > MOST_LINES {
        let stride = kept.len().div_ceil(MOST_LINES);
        kept = kept.into_iter().step_by(stride).collect();
    }
    kept.into_iter().map(|(a, b)| [corners[a], corners[b]]).collect()
}

fn field(heights: &[Vec<f64>], extents: [f64; 2]) -> Vec<Segment> {
    let (rows, columns) = (heights.len(), heights[0].len());
    let along = |i: usize, count: usize, extent: f64| extent * (i as f64 / (count - 1) as f64 - 0.5);
    let at = |row: usize, column: usize| {
        [-heights[row][column], along(column, columns, extents[0]), along(row, rows, extents[1])]
    };
    let chosen = |count: usize| {
        let stride = count.div_ceil(MOST_FIELD_LINES).max(1);
        (0..count).filter(move |i| i % stride == 0 || i + 1 == count)
    };
    let mut lines = Vec::new();
    for row in chosen(rows) {
        lines.extend((0..columns - 1).map(|column| [at(row, column), at(row, column + 1)]));
    }
    for column in chosen(columns) {
        lines.extend((0..rows - 1).map(|row| [at(row, column), at(row + 1, column)]));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;

    #[test]
    fn truth_a_box_has_twelve_edges_and_two_triangles_share_one() {
        let place = Placement::at([1.0, 0.0, 0.0]);
        let lines = Shape::Cuboid { half_extents_m: [0.1, 0.2, 0.3] }.outline(&place).unwrap();
        let length = |line: &Segment| (0..3).map(|k| (line[0][k] - line[1][k]).powi(2)).sum::<f64>().sqrt();
        assert_eq!(lines.len(), 12);
        // Four edges along each axis.
        assert!((lines.iter().map(length).sum::<f64>() - 4.0 * 1.2).abs() < 1e-12);
        assert!(lines.iter().flatten().all(|point| (point[0] - 1.0).abs() < 0.1 + 1e-12));
        // The corners of the second triangle are written again.
        let lines = |height: f64| {
            let vertices_m = vec![
                [0.0; 3],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [1.0, 0.0, 0.0],
                [1.0, 1.0, height],
                [0.0, 1.0, 0.0],
            ];
            Shape::Mesh(Mesh { vertices_m, triangles: vec![[0, 1, 2], [3, 4, 5]] })
                .outline(&Placement::default())
                .unwrap()
                .len()
        };
        // The edge between them inside a plane is omitted.
        assert_eq!((lines(0.5), lines(0.0)), (5, 4));
    }
}
