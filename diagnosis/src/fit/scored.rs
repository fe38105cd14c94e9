//! A set of causes that was fitted.

use crate::fit::candidates::Candidate;
use crate::fit::least_squares::Fitted;
use crate::inverse::Balanced;

/// A candidate with its fit and its misfits on every record.
#[derive(Clone, Debug)]
pub(crate) struct Scored {
    pub(crate) causes: Vec<Candidate>,
    pub(crate) fitted: Fitted,
    /// Mean robust squared residual per record and channel.
    pub(crate) misfits: Vec<Vec<f64>>,
    /// The same causes in a balance of forces; `None` if none shows them.
    pub(crate) balanced: Option<Balanced>,
}
