//! The effects library: departures of a real machine from the ideal one.
//!
//! One effect, one file: its parameters (one line each), what it changes, and its documentation. [`LIBRARY`]
//! is the one list from which file format, schema, command line, documentation, fitting and contract tests
//! draw.

mod definition;
#[cfg(test)]
mod fixture;

pub use definition::{
    ABOVE_ZERO, Change, Definition, EffectError, EffectUse, Host, HostKind, Parameter, Place, Scale,
};

use definition::values;

macro_rules! library {
    ($($module:ident,)*) => {
        $(mod $module;)*
        /// Every effect, in the order of the manual.
        pub static LIBRARY: &[&Definition] = &[$(&$module::DEFINITION,)*];
    };
}

library! {
    actuator_lag,
    command_delay,
    drive_gain,
    drive_deadband,
    force_limit,
    slew_limit,
    force_ripple,
    constant_load,
    coulomb_friction,
    stribeck_friction,
    viscous_friction,
    load_friction,
    asymmetric_friction,
    added_mass,
    transmission_flexibility,
    backlash,
    hardening_stiffness,
    base_flexibility,
    workpiece_dynamics,
    contact_stiffness,
    contact_damping,
    hunt_crossley_contact,
    hertz_contact,
    surface_offset,
    force_lag,
    force_delay,
    force_gain,
    force_bias,
    force_resolution,
    tool_inertia,
    encoder_resolution,
    timing_jitter,
}

/// The effect of this kind, if the library has one.
pub fn find(kind: &str) -> Option<&'static Definition> {
    LIBRARY.iter().copied().find(|definition| definition.kind == kind)
}
