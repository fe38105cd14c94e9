//! The confusion matrix: hidden causes in rows, answers in columns.

use std::fmt::Write as _;

use feeler_plant::effects::LIBRARY;

use crate::pages::parts::escape;

const CELL: f64 = 22.0;
/// Width of a letter of a name, and the space beside it.
const LETTER: f64 = 7.0;
const GAP: f64 = 16.0;
/// Slope of the names along the top, degrees.
const SLOPE_DEG: f64 = 60.0;

/// Opacity of a cell above which its number is white.
const DARK: f64 = 0.8;

/// The drawing: cells on the diagonal are right answers, and each number is a count of cases.
pub(super) fn drawing(confusion: &[(String, String, usize)]) -> String {
    let mut rows: Vec<&str> = confusion.iter().map(|(hidden, ..)| hidden.as_str()).collect();
    let mut columns: Vec<&str> = confusion.iter().map(|(_, answered, _)| answered.as_str()).collect();
    for names in [&mut rows, &mut columns] {
        names.sort_by_key(|name| (order(name), *name));
        names.dedup();
    }
    // Names of effects outside the library have unknown lengths.
    let longest =
        |names: &[&str]| LETTER * names.iter().map(|name| name.chars().count()).max().unwrap_or(0) as f64;
    let left = longest(&rows).max(longest(&["hidden ↓ answered →"])) + GAP;
    let (rise, reach) = SLOPE_DEG.to_radians().sin_cos();
    let top = longest(&columns) * rise + GAP;
    let width = left + CELL * columns.len() as f64 + longest(&columns) * reach + GAP;
    let height = top + CELL * rows.len() as f64 + 8.0;
    let mut svg = format!(
        "<svg viewBox=\"0 0 {width} {height}\" style=\"max-width:{width}px\" role=\"img\" \
         aria-label=\"Confusion matrix\" font-size=\"12\">\
         <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"#5a646c\">hidden ↓ answered →</text>",
        left - 8.0,
        top - 8.0
    );
    for (i, name) in columns.iter().enumerate() {
        let (x, y) = (left + CELL * (i as f64 + 0.5) + 4.0, top - 6.0);
        let _ = write!(
            svg,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" transform=\"rotate(-{SLOPE_DEG} {x:.1} {y:.1})\">{}</text>",
            escape(name)
        );
    }
    for (j, name) in rows.iter().enumerate() {
        let y = top + CELL * j as f64;
        let _ = write!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text><path d=\"M{left:.1} {y:.1}H{:.1}\" \
             stroke=\"#e6eaed\"/>",
            left - 8.0,
            y + 15.0,
            escape(name),
            left + CELL * columns.len() as f64
        );
    }
    let times =
        |hidden: &str| confusion.iter().filter(|(h, ..)| h == hidden).map(|(.., n)| n).sum::<usize>() as f64;
    for (hidden, answered, n) in confusion {
        let at = |names: &[&str], name: &str| names.iter().position(|n| *n == name);
        let (Some(j), Some(i)) = (at(&rows, hidden), at(&columns, answered)) else { continue };
        let (x, y) = (left + CELL * i as f64, top + CELL * j as f64);
        let colour = if is_right(hidden, answered) { "#0072b2" } else { "#d55e00" };
        let share = 0.35 + 0.65 * *n as f64 / times(hidden);
        // Letters on a pale cell have the colour of the page's text.
        let ink = if share > DARK { "fill:#ffffff;" } else { "" };
        let _ = write!(
            svg,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{}\" height=\"{}\" rx=\"2\" fill=\"{colour}\" \
             fill-opacity=\"{share:.2}\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" \
             style=\"{ink}font-weight:600\">{n}</text>",
            x + 1.0,
            y + 1.0,
            CELL - 2.0,
            CELL - 2.0,
            x + 0.5 * CELL,
            y + 15.5
        );
    }
    svg.push_str("</svg>");
    svg
}

/// Position in the order of the library; other names come last.
fn order(name: &str) -> usize {
    LIBRARY.iter().position(|definition| definition.name == name).unwrap_or(LIBRARY.len())
}

fn is_right(hidden: &str, answered: &str) -> bool {
    hidden == answered
        || (order(hidden) == LIBRARY.len()
            && answered == feeler_diagnosis::blind::UNKNOWN
            && hidden != feeler_diagnosis::blind::NOTHING)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_what_is_right_is_on_the_diagonal_or_a_refusal() {
        assert!(is_right("backlash", "backlash"));
        assert!(is_right("quadratic-drag (no library)", "unknown cause"));
        assert!(!is_right("nothing", "unknown cause"));
        assert!(!is_right("backlash", "unknown cause"));
    }
}
