//! A machine with the landmarks that the paper measured on the MIT Precision Assembly Robot (Figs. 15 to 17), as far as they determine one.
//!
//! The paper publishes landmarks of three measured responses and no parameters. The chain here is a stand-in that shows the same landmarks; its
//! masses, springs and dampers are **not** those of the robot, and many other machines would fit as well. [`fit`] says in which directions of
//! parameter space the landmarks leave it free.

use std::f64::consts::TAU;

use feeler_analysis::frf::{Excitation, Experiment, NoiseMethod};
use feeler_analysis::{LinearMachine, View, modes};
use feeler_lti::C64;
use feeler_lti::spectral::LocalPolynomialSettings;
use feeler_plant::description::{Actuator, ActuatorKind, Body, Contact, ContactLaw, Engagement, GROUND, Machine, Quantity, SignalName};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use crate::error::ValidationError;
use crate::paper::spring;
use crate::table::Row;

/// Bodies after the motor.
const LINKS: usize = 4;
/// Band in which landmarks are looked for, Hz.
const BAND_HZ: (f64, f64) = (2.0, 90.0);
/// Asked of every landmark, Hz.
const LANDMARK_HZ: f64 = 1.0;
/// Resonances that the paper names, Hz.
const RESONANCES_HZ: [f64; 5] = [12.0, 38.0, 44.0, 67.0, 77.0];
/// Singular values below this share of the largest belong to directions that the landmarks do not tell.
const UNDETERMINED: f64 = 1e-3;

/// A serial chain: base on its mount, motor guided on the base, four more masses, a velocity source; clamped by its sensor to the base.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Chain {
    /// Mass of the base, kg.
    pub base_kg: f64,
    /// Frequency of the base with the rest on it, Hz, and its damping ratio.
    pub mount: [f64; 2],
    /// Mass of the motor, kg.
    pub motor_kg: f64,
    /// Damping of the guide, N s/m.
    pub guide_n_s_per_m: f64,
    /// Masses after the motor, kg.
    pub masses_kg: [f64; LINKS],
    /// Springs before each of them, N/m.
    pub stiffness_n_per_m: [f64; LINKS],
    /// Dampers beside the springs, N s/m.
    pub damping_n_s_per_m: [f64; LINKS],
    /// Damping (N s/m) and time constant (s) of the velocity source.
    pub source: [f64; 2],
    /// Stiffness (N/m) and damping (N s/m) of the sensor.
    pub sensor: [f64; 2],
}

/// How many numbers a chain has.
const PARAMETERS: usize = 2 + 1 + 1 + 1 + 3 * LINKS + 2 + 2;

impl Chain {
    /// What [`fit`] makes of [`Self::START`], to six digits.
    pub const FITTED: Self = Self {
        base_kg: 159.468,
        mount: [10.6963, 0.109_197],
        motor_kg: 84.7368,
        guide_n_s_per_m: 61.2371,
        masses_kg: [13.1877, 4.78503, 0.499_345, 0.110_906],
        stiffness_n_per_m: [1.32854e6, 565_366.0, 80_840.5, 8715.03],
        damping_n_s_per_m: [22.1445, 16.7749, 17.6357, 11.8577],
        source: [4441.58, 1.240_06e-3],
        sensor: [253_468.0, 74.11],
    };

    /// Where a fit starts.
    pub const START: Self = Self {
        base_kg: 315.0,
        mount: [12.0, 0.03],
        motor_kg: 7.5,
        guide_n_s_per_m: 60.0,
        masses_kg: [3.3, 3.36, 0.735, 0.705],
        stiffness_n_per_m: [2.18e5, 5.99e5, 7.55e4, 3.69e5],
        damping_n_s_per_m: [26.5, 22.5, 26.8, 13.0],
        source: [343.0, 2.07e-3],
        sensor: [1.49e5, 120.0],
    };

    fn to_logs(self) -> DVector<f64> {
        let head = [self.base_kg, self.mount[0], self.mount[1], self.motor_kg, self.guide_n_s_per_m];
        let lists = self.masses_kg.into_iter().chain(self.stiffness_n_per_m).chain(self.damping_n_s_per_m);
        let all = head.into_iter().chain(lists).chain(self.source).chain(self.sensor);
        DVector::from_iterator(PARAMETERS, all.map(f64::ln))
    }

    fn from_logs(logs: &DVector<f64>) -> Self {
        let p: Vec<f64> = logs.iter().map(|l| l.exp()).collect();
        let list = |first: usize| std::array::from_fn(|i| p[first + i]);
        Self {
            base_kg: p[0],
            mount: [p[1], p[2]],
            motor_kg: p[3],
            guide_n_s_per_m: p[4],
            masses_kg: list(5),
            stiffness_n_per_m: list(5 + LINKS),
            damping_n_s_per_m: list(5 + 2 * LINKS),
            source: [p[5 + 3 * LINKS], p[6 + 3 * LINKS]],
            sensor: [p[7 + 3 * LINKS], p[8 + 3 * LINKS]],
        }
    }

    /// Names of the parameters, in the order of [`Fit::undetermined`].
    pub fn parameter_names() -> Vec<String> {
        let of = |what: &str| (1..=LINKS).map(move |i| format!("{what} {i}")).collect::<Vec<_>>();
        let head = ["base mass", "mount frequency", "mount damping ratio", "motor mass", "guide damping"].map(String::from);
        let tail = ["source damping", "source time constant", "sensor stiffness", "sensor damping"].map(String::from);
        head.into_iter().chain(of("mass")).chain(of("stiffness")).chain(of("damping")).chain(tail).collect()
    }

    /// The machine: `base`, `motor`, `link1` to `link4`, the last of which is the end-point; contact `tool`.
    pub fn machine(&self, engagement: Engagement) -> Machine {
        let mut machine = Machine { name: "landmarks".into(), ..Machine::default() };
        let body = |mass_kg| Body { mass_kg, ..Body::default() };
        machine.bodies.insert("base".into(), body(self.base_kg));
        machine.bodies.insert("motor".into(), body(self.motor_kg));
        let on_mount = self.base_kg + self.motor_kg + self.masses_kg.iter().sum::<f64>();
        let w = TAU * self.mount[0];
        machine.springs.insert("mount".into(), spring(GROUND, "base", on_mount * w * w, 2.0 * self.mount[1] * on_mount * w));
        machine.springs.insert("guide".into(), spring("base", "motor", 0.0, self.guide_n_s_per_m));
        let mut before = "motor".to_string();
        for i in 0..LINKS {
            let name = format!("link{}", i + 1);
            machine.bodies.insert(name.clone(), body(self.masses_kg[i]));
            let joint = spring(&before, &name, self.stiffness_n_per_m[i], self.damping_n_s_per_m[i]);
            machine.springs.insert(format!("joint{}", i + 1), joint);
            before = name;
        }
        let contact = Contact {
            between: [before, "base".into()],
            engagement,
            law: ContactLaw::KelvinVoigt,
            stiffness: self.sensor[0],
            damping_n_s_per_m: self.sensor[1],
            gap_m: 0.0,
            effects: Vec::new(),
        };
        machine.contacts.insert("tool".into(), contact);
        let kind = ActuatorKind::VelocitySource { damping_n_s_per_m: self.source[0], time_constant_s: self.source[1] };
        let drive =
            Actuator { on: "motor".into(), reacts_on: "base".into(), kind, limit_n: None, rate_limit_per_s: None, effects: Vec::new() };
        machine.actuators.insert("drive".into(), drive);
        machine
    }
}

/// The paper's landmarks as they stand on a machine, Hz; not a number where a crossing is absent.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Landmarks {
    /// Frequencies of the modes nearest to the five resonances, each mode counted once.
    pub resonances_hz: [f64; 5],
    /// Acceleration of the motor: phase falls below 0 degrees for good. (In the fitted chain it grazes 0 at the base mode as well, by some degrees:
    /// a base that turns the end-point's phase turns the motor's too.)
    pub motor_hz: f64,
    /// Acceleration of the end-point: phase dips below 0 degrees, and returns.
    pub end_dip_hz: [f64; 2],
    /// And falls below 0 for good.
    pub end_hz: f64,
    /// Contact force, clamped: phase falls through -180 degrees.
    pub force_hz: f64,
}

/// What the paper reports.
pub const PAPER: Landmarks =
    Landmarks { resonances_hz: RESONANCES_HZ, motor_hz: 50.0, end_dip_hz: [11.0, 13.0], end_hz: 28.0, force_hz: 37.0 };

impl Landmarks {
    /// From the phases (frequencies in Hz, degrees) of motor acceleration, end-point acceleration and clamped force.
    fn from_phases(resonances_hz: [f64; 5], [motor, end, force]: [&(Vec<f64>, Vec<f64>); 3]) -> Self {
        let first = |found: &[f64]| found.first().copied().unwrap_or(f64::NAN);
        let (down, up) = crossings(&end.0, &end.1, 0.0);
        let end_dip_hz = [first(&down), first(&up)];
        Self {
            resonances_hz,
            motor_hz: crossings(&motor.0, &motor.1, 0.0).0.last().copied().unwrap_or(f64::NAN),
            end_dip_hz,
            end_hz: down.into_iter().find(|f| *f > end_dip_hz[1]).unwrap_or(f64::NAN),
            force_hz: first(&crossings(&force.0, &force.1, -180.0).0),
        }
    }

    /// Name, found and reported value of each.
    pub fn against_paper(&self) -> Vec<(String, f64, f64)> {
        let mut all: Vec<(String, f64, f64)> = (self.resonances_hz.iter().zip(PAPER.resonances_hz))
            .map(|(got, expected)| (format!("resonance at {expected} Hz"), *got, expected))
            .collect();
        all.push(("motor acceleration below 0 degrees".into(), self.motor_hz, PAPER.motor_hz));
        all.push(("end-point acceleration dips below 0 degrees".into(), self.end_dip_hz[0], PAPER.end_dip_hz[0]));
        all.push(("end-point acceleration returns above".into(), self.end_dip_hz[1], PAPER.end_dip_hz[1]));
        all.push(("end-point acceleration below 0 for good".into(), self.end_hz, PAPER.end_hz));
        all.push(("clamped force through -180 degrees".into(), self.force_hz, PAPER.force_hz));
        all
    }
}

/// Phase (degrees) of a response on a fine grid, continued from its first value in (-180, 180].
fn phase_deg(plant: &LinearMachine, output: &SignalName) -> Result<(Vec<f64>, Vec<f64>), ValidationError> {
    let points = 880;
    let frequencies: Vec<f64> = (0..=points).map(|i| BAND_HZ.0 + (BAND_HZ.1 - BAND_HZ.0) * f64::from(i) / f64::from(points)).collect();
    let channel = plant.channel(&SignalName::new("drive", Quantity::Command), output)?;
    let response: Vec<C64> = channel.frequency_response(&frequencies)?;
    let phase = feeler_lti::unwrapped_phase_rad(&response).into_iter().map(f64::to_degrees).collect();
    Ok((frequencies, phase))
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

/// The landmarks of a chain, by linear theory.
///
/// # Errors
/// [`ValidationError::Analysis`].
pub fn landmarks(chain: &Chain) -> Result<Landmarks, ValidationError> {
    let free = LinearMachine::new(&chain.machine(Engagement::Free), &View::default())?;
    let clamped = LinearMachine::new(&chain.machine(Engagement::Clamped), &View::default())?;
    let own: Vec<f64> = modes(&free)?.iter().map(|mode| mode.eigenvalue.im / TAU).collect();
    let mut resonances_hz = [f64::NAN; 5];
    for (slot, f) in resonances_hz.iter_mut().zip(own) {
        *slot = f;
    }
    let motor = phase_deg(&free, &SignalName::new("motor", Quantity::Acceleration))?;
    let end = phase_deg(&free, &SignalName::new("link4", Quantity::Acceleration))?;
    let force = phase_deg(&clamped, &SignalName::new("tool", Quantity::SpringForce))?;
    Ok(Landmarks::from_phases(resonances_hz, [&motor, &end, &force]))
}

/// The crossings of phase as a white-noise experiment on the simulated machine shows them; resonances stay those of the modes.
///
/// # Errors
/// [`ValidationError::Analysis`].
pub fn simulated_landmarks(chain: &Chain, duration_s: f64) -> Result<Landmarks, ValidationError> {
    let measured = |engagement, element: &str, quantity| -> Result<(Vec<f64>, Vec<f64>), ValidationError> {
        // Commands are held so briefly that the hold turns 50 Hz by less than a degree: the paper's amplifier had none.
        let experiment = Experiment {
            machine: chain.machine(engagement),
            actuator: "drive".into(),
            output: SignalName::new(element, quantity),
            hold_s: 1e-4,
            offset: 0.0,
            seed: 5,
        };
        let method = NoiseMethod::LocalPolynomial(LocalPolynomialSettings::default());
        let noise = Excitation::WhiteNoise { duration_s, method };
        let estimate = experiment.measure(&noise, 1.0, (BAND_HZ.0, BAND_HZ.1))?.estimate;
        let phase = feeler_lti::unwrapped_phase_rad(&estimate.response).into_iter().map(f64::to_degrees).collect();
        Ok((estimate.frequencies_hz, phase))
    };
    let motor = measured(Engagement::Free, "motor", Quantity::Acceleration)?;
    let end = measured(Engagement::Free, "link4", Quantity::Acceleration)?;
    let force = measured(Engagement::Clamped, "tool", Quantity::SpringForce)?;
    Ok(Landmarks::from_phases(landmarks(chain)?.resonances_hz, [&motor, &end, &force]))
}

/// Rows for the fourth claim, the crossings measured by simulated white-noise experiments.
///
/// # Errors
/// [`ValidationError::Analysis`].
pub fn simulated_rows(chain: &Chain) -> Result<Vec<Row>, ValidationError> {
    let claim = "claim 4: landmarks of the measured machine, by simulated white-noise experiments";
    let found = simulated_landmarks(chain, 120.0)?;
    Ok(found.against_paper().into_iter().map(|(name, got, expected)| Row::close(name, claim, got, expected, LANDMARK_HZ)).collect())
}

/// Rows for the fourth claim, by linear theory.
///
/// # Errors
/// [`ValidationError::Analysis`].
pub fn rows(chain: &Chain) -> Result<Vec<Row>, ValidationError> {
    let claim = "claim 4: landmarks of the measured machine (Figs. 15 to 17)";
    let found = landmarks(chain)?;
    Ok(found.against_paper().into_iter().map(|(name, got, expected)| Row::close(name, claim, got, expected, LANDMARK_HZ)).collect())
}

/// Result of a fit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fit {
    /// The chain.
    pub chain: Chain,
    /// Its landmarks.
    pub landmarks: Landmarks,
    /// Root mean square of the residuals: 1 is half the tolerance of the landmarks.
    pub rms: f64,
    /// Singular values of the scaled Jacobian, falling: how much the landmarks tell of each direction of the (logarithmic) parameters.
    pub singular_values: Vec<f64>,
    /// Per parameter, the share of it (0 to 1) that lies in directions which the landmarks do not tell.
    pub undetermined: Vec<(String, f64)>,
}

/// Residuals: logarithms of the resonances over 1 %, phases at the landmarks over 3 degrees, and logarithms of the parameters over a factor of ten
/// from where the fit began, so that what the landmarks do not tell stays where it was.
fn residuals(logs: &DVector<f64>, start: &DVector<f64>) -> Result<DVector<f64>, ValidationError> {
    let chain = Chain::from_logs(logs);
    let free = LinearMachine::new(&chain.machine(Engagement::Free), &View::default())?;
    let clamped = LinearMachine::new(&chain.machine(Engagement::Clamped), &View::default())?;
    let own: Vec<f64> = modes(&free)?.iter().map(|mode| mode.eigenvalue.im / TAU).collect();
    let mut all: Vec<f64> = RESONANCES_HZ.iter().enumerate().map(|(i, f)| (own.get(i).unwrap_or(&1e3) / f).ln() / 0.01).collect();
    let mut phase = |plant: &LinearMachine, signal: SignalName, at_hz: &[(f64, f64)]| -> Result<(), ValidationError> {
        let channel = plant.channel(&SignalName::new("drive", Quantity::Command), &signal)?;
        let frequencies: Vec<f64> = at_hz.iter().map(|(f, _)| *f).collect();
        for (g, (_, wanted_deg)) in channel.frequency_response(&frequencies)?.iter().zip(at_hz) {
            all.push((g * C64::from_polar(1.0, -wanted_deg.to_radians())).arg().to_degrees() / 3.0);
        }
        Ok(())
    };
    phase(&free, SignalName::new("motor", Quantity::Acceleration), &[(50.0, 0.0)])?;
    phase(&free, SignalName::new("link4", Quantity::Acceleration), &[(11.0, 0.0), (13.0, 0.0), (28.0, 0.0)])?;
    phase(&clamped, SignalName::new("tool", Quantity::SpringForce), &[(37.0, 180.0)])?;
    all.extend(logs.iter().zip(start).map(|(l, s)| 0.03 * (l - s)));
    Ok(DVector::from_vec(all))
}

/// Levenberg and Marquardt's method on the logarithms of the parameters, with difference quotients for the Jacobian.
///
/// # Errors
/// [`ValidationError::Analysis`].
pub fn fit(start: &Chain, iterations: usize) -> Result<Fit, ValidationError> {
    let origin = start.to_logs();
    let mut logs = origin.clone();
    let mut current = residuals(&logs, &origin)?;
    let mut damping = 1e-1;
    for _ in 0..iterations {
        let jacobian = jacobian(&logs, &origin, &current)?;
        let normal = jacobian.transpose() * &jacobian;
        let gradient = jacobian.transpose() * &current;
        let mut improved = false;
        while damping < 1e8 {
            let mut damped = normal.clone();
            for i in 0..PARAMETERS {
                damped[(i, i)] += damping * (normal[(i, i)] + 1e-6);
            }
            let Some(step) = damped.cholesky().map(|c| c.solve(&gradient)) else { break };
            // No parameter moves by more than a fifth at once.
            let step = &step * (0.2 / step.amax()).min(1.0);
            let trial = &logs - step;
            let there = residuals(&trial, &origin)?;
            if there.norm() < current.norm() {
                improved = (current.norm() - there.norm()) > 1e-7 * current.norm();
                (logs, current) = (trial, there);
                damping = (damping * 0.3).max(1e-9);
                break;
            }
            damping *= 4.0;
        }
        if !improved {
            break;
        }
    }
    let chain = Chain::from_logs(&logs);
    let told = current.len() - PARAMETERS;
    let whole = jacobian(&logs, &origin, &current)?;
    let decomposition = whole.rows(0, told).into_owned().svd(false, true);
    let singular_values: Vec<f64> = decomposition.singular_values.iter().copied().collect();
    let largest = singular_values.iter().copied().fold(0.0, f64::max);
    let directions = decomposition.v_t.unwrap_or_else(|| DMatrix::zeros(told, PARAMETERS));
    let seen = |j: usize| -> f64 {
        let kept = (0..singular_values.len()).filter(|&i| singular_values[i] > UNDETERMINED * largest);
        kept.map(|i| directions[(i, j)] * directions[(i, j)]).sum()
    };
    let undetermined = Chain::parameter_names().into_iter().enumerate().map(|(j, name)| (name, (1.0 - seen(j)).max(0.0))).collect();
    let rms = current.rows(0, told).norm() / (told as f64).sqrt();
    Ok(Fit { chain, landmarks: landmarks(&chain)?, rms, singular_values, undetermined })
}

fn jacobian(logs: &DVector<f64>, origin: &DVector<f64>, current: &DVector<f64>) -> Result<DMatrix<f64>, ValidationError> {
    const STEP: f64 = 1e-5;
    let mut jacobian = DMatrix::zeros(current.len(), PARAMETERS);
    for j in 0..PARAMETERS {
        let mut moved = logs.clone();
        moved[j] += STEP;
        jacobian.set_column(j, &((residuals(&moved, origin)? - current) / STEP));
    }
    Ok(jacobian)
}
