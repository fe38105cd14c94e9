//! A machine as the user describes it, in SI units and by name. References are neither resolved nor checked
//! yet.
//!
//! The machine has one axis of motion; `+x` points from the robot towards the workpiece. On a rotational axis
//! read kg m², N m and rad for kg, N and m.

mod actuator;
mod building;
mod contact;
mod motor;
mod profile;
mod sensor;
mod servo;
mod signal;
mod site;

pub use actuator::{Actuator, ActuatorKind};
pub use contact::{Contact, ContactLaw, Engagement};
pub use motor::{DcMotor, MotorInput};
pub use profile::{Knot, Piece, Profile, Touched};
pub use sensor::{LowPass, Sensor};
pub use servo::PositionServo;
pub use signal::{ParseSignalError, Quantity, SignalName};
pub use site::{Believed, Element, ElementKind, Site};

use std::sync::Arc;

use feeler_catalogue::{
    Absent, Bound, Dimension, Field, Key, KeyKind, KeyRole, Keyed, Unit, field, number, required, words,
};
use indexmap::IndexMap;

use crate::effects::EffectUse;

/// Elements of one kind by name, in the order of the file.
pub type Elements<T> = IndexMap<String, T>;

/// The name of the fixed body.
pub const GROUND: &str = "ground";

/// Whether coordinates are lengths or angles. Only the units differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Axis {
    /// kg, N, m.
    #[default]
    Translational,
    /// kg m², N m, rad.
    Rotational,
}

words!(Axis {
    Translational = "translational", "kg, N, m";
    Rotational = "rotational", "kg m2, N m, rad";
});

/// A machine as described in a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Machine {
    /// Short name.
    pub name: String,
    /// Purpose of the machine, in one or two sentences.
    pub about: String,
    /// Units of its coordinate.
    pub axis: Axis,
    /// Lumped masses.
    pub bodies: Elements<Body>,
    /// Springs, dampers, guides and rigid joints.
    pub springs: Elements<Spring>,
    /// Contacts between tool and workpiece.
    pub contacts: Elements<Contact>,
    /// Motions of gaps, by the names of their contacts. They describe the surface under a tool that travels
    /// sideways.
    pub profiles: Elements<Arc<Profile>>,
    pub actuators: Elements<Actuator>,
    pub sensors: Elements<Sensor>,
}

/// A lumped mass. All springs are relaxed where every position is zero.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Body {
    /// Mass, > 0.
    pub mass_kg: f64,
    /// Initial position.
    pub position_m: f64,
    /// Initial velocity.
    pub velocity_m_per_s: f64,
    /// Largest torque of gravity, `-gravity sin(x + gravity_phase)`; only on a rotational axis.
    pub gravity_n: f64,
    /// Angle of the body from its hanging position, at zero position.
    pub gravity_phase_rad: f64,
    /// Departures from the ideal body.
    pub effects: Vec<EffectUse>,
}

/// A linear spring and damper between two bodies, a viscous guide (zero stiffness), or a rigid joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spring {
    /// The two bodies; elongation is the position of the second minus that of the first.
    pub between: [String; 2],
    /// Stiffness, >= 0.
    pub stiffness_n_per_m: f64,
    /// Viscous damping, >= 0.
    pub damping_n_s_per_m: f64,
    /// The two bodies move as one, and each keeps its own signals.
    pub rigid: bool,
    /// Departures from the ideal spring.
    pub effects: Vec<EffectUse>,
}

const MASS: Unit = Unit::Of(Dimension::MASS);
const LENGTH: Unit = Unit::Of(Dimension::LENGTH);
const VELOCITY: Unit = Unit::Of(Dimension::VELOCITY);
const FORCE: Unit = Unit::Of(Dimension::FORCE);
const STIFFNESS: Unit = Unit::Of(Dimension::STIFFNESS);
const DAMPING: Unit = Unit::Of(Dimension::DAMPING);

impl Body {
    /// The key of the mass.
    pub const MASS: Field<Self> = field!(Body: mass_kg,
        required("mass", KeyKind::Quantity(MASS, Bound::Within(1e-15, 1e12)), "mass"), KeyRole::Believed);
    /// The initial velocity.
    pub const VELOCITY: Field<Self> = field!(Body: velocity_m_per_s,
        number("velocity", VELOCITY, Bound::Any, 0.0, "initial velocity"));
    /// The torque of gravity.
    pub const GRAVITY: Field<Self> = field!(Body: gravity_n,
        number("gravity", FORCE, Bound::NotNegative, 0.0,
            "largest torque of gravity, `-gravity sin(position + gravity_phase)`, on a rotational axis"),
        KeyRole::Believed);
}

impl Keyed for Body {
    const FIELDS: &'static [Field<Self>] = &[
        Body::MASS,
        field!(Body: position_m, number("position", LENGTH, Bound::Any, 0.0, "initial position")),
        Body::VELOCITY,
        Body::GRAVITY,
        field!(Body: gravity_phase_rad,
            number("gravity_phase", LENGTH, Bound::Any, 0.0,
                "angle of the body from its hanging position, at zero position")),
    ];

    fn blank() -> Option<Self> {
        Some(Self::new(1.0))
    }
}

impl Spring {
    /// The two bodies.
    pub const BETWEEN: Field<Self> = field!(Spring: between,
        required("between", KeyKind::Pair,
            "the two bodies; elongation is the position of the second minus that of the first"));
    /// The key of the stiffness.
    pub const STIFFNESS: Field<Self> = field!(Spring: stiffness_n_per_m,
        number("stiffness", STIFFNESS, Bound::NotNegative, 0.0, "stiffness"), KeyRole::Believed);
    /// The key of the damping.
    pub const DAMPING: Field<Self> = field!(Spring: damping_n_s_per_m,
        number("damping", DAMPING, Bound::NotNegative, 0.0, "viscous damping"), KeyRole::Believed);
    /// Whether it is a joint.
    pub const RIGID: Field<Self> = field!(Spring: rigid,
        Key { name: "rigid", kind: KeyKind::Flag, absent: Absent::Flag(false),
            text: "the two bodies move as one, and each keeps its own signals" });
}

impl Keyed for Spring {
    const FIELDS: &'static [Field<Self>] =
        &[Spring::BETWEEN, Spring::STIFFNESS, Spring::DAMPING, Spring::RIGID];

    fn blank() -> Option<Self> {
        Some(Self { stiffness_n_per_m: 1.0, damping_n_s_per_m: 1.0, ..Self::default() })
    }
}
