//! Sentences on a terminal.

use super::table::terminal_width;

/// Further indentation of the rest of a line that is indented.
const HANGING: usize = 4;

/// A text whose long lines are broken between words on a terminal; otherwise unchanged. The rest of an
/// indented line is indented more.
pub(crate) fn wrapped(text: &str) -> String {
    terminal_width().map_or_else(|| text.to_owned(), |width| within(text, usize::from(width)))
}

fn within(text: &str, width: usize) -> String {
    let mut lines = Vec::new();
    for long in text.lines() {
        if long.chars().count() <= width {
            lines.push(long.to_owned());
            continue;
        }
        let words = long.trim_start_matches(' ');
        let indent = long.len() - words.len();
        let (mut line, mut used, mut is_first) = (" ".repeat(indent), indent, true);
        let hanging = if indent > 0 { indent + HANGING } else { 0 };
        for word in words.split(' ') {
            let size = word.chars().count();
            if !is_first && used + 1 + size > width {
                lines.push(std::mem::replace(&mut line, " ".repeat(hanging)));
                (used, is_first) = (hanging, true);
            }
            if !is_first {
                line.push(' ');
                used += 1;
            }
            line.push_str(word);
            (used, is_first) = (used + size, false);
        }
        lines.push(line);
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_lines_are_broken_between_words() {
        assert_eq!(within("the limit is 1.507\n\nshort", 10), "the limit\nis 1.507\n\nshort");
        // A line that fits keeps its spaces.
        assert_eq!(within("  a  b", 10), "  a  b");
        // A word that is too long has its own line.
        assert_eq!(within("  u = KP * error + rest", 14), "  u = KP *\n      error +\n      rest");
        assert_eq!(within("1 % more springs.guide.damping", 10), "1 % more\nsprings.guide.damping");
    }
}
