//! Blind benchmark: datasets whose hidden effect is withheld from the diagnosis, and scores of its answers.
//!
//! The data come from a bench of their own ([`bench`]). It has equations of motion written out by hand, small
//! semi-implicit steps, a bristle in place of dry friction, drift and coloured noise. No part of the
//! diagnosis, of its predictions or of the simulator is used to make them.

mod axis;
mod bench;
mod cases;
mod make;
mod noise;
mod regression;
mod score;
mod seal;
mod servo;
mod wild;

pub use cases::{Case, HiddenEffect};
pub use make::{CASES, HELD_BACK, SEALED, make};
pub use regression::{Regressed, regressions};
pub use score::{
    Answered, AnsweredEffect, Calibration, CaseScore, Measure, NOTHING, Score, ScoredValue, UNKNOWN, Unit,
    score,
};
pub use seal::unseal;
pub use servo::{ServoConditions, make_servo};
pub use wild::{Conditions, make_wild};
