//! Declarations shared by keys of several crates.

use crate::dimension::Dimension;
use crate::shape::{Bound, Key, KeyKind, Keys, Unit, optional, required};

/// A longer delay is a mistaken unit, since a delay stores past values.
pub const LONGEST_DELAY: Bound = Bound::Within(0.0, 1e3);

/// Corner frequency of a low-pass.
pub const CORNER: Key = required(
    "corner",
    KeyKind::Quantity(Unit::Of(Dimension::FREQUENCY), Bound::Positive),
    "corner (first order) or natural (second order) frequency",
);

/// Damping ratio of a low-pass.
pub const DAMPING_RATIO: Key = optional(
    "damping_ratio",
    KeyKind::Quantity(Unit::Of(Dimension::NONE), Bound::Positive),
    "of a second-order filter; first order if absent",
);

/// Name of the key of the law of a contact or a controller.
pub const LAW: &str = "law";

/// Name of the key of a low-pass.
pub const LOW_PASS: &str = "low_pass";

/// A key that holds a low-pass: a corner frequency, or a table.
pub const fn low_pass(text: &'static str) -> Key {
    static PARTS: Keys = Keys { keys: &[CORNER, DAMPING_RATIO], choice: None };
    optional(LOW_PASS, KeyKind::QuantityOrTable(CORNER.name, Unit::Of(Dimension::FREQUENCY), &PARTS), text)
}
