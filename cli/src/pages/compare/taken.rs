//! A scenario of a comparison, with its results.

use feeler_analysis::{Curves, Report};
use feeler_files::Document;
use feeler_studies::glimpse::Glimpse;
use feeler_studies::run::RunResult;

use crate::units::Units;

/// A scenario with its results.
pub(crate) struct Taken {
    pub(crate) name: String,
    pub(crate) document: Document,
    pub(crate) glimpse: Glimpse,
}

impl Taken {
    pub(super) fn run(&self) -> Option<&RunResult> {
        self.glimpse.run.as_ref().ok()
    }

    pub(super) fn theory(&self) -> Option<&(Report, Curves)> {
        self.glimpse.theory.as_ref().ok()
    }

    pub(super) fn units(&self) -> Units {
        Units::of(&self.document.scenario.machine)
    }
}
