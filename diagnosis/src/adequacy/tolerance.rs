//! Believed values that end at the limit of their tolerance: their true values may lie beyond, and values
//! fitted beside them are then off as well.

use crate::fit::scored::Scored;

/// The believed values at the limits of their tolerances, in words.
pub(super) fn ends(accepted: &Scored) -> Vec<String> {
    let (model, theta) = (&accepted.fitted.model, &accepted.fitted.theta);
    let say = |(key, off): (String, f64)| {
        format!(
            "{key} ends at the limit of its tolerance ({off:+.0} %): its true value may lie beyond, and the \
             values of the causes are then off too (state a wider tolerance, or correct the believed value)"
        )
    };
    model.at_ends(theta).into_iter().map(say).collect()
}
