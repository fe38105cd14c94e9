//! An analysis in plain words.

use feeler_analysis::{Edge, Limit, ModeClass, RankedBy, Report, Sensitivity, WhyNoWaterfall};

use crate::numbers::{plain, two_digits, with_unit};

pub(crate) fn class_name(class: ModeClass) -> &'static str {
    match class {
        ModeClass::Colocated => "colocated",
        ModeClass::Noncolocated => "noncolocated",
        ModeClass::Uninvolved => "uninvolved",
    }
}

/// The signals of poles, zeros and modes, and those of the rest if they differ.
pub(crate) fn subject(report: &Report) -> String {
    let asked = format!("from {} to {}", report.input, report.output);
    match report.pair() {
        Some(of) if of.input != report.input || of.output != report.output => format!(
            "{asked}: poles, zeros, and class and phase of the modes\nGains, margins, phase at the \
             crossover, bandwidth and advice are those of the loop of controllers.{}, from {} to {}.",
            of.controller, of.input, of.output
        ),
        _ => asked,
    }
}

/// Heading of the column with the effect of a change on the achieved quantity.
pub(crate) fn achieved_name(report: &Report) -> &'static str {
    if report.ranked_by() == Some(RankedBy::Saturation) { "saturation frequency" } else { "bandwidth" }
}

/// Limits of a fragile loop: phase margins below this, and sensitivities above.
const FRAGILE_DEG: f64 = 30.0;
const FRAGILE_SENSITIVITY: f64 = 3.0;

/// State of the loop with the gain of the file, its margins, its limit and what sets it, in one sentence.
/// `None` if no loop is closed.
pub(crate) fn as_set(report: &Report) -> Option<String> {
    let gain = report.gain()?;
    let key = gain.key.rsplit('.').next().unwrap_or(&gain.key);
    let set = format!("{key} = {}", plain(gain.present));
    let by = report.limit().and_then(sets).map_or_else(String::new, |what| format!(", set by {what}"));
    let swings = gain
        .sampled
        .edge_hz
        .map_or_else(String::new, |f| format!(", where it oscillates at {}", with_unit(f, "Hz")));
    let limit = gain.sampled.stable[1].filter(|limit| *limit > 0.0);
    if gain.is_unstable_as_set() || report.margins().is_some_and(|margins| margins.unstable_poles > 0) {
        let beyond = limit.filter(|limit| gain.present > *limit).map_or_else(String::new, |limit| {
            let over = 100.0 * (gain.present / limit - 1.0);
            format!(": {} % above the limit of {}{by}{swings}", plain(over), plain(limit))
        });
        return Some(format!("{set} is unstable{beyond}."));
    }
    let top = limit.map_or_else(
        || ", and no larger gain is unstable".to_owned(),
        |limit| format!(", up to the limit of {}{by}{swings}", plain(limit)),
    );
    let margins = report.margins();
    let phase = margins.and_then(|margins| margins.phase_deg);
    let is_fragile = phase.is_some_and(|deg| deg < FRAGILE_DEG)
        || margins.is_some_and(|margins| margins.sensitivity_peak > FRAGILE_SENSITIVITY);
    let mut figures = Vec::new();
    figures.extend(phase.map(|deg| format!("phase margin {}°", plain(deg))));
    figures.extend(
        margins.and_then(|margins| margins.gain).map(|factor| format!("gain margin {}", plain(factor))),
    );
    let bandwidth = report.looped.as_ref().and_then(|looped| looped.bandwidth_hz);
    figures.extend(
        bandwidth.filter(|_| margins.is_some()).map(|hz| format!("bandwidth {}", with_unit(hz, "Hz"))),
    );
    let figures = if figures.is_empty() { String::new() } else { format!(" ({})", figures.join(", ")) };
    let how = if is_fragile { " but fragile" } else { "" };
    Some(format!("{set} is stable{how}{figures}{top}."))
}

/// What sets the largest stable gain, if it is a part of the loop.
fn sets(limit: Limit) -> Option<&'static str> {
    match limit {
        Limit::RigidBody => Some("the rigid body and its actuator"),
        Limit::NoncolocatedMode => Some("a noncolocated mode"),
        Limit::ColocatedMode => Some("a colocated mode"),
        Limit::Sampling => Some("sampling and delay"),
        Limit::Saturation | Limit::Nothing | Limit::UndampedMode => None,
    }
}

/// Which of the three problems limits the bandwidth, how far the gain may rise, and what to change first.
pub(crate) fn sentences(report: &Report) -> Vec<String> {
    let Some(gain) = report.gain() else {
        return vec![format!(
            "No controller closes a loop: poles, zeros and modes from {} to {}.",
            report.input, report.output
        )];
    };
    let mut said = Vec::new();
    match (report.limit(), gain.sampled.all.bands.is_empty()) {
        (_, true) => {
            let spans = gain.sampled.intervals.iter().map(|band| {
                let end = |edge: &Option<Edge>| {
                    edge.as_ref().map_or_else(|| "minus infinity".to_owned(), |edge| plain(edge.gain))
                };
                format!("from {} to {}", end(&band.lower), end(&band.upper))
            });
            let below = spans.collect::<Vec<_>>().join(" and ");
            let but =
                if below.is_empty() { String::new() } else { format!("; below zero it is stable {below}") };
            let undamped: Vec<String> = report.undamped_hz.iter().map(|f| with_unit(*f, "Hz")).collect();
            said.push(if undamped.is_empty() {
                format!("No value of {} from zero on makes this loop stable{but}.", gain.key)
            } else {
                let modes = if undamped.len() == 1 { "undamped mode" } else { "undamped modes" };
                format!(
                    "Unstable at any gain {} from zero on: {modes} at {}{but}. A held output, half a period \
                     late at best, feeds energy that nothing dissipates: give the \
                     machine the damping that it has.",
                    gain.key,
                    undamped.join(", ")
                )
            });
        }
        (Some(limit), _) => said.push(limited(report, limit)),
        (None, _) => {
            said.push(untold(report));
        }
    }
    let [low, high] = gain.sampled.stable;
    if let Some(high) = high {
        let at = gain.sampled.edge_hz.map_or_else(String::new, |f| {
            format!(", where it begins to oscillate at {}", with_unit(f, "Hz"))
        });
        let swings =
            |edge: &Edge| format!(" (where it oscillates at {})", with_unit(edge.frequency_hz, "Hz"));
        let low_edge = gain.sampled.edges[0]
            .as_ref()
            .filter(|edge| edge.frequency_hz > 0.0)
            .map_or_else(String::new, swings);
        let from = low
            .filter(|low| *low > 0.0)
            .map_or_else(String::new, |low| format!(" from {}{low_edge}", plain(low)));
        let unbounded = gain
            .continuous
            .as_ref()
            .is_some_and(|range| !range.all.bands.is_empty() && range.stable[1].is_none());
        let paper = if unbounded { "; on paper, without sampling, no gain is too large" } else { "" };
        said.push(format!(
            "Sampled, the loop is stable{from} up to {} = {}{at}{paper}.",
            gain.key,
            plain(high)
        ));
    }
    if let Some(cycle) = report.limit_cycles.iter().find(|cycle| cycle.stable) {
        said.push(format!(
            "In contact that only pushes, describing functions predict chatter at {} with peaks of {}.",
            with_unit(cycle.frequency_hz, "Hz"),
            with_unit(cycle.peak_force_n, "N")
        ));
    }
    said.extend(advice(report));
    said
}

/// Why no problem is named.
fn untold(report: &Report) -> String {
    match report.why_no_waterfall() {
        Some(WhyNoWaterfall::SlowerLoop { controller, period_s, common_s, slowest }) => {
            let remedy = slowest.as_ref().map_or_else(
                || {
                    "No controller has that period: make the slowest one's a multiple of all others, and \
                    name a gain of it with --gain."
                        .to_owned()
                },
                |slowest| format!("For the whole answer, name a gain of controllers.{slowest} with --gain."),
            );
            format!(
                "It is unknown which problem limits this loop: controllers.{controller} samples every {}, \
                 and all controllers repeat together only every {}. Broken at this one, the loop varies in \
                 time: it has no frequency response, and so neither margins nor bandwidth. Its stable gains \
                 are exact. {remedy}",
                with_unit(*period_s, "s"),
                with_unit(*common_s, "s")
            )
        }
        Some(WhyNoWaterfall::NoContinuousForm { controller }) => format!(
            "It is unknown which problem limits this loop. On paper, controllers.{controller} would \
             differentiate a signal that follows its command at once: there is no continuous loop to begin \
             from. Stable gains and margins are those of the sampled loop."
        ),
        None => "It is unknown which problem limits this loop.".to_owned(),
    }
}

/// Numbers named in an advice, and the smallest relative change that is named.
const NAMED: usize = 3;
const TELLING: f64 = 0.1;

/// A share whose further digits change no decision.
fn brief(share: f64) -> String {
    plain(two_digits(share))
}

/// What to change first, its effect, and changes that only seem to help.
fn advice(report: &Report) -> Vec<String> {
    let Some(by) = report.ranked_by() else { return Vec::new() };
    let mut said = Vec::new();
    if let Some(mode) = report.waterfall().and_then(|w| w.rides_mode).and_then(|i| report.modes.get(i)) {
        said.push(format!(
            "The bandwidth lies on the flank of the mode at {}, and moves with that peak. A softer or less \
             damped mode may seem to raise it. So changes are ranked by the largest stable gain.",
            with_unit(mode.frequency_hz, "Hz")
        ));
    }
    if by == RankedBy::Saturation
        && report.waterfall().and_then(|w| w.saturation_hz).is_some_and(|f| f <= 0.0)
    {
        said.push(
            "The reference asks for more than the drive's limit even at rest: no stiffness, mass or \
                   damping changes that, only a higher limit."
                .to_owned(),
        );
        return said;
    }
    let telling = |s: &&Sensitivity| s.worth(by).is_finite() && s.worth(by).abs() > TELLING;
    let way = |s: &Sensitivity| if s.worth(by) > 0.0 { "more" } else { "less" };
    let gives = |s: &Sensitivity| {
        let (bandwidth, gain) =
            (s.bandwidth_relative * s.worth(by).signum(), s.largest_gain_relative * s.worth(by).signum());
        match by {
            RankedBy::BandwidthAndGain => {
                let of = |share: f64, what: &str| format!("{} % of {what}", brief(share.abs()));
                let (bandwidth, gain) =
                    ((bandwidth, of(bandwidth, "bandwidth")), (gain, of(gain, "the largest gain")));
                match (bandwidth.0 < 0.0, gain.0 < 0.0) {
                    (true, _) => format!("{} and costs {}", gain.1, bandwidth.1),
                    (_, true) => format!("{} and costs {}", bandwidth.1, gain.1),
                    _ => format!("{} and {}", bandwidth.1, gain.1),
                }
            }
            RankedBy::LargestGain => format!("{} %", brief(gain)),
            RankedBy::Saturation => format!("{} %", brief(bandwidth)),
        }
    };
    let first: Vec<String> =
        (report.sensitivities().iter().filter(telling).filter(|s| !s.is_trade(by)).take(NAMED))
            .map(|s| format!("{} {} (1 % gives {})", way(s), s.key, gives(s)))
            .collect();
    let aim = match by {
        RankedBy::BandwidthAndGain => "For more bandwidth and gain",
        RankedBy::LargestGain => "For more gain",
        RankedBy::Saturation => "For a higher frequency at which the drive saturates",
    };
    let most = || report.sensitivities().iter().find(|s| s.worth(by).is_finite() && !s.is_trade(by));
    if !first.is_empty() {
        said.push(format!("{aim}, first: {}.", first.join("; ")));
    } else if let Some(most) = most() {
        said.push(format!(
            "No single mass, stiffness or damping helps much: the most telling is {} {}, of which 1 % gives \
             {}.",
            way(most),
            most.key,
            gives(most)
        ));
    }
    let trades =
        report.sensitivities().iter().filter(telling).filter(|s| s.is_trade(by)).take(NAMED).map(|s| {
            let [bandwidth, gain] = [s.bandwidth_relative, s.largest_gain_relative].map(f64::abs).map(brief);
            let (won, lost) =
                if s.bandwidth_relative > 0.0 { ("raises", "lowers") } else { ("lowers", "raises") };
            format!(
                "1 % more {} {won} the bandwidth by {bandwidth} % and {lost} the largest gain by {gain} %",
                s.key
            )
        });
    let trades = trades.collect::<Vec<_>>().join("; ");
    if !trades.is_empty() {
        said.push(format!("What trades one for the other: {trades}."));
    }
    said
}

/// Why no gain is too large.
fn unlimited(report: &Report) -> String {
    let Some(gain) = report.gain() else { return String::new() };
    if report.margins().is_some_and(|margins| margins.complementary_sensitivity_peak <= 0.0) {
        let reads = report.pair().map_or(&report.output, |of| &of.output);
        return format!(
            "Nothing limits the bandwidth: {reads} does not answer {} here, so that no loop is closed.",
            report.input
        );
    }
    format!("Nothing limits the bandwidth: no {} is too large.", gain.key)
}

fn limited(report: &Report, limit: Limit) -> String {
    let achieved = report.waterfall().and_then(|w| w.stages.last()).and_then(|stage| stage.bandwidth_hz);
    let reach = achieved.map_or_else(String::new, |f| {
        format!(", to {} at half of the largest stable gain", with_unit(f, "Hz"))
    });
    let modes = |class: ModeClass| {
        let of_class = report
            .modes
            .iter()
            .filter(|mode| mode.class_in_loop.unwrap_or(mode.class) == class && !mode.rigid_body);
        let list: Vec<String> = of_class.map(|mode| with_unit(mode.frequency_hz, "Hz")).collect();
        if list.is_empty() { String::new() } else { format!(" ({})", list.join(", ")) }
    };
    let what = match limit {
        Limit::RigidBody => "The rigid body and its actuator limit".to_owned(),
        Limit::NoncolocatedMode => format!("A noncolocated mode{} limits", modes(ModeClass::Noncolocated)),
        Limit::ColocatedMode => format!("A colocated mode{} limits", modes(ModeClass::Colocated)),
        Limit::Sampling => "Sampling, that is hold, delay and filters of the controller, limits".to_owned(),
        Limit::Saturation if achieved.is_some_and(|f| f <= 0.0) => {
            return "The limit of the drive's force or command is below what the reference asks for at rest: \
                    it is never reached."
                .to_owned();
        }
        Limit::Nothing => return unlimited(report),
        Limit::UndampedMode => return "An undamped mode makes every gain unstable.".to_owned(),
        Limit::Saturation => {
            "The limit of the drive's force or command, rather than stability, limits".to_owned()
        }
    };
    let of = report
        .pair()
        .filter(|of| of.controlled != of.output)
        .map_or_else(String::new, |of| format!(" of {}", of.controlled));
    format!("{what} the bandwidth{of}{reach}.")
}
