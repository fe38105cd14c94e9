//! The force bandwidth that an axis allows.

use std::f64::consts::TAU;

use feeler_analysis::{AnalysisError, GainReport, Request, analyze};
use feeler_arm::{Agreement, Reduction};
use feeler_control::{ForceGains, Law};
use feeler_engine::Scenario;

use super::axis_file::{ToolContact, axis_text};
use super::error::ArmFileError;
use crate::format::Document;

/// Integral gain from which the largest stable one is found, 1/s.
const TRIED_GAIN: f64 = 0.1;
/// Share of the largest stable gain: a gain margin of two.
const GAIN_SHARE: f64 = 0.5;
/// Frequencies among which a crossover is looked for: from 1 mHz to 1 kHz.
const LOWEST_HZ: f64 = 1e-3;
const GRID_RATIO: f64 = 1.02;
const GRID: i32 = 698;
/// Halvings of a step of the grid, to rounding.
const HALVINGS: u32 = 50;
const KEY: &str = "controllers.force.ki";

/// What integral force control with damping of the motors reaches on an axis, sampled at 1 kHz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceBandwidth {
    /// Largest stable integral gain, 1/s: zero where none is stable, infinite where all are.
    pub largest_gain_per_s: f64,
    /// Where the force loop's gain is one at half of it, Hz; not a number where no gain is stable, or all are.
    pub crossover_hz: f64,
    /// Frequency at which the loop oscillates at the largest gain, Hz.
    pub edge_hz: f64,
}

/// What integral force control reaches on an axis, with a gain margin of two, the motors damped so that the arm's contact mode has a damping ratio of 0.7; dry
/// friction left out.
///
/// # Errors
/// [`ArmFileError::Analysis`].
pub fn force_bandwidth(axis: &Reduction, agreement: &Agreement, contact: ToolContact) -> Result<ForceBandwidth, ArmFileError> {
    let smooth = Reduction { dry_friction_n: 0.0, ..axis.clone() };
    let mut scenario = Document::parse(&axis_text(&smooth, contact, 1.0), "axis.toml")?.scenario;
    let damping = agreement.motor_damping_n_s_per_m;
    for used in scenario.controllers.values_mut() {
        used.spec.law = Law::ExplicitForce(ForceGains { ki: TRIED_GAIN, damping, ..ForceGains::default() });
    }
    let gain = report(&scenario)?.gain;
    let edge_hz = gain.as_ref().and_then(|gain| gain.sampled.edge_hz).unwrap_or(f64::NAN);
    let edge = largest_stable(gain.as_ref());
    let damped = Reduction { guide_damping_n_s_per_m: axis.guide_damping_n_s_per_m + damping, ..axis.clone() };
    let crossover_hz = if edge > 0.0 && edge.is_finite() { crossover_hz(&damped, contact, GAIN_SHARE * edge) } else { f64::NAN };
    Ok(ForceBandwidth { largest_gain_per_s: edge, crossover_hz, edge_hz })
}

/// The largest stable gain of a report: zero where none is stable, infinite where all are.
pub(super) fn largest_stable(gain: Option<&GainReport>) -> f64 {
    match gain.map(|gain| (gain.sampled.all.bands.is_empty(), gain.sampled.stable[1])) {
        Some((true, _)) => 0.0,
        Some((false, Some(edge))) => edge,
        _ => f64::INFINITY,
    }
}

/// Where an integral loop around an axis has a gain of one; the hold and the sampling, which hardly change sizes there, left out.
fn crossover_hz(axis: &Reduction, contact: ToolContact, ki: f64) -> f64 {
    let touch = [contact.stiffness_n_per_m, contact.damping_n_s_per_m];
    let gain = |f: f64| {
        let drive = axis.bandwidth_hz.map_or(1.0, |corner_hz| 1.0 / f64::hypot(1.0, f / corner_hz));
        ki / (TAU * f) * axis.response_in_contact(touch, f).norm() * drive
    };
    // The gain falls from infinity; the first crossing is bracketed on a grid and halved.
    let grid = |i: i32| LOWEST_HZ * GRID_RATIO.powi(i);
    let Some(above) = (1..GRID).find(|&i| gain(grid(i)) < 1.0) else { return f64::NAN };
    let (mut low, mut high) = (grid(above - 1), grid(above));
    for _ in 0..HALVINGS {
        let middle = (low * high).sqrt();
        if gain(middle) < 1.0 { high = middle } else { low = middle }
    }
    (low * high).sqrt()
}

fn report(scenario: &Scenario) -> Result<feeler_analysis::Report, AnalysisError> {
    analyze(scenario, &Request { gain: Some(KEY.into()), ..Request::default() })
}
