//! Blind benchmark: datasets whose hidden effect is withheld from the diagnosis, and scores of its answers.
//!
//! The data come from a separate bench ([`bench`]). It has hand-written equations of motion, small
//! semi-implicit steps, a bristle for dry friction, drift and coloured noise. It uses no part of the
//! diagnosis, of its predictions or of the simulator.

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
    Answered, AnsweredEffect, Calibration, CaseScore, Measure, MeasureUnit, NOTHING, Score, ScoredValue,
    UNKNOWN, score,
};
pub use seal::unseal;
pub use servo::{ServoConditions, make_servo};
pub use wild::{Conditions, make_wild};
