//! Bars with their names and numbers as text.

use std::fmt::Write as _;

use super::{Page, escape};

impl Page {
    /// Bars, each with its name and number. Lengths are relative to the largest finite bar. An infinite bar
    /// is hatched and has the whole width.
    pub(crate) fn bars(&mut self, bars: &[(String, f64, String)]) {
        let largest =
            bars.iter().map(|(_, size, _)| size.abs()).filter(|size| size.is_finite()).fold(0.0, f64::max);
        self.body.push_str("<div class=\"bars\">");
        for (name, size, text) in bars {
            let (width, class) = match *size {
                size if size.is_infinite() => (100.0, "unlimited"),
                size if largest > 0.0 => {
                    (100.0 * size.abs() / largest, if size < 0.0 { "out" } else { "in" })
                }
                _ => (0.0, "in"),
            };
            let (name, text) = (escape(name), escape(text));
            let _ = write!(
                self.body,
                "<span>{name}</span><i class=\"{class}\" style=\"--size:{width:.2}%\"></i><span \
                 class=\"number\">{text}</span>"
            );
        }
        self.body.push_str("</div>\n");
    }

    /// Hanging bars, each with its name, both ends as shares of the whole width, and its number. A level is
    /// grey, a fall of the first colour and a rise of the second.
    pub(crate) fn hanging_bars(&mut self, bars: &[(String, [f64; 2], bool, String)]) {
        self.body.push_str("<div class=\"bars\">");
        for (name, [from, to], is_level, text) in bars {
            let class = if *is_level {
                "level"
            } else if to > from {
                "out"
            } else {
                "in"
            };
            let (start, size) = (100.0 * from.min(*to), 100.0 * (to - from).abs());
            let (name, text) = (escape(name), escape(text));
            let _ = write!(
                self.body,
                "<span>{name}</span><i class=\"{class}\" style=\"--from:{start:.2}%;--size:{size:.2}%\"></i>\
                 <span class=\"number\">{text}</span>"
            );
        }
        self.body.push_str("</div>\n");
    }
}
