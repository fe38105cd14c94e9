//! What the library says of each effect.

use thiserror::Error;

use crate::assembly::Assembly;
use crate::units::Dimension;

/// Where on the machine an effect lives: the places a diagnosis names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Place {
    /// Between command and drive force.
    Drive,
    /// Where the axis slides.
    Guide,
    /// Between motor and tip.
    Transmission,
    /// What guide, reaction and workpiece stand on.
    Base,
    /// Where tool and workpiece meet.
    Contact,
    /// What is touched.
    Workpiece,
    /// The force channel.
    ForceSensor,
    /// The position channel.
    Encoder,
    /// When samples are taken.
    Timing,
}

impl Place {
    /// Every place with its name in files.
    pub const ALL: [(Self, &'static str); 9] = [
        (Self::Drive, "drive"),
        (Self::Guide, "guide"),
        (Self::Transmission, "transmission"),
        (Self::Base, "base"),
        (Self::Contact, "contact"),
        (Self::Workpiece, "workpiece"),
        (Self::ForceSensor, "force-sensor"),
        (Self::Encoder, "encoder"),
        (Self::Timing, "timing"),
    ];

    /// Its name in files.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(place, _)| *place == self).map_or("", |(_, name)| name)
    }
}

/// Which kind of element carries an effect in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HostKind {
    /// `[bodies.*]`.
    Body,
    /// `[springs.*]` with stiffness or damping.
    Spring,
    /// `[springs.*]` with `rigid = true`.
    RigidSpring,
    /// `[contacts.*]`.
    Contact,
    /// `[actuators.*]`.
    Actuator,
    /// `[sensors.*]` that reads a force.
    ForceSensor,
    /// `[sensors.*]` that reads a motion.
    MotionSensor,
    /// `[controllers.*]`.
    Controller,
}

/// The element an effect sits under, as an index into the assembly (nodes for bodies, links for springs).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Host {
    /// A node.
    Body(usize),
    /// A link.
    Spring(usize),
    /// A contact.
    Contact(usize),
    /// A drive.
    Actuator(usize),
    /// A sensor.
    Sensor(usize),
}

/// How a fit should walk along a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// By addition, in units of the typical value.
    Linear,
    /// By multiplication.
    Log,
}

/// A parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Key in files.
    pub name: &'static str,
    /// Dimension on a translational axis.
    pub dimension: Dimension,
    /// The value at which the effect vanishes (may be infinite); none where it never does or the host's own value is the null.
    pub null: Option<f64>,
    /// A typical value, for templates and as a starting point of fits.
    pub typical: f64,
    /// Smallest and largest value a file may hold; an open bound is the next float.
    pub bounds: (f64, f64),
    /// How a fit walks along it.
    pub scale: Scale,
    /// Used where a file leaves the key out; none where it must be given.
    pub default: Option<f64>,
    /// One line of text.
    pub text: &'static str,
}

/// What an effect does to a machine.
#[derive(Clone, Copy, Debug)]
pub enum Change {
    /// It changes the plant. Arguments: the machine, the element under which the effect sits, the parameters in the order of the definition.
    Plant(fn(&mut Assembly, Host, &[f64]) -> Result<(), EffectError>),
    /// It adds this much (one sigma, the first parameter) to the sample times of the controller.
    SampleJitter,
}

/// All that is known of one effect.
#[derive(Clone, Copy, Debug)]
pub struct Definition {
    /// Key in files.
    pub kind: &'static str,
    /// Where it lives.
    pub place: Place,
    /// Elements that take it.
    pub hosts: &'static [HostKind],
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// One line.
    pub summary: &'static str,
    /// What it is, its equation, where it comes from, what it is confused with: Markdown with the sections `Model`, `Where it comes from`, `How it shows` and `Source`.
    pub documentation: &'static str,
    /// Whether it can only take energy out of the machine.
    pub dissipative: bool,
    /// What it does.
    pub change: Change,
}

impl Definition {
    /// Position of a parameter.
    pub fn parameter_index(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|parameter| parameter.name == name)
    }
}

/// An effect as used under an element of a machine.
#[derive(Clone, Debug)]
pub struct EffectUse {
    /// Which effect.
    pub definition: &'static Definition,
    /// Its parameters in SI, in the order of the definition.
    pub values: Vec<f64>,
}

impl PartialEq for EffectUse {
    fn eq(&self, other: &Self) -> bool {
        self.definition.kind == other.definition.kind && self.values == other.values
    }
}

/// Why an effect cannot be applied where it stands.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum EffectError {
    /// The element is of another kind than the effect needs.
    #[error("`{kind}` does not sit under this element; it goes under {expected}")]
    WrongHost {
        /// The effect.
        kind: &'static str,
        /// Elements that take it.
        expected: &'static str,
    },
    /// A split would leave no mass on one side.
    #[error("`{parameter}` = {value_kg} kg leaves nothing of the {available_kg} kg there are; choose less")]
    MassExceeded {
        /// The parameter.
        parameter: &'static str,
        /// What was asked.
        value_kg: f64,
        /// What there is.
        available_kg: f64,
    },
    /// A value makes no sense on this host.
    #[error("`{parameter}` = {value}: {reason}")]
    Value {
        /// The parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// What it must satisfy.
        reason: &'static str,
    },
}
