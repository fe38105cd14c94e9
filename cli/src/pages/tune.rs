//! A tuned controller on the terminal.

use feeler_studies::numbers::{count, percent, plain, with_unit};
use feeler_studies::tune::{Figures, Runs, Step, Tuned, Uncertain};

use crate::terminal::{table, wrapped};
use crate::units::Units;

/// The printed lines of a tuned controller. `further` names what else could be tuned.
pub(crate) fn summary(
    name: &str,
    tuned: &Tuned,
    uncertain: &[Uncertain],
    units: Units,
    further: Option<&str>,
) -> String {
    let on = match tuned.machines {
        1 if uncertain.is_empty() => "on the machine in the file".to_owned(),
        1 => "on the most probable machine".to_owned(),
        many => format!("on {} within {}", count(many, "machine", "machines"), intervals(uncertain)),
    };
    let outcomes: Vec<String> = tuned
        .runs
        .outcomes
        .iter()
        .map(|(outcome, runs)| format!("{runs} {}", outcome.replace('-', " ")))
        .collect();
    let mut parts = vec![
        format!("{name}: {} follows up to {}, {on}", tuned.controller, with_unit(tuned.bandwidth_hz, "Hz")),
        table(&["", "as it is", "tuned"], &[1, 2], figures(tuned, units)),
        format!("runs: {}", outcomes.join(", ")),
    ];
    parts.extend(rests_off(&tuned.runs, units));
    if let Some(theory_hz) = tuned.theory_alone_hz {
        parts.push(format!(
            "linear theory alone would allow {}; the runs show the effects that it leaves out",
            with_unit(theory_hz, "Hz")
        ));
    }
    let settings = if tuned.settings.is_empty() {
        "settings\n  as in the file: no others that were tried are better".into()
    } else {
        format!("settings\n  {}", tuned.settings.join("\n  "))
    };
    parts.push(settings);
    parts.extend(further.map(str::to_owned));
    parts.push(order(tuned, units));
    parts.push(equation(tuned));
    parts.join("\n\n")
}

fn intervals(uncertain: &[Uncertain]) -> String {
    let of = |one: &Uncertain| {
        let [low, high] = one.interval.map(plain);
        format!("{} {low} to {high}", one.key)
    };
    uncertain.iter().map(of).collect::<Vec<_>>().join(", ")
}

fn figures(tuned: &Tuned, units: Units) -> Vec<Vec<String>> {
    let row = |name: &str, of: &dyn Fn(&Figures) -> String| {
        let before = tuned.before.as_ref().map_or_else(|| "unstable".into(), of);
        vec![name.to_owned(), before, of(&tuned.after)]
    };
    let none = || "no limit".to_owned();
    let mut rows = vec![
        row("bandwidth", &|f| with_unit(f.bandwidth_hz, "Hz")),
        row("phase margin", &|f| f.phase_margin_deg.map_or_else(none, |phase| format!("{phase:.1} deg"))),
        row("gain margin", &|f| f.gain_margin.map_or_else(none, decibels)),
        row("disk margin", &|f| plain(f.disk_margin)),
        row("sensitivity peak", &|f| decibels(f.sensitivity)),
    ];
    let runs = &tuned.runs;
    let of_runs = |name: &str, value: String| vec![name.to_owned(), "not run".to_owned(), value];
    // The file as it is is not simulated.
    rows.push(of_runs("peak force", with_unit(runs.peak_force_n, units.force)));
    if tuned.after.step_overshoot.is_some() {
        let share = |f: &Figures| f.step_overshoot.map_or_else(none, |share| format!("{} %", percent(share)));
        rows.push(row("step overshoot", &share));
    }
    rows.extend(runs.overshoot.map(|share| of_runs("overshoot", format!("{} %", percent(share)))));
    let settles = runs.settling_time_s.map(|time| with_unit(time, "s"));
    let settles = settles.or(runs.rest_time_s.map(|_| "none".to_owned()));
    rows.extend(settles.map(|settles| of_runs("settling time", settles)));
    rows
}

/// A force that rests where friction keeps it, off its reference.
fn rests_off(runs: &Runs, units: Units) -> Option<String> {
    let (time_s, band_n) = runs.rest_time_s.zip(runs.band_n).filter(|_| runs.settling_time_s.is_none())?;
    Some(wrapped(&format!(
        "no settling time: the {} rests after {}, but farther than {} from its reference",
        units.force_word(),
        with_unit(time_s, "s"),
        with_unit(band_n, units.force)
    )))
}

/// A factor in decibels.
fn decibels(factor: f64) -> String {
    format!("{:.1} dB", 20.0 * factor.log10())
}

/// The order of gains to try.
fn order(tuned: &Tuned, units: Units) -> String {
    let force = units.force_word();
    let way = if tuned.after.follows < 0.0 { "fall" } else { "rise" };
    let about = [
        "set damping and filters first, then the rows in order".to_owned(),
        format!(
            "at each row, in contact, raise the reference a little: the reading must {way}; if not, a sign \
             is wrong"
        ),
        format!(
            "stop if the tool leaves the workpiece again and again, or the {force} does not rest in time"
        ),
    ];
    let never_rests = tuned.steps.iter().any(|step| step.wait_s.is_none());
    let blank =
        if never_rests { "\n-: no reference rests to the end, so there is no rest to wait for" } else { "" };
    let about = wrapped(&(about.join("\n") + blank));
    let row = |step: &Step| {
        let own = format!("controllers.{}.", tuned.controller);
        let settings: Vec<&str> =
            step.settings.iter().map(|words| words.strip_prefix(&own).unwrap_or(words)).collect();
        let optional =
            |value: Option<f64>, unit: &str| value.map_or_else(|| "-".into(), |v| with_unit(v, unit));
        vec![
            format!("{} %", percent(step.share)),
            settings.join(" "),
            step.gain_margin.map_or_else(|| "no limit".into(), decibels),
            with_unit(step.stop_force_n, units.force),
            optional(step.stop_swing_n, units.force),
            with_unit(step.swing_hz, "Hz"),
            optional(step.wait_s, "s"),
        ]
    };
    let header = ["try", "set", "gain margin", "stop above", "or if it oscillates by", "at about", "after"];
    let rows = table(&header, &[0, 2, 3, 4, 5, 6], tuned.steps.iter().map(row));
    format!("gains to try on the robot, in this order\n\n{rows}\n{about}")
}

fn equation(tuned: &Tuned) -> String {
    let equation = &tuned.equation;
    let constants: Vec<String> =
        equation.constants.iter().map(|(name, value)| format!("  {name} = {value:?}")).collect();
    format!(
        "{}\n{}\n  output {}\n\nwith\n{}\n\n\
         --code DIR writes this as C and Rust, bit for bit as simulated",
        wrapped(&format!(
            "the controller: what it computes at each sample, every {}; the output acts {} later; x[n-1] is \
             x of the sample before, at first zero or false; SI units",
            with_unit(equation.period_s, "s"),
            with_unit(equation.delay_s, "s")
        )),
        wrapped(&equation.lines.iter().map(|line| format!("  {line}")).collect::<Vec<_>>().join("\n")),
        equation.output,
        constants.join("\n")
    )
}
