//! The simulation compared with the analysis: frequency responses and the onset of instability.

use feeler_analysis::View;
use feeler_analysis::frf::{Excitation, FrfExperiment, MeasuredResponse, NoiseMethod};
use feeler_control::ForceGains;
use feeler_engine::{Program, RunEnd, Scenario, Simulation, Trace};
use feeler_lti::C64;
use feeler_lti::spectral::{LocalPolynomialSettings, WelchSettings, cross_spectra};
use feeler_plant::description::{Quantity, SignalName};

use crate::error::ValidationError;
use crate::paper::{IDEAL, PaperAxis, PaperModel, SOURCE, gain_of};
use crate::table::CheckRow;
use crate::truths::axis_response;

/// Hold and sample time of all experiments, s.
pub const HOLD_S: f64 = 1e-3;
/// Band of comparison, Hz.
pub const BAND_HZ: (f64, f64) = (1.0, 400.0);
/// Tolerance of measured responses, dB and degrees.
const MAGNITUDE_DB: f64 = 0.05;
const PHASE_DEG: f64 = 0.3;
/// Least coherence of the compared frequencies.
const COHERENCE: f64 = 0.99;
/// Tolerance of the onset of instability, relative to the predicted gain.
const ONSET: f64 = 1e-3;
/// Tolerance of transfer functions from two methods: rounding of a few hundred operations, amplified near
/// lightly damped zeros.
const TWO_ROUTES: f64 = 1e-9;
/// Length of the segments for the coherence, s.
const SEGMENT_S: f64 = 4.0;

/// Every machine of the paper: each model with both drives.
pub fn paper_axes() -> Vec<(String, PaperAxis)> {
    let drives = [("ideal", IDEAL), ("source", SOURCE)];
    let each = |model: PaperModel| {
        drives.map(|(name, drive)| (format!("{}, {name}", model.name()), PaperAxis::reference(model, drive)))
    };
    PaperModel::ALL.into_iter().flat_map(each).collect()
}

/// The measurement of an axis from command to elastic contact force, clamped.
fn clamped_experiment(axis: &PaperAxis) -> FrfExperiment {
    FrfExperiment {
        machine: axis.machine("axis"),
        actuator: "drive".into(),
        output: SignalName::new("tool", Quantity::SpringForce),
        hold_s: HOLD_S,
        offset: 0.0,
        seed: 11,
    }
}

/// Transfer function by hand against the state space from the machine's description.
///
/// # Errors
/// [`ValidationError::Analysis`].
pub fn two_route_rows() -> Result<Vec<CheckRow>, ValidationError> {
    let mut rows = Vec::new();
    for (name, axis) in paper_axes() {
        let plant = feeler_analysis::LinearMachine::new(&axis.machine("axis"), &View::CLAMPED)?;
        let channel = plant.channel(
            &SignalName::new("drive", Quantity::Command),
            &SignalName::new("tool", Quantity::SpringForce),
        )?;
        let frequencies: Vec<f64> = (0..400).map(|i| 0.1 * 10_f64.powf(f64::from(i) / 100.0)).collect();
        let found = channel.frequency_response(&frequencies)?;
        let worst = frequencies.iter().zip(&found).map(|(f, g)| {
            let expected = axis_response(&axis, C64::new(0.0, std::f64::consts::TAU * f));
            (g - expected).norm() / expected.norm()
        });
        let claim = "three routes agree: equations of motion by hand, state space from the file";
        rows.push(CheckRow::at_most(
            format!("{name}: response, relative difference"),
            claim,
            worst.fold(0.0, f64::max),
            TWO_ROUTES,
        ));
    }
    Ok(rows)
}

/// Largest differences in dB and degrees over the frequencies for which `counts` holds, and their number.
fn differences(measured: &MeasuredResponse, counts: impl Fn(f64) -> bool) -> (f64, f64, usize) {
    let mut worst = (0.0_f64, 0.0_f64, 0);
    let values =
        measured.estimate.response.iter().zip(&measured.linear).zip(&measured.estimate.frequencies_hz);
    for ((g, linear), _) in values.filter(|(_, f)| counts(**f)) {
        let ratio = g / linear;
        worst.0 = worst.0.max((20.0 * ratio.norm().log10()).abs());
        worst.1 = worst.1.max(ratio.arg().to_degrees().abs());
        worst.2 += 1;
    }
    worst
}

/// Effort of a measured response.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponseEffort {
    /// Length of the noise record, s.
    pub noise_s: f64,
    pub multisine_period_s: f64,
}

impl ResponseEffort {
    /// Effort for every machine.
    pub(crate) const FULL: Self = Self { noise_s: 240.0, multisine_period_s: 4.0 };
    /// Effort for a machine whose resonances are at least 1 Hz wide.
    pub const QUICK: Self = Self { noise_s: 60.0, multisine_period_s: 1.0 };
}

/// Measured against linear response of one axis, by noise and by multisine.
///
/// # Errors
/// [`ValidationError::Analysis`].
pub fn response_rows(
    name: &str,
    axis: &PaperAxis,
    effort: ResponseEffort,
) -> Result<Vec<CheckRow>, ValidationError> {
    let claim = "simulated response agrees with the linear one";
    let experiment = clamped_experiment(axis);
    let mut rows = Vec::new();
    let mut compare = |excitation: &str, (db, deg, lines): (f64, f64, usize)| {
        rows.push(CheckRow::at_most(format!("{name}: {excitation}, dB"), claim, db, MAGNITUDE_DB));
        rows.push(CheckRow::at_most(format!("{name}: {excitation}, degrees"), claim, deg, PHASE_DEG));
        rows.push(CheckRow::above(
            format!("{name}: {excitation}, frequencies compared"),
            claim,
            lines as f64,
            50.0,
        ));
    };
    let periodic = Excitation::Multisine {
        period_s: effort.multisine_period_s,
        periods: 2,
        transient_periods: 4,
        realisations: 1,
    };
    compare("multisine", differences(&experiment.measure(&periodic, 1.0, BAND_HZ)?, |_| true));

    let method = NoiseMethod::LocalPolynomial(LocalPolynomialSettings::default());
    let noise = Excitation::WhiteNoise { duration_s: effort.noise_s, method };
    let measured = experiment.measure(&noise, 1.0, BAND_HZ)?;
    let spec =
        feeler_control::ReferenceSpec::WhiteNoise { low_hz: 0.0, high_hz: BAND_HZ.1, rms: 1.0, offset: 0.0 };
    let (u, y) = experiment.record(spec, experiment.seed, effort.noise_s)?;
    let spectra = cross_spectra(&u, &y, HOLD_S, &WelchSettings::hann((SEGMENT_S / HOLD_S) as usize))?;
    let coherence = spectra.coherence();
    let coherent =
        |f: f64| coherence[((f * SEGMENT_S).round() as usize).min(coherence.len() - 1)] > COHERENCE;
    compare("white noise", differences(&measured, coherent));
    Ok(rows)
}

/// Growth rate of the motion (1/s) of a linear closed loop over the later part of a run. It follows from the
/// energy of the force in two stretches.
fn growth_per_s(scenario: &Scenario, duration_s: f64) -> Result<f64, ValidationError> {
    let mut scenario = scenario.clone();
    scenario.run.duration_s = duration_s;
    scenario.run.record = vec![SignalName::new("tool", Quantity::SpringForce)];
    scenario.run.record_rate_hz = Some(1.0 / HOLD_S);
    for body in scenario.machine.bodies.values_mut().take(2) {
        body.velocity_m_per_s = 1e-3;
    }
    let program = Program::new(&scenario)?;
    let mut trace = Trace::new(program.record_names());
    let mut simulation = Simulation::<f64>::new(vec![program])?;
    simulation.run(&mut trace)?;
    if simulation.end(0) != Some(RunEnd::Completed) {
        return Ok(f64::INFINITY);
    }
    let force = &trace.columns[0];
    let window = force.len() / 5;
    let energy = |first: usize| force[first..first + window].iter().map(|f| f * f).sum::<f64>();
    let (early, late) = (energy(2 * window), energy(4 * window));
    Ok((late / early).ln() / (2.0 * 2.0 * window as f64 * HOLD_S))
}

/// Simulated against predicted onset of instability of a proportional force loop, by bisection on long runs.
///
/// # Errors
/// [`ValidationError::Analysis`], [`ValidationError::Engine`].
pub fn onset_row(
    name: &str,
    axis: &PaperAxis,
    delay_samples: f64,
    duration_s: f64,
) -> Result<CheckRow, ValidationError> {
    let scenario =
        |kp: f64| axis.force_loop(ForceGains { kp, ..ForceGains::default() }, HOLD_S, delay_samples * HOLD_S);
    let whole = axis.kp_loop(HOLD_S, delay_samples * HOLD_S)?;
    let predicted = whole.sampled_bands(gain_of(&whole))?.first_upper();
    let (mut low, mut high) = (0.98 * predicted, 1.02 * predicted);
    // The bracket itself is checked: onset must lie within it.
    let bracketed =
        growth_per_s(&scenario(low), duration_s)? < 0.0 && growth_per_s(&scenario(high), duration_s)? > 0.0;
    while bracketed && high - low > 0.2 * ONSET * predicted {
        let middle = 0.5 * (low + high);
        if growth_per_s(&scenario(middle), duration_s)? > 0.0 { high = middle } else { low = middle }
    }
    let got = if bracketed { 0.5 * (low + high) } else { f64::NAN };
    let claim = "simulated onset of instability at the predicted gain";
    Ok(CheckRow::relative(
        format!("{name}: onset of instability, {delay_samples} samples late"),
        claim,
        got,
        predicted,
        ONSET,
    ))
}
