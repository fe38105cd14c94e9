//! The exact sampled loop: the plant under every hold, fractional delays of controllers, drives and sensors,
//! filters, and several rates.
//!
//! Everything is linear in the vector known when a common period begins. It has the plant's state, held
//! outputs, outputs in transit, early readings, and the controllers' states. The code steps through one
//! period, instant by instant, with each quantity as a row over that vector (lifting). The rows at the end
//! are the matrix of the loop.

use std::collections::VecDeque;

use feeler_control::{ControllerSpec, LinearLaw};
use feeler_lti::{C64, Discrete, DiscreteStateSpace, StateSpace, eigenvalues};
use nalgebra::{DMatrix, RowDVector};

use crate::error::AnalysisError;
use crate::loops::control_loop::{ControlLoop, LoopController, LoopPlant, Probe};
use crate::loops::schedule::{Action, Schedule, Timing};
use crate::loops::spans::{self, Span};
use crate::machine::linearise::OutputRow;

/// Spans whose lengths differ by less than this, in s, use one exponential. It is the engine's time grid.
const SAME_SPAN_S: f64 = 1e-15;
/// Largest number of outputs and readings in transit if eigenvalues are needed. Each is a state. An analysis
/// takes about ten seconds with a hundred of them, and eight times as long with twice as many.
const MOST_STORED: usize = 100;

/// The sampled loop of a [`ControlLoop`].
#[derive(Clone, Debug)]
pub struct SampledLoop<'a> {
    whole: &'a ControlLoop,
    plant: LoopPlant,
    schedule: Schedule,
    /// Transition and input matrix of the plant over each span that differs.
    spans: Vec<Span>,
    /// Per instant, the index of the span that leads to the next instant.
    steps: Vec<usize>,
    /// Index of the span from the start of the period to the first instant.
    lead_in: usize,
}

/// All quantities as rows over the lifted vector.
struct Walk {
    width: usize,
    /// Plant states, one row each.
    x: DMatrix<f64>,
    held: Vec<RowDVector<f64>>,
    pending: Vec<VecDeque<RowDVector<f64>>>,
    taken: Vec<[VecDeque<RowDVector<f64>>; 2]>,
    states: Vec<Vec<RowDVector<f64>>>,
}

impl<'a> SampledLoop<'a> {
    /// The sampled loop of a machine and its controllers.
    ///
    /// # Errors
    /// [`AnalysisError::Rates`] if the periods do not repeat together; [`AnalysisError::Lti`].
    pub fn new(whole: &'a ControlLoop) -> Result<Self, AnalysisError> {
        Self::build(whole, whole.loop_plant(None)?)
    }

    fn build(whole: &'a ControlLoop, plant: LoopPlant) -> Result<Self, AnalysisError> {
        let timings: Vec<Timing> = (whole.controllers().iter().enumerate())
            .map(|(i, c)| Timing {
                period_s: c.spec.period_s,
                offset_s: c.spec.offset_s,
                output_delay_s: whole.output_delay_s(c),
                sensor_delay_s: [&plant.reading[i], &plant.motion[i]]
                    .map(|row| row.as_ref().map(|row| row.delay_s)),
                is_servo: c.is_servo,
            })
            .collect();
        let schedule = Schedule::new(&timings)?;
        let mut lengths_s: Vec<f64> = Vec::new();
        let mut number = |span_s: f64| {
            let known = lengths_s.iter().position(|other| (other - span_s).abs() <= SAME_SPAN_S);
            known.unwrap_or_else(|| {
                lengths_s.push(span_s);
                lengths_s.len() - 1
            })
        };
        let ends = schedule.instants.iter().skip(1).map(|(t, _)| *t).chain([schedule.common_s]);
        let steps: Vec<usize> =
            schedule.instants.iter().zip(ends).map(|((t, _), end)| number(end - t.max(0.0))).collect();
        let lead_in = number(schedule.instants.first().map_or(0.0, |(t, _)| t.max(0.0)));
        let over = |span_s: &f64| spans::span(&plant.reduced.a, &plant.reduced.b, span_s.max(0.0));
        let spans = lengths_s.iter().map(over).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { whole, plant, schedule, spans, steps, lead_in })
    }

    /// The time after which all controllers repeat together, s.
    pub fn common_period_s(&self) -> f64 {
        self.schedule.common_s
    }

    /// The common period, if some controller samples more than once in it. Motions above half of its inverse
    /// then appear slower.
    pub(crate) fn alias_s(&self) -> Option<f64> {
        let common_s = self.schedule.common_s;
        let is_fast = |period_s: f64| period_s < 0.75 * common_s;
        self.whole.controllers().iter().any(|c| is_fast(c.spec.period_s)).then_some(common_s)
    }

    /// The loop's time domain: one step per common period.
    ///
    /// # Errors
    /// [`AnalysisError::Lti`].
    pub fn domain(&self) -> Result<Discrete, AnalysisError> {
        Ok(Discrete::new(self.schedule.common_s)?)
    }

    /// State matrix of the closed loop over one common period. The plant's states come first.
    ///
    /// # Errors
    /// [`AnalysisError::Control`].
    pub fn closed_loop(&self) -> Result<DMatrix<f64>, AnalysisError> {
        self.closed_with(&self.whole.specs())
    }

    /// State matrix of the closed loop with the gain of every drive multiplied by a factor.
    ///
    /// # Errors
    /// As [`Self::closed_loop`].
    pub(crate) fn closed_loop_driven(&self, factor: f64) -> Result<DMatrix<f64>, AnalysisError> {
        let mut driven = self.clone();
        for (_, step) in &mut driven.spans {
            *step *= factor;
        }
        for row in driven.plant.reading.iter_mut().chain(&mut driven.plant.motion).flatten() {
            row.d *= factor;
        }
        driven.closed_loop()
    }

    /// State matrix of the closed loop with one gain changed.
    ///
    /// # Errors
    /// [`AnalysisError::NoGain`], [`AnalysisError::Control`].
    pub fn closed_loop_with(
        &self,
        controller: usize,
        gain: &str,
        value: f64,
    ) -> Result<DMatrix<f64>, AnalysisError> {
        self.closed_with(&self.whole.specs_with(controller, gain, value)?)
    }

    /// Eigenvalues of the closed loop (z plane of the common period).
    ///
    /// # Errors
    /// [`AnalysisError::Lti`].
    pub fn eigenvalues(&self) -> Result<Vec<C64>, AnalysisError> {
        Ok(eigenvalues(&self.closed_loop()?)?)
    }

    /// Matrix from a state of the loop to positions and speeds of the machine.
    pub(crate) fn expand(&self) -> &DMatrix<f64> {
        &self.plant.reduced.expand
    }

    /// The loop broken at the output of one controller, with the others closed: from that output to the
    /// negated response of the controller.
    ///
    /// # Errors
    /// [`AnalysisError::SlowerThanLoop`] if other controllers repeat more slowly, so that the broken loop
    /// varies in time.
    pub fn open_loop(&self, controller: usize) -> Result<DiscreteStateSpace, AnalysisError> {
        self.broken(controller, Probe::Law)
    }

    /// From the held output of one controller to any signal, as that controller would sample it just before
    /// it acts; the other controllers are closed.
    ///
    /// # Errors
    /// As [`Self::open_loop`].
    pub(crate) fn response_to(
        whole: &'a ControlLoop,
        controller: usize,
        output: OutputRow,
    ) -> Result<DiscreteStateSpace, AnalysisError> {
        Self::build(whole, whole.loop_plant(Some((controller, output)))?)?.broken(controller, Probe::Reading)
    }

    fn broken(&self, controller: usize, probe: Probe) -> Result<DiscreteStateSpace, AnalysisError> {
        let own = &self.whole.controllers()[controller];
        let common_s = self.schedule.common_s;
        if (common_s - own.spec.period_s).abs() > 1e-9 * common_s {
            return Err(AnalysisError::SlowerThanLoop {
                name: own.name.clone(),
                period_s: own.spec.period_s,
                common_s,
            });
        }
        let (a, output) = self.walk(&self.whole.specs(), Some((controller, probe)))?;
        let n = a.nrows();
        let b = a.column(n).into_owned();
        let (c, d) = (output.columns(0, n).into_owned(), output[n]);
        let sign = if probe == Probe::Law { -1.0 } else { 1.0 };
        Ok(StateSpace::discrete(
            a.columns(0, n).into_owned(),
            DMatrix::from_column_slice(n, 1, b.as_slice()),
            DMatrix::from_row_slice(1, n, c.as_slice()) * sign,
            DMatrix::from_element(1, 1, sign * d),
            common_s,
        )?)
    }

    fn closed_with(&self, specs: &[ControllerSpec]) -> Result<DMatrix<f64>, AnalysisError> {
        Ok(self.walk(specs, None)?.0)
    }

    /// Samples in transit when a common period begins.
    fn stored(&self) -> usize {
        self.schedule.pending.iter().sum::<usize>() + self.schedule.taken.iter().flatten().sum::<usize>()
    }

    /// One common period: every entry of the lifted vector at its end, as rows over the vector. If the loop
    /// is broken, the last column is the output that enters instead. Also returns the response of the broken
    /// controller.
    fn walk(
        &self,
        specs: &[ControllerSpec],
        broken: Option<(usize, Probe)>,
    ) -> Result<(DMatrix<f64>, RowDVector<f64>), AnalysisError> {
        let stored = self.stored();
        if stored > MOST_STORED {
            return Err(AnalysisError::LongDelay {
                stored,
                most: MOST_STORED,
                common_s: self.schedule.common_s,
            });
        }
        let motion_is_velocity = self.whole.controllers().iter().map(|c| c.motion_is_velocity);
        let laws = specs
            .iter()
            .zip(motion_is_velocity)
            .map(|(spec, v)| spec.linear(v))
            .collect::<Result<Vec<_>, _>>()?;
        let mut walk = self.start(&laws, broken.is_some());
        let mut answer = RowDVector::zeros(walk.width);
        self.advance(&mut walk, self.lead_in);
        for ((_, actions), span) in self.schedule.instants.iter().zip(&self.steps) {
            // Sensors are read before anything acts.
            let signals: Vec<[Option<RowDVector<f64>>; 2]> = (0..laws.len())
                .map(|i| {
                    [&self.plant.reading[i], &self.plant.motion[i]]
                        .map(|row| self.signal(&walk, row.as_ref()))
                })
                .collect();
            for action in actions {
                match *action {
                    Action::Take(i, which) => walk.taken[i][which].extend(signals[i][which].clone()),
                    Action::Arrive(i) => {
                        if let Some(output) = walk.pending[i].pop_front() {
                            walk.held[i] = output;
                        }
                    }
                    Action::Sample(i) => {
                        let now = |which: usize, walk: &mut Walk| {
                            let delayed = [&self.plant.reading[i], &self.plant.motion[i]][which]
                                .as_ref()
                                .is_some_and(|row| row.delay_s > 0.0);
                            let early = delayed.then(|| walk.taken[i][which].pop_front()).flatten();
                            early
                                .or_else(|| signals[i][which].clone())
                                .unwrap_or_else(|| RowDVector::zeros(walk.width))
                        };
                        let inputs = [self.target(i, &walk), now(0, &mut walk), now(1, &mut walk)];
                        let output = step(&laws[i], &mut walk.states[i], &inputs);
                        let entering = match broken {
                            Some((controller, probe)) if controller == i => {
                                answer = if probe == Probe::Law { output } else { inputs[1].clone() };
                                let mut unit = RowDVector::zeros(walk.width);
                                unit[walk.width - 1] = 1.0;
                                unit
                            }
                            _ => output,
                        };
                        walk.pending[i].push_back(entering);
                    }
                }
            }
            self.advance(&mut walk, *span);
        }
        Ok((walk.into_matrix(), answer))
    }

    /// The identity: every entry of the lifted vector as itself.
    fn start(&self, laws: &[LinearLaw], broken: bool) -> Walk {
        let n = self.plant.reduced.a.nrows();
        let controllers = laws.len();
        let order = n + controllers + self.stored() + laws.iter().map(|law| law.c.len()).sum::<usize>();
        let width = order + usize::from(broken);
        let mut next = n;
        let mut take = || {
            let mut row = RowDVector::zeros(width);
            row[next] = 1.0;
            next += 1;
            row
        };
        let held = (0..controllers).map(|_| take()).collect();
        let pending =
            self.schedule.pending.iter().map(|&count| (0..count).map(|_| take()).collect()).collect();
        let taken = self
            .schedule
            .taken
            .iter()
            .map(|counts| counts.map(|count| (0..count).map(|_| take()).collect()))
            .collect();
        let states = laws.iter().map(|law| law.c.iter().map(|_| take()).collect()).collect();
        Walk { width, x: DMatrix::identity(n, width), held, pending, taken, states }
    }

    /// Advances the plant over one of its spans with its inputs held.
    fn advance(&self, walk: &mut Walk, span: usize) {
        let (transition, step) = &self.spans[span];
        walk.x = transition * &walk.x;
        for (controller, held) in self.acting(&walk.held) {
            walk.x.ger(1.0, &step.column(controller.drive), &held.transpose(), 1.0);
        }
    }

    fn signal(&self, walk: &Walk, row: Option<&OutputRow>) -> Option<RowDVector<f64>> {
        let row = row?;
        let mut signal = &row.c * &walk.x;
        for (controller, held) in self.acting(&walk.held) {
            signal += held * row.d[controller.drive];
        }
        Some(signal)
    }

    /// Controllers that act on their drives, with the held output of each.
    fn acting<'h>(
        &'h self,
        held: &'h [RowDVector<f64>],
    ) -> impl Iterator<Item = (&'h LoopController, &'h RowDVector<f64>)> {
        self.whole.controllers().iter().zip(held).filter(|(controller, _)| controller.aims_at.is_none())
    }

    /// The reference of controller `i`: the target that others give it, else rest.
    fn target(&self, i: usize, walk: &Walk) -> RowDVector<f64> {
        let mut target = RowDVector::zeros(walk.width);
        for (other, held) in self.whole.controllers().iter().zip(&walk.held) {
            let sampling = self.whole.assembly().drives[other.drive].sampling();
            if let Some(sampling) = sampling.filter(|_| other.aims_at == Some(i)) {
                target += held * sampling.target.gain;
            }
        }
        target
    }
}

impl Walk {
    fn into_matrix(self) -> DMatrix<f64> {
        let mut rows: Vec<RowDVector<f64>> = self.x.row_iter().map(nalgebra::Matrix::into_owned).collect();
        rows.extend(self.held);
        rows.extend(self.pending.into_iter().flatten());
        rows.extend(self.taken.into_iter().flatten().flatten());
        rows.extend(self.states.into_iter().flatten());
        if rows.is_empty() { DMatrix::zeros(0, self.width) } else { DMatrix::from_rows(&rows) }
    }
}

/// One sample of a law: advances its states and returns its output for reference, reading and motion.
fn step(law: &LinearLaw, states: &mut [RowDVector<f64>], inputs: &[RowDVector<f64>; 3]) -> RowDVector<f64> {
    let mix = |of_state: &[f64], of_input: &[f64; 3], states: &[RowDVector<f64>]| {
        let mut sum = &inputs[0] * of_input[0] + &inputs[1] * of_input[1] + &inputs[2] * of_input[2];
        for (factor, state) in of_state.iter().zip(states) {
            sum += state * *factor;
        }
        sum
    };
    let output = mix(&law.c, &law.d, states);
    let next: Vec<_> = law.a.iter().zip(&law.b).map(|(a, b)| mix(a, b, states)).collect();
    states.clone_from_slice(&next);
    output
}
