//! The effects library: departures of a real machine from the ideal one.
//!
//! One effect, one file: its parameters (one line each), what it changes, and its documentation.
//! [`LIBRARY`] is the one list from which file format, schema, command line, documentation, fitting and contract tests draw.

mod definition;

pub use definition::{Change, Definition, EffectError, EffectUse, Host, HostKind, Parameter, Place, Scale};

macro_rules! library {
    ($($module:ident,)*) => {
        $(mod $module;)*
        /// Every effect, in the order of the manual.
        pub static LIBRARY: &[&Definition] = &[$(&$module::DEFINITION,)*];
    };
}

library! {
    command_delay,
    coulomb_friction,
}

/// The effect of this kind, if the library has one.
pub fn find(kind: &str) -> Option<&'static Definition> {
    LIBRARY.iter().copied().find(|definition| definition.kind == kind)
}
