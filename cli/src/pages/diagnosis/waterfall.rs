//! The gap after each step, as hanging bars.

use std::fmt::Write as _;

use feeler_diagnosis::report::Diagnosis;

use super::adequacy::WITH_EFFECTS;
use crate::numbers::{fine_percent, plain};
use crate::pages::parts::escape;
use crate::pages::parts::svg::{Scale, lines};

const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 320.0;
const LEFT: f64 = 88.0;
const TOP: f64 = 26.0;
const BOTTOM: f64 = 258.0;
/// Ratio of a bar's width to that of its column.
const BAR: f64 = 0.62;
/// Space above the tallest bar, as a share of it.
const HEADROOM: f64 = 1.08;
/// A step below this share of the tallest bar is a rounding error.
const ROUNDING: f64 = 1e-9;
/// Width of a letter in the texts below a bar, pixels.
const LETTER: f64 = 7.2;

/// One bar: its name, its ends, and whether it is a level or a step.
struct Bar {
    name: String,
    from: f64,
    to: f64,
    is_level: bool,
}

pub(super) fn drawing(diagnosis: &Diagnosis) -> String {
    let bars = bars(diagnosis);
    let top = bars
        .iter()
        .map(|bar| bar.from.max(bar.to))
        .fold(diagnosis.gap.floor, f64::max)
        .max(f64::MIN_POSITIVE)
        * HEADROOM;
    let y = |value: f64| BOTTOM - (BOTTOM - TOP) * value / top;
    let step = (WIDTH - LEFT - 10.0) / bars.len() as f64;
    let mut svg = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"Gap, step by step\" \
         font-size=\"13\">"
    );
    for (value, text) in ticks(top) {
        let at = y(value);
        let _ = write!(
            svg,
            "<path d=\"M{LEFT} {at:.1}H{WIDTH}\" stroke=\"#d9dfe3\"/><text x=\"{}\" y=\"{:.1}\" \
             text-anchor=\"end\">{} %</text>",
            LEFT - 6.0,
            at + 4.0,
            text
        );
    }
    let middle = f64::midpoint(TOP, BOTTOM);
    let _ = write!(
        svg,
        "<text x=\"13\" y=\"{middle}\" text-anchor=\"middle\" transform=\"rotate(-90 13 {middle})\">gap, \
         share of signal</text>"
    );
    for (i, bar) in bars.iter().enumerate() {
        let centre = LEFT + step * (i as f64 + 0.5);
        let (high, low) = (bar.from.max(bar.to), bar.from.min(bar.to));
        let colour = if bar.is_level {
            "#5a646c"
        } else if bar.to <= bar.from {
            "#0072b2"
        } else {
            "#d55e00"
        };
        let text = if bar.is_level {
            format!("{} %", fine_percent(bar.to))
        } else {
            let change = bar.to - bar.from;
            // A smaller change is a rounding error of sums.
            if change.abs() <= ROUNDING * top {
                "0 %".into()
            } else {
                format!("{}{} %", sign(change), fine_percent(change.abs()))
            }
        };
        let _ = write!(
            svg,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{colour}\"/>\
             <text x=\"{centre:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{text}</text>",
            centre - 0.5 * BAR * step,
            y(high),
            BAR * step,
            (y(low) - y(high)).max(1.0),
            y(high) - 6.0
        );
        for (line, words) in lines(&bar.name, (step / LETTER) as usize).iter().enumerate() {
            let _ = write!(
                svg,
                "<text x=\"{centre:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                BOTTOM + 18.0 + 16.0 * line as f64,
                escape(words)
            );
        }
    }
    svg.push_str("</svg>");
    svg
}

/// Round shares up to the top, as percentages with as many decimals as their steps.
fn ticks(top: f64) -> Vec<(f64, String)> {
    let scale = Scale { label: String::new(), unit: String::new(), range: [0.0, 100.0 * top], log: false };
    scale.ticks(BOTTOM - TOP).into_iter().map(|(percent, _)| (percent / 100.0, plain(percent))).collect()
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
