//! Content of the page of a sweep.

use feeler_studies::sweep::{DrawnAxis, Sweep, SweepTable};

use super::drawn::Drawn;
use super::tally::Tally;
use crate::units::Units;

/// A sweep with the data of all drawings.
pub(super) struct Report<'a> {
    pub(super) sweep: &'a Sweep,
    /// The drawn variants.
    pub(super) table: &'a SweepTable,
    /// Figures of all variants.
    pub(super) tally: &'a Tally,
    pub(super) drawn: &'a Drawn,
    pub(super) axes: Vec<DrawnAxis>,
    /// Name of the outcome of each row: `error` for a failed variant, `done` if outcomes are not kept.
    pub(super) outcomes: Vec<String>,
    pub(super) units: Units,
    /// Word and unit of what decides the outcomes: a force, or a motion if nothing can touch.
    pub(super) judged: (&'static str, &'static str),
}
