//! Declarations of the keys of a table: one line per key, for parsing, writing, the schema and the reference.

use crate::content::Content;
use crate::dimension::Dimension;

/// A key of a table.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Its name in files.
    pub name: &'static str,
    /// Kind of its content.
    pub kind: KeyKind,
    /// Meaning of its absence.
    pub absent: Absent,
    /// Its meaning.
    pub text: &'static str,
}

/// Kind of the content of a key.
#[derive(Clone, Copy, Debug)]
pub enum KeyKind {
    /// A number in SI or a text with a unit.
    Quantity(Unit, Bound),
    /// A whole number from..=to.
    Count(u64, u64),
    /// True or false.
    Flag,
    /// Any text.
    Text,
    /// The name of another element; the text says of which kind.
    Name(&'static str),
    /// The names of two bodies.
    Pair,
    /// `element.quantity`.
    Signal,
    /// A list of signals.
    Signals,
    /// One of several words.
    Word(&'static [Word]),
    Table(&'static Keys),
    /// A table, or a quantity that is short for the key of this name.
    QuantityOrTable(&'static str, Unit, &'static Keys),
    WordOrTable(&'static [Word], &'static Keys),
    /// Two quantities, low and high.
    Range(Unit),
    /// A list of this many quantities; of any number if this is zero.
    Numbers(Unit, usize),
    /// `[[time, value], ...]`.
    Points(Unit),
    /// A number, points (steps), or a table of the shape.
    Reference(&'static Keys),
}

/// A possible value of a key, and its meaning.
#[derive(Clone, Copy, Debug)]
pub struct Word {
    /// The word as written in a file.
    pub name: &'static str,
    /// Its meaning.
    pub text: &'static str,
}

/// Unit of a quantity; some depend on other keys of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Unit {
    /// Unit of this dimension.
    Of(Dimension),
    /// Unit of the signal that a sensor reads.
    Signal,
    /// N/m^n, with the exponent `n` of the contact's law.
    PowerStiffness,
    /// N/m², of a material, whatever the axis.
    Pressure,
    /// Unit of the drive's command.
    Output,
    /// Unit of the drive's command, divided by this.
    OutputPer(Dimension),
    /// Unit of the quantity that the controller's law follows.
    Reference,
    /// Unit of the key on a sweep's axis; plain numbers.
    Swept,
}

/// Valid values of a quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// Any finite number.
    Any,
    /// > 0.
    Positive,
    /// >= 0.
    NotNegative,
    /// This value or above.
    AtLeast(f64),
    /// From the first to the second, both included.
    Within(f64, f64),
    /// Above the first, up to the second.
    Above(f64, f64),
}

impl Bound {
    /// Whether a value is valid.
    pub fn admits(self, value: f64) -> bool {
        value.is_finite()
            && match self {
                Self::Any => true,
                Self::Positive => value > 0.0,
                Self::NotNegative => value >= 0.0,
                Self::AtLeast(least) => value >= least,
                Self::Within(least, most) => (least..=most).contains(&value),
                Self::Above(least, most) => value > least && value <= most,
            }
    }

    /// "must be above zero".
    pub fn words(self) -> String {
        let verb = if matches!(self, Self::Within(..)) { "lie" } else { "be" };
        format!("must {verb} {}", self.range())
    }

    /// "above zero".
    pub fn range(self) -> String {
        match self {
            Self::Any => "a finite number".into(),
            Self::Positive => "above zero".into(),
            Self::NotNegative => "zero or above".into(),
            Self::AtLeast(least) => format!("{least} or above"),
            Self::Within(least, most) => format!("from {} to {}", compact(least), compact(most)),
            Self::Above(least, most) => format!("above {least} and at most {most}"),
        }
    }
}

/// A number without long rows of zeros.
pub fn compact(value: f64) -> String {
    if value != 0.0 && !(1e-4..1e6).contains(&value.abs()) {
        format!("{value:e}")
    } else {
        format!("{value}")
    }
}

impl Unit {
    /// The unit in words, for manuals; a different unit on a rotational axis follows in parentheses.
    pub fn words(self) -> String {
        match self {
            Self::Of(dimension) => {
                let [straight, rotary] = [false, true].map(|rotational| dimension.si_unit(rotational));
                if straight == rotary { straight.into() } else { format!("{straight} ({rotary})") }
            }
            Self::Signal => "unit of the signal".into(),
            Self::PowerStiffness => Self::Of(Dimension::POWER_STIFFNESS).words(),
            Self::Pressure => "N/m2".into(),
            Self::Output => "unit of the command".into(),
            Self::OutputPer(dimension) => {
                let unit = dimension.si_unit(false);
                if unit.contains(['/', ' ']) {
                    format!("unit of the command per ({unit})")
                } else {
                    format!("unit of the command per {unit}")
                }
            }
            Self::Reference => "unit of the reference".into(),
            Self::Swept => "unit of the key".into(),
        }
    }
}

/// Meaning of an absent key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Absent {
    /// A mistake.
    Required,
    /// The feature does not exist.
    Nothing,
    /// This quantity, SI.
    Number(f64),
    /// This whole number.
    Count(u64),
    /// True or false.
    Flag(bool),
    /// This word or name.
    Word(&'static str),
}

impl Absent {
    /// Whether the default of a key is exactly this content. Numbers are compared by bits, so that -0 is
    /// written as -0.
    pub fn means(self, content: &Content) -> bool {
        match (self, content) {
            (Self::Number(default), Content::Number(value)) => default.to_bits() == value.to_bits(),
            (Self::Count(default), Content::Count(count)) => default == *count,
            (Self::Flag(default), Content::Flag(flag)) => default == *flag,
            (Self::Word(default), Content::Word(word)) => default == *word,
            (Self::Word(default), Content::Text(text)) => default == text,
            _ => false,
        }
    }
}

/// The keys of a table; in some tables the value of one key adds others.
#[derive(Debug)]
pub struct Keys {
    /// Keys that it always has.
    pub keys: &'static [Key],
    /// The key that adds others.
    pub choice: Option<Choice>,
}

/// A key whose word decides which other keys exist.
#[derive(Debug)]
pub struct Choice {
    /// Its name; empty if the present keys identify the variant.
    pub key: &'static str,
    /// The default word; `None` if it is required.
    pub default: Option<&'static str>,
    /// Meaning of the choice, for people.
    pub text: &'static str,
    /// The possible variants.
    pub variants: &'static [Variant],
}

/// One word of a [`Choice`].
#[derive(Clone, Copy, Debug)]
pub struct Variant {
    /// Its word in files.
    pub name: &'static str,
    /// Its meaning.
    pub text: &'static str,
    /// The keys of this variant only.
    pub keys: &'static [Key],
}

impl Keys {
    /// Keys of the table itself and of every variant.
    pub fn all_keys(&self) -> impl Iterator<Item = &'static Key> {
        let variants = self.choice.iter().flat_map(|choice| choice.variants).flat_map(|variant| variant.keys);
        self.keys.iter().chain(variants)
    }

    /// The variant with this key.
    pub fn variant_of(&self, key: &str) -> Option<&'static Variant> {
        self.choice
            .iter()
            .flat_map(|choice| choice.variants)
            .find(|variant| variant.keys.iter().any(|k| k.name == key))
    }
}

/// A required key.
pub const fn required(name: &'static str, kind: KeyKind, text: &'static str) -> Key {
    Key { name, kind, absent: Absent::Required, text }
}

/// An optional key; without it the feature does not exist.
pub const fn optional(name: &'static str, kind: KeyKind, text: &'static str) -> Key {
    Key { name, kind, absent: Absent::Nothing, text }
}

/// A quantity with a default in SI.
pub const fn number(name: &'static str, unit: Unit, bound: Bound, default: f64, text: &'static str) -> Key {
    Key { name, kind: KeyKind::Quantity(unit, bound), absent: Absent::Number(default), text }
}

/// A word and its meaning.
pub const fn word(name: &'static str, text: &'static str) -> Word {
    Word { name, text }
}
