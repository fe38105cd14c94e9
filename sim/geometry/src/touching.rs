//! The place where tip and workpiece touch.

use parry3d_f64::math::Vector;
use parry3d_f64::query::{ShapeCastOptions, cast_shapes, contact};

use crate::error::GeometryError;
use crate::pair::Pair;
use crate::shape::{Placement, Shape};
use crate::swept_ball::{SweptBall, is_triangles, with_faces};

/// Distance of the tip's start from the workpiece, over the size of both.
const ROOM: f64 = 0.1;
/// Newton steps after the cast, which is already close; each doubles the digits on smooth surfaces.
const POLISHING_STEPS: usize = 12;
/// Largest correction by polishing, over the size of both. Parry's casts end closer than this; a larger step
/// would reach another point of the surface.
const NEAR: f64 = 1e-3;
/// Rounding of positions, over the size of both.
const ROUNDING: f64 = 1e-15;
/// Jumps of Parry's iteration on convex hulls with thin faces, over the size of both: 2.6 um of 0.16 m
/// occurred.
const ROUGH: f64 = 3e-5;
/// Component of the normal along the axis below which the tip slides along a wall.
const GRAZING: f64 = 1e-6;

/// A tip that travels along x, and a workpiece.
#[derive(Clone, Debug)]
pub struct Touching {
    pair: Pair,
    /// Start of the cast, its largest length, and the size of both shapes, m.
    start_m: f64,
    reach_m: f64,
    size_m: f64,
}

/// A touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Travel of the tip along x from its place until it touches.
    pub travel_m: f64,
    /// The point where it touches.
    pub point_m: [f64; 3],
    /// Unit vector from the tip into the workpiece.
    pub normal: [f64; 3],
    /// Change of the travel per length of lateral motion in y and z; infinite at a wall.
    pub slope: [f64; 2],
}

impl Touching {
    /// A tip whose body is at x = 0, with its shape at a place relative to that body, and a workpiece at its
    /// place.
    ///
    /// # Errors
    /// Those of the shapes' numbers.
    pub fn new(
        tip: &Shape,
        tip_place: &Placement,
        workpiece: &Shape,
        workpiece_place: &Placement,
    ) -> Result<Self, GeometryError> {
        let mut pair = Pair::new(tip, tip_place, workpiece, workpiece_place)?;
        let tip_box = pair.tip.compute_aabb(&pair.tip_pose);
        let work_box = pair.workpiece.compute_aabb(&pair.workpiece_pose);
        let size_m = tip_box.extents().length() + work_box.extents().length();
        if pair.tip.as_ball().is_some() {
            pair.workpiece = with_faces(pair.workpiece);
        }
        let start_m = work_box.mins.x - tip_box.maxs.x - ROOM * size_m;
        Ok(Self { pair, start_m, reach_m: work_box.maxs.x - tip_box.mins.x - start_m, size_m })
    }

    /// The touch with the tip moved sideways by `[y, z]`.
    ///
    /// # Errors
    /// [`GeometryError::Unreachable`] if the tip passes the workpiece, [`GeometryError::Unsupported`] for two
    /// shapes whose distance cannot be computed.
    pub fn at(&self, lateral_m: [f64; 2]) -> Result<Touch, GeometryError> {
        let [y_m, z_m] = lateral_m;
        if let Some(ball) = self.pair.tip.as_ball().filter(|_| is_triangles(&self.pair.workpiece)) {
            let centre = self.pair.tip_pose.translation + Vector::new(self.start_m, y_m, z_m);
            let swept = SweptBall { centre, along: Vector::X, radius_m: ball.radius };
            let touch = swept
                .first_touch(&self.pair.workpiece, &self.pair.workpiece_pose, self.reach_m)
                .ok_or(GeometryError::Unreachable { y_m, z_m, t_s: None })?;
            let normal = (touch.point - centre - Vector::X * touch.travel_m) / ball.radius;
            return Ok(Self::touch(self.start_m + touch.travel_m, touch.point, normal));
        }
        let placed = |x: f64| self.pair.tip_pose.append_translation(Vector::new(x, y_m, z_m));
        let options = ShapeCastOptions {
            max_time_of_impact: self.reach_m,
            stop_at_penetration: false,
            ..ShapeCastOptions::default()
        };
        let begin = placed(self.start_m);
        let hit = cast_shapes(
            &begin,
            Vector::X,
            self.pair.tip.as_ref(),
            &self.pair.workpiece_pose,
            Vector::ZERO,
            self.pair.workpiece.as_ref(),
            options,
        )
        .map_err(|_| self.pair.unsupported())?
        .ok_or(GeometryError::Unreachable { y_m, z_m, t_s: None })?;
        let cast_m = self.start_m + hit.time_of_impact;
        let mut travel_m = cast_m;
        let mut normal = begin.rotation * hit.normal1;
        let mut point =
            begin.append_translation(Vector::X * hit.time_of_impact).transform_point(hit.witness1);
        for _ in 0..POLISHING_STEPS {
            let nearest = contact(
                &placed(travel_m),
                self.pair.tip.as_ref(),
                &self.pair.workpiece_pose,
                self.pair.workpiece.as_ref(),
                NEAR * self.size_m,
            )
            .map_err(|_| self.pair.unsupported())?;
            let Some(nearest) = nearest.filter(|nearest| nearest.normal1.x > GRAZING) else { break };
            // Each step along x reduces the distance by the normal's component.
            let next_m = travel_m + nearest.dist / nearest.normal1.x;
            if (next_m - cast_m).abs() > NEAR * self.size_m {
                break;
            }
            (normal, point) = (nearest.normal1, nearest.point1);
            let moved_m = (next_m - travel_m).abs();
            travel_m = next_m;
            if moved_m <= ROUNDING * self.size_m {
                break;
            }
        }
        Ok(Self::touch(travel_m, point, normal))
    }

    /// Largest jump of the travel that may come from Parry's iteration, m.
    pub(crate) fn roughness_m(&self) -> f64 {
        let is_exact = self.pair.tip.as_ball().is_some() && is_triangles(&self.pair.workpiece);
        if is_exact { 0.0 } else { ROUGH * self.size_m }
    }

    fn touch(travel_m: f64, point: Vector, normal: Vector) -> Touch {
        // While in touch, the tip's path has no component along the normal.
        let slope = [normal.y, normal.z]
            .map(|n| if normal.x > GRAZING { -n / normal.x } else { f64::INFINITY.copysign(-n) });
        Touch { travel_m, point_m: point.to_array(), normal: normal.to_array(), slope }
    }
}
