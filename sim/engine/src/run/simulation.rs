//! A run: discrete instants in order ([`crate::run::instants`]), and the motion in between
//! ([`crate::carry::travel`]).

use std::collections::VecDeque;

use feeler_lanes::{Blocks, Lane, LaneMask, dispatch};

use crate::carry::bodies::BodyEngine;
use crate::carry::fixed_step::FixedStep;
use crate::carry::formation::Formation;
use crate::carry::lane::LaneCore;
use crate::carry::ledger::EnergyBalance;
use crate::carry::peaks::{Abreast, Peak};
use crate::carry::transition::Transition;
use crate::error::{EngineError, RunEnd};
use crate::observe::observer::Observer;
use crate::run::program::{Program, Recorded, Tapped};
use crate::run::scenario::Integrator;
use crate::sample::clock::{GapClock, due};
use crate::sample::control_loop::ControlLoop;
use crate::sample::drive::DriveChain;
use crate::sample::sensing::Sensing;
use crate::sample::taps::Tap;

/// `L::WIDTH` variants of one scenario, run side by side.
#[derive(Debug)]
pub struct Simulation<L: Lane> {
    pub(crate) programs: Vec<Program>,
    pub(crate) lanes: Vec<LaneCore>,
    pub(crate) formation: Formation<L>,
    /// Whether lanes have met events that nobody has been told of.
    pub(crate) news: bool,
    pub(crate) loops: Vec<ControlLoop<L>>,
    pub(crate) drives: Vec<DriveChain<L>>,
    /// Whether any output or command is under way for a while.
    pub(crate) any_late: bool,
    pub(crate) sensors: Vec<Sensing<L>>,
    pub(crate) taps: Vec<Tap<L>>,
    /// One per gap that moves by itself.
    pub(crate) gaps: Vec<GapClock>,
    /// For each recorded reading of a delayed sensor its tap.
    pub(crate) record_taps: Vec<Option<usize>>,
    pub(crate) t_s: f64,
    pub(crate) records: u64,
    /// Instant of the next record; infinite where nothing is recorded.
    pub(crate) next_record_s: f64,
    pub(crate) record_rate_hz: f64,
    /// What is recorded at the present instant.
    pub(crate) record: Vec<L>,
    /// Extended vector of every lane.
    pub(crate) xi: Vec<L>,
    pub(crate) product: Vec<L>,
    pub(crate) transitions: Vec<Transition<L>>,
    /// The one that was used last.
    pub(crate) last_transition: usize,
    pub(crate) seen_spans: VecDeque<u64>,
    /// Values of the wanted signals.
    pub(crate) signals: Vec<L>,
    /// Lanes whose signals came with their motion to the present instant.
    pub(crate) told: L::Mask,
    /// The signals of the others, padded.
    pub(crate) looked_up: Vec<L>,
    pub(crate) signal_rows: Blocks<L>,
    pub(crate) signal_rows_for: Vec<usize>,
    /// The formation for which these rows were filled in.
    pub(crate) signal_rows_at: u64,
    pub(crate) fixed: Option<FixedStep<L>>,
    pub(crate) scratch: Vec<f64>,
    /// Largest forces of the present stretches of contact, one per contact; none where peaks are not kept,
    /// and with fixed steps, where each lane has its own.
    pub(crate) peaks: Vec<Abreast<L>>,
    /// Steps taken: intervals, parts of them, or fixed steps.
    pub(crate) steps: u64,
}

impl<L: Lane> Simulation<L> {
    /// One variant per lane. All must share their structure and timing (periods, delays, offsets, jitter,
    /// record), and may differ in every other number.
    ///
    /// # Errors
    /// [`EngineError::Structure`] where they do not, [`EngineError::BodyEngines`] for
    /// [`Integrator::External`], and whatever the controllers or exponentials object to.
    pub fn new(programs: Vec<Program>) -> Result<Self, EngineError> {
        Self::with_bodies(programs, Vec::new())
    }

    /// The same, where the integrator is [`Integrator::External`], with the engines that move the bodies, one
    /// per lane.
    ///
    /// # Errors
    /// Those of [`Self::new`].
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
        let first = &programs[0];
        let needed = if first.run.integrator == Integrator::External { L::WIDTH } else { 0 };
        if bodies.len() != needed {
            return Err(EngineError::BodyEngines { given: bodies.len(), needed });
        }
        let (energy, seed) = (first.run.energy, first.run.seed);
        // Fixed steps without a ledger go many at a time, and look at nothing in between.
        let is_exact = first.run.integrator == Integrator::Exact;
        let keeps_peaks = first.run.peaks && (is_exact || energy);
        let mut lanes = Vec::new();
        let mut states = Vec::new();
        for program in &programs {
            let (lane, state) =
                LaneCore::new(program.motion.clone(), program.wanted.clone(), energy, keeps_peaks)?;
            lanes.push(lane);
            states.push(state);
        }
        let xi = (0..states[0].len()).map(|i| L::from_fn(|l| states[l][i])).collect();
        let parts = |i: usize| programs.iter().map(|p| &p.motion.assembly().drives[i]).collect::<Vec<_>>();
        let drives: Vec<DriveChain<L>> =
            (0..first.motion.assembly().drives.len()).map(|i| DriveChain::new(&parts(i))).collect();
        let parts = |i: usize| programs.iter().map(|p| &p.motion.assembly().sensors[i]).collect::<Vec<_>>();
        let sensors: Vec<Sensing<L>> =
            (0..first.motion.assembly().sensors.len()).map(|i| Sensing::new(&parts(i), seed)).collect();
        let mut taps = Vec::new();
        let mut tap = |tapped: Tapped, first_s: f64| {
            let delay_s = sensors[tapped.sensor].delay_s;
            (delay_s > 0.0).then(|| {
                taps.push(Tap::new(tapped.signal, delay_s, first_s));
                taps.len() - 1
            })
        };
        let loops = (0..first.controllers.len())
            .map(|i| ControlLoop::new(&programs, i, &mut tap))
            .collect::<Result<Vec<ControlLoop<L>>, _>>()?;
        let record_taps = (first.recorded.iter())
            .map(|recorded| match *recorded {
                Recorded::Reading(sensor, signal) => tap(Tapped { sensor, signal }, 0.0),
                _ => None,
            })
            .collect();
        let fixed = (first.run.integrator != Integrator::Exact)
            .then(|| FixedStep::new(first.run.integrator, first.run.step_s, &lanes, bodies));
        let contacts = if keeps_peaks && is_exact { first.motion.assembly().contacts.len() } else { 0 };
        let mut peaks = vec![Abreast::new(); contacts];
        for (l, of_lane) in lanes.iter().enumerate().filter_map(|(l, lane)| Some((l, lane.peaks.as_ref()?))) {
            peaks.iter_mut().enumerate().for_each(|(i, present)| present.take(of_lane, i, l));
        }
        let signal_rows = Blocks::zeros(first.wanted.len(), first.motion.layout().width());
        Ok(Self {
            formation: Formation::new(&lanes),
            news: lanes.iter().any(|lane| !lane.events.is_empty()),
            lanes,
            any_late: loops.iter().any(|control| control.delay_s > 0.0)
                || drives.iter().any(|drive| drive.delay_s > 0.0),
            loops,
            drives,
            sensors,
            taps,
            gaps: first
                .motion
                .assembly()
                .contacts
                .iter()
                .filter_map(|contact| contact.profile.as_deref())
                .map(GapClock::new)
                .collect(),
            record_taps,
            t_s: 0.0,
            records: 0,
            next_record_s: if first.recorded.is_empty() { f64::INFINITY } else { 0.0 },
            record_rate_hz: 1.0 / first.record_spacing_s(),
            record: vec![L::zero(); first.recorded.len()],
            xi,
            product: Vec::new(),
            transitions: Vec::new(),
            last_transition: 0,
            seen_spans: VecDeque::new(),
            signals: vec![L::zero(); first.wanted.len()],
            told: L::Mask::splat(false),
            looked_up: vec![L::zero(); signal_rows.padded_rows()],
            signal_rows,
            signal_rows_for: vec![usize::MAX; L::WIDTH],
            signal_rows_at: 0,
            fixed,
            scratch: Vec::new(),
            peaks,
            steps: 0,
            programs,
        })
    }

    /// Runs to the end of the scenario's duration.
    ///
    /// # Errors
    /// Only where the exponential of a mode cannot be computed; a motion that diverges is a result, see
    /// [`Self::end`].
    pub fn run(&mut self, observer: &mut impl Observer<L>) -> Result<(), EngineError> {
        let duration_s = self.programs[0].run.duration_s;
        self.run_to(duration_s, observer)
    }

    /// Runs on to `until_s`; instants due then are served. Ends at instants of the record or of samples leave
    /// no trace in the numbers; others change roundings.
    ///
    /// # Errors
    /// Those of [`Self::run`].
    pub fn run_to(&mut self, until_s: f64, observer: &mut impl Observer<L>) -> Result<(), EngineError> {
        // The whole loop is one kernel: what travels and what samples is inlined into it, what goes alone is
        // called.
        dispatch(
            #[inline(always)]
            || {
                loop {
                    let instant_s = self.next_instant_s();
                    // An end that falls on an instant is that instant: a run in slices then goes through the
                    // same spans as one run.
                    let next_s = if due(instant_s, until_s) { instant_s } else { until_s };
                    if !due(next_s, self.t_s) {
                        self.propagate(next_s - self.t_s)?;
                        self.t_s = next_s;
                        if self.news {
                            self.tell(observer);
                        }
                    }
                    if self.formation.all_ended {
                        return Ok(());
                    }
                    if due(instant_s, self.t_s) {
                        self.serve(observer)?;
                    } else if due(until_s, self.t_s) {
                        return Ok(());
                    }
                }
            },
        )
    }

    #[cold]
    fn tell(&mut self, observer: &mut impl Observer<L>) {
        self.news = false;
        for (l, lane) in self.lanes.iter_mut().enumerate() {
            for event in lane.events.drain(..) {
                observer.event(l, &event);
            }
        }
    }

    /// Time reached, s.
    pub fn time_s(&self) -> f64 {
        self.t_s
    }

    /// How the run of a lane ended; `None` while it goes on.
    pub fn end(&self, lane: usize) -> Option<RunEnd> {
        let is_over = due(self.programs[0].run.duration_s, self.t_s);
        self.lanes[lane].end.or(is_over.then_some(RunEnd::Completed))
    }

    /// Takes a lane out of the run where it is, so that what would still happen in it costs the others
    /// nothing. From then on its recorded values are not numbers.
    pub fn stop(&mut self, lane: usize) {
        if !self.lanes[lane].has_ended() {
            self.lanes[lane].end = Some(RunEnd::Stopped { t_s: self.t_s });
            self.formation.form(&self.lanes);
        }
    }

    /// Steps taken so far: intervals between instants and their parts, or fixed steps.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Replaces the state (positions, velocities, then drives and filters; gaps move as they do at that time,
    /// as [`feeler_plant::motion::Layout`] numbers them) of a lane at the present time; what touches and what
    /// sticks follows from it, and the energy ledger starts anew.
    ///
    /// # Errors
    /// Where the exponential of the mode that the state is in cannot be computed.
    pub fn set_state(&mut self, lane: usize, state: &[f64]) -> Result<(), EngineError> {
        take_lane(&self.xi, lane, &mut self.scratch);
        let states = self.programs[lane].motion.layout().states().min(state.len());
        self.scratch[..states].copy_from_slice(&state[..states]);
        self.lanes[lane].motion.set_gaps(self.t_s, &mut self.scratch);
        self.told = L::Mask::splat(false);
        let (xi, t_s) = (&mut self.scratch, self.t_s);
        self.lanes[lane].exchange_peaks(&mut self.peaks, lane, |lane| lane.begin_at(xi, t_s))?;
        put_lane(&mut self.xi, lane, &self.scratch);
        self.formation.form(&self.lanes);
        Ok(())
    }

    /// The state of a lane.
    pub fn state(&self, lane: usize) -> Vec<f64> {
        self.xi[..self.programs[lane].motion.layout().states()].iter().map(|x| x.lane(lane)).collect()
    }

    /// The largest force of every stretch of contact of a lane so far, per contact in the order of the file;
    /// none where the run does not keep them. A stretch begins with a touch (or with the run) and ends with a
    /// lift.
    pub fn peaks(&self, lane: usize) -> Vec<Vec<Peak>> {
        let Some(peaks) = &self.lanes[lane].peaks else { return Vec::new() };
        (0..self.programs[lane].motion.assembly().contacts.len())
            .map(|i| peaks.of(i, self.peaks.get(i).map(|abreast| abreast.peak(lane))))
            .collect()
    }

    /// The energy balance of a lane, if the run keeps the ledger.
    pub fn energy(&self, lane: usize) -> Option<EnergyBalance> {
        let core = &self.lanes[lane];
        let ledger = core.ledger.as_ref()?;
        let xi: Vec<f64> = self.xi.iter().map(|x| x.lane(lane)).collect();
        let names: Vec<String> = self.programs[lane].controllers.keys().cloned().collect();
        Some(ledger.balance(&core.motion, core.flow(), &xi, &names))
    }
}

pub(crate) fn take_lane<L: Lane>(xi: &[L], l: usize, out: &mut Vec<f64>) {
    out.clear();
    out.extend(xi.iter().map(|x| x.lane(l)));
}

pub(crate) fn put_lane<L: Lane>(xi: &mut [L], l: usize, values: &[f64]) {
    for (x, &value) in xi.iter_mut().zip(values) {
        x.set_lane(l, value);
    }
}
