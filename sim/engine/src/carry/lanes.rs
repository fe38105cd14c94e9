//! All variants of a run, each with its mode and events; their states lie side by side.

use feeler_lanes::{Lane, LaneMask};
use feeler_plant::motion::{Row, dot};

use crate::carry::abreast::Abreast;
use crate::carry::formation::Formation;
use crate::carry::lane::LaneCore;
use crate::carry::ledger::EnergyBalance;
use crate::carry::peaks::Peak;
use crate::carry::signals::Signals;
use crate::error::{EngineError, RunEnd};
use crate::observe::event::Event;
use crate::run::program::Program;
use crate::run::settings::Integrator;
use crate::sample::clock::SAME_INSTANT_S;

/// Every variant of a run.
#[derive(Debug)]
pub(crate) struct Lanes<L: Lane> {
    pub(super) cores: Vec<LaneCore>,
    pub(super) formation: Formation<L>,
    /// Extended vector of every lane.
    pub(super) xi: Vec<L>,
    /// Instant that all lanes have reached, s.
    pub(super) t_s: f64,
    pub(super) signals: Signals<L>,
    /// Largest forces of the present stretches of contact, one per contact. Empty if peaks are not kept. Also
    /// empty with fixed steps, since each lane then keeps its own peaks.
    pub(super) peaks: Vec<Abreast<L>>,
    has_events: bool,
    pub(super) scratch: Vec<f64>,
}

impl<L: Lane> Lanes<L> {
    pub(crate) fn new(programs: &[Program]) -> Result<Self, EngineError> {
        let first = &programs[0];
        let energy = first.run.energy;
        // Fixed steps without a ledger run many at a time, without evaluations in between.
        let is_exact = first.run.integrator == Integrator::Exact;
        let keeps_peaks = first.run.peaks && (is_exact || energy);
        let mut cores = Vec::new();
        let mut states = Vec::new();
        for program in programs {
            let (core, state) =
                LaneCore::new(program.motion.clone(), program.wanted.clone(), energy, keeps_peaks)?;
            cores.push(core);
            states.push(state);
        }
        let contacts = if keeps_peaks && is_exact { first.motion.assembly().contacts.len() } else { 0 };
        let mut peaks = vec![Abreast::new(); contacts];
        for (l, of_lane) in cores.iter().enumerate().filter_map(|(l, core)| Some((l, core.peaks.as_ref()?))) {
            peaks.iter_mut().enumerate().for_each(|(i, present)| present.take(of_lane, i, l));
        }
        Ok(Self {
            formation: Formation::new(&cores),
            has_events: false,
            cores,
            xi: (0..states[0].len()).map(|i| L::from_fn(|l| states[l][i])).collect(),
            t_s: 0.0,
            signals: Signals::new(first.wanted.len(), first.motion.layout().width()),
            peaks,
            scratch: Vec::new(),
        })
    }

    /// Instant that all lanes have reached, s.
    #[inline(always)]
    pub(crate) fn time_s(&self) -> f64 {
        self.t_s
    }

    /// Records that every lane has reached `t_s`.
    #[inline(always)]
    pub(crate) fn arrive(&mut self, t_s: f64) {
        self.t_s = t_s;
    }

    #[inline(always)]
    pub(crate) fn all_ended(&self) -> bool {
        self.formation.all_ended
    }

    /// Sets the values of lanes that have ended to NaN.
    pub(crate) fn blank_ended(&self, values: &mut [L]) {
        if !self.formation.travelling.all() {
            for (l, _) in self.cores.iter().enumerate().filter(|(_, core)| core.has_ended()) {
                for value in values.iter_mut() {
                    value.set_lane(l, f64::NAN);
                }
            }
        }
    }

    /// Why lane `l` has stopped moving; `None` while it moves.
    pub(crate) fn end(&self, l: usize) -> Option<RunEnd> {
        self.cores[l].end
    }

    /// Removes lane `l`, which is at `t_s`, from the run.
    pub(crate) fn stop(&mut self, l: usize, t_s: f64) {
        if !self.cores[l].has_ended() {
            self.cores[l].end = Some(RunEnd::Stopped { t_s });
            self.formation.form(&self.cores);
        }
    }

    pub(super) fn note_events(&mut self) {
        self.has_events |= self.cores.iter().any(|core| !core.events.is_empty());
    }

    /// Whether lanes have events that have not been taken.
    #[inline(always)]
    pub(crate) fn has_events(&self) -> bool {
        self.has_events
    }

    /// Hands over every event with its lane; events of one lane are in order.
    #[cold]
    pub(crate) fn take_events(&mut self, mut take: impl FnMut(usize, &Event)) {
        self.has_events = false;
        for (l, core) in self.cores.iter_mut().enumerate() {
            core.events.drain(..).for_each(|event| take(l, &event));
        }
    }

    /// The first event that has not been taken, with its lane.
    pub(crate) fn take_event(&mut self) -> Option<(usize, Event)> {
        let next = (self.cores.iter_mut().enumerate())
            .find_map(|(l, core)| (!core.events.is_empty()).then(|| (l, core.events.remove(0))));
        self.has_events = next.is_some();
        next
    }

    /// The state of lane `l`, as [`feeler_plant::motion::Layout`] numbers it.
    pub(crate) fn state(&self, l: usize) -> Vec<f64> {
        let states = self.cores[l].motion.layout().states();
        self.xi[..states].iter().map(|x| x.lane(l)).collect()
    }

    /// Replaces the state of lane `l`, which is at `t_s`.
    pub(crate) fn set_state(&mut self, l: usize, state: &[f64], t_s: f64) -> Result<(), EngineError> {
        take_lane(&self.xi, l, &mut self.scratch);
        let core = &mut self.cores[l];
        let states = core.motion.layout().states().min(state.len());
        self.scratch[..states].copy_from_slice(&state[..states]);
        core.motion.set_gaps(t_s, &mut self.scratch);
        self.signals.are_fresh = L::Mask::splat(false);
        let xi = &mut self.scratch;
        core.exchange_peaks(&mut self.peaks, l, |core| core.begin_at(xi, t_s))?;
        put_lane(&mut self.xi, l, &self.scratch);
        self.formation.form(&self.cores);
        Ok(())
    }

    /// Sets the speed of every gap to that of its piece from the present instant on.
    pub(crate) fn move_gaps(&mut self) {
        for (l, core) in self.cores.iter().enumerate() {
            take_lane(&self.xi, l, &mut self.scratch);
            // Slightly later than the present: an instant may come early by less than that, and the next
            // piece must apply.
            core.motion.set_gaps(self.t_s + SAME_INSTANT_S, &mut self.scratch);
            core.motion.join(&core.flow().equations, &mut self.scratch);
            put_lane(&mut self.xi, l, &self.scratch);
        }
    }

    /// Gives drive `i` a new input.
    #[inline(always)]
    pub(crate) fn set_input(&mut self, i: usize, input: L) -> Result<(), EngineError> {
        let layout = self.cores[0].motion.layout();
        if layout.ramp(i).is_some() {
            return self.ramp_to(i, input);
        }
        self.xi[layout.input(i)] = input;
        Ok(())
    }

    /// A new input of a drive with limited rate starts a ramp, which is another mode.
    #[cold]
    fn ramp_to(&mut self, i: usize, input: L) -> Result<(), EngineError> {
        for (l, core) in self.cores.iter_mut().enumerate() {
            take_lane(&self.xi, l, &mut self.scratch);
            core.set_input(i, input.lane(l), &mut self.scratch)?;
            put_lane(&mut self.xi, l, &self.scratch);
        }
        self.formation.form(&self.cores);
        Ok(())
    }

    /// Updates the wanted signals to the present instant.
    #[inline(always)]
    pub(crate) fn refresh_signals(&mut self) {
        if !self.formation.all_linear {
            self.refresh_terms();
        }
        self.signals.refresh(&self.formation, &self.cores, &self.xi);
    }

    /// The wanted signals as last updated.
    #[inline(always)]
    pub(crate) fn signals(&self) -> &[L] {
        &self.signals.values
    }

    /// The signals at the note of the last interval (see [`crate::carry::carrier::Carrier::start`]).
    #[inline(always)]
    pub(crate) fn noted(&self) -> &[L] {
        &self.signals.noted
    }

    #[cold]
    fn refresh_terms(&mut self) {
        for (l, core) in self.cores.iter().enumerate().filter(|(_, core)| !core.flow().linear) {
            take_lane(&self.xi, l, &mut self.scratch);
            core.motion.fill_terms(&core.flow().equations, &mut self.scratch);
            put_lane(&mut self.xi, l, &self.scratch);
        }
    }

    /// Number `which` of the point at which the shapes of a contact touch; NaN without shapes.
    pub(crate) fn touch(&self, contact: usize, which: usize) -> L {
        L::from_fn(|l| {
            let profile = self.cores[l].motion.assembly().contacts[contact].profile.as_ref();
            profile.and_then(|profile| profile.touch_at(self.t_s)).map_or(f64::NAN, |touch| touch[which])
        })
    }

    /// 1 in lanes in which a contact pushes, 0 in the others.
    pub(crate) fn is_touching(&self, contact: usize) -> L {
        self.formation.touching[contact]
    }

    /// Compression of each contact of lane `l`, m, its rate, m/s, and its acceleration, m/s2 (without the
    /// part of nonlinear laws).
    pub(crate) fn compressions(&self, l: usize) -> Vec<[f64; 3]> {
        let mut xi = Vec::new();
        take_lane(&self.xi, l, &mut xi);
        let flow = self.cores[l].flow();
        let of = |[compression, rate]: &[Row; 2]| {
            [dot(compression, &xi), dot(rate, &xi), dot(&flow.slope(rate), &xi)]
        };
        flow.equations.compression.iter().map(of).collect()
    }

    /// The largest force of every stretch of contact of lane `l`, per contact; empty if peaks are not kept.
    pub(crate) fn peaks(&self, l: usize) -> Vec<Vec<Peak>> {
        let core = &self.cores[l];
        let Some(peaks) = &core.peaks else { return Vec::new() };
        (0..core.motion.assembly().contacts.len())
            .map(|i| peaks.of(i, self.peaks.get(i).map(|abreast| abreast.peak(l))))
            .collect()
    }

    /// Whether the energy ledger is kept.
    #[inline(always)]
    pub(crate) fn keeps_energy(&self) -> bool {
        self.cores[0].ledger.is_some()
    }

    /// Whether lane `l` has stopped because of the ledger.
    pub(crate) fn outpaces_ledger(&self, l: usize) -> bool {
        self.cores[l].outpaces_ledger
    }

    /// The energy balance of lane `l` with the works of `controllers`; `None` without a ledger.
    pub(crate) fn energy(&self, l: usize, controllers: &[String]) -> Option<EnergyBalance> {
        let core = &self.cores[l];
        let ledger = core.ledger.as_ref()?;
        let xi: Vec<f64> = self.xi.iter().map(|x| x.lane(l)).collect();
        Some(ledger.balance(&core.motion, core.flow(), &xi, controllers))
    }

    /// Strokes of all drives of all lanes, m.
    pub(crate) fn strokes(&self) -> Vec<Vec<f64>> {
        self.cores.iter().enumerate().map(|(l, core)| core.strokes(&self.xi, l)).collect()
    }

    /// Adds the work of each controller in lane `l` to the ledger, J.
    pub(crate) fn charge(&mut self, l: usize, works_j: impl Iterator<Item = f64>) {
        if let Some(ledger) = &mut self.cores[l].ledger {
            ledger.charge_controllers(works_j);
        }
    }
}

pub(super) fn take_lane<L: Lane>(xi: &[L], l: usize, out: &mut Vec<f64>) {
    out.clear();
    out.extend(xi.iter().map(|x| x.lane(l)));
}

pub(super) fn put_lane<L: Lane>(xi: &mut [L], l: usize, values: &[f64]) {
    for (x, &value) in xi.iter_mut().zip(values) {
        x.set_lane(l, value);
    }
}

impl LaneCore {
    /// Passes the peaks found in group travel to a lane that continues alone, and takes its new peaks back.
    pub(super) fn exchange_peaks<L: Lane, R>(
        &mut self,
        abreast: &mut [Abreast<L>],
        l: usize,
        go: impl FnOnce(&mut Self) -> R,
    ) -> R {
        if let Some(peaks) = &mut self.peaks {
            abreast.iter().enumerate().for_each(|(i, present)| present.give(peaks, i, l));
        }
        let result = go(self);
        if let Some(peaks) = &self.peaks {
            abreast.iter_mut().enumerate().for_each(|(i, present)| present.take(peaks, i, l));
        }
        result
    }

    /// Whether guides stick bodies to each other. (A body that sticks to ground is at rest by its own
    /// equations.)
    pub(super) fn joins_bodies(&self) -> bool {
        self.flow().equations.joined.iter().any(|(_, lead)| lead.is_some())
    }

    fn strokes<L: Lane>(&self, xi: &[L], l: usize) -> Vec<f64> {
        let stroke = |row: &Vec<f64>| row.iter().zip(xi).map(|(r, x)| r * x.lane(l)).sum();
        self.flow().equations.stroke.iter().map(|rows| stroke(&rows[0])).collect()
    }
}
