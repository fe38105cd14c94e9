//! The keys of a machine file. Each is declared once, as a [`Field`], next to the struct that it fills. A
//! field holds its name, unit, bounds, default, text and role, and how the struct's number is read and set.
//!
//! Reader, writer, check, schema, reference manual, units of sweep axes, gains and believed values all follow
//! from these declarations and know no key by name.
//!
//! ```
//! use feeler_catalogue::{Bound, Dimension, Field, Keyed, Unit, field, number};
//!
//! struct Damper {
//!     damping_n_s_per_m: f64,
//! }
//!
//! impl Keyed for Damper {
//!     const FIELDS: &'static [Field<Self>] = &[field!(
//!         Damper: damping_n_s_per_m,
//!         number("damping", Unit::Of(Dimension::DAMPING), Bound::NotNegative, 0.0, "viscous damping")
//!     )];
//!
//!     fn blank() -> Option<Self> {
//!         Some(Self { damping_n_s_per_m: 0.0 })
//!     }
//! }
//!
//! let mut damper = Damper { damping_n_s_per_m: 0.0 };
//! let damping = &Damper::FIELDS[0];
//! damping.set_number(&mut damper, 3.0);
//! assert_eq!(damping.number(&damper), Some(3.0));
//! ```

mod common;
mod content;
mod dimension;
mod field;
mod shape;
mod slot;
mod tabled;

pub use common::{CORNER, DAMPING_RATIO, LAW, LONGEST_DELAY, LOW_PASS, low_pass};
pub use content::{Content, Contents};
pub use dimension::{Dimension, same_exponent};
pub use field::{Field, Form, GainPart, KeyRole, Keyed, chained, joined, keys, variants};
pub use shape::{
    Absent, Bound, Choice, Key, KeyKind, Keys, Unit, Variant, Word, compact, number, optional, required, word,
};
pub use slot::Slot;
pub use tabled::Tabled;
