//! Controllers beside a proposal. One run at the edge of chatter proves nothing: neighbours must rest too.

use feeler_control::{ControllerSpec, Law};

use super::knobs::Knobs;

/// How far gains and frequencies are moved, either way. Force sensor and drive are calibrated to a few per
/// cent each, which scales the loop's gain by about this. A stiffness or mass known to ten per cent moves a
/// mode by as much against a filter.
const NEAR: f64 = 0.05;
/// The highest corner that a sampled filter may have, over the sampling rate.
const HIGHEST: f64 = 0.49;

/// The gains on errors together, and each frequency of filter, notch and lead, moved up and down; each with
/// its name.
pub(super) fn neighbours(tuned: &ControllerSpec) -> Vec<(String, ControllerSpec)> {
    let mut found = Vec::new();
    for times in [1.0 - NEAR, 1.0 + NEAR] {
        let mut add = |what: &str, spec| found.push((format!("{times} of {what}"), spec));
        add("the gains", Knobs::with_share(tuned, times));
        let at = |frequency_hz: f64| (times * frequency_hz).min(HIGHEST / tuned.period_s);
        if let Some(mut filter) = tuned.reading_low_pass {
            filter.cutoff_hz = at(filter.cutoff_hz);
            add("the filter's corner", ControllerSpec { reading_low_pass: Some(filter), ..tuned.clone() });
        }
        if let Some(mut notch) = tuned.reading_notch {
            notch.frequency_hz = at(notch.frequency_hz);
            add("the notch's frequency", ControllerSpec { reading_notch: Some(notch), ..tuned.clone() });
        }
        let mut moved = tuned.clone();
        if let Law::ExplicitForce(gains) = &mut moved.law
            && let Some(lead) = &mut gains.lead
        {
            (lead.zero_hz, lead.pole_hz) = (times * lead.zero_hz, times * lead.pole_hz);
            add("the lead's frequencies", moved);
        }
    }
    found
}
