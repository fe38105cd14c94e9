//! A run: actions at instants ([`Sampling`]), the record ([`Recorder`]), and the motion in between
//! ([`Carrier`]) of every lane ([`Lanes`]).

use feeler_lanes::{Lane, dispatch};

use crate::carry::bodies::BodyEngine;
use crate::carry::carrier::Carrier;
use crate::carry::lanes::Lanes;
use crate::carry::ledger::EnergyBalance;
use crate::carry::peaks::Peak;
use crate::error::{EngineError, RunEnd};
use crate::observe::event::Event;
use crate::observe::observer::Observer;
use crate::run::program::Program;
use crate::run::recorder::Recorder;
use crate::sample::clock::due;
use crate::sample::sampling::{Sampling, earlier};

/// `L::WIDTH` variants of one scenario, run side by side.
#[derive(Debug)]
pub struct Simulation<L: Lane> {
    lanes: Lanes<L>,
    sampling: Sampling<L>,
    recorder: Recorder<L>,
    carrier: Carrier<L>,
    /// Strokes of all drives of all lanes at the start of the interval, while the ledger is kept.
    strokes: Vec<Vec<f64>>,
    duration_s: f64,
    /// Whether [`Self::step_to`] has yet to stop for a record taken at the present instant.
    owes_record: bool,
}

/// Why [`Simulation::step_to`] stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stop {
    /// An event of a lane, which is in the state just after it.
    Event {
        /// Index of the lane that stopped.
        lane: usize,
        event: Event,
    },
    /// A controller has sampled at this instant.
    Sample,
    /// The recorded signals were taken at this instant (see [`Simulation::recorded`]); samples of the same
    /// instant come first.
    Record,
    /// The requested end is reached, or every lane has ended before.
    End,
}

/// The point that [`Simulation::go_on`] reached.
enum Reached {
    /// An event, or the end of an interval that an event had interrupted.
    Between,
    /// An instant, which is served.
    Instant { sampled: bool, recorded: bool },
    /// The requested end, or the end of every lane.
    End,
}

impl<L: Lane> Simulation<L> {
    /// One variant per lane. All must share their structure and timing (periods, delays, offsets, jitter,
    /// record); every other number may differ.
    ///
    /// # Errors
    /// [`EngineError::Structure`] if they do not, [`EngineError::BodyEngines`] for
    /// [`crate::Integrator::External`], and errors of controllers or exponentials.
    pub fn new(programs: Vec<Program>) -> Result<Self, EngineError> {
        Self::with_bodies(programs, Vec::new())
    }

    /// A simulation with [`crate::Integrator::External`], with the engines that move the bodies, one per
    /// lane.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    #[expect(clippy::needless_pass_by_value, reason = "a batch hands over the programs made for it")]
    pub fn with_bodies(
        programs: Vec<Program>,
        bodies: Vec<Box<dyn BodyEngine>>,
    ) -> Result<Self, EngineError> {
        if programs.len() != L::WIDTH {
            return Err(EngineError::Lanes { given: programs.len(), lanes: L::WIDTH });
        }
        for (variant, program) in programs.iter().enumerate().skip(1) {
            if let Some(what) = programs[0].difference(program) {
                return Err(EngineError::Structure { variant, what });
            }
        }
        let lanes = Lanes::new(&programs)?;
        let sampling = Sampling::new(&programs)?;
        let recorder = Recorder::new(&programs[0], &sampling);
        let mut late: Vec<usize> = sampling.delayed_signals().chain(recorder.delayed_signals()).collect();
        late.sort_unstable();
        late.dedup();
        Ok(Self {
            carrier: Carrier::new(&programs, bodies, &lanes, late)?,
            recorder,
            lanes,
            sampling,
            strokes: Vec::new(),
            duration_s: programs[0].run.duration_s,
            owes_record: false,
        })
    }

    /// Runs to the end of the scenario's duration.
    ///
    /// # Errors
    /// Only if the exponential of a mode cannot be computed. A motion that diverges is a result, see
    /// [`Self::end`].
    pub fn run(&mut self, observer: &mut impl Observer<L>) -> Result<(), EngineError> {
        self.run_to(self.duration_s, observer)
    }

    /// Continues to `until_s`, including the instants due then. Ends at instants of the record or of samples
    /// do not change the numbers; other ends change roundings.
    ///
    /// # Errors
    /// Those of [`Self::run`].
    pub fn run_to(&mut self, until_s: f64, observer: &mut impl Observer<L>) -> Result<(), EngineError> {
        // The whole loop is one kernel: group travel and sampling are inlined into it, travel of single lanes
        // is called.
        dispatch(
            #[inline(always)]
            || {
                loop {
                    let reached = self.go_on(until_s, false)?;
                    if self.lanes.has_events() {
                        self.lanes.take_events(|lane, event| observer.event(lane, event));
                    }
                    match reached {
                        Reached::Instant { recorded: true, .. } => {
                            observer.record(self.lanes.time_s(), self.recorder.values());
                        }
                        Reached::Instant { .. } | Reached::Between => {}
                        Reached::End => return Ok(()),
                    }
                }
            },
        )
    }

    /// Runs until the next event, sample or record, or until `until_s`. A loop over this method gives the
    /// same numbers as [`Self::run_to`], bit for bit.
    ///
    /// At an event, the lane of the event is in the state just after it. The other lanes are within the same
    /// interval between instants ([`Self::lane_time_s`] gives the time); the next steps finish that interval.
    /// The ledger charges controllers at the ends of intervals. With fixed steps every lane is at the end of
    /// the interval.
    ///
    /// A 10 kg axis, 5 mm off a wall, is pushed towards it with 40 N. How fast does it hit?
    ///
    /// ```
    /// use feeler_control::{ControllerSpec, Law, ReferenceSpec};
    /// use feeler_engine::{ControllerUse, EventKind, Program, RunSettings, Scenario, Simulation, Stop};
    /// use feeler_plant::description::{Actuator, Body, Contact, GROUND, Machine};
    ///
    /// let mut machine = Machine::default();
    /// machine.bodies.insert("tip".into(), Body { mass_kg: 10.0, position_m: -5e-3, ..Body::default() });
    /// machine.contacts.insert("tool".into(), Contact::kelvin_voigt("tip", GROUND, 1e5, 100.0));
    /// machine.actuators.insert("drive".into(), Actuator::ideal("tip", GROUND));
    /// let mut spec = ControllerSpec::new(Law::OpenLoop, 1e-3);
    /// spec.reference = ReferenceSpec::Constant(40.0);
    /// let push =
    ///     ControllerUse { spec, reads: None, motion: None, drives: "drive".into(), effects: Vec::new() };
    /// let controllers = [("push".to_string(), push)].into_iter().collect();
    /// let run = RunSettings { duration_s: 0.2, ..RunSettings::default() };
    /// let program = Program::new(&Scenario { machine, controllers, run })?;
    ///
    /// let mut simulation = Simulation::<f64>::new(vec![program])?;
    /// let (mut samples, mut hits) = (0, Vec::new());
    /// loop {
    ///     match simulation.step_to(0.2)? {
    ///         Stop::Event { lane, event } if event.kind == EventKind::Touch => {
    ///             let speed_m_per_s = simulation.state(lane)[1];
    ///             hits.push((event.t_s, speed_m_per_s));
    ///         }
    ///         Stop::Sample => samples += 1,
    ///         Stop::End => break,
    ///         _ => {}
    ///     }
    /// }
    /// // After sqrt(2 * 5 mm * 10 kg / 40 N) = 50 ms, at 4 m/s2 * 50 ms.
    /// let (t_s, speed_m_per_s) = hits[0];
    /// assert!((t_s - 0.05).abs() < 1e-12);
    /// assert!((speed_m_per_s - 0.2).abs() < 1e-12);
    /// assert_eq!(samples, 201);
    /// # Ok::<(), feeler_engine::EngineError>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Self::run`].
    pub fn step_to(&mut self, until_s: f64) -> Result<Stop, EngineError> {
        loop {
            if let Some((lane, event)) = self.lanes.take_event() {
                return Ok(Stop::Event { lane, event });
            }
            if std::mem::take(&mut self.owes_record) {
                return Ok(Stop::Record);
            }
            match dispatch(
                #[inline(always)]
                || self.go_on(until_s, true),
            )? {
                Reached::Between => {}
                Reached::Instant { sampled, recorded } => {
                    self.owes_record = recorded;
                    if sampled {
                        return Ok(Stop::Sample);
                    }
                }
                Reached::End => return Ok(Stop::End),
            }
        }
    }

    /// Continues to the next instant and serves it, or to `until_s` if that comes first. With `pauses` it
    /// also stops at an event.
    #[inline(always)]
    fn go_on(&mut self, until_s: f64, pauses: bool) -> Result<Reached, EngineError> {
        let (instant_s, note_s) = self.next_instant(until_s);
        // An end that falls on an instant is that instant. A run in slices then has the same spans as one
        // run.
        let next_s = if due(instant_s, until_s) { instant_s } else { until_s };
        if self.carrier.ends_s().is_some() || !due(next_s, self.lanes.time_s()) {
            let has_come = self.carry(next_s, note_s, pauses)?;
            if pauses && (!has_come || self.lanes.has_events()) {
                return Ok(Reached::Between);
            }
        }
        if self.lanes.all_ended() {
            return Ok(Reached::End);
        }
        if due(instant_s, self.lanes.time_s()) {
            return self.serve();
        }
        Ok(if due(until_s, self.lanes.time_s()) { Reached::End } else { Reached::Between })
    }

    /// The next instant, s, and the instant before it at which late readings take their signals. Taking them
    /// costs one more row of the same product. If there are several such instants, or if the interval ends
    /// before, the next of them is an instant of its own.
    #[inline(always)]
    fn next_instant(&self, until_s: f64) -> (f64, Option<f64>) {
        let instant_s = earlier(self.recorder.next_instant_s(), self.sampling.next_instant_s());
        let take_s = earlier(self.recorder.next_take_s(), self.sampling.next_take_s());
        if due(instant_s, take_s) {
            return (earlier(instant_s, take_s), None);
        }
        let after_s = earlier(self.recorder.take_after_s(take_s), self.sampling.take_after_s(take_s));
        let is_on_the_way = self.carrier.takes_notes(&self.lanes)
            && !due(take_s, self.lanes.time_s())
            && due(instant_s, after_s)
            && due(instant_s, until_s);
        if is_on_the_way { (instant_s, Some(take_s)) } else { (take_s, None) }
    }

    /// Carries every lane to `next_s` past a note, or to the end of the interval that an event interrupted.
    /// Returns whether all have reached it.
    #[inline(always)]
    fn carry(&mut self, next_s: f64, note_s: Option<f64>, pauses: bool) -> Result<bool, EngineError> {
        let keeps_energy = self.lanes.keeps_energy();
        let interrupted = self.carrier.ends_s();
        if interrupted.is_none() {
            if keeps_energy {
                self.strokes = self.lanes.strokes();
            }
            self.carrier.start(&mut self.lanes, next_s, note_s)?;
        }
        if !self.carrier.finish(&mut self.lanes, pauses)? {
            return Ok(false);
        }
        if keeps_energy {
            self.sampling.charge(&self.strokes, &mut self.lanes);
        }
        if let Some(note_s) = self.carrier.finished_note_s() {
            self.sampling.take_delayed(note_s, self.lanes.noted());
            self.recorder.take_delayed(note_s, self.lanes.noted());
        }
        self.lanes.arrive(interrupted.unwrap_or(next_s));
        Ok(true)
    }

    /// Serves every instant that is due, in this order: delayed readings, samples of controllers, records,
    /// arrivals of commands, samples of servos.
    #[inline(always)]
    fn serve(&mut self) -> Result<Reached, EngineError> {
        let Self { lanes, sampling, recorder, .. } = self;
        sampling.move_gaps(lanes);
        lanes.refresh_signals();
        sampling.take_delayed(lanes.time_s(), lanes.signals());
        recorder.take_delayed(lanes.time_s(), lanes.signals());
        let sampled = sampling.sample(lanes)?;
        let recorded = recorder.is_due(lanes.time_s());
        if recorded {
            recorder.take_plant(lanes, sampling);
        }
        sampling.arrivals(lanes)?;
        sampling.sample_servos(lanes)?;
        if recorded {
            recorder.take_commands(lanes, sampling);
        }
        Ok(Reached::Instant { sampled, recorded })
    }

    /// Time that every lane has reached, s.
    pub fn time_s(&self) -> f64 {
        self.lanes.time_s()
    }

    /// Time of a lane's state, s. It exceeds [`Self::time_s`] only while [`Self::step_to`] is stopped at an
    /// event.
    pub fn lane_time_s(&self, lane: usize) -> f64 {
        self.carrier.lane_time_s(lane, &self.lanes)
    }

    /// The recorded signals as last taken, in the order of the scenario's `record`; zeros before the first
    /// record.
    pub fn recorded(&self) -> &[L] {
        self.recorder.values()
    }

    /// How the run of a lane ended; `None` while it goes on.
    pub fn end(&self, lane: usize) -> Option<RunEnd> {
        let is_over = due(self.duration_s, self.lanes.time_s());
        self.lanes.end(lane).or(is_over.then_some(RunEnd::Completed))
    }

    /// Removes a lane from the run at its present state, so that it costs no further work. Its recorded
    /// values are NaN from then on.
    pub fn stop(&mut self, lane: usize) {
        let t_s = self.lane_time_s(lane);
        self.lanes.stop(lane, t_s);
    }

    /// Steps taken so far: intervals between instants and their parts, or fixed steps.
    pub fn steps(&self) -> u64 {
        self.carrier.steps()
    }

    /// Replaces the state of a lane at [`Self::lane_time_s`]: positions, velocities, then drives and filters,
    /// in the order of [`feeler_plant::motion::Layout`]. Gaps keep their own motion. Contacts and sticking
    /// guides follow from the state, and the energy ledger restarts.
    ///
    /// # Errors
    /// If the exponential of the mode of this state cannot be computed.
    pub fn set_state(&mut self, lane: usize, state: &[f64]) -> Result<(), EngineError> {
        let t_s = self.lane_time_s(lane);
        self.lanes.set_state(lane, state, t_s)
    }

    /// The state of a lane.
    pub fn state(&self, lane: usize) -> Vec<f64> {
        self.lanes.state(lane)
    }

    /// Whether some controller of a lane was in its approach at its last sample, so that its law did not run.
    pub fn is_approaching(&self, lane: usize) -> bool {
        self.sampling.is_approaching(lane)
    }

    /// Compression of each contact of a lane at the present time, m (negative across a gap), and its rate,
    /// m/s. Also its acceleration, m/s2 (without the part of nonlinear laws).
    pub fn compressions(&self, lane: usize) -> Vec<[f64; 3]> {
        self.lanes.compressions(lane)
    }

    /// The largest force of every stretch of contact of a lane so far, per contact in the order of the file.
    /// Empty if the run does not keep them. A stretch begins with a touch (or with the run) and ends with a
    /// lift.
    pub fn peaks(&self, lane: usize) -> Vec<Vec<Peak>> {
        self.lanes.peaks(lane)
    }

    /// Whether a lane has ended as an event storm because it keeps the ledger. The ledger must follow every
    /// oscillation of the fastest motion. The states need not be followed so closely, so the lane may
    /// complete without the ledger.
    pub fn outpaces_ledger(&self, lane: usize) -> bool {
        self.lanes.outpaces_ledger(lane)
    }

    /// The energy balance of a lane, if the run keeps the ledger.
    pub fn energy(&self, lane: usize) -> Option<EnergyBalance> {
        self.lanes.energy(lane, &self.sampling.names())
    }
}
