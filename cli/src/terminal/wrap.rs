//! Sentences on a terminal.

use super::table::terminal_width;

/// A text whose long lines are broken between words on a terminal; otherwise unchanged.
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
        let (mut line, mut used) = (String::new(), 0);
        for word in long.split(' ') {
            let size = word.chars().count();
            if used > 0 && used + 1 + size > width {
                lines.push(std::mem::take(&mut line));
                used = 0;
            }
            if used > 0 {
                line.push(' ');
                used += 1;
            }
            line.push_str(word);
            used += size;
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
        assert_eq!(within("1 % more springs.guide.damping", 10), "1 % more\nsprings.guide.damping");
    }
}
