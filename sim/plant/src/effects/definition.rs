//! The definition of an effect in the library.

use super::{EffectError, Kind, LawDrawing};
use crate::assembly::Assembly;
use crate::units::Dimension;

/// Place of an effect on the machine, as a diagnosis names it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Place {
    /// Between command and drive force.
    Drive,
    /// The guide on which the axis slides.
    Guide,
    /// Between motor and tip.
    Transmission,
    /// The support of guide, reaction and workpiece.
    Base,
    /// The contact of tool and workpiece.
    Contact,
    /// The workpiece that is touched.
    Workpiece,
    /// The force channel.
    ForceSensor,
    /// The position channel.
    Encoder,
    /// The instants of samples.
    Timing,
}

impl Place {
    /// Every place, with its name in files.
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

/// Kind of the element that carries an effect in a file.
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
    /// `[sensors.*]` that reads neither: it reads a command, or whether there is contact.
    OtherSensor,
    /// `[controllers.*]`.
    Controller,
}

impl HostKind {
    /// Its name in a sentence, with the article.
    pub fn phrase(self) -> &'static str {
        match self {
            Self::Body => "a body",
            Self::Spring => "a spring that is not rigid",
            Self::RigidSpring => "a rigid spring",
            Self::Contact => "a contact",
            Self::Actuator => "an actuator",
            Self::ForceSensor => "a sensor that reads a force",
            Self::MotionSensor => "a sensor that reads a motion",
            Self::OtherSensor => "a sensor that reads neither force nor motion",
            Self::Controller => "a controller",
        }
    }
}

/// The element with an effect, as an index into the assembly (nodes for bodies, links for springs).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Host {
    /// A node.
    Body(usize),
    /// A link.
    Spring(usize),
    Contact(usize),
    /// A drive.
    Actuator(usize),
    Sensor(usize),
}

/// How a fit steps along a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Additive steps, in units of the typical value.
    Linear,
    /// By multiplication.
    Log,
}

/// The lower bound of a parameter that must be positive.
pub const ABOVE_ZERO: f64 = f64::MIN_POSITIVE;

/// A parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Key in files.
    pub name: &'static str,
    /// Dimension on a translational axis.
    pub dimension: Dimension,
    /// The value of the ideal machine (may be infinite): the effect is absent if every parameter that has a
    /// null is at it. `None` if the parameter does not matter for that, or if the element's own value is the
    /// ideal one.
    pub null: Option<f64>,
    /// A typical value, for templates and as a starting point of fits.
    pub typical: f64,
    /// Smallest and largest value in a file; [`ABOVE_ZERO`] if zero itself is excluded.
    pub bounds: (f64, f64),
    /// How a fit steps along it.
    pub scale: Scale,
    /// Value if a file omits the key; such a parameter is a choice of the model and is not fitted. `None` if
    /// the key is required.
    pub default: Option<f64>,
    pub text: &'static str,
}

impl Parameter {
    /// A required parameter with multiplicative steps in a fit.
    pub const fn log(
        name: &'static str,
        dimension: Dimension,
        null: Option<f64>,
        typical: f64,
        bounds: (f64, f64),
        text: &'static str,
    ) -> Self {
        Self { name, dimension, null, typical, bounds, scale: Scale::Log, default: None, text }
    }

    /// A required parameter with additive steps in a fit.
    pub const fn linear(
        name: &'static str,
        dimension: Dimension,
        null: Option<f64>,
        typical: f64,
        bounds: (f64, f64),
        text: &'static str,
    ) -> Self {
        Self { scale: Scale::Linear, ..Self::log(name, dimension, null, typical, bounds, text) }
    }

    /// The same, but optional in a file.
    #[must_use]
    pub const fn or(self, default: f64) -> Self {
        Self { default: Some(default), ..self }
    }
}

/// The parameters of one kind of effect, by name.
pub trait Parameters: Copy {
    /// The kind that has them.
    const KIND: Kind;
    /// Definition of each parameter, in order.
    const PARAMETERS: &'static [Parameter];

    /// From values in the order of the definition.
    ///
    /// # Panics
    /// If there are fewer values than parameters.
    fn of(values: &[f64]) -> Self;

    /// Values in the order of the definition.
    fn values(self) -> Vec<f64>;

    /// Typical values.
    fn typical() -> Self {
        Self::of(&Self::PARAMETERS.iter().map(|parameter| parameter.typical).collect::<Vec<_>>())
    }
}

/// The parameters of an effect that changes the plant.
pub(super) trait ChangesPlant: Parameters {
    /// Changes the machine as the effect on `host` does.
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError>;
}

/// Declares the parameters of an effect: its kind first, then one line each: `name: scale(dimension, null,
/// typical, bounds, text)`. `as "key"` gives another name in files, and `or default` makes the parameter
/// optional.
macro_rules! parameters {
    (@key $name:ident) => { stringify!($name) };
    (@key $name:ident $key:literal) => { $key };
    ($kind:ident $(
        $name:ident $(as $key:literal)?: $scale:ident(
            $dimension:expr, $null:expr, $typical:expr, $bounds:expr, $text:literal
        ) $(or $default:expr)?,
    )+) => {
        #[doc = concat!("Parameters of [`Kind::", stringify!($kind), "`](crate::effects::Kind) in SI units.")]
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct $kind {
            $(#[doc = $text] pub $name: f64,)+
        }

        impl $crate::effects::Parameters for $kind {
            const KIND: $crate::effects::Kind = $crate::effects::Kind::$kind;
            const PARAMETERS: &'static [$crate::effects::Parameter] = &[$(
                $crate::effects::Parameter::$scale(
                    parameters!(@key $name $($key)?), $dimension, $null, $typical, $bounds, $text,
                )$(.or($default))?,
            )+];

            fn of(values: &[f64]) -> Self {
                let [$($name),+] = std::array::from_fn(|i| values[i]);
                Self { $($name),+ }
            }

            fn values(self) -> Vec<f64> {
                vec![$(self.$name),+]
            }
        }
    };
}
/// The change that an effect makes to a machine.
#[derive(Clone, Copy, Debug)]
pub enum Change {
    /// Changes the plant. Arguments: the machine, the element with the effect, the parameters in the order of
    /// the definition.
    Plant(fn(&mut Assembly, Host, &[f64]) -> Result<(), EffectError>),
    /// Shifts the samples of the controller off the grid, by a standard deviation in s. Argument: the
    /// parameters.
    SampleJitter(fn(&[f64]) -> f64),
}

impl Change {
    /// The change that parameters make.
    pub(super) const fn plant<P: ChangesPlant>() -> Self {
        Self::Plant(|machine, host, values| P::of(values).apply(machine, host))
    }
}

/// Common properties of effects, for code that treats them alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trait {
    /// It can only dissipate energy.
    Dissipative,
    /// It holds at rest up to a level: dry friction.
    DryFriction,
    /// It is a parameter that the ideal machine has too, and not a law: only its value differs.
    PlainNumber,
    /// It is a law of surfaces that meet and part: a diagnosis leaves it out of records of a clamped contact.
    SurfacesPart,
    /// It rounds readings to steps.
    Quantisation,
    /// It delays commands or readings.
    Delay,
    /// It limits the output of a drive.
    Saturation,
    /// It distorts the output of a drive within its limits.
    DriveFlaw,
    /// It makes a rigid connection of the ideal machine flexible.
    Compliance,
    /// The force of a drive drifts under a command at rest.
    Drift,
    /// Its parameters have the unit of the drive's command where their dimension says force.
    OfCommand,
    /// It acts on the command before the gain of the drive.
    BeforeGain,
    /// It multiplies what a drive gives or a sensor reads.
    Gain,
    /// A mistaken unit of a command or a reading looks like it.
    LikeUnits,
    /// It leaves a gap within which two bodies do not push each other.
    FreePlay,
    /// It adds noise to a command.
    Noise,
    /// It holds a guide at rest by an elastic force.
    Bristles,
}

/// The complete definition of one effect.
#[derive(Clone, Copy, Debug)]
pub struct Definition {
    pub kind: Kind,
    /// Key in files.
    pub name: &'static str,
    /// Its place; see [`Definition::place_under`].
    pub place: Place,
    /// Position in the manual, by rising numbers. Steps of ten leave room for another between two.
    pub order: u16,
    /// Elements that take it.
    pub hosts: &'static [HostKind],
    /// Further requirement on the element; empty if there is none.
    pub site: &'static str,
    pub parameters: &'static [Parameter],
    pub summary: &'static str,
    /// The lines of its file in `scenarios/effects` that add it to the ideal axis.
    pub example: &'static str,
    /// The other sections of [`Definition::documentation`]: equation, causes, look-alikes, source.
    pub sections: &'static str,
    /// The drawing of its model on that page.
    pub law: LawDrawing,
    /// Properties that it shares with other effects.
    pub traits: &'static [Trait],
    pub change: Change,
}

impl Definition {
    /// The elements that accept it, in words: "a rigid spring; a contact (...)".
    pub fn sits_under(&self) -> String {
        let hosts = self.hosts.iter().map(|host| host.phrase()).collect::<Vec<_>>().join("; ");
        if self.site.is_empty() { hosts } else { format!("{hosts} ({})", self.site) }
    }

    /// Its page as Markdown.
    pub fn documentation(&self) -> String {
        let Self { name, example, sections, .. } = self;
        format!(
            "## Example\n```toml\n{example}```\n`feeler run scenarios/effects/{name}.toml` runs it.\n`feeler \
             compare scenarios/effects/ideal.toml scenarios/effects/{name}.toml` shows the difference.\n\n\
             {sections}"
        )
    }

    /// Whether it has this property.
    pub fn has(&self, of_its: Trait) -> bool {
        self.traits.contains(&of_its)
    }

    /// Dimension of a parameter, under a drive whose command has the dimension `command`.
    pub fn dimension_of(&self, parameter: &Parameter, command: Dimension) -> Dimension {
        if self.has(Trait::OfCommand) {
            parameter.dimension * command / Dimension::FORCE
        } else {
            parameter.dimension
        }
    }

    /// Its place on an element of this kind: an effect of the transmission that sits under a contact belongs
    /// to the contact.
    pub fn place_under(&self, host: HostKind) -> Place {
        match (self.place, host) {
            (Place::Transmission, HostKind::Contact) => Place::Contact,
            (place, _) => place,
        }
    }

    /// Changes the plant as the effect on `host` does, with `parameters` (SI) in the order of the definition.
    /// An effect on a controller leaves the plant unchanged.
    ///
    /// # Errors
    /// If the host has the wrong kind, or a parameter is missing, out of bounds or invalid on this host.
    pub fn apply(&self, machine: &mut Assembly, host: Host, parameters: &[f64]) -> Result<(), EffectError> {
        if parameters.len() != self.parameters.len() {
            return Err(EffectError::Count {
                kind: self.kind,
                expected: self.parameters.len(),
                given: parameters.len(),
            });
        }
        for (parameter, &value) in self.parameters.iter().zip(parameters) {
            let (low, high) = parameter.bounds;
            if !(low..=high).contains(&value) {
                return Err(EffectError::OutOfBounds { parameter: parameter.name, value, low, high });
            }
        }
        let Change::Plant(change) = self.change else { return Ok(()) };
        let found = machine.host_kind(host);
        if !self.hosts.contains(&found) {
            return Err(EffectError::WrongHost { kind: self.kind, found, expected: self.hosts });
        }
        change(machine, host, parameters)
    }
}

/// An effect on an element of a machine.
#[derive(Clone, Debug)]
pub struct EffectUse {
    pub definition: &'static Definition,
    /// Its parameters in SI, in the order of the definition.
    pub values: Vec<f64>,
}

impl EffectUse {
    /// The effect with these parameters.
    pub fn of<P: Parameters>(parameters: P) -> Self {
        Self { definition: P::KIND.definition(), values: parameters.values() }
    }

    /// Its parameters by name; `None` if it is of another kind.
    pub fn parameters<P: Parameters>(&self) -> Option<P> {
        (self.definition.kind == P::KIND).then(|| P::of(&self.values))
    }
}

impl PartialEq for EffectUse {
    fn eq(&self, other: &Self) -> bool {
        self.definition.kind == other.definition.kind && self.values == other.values
    }
}
