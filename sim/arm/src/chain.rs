//! A serial chain of joints, and the positions of its parts at a pose.

use nalgebra::{Isometry3, Matrix3, Point3, Unit, Vector3};

use crate::error::ArmError;

/// Motion of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Turns between limits.
    Revolute,
    /// Turns without limits.
    Continuous,
    /// Slides.
    Prismatic,
}

/// Mass, centre and inertia of the bodies that a joint moves as one.
#[derive(Clone, Debug, PartialEq)]
pub struct Inertial {
    pub mass_kg: f64,
    /// Centre of mass in the joint's frame, m.
    pub centre_m: Vector3<f64>,
    /// Inertia about the centre of mass, in the joint's axes, kg m².
    pub inertia_kg_m2: Matrix3<f64>,
}

impl Inertial {
    /// No mass and no inertia.
    pub fn none() -> Self {
        Self { mass_kg: 0.0, centre_m: Vector3::zeros(), inertia_kg_m2: Matrix3::zeros() }
    }

    /// Adds another body, given in a frame at `place` in this one.
    pub fn add(&mut self, other: &Self, place: &Isometry3<f64>) {
        let rotation = place.rotation.to_rotation_matrix();
        let centre = place * Point3::from(other.centre_m);
        let total = self.mass_kg + other.mass_kg;
        let joint = if total > 0.0 {
            (self.centre_m * self.mass_kg + centre.coords * other.mass_kg) / total
        } else {
            Vector3::zeros()
        };
        let turned = rotation * other.inertia_kg_m2 * rotation.transpose();
        self.inertia_kg_m2 += steiner(self.mass_kg, &(self.centre_m - joint))
            + turned
            + steiner(other.mass_kg, &(centre.coords - joint));
        (self.mass_kg, self.centre_m) = (total, joint);
    }
}

/// Inertia of a point mass at an offset.
fn steiner(mass: f64, r: &Vector3<f64>) -> Matrix3<f64> {
    mass * (Matrix3::identity() * r.norm_squared() - r * r.transpose())
}

/// A joint, and the bodies that it moves up to the next one.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    pub name: String,
    /// The name of the link that it moves.
    pub link: String,
    /// Whether it turns or slides.
    pub kind: JointKind,
    /// Its frame in that of the previous joint, at position zero.
    pub place: Isometry3<f64>,
    /// Its axis, in its own frame.
    pub axis: Unit<Vector3<f64>>,
    /// Smallest and largest position, rad or m; infinite without limits.
    pub limits: [f64; 2],
    /// Largest effort, N m or N, if known.
    pub effort_limit: Option<f64>,
    /// Viscous friction, N m s/rad or N s/m.
    pub viscous_friction: f64,
    /// Dry friction, N m or N.
    pub dry_friction: f64,
    /// The bodies that it moves as one.
    pub inertial: Inertial,
}

/// A serial arm.
#[derive(Clone, Debug, PartialEq)]
pub struct Chain {
    pub name: String,
    /// Joints from the base onwards; at least one.
    pub joints: Vec<Joint>,
    /// The tool in the frame of the last joint.
    pub tool: Isometry3<f64>,
    /// Acceleration of free fall in the base's frame, m/s².
    pub gravity_m_per_s2: Vector3<f64>,
}

impl Chain {
    /// Number of joints.
    pub fn joints(&self) -> usize {
        self.joints.len()
    }

    /// Checks the number of joint positions and their limits.
    ///
    /// # Errors
    /// [`ArmError::Pose`], [`ArmError::Limit`].
    pub fn check_pose(&self, q: &[f64]) -> Result<(), ArmError> {
        if q.len() != self.joints.len() {
            let names: Vec<&str> = self.joints.iter().map(|joint| joint.name.as_str()).collect();
            return Err(ArmError::Pose {
                given: q.len(),
                needed: self.joints.len(),
                names: names.join(", "),
            });
        }
        for (joint, &position) in self.joints.iter().zip(q) {
            let [lower, upper] = joint.limits;
            if !(lower..=upper).contains(&position) {
                return Err(ArmError::Limit { joint: joint.name.clone(), position, lower, upper });
            }
        }
        Ok(())
    }

    /// Pose of the tool in the base's frame.
    pub fn tool_place(&self, q: &[f64]) -> Isometry3<f64> {
        self.posture(q).tool()
    }

    /// Frames of all joints in the base's frame, and last that of the tool: the arm's skeleton.
    pub fn skeleton(&self, q: &[f64]) -> Vec<Isometry3<f64>> {
        self.posture(q).skeleton()
    }

    /// Velocity of the tool (three rows of m/s, then three of rad/s, in the base's frame) per joint speed.
    pub fn jacobian(&self, q: &[f64]) -> nalgebra::DMatrix<f64> {
        self.posture(q).jacobian()
    }
}
