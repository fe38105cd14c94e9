//! Distance of a capsule from triangles, in closed form.
//!
//! Parry measures a capsule against each triangle by iteration. This gives the same result to machine
//! precision at a small part of the cost, if the capsule's axis is outside the surface.

use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{Segment, SharedShape, Triangle};

/// The nearest points of a capsule's axis and a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    pub(crate) on_axis: Vector,
    pub(crate) on_surface: Vector,
    pub(crate) distance_m: f64,
}

/// The nearest points of an axis and the triangles of a mesh or height field at a pose within `reach_m`. It
/// is an error if the axis crosses the surface, since it then has no distance.
pub(crate) fn nearest(
    axis: &Segment,
    shape: &SharedShape,
    pose: &Pose,
    reach_m: f64,
) -> Result<Option<Near>, Crosses> {
    let inverse = pose.inverse();
    let (a, b) = (inverse.transform_point(axis.a), inverse.transform_point(axis.b));
    let room = Vector::splat(reach_m);
    let around = Aabb::new(a.min(b) - room, a.max(b) + room);
    let mut best: Option<Near> = None;
    let mut crosses = false;
    let mut take = |triangle: &Triangle| match near(a, b, triangle) {
        None => crosses = true,
        Some(found)
            if found.distance_m <= reach_m && best.is_none_or(|best| found.distance_m < best.distance_m) =>
        {
            best = Some(found);
        }
        Some(_) => {}
    };
    if let Some(mesh) = shape.as_trimesh() {
        mesh.bvh().intersect_aabb(&around).for_each(|i| take(&mesh.triangle(i)));
    } else if let Some(field) = shape.as_heightfield() {
        field.map_elements_in_local_aabb(&around, &mut |_, triangle| take(triangle));
    }
    if crosses {
        return Err(Crosses);
    }
    Ok(best.map(|near| Near {
        on_axis: pose.transform_point(near.on_axis),
        on_surface: pose.transform_point(near.on_surface),
        distance_m: near.distance_m,
    }))
}

/// The axis crosses the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crosses;

/// The nearest points of a segment from `a` to `b` and a triangle. Either an end of the segment is nearest to
/// the face, or the segment is nearest to an edge. `None` if the segment crosses the face.
fn near(a: Vector, b: Vector, triangle: &Triangle) -> Option<Near> {
    let square = (triangle.b - triangle.a).cross(triangle.c - triangle.a);
    let heights = [a, b].map(|end| square.dot(end - triangle.a));
    if heights[0] * heights[1] < 0.0 {
        let at = a + (b - a) * (heights[0] / (heights[0] - heights[1]));
        let inside = |p: Vector, q: Vector| (q - p).cross(at - p).dot(square) >= 0.0;
        if inside(triangle.a, triangle.b) && inside(triangle.b, triangle.c) && inside(triangle.c, triangle.a)
        {
            return None;
        }
    }
    let over_face = [a, b].map(|end| (end, triangle.project_local_point(end, false).point));
    let over_edges = [(triangle.a, triangle.b), (triangle.b, triangle.c), (triangle.c, triangle.a)]
        .map(|edge| between_lines((a, b), edge));
    let pairs = over_face.into_iter().chain(over_edges);
    let found = pairs.map(|(on_axis, on_surface)| Near {
        on_axis,
        on_surface,
        distance_m: (on_surface - on_axis).length(),
    });
    found.min_by(|one, other| one.distance_m.total_cmp(&other.distance_m))
}

/// The nearest points of two segments (C. Ericson, "Real-Time Collision Detection", 2005, sec. 5.1.9).
fn between_lines((a, b): (Vector, Vector), (c, d): (Vector, Vector)) -> (Vector, Vector) {
    let (along, other, apart) = (b - a, d - c, a - c);
    let (aa, ee, f) = (along.dot(along), other.dot(other), other.dot(apart));
    let share = |x: f64| if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.0 };
    let (g, h) = (along.dot(apart), along.dot(other));
    let spread = aa * ee - h * h;
    let mut s = if spread > 0.0 { share((h * f - g * ee) / spread) } else { 0.0 };
    let t = (h * s + f) / ee;
    let on_other = share(t);
    if (on_other - t).abs() > 0.0 {
        s = share((h * on_other - g) / aa);
    }
    (a + along * s, c + other * on_other)
}
