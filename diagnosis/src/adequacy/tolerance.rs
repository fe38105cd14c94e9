//! Believed values at the limits of their tolerances: their true values may lie beyond, and values fitted
//! beside them are then off as well.

use crate::dataset::Dataset;
use crate::fit::scored::Scored;

/// Rows by which commands without a stated hold may act late without doubt. A drive that is quick
/// follows lines from row to row, or holds each value, which is early; a short lag is late.
const MOST_LATE_ROWS: f64 = 0.2;

/// The believed values at the limits of their tolerances, and commands that act late, or as early as they
/// may, in words.
pub(super) fn limits(dataset: &Dataset, accepted: &Scored) -> Vec<String> {
    let (model, theta) = (&accepted.fitted.model, &accepted.fitted.theta);
    let say = |(key, [believed, fitted]): (String, [f64; 2])| {
        let off = if believed == 0.0 {
            format!("{fitted:+.3}")
        } else {
            format!("{:+.0} %", 100.0 * (fitted / believed - 1.0))
        };
        format!(
            "{key} ends at the limit of its tolerance ({off}): its true value may lie beyond; then \
             the values of the causes are off too (state a wider tolerance, or correct the believed value)"
        )
    };
    let values = model.at_limits(theta).into_iter().map(say);
    let rows = model.leeway(theta).late_rows;
    let is_doubtful = model.is_timing_at_limit(theta) || rows > MOST_LATE_ROWS;
    let column = dataset.first_sampled().filter(|_| is_doubtful);
    let shifted = column.map(|column| {
        format!(
            "commands of `{column}` act {rows:+.2} rows after theirs, as fitted: something else may shift \
             them, such as a delay or a lag (state `hold`)"
        )
    });
    values.chain(shifted).collect()
}
