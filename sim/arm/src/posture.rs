//! A chain at a pose: the positions of its parts, computed once.

use nalgebra::{DMatrix, Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};

use crate::chain::{Chain, JointKind};

/// A chain at a pose; everything in the base's frame.
#[derive(Clone, Debug)]
pub struct Posture<'a> {
    pub(crate) chain: &'a Chain,
    pub(crate) bodies: Vec<Placed>,
    tool: Isometry3<f64>,
}

/// A joint, and the bodies that it moves.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    pub(crate) frame: Isometry3<f64>,
    pub(crate) axis: Vector3<f64>,
    /// From the joint's origin to the centre of mass.
    pub(crate) centre: Vector3<f64>,
    /// About the centre of mass.
    pub(crate) inertia: Matrix3<f64>,
}

impl Chain {
    /// The chain at joint positions, rad or m.
    pub fn posture(&self, q: &[f64]) -> Posture<'_> {
        let mut at = Isometry3::identity();
        let mut bodies = Vec::with_capacity(q.len());
        for (joint, &position) in self.joints.iter().zip(q) {
            at *= joint.place;
            let axis = at.rotation * joint.axis;
            match joint.kind {
                JointKind::Prismatic => at = Translation3::from(axis.into_inner() * position) * at,
                JointKind::Revolute | JointKind::Continuous => {
                    at = Isometry3::from_parts(
                        at.translation,
                        UnitQuaternion::from_axis_angle(&axis, position) * at.rotation,
                    );
                }
            }
            let rotation = at.rotation.to_rotation_matrix();
            bodies.push(Placed {
                frame: at,
                axis: axis.into_inner(),
                centre: rotation * joint.inertial.centre_m,
                inertia: rotation * joint.inertial.inertia_kg_m2 * rotation.transpose(),
            });
        }
        Posture { chain: self, bodies, tool: at * self.tool }
    }
}

impl Posture<'_> {
    /// Place and orientation of the tool.
    pub fn tool(&self) -> Isometry3<f64> {
        self.tool
    }

    /// Frames of all joints, and last that of the tool.
    pub fn skeleton(&self) -> Vec<Isometry3<f64>> {
        self.bodies.iter().map(|body| body.frame).chain([self.tool]).collect()
    }

    /// Velocity of the tool (three rows of m/s, then three of rad/s) per joint speed.
    pub fn jacobian(&self) -> DMatrix<f64> {
        let mut jacobian = DMatrix::zeros(6, self.bodies.len());
        for (i, (joint, body)) in self.chain.joints.iter().zip(&self.bodies).enumerate() {
            let (linear, angular) = match joint.kind {
                JointKind::Prismatic => (body.axis, Vector3::zeros()),
                _ => (
                    body.axis.cross(&(self.tool.translation.vector - body.frame.translation.vector)),
                    body.axis,
                ),
            };
            jacobian.fixed_view_mut::<3, 1>(0, i).copy_from(&linear);
            jacobian.fixed_view_mut::<3, 1>(3, i).copy_from(&angular);
        }
        jacobian
    }
}
