//! Events as programs read them.

use serde::Serialize;

/// An event in the summary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EventRecord {
    /// Time of the event.
    pub t_s: f64,
    /// `touch`, `lift`, `stick`, `slip`, `limit`, `release`.
    pub what: &'static str,
    /// Name of the element.
    pub on: String,
}
