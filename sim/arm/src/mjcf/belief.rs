//! Parameters of a joint as the author of a model believes them.

/// The author's parameters of a joint and of the loop that drives it; SI.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointBelief {
    pub name: String,
    /// The link that it moves.
    pub link: String,
    /// Inertia (or mass) of rotor and gear, as seen at the joint.
    pub armature: f64,
    /// Viscous friction.
    pub damping: f64,
    pub friction: f64,
    /// Effort per position error of its position actuator.
    pub kp: Option<f64>,
    /// Effort per speed of that actuator.
    pub kd: f64,
    pub effort_limit: Option<f64>,
    /// Delay of a command, s.
    pub delay_s: f64,
}
