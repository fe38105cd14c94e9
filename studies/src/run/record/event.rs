//! Events as programs read them.

use serde::Serialize;

/// An event in the summary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EventRecord {
    /// When.
    pub t_s: f64,
    /// `touch`, `lift`, `stick`, `slip`, `limit`, `release`.
    pub what: &'static str,
    /// The element.
    pub on: String,
}
