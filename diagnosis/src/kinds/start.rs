//! Starting points of fits, shared by similar kinds.

use std::f64::consts::TAU;

use feeler_plant::effects::Parameters;

use super::element::Glance;

/// Initial damping ratio of modes, and ratio of neighbouring initial frequencies. A fit finds a resonance
/// only from within its width, so neighbouring starts must be this close.
pub(super) const NARROW: f64 = 0.05;
const STEP: f64 = 1.08;

/// Trial multiples of a typical value.
const ABOUT: [f64; 3] = [0.3, 1.0, 3.0];

/// Every combination of values about the typical ones; optional parameters are omitted.
pub(super) fn about_typical<P: Parameters>() -> Vec<P> {
    let axes = P::PARAMETERS
        .iter()
        .map(|p| p.default.map_or_else(|| ABOUT.map(|f| f * p.typical).to_vec(), |d| vec![d]));
    let every = axes.fold(vec![Vec::new()], |points: Vec<Vec<f64>>, axis| {
        points
            .iter()
            .flat_map(|point| axis.iter().map(move |&value| point.iter().copied().chain([value]).collect()))
            .collect()
    });
    every.iter().map(|values| P::of(values)).collect()
}

/// Gains that are too small or too large.
pub(super) const GAINS: [f64; 4] = [0.6, 0.8, 1.25, 1.6];

/// Trial levels of a force, from the largest command: in slow drives friction takes most of the command.
pub(super) fn levels(largest: f64) -> [f64; 5] {
    [0.01, 0.04, 0.15, 0.4, 0.8].map(|f| f * largest)
}

/// Trial lags and delays, s.
pub(super) fn times(glance: &Glance) -> [f64; 3] {
    [0.6, 2.0, 6.0].map(|f| f * glance.spacing_s)
}

/// Quantisation steps in the values of a sensor.
pub(super) fn quanta(sensor: feeler_plant::effects::Host, glance: &Glance) -> impl Iterator<Item = f64> {
    let of_it = move |(i, _): &&(usize, f64)| sensor == feeler_plant::effects::Host::Sensor(*i);
    glance.quanta.iter().filter(of_it).map(|(_, step)| *step)
}

/// Stiffness and damping of a spring on which a mass oscillates at a frequency with a damping ratio.
pub(super) fn mode(mass: f64, frequency_hz: f64, ratio: f64) -> (f64, f64) {
    let omega = TAU * frequency_hz;
    (mass * omega * omega, 2.0 * ratio * mass * omega)
}

/// Frequencies across a range, Hz.
pub(super) fn every((low, high): (f64, f64)) -> impl Iterator<Item = f64> {
    std::iter::successors(Some(low), |f| Some(STEP * f)).take_while(move |f| *f <= high)
}

/// Whether a mode is overdamped, so that it does not oscillate.
pub(super) fn is_overdamped(mass: f64, stiffness: f64, damping: f64) -> bool {
    damping > 2.0 * (mass * stiffness).sqrt()
}

/// Relative difference between two values.
pub(super) fn off(value: f64, believed: f64) -> f64 {
    (value / believed - 1.0).abs()
}
