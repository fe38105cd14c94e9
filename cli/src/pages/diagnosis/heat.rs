//! Location of the gap: channels against phases of the motion, frequency bands and command levels, before and
//! after repair.

use std::fmt::Write as _;

use feeler_diagnosis::report::GapCell;

use super::adequacy::WITH_EFFECTS;
use crate::numbers::plain;
use crate::pages::parts::escape;

const WIDTH: f64 = 900.0;
const LEFT: f64 = 190.0;
const ROW: f64 = 26.0;
const HEAD: f64 = 52.0;
/// Largest width of a column.
const WIDEST: f64 = 90.0;
/// Width of a letter of a group's name, and the space between two names.
const LETTER: f64 = 8.0;
const GAP: f64 = 12.0;
/// Number of noise floors up to which an error has no colour, because noise alone may cause it.
pub(super) const NOISE: f64 = 1.5;
/// Shares of the variation with the palest and the darkest colour. The scale is logarithmic, so that a larger
/// number is never paler.
pub(super) const PALEST: f64 = 1e-3;
pub(super) const DARKEST: f64 = 1.0;
/// Smallest noise floor as a share of the variation; a smaller one is too strict for a model.
const LEAST_FLOOR: f64 = 1e-5;
/// Level above which letters are white. At this level black and white letters have a contrast of at least
/// 4.5.
const DARK: f64 = 0.635;

/// Phases in the order of a motion.
const PHASES: [&str; 5] = ["free", "approach", "impact", "contact", "release"];

/// Levels of the command from low to high.
const LEVELS: [&str; 3] = ["low", "middle", "high"];

/// The state of the machine whose gap is drawn.
type Of = fn(&GapCell) -> f64;

/// One column: its group, its label, and the selection of its cells.
struct Column<'a> {
    group: &'a str,
    label: String,
    holds: Box<dyn Fn(&GapCell) -> bool + 'a>,
    of: Of,
}

/// Phases of the motion and frequency bands, over all levels.
pub(super) fn by_phase(cells: &[GapCell], of: Of, label: &str) -> String {
    let mut keys: Vec<(&'static str, [f64; 2])> = Vec::new();
    for cell in cells {
        if !keys.iter().any(|(phase, band)| *phase == cell.phase && same(*band, cell.band_hz)) {
            keys.push((cell.phase, cell.band_hz));
        }
    }
    keys.sort_by(|a, b| order(a.0).cmp(&order(b.0)).then(a.1[0].total_cmp(&b.1[0])));
    let column = |(phase, band): (&'static str, [f64; 2])| Column {
        group: phase,
        label: plain(band[1].round()),
        holds: Box::new(move |cell: &GapCell| cell.phase == phase && same(cell.band_hz, band)),
        of,
    };
    let columns: Vec<Column> = keys.into_iter().map(column).collect();
    grid(cells, &columns, "band up to (Hz)", label)
}

/// Command levels before and, if effects were found, after repair, over all phases and bands.
pub(super) fn by_level(cells: &[GapCell], is_found: bool) -> String {
    let states: [(&'static str, Of); 2] =
        [("calibrated machine", |cell| cell.refit), (WITH_EFFECTS, |cell| cell.after)];
    let mut columns = Vec::new();
    for (group, of) in states.into_iter().take(1 + usize::from(is_found)) {
        for level in LEVELS.iter().filter(|level| cells.iter().any(|cell| cell.amplitude == **level)) {
            columns.push(Column {
                group,
                label: (*level).to_owned(),
                holds: Box::new(move |cell: &GapCell| cell.amplitude == *level),
                of,
            });
        }
    }
    grid(cells, &columns, "level of the command", "by level")
}

/// A grid with channels as rows.
fn grid(cells: &[GapCell], columns: &[Column<'_>], axis: &str, label: &str) -> String {
    let mut channels: Vec<&str> = Vec::new();
    for cell in cells {
        if !channels.contains(&cell.channel.as_str()) {
            channels.push(&cell.channel);
        }
    }
    // A group is as wide as its name.
    let share = |column: &Column<'_>| {
        let members = columns.iter().filter(|other| other.group == column.group).count();
        (LETTER * column.group.chars().count() as f64 + GAP) / members as f64
    };
    let asked = columns.iter().map(share).fold(WIDEST, f64::max);
    let wide = ((WIDTH - LEFT) / columns.len().max(1) as f64).min(asked);
    let height = HEAD + ROW * channels.len() as f64 + 6.0;
    let mut svg = format!(
        "<svg viewBox=\"0 0 {WIDTH} {height}\" role=\"img\" aria-label=\"{}\" font-size=\"12\">",
        escape(label)
    );
    let mut from = 0;
    while from < columns.len() {
        let group = columns[from].group;
        let to = from + columns[from..].iter().take_while(|column| column.group == group).count();
        let centre = LEFT + wide * (from + to) as f64 * 0.5;
        let _ = write!(
            svg,
            "<text x=\"{centre:.1}\" y=\"16\" text-anchor=\"middle\" font-weight=\"600\">{group}</text>"
        );
        let _ = write!(
            svg,
            "<path d=\"M{:.1} 22H{:.1}\" stroke=\"#5a646c\"/>",
            LEFT + wide * from as f64 + 3.0,
            LEFT + wide * to as f64 - 3.0
        );
        from = to;
    }
    let _ = write!(svg, "<text x=\"{}\" y=\"42\" text-anchor=\"end\">{}</text>", LEFT - 8.0, escape(axis));
    for (i, column) in columns.iter().enumerate() {
        let centre = LEFT + wide * (i as f64 + 0.5);
        let _ =
            write!(svg, "<text x=\"{centre:.1}\" y=\"42\" text-anchor=\"middle\">{}</text>", column.label);
    }
    for (j, channel) in channels.iter().enumerate() {
        let top = HEAD + ROW * j as f64;
        let _ = write!(
            svg,
            "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            LEFT - 8.0,
            top + 17.0,
            escape(channel)
        );
        for (i, column) in columns.iter().enumerate() {
            let Some([value, floor]) = value(cells, channel, column) else { continue };
            let floors = value / floor.max(LEAST_FLOOR);
            // On a dark page white becomes the background colour.
            let (fill, stroke, ink) = match shade(value, floors) {
                None => ("#ffffff".to_owned(), " stroke=\"#d9dfe3\"", ""),
                Some(share) if share > DARK => (colour(share), "", " style=\"fill:#ffffff\""),
                Some(share) => (colour(share), "", " style=\"fill:#000000\""),
            };
            let _ = write!(
                svg,
                "<rect x=\"{:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" \
                 fill=\"{fill}\"{stroke}/>\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\"{ink}>{}</text>",
                LEFT + wide * i as f64 + 1.0,
                wide - 2.0,
                ROW - 2.0,
                LEFT + wide * (i as f64 + 0.5),
                top + 17.0,
                shown(value)
            );
        }
    }
    svg.push_str("</svg>");
    svg
}

/// Darkness of a cell from 0 to 1; `None` for errors that may be noise.
fn shade(value: f64, floors: f64) -> Option<f64> {
    (floors > NOISE).then(|| ((value / PALEST).ln() / (DARKEST / PALEST).ln()).clamp(0.0, 1.0))
}

/// A share as a percentage with two digits.
fn shown(value: f64) -> String {
    match 100.0 * value {
        percent if percent < 0.0095 => "<.01".into(),
        percent if percent < 0.095 => format!("{percent:.2}"),
        percent if percent < 9.95 => format!("{percent:.1}"),
        percent if percent > 999.0 => ">999".into(),
        percent => format!("{percent:.0}"),
    }
}

fn order(phase: &str) -> usize {
    PHASES.iter().position(|p| *p == phase).unwrap_or(PHASES.len())
}

fn same(a: [f64; 2], b: [f64; 2]) -> bool {
    a.map(f64::to_bits) == b.map(f64::to_bits)
}

/// Root mean square over the cells of a column, weighted by time, and of their noise floors.
fn value(cells: &[GapCell], channel: &str, column: &Column<'_>) -> Option<[f64; 2]> {
    let (mut sum, mut floor, mut time) = (0.0, 0.0, 0.0);
    for cell in cells.iter().filter(|cell| cell.channel == channel && (column.holds)(cell)) {
        sum += (column.of)(cell).powi(2) * cell.seconds;
        floor += cell.floor.powi(2) * cell.seconds;
        time += cell.seconds;
    }
    (time > 0.0).then(|| [sum, floor].map(|sum| (sum / time).sqrt()))
}

/// A scale from pale blue through blue to near black, which also works in grey.
fn colour(share: f64) -> String {
    const STOPS: [[f64; 3]; 4] =
        [[222.0, 235.0, 247.0], [158.0, 202.0, 225.0], [33.0, 113.0, 181.0], [8.0, 29.0, 70.0]];
    let at = share * (STOPS.len() - 1) as f64;
    let i = (at.floor() as usize).min(STOPS.len() - 2);
    let mixed: Vec<u8> = (0..3)
        .map(|k| (STOPS[i][k] + (at - i as f64) * (STOPS[i + 1][k] - STOPS[i][k])).round() as u8)
        .collect();
    format!("#{:02x}{:02x}{:02x}", mixed[0], mixed[1], mixed[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Regression: noise floors once determined the colour, so that 22 % was darkest and 127 % a middle blue.
    #[test]
    fn regress_a_larger_number_is_never_paler() {
        let shades: Vec<Option<f64>> = [0.005, 0.02, 0.22, 0.5, 1.27].map(|share| shade(share, 10.0)).into();
        assert!(shades.is_sorted() && shades[4] > shades[2], "{shades:?}");
        assert!(shade(0.3, 1.0).is_none() && shade(0.3, 300.0) <= shade(0.31, 2.0));
    }

    /// A dark page replaces white by its background, and letters have the page's colour.
    #[test]
    fn regress_a_cell_within_the_noise_follows_the_page() {
        let cell = |refit: f64| GapCell {
            channel: "encoder".into(),
            phase: "free",
            band_hz: [0.0, 10.0],
            amplitude: "low",
            before: refit,
            refit,
            after: refit,
            floor: 0.01,
            seconds: 1.0,
        };
        let drawn = |refit: f64| by_phase(&[cell(refit)], |cell| cell.refit, "before");
        let (noise, gap) = (drawn(0.01), drawn(0.1));
        assert!(
            noise.contains("fill=\"#ffffff\" stroke=\"#d9dfe3\"") && !noise.contains("style="),
            "{noise}"
        );
        assert!(!gap.contains("fill=\"#ffffff\"") && gap.contains("style=\"fill:"), "{gap}");
    }
}
