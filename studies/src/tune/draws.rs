//! Machines drawn from the uncertain values of one.

use feeler_engine::Scenario;
use feeler_files::{Document, MOST_DIMENSIONS, Setting};
use rayon::prelude::*;
use serde::Serialize;

use super::error::{TuneError, refused};
use crate::sweep::sobol;

/// A number of a machine that is known within an interval.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Uncertain {
    /// Its key, as in `springs.guide.effects.coulomb-friction.level`.
    pub key: String,
    /// The most probable value, SI.
    pub value: f64,
    /// The interval, SI.
    pub interval: [f64; 2],
}

/// The file's machine with the most probable values, then `draws` with values spread evenly over the
/// intervals, by Sobol's sequence from its point `first` on. The file's machine alone if nothing is
/// uncertain.
///
/// # Errors
/// More numbers than the sequence has dimensions; values that the file refuses.
pub fn machines(
    document: &Document,
    uncertain: &[Uncertain],
    draws: usize,
    first: u32,
) -> Result<Vec<Scenario>, TuneError> {
    if uncertain.is_empty() {
        return Ok(vec![document.scenario.clone()]);
    }
    if uncertain.len() > MOST_DIMENSIONS {
        return Err(refused(
            format!("{} numbers are uncertain, and {MOST_DIMENSIONS} can be drawn", uncertain.len()),
            "diagnose with fewer causes, or fix the narrowest ones in the file",
        ));
    }
    let probable = with(document, uncertain, |_, one| one.value)?;
    let drawn = (0..draws).into_par_iter().map(|draw| {
        // The first point of the sequence is the corner of all lower ends. It is the least informative, so it
        // is skipped.
        let index = first + 1 + u32::try_from(draw).unwrap_or(u32::MAX - first - 1);
        with(document, uncertain, |dimension, Uncertain { interval: [low, high], .. }| {
            let share = f64::from(sobol(dimension, index)) * 0.5_f64.powi(32);
            low + share * (high - low)
        })
    });
    let drawn = drawn.collect::<Result<Vec<_>, _>>()?;
    Ok(std::iter::once(probable).chain(drawn).collect())
}

fn with(
    document: &Document,
    uncertain: &[Uncertain],
    value: impl Fn(usize, &Uncertain) -> f64,
) -> Result<Scenario, TuneError> {
    let settings =
        uncertain.iter().enumerate().map(|(i, one)| (one.key.as_str(), Setting::Number(value(i, one))));
    Ok(document.with(settings)?.scenario)
}
