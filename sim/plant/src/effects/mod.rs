//! The effects library: departures of a real machine from the ideal one.
//!
//! Each effect has one file: its parameters (one line each), its change of the machine, and its
//! documentation. [`effects!`](crate::effects!) is the only list of effects. [`Kind`] and [`LIBRARY`] follow
//! from it; file format, schema, command line, documentation, fitting and contract tests use these.

#[macro_use]
mod definition;
mod error;
#[cfg(test)]
mod fixture;
mod law;

pub use definition::{
    ABOVE_ZERO, Change, Definition, EffectUse, Host, HostKind, Parameter, Parameters, Place, Scale, Trait,
};
pub use error::EffectError;
pub use law::{Curve, Law};

use definition::ChangesPlant;

/// Passes every effect, in the order of the manual, to a macro: `file Kind,` each.
#[macro_export]
macro_rules! effects {
    ($to:ident) => {
        $to! {
            actuator_lag ActuatorLag,
            command_delay CommandDelay,
            command_interpolation CommandInterpolation,
            drive_gain DriveGain,
            loop_gain LoopGain,
            drive_deadband DriveDeadband,
            force_limit ForceLimit,
            torque_speed_line TorqueSpeedLine,
            thermal_derating ThermalDerating,
            slew_limit SlewLimit,
            force_ripple ForceRipple,
            command_noise CommandNoise,
            constant_load ConstantLoad,
            gravity Gravity,
            coulomb_friction CoulombFriction,
            stribeck_friction StribeckFriction,
            viscous_friction ViscousFriction,
            directional_damping DirectionalDamping,
            quadratic_drag QuadraticDrag,
            load_friction LoadFriction,
            asymmetric_friction AsymmetricFriction,
            lugre_friction LugreFriction,
            hard_stop HardStop,
            added_mass AddedMass,
            transmission_flexibility TransmissionFlexibility,
            backlash Backlash,
            hardening_stiffness HardeningStiffness,
            base_flexibility BaseFlexibility,
            workpiece_dynamics WorkpieceDynamics,
            contact_stiffness ContactStiffness,
            contact_damping ContactDamping,
            hunt_crossley_contact HuntCrossleyContact,
            hertz_contact HertzContact,
            surface_offset SurfaceOffset,
            force_lag ForceLag,
            force_delay ForceDelay,
            force_gain ForceGain,
            force_bias ForceBias,
            force_resolution ForceResolution,
            tool_inertia ToolInertia,
            encoder_resolution EncoderResolution,
            timing_jitter TimingJitter,
        }
    };
}

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
