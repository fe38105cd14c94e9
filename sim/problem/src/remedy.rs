//! The information that every error of Feeler adds to its message.

use std::borrow::Cow;
use std::error::Error;

use crate::problem::Problem;

/// An error with its place and its remedy.
///
/// An error that wraps another returns it by [`Remedy::passed_on`] and then gives its place and remedy.
pub trait Remedy: Error + Send + Sync {
    /// The error of another crate that this one passes on as it is.
    fn passed_on(&self) -> Option<&dyn Remedy> {
        None
    }

    /// The remedy as a request: "name another folder".
    fn remedy(&self) -> Cow<'_, str>;

    /// The place: dotted path of a key, a file, a row; empty if it is the input as a whole.
    fn place(&self) -> String {
        self.passed_on().map_or_else(String::new, Remedy::place)
    }

    /// Whether the calling program made the mistake, and not its user.
    fn is_of_caller(&self) -> bool {
        self.passed_on().is_some_and(Remedy::is_of_caller)
    }

    /// Every mistake that this error contains.
    fn problems(&self) -> Vec<Problem> {
        self.passed_on().map_or_else(
            || vec![Problem::new(self.place(), self.to_string(), self.remedy())],
            Remedy::problems,
        )
    }

    /// The text for a terminal: each mistake with its place and its remedy.
    fn report(&self, coloured: bool) -> String {
        self.passed_on().map_or_else(
            || {
                let shown =
                    |problem: Problem| format!("error: {}\n  help: {}", problem.headline(), problem.remedy);
                self.problems().into_iter().map(shown).collect::<Vec<_>>().join("\n")
            },
            |inner| inner.report(coloured),
        )
    }
}
