//! A fitted set of causes.

use std::borrow::Borrow;

use crate::fit::candidates::Candidate;
use crate::fit::least_squares::Fitted;
use crate::inverse::Balanced;

/// The sets without repetitions: the first of each is kept.
pub(crate) fn distinct<T: Borrow<Scored>>(sets: impl IntoIterator<Item = T>) -> Vec<T> {
    let mut kept: Vec<T> = Vec::new();
    for set in sets {
        if !kept.iter().any(|other| other.borrow().is_same(set.borrow())) {
            kept.push(set);
        }
    }
    kept
}

/// A candidate with its fit and its misfits on every record.
#[derive(Clone, Debug)]
pub(crate) struct Scored {
    pub(crate) causes: Vec<Candidate>,
    pub(crate) fitted: Fitted,
    /// Mean robust squared residual per record and channel.
    pub(crate) misfits: Vec<Vec<f64>>,
    /// The balance of forces with the same causes; `None` if a balance does not involve one of them.
    pub(crate) balanced: Option<Balanced>,
}

impl Scored {
    /// The parameters of a cause.
    pub(crate) fn values(&self, cause: usize) -> Vec<f64> {
        self.fitted.model.parameters(cause, &self.fitted.theta)
    }

    /// The causes that another set lacks, with their indices.
    pub(crate) fn beyond<'s>(&'s self, other: &Self) -> Vec<(usize, &'s Candidate)> {
        let is_own = |(_, cause): &(usize, &Candidate)| !other.causes.iter().any(|known| known.is(cause));
        self.causes.iter().enumerate().filter(is_own).collect()
    }

    /// Whether another set has the same causes.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        self.is_of(&other.causes)
    }

    /// Whether these are the causes of the set.
    pub(crate) fn is_of(&self, causes: &[Candidate]) -> bool {
        let is_one = |own: &Candidate| causes.iter().any(|cause| cause.is(own));
        self.causes.len() == causes.len() && self.causes.iter().all(is_one)
    }
}
