//! The effects library: departures of a real machine from the ideal one.
//!
//! Each effect has one file: its parameters (one line each), its change of the machine, and its
//! documentation. `build.rs` lists these files by their [`Definition::order`]. [`Kind`] and [`LIBRARY`]
//! follow from the list; file format, schema, command line, documentation, fitting and contract tests use
//! these.

#[macro_use]
mod definition;
mod error;
#[cfg(test)]
mod fixture;
mod law;
mod symptoms;

pub use definition::{
    ABOVE_ZERO, Change, Definition, EffectUse, Host, HostKind, Parameter, Parameters, Place, Scale, Trait,
};
pub use error::EffectError;
pub use law::{Curve, LawDrawing};
pub use symptoms::BY_SYMPTOM;

use definition::ChangesPlant;

/// Names that the file of an effect uses.
mod prelude {
    pub(super) use super::{
        ABOVE_ZERO, Change, ChangesPlant, Curve, Definition, EffectError, Host, HostKind, LawDrawing,
        Parameters, Place, Trait,
    };
    pub(super) use crate::assembly::Assembly;
    pub(super) use crate::units::Dimension;
}

// `effects!`, which passes every effect, in the order of the manual, to a macro: `file Kind,` each.
include!(concat!(env!("OUT_DIR"), "/effects.rs"));

macro_rules! library {
    ($($file:ident $kind:ident,)*) => {
        $(mod $file;)*
        $(pub use $file::$kind;)*

        /// The identity of an effect.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Kind {
            $(#[doc = concat!("Its parameters are [`", stringify!($kind), "`].")] $kind,)*
        }

        /// Every effect, in the order of the manual.
        pub static LIBRARY: &[&Definition] = &[$(&$file::DEFINITION,)*];

        $(const _: () = assert!($file::DEFINITION.kind as usize == Kind::$kind as usize);)*
    };
}

effects!(library);

impl Kind {
    /// Its definition.
    pub fn definition(self) -> &'static Definition {
        LIBRARY[self as usize]
    }

    /// Its name in files.
    pub fn name(self) -> &'static str {
        self.definition().name
    }
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

impl serde::Serialize for Kind {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// The effect with this name in files, if the library has one.
pub fn find(name: &str) -> Option<&'static Definition> {
    LIBRARY.iter().copied().find(|definition| definition.name == name)
}
