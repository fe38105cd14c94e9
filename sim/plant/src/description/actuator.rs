//! Drives.

use crate::effects::EffectUse;

/// A drive: a force on one body and its reaction on another.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// The body that is pushed towards +x by a positive force.
    pub on: String,
    /// The body that carries the reaction.
    pub reacts_on: String,
    /// How a command becomes a force.
    pub kind: ActuatorKind,
    /// Effort limit, > 0; none where absent.
    pub limit_n: Option<f64>,
    /// Largest rate of the effort, > 0 (N/s; of the commanded velocity, m/s², for a velocity source).
    pub rate_limit_per_s: Option<f64>,
    /// Departures from the ideal drive.
    pub effects: Vec<EffectUse>,
}

impl Actuator {
    /// A drive whose force is its command, at once and without limit.
    pub fn ideal(on: impl Into<String>, reacts_on: impl Into<String>) -> Self {
        Self {
            on: on.into(),
            reacts_on: reacts_on.into(),
            kind: ActuatorKind::Force { bandwidth_hz: None },
            limit_n: None,
            rate_limit_per_s: None,
            effects: Vec::new(),
        }
    }
}

/// How a command becomes a force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ActuatorKind {
    /// A high-bandwidth current amplifier: the command is the force (N).
    Force {
        /// First-order bandwidth of the current loop, where it matters.
        bandwidth_hz: Option<f64>,
    },
    /// The paper's Fig. 2, a voltage amplifier: the command is a velocity `v_c`, and
    /// `tau df_a/dt + f_a = b_a (v_c - v)`.
    VelocitySource {
        /// `b_a`, force per velocity error.
        damping_n_s_per_m: f64,
        /// `tau`, > 0.
        time_constant_s: f64,
    },
}
