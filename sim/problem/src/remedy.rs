//! What every error of Feeler says beside what is wrong.

use std::borrow::Cow;
use std::error::Error;

use crate::problem::Problem;

/// An error that says where it is and what to do about it.
///
/// An error that wraps another hands it out by [`Remedy::passed_on`] and so says what that one says.
pub trait Remedy: Error + Send + Sync {
    /// The error of another crate that this one passes on as it is.
    fn passed_on(&self) -> Option<&dyn Remedy> {
        None
    }

    /// What to do about it, as a request: "name another folder".
    fn remedy(&self) -> Cow<'_, str>;

    /// Where it is: dotted path of a key, a file, a row; empty where the input as a whole is meant.
    fn place(&self) -> String {
        self.passed_on().map_or_else(String::new, Remedy::place)
    }

    /// Whether the calling program is at fault, and no input of its user.
    fn is_of_caller(&self) -> bool {
        self.passed_on().is_some_and(Remedy::is_of_caller)
    }

    /// Every mistake that this error stands for.
    fn problems(&self) -> Vec<Problem> {
        self.passed_on().map_or_else(
            || vec![Problem::new(self.place(), self.to_string(), self.remedy())],
            Remedy::problems,
        )
    }

    /// What a terminal shows: each mistake with its place, and what to do about it.
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
