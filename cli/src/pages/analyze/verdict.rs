//! An analysis in plain words.

use feeler_analysis::{
    Edge, GainReport, Limit, ModeClass, RankedBy, Relief, Report, Sensitivity, WhyNoWaterfall,
};

use crate::numbers::{plain, two_digits, with_unit};

pub(crate) fn class_name(class: ModeClass) -> &'static str {
    match class {
        ModeClass::Colocated => "colocated",
        ModeClass::Noncolocated => "noncolocated",
        ModeClass::Uninvolved => "uninvolved",
    }
}

/// The signals of poles, zeros and modes, and those of the other results if they differ.
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

/// Heading of the column with the effect of a change on bandwidth or saturation frequency.
pub(crate) fn achieved_name(report: &Report) -> &'static str {
    if report.ranked_by() == Some(RankedBy::Saturation) { "saturation frequency" } else { "bandwidth" }
}

/// Limits of a fragile loop: a smaller phase margin, or a larger sensitivity. A negative margin belongs to a
/// crossover at which less phase lag destabilises.
const FRAGILE_DEG: f64 = 30.0;
const FRAGILE_SENSITIVITY: f64 = 3.0;

/// State of the loop with the gain of the file: its margins, its limit and the cause of the limit, in one
/// sentence. `None` if no loop is closed.
pub(crate) fn as_set(report: &Report) -> Option<String> {
    let gain = report.gain()?;
    let key = gain.key.rsplit('.').next().unwrap_or(&gain.key);
    let set = format!("{key} = {}", plain(gain.present));
    let by = report.limit().and_then(sets).map_or_else(String::new, |what| format!(", set by {what}"));
    let swings = gain
        .sampled
        .edge_hz
        .map_or_else(String::new, |f| format!(", where the loop oscillates at {}", with_unit(f, "Hz")));
    let limit = gain.sampled.stable[1].filter(|limit| *limit > 0.0);
    if is_unstable(report, gain) {
        let beyond = limit.filter(|limit| gain.present > *limit).map_or_else(String::new, |limit| {
            let over = 100.0 * (gain.present / limit - 1.0);
            format!(": {} % above the limit of {}{by}{swings}", plain(two_digits(over)), plain(limit))
        });
        return Some(format!("{set} is unstable{beyond}."));
    }
    let top = limit.map_or_else(
        || ", and no larger gain is unstable".to_owned(),
        |limit| format!("; its limit is {}{by}{swings}", plain(limit)),
    );
    let margins = report.margins();
    let phase = margins.and_then(|margins| margins.phase_deg);
    let is_fragile = phase.is_some_and(|deg| deg.abs() < FRAGILE_DEG)
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

fn is_unstable(report: &Report, gain: &GainReport) -> bool {
    gain.is_unstable_as_set() || report.margins().is_some_and(|margins| margins.unstable_poles > 0)
}

/// The part of the loop that determines the largest stable gain, if there is one.
fn sets(limit: Limit) -> Option<&'static str> {
    match limit {
        Limit::RigidBody => Some("the rigid body and its actuator"),
        Limit::NoncolocatedMode => Some("a noncolocated mode"),
        Limit::ColocatedMode => Some("a colocated mode"),
        Limit::Sampling => Some("sampling and delay"),
        Limit::Saturation | Limit::Nothing | Limit::UndampedMode => None,
    }
}

/// Which of the three problems limits the bandwidth, what to change first, and how far the gain may rise.
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
                format!("No value of {} at or above zero makes this loop stable{but}.", gain.key)
            } else {
                let modes = if undamped.len() == 1 { "undamped mode" } else { "undamped modes" };
                format!(
                    "Unstable at any gain {} at or above zero: {modes} at {}{but}. A held output is half a \
                     period late at best. It feeds energy that nothing dissipates: give the machine the \
                     damping that it has.",
                    gain.key,
                    undamped.join(", ")
                )
            });
        }
        (Some(limit), _) => said.push(limited(report, limit)),
        (None, _) => {
            said.push(why_no_limit(report));
        }
    }
    said.extend(advice(report));
    said.extend(stable_interval(report, gain));
    said.extend(margin_of_all(report, gain));
    let unbounded = gain
        .continuous
        .as_ref()
        .is_some_and(|range| !range.all.bands.is_empty() && range.stable[1].is_none());
    if unbounded && gain.sampled.stable[1].is_some() {
        said.push("On paper, without sampling, no gain is too large.".to_owned());
    }
    if let Some(cycle) = report.limit_cycles.iter().find(|cycle| cycle.stable) {
        said.push(format!(
            "In contact that only pushes, describing functions predict chatter at {} with peaks of {}.",
            with_unit(cycle.frequency_hz, "Hz"),
            with_unit(cycle.peak_force_n, "N")
        ));
    }
    said
}

/// Relative difference below which a reader regards two numbers as equal.
const ALIKE: f64 = 0.01;

/// Reason why the gain margin differs from the ratio of limit to gain: it scales all gains together.
fn margin_of_all(report: &Report, gain: &GainReport) -> Option<String> {
    let margin = report.margins().filter(|margins| margins.unstable_poles == 0)?.gain?;
    let alone = gain.sampled.stable[1]? / gain.present;
    let (owner, key) = gain.key.rsplit_once('.')?;
    let is_alike = (margin / alone - 1.0).abs() < ALIKE;
    (!is_alike && alone.is_finite()).then(|| {
        format!(
            "The gain margin is a factor on the whole output of {owner}, all its gains together. The limit \
             is that of {key} alone."
        )
    })
}

/// The stable gains, if [`as_set`] does not state all of them.
fn stable_interval(report: &Report, gain: &GainReport) -> Option<String> {
    let [low, high] = gain.sampled.stable;
    let (low, high) = (low.filter(|low| *low > 0.0), high?);
    let is_stated = high > 0.0 && (gain.present > high || !is_unstable(report, gain));
    if is_stated && low.is_none() {
        return None;
    }
    let at = |edge: &Edge| format!(" (where it oscillates at {})", with_unit(edge.frequency_hz, "Hz"));
    let low_edge = gain.sampled.edges[0].as_ref().filter(|edge| edge.frequency_hz > 0.0);
    let from = low.map_or_else(String::new, |low| {
        format!(" from {}{}", plain(low), low_edge.map_or_else(String::new, at))
    });
    let begins = gain
        .sampled
        .edge_hz
        .map_or_else(String::new, |f| format!(", where it begins to oscillate at {}", with_unit(f, "Hz")));
    Some(format!("Sampled, the loop is stable{from} up to {} = {}{begins}.", gain.key, plain(high)))
}

/// Reason why no limiting problem is named.
fn why_no_limit(report: &Report) -> String {
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

/// Largest number of parameters named in advice, and the smallest relative change that is named.
const NAMED: usize = 3;
const TELLING: f64 = 0.1;
/// The smaller of two changes is left out if it is below this share of the larger.
const BESIDE: f64 = 0.1;

/// Effect of a 1 % increase of a number on bandwidth and limit, as in `(bandwidth +0.09 %, limit +0.37 %)`.
fn effect(s: &Sensitivity, by: RankedBy, way: f64) -> String {
    let (bandwidth, limit) = (way * s.bandwidth_relative, way * s.largest_gain_relative);
    // Further digits would not change a decision.
    let percent = |share: f64| {
        let sign = if share > 0.0 { "+" } else { "" };
        format!("{sign}{} %", plain(two_digits(share)))
    };
    match by {
        RankedBy::LargestGain => format!("({})", percent(limit)),
        RankedBy::Saturation => format!("({})", percent(bandwidth)),
        RankedBy::BandwidthAndGain => {
            let least = if s.is_trade(by) { 0.0 } else { BESIDE * bandwidth.abs().max(limit.abs()) };
            let both = [("bandwidth", bandwidth), ("limit", limit)];
            let named = both.into_iter().filter(|(_, share)| share.abs() >= least);
            let named = named.map(|(what, share)| format!("{what} {}", percent(share)));
            format!("({})", named.collect::<Vec<_>>().join(", "))
        }
    }
}

/// The first change to make with its effect, and changes whose benefit is only apparent.
fn advice(report: &Report) -> Vec<String> {
    let Some(by) = report.ranked_by() else { return Vec::new() };
    if by == RankedBy::Saturation
        && report.waterfall().and_then(|w| w.saturation_hz).is_some_and(|f| f <= 0.0)
    {
        return vec![
            "The reference asks for more than the drive's limit even at rest: no stiffness, mass or damping \
             changes that, only a higher limit."
                .to_owned(),
        ];
    }
    let mut said = Vec::new();
    let better = |s: &Sensitivity| {
        let way = s.worth(by).signum();
        format!("1 % {} {} {}", if way > 0.0 { "more" } else { "less" }, s.key, effect(s, by, way))
    };
    let telling = |s: &&Sensitivity| s.worth(by).is_finite() && s.worth(by).abs() > TELLING;
    let (trades, others): (Vec<_>, Vec<_>) =
        report.sensitivities().iter().filter(telling).partition(|s| s.is_trade(by));
    let first: Vec<String> = others.into_iter().take(NAMED).map(better).collect();
    let aim = match by {
        RankedBy::BandwidthAndGain => "bandwidth and limit",
        RankedBy::LargestGain => "the limit",
        RankedBy::Saturation => "the frequency at which the drive saturates",
    };
    let most = || report.sensitivities().iter().find(|s| s.worth(by).is_finite() && !s.is_trade(by));
    if !first.is_empty() {
        said.push(format!(
            "Of masses, stiffnesses and dampings, these raise {aim} most: {}.",
            first.join("; ")
        ));
    } else if let Some(most) = most() {
        said.push(format!(
            "No single mass, stiffness or damping helps much. The most telling change is {}.",
            better(most)
        ));
    }
    let trades = trades.into_iter().take(NAMED);
    let trades = trades.map(|s| format!("1 % more {} {}", s.key, effect(s, by, 1.0)));
    let trades = trades.collect::<Vec<_>>().join("; ");
    if !trades.is_empty() {
        said.push(format!("These raise one and lower the other: {trades}."));
    }
    if let Some(mode) = report.waterfall().and_then(|w| w.rides_mode).and_then(|i| report.modes.get(i)) {
        said.push(format!(
            "The bandwidth lies on the flank of the mode at {}, and moves with that peak. A softer or less \
             damped mode may seem to raise it. So changes are ranked by the limit alone.",
            with_unit(mode.frequency_hz, "Hz")
        ));
    }
    said
}

/// Reason why every gain is stable.
fn unlimited(report: &Report) -> String {
    let Some(gain) = report.gain() else { return String::new() };
    if report.margins().is_some_and(|margins| margins.complementary_sensitivity_peak <= 0.0) {
        let reads = report.pair().map_or(&report.output, |of| &of.output);
        return format!(
            "Nothing limits the bandwidth: {reads} does not answer {} here, so no loop is closed.",
            report.input
        );
    }
    format!("Nothing limits the bandwidth: no {} is too large.", gain.key)
}

fn limited(report: &Report, limit: Limit) -> String {
    let achieved = report.waterfall().and_then(|w| w.stages.last()).and_then(|stage| stage.bandwidth_hz);
    let modes = |class: ModeClass| {
        let of_class = report
            .modes
            .iter()
            .filter(|mode| mode.class_in_loop.unwrap_or(mode.class) == class && !mode.rigid_body);
        let list: Vec<String> = of_class.map(|mode| with_unit(mode.frequency_hz, "Hz")).collect();
        if list.is_empty() { String::new() } else { format!(" ({})", list.join(", ")) }
    };
    let what = match limit {
        Limit::RigidBody => "The rigid body and its actuator limit this loop".to_owned(),
        Limit::NoncolocatedMode => {
            format!("A noncolocated mode{} limits this loop", modes(ModeClass::Noncolocated))
        }
        Limit::ColocatedMode => format!("A colocated mode{} limits this loop", modes(ModeClass::Colocated)),
        Limit::Sampling => "Sampling limits this loop: hold, delay and filters of the controller".to_owned(),
        Limit::Saturation if achieved.is_some_and(|f| f <= 0.0) => {
            return "The limit of the drive's force or command is below what the reference asks for at rest: \
                    it is never reached."
                .to_owned();
        }
        Limit::Nothing => return unlimited(report),
        Limit::UndampedMode => return "An undamped mode makes every gain unstable.".to_owned(),
        Limit::Saturation => {
            "The drive's force or command reaches its limit before the loop is unstable".to_owned()
        }
    };
    let of = report
        .pair()
        .filter(|of| of.controlled != of.output)
        .map_or_else(String::new, |of| format!(" of {}", of.controlled));
    let reach = achieved.map_or_else(String::new, |f| {
        format!(" At half of the largest stable gain, the bandwidth{of} is {}.", with_unit(f, "Hz"))
    });
    let relief = relief(report).unwrap_or_default();
    format!("{what}.{relief}{reach}")
}

/// Smallest factor on the limit that is worth a sentence.
const RELIEVING: f64 = 1.1;

/// The limit without the ingredient that lowers it most.
fn relief(report: &Report) -> Option<String> {
    let factor = |relief: Relief| match relief {
        Relief::Times(factor) => factor,
        Relief::Unlimited => f64::INFINITY,
        Relief::Stable | Relief::NoneEither => 1.0,
    };
    let without = report.waterfall()?.without.iter();
    let (name, most) = without.max_by(|a, b| factor(a.1).total_cmp(&factor(b.1)))?;
    let high = match *most {
        Relief::Times(factor) if factor > RELIEVING => {
            format!("its limit would be {} times as high", plain(two_digits(factor)))
        }
        Relief::Unlimited => "no gain would be too large".to_owned(),
        Relief::Times(_) | Relief::Stable | Relief::NoneEither => return None,
    };
    let with = match name.as_str() {
        "sampling" => "With continuous control".to_owned(),
        "actuator" => "With an ideal actuator".to_owned(),
        spring => format!("With {spring} rigid"),
    };
    Some(format!(" {with}, {high}."))
}
