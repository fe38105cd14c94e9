//! Believed values at the limits of their tolerances: their true values may lie beyond. Values fitted
//! together with them are then off as well.

use crate::dataset::Dataset;
use crate::fit::scored::Scored;

/// Largest delay of commands without a stated hold that raises no doubt, rows. A fast drive interpolates
/// between rows or holds each value, and both act early. A later command may be a short lag.
const MOST_LATE_ROWS: f64 = 0.2;

/// The believed values at the limits of their tolerances, and commands that act late or at the limit of their
/// timing, in words.
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
