//! Limit cycles of a contact that only pushes, as a table.

use feeler_analysis::{LimitCycle, Report};

use crate::numbers::{percent, plain};

/// Heads of the table's columns.
pub(crate) const HEADER: [&str; 5] =
    ["cycle", "frequency (Hz)", "peak force (N)", "time in contact (%)", "of the command passed (%)"];
/// Columns of numbers.
pub(crate) const NUMBERS: [usize; 4] = [1, 2, 3, 4];

/// One row for each cycle.
pub(crate) fn rows(report: &Report) -> Vec<Vec<String>> {
    let row = |cycle: &LimitCycle| {
        let kind = if cycle.stable { "attracts: chatter" } else { "repels: smaller motions settle" };
        let shares = [cycle.contact_share, cycle.drive_share].map(percent);
        [kind.to_owned(), plain(cycle.frequency_hz), plain(cycle.peak_force_n)]
            .into_iter()
            .chain(shares)
            .collect()
    };
    report.limit_cycles.iter().map(row).collect()
}
