//! What is wrong with a request, and what to do about it.

use std::borrow::Cow;

use feeler_problem::Remedy;
use thiserror::Error;

/// A request that cannot be met: what is wrong, and the remedy, each a sentence without full stop.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{message}")]
pub struct Refusal {
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub remedy: String,
}

impl Refusal {
    /// Of a message and its remedy.
    pub fn new(message: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { message: message.into(), remedy: remedy.into() }
    }
}

impl Remedy for Refusal {
    fn remedy(&self) -> Cow<'_, str> {
        self.remedy.as_str().into()
    }
}
