//! A key together with the member of a struct that it fills.

use crate::content::{Content, Contents};
use crate::shape::{Absent, Bound, Key, KeyKind, Unit, Variant};

/// A key of the struct `T`: its declaration, and how its content is read from and written to a `T`.
#[derive(Debug)]
pub struct Field<T> {
    /// Name, kind, default and text.
    pub key: Key,
    /// Its role in the study of a machine.
    pub role: KeyRole,
    /// Content in a struct; `None` if absent.
    pub get: fn(&T) -> Option<Content>,
    /// Writes a content into a struct.
    pub set: fn(&mut T, &Content),
}

/// Role of a key in the study of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyRole {
    /// The structure of the machine, and all other settings.
    Structure,
    /// A gain of a control law.
    Gain {
        /// Position among the gains of its law, most important first.
        rank: u8,
        /// Its part in the law.
        part: GainPart,
    },
    /// A believed parameter of the real machine, within a tolerance.
    Believed,
}

/// Part of a control law that a gain multiplies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GainPart {
    /// The error.
    Proportional,
    /// The integral of the error.
    Integral,
    /// The derivative of the error.
    Derivative,
    /// A velocity, which the gain opposes.
    Damping,
    /// The reading itself, so that its loop closes through the reading.
    Reading,
    /// Anything else, such as the reference.
    Other,
}

impl<T> Field<T> {
    /// The quantity in a struct, SI.
    pub fn number(&self, owner: &T) -> Option<f64> {
        if let Some(Content::Number(value)) = (self.get)(owner) { Some(value) } else { None }
    }

    /// Sets the quantity, SI.
    pub fn set_number(&self, owner: &mut T, value: f64) {
        (self.set)(owner, &Content::Number(value));
    }

    /// Unit and valid range of the quantity; `None` if the key is not a single quantity.
    pub fn quantity(&self) -> Option<(Unit, Bound)> {
        if let KeyKind::Quantity(unit, bound) = self.key.kind { Some((unit, bound)) } else { None }
    }
}

/// A struct, or an enum of structs, that a table fills.
pub trait Keyed: Sized + 'static {
    /// Keys of every form.
    const FIELDS: &'static [Field<Self>];
    /// Its forms, if the word of a key decides which other keys exist.
    const FORMS: &'static [Form<Self>] = &[];

    /// Its value before any key is read; `None` for an enum whose form must be named. A number whose key had
    /// a mistake keeps this value, which passes every check. Only further checks use it, since the file as a
    /// whole is rejected.
    fn blank() -> Option<Self> {
        None
    }

    /// The value of a table, after mistakes have been recorded; `None` if its form is unknown.
    fn read(contents: &Contents) -> Option<Self> {
        let form = Self::FORMS.iter().find(|form| Some(form.name) == contents.variant);
        let mut record = form.map(|form| (form.start)()).or_else(Self::blank)?;
        record.take(contents);
        Some(record)
    }

    /// Takes the keys of a table; everything else stays.
    fn take(&mut self, contents: &Contents) {
        let form = self.form().map_or(&[] as &[Field<Self>], |form| form.fields);
        for field in Self::FIELDS.iter().chain(form) {
            if let Some(content) = contents.get(field.key.name) {
                (field.set)(self, content);
            }
        }
    }

    /// Everything that differs from its default.
    fn contents(&self) -> Contents {
        let mut contents = Contents::new(self.form().map(|form| form.name));
        for field in self.fields() {
            if let Some(content) = (field.get)(self).filter(|content| !field.key.absent.means(content)) {
                contents.insert(field.key.name, content);
            }
        }
        contents
    }

    /// The first quantity out of range: its key, its value and its rule.
    fn out_of_range(&self) -> Option<(String, f64, Bound)> {
        self.fields().find_map(|field| out_of_range(&field.key, &(field.get)(self)?))
    }

    fn form(&self) -> Option<&'static Form<Self>> {
        Self::FORMS.iter().find(|form| (form.is)(self))
    }

    /// The keys of this value.
    fn fields(&self) -> impl Iterator<Item = &'static Field<Self>> {
        Self::FIELDS.iter().chain(self.form().into_iter().flat_map(|form| form.fields))
    }
}

fn out_of_range(key: &Key, content: &Content) -> Option<(String, f64, Bound)> {
    match (key.kind, content) {
        (KeyKind::Quantity(_, bound), Content::Number(value)) => {
            (!bound.admits(*value)).then(|| (key.name.to_owned(), *value, bound))
        }
        (
            KeyKind::Table(shape) | KeyKind::QuantityOrTable(_, _, shape) | KeyKind::WordOrTable(_, shape),
            Content::Table(table),
        ) => {
            let (inner, value, bound) =
                shape.all_keys().find_map(|inner| out_of_range(inner, table.get(inner.name)?))?;
            Some((format!("{}.{inner}", key.name), value, bound))
        }
        _ => None,
    }
}

/// One form of an enum that a table fills.
#[derive(Debug)]
pub struct Form<T: 'static> {
    /// Its word in files.
    pub name: &'static str,
    /// Text for the schema and the manual.
    pub text: &'static str,
    /// The value before its keys are read.
    pub start: fn() -> T,
    /// Whether a value has this form.
    pub is: fn(&T) -> bool,
    /// The keys of this form only.
    pub fields: &'static [Field<T>],
    /// All keys that belong to it, including those that fill another struct.
    pub keys: &'static [Key],
}

const NO_KEY: Key = Key { name: "", kind: KeyKind::Flag, absent: Absent::Nothing, text: "" };

/// The declarations of fields.
pub const fn keys<T, const N: usize>(fields: &[Field<T>]) -> [Key; N] {
    let mut keys = [NO_KEY; N];
    let mut i = 0;
    while i < N {
        keys[i] = fields[i].key;
        i += 1;
    }
    keys
}

/// The keys of two lists, one after the other.
pub const fn joined<const N: usize>(first: &[Key], second: &[Key]) -> [Key; N] {
    let mut keys = [NO_KEY; N];
    let mut i = 0;
    while i < N {
        keys[i] = if i < first.len() { first[i] } else { second[i - first.len()] };
        i += 1;
    }
    keys
}

/// The variants for the forms of a record.
pub const fn variants<T, const N: usize>(forms: &[Form<T>]) -> [Variant; N] {
    let mut variants = [const { Variant { name: "", text: "", keys: &[] } }; N];
    let mut i = 0;
    while i < N {
        variants[i] = Variant { name: forms[i].name, text: forms[i].text, keys: forms[i].keys };
        i += 1;
    }
    variants
}

/// The variants of two lists, one after the other.
pub const fn chained<const N: usize>(first: &[Variant], second: &[Variant]) -> [Variant; N] {
    let mut variants = [first[0]; N];
    let mut i = 0;
    while i < N {
        variants[i] = if i < first.len() { first[i] } else { second[i - first.len()] };
        i += 1;
    }
    variants
}

/// A [`Field`]: `field!(Struct: member, key)`, `field!(Struct: member[0], key)`, `field!(Enum:
/// Enum::Form(inner) => inner.member, key)`, each with an optional [`KeyRole`] after the key.
#[macro_export]
macro_rules! field {
    ($owner:ty: $member:ident $([$index:literal])?, $key:expr) => {
        $crate::field!($owner: $member $([$index])?, $key, $crate::KeyRole::Structure)
    };
    ($owner:ty: $member:ident $([$index:literal])?, $key:expr, $role:expr) => {
        $crate::Field {
            key: $key,
            role: $role,
            get: |owner: &$owner| $crate::Slot::content(&owner.$member $([$index])?),
            set: |owner: &mut $owner, content| {
                if let Some(value) = $crate::Slot::of(content) {
                    owner.$member $([$index])? = value;
                }
            },
        }
    };
    ($owner:ty: $form:pat => $place:expr, $key:expr) => {
        $crate::field!($owner: $form => $place, $key, $crate::KeyRole::Structure)
    };
    ($owner:ty: $form:pat => $place:expr, $key:expr, $role:expr) => {
        $crate::Field {
            key: $key,
            role: $role,
            get: |owner: &$owner| if let $form = owner { $crate::Slot::content(&$place) } else { None },
            set: |owner: &mut $owner, content| {
                if let ($form, Some(value)) = (owner, $crate::Slot::of(content)) {
                    $place = value;
                }
            },
        }
    };
}

/// The declarations of a constant list of fields, as a constant list.
#[macro_export]
macro_rules! keys {
    ($fields:expr) => {{
        const KEYS: [$crate::Key; $fields.len()] = $crate::keys($fields);
        &KEYS
    }};
}

/// The keys of two constant lists, as a constant list.
#[macro_export]
macro_rules! joined {
    ($first:expr, $second:expr) => {{
        const KEYS: [$crate::Key; $first.len() + $second.len()] = $crate::joined($first, $second);
        &KEYS
    }};
}

/// A [`Form`]: its word, its text, its pattern, its initial value, its fields, and the associated keys that
/// fill another struct.
#[macro_export]
macro_rules! form {
    ($name:expr, $text:expr, $owner:ty: $is:pat, $start:expr, $fields:expr) => {
        $crate::form!($name, $text, $owner: $is, $start, $fields, &[] as &[$crate::Key])
    };
    ($name:expr, $text:expr, $owner:ty: $is:pat, $start:expr, $fields:expr, $besides:expr) => {
        $crate::Form {
            name: $name,
            text: $text,
            start: || $start,
            is: |owner: &$owner| matches!(owner, $is),
            fields: $fields,
            keys: $crate::joined!($besides, $crate::keys!($fields)),
        }
    };
}
