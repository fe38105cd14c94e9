//! The computation of a controller at a sample, as a program of few kinds of lines that any language has.
//!
//! Each part of a controller lists itself beside the function that runs it, operation by operation in the
//! same order. So a program written from the list computes the same bits, where the language neither fuses
//! nor reorders operations.

/// One line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Line {
    /// A number under a name.
    Number(String, String),
    /// Yes or no under a name.
    Truth(String, String),
    /// A number under a name: the second expression where the first holds, else the third.
    Choice(String, [String; 3]),
    /// A number under a name: an expression rounded to the nearest integer, ties to even.
    Rounded(String, String),
    /// A state's next value.
    Set(String, String),
}

/// A program. Expressions are those that C and Rust share; `s.name` is the value of a state after the
/// previous sample.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Listing {
    /// Names and values of the constants.
    pub constants: Vec<(String, f64)>,
    /// States that are numbers, zero before the first sample.
    pub numbers: Vec<String>,
    /// States that are yes or no, no before the first sample.
    pub truths: Vec<String>,
    /// The computations, in order.
    pub lines: Vec<Line>,
    /// The name of the output.
    pub output: String,
}

/// Inputs of a sample, in order: its time (s), the reference, the reading, and position or velocity.
const INPUTS: [&str; 4] = ["t", "reference", "reading", "motion"];

impl Listing {
    /// The inputs that are used, of `t`, `reference`, `reading` and `motion`.
    pub fn inputs(&self) -> Vec<&'static str> {
        let texts = self.lines.iter().flat_map(Line::expressions).chain([self.output.as_str()]);
        let words: Vec<&str> = texts.flat_map(words).collect();
        INPUTS.into_iter().filter(|input| words.contains(input)).collect()
    }

    pub(crate) fn has_state(&self, name: &str) -> bool {
        self.truths.iter().chain(&self.numbers).any(|known| known == name)
    }

    pub(crate) fn constant(&mut self, name: &str, value: f64) {
        if !self.constants.iter().any(|(known, _)| known == name) {
            self.constants.push((name.into(), value));
        }
    }

    pub(crate) fn number_state(&mut self, name: &str) {
        if !self.has_state(name) {
            self.numbers.push(name.into());
        }
    }

    pub(crate) fn truth_state(&mut self, name: &str) {
        if !self.has_state(name) {
            self.truths.push(name.into());
        }
    }

    pub(crate) fn number(&mut self, name: &str, value: &str) {
        self.lines.push(Line::Number(name.into(), value.into()));
    }

    pub(crate) fn truth(&mut self, name: &str, value: &str) {
        self.lines.push(Line::Truth(name.into(), value.into()));
    }

    pub(crate) fn choice(&mut self, name: &str, when: &str, then: &str, otherwise: &str) {
        self.lines.push(Line::Choice(name.into(), [when.into(), then.into(), otherwise.into()]));
    }

    pub(crate) fn rounded(&mut self, name: &str, value: &str) {
        self.lines.push(Line::Rounded(name.into(), value.into()));
    }

    pub(crate) fn set(&mut self, state: &str, value: &str) {
        self.lines.push(Line::Set(state.into(), value.into()));
    }
}

impl Line {
    fn expressions(&self) -> Vec<&str> {
        match self {
            Self::Number(_, value)
            | Self::Truth(_, value)
            | Self::Rounded(_, value)
            | Self::Set(_, value) => {
                vec![value.as_str()]
            }
            Self::Choice(_, parts) => parts.iter().map(String::as_str).collect(),
        }
    }
}

/// Names in an expression. The name of a state begins with `s.`, so that it differs from those of inputs.
fn words(expression: &str) -> impl Iterator<Item = &str> {
    expression.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '.'))
}
