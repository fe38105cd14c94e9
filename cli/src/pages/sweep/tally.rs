//! Figures of all variants of a sweep, read from its table part by part.

use std::collections::BTreeMap;
use std::path::Path;

use feeler_studies::sweep::{SweepError, SweepTable};

/// Largest number of variants whose outcomes a page holds: 2.8 MB of text.
const MOST_CODES: usize = 2_000_000;

/// Outcomes of the variants.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    pub(crate) rows: usize,
    /// Number of variants by outcome: `error` if they failed, `done` if outcomes were not kept.
    pub(crate) outcomes: BTreeMap<String, usize>,
    /// The outcome of each variant as an index into the names of [`super::labels`]. Variants beyond the
    /// largest number are absent.
    pub(super) codes: Vec<u8>,
    pub(crate) largest_peak_n: Option<f64>,
    /// The first failed variant, and the reason.
    pub(super) first_error: Option<(usize, String)>,
}

impl Tally {
    /// Counts the rows of a table of results.
    pub(crate) fn of(path: &Path) -> Result<Self, SweepError> {
        let mut tally = Self::default();
        SweepTable::scan(
            path,
            &|name| ["outcome", "error", "peak_force_n"].contains(&name),
            &mut |first, part| tally.add(first, &part),
        )?;
        Ok(tally)
    }

    fn add(&mut self, first: usize, part: &SweepTable) {
        self.rows += part.rows;
        let codes = outcomes(part).map(|name| super::palette::labels().position(|(known, _)| known == name));
        let room = MOST_CODES.saturating_sub(self.codes.len());
        self.codes.extend(codes.map(|code| code.unwrap_or_default() as u8).take(room));
        for name in outcomes(part) {
            match self.outcomes.get_mut(name) {
                Some(count) => *count += 1,
                None => drop(self.outcomes.insert(name.to_owned(), 1)),
            }
        }
        let largest = part.reals("peak_force_n").unwrap_or_default().into_iter().flatten().reduce(f64::max);
        self.largest_peak_n = self.largest_peak_n.into_iter().chain(largest).reduce(f64::max);
        if self.first_error.is_none() {
            let mut errors = part.texts("error").unwrap_or_default().iter().enumerate();
            self.first_error = errors.find_map(|(row, error)| Some((first + row, error.clone()?)));
        }
    }

    pub(super) fn count(&self, name: &str) -> usize {
        self.outcomes.get(name).copied().unwrap_or(0)
    }
}

/// The outcome of each row by name.
pub(super) fn outcomes(table: &SweepTable) -> impl Iterator<Item = &str> {
    let (outcomes, errors) =
        (table.texts("outcome").unwrap_or_default(), table.texts("error").unwrap_or_default());
    (0..table.rows).map(move |row| {
        let failed = errors.get(row).is_some_and(Option::is_some);
        if failed { "error" } else { outcomes.get(row).and_then(Option::as_deref).unwrap_or("done") }
    })
}
