//! Units of a machine's axis.

use feeler_plant::description::{Actuator, Axis, Machine, Quantity};
use feeler_plant::units::Dimension;

/// SI units of the quantities of an axis, which may be rotational.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Units {
    pub(crate) force: &'static str,
    pub(crate) position: &'static str,
    pub(crate) velocity: &'static str,
    pub(crate) acceleration: &'static str,
    is_rotational: bool,
}

impl Units {
    pub(crate) fn of(machine: &Machine) -> Self {
        let unit = |dimension: Dimension| dimension.named_unit(machine.axis == Axis::Rotational);
        Self {
            force: unit(Dimension::FORCE),
            position: unit(Dimension::LENGTH),
            velocity: unit(Dimension::VELOCITY),
            acceleration: unit(Dimension::ACCELERATION),
            is_rotational: machine.axis == Axis::Rotational,
        }
    }

    /// The unit of an actuator's command.
    pub(crate) fn command(self, actuator: &Actuator) -> &'static str {
        actuator.kind.command().named_unit(self.is_rotational)
    }

    /// A force, or a torque.
    pub(crate) fn force_word(self) -> &'static str {
        if self.force == Dimension::FORCE.named_unit(false) { "force" } else { "torque" }
    }

    /// The unit of a quantity; empty if the quantity alone does not determine it.
    pub(crate) fn unit(self, quantity: Quantity) -> &'static str {
        match quantity.dimension() {
            Some(Dimension::LENGTH) => self.position,
            Some(Dimension::VELOCITY) => self.velocity,
            Some(Dimension::ACCELERATION) => self.acceleration,
            Some(Dimension::FORCE) => self.force,
            Some(Dimension::VOLTAGE) => "V",
            Some(Dimension::CURRENT) => "A",
            _ => "",
        }
    }
}
