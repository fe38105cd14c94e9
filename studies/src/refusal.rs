//! A rejected request, with its remedy.

use std::borrow::Cow;

use feeler_problem::Remedy;
use thiserror::Error;

/// A request that cannot be met: the reason and the remedy, each a sentence without full stop.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{message}")]
pub struct Refusal {
    /// The mistake in words.
    pub message: String,
    /// How to correct it.
    pub remedy: String,
}

impl Refusal {
    /// From a message and its remedy.
    pub fn new(message: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { message: message.into(), remedy: remedy.into() }
    }
}

impl Remedy for Refusal {
    fn remedy(&self) -> Cow<'_, str> {
        self.remedy.as_str().into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let all = [Refusal::new("the pose is empty", "write a number for each joint")];
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("refusal.rs")),
            Vec::<String>::new()
        );
    }
}
