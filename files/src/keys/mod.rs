//! Every key of every file, one line each.
use feeler_catalogue::{Absent, Key, KeyKind, Keyed, Keys, keys, optional};
use feeler_engine::RunSettings;
use feeler_plant::description::Axis;
use feeler_plant::effects::HostKind;

pub(crate) mod arm;
pub(crate) mod cell;
mod controllers;
pub(crate) mod dataset;
mod machine;
pub(crate) mod surface;
pub(crate) mod sweep;

pub(crate) use arm::{ARM, JOINT};
pub(crate) use cell::{CELL, CELL_TABLES, HOLD, PLACED, SHARED, START};
pub(crate) use controllers::CONTROLLERS;
pub(crate) use dataset::{COLUMN, DATASET, EXPERIMENT};
pub(crate) use machine::{ACTUATORS, BODIES, CONTACTS, KIND, LAW, SENSORS, SPRINGS};
pub(crate) use sweep::{AXIS, KEEP, REFINE, SWEEP};

/// A table of named elements, as `[bodies.NAME]`.
#[derive(Debug)]
pub(crate) struct Element {
    pub(crate) table: &'static str,
    /// Word for a single element.
    pub(crate) singular: &'static str,
    pub(crate) text: &'static str,
    pub(crate) shape: Keys,
    /// Kinds of the element in the effects library; some depend on the element's own keys.
    pub(crate) hosts: &'static [HostKind],
}

/// The table of how to run.
pub(crate) const RUN_TABLE: &str = "run";

/// `[run]`
pub(crate) static RUN: Keys = Keys { keys: keys!(RunSettings::FIELDS), choice: None };

/// Tables of named elements, in the order of the manual.
pub(crate) static ELEMENTS: [&Element; 6] =
    [&BODIES, &SPRINGS, &CONTACTS, &ACTUATORS, &SENSORS, &CONTROLLERS];

pub(crate) const NAME: Key = optional("name", KeyKind::Text, "short name; the file's own if absent");
pub(crate) const ABOUT: Key = optional("about", KeyKind::Text, "what it is for, in one or two sentences");
pub(crate) const AXIS_KIND: Key = Key {
    name: "axis",
    kind: KeyKind::Word(Axis::WORDS),
    absent: Absent::Word(Axis::Translational.name()),
    text: "kind of coordinate",
};
pub(crate) const BASE: Key =
    optional("machine", KeyKind::Text, "a base file, relative to this one; keys here replace its keys");

/// Keys at the top of a machine or scenario.
pub(crate) static TOP: &[Key] = &[NAME, ABOUT, AXIS_KIND, BASE];

/// The table of tolerances.
pub(crate) const TOLERANCE: &str = "tolerance";
/// Meaning of `[tolerance]`.
pub(crate) const TOLERANCE_TEXT: &str = "how far a believed value may be off before that counts as a \
    finding, as the logarithm of a factor: 0.05 is about 5 %, 0.5 allows factors from 0.61 to 1.65. Dotted \
    keys in quotes, as in \"bodies.motor.mass\" = 0.05";
/// The table of effects under an element.
pub(crate) const EFFECTS: &str = "effects";
