//! The missing force against possible variables.

use std::fmt::Write as _;

use feeler_diagnosis::report::{PortraitPoint, Rung};

use crate::numbers::{plain, prefix};
use crate::pages::parts::escape;
use crate::units::Units;

const WIDTH: f64 = 440.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 72.0;
const BOTTOM: f64 = 252.0;
const TOP: f64 = 12.0;
const RIGHT: f64 = 430.0;
/// Colours of the sets of dots; the mean of a single set has the second colour.
const COLOURS: [&str; 2] = ["#0072b2", "#d55e00"];
/// Largest number of dots of one set.
const MOST_DOTS: usize = 1500;
/// Intervals of the horizontal axis with a drawn mean, and the smallest number of dots for a mean.
const BINS: usize = 24;
const LEAST_IN_BIN: usize = 5;
/// Share of dots on each side that may be outside the frame.
const OUTSIDE: f64 = 0.002;

/// The horizontal variable of a portrait.
type Of = fn(&PortraitPoint) -> f64;

/// The four drawings with their captions.
pub(super) fn drawings(rung: &Rung, units: Units) -> Vec<(String, String)> {
    let share = |i: usize| rung.goes_with.get(i).map_or(0.0, |(_, share)| *share);
    let axes: [(&str, &str, Of); 4] = [
        ("position", units.position, |p| p.position_m),
        ("velocity", units.velocity, |p| p.velocity_m_per_s),
        ("drive force", units.force, |p| p.drive_n),
        ("time", "s", |p| p.time_s),
    ];
    axes.iter()
        .enumerate()
        .map(|(i, (name, unit, of))| {
            let caption = format!("against {name}, which explains {:.0} % of its variance", 100.0 * share(i));
            let dots: Vec<[f64; 2]> =
                rung.portrait.iter().map(|point| [of(point), point.missing_n]).collect();
            (caption, drawing(&[dots], name, unit, units.force))
        })
        .collect()
}

/// The force of one experiment that the believed and the repaired machine lack, over time, position and
/// speed.
pub(super) fn inverse(rows: &[[f64; 5]], units: Units) -> Vec<(String, String)> {
    [("time", "s"), ("position", units.position), ("velocity", units.velocity)]
        .into_iter()
        .enumerate()
        .map(|(i, (name, unit))| {
            let dots = [3, 4].map(|machine| rows.iter().map(|row| [row[i], row[machine]]).collect());
            (format!("against {name}"), drawing(&dots, name, unit, units.force))
        })
        .collect()
}

/// Limits that contain nearly all of the values.
fn limits(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let mut sorted: Vec<f64> = values.filter(|x| x.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    if sorted.is_empty() {
        return [-1.0, 1.0];
    }
    let cut = (OUTSIDE * sorted.len() as f64) as usize;
    let (low, high) = (sorted[cut], sorted[sorted.len() - 1 - cut]);
    let room = if high > low { 0.04 * (high - low) } else { high.abs().max(1e-9) };
    [low - room, high + room]
}

/// Sets of dots, each in its own colour; a single set has its mean.
fn drawing(sets: &[Vec<[f64; 2]>], name: &str, unit: &str, force: &str) -> String {
    let [x_limits, y_limits] = [0, 1].map(|axis| limits(sets.iter().flatten().map(|dot| dot[axis])));
    let x = |value: f64| LEFT + (RIGHT - LEFT) * (value - x_limits[0]) / (x_limits[1] - x_limits[0]);
    let y = |value: f64| BOTTOM - (BOTTOM - TOP) * (value - y_limits[0]) / (y_limits[1] - y_limits[0]);
    let mut svg = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"missing force against {}\" \
         style=\"font-size:15px\">",
        escape(name)
    );
    let (scale, size) = prefix(x_limits[0].abs().max(x_limits[1].abs()));
    for value in ticks(y_limits) {
        let at = y(value);
        let _ = write!(
            svg,
            "<path d=\"M{LEFT} {at:.1}H{RIGHT}\" stroke=\"#d9dfe3\"/><text x=\"{}\" y=\"{:.1}\" \
             text-anchor=\"end\">{}</text>",
            LEFT - 5.0,
            at + 4.0,
            plain(value)
        );
    }
    for value in ticks(x_limits.map(|limit| limit / scale)) {
        let at = x(value * scale);
        let _ = write!(
            svg,
            "<path d=\"M{at:.1} {BOTTOM}V{TOP}\" stroke=\"#d9dfe3\"/><text x=\"{at:.1}\" y=\"{}\" \
             text-anchor=\"middle\">{}</text>",
            BOTTOM + 18.0,
            plain(value)
        );
    }
    let inside = |dot: &&[f64; 2]| {
        (x_limits[0]..=x_limits[1]).contains(&dot[0]) && (y_limits[0]..=y_limits[1]).contains(&dot[1])
    };
    for (dots, colour) in sets.iter().zip(COLOURS) {
        let thin = dots.len().div_ceil(MOST_DOTS).max(1);
        let _ = write!(
            svg,
            "<path fill=\"none\" stroke=\"{colour}\" stroke-opacity=\"0.35\" stroke-width=\"3\" \
             stroke-linecap=\"round\" d=\""
        );
        for dot in dots.iter().step_by(thin).filter(inside) {
            let _ = write!(svg, "M{:.0} {:.0}h0", x(dot[0]), y(dot[1]));
        }
        svg.push_str("\"/>");
    }
    if let [dots] = sets {
        let mut sums = [(0.0, 0.0, 0_usize); BINS];
        for dot in dots.iter().filter(inside) {
            let share = (dot[0] - x_limits[0]) / (x_limits[1] - x_limits[0]);
            let i = ((share * BINS as f64) as usize).min(BINS - 1);
            sums[i] = (sums[i].0 + dot[0], sums[i].1 + dot[1], sums[i].2 + 1);
        }
        let mut mean = String::new();
        for (sx, sy, n) in sums.iter().filter(|(_, _, n)| *n >= LEAST_IN_BIN) {
            let letter = if mean.is_empty() { 'M' } else { 'L' };
            let _ = write!(mean, "{letter}{:.1} {:.1}", x(sx / *n as f64), y(sy / *n as f64));
        }
        let colour = COLOURS[1];
        let _ = write!(svg, "<path fill=\"none\" stroke=\"{colour}\" stroke-width=\"2.5\" d=\"{mean}\"/>");
    }
    let (across, middle) = (f64::midpoint(LEFT, RIGHT), f64::midpoint(TOP, BOTTOM));
    let _ = write!(
        svg,
        "<text x=\"{across}\" y=\"{}\" text-anchor=\"middle\">{} ({size}{unit})</text>\
         <text x=\"15\" y=\"{middle}\" text-anchor=\"middle\" transform=\"rotate(-90 15 {middle})\">missing \
         force ({force})</text></svg>",
        BOTTOM + 40.0,
        escape(name)
    );
    svg
}

/// Round numbers within limits, about five of them.
fn ticks([low, high]: [f64; 2]) -> Vec<f64> {
    let raw = (high - low) / 5.0;
    let power = 10_f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].iter().map(|m| m * power).find(|step| *step >= raw).unwrap_or(raw);
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(|i| i as f64 * step).collect()
}

#[cfg(test)]
mod tests {
    use super::ticks;

    #[test]
    fn truth_ticks_are_round_and_inside() {
        assert_eq!(ticks([-11.0, 12.0]), [-10.0, -5.0, 0.0, 5.0, 10.0]);
    }
}
