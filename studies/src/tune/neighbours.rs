//! Controllers beside a proposal. One run at the edge of chatter proves nothing: neighbours must rest too.

use feeler_control::{ControllerSpec, Law, LowPassSpec, NotchSpec};
use feeler_files::rounded;

use super::knobs::Knobs;

/// Share by which gains and frequencies are moved, up and down. Force sensor and drive are calibrated to a
/// few per cent each, which scales the loop's gain by about this share. A stiffness or mass known to ten per
/// cent moves a mode by the same share relative to a filter.
const NEAR: f64 = 0.05;
/// A sampled filter is moved no higher than this, over the sampling rate; its corner must be below a half.
const HIGHEST: f64 = 0.49;
/// Digits of a neighbour's name.
const DIGITS: usize = 3;

/// The gains on errors together, and each frequency of filter, notch and lead, moved up and down; each with
/// its name. A filter without room above has no neighbour there.
pub(super) fn neighbours(tuned: &ControllerSpec) -> Vec<(String, ControllerSpec)> {
    let mut found = Vec::new();
    for times in [1.0 - NEAR, 1.0 + NEAR] {
        let mut add = |times: f64, what: &str, spec| {
            if spec != *tuned {
                found.push((format!("{} of {what}", rounded(times, DIGITS)), spec));
            }
        };
        add(times, "the gains", Knobs::with_share(tuned, times));
        let most_hz = HIGHEST / tuned.period_s;
        let at = |frequency_hz: f64| (times * frequency_hz).min(most_hz.max(frequency_hz));
        if let Some(filter) = tuned.reading_low_pass {
            let cutoff_hz = at(filter.cutoff_hz);
            let moved = Some(LowPassSpec { cutoff_hz, ..filter });
            let spec = ControllerSpec { reading_low_pass: moved, ..tuned.clone() };
            add(cutoff_hz / filter.cutoff_hz, "the filter's corner", spec);
        }
        if let Some(notch) = tuned.reading_notch {
            let frequency_hz = at(notch.frequency_hz);
            let moved = Some(NotchSpec { frequency_hz, ..notch });
            let spec = ControllerSpec { reading_notch: moved, ..tuned.clone() };
            add(frequency_hz / notch.frequency_hz, "the notch's frequency", spec);
        }
        let mut moved = tuned.clone();
        if let Law::ExplicitForce(gains) = &mut moved.law
            && let Some(lead) = &mut gains.lead
        {
            (lead.zero_hz, lead.pole_hz) = (times * lead.zero_hz, times * lead.pole_hz);
            add(times, "the lead's frequencies", moved);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use feeler_control::ForceGains;

    use super::*;

    /// Corners that a filter of 1 kHz has in the neighbours of one, Hz.
    fn corners(cutoff_hz: f64) -> Vec<f64> {
        let law = Law::ExplicitForce(ForceGains { kp: 1.0, ..ForceGains::default() });
        let filter = LowPassSpec { cutoff_hz, damping_ratio: None };
        let tuned = ControllerSpec { reading_low_pass: Some(filter), ..ControllerSpec::new(law, 1e-3) };
        let found = neighbours(&tuned);
        let of_filter = found.iter().filter(|(what, _)| what.ends_with("corner"));
        of_filter.map(|(_, spec)| spec.reading_low_pass.unwrap().cutoff_hz).collect()
    }

    #[test]
    fn regress_a_neighbour_above_a_corner_is_never_below_it() {
        for (cutoff_hz, wanted) in
            [(100.0, vec![95.0, 105.0]), (480.0, vec![456.0, 490.0]), (495.0, vec![470.25])]
        {
            let found = corners(cutoff_hz);
            let close = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-9;
            assert!(found.len() == wanted.len() && found.iter().zip(&wanted).all(close), "{found:?}");
        }
    }
}
