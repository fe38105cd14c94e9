//! The gap after each step, as hanging bars.

use feeler_diagnosis::report::Diagnosis;

use super::adequacy::WITH_EFFECTS;
use crate::numbers::fine_percent;

/// A step below this share of the tallest bar is a rounding error.
const ROUNDING: f64 = 1e-9;

/// One bar: its name, its ends, and whether it is a level or a step.
struct Bar {
    name: String,
    from: f64,
    to: f64,
    is_level: bool,
}

/// The bars with their ends as shares of the largest, and their numbers.
pub(super) fn hanging(diagnosis: &Diagnosis) -> Vec<(String, [f64; 2], bool, String)> {
    let bars = bars(diagnosis);
    let top = bars.iter().map(|bar| bar.from.max(bar.to)).fold(f64::MIN_POSITIVE, f64::max);
    let row = |bar: Bar| {
        let change = bar.to - bar.from;
        let text = if bar.is_level {
            format!("{} %", fine_percent(bar.to))
        } else if change.abs() <= ROUNDING * top {
            "0 %".into()
        } else {
            format!("{}{} %", sign(change), fine_percent(change.abs()))
        };
        (bar.name, [bar.from, bar.to].map(|end| end / top), bar.is_level, text)
    };
    bars.into_iter().map(row).collect()
}

fn sign(change: f64) -> &'static str {
    if change < 0.0 { "−" } else { "+" }
}

fn bars(diagnosis: &Diagnosis) -> Vec<Bar> {
    let gap = &diagnosis.gap;
    let level = |name: &str, value: f64| Bar { name: name.into(), from: 0.0, to: value, is_level: true };
    let mut bars = vec![
        level("machine as given", gap.before),
        Bar { name: "calibration".into(), from: gap.before, to: gap.refit, is_level: false },
    ];
    let accepted: Vec<_> = diagnosis.effects.iter().filter(|effect| effect.accepted).collect();
    let credits: f64 = accepted.iter().map(|effect| effect.credit).sum();
    let mut at = gap.refit;
    for (i, effect) in accepted.iter().enumerate() {
        let share = if credits > 0.0 { effect.credit / credits } else { 1.0 / accepted.len() as f64 };
        let next = if i + 1 == accepted.len() { gap.after } else { at + share * (gap.after - gap.refit) };
        bars.push(Bar { name: effect.kind.name().replace('-', " "), from: at, to: next, is_level: false });
        at = next;
    }
    if !accepted.is_empty() {
        bars.push(level(WITH_EFFECTS, gap.after));
    }
    bars.push(level("noise floor", gap.floor));
    bars
}
