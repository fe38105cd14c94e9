//! Problems as one text, each with its line.

use std::fmt::Write as _;

use annotate_snippets::{AnnotationKind, Level, Renderer, Snippet};

use super::located::Located;
use super::source::{Source, Sources};

/// Largest number of problems in one report.
const MOST_SHOWN: usize = 50;

pub(crate) fn render(problems: &[Located], omitted: usize, sources: &Sources, coloured: bool) -> String {
    let renderer = if coloured { Renderer::styled() } else { Renderer::plain() };
    let mut text = String::new();
    for problem in problems.iter().take(MOST_SHOWN) {
        text.push_str(&one(problem, sources.0.get(problem.source), &renderer));
        text.push_str("\n\n");
    }
    let count = problems.len() + omitted;
    if count > MOST_SHOWN {
        let _ = writeln!(text, "... and {} more\n", count - MOST_SHOWN);
    }
    let plural = if count == 1 { "" } else { "s" };
    let _ = write!(text, "{count} mistake{plural}");
    text
}

fn one(problem: &Located, source: Option<&Source>, renderer: &Renderer) -> String {
    let title = if problem.key.is_empty() {
        problem.message.clone()
    } else {
        format!("{}: {}", problem.key, problem.message)
    };
    let Some(source) = source else {
        let group = Level::ERROR.primary_title(format!("{}: {title}", problem.file));
        let remedy = [Level::HELP.message(problem.remedy.as_str())];
        return renderer.render(&[group.elements(remedy)]);
    };
    // Only the lines of the span are rendered, so a report on a large file is as fast as one on a small file.
    let (first, excerpt, span) = excerpt(source, problem);
    let annotation = AnnotationKind::Primary.span(span);
    let snippet =
        Snippet::source(excerpt).line_start(first).path(problem.file.as_str()).annotation(annotation);
    let group = Level::ERROR.primary_title(title).element(snippet);
    let remedy = [Level::HELP.message(problem.remedy.as_str())];
    renderer.render(&[group.elements(remedy)])
}

/// Number of the first line of the span, the text of its line, and the span within it.
fn excerpt<'a>(source: &'a Source, problem: &Located) -> (usize, &'a str, std::ops::Range<usize>) {
    let text: &str = &source.text;
    let boundary = |mut at: usize| {
        at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        at
    };
    let start = boundary(problem.span.start);
    let line_start = text[..start].rfind('\n').map_or(0, |at| at + 1);
    let line_end = text[start..].find('\n').map_or(text.len(), |at| start + at);
    let end = boundary(problem.span.end).clamp(start, line_end);
    (problem.line, &text[line_start..line_end], start - line_start..end - line_start)
}
