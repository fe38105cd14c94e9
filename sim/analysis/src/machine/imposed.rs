//! An imposed motion as the input of a linear machine.
//!
//! The states of the imposed coordinate are given: position, speed, acceleration and its rate. The machine is
//! linear in them: `x' = A x + sum B_k u_k`, `y = C x + sum D_k u_k`, where `u_k` is derivative `k` of the
//! position.

use feeler_lti::{C64, DiscreteStateSpace, StateSpace, TransferEvaluator, expm_integrals};
use feeler_plant::motion::GAP_TIME_S;
use nalgebra::DMatrix;

use crate::error::AnalysisError;
use crate::machine::channel::{ResponseChannel, reduce};
use crate::machine::linearise::{LinearMachine, OutputRow};

const GIVEN: usize = 4;
/// Factors from a derivative of the position to its state. Two of them have the scale of a moving gap's
/// states.
const SCALES: [f64; GIVEN] = [1.0, 1.0, GAP_TIME_S, GAP_TIME_S * GAP_TIME_S];

/// The states of a machine whose body `drive` moves: those that are given, and all others.
struct Parts {
    given: Vec<usize>,
    free: Vec<usize>,
}

impl Parts {
    fn new(plant: &LinearMachine, drive: usize) -> Option<Self> {
        let (motion, layout) = (plant.motion(), plant.motion().layout());
        let first = layout.imposed(drive)?;
        let g = motion.coordinates().of(motion.assembly().drives[drive].on)?;
        let given = vec![layout.q(g), layout.v(g), first, first + 1];
        let free = (0..layout.states()).filter(|i| !given.contains(i)).collect();
        Some(Self { given, free })
    }
}

/// From an imposed position to an output; `None` if the drive imposes no motion. A change of the states
/// removes the derivatives of the position.
pub(crate) fn channel(
    plant: &LinearMachine,
    drive: usize,
    output: &OutputRow,
) -> Option<Result<ResponseChannel, AnalysisError>> {
    let parts = Parts::new(plant, drive)?;
    let part = &plant.motion().assembly().drives[drive];
    let a = plant.a().select_rows(&parts.free).select_columns(&parts.free);
    let mut b = plant.a().select_rows(&parts.free).select_columns(&parts.given);
    let c = DMatrix::from_fn(1, parts.free.len(), |_, j| output.c[parts.free[j]]);
    let mut d = DMatrix::from_fn(1, GIVEN, |_, k| output.c[parts.given[k]]);
    for (k, scale) in SCALES.into_iter().enumerate() {
        b.column_mut(k).scale_mut(scale * part.gain);
        d[k] *= scale * part.gain;
    }
    for k in (1..GIVEN).rev() {
        // With w = x - B_k u_(k-1) the derivative k is gone.
        let moved = b.column(k).into_owned();
        let (into_state, into_output) = (&a * &moved, (&c * &moved)[0]);
        b.column_mut(k - 1).axpy(1.0, &into_state, 1.0);
        d[k - 1] += into_output;
    }
    if d.iter().skip(1).any(|d| *d != 0.0) {
        return Some(Err(AnalysisError::ImposedOutput { name: part.name.clone() }));
    }
    // Positions and speeds of the other coordinates come first.
    let coordinates = plant.motion().layout().coordinates() - 1;
    let reduced = reduce(&a, &b.columns(0, 1).into_owned(), &c, coordinates);
    let names = plant.motion().state_names();
    let of_free: Vec<String> = parts.free.iter().map(|&i| names[i].clone()).collect();
    let states = reduced.names(&of_free);
    let delay_s = output.delay_s + part.delay;
    let system = StateSpace::new(reduced.a, reduced.b, reduced.c, d.columns(0, 1).into_owned());
    Some(system.map(|system| ResponseChannel { system, states, delay_s }).map_err(AnalysisError::from))
}

/// The response to an imposed motion that is sampled and a cubic between its samples, as the engine moves it.
pub(crate) struct ImposedResponse {
    /// From the given states at a sample to the output, without whole samples of delay.
    system: TransferEvaluator,
    samples: i32,
    hold_s: f64,
    gain: f64,
}

impl ImposedResponse {
    /// From samples every `hold_s` to the output at the same instants; `None` if the drive imposes no motion.
    pub(crate) fn new(
        plant: &LinearMachine,
        drive: usize,
        output: &OutputRow,
        hold_s: f64,
    ) -> Option<Result<Self, AnalysisError>> {
        let parts = Parts::new(plant, drive)?;
        let part = &plant.motion().assembly().drives[drive];
        let late_s = output.delay_s + part.delay;
        // At an instant of the output, the last sample that has arrived lies this many holds back.
        let samples = (late_s / hold_s * (1.0 - f64::EPSILON)).ceil();
        let system = || -> Result<DiscreteStateSpace, AnalysisError> {
            let nothing = DMatrix::zeros(plant.a().nrows(), 1);
            let over = |span_s: f64| expm_integrals(plant.a(), &nothing, span_s.max(0.0));
            let step = over(hold_s)?.transition.select_rows(&parts.free);
            let row = &output.c * over(samples * hold_s - late_s)?.transition;
            let of = |states: &[usize]| DMatrix::from_fn(1, states.len(), |_, j| row[states[j]]);
            let (free, given) = (step.select_columns(&parts.free), step.select_columns(&parts.given));
            Ok(StateSpace::discrete(free, given, of(&parts.free), of(&parts.given), hold_s)?)
        };
        Some(system().map(|system| Self {
            system: TransferEvaluator::new(&system),
            samples: samples as i32,
            hold_s,
            gain: part.gain,
        }))
    }

    /// The value at a point of the z plane.
    pub(crate) fn at(&self, z: C64) -> Result<C64, AnalysisError> {
        let t = self.hold_s;
        // The rate at a sample is that from the sample before it to the one after.
        let rate = (z - z.inv()) / (2.0 * t);
        let next = rate * z;
        let acceleration = (z - 1.0) * (6.0 / (t * t)) - (rate * 4.0 + next * 2.0) / t;
        let jerk = (z - 1.0) * (-12.0 / (t * t * t)) + (rate + next) * (6.0 / (t * t));
        let given = [C64::new(1.0, 0.0), rate, acceleration, jerk];
        let response = self.system.at(z)?;
        let sum: C64 = (0..GIVEN).map(|k| response[(0, k)] * given[k] * SCALES[k]).sum();
        Ok(sum * self.gain * z.powi(-self.samples))
    }
}
