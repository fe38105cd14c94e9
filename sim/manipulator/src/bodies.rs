//! Shapes of links, and their collisions.

use feeler_arm::Chain;
use feeler_geometry::{GeometryError, Shape, overlap_m};
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};

/// Thinnest link, m.
const THINNEST: f64 = 1e-3;
/// Overlap by rounding, m.
const TOUCHING: f64 = 1e-9;

/// The shapes of the base, or of the bodies that a joint moves.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyShapes {
    /// `base`, or the name of the link.
    pub name: String,
    /// Shapes of the body, in the frame of the base or of that joint.
    pub shapes: Vec<(Shape, Isometry3<f64>)>,
    /// Half the thickness of a body without its own shapes, which is a capsule from its joint to the next;
    /// zero otherwise.
    pub radius_m: f64,
}

/// Capsules from each joint to the next, for links without known shapes, the base first. Each is as thick as
/// the cylinder with the link's mass and smallest moment of inertia; the base is as thick as the first link.
pub fn link_capsules(chain: &Chain) -> Vec<BodyShapes> {
    let radius = |i: usize| {
        let inertial = &chain.joints[i].inertial;
        let least = inertial.inertia_kg_m2.symmetric_eigenvalues().min();
        (2.0 * least / inertial.mass_kg).sqrt().max(THINNEST)
    };
    let body = |i: usize| {
        // Body 0 is the base, body i is moved by joint i - 1.
        let next = chain.joints.get(i).map_or(chain.tool, |joint| joint.place).translation.vector;
        let radius_m = if i == 0 { radius(0) } else { radius(i - 1) };
        let name = if i == 0 { "base".to_owned() } else { chain.joints[i - 1].link.clone() };
        BodyShapes { name, shapes: vec![capsule(next, radius_m)], radius_m }
    };
    (0..=chain.joints()).map(body).collect()
}

/// A capsule from a frame's origin to one of its points; a ball if the two coincide.
fn capsule(end: Vector3<f64>, radius_m: f64) -> (Shape, Isometry3<f64>) {
    let length = end.norm();
    if length < THINNEST {
        return (Shape::Ball { radius_m }, Isometry3::identity());
    }
    let turn = UnitQuaternion::rotation_between(&Vector3::y(), &end)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    (
        Shape::Capsule { half_length_m: 0.5 * length, radius_m },
        Isometry3::from_parts((0.5 * end).into(), turn),
    )
}

/// The first two bodies of an arm that overlap at a pose, and the depth. Neighbours may overlap, since a
/// joint connects them. So may capsules whose ends are closer along the arm than their thickness; these
/// overlap at every pose.
pub(crate) fn overlap(
    chain: &Chain,
    bodies: &[BodyShapes],
    pose: &[f64],
) -> Result<Option<(String, String, f64)>, GeometryError> {
    let skeleton = chain.skeleton(pose);
    let frame = |body: usize| if body == 0 { Isometry3::identity() } else { skeleton[body - 1] };
    // Length of the arm from the end of one body to the start of another.
    let between = |i: usize, j: usize| -> f64 {
        let origin = |k: usize| frame(k) * Point3::origin();
        (i + 1..j).map(|k| (origin(k + 1) - origin(k)).norm()).sum()
    };
    for i in 0..bodies.len() {
        for j in i + 2..bodies.len() {
            let (a, b) = (&bodies[i], &bodies[j]);
            let thick = a.radius_m + b.radius_m;
            if thick > 0.0 && between(i, j) <= thick {
                continue;
            }
            for (first, at) in &a.shapes {
                for (second, beside) in &b.shapes {
                    let (one, two) = (numbers(&(frame(i) * at)), numbers(&(frame(j) * beside)));
                    let depth_m = overlap_m((first, one.0, one.1), (second, two.0, two.1))?;
                    if depth_m > TOUCHING {
                        return Ok(Some((a.name.clone(), b.name.clone(), depth_m)));
                    }
                }
            }
        }
    }
    Ok(None)
}

/// Position and unit quaternion of a place.
pub(crate) fn numbers(place: &Isometry3<f64>) -> ([f64; 3], [f64; 4]) {
    let turn = place.rotation.coords;
    (place.translation.vector.into(), [turn.x, turn.y, turn.z, turn.w])
}
