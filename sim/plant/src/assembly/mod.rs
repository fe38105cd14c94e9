//! The machine with names resolved and effects applied: nodes, links, contacts, drives and sensors in
//! numbers.
//!
//! Effects change this description, and the equations of motion use nothing else.

mod access;
mod build;
mod drive;
mod friction;
mod laws;
mod presliding;
mod rates;
mod resolve;
mod table;

pub use build::assemble;
pub use drive::{
    Drive, Motor, Servo, ServoFeed, ServoSampling, SpeedLine, TargetChain, VelocitySource, Warming,
};
pub use friction::Friction;
pub use laws::{Bristle, PositionForce, Pull, Ripple, Weight};
pub use presliding::Presliding;
pub use resolve::resolve;
pub use table::{POINTS, TabulatedForce};

use std::sync::Arc;

use crate::description::{Engagement, LowPass, Profile, Quantity};

/// Index of a node; [`GROUND_NODE`] is the fixed body.
pub type NodeId = usize;

/// The fixed body.
pub const GROUND_NODE: NodeId = 0;

/// The whole machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Assembly {
    /// Ground first, then the bodies in the order of the file, then those that effects add.
    pub nodes: Vec<Node>,
    /// One per spring, then those that effects add.
    pub links: Vec<Link>,
    /// One per contact.
    pub contacts: Vec<ContactPart>,
    /// Forces over position that belong to no spring.
    pub weights: Vec<Weight>,
    pub drives: Vec<Drive>,
    /// One per sensor, then the encoders of sampled servos.
    pub sensors: Vec<SensorPart>,
}

/// A lumped mass.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Name of the body, or of the effect's host for an added one.
    pub name: String,
    /// Mass; infinite for ground.
    pub mass_kg: f64,
    /// Initial position.
    pub position_m: f64,
    /// Initial velocity.
    pub velocity_m_per_s: f64,
}

/// A spring, guide or joint between two nodes with elongation `e = x_b - x_a`. The force on `b` is `-(k e +
/// cubic e^3 + c (1 + asymmetry sign e') e' + drag |e'| e') + over_speed(e') + load` less friction; the force
/// on `a` is its opposite.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Name of the spring, or of the effect's host for an added one.
    pub name: String,
    /// First node.
    pub a: NodeId,
    /// Second node.
    pub b: NodeId,
    /// The two nodes move as one.
    pub rigid: bool,
    /// Stiffness `k`, N/m.
    pub stiffness: f64,
    /// Damping `c`, N s/m.
    pub damping: f64,
    /// Share of `c` that is added while `e` grows and subtracted while it falls.
    pub asymmetry: f64,
    /// Increase of the damping with speed, N s²/m².
    pub drag: f64,
    /// A force on `b` over the speed of the elongation.
    pub over_speed: Option<TabulatedForce>,
    /// Hardening, N/m³.
    pub cubic: f64,
    /// Full width of the free play, m: within `|e| < width / 2` neither `k` nor `c` acts. Beyond it the two
    /// sides only push.
    pub play: f64,
    /// One side only: beyond this elongation `k` and `c` act and only push; within it, no force acts.
    pub stop: Option<(StopSide, f64)>,
    /// A constant force on `b`, N.
    pub load: f64,
    /// Dry friction against `e'`.
    pub friction: Friction,
    /// How dry friction yields before it slides; without it a guide holds perfectly still.
    pub presliding: Option<Presliding>,
    /// The guide whose friction this link carries to its body.
    pub bears: Option<usize>,
    /// Friction of bristles that bend against `e'`.
    pub bristle: Option<Bristle>,
}

/// A side of a free play.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StopSide {
    /// Reached when the elongation grows.
    Upper,
    /// Reached when the elongation falls.
    Lower,
}

impl StopSide {
    /// Sign of the elongations that compress this side.
    pub fn sign(self) -> f64 {
        match self {
            Self::Upper => 1.0,
            Self::Lower => -1.0,
        }
    }
}

/// A contact; compression `d = x_a - x_b - gap - offset(t)`, force on `b` is `+F`.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactPart {
    pub name: String,
    /// Tip.
    pub a: NodeId,
    /// Workpiece.
    pub b: NodeId,
    /// How tool and workpiece are engaged.
    pub engagement: Engagement,
    /// Gap at zero positions, m.
    pub gap: f64,
    /// Time-dependent addition to the gap.
    pub profile: Option<Arc<Profile>>,
    /// `F = k d^exponent (1 + alpha d') + c d' + cubic d^3`.
    pub law: ForceLaw,
}

/// The general law of a contact, of which the named ones are special cases.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceLaw {
    /// Stiffness `k`, N/m^exponent.
    pub stiffness: f64,
    /// Exponent `n`, >= 1.
    pub exponent: f64,
    /// Damping `c`, N s/m.
    pub damping: f64,
    /// Growth `alpha` of the force with the rate of compression, s/m.
    pub alpha: f64,
    /// Hardening, N/m³.
    pub cubic: f64,
}

impl ForceLaw {
    /// Whether the force is linear in compression and rate.
    pub fn is_linear(&self) -> bool {
        // Bit comparisons: the other terms vanish at exactly these values.
        self.exponent.to_bits() == 1.0_f64.to_bits() && self.alpha == 0.0 && self.cubic == 0.0
    }
}

/// A sensor: `reading = quantise(gain * filters(signal(t - delay)) + bias + noise)`.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorPart {
    pub name: String,
    /// Source of its reading.
    pub source: Source,
    /// Node on which it is mounted; ground for an absolute reading.
    pub relative_to: NodeId,
    /// Mass beyond the sensor and its node `(mass, node)`: mass times acceleration of the node is added to
    /// the reading.
    pub tool_inertia: (f64, NodeId),
    pub gain: f64,
    /// Offset.
    pub bias: f64,
    /// Analogue filters in series.
    pub filters: Vec<LowPass>,
    /// Pure delay, s.
    pub delay: f64,
    /// Quantisation steps, applied one after the other.
    pub resolutions: Vec<f64>,
    /// Standard deviation of the noise.
    pub noise: f64,
}

impl SensorPart {
    /// Rounds readings to multiples of a step, after any previous rounding; a step of zero has no effect.
    pub(crate) fn round_to(&mut self, step: f64) {
        if step > 0.0 {
            self.resolutions.push(step);
        }
    }
}

/// A resolved signal of the plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// Position, velocity or acceleration of a node.
    Node(NodeId, Quantity),
    /// Force, elastic force, compression or state of a contact.
    Contact(usize, Quantity),
    /// Force or elastic force of a link.
    Link(usize, Quantity),
    /// Command or force of a drive.
    Drive(usize, Quantity),
    /// Reading of a sensor.
    Sensor(usize),
}
