//! The path of a ball into triangles, in closed form.
//!
//! Parry casts a ball against a triangle by iteration. This gives the same result to machine precision at a
//! hundredth of the cost, for the most frequent tip.

use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::shape::{SharedShape, Triangle};

/// A ball that moves along a line.
pub(crate) struct SweptBall {
    /// Centre at the start.
    pub(crate) centre: Vector,
    /// Unit vector of its motion.
    pub(crate) along: Vector,
    pub(crate) radius_m: f64,
}

/// The first touch on the path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BallTouch {
    /// Path of the ball until the touch, m.
    pub(crate) travel_m: f64,
    /// The point where it touches.
    pub(crate) point: Vector,
}

/// Whether a shape consists of triangles that [`SweptBall::first_touch`] can use.
pub(crate) fn is_triangles(shape: &SharedShape) -> bool {
    shape.as_trimesh().is_some() || shape.as_heightfield().is_some()
}

/// The faces of a convex hull as triangles; other shapes unchanged. Parry's iteration on hulls with thin
/// faces jumps by up to about 1e-5 of their size.
pub(crate) fn with_faces(shape: SharedShape) -> SharedShape {
    let Some(hull) = shape.as_convex_polyhedron() else { return shape };
    let (corners, triangles) = hull.to_trimesh();
    SharedShape::trimesh(corners, triangles).unwrap_or(shape)
}

impl SweptBall {
    /// The first touch with the triangles of a mesh or height field at a pose, within `reach_m`.
    pub(crate) fn first_touch(&self, shape: &SharedShape, pose: &Pose, reach_m: f64) -> Option<BallTouch> {
        let inverse = pose.inverse();
        let local = Self {
            centre: inverse.transform_point(self.centre),
            along: inverse.rotation * self.along,
            radius_m: self.radius_m,
        };
        let end = local.centre + local.along * reach_m;
        let room = Vector::splat(self.radius_m);
        let swept = Aabb::new(local.centre.min(end) - room, local.centre.max(end) + room);
        let mut first: Option<BallTouch> = None;
        let mut take = |triangle: &Triangle| {
            for touch in local.touches(triangle).into_iter().flatten() {
                let ahead = (0.0..=reach_m).contains(&touch.travel_m);
                if ahead && first.is_none_or(|best| touch.travel_m < best.travel_m) {
                    first = Some(touch);
                }
            }
        };
        if let Some(mesh) = shape.as_trimesh() {
            mesh.bvh().intersect_aabb(&swept).for_each(|i| take(&mesh.triangle(i)));
        } else if let Some(field) = shape.as_heightfield() {
            field.map_elements_in_local_aabb(&swept, &mut |_, triangle| take(triangle));
        }
        first.map(|touch| BallTouch { point: pose.transform_point(touch.point), ..touch })
    }

    /// First touches with the face, the edges and the corners of a triangle.
    fn touches(&self, triangle: &Triangle) -> [Option<BallTouch>; 7] {
        let Triangle { a, b, c } = *triangle;
        [
            self.face(a, b, c),
            self.edge(a, b),
            self.edge(b, c),
            self.edge(c, a),
            self.corner(a),
            self.corner(b),
            self.corner(c),
        ]
    }

    fn face(&self, a: Vector, b: Vector, c: Vector) -> Option<BallTouch> {
        let across = (b - a).cross(c - a);
        let area = across.length();
        // The normal against which the ball moves.
        let normal = if across.dot(self.along) > 0.0 { across / area } else { -across / area };
        let speed = normal.dot(self.along);
        if speed.is_nan() || speed <= 0.0 {
            return None;
        }
        let travel_m = ((a - self.centre).dot(normal) - self.radius_m) / speed;
        let point = self.centre + self.along * travel_m + normal * self.radius_m;
        let inside = |p: Vector, q: Vector| (q - p).cross(point - p).dot(across) >= 0.0;
        (inside(a, b) && inside(b, c) && inside(c, a)).then_some(BallTouch { travel_m, point })
    }

    fn edge(&self, a: Vector, b: Vector) -> Option<BallTouch> {
        let length = (b - a).length();
        let axis = (b - a) / length;
        let square_to = |v: Vector| v - axis * v.dot(axis);
        let (way, start) = (square_to(self.along), square_to(self.centre - a));
        // |start + travel way| = radius, the first of the two solutions.
        let travel_m =
            first_root(way.dot(way), start.dot(way), start.dot(start) - self.radius_m * self.radius_m)?;
        let share = (self.centre + self.along * travel_m - a).dot(axis);
        (0.0..=length).contains(&share).then(|| BallTouch { travel_m, point: a + axis * share })
    }

    fn corner(&self, a: Vector) -> Option<BallTouch> {
        let start = self.centre - a;
        let travel_m =
            first_root(1.0, start.dot(self.along), start.dot(start) - self.radius_m * self.radius_m)?;
        Some(BallTouch { travel_m, point: a })
    }
}

/// The smaller root of `a t^2 + 2 b t + c`.
fn first_root(a: f64, b: f64, c: f64) -> Option<f64> {
    let discriminant = b * b - a * c;
    (discriminant >= 0.0 && a > 0.0).then(|| (-b - discriminant.sqrt()) / a)
}
