//! An analysis in plain words.

use feeler_analysis::{Limit, ModeClass, Report};

use crate::numbers::{plain, with_unit};

/// The name of a class.
pub(crate) fn class_name(class: ModeClass) -> &'static str {
    match class {
        ModeClass::Colocated => "colocated",
        ModeClass::Noncolocated => "noncolocated",
        ModeClass::Uninvolved => "uninvolved",
    }
}

/// Which of the three problems limits the bandwidth, how far the gain may rise, and what to change first.
pub(crate) fn sentences(report: &Report) -> Vec<String> {
    let Some(gain) = &report.gain else {
        return vec![format!("No controller closes a loop: poles, zeros and modes from {} to {}.", report.input, report.output)];
    };
    let mut said = Vec::new();
    match (report.limit, gain.sampled.all.bands.is_empty()) {
        (_, true) => said.push(format!("No value of {} makes this loop stable.", gain.key)),
        (Some(limit), _) => said.push(limited(report, limit)),
        (None, _) => {
            said.push("Which problem limits this loop cannot be told: it has no continuous counterpart, or varies in time.".to_owned());
        }
    }
    let [low, high] = gain.sampled.stable;
    if let Some(high) = high {
        let at = gain.sampled.edge_hz.map_or_else(String::new, |f| format!(", where it begins to swing at {}", with_unit(f, "Hz")));
        let from = low.filter(|low| *low > 0.0).map_or_else(String::new, |low| format!(" from {}", plain(low)));
        let unbounded = gain.continuous.as_ref().is_some_and(|range| !range.all.bands.is_empty() && range.stable[1].is_none());
        let paper = if unbounded { "; on paper, without sampling, no gain is too large" } else { "" };
        said.push(format!("Sampled, the loop is stable{from} up to {} = {}{at}{paper}.", gain.key, plain(high)));
    }
    if report.margins.as_ref().is_some_and(|margins| margins.unstable_poles > 0) {
        said.push("As set in the file, the loop is unstable.".to_owned());
    }
    if let Some(cycle) = report.limit_cycles.iter().find(|cycle| cycle.stable) {
        said.push(format!(
            "In contact that only pushes, describing functions predict chatter at {} with peaks of {}.",
            with_unit(cycle.frequency_hz, "Hz"),
            with_unit(cycle.peak_force_n, "N")
        ));
    }
    let telling = report.sensitivities.iter().filter(|s| s.bandwidth_relative.is_finite() && s.bandwidth_relative.abs() > 1e-3).take(3);
    let first: Vec<String> = telling
        .map(|s| {
            let way = if s.bandwidth_relative > 0.0 { "more" } else { "less" };
            format!("{way} {} (1 % gives {} %)", s.key, plain(s.bandwidth_relative.abs()))
        })
        .collect();
    if !first.is_empty() {
        said.push(format!("For more bandwidth, first: {}.", first.join("; ")));
    }
    said
}

fn limited(report: &Report, limit: Limit) -> String {
    let achieved = report.waterfall.as_ref().and_then(|w| w.stages.last()).and_then(|stage| stage.bandwidth_hz);
    let reach = achieved.map_or_else(String::new, |f| format!(", to {} at half of the largest stable gain", with_unit(f, "Hz")));
    let modes = |class: ModeClass| {
        let of_class = report.modes.iter().filter(|mode| mode.class == class && !mode.rigid_body);
        let list: Vec<String> = of_class.map(|mode| with_unit(mode.frequency_hz, "Hz")).collect();
        if list.is_empty() { String::new() } else { format!(" ({})", list.join(", ")) }
    };
    let what = match limit {
        Limit::RigidBody => "The rigid body and its actuator limit".to_owned(),
        Limit::NoncolocatedMode => format!("A noncolocated mode{} limits", modes(ModeClass::Noncolocated)),
        Limit::ColocatedMode => format!("A colocated mode{} limits", modes(ModeClass::Colocated)),
        Limit::Sampling => "Sampling, that is hold, delay and filters of the controller, limits".to_owned(),
        Limit::Saturation => "The limit of the drive's force or command, rather than stability, limits".to_owned(),
    };
    format!("{what} the bandwidth{reach}.")
}
