//! One variant on its own: the modes it has met, and its motion through events.
//!
//! Lanes travel together between events. A lane that meets an event goes through it here, alone, and rejoins
//! the others at the end of the interval.

use feeler_plant::assembly::Source;
use feeler_plant::motion::modes::{ModeTable, Storm, Switched};
use feeler_plant::motion::{Mode, Motion};

use crate::carry::ledger::{EnergyLedger, GAUSS_NODES};
use crate::carry::peaks::Peaks;
use crate::carry::toil::{NONLINEAR, Toil, WITH_ENERGY};
use crate::error::{EngineError, RunEnd};
use crate::observe::event::{Event, EventKind};
use crate::solve::crossing::{Known, Path, Piece, first_guard};
use crate::solve::decay::Decay;
use crate::solve::extrapolation::Extrapolation;
use crate::solve::flow::Flow;
use crate::solve::flows::Flows;
use crate::solve::taylor::Series;

/// Largest span of one polynomial, relative to its limit, while the ledger is kept. Powers oscillate twice as
/// fast as the motion, and eight nodes then integrate them to machine precision.
const LEDGER_SHARE: f64 = 1.0 / 3.0;

/// A span that a lane travels on its own, and its progress.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passage {
    from_s: f64,
    span_s: f64,
    elapsed_s: f64,
    has_begun: bool,
    /// Time from the start to the note, at which late readings take their signals; `None` once they are
    /// taken.
    note_s: Option<f64>,
    /// Whether the passage has a note, ahead or past.
    has_note: bool,
}

impl Passage {
    pub(crate) fn new(from_s: f64, span_s: f64, note_s: Option<f64>) -> Self {
        Self { from_s, span_s, elapsed_s: 0.0, has_begun: false, note_s, has_note: note_s.is_some() }
    }

    pub(crate) fn has_note(&self) -> bool {
        self.has_note
    }

    pub(crate) fn time_s(&self) -> f64 {
        self.from_s + self.elapsed_s
    }

    pub(crate) fn is_through(&self) -> bool {
        self.elapsed_s >= self.span_s
    }

    /// Records that the lane has moved by `moved_s`.
    fn go(&mut self, moved_s: f64) {
        self.elapsed_s += moved_s;
        if self.span_s - self.elapsed_s <= self.resolution_s() {
            self.elapsed_s = self.span_s;
        }
    }

    /// Time to the note, if it is ahead; zero once it is reached.
    fn until_note_s(&self) -> Option<f64> {
        let left_s = self.note_s? - self.elapsed_s;
        Some(if left_s <= self.resolution_s() { 0.0 } else { left_s })
    }

    /// Resolution of the clock at the end of the passage.
    fn resolution_s(&self) -> f64 {
        f64::EPSILON * (self.from_s + self.span_s)
    }
}

/// One variant.
#[derive(Debug)]
pub(crate) struct LaneCore {
    pub(super) motion: Motion,
    flows: Flows,
    /// Index of the current flow.
    pub(super) current: usize,
    pub(super) events: Vec<Event>,
    storm: Storm,
    toil: Toil,
    pub(super) ledger: Option<EnergyLedger>,
    pub(super) peaks: Option<Peaks>,
    /// Why the lane has stopped moving; `None` while it moves.
    pub(super) end: Option<RunEnd>,
    /// Whether the lane has stopped because the ledger follows its linear motion in too many pieces.
    pub(super) outpaces_ledger: bool,
    /// Time since the last event within the present span, s.
    calm_s: f64,
    series: Series,
    extrapolation: Extrapolation,
    /// The extended vector at the last note, and the index of the flow there.
    noted: (usize, Vec<f64>),
}

impl LaneCore {
    /// A state beyond this has diverged.
    pub(crate) const BOUND: f64 = 1e12;

    /// A variant at its start: the machine's initial state and the mode of that state.
    pub(crate) fn new(
        motion: Motion,
        wanted: Vec<Source>,
        energy: bool,
        peaks: bool,
    ) -> Result<(Self, Vec<f64>), EngineError> {
        let mut xi = motion.initial_vector();
        let contacts = motion.assembly().contacts.len();
        let mut lane = Self {
            motion,
            flows: Flows::new(wanted, energy, peaks),
            current: 0,
            events: Vec::new(),
            storm: Storm::default(),
            toil: Toil::default(),
            ledger: energy.then(EnergyLedger::default),
            peaks: peaks.then(|| Peaks::new(contacts)),
            end: None,
            outpaces_ledger: false,
            calm_s: 0.0,
            series: Series::default(),
            extrapolation: Extrapolation::default(),
            noted: (0, Vec::new()),
        };
        lane.enter_initial_mode(Mode::default(), &mut xi, 0.0)?;
        let equations = lane.flows[lane.current].equations.clone();
        lane.motion.settle_filters(&equations, &mut xi);
        Ok((lane, xi))
    }

    pub(crate) fn flow(&self) -> &Flow {
        &self.flows[self.current]
    }

    pub(crate) fn flow_mut(&mut self) -> &mut Flow {
        &mut self.flows[self.current]
    }

    /// The flow and the extended vector at the last note.
    pub(crate) fn noted(&self) -> (&Flow, &[f64]) {
        let (index, xi) = &self.noted;
        (&self.flows[*index], xi)
    }

    /// Keeps the present state as that of the note.
    #[cold]
    fn take_note(&mut self, xi: &[f64]) {
        self.noted.0 = self.current;
        self.noted.1.clear();
        self.noted.1.extend_from_slice(xi);
        let flow = &self.flows[self.current];
        if !flow.linear {
            self.motion.fill_terms(&flow.equations, &mut self.noted.1);
        }
    }

    pub(crate) fn has_ended(&self) -> bool {
        self.end.is_some()
    }

    /// Enters the mode of a state that was not reached by motion; limits and ramps are as in `held`.
    fn enter_initial_mode(&mut self, held: Mode, xi: &mut [f64], t_s: f64) -> Result<(), EngineError> {
        let beginning = self.motion.begin(&mut self.flows, held, xi)?;
        self.current = beginning.index;
        if let Some(ledger) = &mut self.ledger {
            let flows = [beginning.pressed, beginning.index].map(|i| &self.flows[i]);
            ledger.begin(&self.motion, flows[0], xi);
            for switch in beginning.releasing {
                ledger.switch(&self.motion, flows, switch, xi);
            }
        }
        if let Some(peaks) = &mut self.peaks {
            peaks.enter(&self.flows[self.current], xi, t_s);
        }
        Ok(())
    }

    /// Restarts at a state that was not reached by motion: determines what touches, sticks and slides there,
    /// and restarts the ledger.
    pub(crate) fn begin_at(&mut self, xi: &mut [f64], t_s: f64) -> Result<(), EngineError> {
        let old = self.flow().equations.mode;
        self.enter_initial_mode(old, xi, t_s)
    }

    /// Gives drive `i` a new input. If the drive's rate is limited, a ramp starts there.
    pub(crate) fn set_input(&mut self, i: usize, value: f64, xi: &mut [f64]) -> Result<(), EngineError> {
        let mode = self.motion.take_input(self.flow().equations.mode, i, value, xi);
        self.current = self.flows.index_of(&self.motion, mode)?;
        Ok(())
    }

    /// Moves `xi` through every event to the end of a passage or, with `pauses`, to the next recorded event.
    pub(crate) fn advance(
        &mut self,
        xi: &mut [f64],
        passage: &mut Passage,
        pauses: bool,
    ) -> Result<(), EngineError> {
        if !std::mem::replace(&mut passage.has_begun, true) {
            self.storm.begin();
            self.calm_s = 0.0;
        }
        while !passage.is_through() && !self.has_ended() {
            let until_note = passage.until_note_s();
            if until_note.is_some_and(|s| s <= 0.0) {
                passage.note_s = None;
                self.take_note(xi);
                continue;
            }
            let remaining = passage.span_s - passage.elapsed_s;
            let push = self.storm.push_s();
            let attempts = self.extrapolation.attempts;
            let (moved, event) = if self.flow().linear {
                self.linear_piece(xi, passage, remaining, push)
            } else {
                // Only polynomials give the motion within a piece, so a nonlinear piece ends at the note.
                let remaining = until_note.unwrap_or(remaining);
                self.nonlinear_piece(xi, passage.time_s(), remaining, push)
            };
            self.storm.moved(moved, push.is_some());
            passage.go(moved);
            self.calm_s += moved;
            let t_s = passage.time_s();
            if let Some(guard) = event {
                self.calm_s = 0.0;
                self.switch(guard, xi, t_s)?;
                if self.storm.fired(t_s) {
                    self.end = Some(RunEnd::EventStorm { t_s });
                }
            }
            let polynomials = if self.ledger.is_some() { WITH_ENERGY } else { 1 };
            let steps = polynomials + NONLINEAR * (self.extrapolation.attempts - attempts);
            if self.toil.took(steps, t_s) {
                self.outpaces_ledger = self.ledger.is_some() && self.flow().linear;
                self.end = Some(RunEnd::EventStorm { t_s });
            }
            // A piece that does not advance has found no finite state.
            if (event.is_none() && moved <= 0.0) || xi.iter().any(|x| x.is_nan() || x.abs() > Self::BOUND) {
                self.end = Some(RunEnd::Diverged { t_s });
            }
            if pauses && !self.events.is_empty() {
                break;
            }
        }
        let is_over = passage.is_through() || self.has_ended();
        if is_over && passage.note_s.take().is_some() {
            self.take_note(xi);
        }
        Ok(())
    }

    /// One polynomial of a linear mode: returns its length, and the guard that ended it.
    fn linear_piece(
        &mut self,
        xi: &mut [f64],
        passage: &mut Passage,
        remaining: f64,
        push: Option<f64>,
    ) -> (f64, Option<usize>) {
        let (t_s, until_note) = (passage.time_s(), passage.until_note_s());
        let share = if self.ledger.is_some() { LEDGER_SHARE } else { 1.0 };
        let flow = &mut self.flows[self.current];
        if let Some(reach) = flow.reach_beyond_decay_s(self.calm_s, remaining).filter(|_| push.is_none()) {
            let most = until_note.unwrap_or(remaining);
            return self.decayed_piece(xi, t_s, (share * reach).min(most));
        }
        let flow = &self.flows[self.current];
        let reach = flow.horizon_s * share;
        let mut h = push.map_or(reach, |push| push.min(reach)).min(remaining);
        self.series.expand(flow, xi, h);
        let mut event = None;
        if push.is_none() {
            for (i, guard) in flow.equations.guards.iter().enumerate() {
                if self.series.stays_positive(&guard.row, xi, flow.width, h) {
                    continue;
                }
                let polynomial = self.series.functional(&guard.row, xi, flow.width);
                if let Some(s) = polynomial.first_crossing(h, || flow.slope_size(&guard.row, xi))
                    && (event.is_none() || s < h)
                {
                    h = s;
                    event = Some(i);
                }
            }
        }
        // A machine at rest stays at rest until the next input.
        let looked_at = h;
        if push.is_none() && event.is_none() && self.series.is_constant() {
            h = remaining;
        }
        if let Some(ledger) = &mut self.ledger {
            let mut node = xi.to_vec();
            for (position, weight) in GAUSS_NODES {
                self.series.evaluate(position * h, &mut node);
                ledger.add_powers(&flow.ledger, &node, weight * h);
            }
        }
        if let Some(peaks) = &mut self.peaks {
            peaks.linear_piece(flow, &self.series, xi, t_s, looked_at);
        }
        if let Some(s) = until_note.filter(|s| *s <= h) {
            passage.note_s = None;
            self.take_note(xi);
            self.series.evaluate(s, &mut self.noted.1);
            self.motion.join(&self.flows[self.current].equations, &mut self.noted.1);
        }
        self.series.evaluate(h, xi);
        self.join(xi);
        (h, event)
    }

    /// A piece of a linear mode whose fastest part has decayed: exponentials reach many times as far as a
    /// polynomial.
    fn decayed_piece(&mut self, xi: &mut [f64], t_s: f64, mut h: f64) -> (f64, Option<usize>) {
        let mut piece = Decay::new(&mut self.flows[self.current], xi);
        let (first, event) = first_guard(&mut piece, h);
        h = first;
        if let Some(ledger) = &mut self.ledger {
            for (position, weight) in GAUSS_NODES {
                let Some(node) = piece.state(position * h) else { return (0.0, None) };
                ledger.add_powers(&piece.flow().ledger, &node, weight * h);
            }
        }
        if let Some(peaks) = &mut self.peaks {
            peaks.piece(&mut piece, t_s, h);
        }
        let Some(end) = piece.state(h) else { return (0.0, None) };
        xi.copy_from_slice(&end);
        self.join(xi);
        (h, event)
    }

    /// One step of a nonlinear mode.
    fn nonlinear_piece(
        &mut self,
        xi: &mut [f64],
        t_s: f64,
        remaining: f64,
        push: Option<f64>,
    ) -> (f64, Option<usize>) {
        let flow = &self.flows[self.current];
        self.motion.fill_terms(&flow.equations, xi);
        let span = push.map_or(flow.horizon_s, |push| push.min(flow.horizon_s)).min(remaining);
        let meters: &mut [f64] = self.ledger.as_mut().map_or(&mut [], |ledger| &mut ledger.meters);
        let start = Known::start(xi, meters);
        let Some(mut h) = self.extrapolation.step(&self.motion, flow, xi, meters, span) else {
            return (0.0, None);
        };
        let mut path = Path::new(&self.motion, flow, &mut self.extrapolation, start);
        path.reaches(h, xi, meters);
        let mut event = None;
        if push.is_none() {
            (h, event) = first_guard(&mut path, h);
        }
        if event.is_some() {
            let Some(end) = path.at(h) else { return (0.0, None) };
            xi.copy_from_slice(&end.xi);
            meters.copy_from_slice(&end.meters);
        }
        if let Some(peaks) = &mut self.peaks {
            peaks.piece(&mut path, t_s, h);
        }
        self.join(xi);
        (h, event)
    }

    /// Records the contact forces at the end of a fixed step.
    pub(crate) fn note_peaks(&mut self, xi: &[f64], t_s: f64) {
        if let Some(peaks) = &mut self.peaks {
            peaks.enter(&self.flows[self.current], xi, t_s);
        }
    }

    /// Finds the peak within a span of the present mode that was travelled in one step from `xi`; `xi` is
    /// moved.
    pub(crate) fn peak(&mut self, xi: &mut [f64], t_s: f64, span_fs: u64) -> Result<(), EngineError> {
        match &mut self.peaks {
            Some(peaks) => peaks.peak(&mut self.flows[self.current], &mut self.series, xi, t_s, span_fs),
            None => Ok(()),
        }
    }

    /// Makes the speeds of bodies that stick together bitwise equal.
    pub(crate) fn join(&self, xi: &mut [f64]) {
        self.motion.join(&self.flow().equations, xi);
    }

    /// Changes the mode after guard `index` has fired.
    pub(crate) fn switch(&mut self, index: usize, xi: &mut [f64], t_s: f64) -> Result<(), EngineError> {
        let old = self.current;
        let Switched { index, switch, from, to } =
            self.motion.switch(&mut self.flows, self.current, index, xi)?;
        self.current = index;
        if let Some(ledger) = &mut self.ledger {
            ledger.switch(&self.motion, [old, index].map(|i| &self.flows[i]), switch, xi);
        }
        if let Some(peaks) = &mut self.peaks {
            peaks.enter(&self.flows[index], xi, t_s);
        }
        if let Some(kind) = EventKind::of(switch, from, to) {
            self.events.push(Event { t_s, kind, switch });
        }
        Ok(())
    }

    /// Sets a sliding guide to rest if a fixed step has carried it past rest.
    pub(crate) fn stop_exactly(&self, guard: usize, xi: &mut [f64]) {
        self.motion.stop_exactly(&self.flow().equations, guard, xi);
    }
}
