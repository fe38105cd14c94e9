//! Distance of a tip from a workpiece, for a tip that moves anywhere in space.

use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::{Pose, Rotation, Vector};
use parry3d_f64::query::{Ray, RayCast, ShapeCastOptions, cast_shapes, contact};
use parry3d_f64::shape::{Segment, SharedShape};

use crate::capsule::{self, Near};
use crate::error::GeometryError;
use crate::shape::{Placement, Shape};
use crate::swept_ball::{SweptBall, is_triangles};

/// Largest distance at which shapes other than balls are measured, over the size of the tip. Beyond it they
/// are only known to be farther apart.
const REACH: f64 = 0.05;

/// Largest distance of a ball's centre from the surface at which it counts as on it, over its radius.
const ON_THE_SURFACE: f64 = 1e-12;

/// A direction in which a ray hardly ever meets an edge.
const OBLIQUE: [f64; 3] = [0.412_943_1, 0.527_181_7, 0.742_839_3];

/// A tip on a tool, and a fixed workpiece.
#[derive(Clone)]
pub struct Pair {
    pub(crate) tip: SharedShape,
    /// Pose of the tip's shape in the frame of the tool.
    pub(crate) tip_pose: Pose,
    pub(crate) workpiece: SharedShape,
    pub(crate) workpiece_pose: Pose,
    names: [&'static str; 2],
    reach_m: f64,
}

/// Nearest points of two shapes, or the deepest if they overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Distance; negative if they overlap.
    pub distance_m: f64,
    /// The point of the workpiece.
    pub point_m: [f64; 3],
    /// Unit vector from the tip into the workpiece.
    pub normal: [f64; 3],
}

impl std::fmt::Debug for Pair {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Pair").field("shapes", &self.names).finish_non_exhaustive()
    }
}

/// A pose from a position, m, and a unit quaternion `[x, y, z, w]`.
fn pose_of(position_m: [f64; 3], quaternion: [f64; 4]) -> Pose {
    Pose::from_parts(Vector::from_array(position_m), Rotation::from_array(quaternion))
}

impl Pair {
    /// A tip with its shape at a place of the tool's frame, and a workpiece at its place.
    ///
    /// # Errors
    /// Those of the shapes' numbers.
    pub fn new(
        tip: &Shape,
        tip_place: &Placement,
        workpiece: &Shape,
        workpiece_place: &Placement,
    ) -> Result<Self, GeometryError> {
        let ((tip_shape, tip_frame), (work_shape, work_frame)) = (tip.build()?, workpiece.build()?);
        let size_m = tip_shape.compute_local_aabb().extents().length();
        Ok(Self {
            tip: tip_shape,
            tip_pose: tip_place.pose() * tip_frame,
            workpiece: work_shape,
            workpiece_pose: workpiece_place.pose() * work_frame,
            names: [tip.name(), workpiece.name()],
            reach_m: REACH * size_m,
        })
    }

    pub(crate) fn unsupported(&self) -> GeometryError {
        GeometryError::Unsupported { tip: self.names[0], workpiece: self.names[1] }
    }

    /// The nearest points with the tool at a position, m, and orientation, a unit quaternion `[x, y, z, w]`.
    /// `None` if they are far apart.
    ///
    /// For a ball it is the projection of its centre, and for a capsule on triangles that of its axis. It is
    /// exact to machine precision if centre or axis is outside. For other tips it comes from Parry's
    /// iteration. If shapes touch in several places it is the deepest.
    ///
    /// # Errors
    /// [`GeometryError::Unsupported`] for two shapes whose distance cannot be computed.
    pub fn nearest(
        &self,
        position_m: [f64; 3],
        quaternion: [f64; 4],
    ) -> Result<Option<Nearest>, GeometryError> {
        let at = pose_of(position_m, quaternion) * self.tip_pose;
        // A ball with its centre on the surface has no direction to it; the iteration handles this case.
        if let Some(ball) = self.tip.as_ball()
            && let Some(nearest) = self.nearest_to_ball(at.translation, ball.radius)
        {
            return Ok(Some(nearest));
        }
        if let Some(capsule) = self.tip.as_capsule().filter(|_| is_triangles(&self.workpiece)) {
            let axis =
                Segment::new(at.transform_point(capsule.segment.a), at.transform_point(capsule.segment.b));
            // An axis that crosses the surface has no direction to it either.
            if let Ok(near) =
                capsule::nearest(&axis, &self.workpiece, &self.workpiece_pose, capsule.radius + self.reach_m)
            {
                return Ok(near.map(|near| of_axis(&near, capsule.radius)));
            }
        }
        let found =
            contact(&at, self.tip.as_ref(), &self.workpiece_pose, self.workpiece.as_ref(), self.reach_m)
                .map_err(|_| self.unsupported())?;
        Ok(found.map(|found| Nearest {
            distance_m: found.dist,
            point_m: found.point2.to_array(),
            normal: found.normal1.to_array(),
        }))
    }

    fn nearest_to_ball(&self, centre: Vector, radius: f64) -> Option<Nearest> {
        let found = self.workpiece.project_point(&self.workpiece_pose, centre, false);
        let way = found.point - centre;
        let distance = way.length();
        if distance <= ON_THE_SURFACE * radius {
            return None;
        }
        let (signed, normal) =
            if found.is_inside { (-distance, -way / distance) } else { (distance, way / distance) };
        Some(Nearest {
            distance_m: signed - radius,
            point_m: found.point.to_array(),
            normal: normal.to_array(),
        })
    }

    /// Depth of the tip's centre inside a workpiece that is a closed mesh, m. `None` if it is not inside, or
    /// the workpiece is not a mesh. [`Self::nearest`] treats a mesh as a surface, without inside and outside.
    pub fn buried_m(&self, position_m: [f64; 3], quaternion: [f64; 4]) -> Option<f64> {
        let mesh = self.workpiece.as_trimesh()?;
        let middle = (pose_of(position_m, quaternion) * self.tip_pose)
            .transform_point(self.tip.compute_local_aabb().center());
        let local = self.workpiece_pose.inverse().transform_point(middle);
        let reach = mesh.local_aabb().extents().length() + (local - mesh.local_aabb().center()).length();
        // From inside a closed surface every ray crosses it an odd number of times.
        let crossings = |along: Vector| {
            let end = local + along * reach;
            let swept = Aabb::new(local.min(end), local.max(end));
            let ray = Ray::new(local, along);
            mesh.bvh()
                .intersect_aabb(&swept)
                .filter(|&i| mesh.triangle(i).cast_local_ray(&ray, reach, true).is_some())
                .count()
        };
        let inside = [OBLIQUE, OBLIQUE.map(|x| -x)]
            .into_iter()
            .all(|along| crossings(Vector::from_array(along).normalize()) % 2 == 1);
        inside.then(|| {
            (self.workpiece.project_point(&self.workpiece_pose, middle, false).point - middle).length()
        })
    }

    /// How far the tip can travel along a direction until it touches, m; `None` if it does not touch within
    /// `reach_m`.
    ///
    /// # Errors
    /// [`GeometryError::Unsupported`] for two shapes whose distance cannot be computed.
    pub fn travel_m(
        &self,
        position_m: [f64; 3],
        quaternion: [f64; 4],
        along: [f64; 3],
        reach_m: f64,
    ) -> Result<Option<f64>, GeometryError> {
        let at = pose_of(position_m, quaternion) * self.tip_pose;
        let along = Vector::from_array(along);
        if let Some(ball) = self.tip.as_ball().filter(|_| is_triangles(&self.workpiece)) {
            let swept = SweptBall { centre: at.translation, along, radius_m: ball.radius };
            return Ok(swept
                .first_touch(&self.workpiece, &self.workpiece_pose, reach_m)
                .map(|touch| touch.travel_m));
        }
        let options = ShapeCastOptions { max_time_of_impact: reach_m, ..ShapeCastOptions::default() };
        let hit = cast_shapes(
            &at,
            along,
            self.tip.as_ref(),
            &self.workpiece_pose,
            Vector::ZERO,
            self.workpiece.as_ref(),
            options,
        );
        Ok(hit.map_err(|_| self.unsupported())?.map(|hit| hit.time_of_impact))
    }
}

/// The nearest point of a capsule, from that of its axis.
fn of_axis(near: &Near, radius: f64) -> Nearest {
    let normal = (near.on_surface - near.on_axis) / near.distance_m;
    Nearest {
        distance_m: near.distance_m - radius,
        point_m: near.on_surface.to_array(),
        normal: normal.to_array(),
    }
}

/// Overlap of two shapes at their poses, m; zero or negative if they do not overlap.
///
/// # Errors
/// Those of the shapes' numbers, and [`GeometryError::Unsupported`].
pub fn overlap_m(
    a: (&Shape, [f64; 3], [f64; 4]),
    b: (&Shape, [f64; 3], [f64; 4]),
) -> Result<f64, GeometryError> {
    let ((first, first_frame), (second, second_frame)) = (a.0.build()?, b.0.build()?);
    let (one, two) = (pose_of(a.1, a.2) * first_frame, pose_of(b.1, b.2) * second_frame);
    let found = contact(&one, first.as_ref(), &two, second.as_ref(), 0.0);
    let found = found.map_err(|_| GeometryError::Unsupported { tip: a.0.name(), workpiece: b.0.name() })?;
    Ok(found.map_or(0.0, |found| -found.dist))
}
