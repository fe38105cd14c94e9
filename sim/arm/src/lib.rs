//! Serial arms, and the single axis that represents an arm along a contact normal.
//!
//! [`Urdf`] reads a robot description. [`Chain`] is its kinematics and rigid-body dynamics. [`Arm`] adds
//! drives: gears, rotors, flexible joints, friction. [`Arm::reduce`] finds the axis of two masses that
//! represents the arm along a direction at a pose. [`Arm::reduce_in_contact`] adds bodies where two masses
//! are not enough. [`FlexibleArm`] simulates the arm itself, for comparison. The model of the flexible joint
//! is that of M. W. Spong, "Modeling and control of elastic joint robots", J. Dyn. Sys. Meas. Control 109
//! (1987): the kinetic energy of rotors includes only their rotation about the joint axes.
//!
//! ```
//! use feeler_arm::Urdf;
//!
//! let urdf = Urdf::parse(r#"<robot name="pendulum">
//!   <link name="base"/>
//!   <link name="rod">
//!     <inertial><origin xyz="0 0 -0.5"/><mass value="2"/>
//!       <inertia ixx="0.17" iyy="0.17" izz="0.01"/></inertial>
//!   </link>
//!   <joint name="hinge" type="continuous">
//!     <parent link="base"/><child link="rod"/><axis xyz="0 1 0"/>
//!   </joint>
//! </robot>"#)?;
//! let chain = urdf.chain("rod")?;
//! // I + m l^2
//! assert!((chain.mass_matrix(&[0.3])[(0, 0)] - 0.67).abs() < 1e-12);
//! # Ok::<(), feeler_arm::ArmError>(())
//! ```

mod agreement;
mod between;
mod branch;
mod branches;
mod chain;
mod collision;
mod dynamics;
mod error;
mod fit;
mod flexible;
mod flexible_arm;
mod inverse_kinematics;
mod linear_system;
mod measure;
mod mjcf;
mod posture;
mod reduce;
mod sampled;
mod urdf;
mod xml;

pub use agreement::{Agreement, Landmark};
pub use branch::Branch;
pub use chain::{Chain, Inertial, Joint, JointKind};
pub use collision::{Collision, CollisionShape};
pub use error::ArmError;
pub use flexible::{Arm, JointDrive, Others};
pub use flexible_arm::{FlexibleArm, Wall};
pub use inverse_kinematics::{Target, inverse_kinematics, usual_starts};
pub use linear_system::ArmMode;
pub use measure::MeasuredArm;
pub use mjcf::{JointBelief, Mjcf};
pub use posture::Posture;
pub use reduce::Reduction;
pub use sampled::PERIOD_S;
pub use urdf::{MeshFile, ShortInertia, Urdf};
