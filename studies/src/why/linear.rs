//! Linear theory of the loop: its distance from the limit, and its bandwidth.

use feeler_analysis::{Band, ControlLoop, SampledLoop, gain, leading_gain, modes, with_gain};
use feeler_control::{AdmittanceGains, GainPart, Law};
use feeler_engine::Scenario;
use feeler_lti::TimeDomain;
use rayon::prelude::*;

use super::change::{Counterfactual, sampled_faster};
use super::explanation::{Lift, in_contact};
use crate::numbers::{plain, two_digits};
use crate::operating_point::contact_view;
use crate::sweep::sampled_growth_per_s;

/// A limit that rises by less than this factor is the same.
const LIFTED: f64 = 1.02;
/// Smallest relevant factor of the loop's gain; the largest is its inverse.
const SMALLEST_FACTOR: f64 = 0.02;

/// The loop in contact with the drives' gain scaled.
fn scaled(whole: &ControlLoop, factor: f64) -> Option<ControlLoop> {
    whole.altered(|assembly, _| assembly.drives.iter_mut().for_each(|drive| drive.gain *= factor)).ok()
}

fn is_stable(whole: &ControlLoop, factor: f64) -> Option<bool> {
    sampled_growth_per_s(&scaled(whole, factor)?).ok().map(|rate| rate < 0.0)
}

/// Whether the sampled loop in contact is stable; `None` if linear theory has no answer.
pub(super) fn is_stable_in_contact(scenario: &Scenario) -> Option<bool> {
    let whole = ControlLoop::new(scenario, &contact_view(scenario)).ok()?;
    is_stable(&whole, 1.0)
}

/// The largest factor on the loop's gain up to which it is stable in contact. It is below one if the loop is
/// unstable, infinite if no reasonable factor destabilises it, zero if no smaller gain helps.
pub(super) fn gain_margin(scenario: &Scenario) -> Option<f64> {
    let whole = ControlLoop::new(scenario, &contact_view(scenario)).ok()?;
    let bands = whole.stable_factors().ok()?;
    let upper = |band: &Band| band.upper.as_ref().map_or(f64::INFINITY, |edge| edge.gain);
    let lower = |band: &Band| band.lower.as_ref().map_or(0.0, |edge| edge.gain);
    // Gains below the first stable one do not count: an open loop may be unstable.
    let first = bands.bands.iter().find(|band| upper(band) > SMALLEST_FACTOR);
    let first = first.filter(|band| lower(band) < SMALLEST_FACTOR.recip());
    let within = |factor: f64| if factor > SMALLEST_FACTOR.recip() { f64::INFINITY } else { factor };
    Some(first.map_or(0.0, |band| within(upper(band))))
}

/// Text: how far a loop's gain is above its limit in contact, from its margin below one. It names the gain
/// and its limit if there is only one gain.
pub(super) fn above_limit(scenario: &Scenario, margin: f64) -> String {
    let over = plain(two_digits(100.0 * (margin.recip() - 1.0)));
    only_gain(scenario).map_or_else(
        || format!("the loop's gain is {over} % above its limit{}", in_contact(scenario)),
        |(name, value)| {
            let [value, limit] = [value, margin * value].map(plain);
            format!("{name} = {value} is {over} % above the limit of {limit}{}", in_contact(scenario))
        },
    )
}

/// Factors from this one on are written as such, and smaller ones as percentages.
const MANIFOLD: f64 = 2.0;

/// Text: a loop whose gain is below its limit, and by how much.
pub(super) fn below_limit(scenario: &Scenario, margin: f64) -> String {
    let in_contact = in_contact(scenario);
    let only = only_gain(scenario);
    if !margin.is_finite() {
        return format!("the loop is stable{in_contact}, and at every larger gain tried");
    }
    let (times, percent) = (plain(two_digits(margin)), plain(two_digits(100.0 * (margin - 1.0))));
    match (only, margin >= MANIFOLD) {
        (Some((name, value)), is_manifold) => {
            let [value, limit] = [value, margin * value].map(plain);
            let more =
                if is_manifold { format!("{times} times as much") } else { format!("{percent} % more") };
            format!("{name} = {value} is stable{in_contact} up to {limit}, {more}")
        }
        (None, true) => format!("the loop is stable{in_contact} up to {times} times its gain"),
        (None, false) => format!("the loop is stable{in_contact} up to {percent} % more gain"),
    }
}

/// The limit of the loop's gain without each property that linear theory knows, the largest first.
pub(super) fn lifts(scenario: &Scenario, from: f64) -> Vec<Lift> {
    let limit = |change: &Counterfactual| {
        let changed = change.applied(scenario);
        let to = if changed == *scenario { None } else { gain_margin(&changed) };
        to.filter(|to| *to > LIFTED * from).map(|to| (*change, to))
    };
    let mut found: Vec<_> = Counterfactual::OF_THE_LOOP.par_iter().filter_map(limit).collect();
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    let lift =
        |(change, to): (Counterfactual, f64)| Lift { change, from, to: Some(to).filter(|to| to.is_finite()) };
    found.into_iter().map(lift).collect()
}

/// The gain of the only loop, if it has but one: a factor on the loop is then one on this gain.
fn only_gain(scenario: &Scenario) -> Option<(&'static str, f64)> {
    let mut closing = scenario.controllers.values().filter(|used| !matches!(used.spec.law, Law::OpenLoop));
    let (spec, None) = (&closing.next()?.spec, closing.next()) else { return None };
    let damping = match &spec.law {
        Law::ExplicitForce(gains) => gains.damping,
        Law::Position(gains) => gains.damping,
        Law::OpenLoop | Law::Impedance(_) | Law::Admittance(_) => return None,
    };
    let leading = leading_gain(spec)?;
    let value = gain(spec, leading).ok().filter(|value| *value != 0.0)?;
    let mut open = spec.law.clone();
    scale_errors(&mut open, 0.0);
    let is_only = damping == 0.0 && with_gain(spec, leading, 0.0).is_ok_and(|without| without.law == open);
    is_only.then_some((leading, value))
}

/// Growth within a period that may be rounding.
const ROUNDING: f64 = 1e-9;
/// Remaining growth, relative to that of the unchanged loop, that is within the error of the extrapolation.
const GROWTH_LEFT: f64 = 0.01;

/// Scales a law's gains on errors; damping stays.
pub(crate) fn scale_errors(law: &mut Law, factor: f64) {
    // The loop's gain falls as the virtual body grows heavier.
    if let Law::Admittance(AdmittanceGains { mass, damping, .. }) = law {
        for gain in [mass, damping] {
            *gain /= factor;
        }
        return;
    }
    for part in [GainPart::Proportional, GainPart::Integral, GainPart::Derivative, GainPart::Reading] {
        if let Some(gain) = law.gain(part) {
            let scaled = gain.number(law).unwrap_or_default() * factor;
            gain.set_number(law, scaled);
        }
    }
}

/// Whether a loop that grows in contact does so only because of its period. `faster` is the same loop at a
/// much shorter one. A line through the growth at that period and at half of it must reach zero at zero
/// period. A loop may be unstable at every gain and period, and yet stable in continuous time.
pub(super) fn grows_only_by_period(scenario: &Scenario, faster: &Scenario) -> bool {
    let growth = |scenario: &Scenario| {
        sampled_growth_per_s(&ControlLoop::new(scenario, &contact_view(scenario)).ok()?).ok()
    };
    let [as_it_is, short, shorter] = [scenario, faster, &sampled_faster(faster, 2.0)].map(growth);
    let Some(((as_it_is, short), shorter)) = as_it_is.zip(short).zip(shorter) else { return false };
    let period_s = scenario.controllers.values().map(|used| used.spec.period_s).fold(f64::INFINITY, f64::min);
    as_it_is * period_s > ROUNDING && short > 0.0 && 2.0 * shorter - short < GROWTH_LEFT * as_it_is
}

/// Whether the loop in contact pushes itself away as with feedback of the wrong sign. Its fastest motion
/// grows without oscillation, and with reversed sign it does not.
pub(super) fn has_wrong_sign(scenario: &Scenario) -> bool {
    let Ok(whole) = ControlLoop::new(scenario, &contact_view(scenario)) else { return false };
    oscillates_as_it_grows(&whole) == Some(false)
        && scaled(&whole, -1.0).is_some_and(|reversed| oscillates_as_it_grows(&reversed) != Some(false))
}

/// Damping ratios below this are rounding.
const NO_DAMPING: f64 = 1e-9;

/// Whether the machine in contact has an undamped mode: bouncing on it loses no energy either.
pub(super) fn is_undamped(scenario: &Scenario) -> bool {
    let found = ControlLoop::new(scenario, &contact_view(scenario)).and_then(|whole| modes(whole.plant()));
    found.is_ok_and(|found| {
        found.iter().any(|mode| mode.frequency_hz() > 0.0 && mode.damping_ratio().abs() < NO_DAMPING)
    })
}

/// Whether the fastest growing motion of a loop oscillates; `None` if none grows.
fn oscillates_as_it_grows(whole: &ControlLoop) -> Option<bool> {
    let sampled = SampledLoop::new(whole).ok()?;
    let domain = sampled.domain().ok()?;
    let poles = sampled.eigenvalues().ok()?.into_iter().map(|pole| domain.s_of_point(pole));
    let fastest = poles.max_by(|a, b| a.re.total_cmp(&b.re)).filter(|pole| pole.re > 0.0)?;
    Some(fastest.im.abs() > 1e-9 * fastest.norm())
}

/// The bandwidth of the force loop in contact, as sampled, Hz.
pub(super) fn bandwidth_hz(scenario: &Scenario) -> Option<f64> {
    let whole = ControlLoop::new(scenario, &contact_view(scenario)).ok()?;
    let controller = crate::run::ForceLoop::find(scenario).map_or(0, |found| found.controller);
    whole.bandwidth_hz(controller).ok()?
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use feeler_files::{Document, Setting};

    fn bandwidth(settings: &[(&str, f64)]) -> f64 {
        let document = Document::load(
            &Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenarios"))
                .join("paper/flexible-contact.toml"),
        )
        .unwrap();
        let settings = settings.iter().map(|(key, value)| (*key, Setting::Number(*value)));
        bandwidth_hz(&document.with(settings).unwrap().scenario).unwrap()
    }

    #[test]
    fn prop_a_lower_gain_gains_no_bandwidth() {
        let gains = [0.8, 0.4, 0.2, 0.1, 0.05].map(|kp| bandwidth(&[("controllers.force.kp", kp)]));
        assert!(gains.windows(2).all(|pair| pair[1] <= pair[0]), "{gains:?}");
    }

    #[test]
    fn prop_damping_alone_does_not_multiply_the_bandwidth() {
        let (without, with) = (bandwidth(&[]), bandwidth(&[("springs.guide.damping", 600.0)]));
        assert!(with < 1.5 * without, "{with} {without}");
    }
}
