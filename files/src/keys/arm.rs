//! Arm files.

use feeler_catalogue::{Bound, Kind, Shape, Unit, number, optional, required};
use feeler_plant::units::Dimension;

/// The top of an arm file; `[joints.*]` are tables of their own.
pub(crate) static ARM: Shape = Shape {
    keys: &[
        optional("name", Kind::Text, "short name; the URDF's where absent"),
        optional("about", Kind::Text, "what it is"),
        required("urdf", Kind::Text, "the URDF file, relative to this one"),
        optional(
            "tool",
            Kind::Text,
            "link whose frame is the tool's; where absent, the last one that nothing hangs on",
        ),
    ],
    choice: None,
};

/// `[joints.*]`
pub(crate) static JOINT: Shape = Shape {
    keys: &[
        required(
            "gear_ratio",
            Kind::Quantity(Unit::Of(Dimension::NONE), Bound::Positive),
            "turns of the rotor per turn of the joint",
        ),
        required(
            "rotor_inertia",
            Kind::Quantity(Unit::Of(Dimension::MASS), Bound::Positive),
            "of the rotor about its own axis, before the gear",
        ),
        required(
            "stiffness",
            Kind::Quantity(Unit::Of(Dimension::STIFFNESS), Bound::Positive),
            "of gear and shaft, at the joint",
        ),
        number(
            "damping",
            Unit::Of(Dimension::DAMPING),
            Bound::NotNegative,
            0.0,
            "of gear and shaft, at the joint",
        ),
        optional(
            "viscous_friction",
            Kind::Quantity(Unit::Of(Dimension::DAMPING), Bound::NotNegative),
            "of the motor, at the joint; the URDF's `dynamics damping` where absent",
        ),
        optional(
            "dry_friction",
            Kind::Quantity(Unit::Of(Dimension::FORCE), Bound::NotNegative),
            "of the motor, at the joint; the URDF's `dynamics friction` where absent",
        ),
        optional(
            "limit",
            Kind::Quantity(Unit::Of(Dimension::FORCE), Bound::Positive),
            "largest torque, at the joint; the URDF's `limit effort` where absent",
        ),
        optional(
            "bandwidth",
            Kind::Quantity(Unit::Of(Dimension::FREQUENCY), Bound::Positive),
            "first-order bandwidth of the torque loop",
        ),
    ],
    choice: None,
};
