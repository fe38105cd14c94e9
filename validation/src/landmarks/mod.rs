//! A machine with the landmarks that the paper measured on the MIT Precision Assembly Robot (Figs. 15 to 17),
//! as far as they determine one.
//!
//! The paper publishes landmarks of three measured responses and no parameters. The chain here is a stand-in
//! with the same landmarks. Its masses, springs and dampers are **not** those of the robot, and many other
//! machines would fit as well. [`fit`] gives the directions of parameter space that the landmarks leave free.
//! [`StartSearch`] counts how many of several starts, which use only the landmarks' frequencies, find the
//! chain.

mod chain;
mod fit;
mod response;
mod starts;

use std::f64::consts::TAU;

use feeler_analysis::frf::{Excitation, FrfExperiment, NoiseMethod};
use feeler_analysis::{LinearMachine, View, modes};
use feeler_files::Document;
use feeler_lti::C64;
use feeler_lti::spectral::{LocalPolynomialSettings, common_poles};
use feeler_plant::description::{Engagement, Machine, Quantity, SignalName};
use serde::Serialize;

use crate::error::ValidationError;
use crate::table::CheckRow;

pub use chain::LandmarkChain;
pub use fit::{Fit, StartSearch, fit};

/// Band of the search for landmarks, Hz.
const BAND_HZ: (f64, f64) = (2.0, 90.0);
/// Required accuracy of every landmark, Hz.
pub const LANDMARK_HZ: f64 = 1.0;
/// Resonances that the paper names, Hz.
const RESONANCES_HZ: [f64; 5] = [12.0, 38.0, 44.0, 67.0, 77.0];
/// A peak is the largest value within this distance, Hz: estimates scatter by a thousandth, and no two of
/// these resonances are so close.
const PEAK_HZ: f64 = 1.0;
/// The scenario file of the fitted chain.
const FILE: &str = include_str!("../../../scenarios/paper/machines/landmarks.toml");
/// Pairs of poles in the fit of measured accelerations: six bodies and the drive have seven at most.
const PAIRS: usize = 7;
/// Poles with more damping are not resonances.
const RESONANT: f64 = 0.5;
/// Step of the measured lines for the poles: every eighth, some tens for each resonance.
const EVERY: usize = 8;

/// The paper's landmarks found on a machine, Hz; NaN for an absent crossing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Landmarks {
    /// Frequencies of the modes nearest to the five resonances, each mode counted once.
    pub resonances_hz: [f64; 5],
    /// Peaks of the end-point's acceleration nearest to them, each counted once.
    pub peaks_hz: [f64; 5],
    /// Acceleration of the motor: phase falls below 0 degrees permanently. (In the fitted chain it also falls
    /// below 0 by about 30 degrees at the base mode, and returns. A base that changes the end-point's phase
    /// changes the motor's, too.)
    pub motor_hz: f64,
    /// Acceleration of the end-point: phase dips below 0 degrees, and returns.
    pub end_dip_hz: [f64; 2],
    /// Frequency above which that phase stays below 0.
    pub end_hz: f64,
    /// Contact force, clamped: phase falls through -180 degrees.
    pub force_hz: f64,
}

/// Landmarks that the paper reports.
pub const PAPER: Landmarks = Landmarks {
    resonances_hz: RESONANCES_HZ,
    peaks_hz: RESONANCES_HZ,
    motor_hz: 50.0,
    end_dip_hz: [11.0, 13.0],
    end_hz: 28.0,
    force_hz: 37.0,
};

impl Landmarks {
    /// From the phases (frequencies in Hz, degrees) of motor acceleration, end-point acceleration and clamped
    /// force.
    fn from_phases(
        resonances_hz: [f64; 5],
        peaks_hz: [f64; 5],
        [motor, end, force]: [&(Vec<f64>, Vec<f64>); 3],
    ) -> Self {
        let first = |found: &[f64]| found.first().copied().unwrap_or(f64::NAN);
        let (down, up) = crossings(&end.0, &end.1, 0.0);
        let end_dip_hz = [first(&down), first(&up)];
        Self {
            resonances_hz,
            peaks_hz,
            motor_hz: crossings(&motor.0, &motor.1, 0.0).0.last().copied().unwrap_or(f64::NAN),
            end_dip_hz,
            end_hz: down.into_iter().find(|f| *f > end_dip_hz[1]).unwrap_or(f64::NAN),
            force_hz: first(&crossings(&force.0, &force.1, -180.0).0),
        }
    }

    /// Name, found value and reported value of each landmark.
    pub fn against_paper(&self) -> Vec<(String, f64, f64)> {
        let mut all: Vec<(String, f64, f64)> = (self.resonances_hz.iter().zip(PAPER.resonances_hz))
            .map(|(got, expected)| (format!("resonance at {expected} Hz"), *got, expected))
            .collect();
        let peaks = self.peaks_hz.iter().zip(PAPER.peaks_hz);
        all.extend(peaks.map(|(got, expected)| {
            (format!("end-point acceleration peaks at {expected} Hz"), *got, expected)
        }));
        all.push(("motor acceleration below 0 degrees".into(), self.motor_hz, PAPER.motor_hz));
        all.push((
            "end-point acceleration dips below 0 degrees".into(),
            self.end_dip_hz[0],
            PAPER.end_dip_hz[0],
        ));
        all.push(("end-point acceleration returns above".into(), self.end_dip_hz[1], PAPER.end_dip_hz[1]));
        all.push(("end-point acceleration below 0 permanently".into(), self.end_hz, PAPER.end_hz));
        all.push(("clamped force through -180 degrees".into(), self.force_hz, PAPER.force_hz));
        all
    }
}

/// Phase (degrees) of a response on a fine grid, continued from its first value in (-180, 180].
fn phase_deg(plant: &LinearMachine, output: &SignalName) -> Result<(Vec<f64>, Vec<f64>), ValidationError> {
    let (frequencies, response) = response(plant, output)?;
    let phase = feeler_lti::unwrapped_phase_rad(&response).into_iter().map(f64::to_degrees).collect();
    Ok((frequencies, phase))
}

/// A response on a fine grid.
fn response(plant: &LinearMachine, output: &SignalName) -> Result<(Vec<f64>, Vec<C64>), ValidationError> {
    let points = 880;
    let frequencies: Vec<f64> = (0..=points)
        .map(|i| BAND_HZ.0 + (BAND_HZ.1 - BAND_HZ.0) * f64::from(i) / f64::from(points))
        .collect();
    let channel = plant.channel(&SignalName::new("drive", Quantity::Command), output)?;
    let response: Vec<C64> = channel.frequency_response(&frequencies)?;
    Ok((frequencies, response))
}

/// Frequencies at which a response is larger than anywhere within [`PEAK_HZ`] of them.
fn peaks(frequencies: &[f64], response: &[C64]) -> Vec<f64> {
    let is_peak = |i: &usize| {
        let from = frequencies.partition_point(|f| *f < frequencies[*i] - PEAK_HZ);
        let to = frequencies.partition_point(|f| *f <= frequencies[*i] + PEAK_HZ);
        // At the ends of the band a further rise cannot be excluded.
        from > 0 && to < frequencies.len() && (from..to).all(|j| response[j].norm() <= response[*i].norm())
    };
    (0..frequencies.len()).filter(is_peak).map(|i| frequencies[i]).collect()
}

/// Frequencies at which a phase crosses a level: downwards, and upwards.
fn crossings(frequencies: &[f64], phase: &[f64], level: f64) -> (Vec<f64>, Vec<f64>) {
    let (mut down, mut up) = (Vec::new(), Vec::new());
    for i in 1..phase.len() {
        let (a, b) = (phase[i - 1] - level, phase[i] - level);
        if (a > 0.0) != (b > 0.0) {
            let f = frequencies[i - 1] + (frequencies[i] - frequencies[i - 1]) * a / (a - b);
            if a > 0.0 { down.push(f) } else { up.push(f) }
        }
    }
    (down, up)
}

/// The fitted machine from its scenario file, with its contact engaged in this way.
///
/// # Errors
/// [`ValidationError::Reference`] if the file has mistakes.
pub fn fitted(engagement: Engagement) -> Result<Machine, ValidationError> {
    let document = Document::parse(FILE, "landmarks.toml")
        .map_err(|error| ValidationError::Reference { what: error.to_string() })?;
    Ok(engaged(&document.scenario.machine, engagement))
}

fn engaged(machine: &Machine, engagement: Engagement) -> Machine {
    let mut machine = machine.clone();
    machine.contacts.values_mut().for_each(|contact| contact.engagement = engagement);
    machine
}

/// The landmarks of a chain, by linear theory.
///
/// # Errors
/// [`ValidationError::Analysis`].
pub fn landmarks(machine: &Machine) -> Result<Landmarks, ValidationError> {
    let free = LinearMachine::new(&engaged(machine, Engagement::Free), &View::default())?;
    let clamped = LinearMachine::new(&engaged(machine, Engagement::Clamped), &View::default())?;
    let own: Vec<f64> = modes(&free)?.iter().map(|mode| mode.eigenvalue.im / TAU).collect();
    let motor = phase_deg(&free, &SignalName::new("motor", Quantity::Acceleration))?;
    let end_point = SignalName::new("link4", Quantity::Acceleration);
    let (end, (frequencies, response)) = (phase_deg(&free, &end_point)?, response(&free, &end_point)?);
    let peaks_hz = nearest_resonances(&peaks(&frequencies, &response));
    let force = phase_deg(&clamped, &SignalName::new("tool", Quantity::SpringForce))?;
    Ok(Landmarks::from_phases(nearest_resonances(&own), peaks_hz, [&motor, &end, &force]))
}

/// For each of the paper's resonances the nearest frequency, each counted once; NaN if none is left.
fn nearest_resonances(found_hz: &[f64]) -> [f64; 5] {
    let mut left = found_hz.to_vec();
    RESONANCES_HZ.map(|named| {
        let nearest =
            (0..left.len()).min_by(|&i, &j| (left[i] - named).abs().total_cmp(&(left[j] - named).abs()));
        nearest.map_or(f64::NAN, |i| left.swap_remove(i))
    })
}

/// The landmarks from white-noise experiments on the simulated machine: crossings of measured phases, and
/// peaks of the measured acceleration of the end-point. Resonances are the common poles of the two measured
/// accelerations.
///
/// # Errors
/// [`ValidationError::Analysis`], [`ValidationError::Lti`].
pub fn simulated_landmarks(machine: &Machine, duration_s: f64) -> Result<Landmarks, ValidationError> {
    let measured = |engagement, element: &str, quantity| -> Result<(Vec<f64>, Vec<C64>), ValidationError> {
        // Commands are held so briefly that the hold changes the phase at 50 Hz by less than a degree: the
        // paper's amplifier had none.
        let experiment = FrfExperiment {
            machine: engaged(machine, engagement),
            actuator: "drive".into(),
            output: SignalName::new(element, quantity),
            hold_s: 1e-4,
            offset: 0.0,
            seed: 5,
        };
        let method = NoiseMethod::LocalPolynomial(LocalPolynomialSettings::default());
        let noise = Excitation::WhiteNoise { duration_s, method };
        let estimate = experiment.measure(&noise, 1.0, (BAND_HZ.0, BAND_HZ.1))?.estimate;
        Ok((estimate.frequencies_hz, estimate.response))
    };
    let phase = |(frequencies, response): &(Vec<f64>, Vec<C64>)| {
        (
            frequencies.clone(),
            feeler_lti::unwrapped_phase_rad(response).into_iter().map(f64::to_degrees).collect::<Vec<f64>>(),
        )
    };
    let motor = measured(Engagement::Free, "motor", Quantity::Acceleration)?;
    let end = measured(Engagement::Free, "link4", Quantity::Acceleration)?;
    let force = measured(Engagement::Clamped, "tool", Quantity::SpringForce)?;
    let thinned = |values: &[C64]| values.iter().copied().step_by(EVERY).collect::<Vec<_>>();
    let frequencies: Vec<f64> = motor.0.iter().copied().step_by(EVERY).collect();
    let poles = common_poles(&frequencies, &[thinned(&motor.1), thinned(&end.1)], PAIRS)?;
    let resonances: Vec<f64> =
        poles.iter().filter(|p| -p.re < RESONANT * p.norm()).map(|p| p.im / TAU).collect();
    let peaks_hz = nearest_resonances(&peaks(&end.0, &end.1));
    Ok(Landmarks::from_phases(
        nearest_resonances(&resonances),
        peaks_hz,
        [&phase(&motor), &phase(&end), &phase(&force)],
    ))
}

/// Rows for the fourth claim, by simulated white-noise experiments.
///
/// # Errors
/// As [`simulated_landmarks`].
pub(crate) fn simulated_rows() -> Result<Vec<CheckRow>, ValidationError> {
    let claim = "claim 4: landmarks of the measured machine, by simulated white-noise experiments";
    let found = simulated_landmarks(&fitted(Engagement::Free)?, 120.0)?;
    Ok(found
        .against_paper()
        .into_iter()
        .map(|(name, got, expected)| CheckRow::close(name, claim, got, expected, LANDMARK_HZ))
        .collect())
}

/// Rows for the fourth claim, by linear theory.
///
/// # Errors
/// [`ValidationError::Analysis`].
pub fn rows(machine: &Machine) -> Result<Vec<CheckRow>, ValidationError> {
    let claim = "claim 4: landmarks of the measured machine (Figs. 15 to 17)";
    let found = landmarks(machine)?;
    Ok(found
        .against_paper()
        .into_iter()
        .map(|(name, got, expected)| CheckRow::close(name, claim, got, expected, LANDMARK_HZ))
        .collect())
}
