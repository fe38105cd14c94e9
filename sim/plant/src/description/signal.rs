//! Signal names: `<element>.<quantity>`.

use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

use feeler_catalogue::Dimension;
use feeler_problem::Remedy;
use thiserror::Error;

/// A quantity of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Quantity {
    /// Position of a body, or of the driven body of a drive against the reacting one.
    Position,
    /// Velocity of a body, or of the driven body of a drive against the reacting one.
    Velocity,
    /// Acceleration of a body.
    Acceleration,
    /// Force of a contact (total, with damping), a spring, or a drive.
    Force,
    /// Elastic part of the force of a contact or spring.
    SpringForce,
    /// Compression `d` of a contact.
    Compression,
    /// Distance of the two bodies of a contact along the axis, `-d`.
    Gap,
    /// Rate of the gap of a contact.
    GapRate,
    /// Touching point of a contact between shapes: the point of the workpiece that the tip touches on its
    /// way. Its x coordinate lies along the axis, in the frame of the shapes.
    PointX,
    /// See [`Self::PointX`].
    PointY,
    /// See [`Self::PointX`].
    PointZ,
    /// Unit vector from the tip into the workpiece at that point.
    NormalX,
    /// See [`Self::NormalX`].
    NormalY,
    /// See [`Self::NormalX`].
    NormalZ,
    /// 1 while the force of a contact acts, else 0.
    Contact,
    /// Command of a drive as the controller issued it.
    Command,
    /// Target of a position servo as issued, which is its command.
    Target,
    /// Voltage of a motor whose command is a voltage, as issued.
    Voltage,
    /// Actual current of a motor.
    Current,
    Reading,
    Output,
    /// Reference of a controller.
    Reference,
}

impl Quantity {
    /// Every quantity with its name.
    pub const ALL: [(Self, &'static str); 22] = [
        (Self::Position, "position"),
        (Self::Velocity, "velocity"),
        (Self::Acceleration, "acceleration"),
        (Self::Force, "force"),
        (Self::SpringForce, "spring_force"),
        (Self::Compression, "compression"),
        (Self::Gap, "gap"),
        (Self::GapRate, "gap_rate"),
        (Self::PointX, "point_x"),
        (Self::PointY, "point_y"),
        (Self::PointZ, "point_z"),
        (Self::NormalX, "normal_x"),
        (Self::NormalY, "normal_y"),
        (Self::NormalZ, "normal_z"),
        (Self::Contact, "contact"),
        (Self::Command, "command"),
        (Self::Target, "target"),
        (Self::Voltage, "voltage"),
        (Self::Current, "current"),
        (Self::Reading, "reading"),
        (Self::Output, "output"),
        (Self::Reference, "reference"),
    ];

    /// Its index among the six numbers of a [`super::Touched`], if it is one of them.
    pub fn of_touch(self) -> Option<usize> {
        [Self::PointX, Self::PointY, Self::PointZ, Self::NormalX, Self::NormalY, Self::NormalZ]
            .iter()
            .position(|one| *one == self)
    }

    /// Its dimension. `None` if another element determines it: the drive for a command, the signal for a
    /// reading, the law for a controller's output and reference.
    pub fn dimension(self) -> Option<Dimension> {
        match self {
            Self::Position
            | Self::Target
            | Self::Compression
            | Self::Gap
            | Self::PointX
            | Self::PointY
            | Self::PointZ => Some(Dimension::LENGTH),
            Self::Velocity | Self::GapRate => Some(Dimension::VELOCITY),
            Self::Acceleration => Some(Dimension::ACCELERATION),
            Self::Voltage => Some(Dimension::VOLTAGE),
            Self::Current => Some(Dimension::CURRENT),
            Self::Force | Self::SpringForce => Some(Dimension::FORCE),
            Self::Contact | Self::NormalX | Self::NormalY | Self::NormalZ => Some(Dimension::NONE),
            Self::Command | Self::Reading | Self::Output | Self::Reference => None,
        }
    }

    /// Whether it is a force, total or elastic.
    pub fn is_force(self) -> bool {
        matches!(self, Self::Force | Self::SpringForce)
    }

    /// Its name in files.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(q, _)| *q == self).map_or("", |(_, name)| name)
    }
}

/// The name of a signal: an element and one of its quantities.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SignalName {
    /// Name of the element, as in the machine.
    pub element: String,
    /// Quantity that is read or commanded.
    pub quantity: Quantity,
}

impl SignalName {
    /// `element.quantity`.
    pub fn new(element: impl Into<String>, quantity: Quantity) -> Self {
        Self { element: element.into(), quantity }
    }
}

impl fmt::Display for SignalName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.element, self.quantity.name())
    }
}

/// Why a text is not a signal name.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ParseSignalError {
    #[error("`{text}` is not a signal")]
    NoDot {
        /// The text that was written.
        text: String,
    },
    /// The part after the dot is not a quantity.
    #[error("`{quantity}` is not a quantity of a signal")]
    UnknownQuantity {
        /// The text that was written.
        quantity: String,
        /// The nearest existing name, or all of them.
        remedy: String,
    },
}

impl Remedy for ParseSignalError {
    fn remedy(&self) -> Cow<'_, str> {
        match self {
            Self::NoDot { .. } => "write `<element>.<quantity>`, as in `motor.position`".into(),
            Self::UnknownQuantity { remedy, .. } => remedy.into(),
        }
    }
}

impl FromStr for SignalName {
    type Err = ParseSignalError;

    fn from_str(text: &str) -> Result<Self, ParseSignalError> {
        let (element, quantity) =
            text.rsplit_once('.').ok_or_else(|| ParseSignalError::NoDot { text: text.into() })?;
        let found = Quantity::ALL.iter().find(|(_, name)| *name == quantity);
        let (quantity, _) = found.ok_or_else(|| ParseSignalError::UnknownQuantity {
            quantity: quantity.into(),
            remedy: crate::names::did_you_mean(quantity, Quantity::ALL.iter().map(|(_, name)| *name)),
        })?;
        Ok(Self::new(element, *quantity))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let all = ["tip", "tip.positon"].map(|text| text.parse::<SignalName>().unwrap_err());
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("signal.rs")),
            Vec::<String>::new()
        );
    }
}
