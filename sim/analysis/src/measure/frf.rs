//! Frequency responses measured on the simulated machine, as an analyst would measure them on the robot, with
//! the linear response beside them.
//!
//! The command is held between samples. The output is sampled at the same instants, just before the next
//! command acts. The linear response is that of the held and sampled machine with exact delays.

use std::f64::consts::TAU;

use feeler_control::reference::{ChirpSweep, Lines};
use feeler_control::{ControllerSpec, Law, ReferenceSpec};
use feeler_engine::{ControllerUse, Program, RunEnd, RunSettings, Scenario, Simulation, Trace};
use feeler_lti::C64;
use feeler_lti::spectral::{
    Estimator, Evidence, LocalPolynomialSettings, Realisation, ResponseEstimate, SteppedSinePoint,
    WelchSettings, best_linear_approximation, cross_spectra, local_polynomial, periodic_response,
    smoothed_spectra, stepped_sine,
};
use feeler_plant::description::{ActuatorKind, Machine, Quantity, SignalName};
use feeler_plant::motion::dot;

use crate::error::AnalysisError;
use crate::loops::control_loop::ControlLoop;
use crate::machine::imposed::ImposedResponse;
use crate::machine::linearise::LinearMachine;
use crate::machine::prepare::{HeldCommand, View};

/// Number of segments that give the coherence for a local polynomial estimate.
const COHERENCE_SEGMENTS: usize = 16;

/// A measurement: machine, signals, excitation, and the hold of the command.
#[derive(Clone, Debug, PartialEq)]
pub struct FrfExperiment {
    /// The machine, with the engagement of the measurement.
    pub machine: Machine,
    /// The actuator that is excited.
    pub actuator: String,
    /// The signal that is recorded; a sensor's reading comes with its noise and delay.
    pub output: SignalName,
    /// Time for which each command is held, and sample period of the record, s.
    pub hold_s: f64,
    /// Mean of the command, in its unit.
    pub offset: f64,
    /// Seed of excitation and noise.
    pub seed: u64,
}

/// How a response is estimated from noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoiseMethod {
    /// Averages over Hann-windowed segments that overlap by half.
    Welch {
        segment_s: f64,
        /// H1, H2 or Hv.
        estimator: Estimator,
    },
    /// Local polynomials through neighbouring lines of the whole record: leakage is estimated and removed.
    LocalPolynomial(LocalPolynomialSettings),
}

/// The excitation of the actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Excitation {
    /// Band-limited Gaussian noise, as in the paper.
    WhiteNoise {
        /// Length of the record, s.
        duration_s: f64,
        method: NoiseMethod,
    },
    /// Multisines of random phase.
    Multisine {
        /// Period, s; a whole number of holds.
        period_s: f64,
        /// Number of periods that are evaluated, at least two.
        periods: usize,
        /// Number of periods before them, in which transients decay.
        transient_periods: usize,
        /// Number of phase realisations; with two or more, nonlinear distortion is separated from noise.
        realisations: usize,
    },
    /// A linear chirp, recorded until the machine is at rest again.
    Chirp {
        sweep_s: f64,
        /// Rest after the sweep, s.
        rest_s: f64,
        /// Neighbouring lines averaged on each side, at least one.
        half_width: usize,
    },
    /// One sine after the other.
    SteppedSine {
        /// Number of frequencies, evenly spaced on a logarithmic scale.
        points: usize,
        /// Time for transients at each frequency, s.
        settle_s: f64,
        /// Time that is evaluated at each frequency, s.
        measure_s: f64,
    },
}

/// A measured response and the linear one at the same frequencies.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredResponse {
    /// The estimate with its uncertainty.
    pub estimate: ResponseEstimate,
    /// The machine's linear response with hold, sampling and delays, at the frequencies of the estimate.
    pub linear: Vec<C64>,
    /// Per frequency, variance of a single realisation due to nonlinear distortion; only for a multisine with
    /// two or more realisations.
    pub distortion_variance: Option<Vec<f64>>,
    /// Per frequency, variance of the estimate due to noise alone; `None` without `distortion_variance`.
    pub noise_variance: Option<Vec<f64>>,
    /// Whether there is distortion beyond the noise; `None` without `distortion_variance`.
    pub evidence: Option<Evidence>,
}

/// The response between two frequencies from records of input and output under a noise-like excitation,
/// simulated or measured on a real machine.
///
/// # Errors
/// [`AnalysisError::Lti`] for records of different length, too short, or without power at a frequency.
pub fn response_from_noise(
    input: &[f64],
    output: &[f64],
    sample_s: f64,
    method: NoiseMethod,
    band_hz: (f64, f64),
) -> Result<ResponseEstimate, AnalysisError> {
    Ok(match method {
        NoiseMethod::Welch { segment_s, estimator } => {
            let settings = WelchSettings::hann((segment_s / sample_s).round() as usize);
            cross_spectra(input, output, sample_s, &settings)?.response(estimator, band_hz.0, band_hz.1)?
        }
        NoiseMethod::LocalPolynomial(settings) => {
            let mut estimate = local_polynomial(input, output, sample_s, &settings, band_hz)?;
            // Single lines have no coherence, so the coherence of averaged segments is used.
            let segment = (input.len() / COHERENCE_SEGMENTS).max(2);
            let segments = cross_spectra(input, output, sample_s, &WelchSettings::hann(segment))?;
            let coherence = segments.coherence();
            let nearest = |f: &f64| {
                coherence[((f * segment as f64 * sample_s).round() as usize).min(coherence.len() - 1)]
            };
            estimate.coherence = Some(estimate.frequencies_hz.iter().map(nearest).collect());
            estimate
        }
    })
}

/// Rounding of a long simulation as standard deviations of a response: a share of itself, and of the largest
/// value.
const ROUNDING: (f64, f64) = (1e-12, 1e-14);

/// A simulation without noise is exact to machine precision, which its confidence bands must include.
fn add_rounding(estimate: &mut ResponseEstimate) {
    let largest = estimate.response.iter().map(|g| g.norm()).fold(0.0, f64::max);
    for (variance, g) in estimate.variance.iter_mut().zip(&estimate.response) {
        *variance += (ROUNDING.0 * g.norm() + ROUNDING.1 * largest).powi(2);
    }
}

impl FrfExperiment {
    /// Excites the machine with root mean square `rms` (amplitude of a sine: `sqrt(2) rms`) between two
    /// frequencies and estimates the response.
    ///
    /// # Errors
    /// The mistakes of the machine; [`AnalysisError::RunEnded`] if the motion diverges;
    /// [`AnalysisError::Lti`] for a record that is too short.
    pub fn measure(
        &self,
        excitation: &Excitation,
        rms: f64,
        (low_hz, high_hz): (f64, f64),
    ) -> Result<MeasuredResponse, AnalysisError> {
        let (mut distortion_variance, mut noise_variance, mut evidence) = (None, None, None);
        let mut estimate = match *excitation {
            Excitation::WhiteNoise { duration_s, method } => {
                let spec = ReferenceSpec::WhiteNoise {
                    low_hz: 0.0,
                    high_hz: high_hz.min(0.499 / self.hold_s),
                    rms,
                    offset: self.offset,
                };
                let (u, y) = self.record(spec, self.seed, duration_s)?;
                response_from_noise(&u, &y, self.hold_s, method, (low_hz, high_hz))?
            }
            Excitation::Multisine { period_s, periods, transient_periods, realisations } => {
                let samples_per_period = (period_s / self.hold_s).round() as usize;
                let spec = ReferenceSpec::Multisine {
                    lines: Lines::All,
                    low_hz,
                    high_hz,
                    period_s,
                    rms,
                    offset: self.offset,
                };
                let duration_s = (transient_periods + periods) as f64 * period_s;
                let records = (0..realisations.max(1))
                    .map(|i| self.record(spec.clone(), self.seed + i as u64, duration_s))
                    .collect::<Result<Vec<_>, _>>()?;
                let periodic: Vec<Realisation<'_>> = records
                    .iter()
                    .map(|(input, output)| Realisation {
                        input,
                        output,
                        period_s: self.hold_s,
                        samples_per_period,
                        transient_periods,
                    })
                    .collect();
                let lines: Vec<usize> =
                    ((low_hz * period_s).ceil() as usize..=(high_hz * period_s).floor() as usize).collect();
                if let [only] = periodic.as_slice() {
                    periodic_response(only, &lines)?
                } else {
                    let best = best_linear_approximation(&periodic, &lines)?;
                    (distortion_variance, noise_variance) =
                        (Some(best.distortion_variance), Some(best.noise_variance));
                    evidence = Some(best.evidence);
                    best.estimate
                }
            }
            Excitation::Chirp { sweep_s, rest_s, half_width } => {
                let amplitude = rms * 2.0_f64.sqrt();
                // The sweep extends beyond the band, so its spectrum is flat within the band.
                let end_hz = (1.1 * high_hz).min(0.499 / self.hold_s);
                let (start_hz, duration_s, offset) = (0.5 * low_hz, sweep_s, self.offset);
                let spec = ReferenceSpec::Chirp {
                    sweep: ChirpSweep::Linear,
                    amplitude,
                    start_hz,
                    end_hz,
                    duration_s,
                    offset,
                };
                let (u, y) = self.record(spec, self.seed, sweep_s + rest_s)?;
                smoothed_spectra(&u, &y, self.hold_s, half_width)?.response(Estimator::H1, low_hz, high_hz)?
            }
            Excitation::SteppedSine { points, settle_s, measure_s } => {
                self.stepped_sines(points, rms, [settle_s, measure_s], (low_hz, high_hz))?
            }
        };
        add_rounding(&mut estimate);
        let linear = self.linear_response(&estimate.frequencies_hz)?;
        Ok(MeasuredResponse { estimate, linear, distortion_variance, noise_variance, evidence })
    }

    /// The view for linearisation: at rest under the mean of the command. A velocity source rests only at
    /// zero.
    pub fn view(&self) -> View {
        let drive = self.machine.actuators.get_full(&self.actuator);
        let held = drive.filter(|(_, _, actuator)| {
            self.offset != 0.0
                && matches!(actuator.kind, ActuatorKind::Force { .. } | ActuatorKind::PositionServo(_))
        });
        View { held: held.map(|(drive, ..)| HeldCommand { drive, command: self.offset }), ..View::default() }
    }

    /// The machine's linear response from held command to sampled output at these frequencies, about its rest
    /// under the mean of the command.
    ///
    /// # Errors
    /// The mistakes of the machine; [`AnalysisError::NoEquilibrium`]; [`AnalysisError::NotLinear`].
    pub fn linear_response(&self, frequencies_hz: &[f64]) -> Result<Vec<C64>, AnalysisError> {
        let point = |f: &f64| C64::cis(TAU * f * self.hold_s);
        let drive = self.machine.actuators.get_index_of(&self.actuator);
        let kind = self.machine.actuators.get(&self.actuator).map(|actuator| &actuator.kind);
        if let (Some(drive), Some(ActuatorKind::Imposed)) = (drive, kind) {
            let plant = LinearMachine::new(&self.machine, &self.view())?;
            let output = plant.output(plant.source(&self.output)?)?;
            if let Some(imposed) = ImposedResponse::new(&plant, drive, &output, self.hold_s) {
                let imposed = imposed?;
                return frequencies_hz.iter().map(|f| imposed.at(point(f))).collect();
            }
        }
        let scenario = self.scenario(ReferenceSpec::Constant(self.offset), self.seed, self.hold_s);
        let whole = ControlLoop::with_targets(&scenario, &self.loop_view()?)?;
        let output = whole.plant().output(whole.plant().source(&self.output)?)?;
        let sampled = whole.response_to(0, output)?.evaluator();
        frequencies_hz.iter().map(|f| sampled.at(point(f))).collect()
    }

    /// The view for the sampled loop. A sampled servo holds the machine by its force, which follows from the
    /// rest of the continuous one.
    fn loop_view(&self) -> Result<View, AnalysisError> {
        let mut view = self.view();
        let held = view.held.as_mut();
        let kind = self.machine.actuators.get(&self.actuator).map(|actuator| &actuator.kind);
        if let (Some(held), Some(ActuatorKind::PositionServo(servo))) = (held, kind)
            && servo.period_s.is_some()
        {
            let rest = LinearMachine::new(&self.machine, &self.view())?;
            held.command = dot(&rest.equations().drive_force[held.drive], &rest.operating_point().xi);
        }
        Ok(view)
    }

    /// Command and output, one sample per hold.
    ///
    /// # Errors
    /// The mistakes of the machine; [`AnalysisError::RunEnded`].
    pub fn record(
        &self,
        command: ReferenceSpec,
        seed: u64,
        duration_s: f64,
    ) -> Result<(Vec<f64>, Vec<f64>), AnalysisError> {
        let program = Program::new(&self.scenario(command, seed, duration_s))?;
        let mut trace = Trace::new(program.record_names());
        let mut simulation = Simulation::<f64>::new(vec![program])?;
        simulation.run(&mut trace)?;
        let samples = (duration_s / self.hold_s).round() as usize;
        match simulation.end(0) {
            Some(RunEnd::Completed) if trace.t_s.len() >= samples => {}
            _ => return Err(AnalysisError::RunEnded { t_s: simulation.time_s() }),
        }
        let column = |i: usize| trace.columns[i][..samples].to_vec();
        Ok((column(0), column(1)))
    }

    fn scenario(&self, command: ReferenceSpec, seed: u64, duration_s: f64) -> Scenario {
        let spec = ControllerSpec { reference: command, ..ControllerSpec::new(Law::OpenLoop, self.hold_s) };
        let control = ControllerUse {
            spec,
            reads: None,
            motion: None,
            drives: self.actuator.clone(),
            effects: Vec::new(),
        };
        let record = vec![SignalName::new(&self.actuator, Quantity::Command), self.output.clone()];
        let run = RunSettings {
            duration_s,
            record,
            record_rate_hz: Some(1.0 / self.hold_s),
            seed,
            ..RunSettings::default()
        };
        Scenario {
            machine: self.machine.clone(),
            controllers: [("excitation".to_string(), control)].into_iter().collect(),
            run,
        }
    }

    fn stepped_sines(
        &self,
        points: usize,
        rms: f64,
        [settle_s, measure_s]: [f64; 2],
        (low_hz, high_hz): (f64, f64),
    ) -> Result<ResponseEstimate, AnalysisError> {
        let step = (high_hz / low_hz).powf(1.0 / (points.max(2) - 1) as f64);
        let frequencies: Vec<f64> = (0..points).map(|i| low_hz * step.powf(i as f64)).collect();
        let records = frequencies
            .iter()
            .map(|&f| self.sine(f, rms, settle_s, measure_s))
            .collect::<Result<Vec<_>, _>>()?;
        let points = frequencies.iter().zip(&records);
        let points: Vec<_> = points
            .map(|(&frequency_hz, (input, output))| SteppedSinePoint { frequency_hz, input, output })
            .collect();
        Ok(stepped_sine(&points, self.hold_s)?)
    }

    fn sine(
        &self,
        frequency_hz: f64,
        rms: f64,
        settle_s: f64,
        measure_s: f64,
    ) -> Result<(Vec<f64>, Vec<f64>), AnalysisError> {
        let samples = ((settle_s + measure_s) / self.hold_s).round() as usize;
        let times_s: Vec<f64> = (0..samples).map(|k| k as f64 * self.hold_s).collect();
        let values = times_s.iter().map(|t| rms * 2.0_f64.sqrt() * (TAU * frequency_hz * t).sin()).collect();
        let between = feeler_control::reference::Between::Hold;
        let spec = ReferenceSpec::Table { times_s, values, between, offset: self.offset };
        let (u, y) = self.record(spec, self.seed, samples as f64 * self.hold_s)?;
        let first = (settle_s / self.hold_s).round() as usize;
        Ok((u[first..].to_vec(), y[first..].to_vec()))
    }
}
