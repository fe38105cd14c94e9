//! A run: discrete instants in order, and the motion in between.

use std::collections::VecDeque;

use feeler_control::{Controller, Inputs};
use feeler_lanes::{Lane, LaneMask, dispatch};
use feeler_plant::motion::SwitchState;

use crate::clock::due;
use crate::drive::DriveChain;
use crate::error::{EngineError, RunEnd};
use crate::fixed_step::FixedStep;
use crate::lane::LaneCore;
use crate::ledger::EnergyBalance;
use crate::observer::Observer;
use crate::program::{Program, Recorded, Tapped};
use crate::scenario::Integrator;
use crate::sensing::Sensing;
use crate::taps::Tap;
use crate::transition::Transition;

/// Spans whose exponentials are kept; a span is worth one from its second appearance on.
const SPANS_KEPT: usize = 32;
/// Femtoseconds per second: spans are rounded to this grid, so that equal intervals share an exponential whatever the rounding of their ends.
const FEMTOSECONDS: f64 = 1e15;

/// One controller of every lane.
#[derive(Debug)]
struct Loop<L: Lane> {
    controller: Controller<L>,
    next_sample: u64,
    next_sample_s: f64,
    delay_s: f64,
    /// Outputs under way.
    pending: VecDeque<(f64, L)>,
    /// Output as applied, and the reference at the last sample.
    output: L,
    reference: L,
    reading: Option<(Tapped, Option<usize>)>,
    motion: Option<(Tapped, Option<usize>)>,
}

/// `L::WIDTH` variants of one scenario, run side by side.
#[derive(Debug)]
pub struct Simulation<L: Lane> {
    programs: Vec<Program>,
    lanes: Vec<LaneCore>,
    loops: Vec<Loop<L>>,
    drives: Vec<DriveChain<L>>,
    sensors: Vec<Sensing<L>>,
    taps: Vec<Tap<L>>,
    /// For each recorded reading of a delayed sensor its tap.
    record_taps: Vec<Option<usize>>,
    t_s: f64,
    next_record: u64,
    record_rate_hz: f64,
    /// Extended vector of every lane.
    xi: Vec<L>,
    product: Vec<L>,
    transitions: Vec<Transition<L>>,
    seen_spans: VecDeque<u64>,
    /// Values of the wanted signals.
    signals: Vec<L>,
    signal_rows: Vec<L>,
    signal_rows_for: Vec<usize>,
    fixed: Option<FixedStep<L>>,
    scratch: Vec<f64>,
    /// Steps taken: intervals, parts of them, or fixed steps.
    steps: u64,
}

impl<L: Lane> Simulation<L> {
    /// One variant per lane. All must share their structure and timing (periods, delays, offsets, jitter, record), and may differ in every other number.
    ///
    /// # Errors
    /// [`EngineError::Structure`] where they do not, and whatever the controllers or exponentials object to.
    pub fn new(programs: Vec<Program>) -> Result<Self, EngineError> {
        if programs.len() != L::WIDTH {
            return Err(EngineError::Lanes { given: programs.len(), lanes: L::WIDTH });
        }
        for (variant, program) in programs.iter().enumerate().skip(1) {
            if let Some(what) = programs[0].difference(program) {
                return Err(EngineError::Structure { variant, what });
            }
        }
        let first = &programs[0];
        let (energy, seed) = (first.run.energy, first.run.seed);
        let mut lanes = Vec::new();
        let mut states = Vec::new();
        for program in &programs {
            let (lane, state) = LaneCore::new(program.motion.clone(), program.wanted.clone(), energy)?;
            lanes.push(lane);
            states.push(state);
        }
        let xi = (0..states[0].len()).map(|i| L::from_fn(|l| states[l][i])).collect();
        let parts = |i: usize| programs.iter().map(|p| &p.motion.assembly().drives[i]).collect::<Vec<_>>();
        let drives = (0..first.motion.assembly().drives.len()).map(|i| DriveChain::new(&parts(i))).collect();
        let parts = |i: usize| programs.iter().map(|p| &p.motion.assembly().sensors[i]).collect::<Vec<_>>();
        let sensors: Vec<Sensing<L>> = (0..first.motion.assembly().sensors.len()).map(|i| Sensing::new(&parts(i), seed)).collect();
        let mut taps = Vec::new();
        let mut tap = |tapped: Tapped, first_s: f64| {
            let delay_s = sensors[tapped.sensor].delay_s;
            (delay_s > 0.0).then(|| {
                taps.push(Tap::new(tapped.signal, delay_s, first_s));
                taps.len() - 1
            })
        };
        let mut loops = Vec::new();
        for (i, (name, used)) in first.controllers.iter().enumerate() {
            let specs: Vec<_> = programs.iter().map(|program| program.controllers[i].spec.clone()).collect();
            let controller = Controller::new(&specs).map_err(|source| EngineError::Control { name: name.clone(), source })?;
            let wiring = &first.wiring[i];
            let next_sample_s = wiring.clock.sample_time_s(0);
            loops.push(Loop {
                controller,
                next_sample: 0,
                next_sample_s,
                delay_s: used.spec.delay_s,
                pending: VecDeque::new(),
                output: L::zero(),
                reference: L::zero(),
                reading: wiring.reading.map(|t| (t, tap(t, next_sample_s))),
                motion: wiring.motion.map(|t| (t, tap(t, next_sample_s))),
            });
        }
        let record_taps = (first.recorded.iter())
            .map(|recorded| match *recorded {
                Recorded::Reading(sensor, signal) => tap(Tapped { sensor, signal }, 0.0),
                _ => None,
            })
            .collect();
        let fixed = (first.run.integrator != Integrator::Exact).then(|| FixedStep::new(first.run.integrator, first.run.step_s, &lanes));
        let record_rate_hz = 1.0 / first.record_spacing_s();
        Ok(Self {
            lanes,
            loops,
            drives,
            sensors,
            taps,
            record_taps,
            t_s: 0.0,
            next_record: 0,
            record_rate_hz,
            xi,
            product: Vec::new(),
            transitions: Vec::new(),
            seen_spans: VecDeque::new(),
            signals: vec![L::zero(); first.wanted.len()],
            signal_rows: vec![L::zero(); first.wanted.len() * first.motion.layout().width()],
            signal_rows_for: vec![usize::MAX; L::WIDTH],
            fixed,
            scratch: Vec::new(),
            steps: 0,
            programs,
        })
    }

    /// Runs to the end of the scenario's duration.
    ///
    /// # Errors
    /// Only where the exponential of a mode cannot be computed; a motion that diverges is a result, see [`Self::end`].
    pub fn run(&mut self, observer: &mut impl Observer<L>) -> Result<(), EngineError> {
        let duration_s = self.programs[0].run.duration_s;
        self.run_to(duration_s, observer)
    }

    /// Runs on to `until_s`; instants due then are served. Ends at instants of the record or of samples leave no trace in the numbers; others change roundings.
    ///
    /// # Errors
    /// Those of [`Self::run`].
    pub fn run_to(&mut self, until_s: f64, observer: &mut impl Observer<L>) -> Result<(), EngineError> {
        loop {
            let instant_s = self.next_instant_s();
            // An end that falls on an instant is that instant: a run in slices then goes through the same spans as one run.
            let next_s = if due(instant_s, until_s) { instant_s } else { until_s };
            if !due(next_s, self.t_s) {
                self.propagate(next_s - self.t_s)?;
                self.t_s = next_s;
                for (l, lane) in self.lanes.iter_mut().enumerate() {
                    for event in lane.events.drain(..) {
                        observer.event(l, &event);
                    }
                }
            }
            if self.lanes.iter().all(LaneCore::has_ended) {
                return Ok(());
            }
            let served = self.serve(observer)?;
            if due(until_s, self.t_s) && !served {
                return Ok(());
            }
        }
    }

    /// Time reached, s.
    pub fn time_s(&self) -> f64 {
        self.t_s
    }

    /// How the run of a lane ended.
    pub fn end(&self, lane: usize) -> RunEnd {
        self.lanes[lane].end
    }

    /// Steps taken so far: intervals between instants and their parts, or fixed steps.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Replaces the state (positions, velocities, then drives and filters, as [`feeler_plant::motion::Layout`] numbers them) of a lane at the present time;
    /// what touches and what sticks follows from it, and the energy ledger starts anew.
    ///
    /// # Errors
    /// Where the exponential of the mode that the state is in cannot be computed.
    pub fn set_state(&mut self, lane: usize, state: &[f64]) -> Result<(), EngineError> {
        take_lane(&self.xi, lane, &mut self.scratch);
        let states = self.programs[lane].motion.layout().states().min(state.len());
        self.scratch[..states].copy_from_slice(&state[..states]);
        self.lanes[lane].begin_at(&mut self.scratch)?;
        put_lane(&mut self.xi, lane, &self.scratch);
        Ok(())
    }

    /// The state of a lane.
    pub fn state(&self, lane: usize) -> Vec<f64> {
        self.xi[..self.programs[lane].motion.layout().states()].iter().map(|x| x.lane(lane)).collect()
    }

    /// The energy balance of a lane, if the run keeps the ledger.
    pub fn energy(&self, lane: usize) -> Option<EnergyBalance> {
        let core = &self.lanes[lane];
        let ledger = core.ledger.as_ref()?;
        let xi: Vec<f64> = self.xi.iter().map(|x| x.lane(lane)).collect();
        let names: Vec<String> = self.programs[lane].controllers.keys().cloned().collect();
        Some(ledger.balance(&core.motion, core.flow(), &xi, &names))
    }

    fn next_instant_s(&self) -> f64 {
        let mut next = self.next_record as f64 / self.record_rate_hz;
        if self.programs[0].recorded.is_empty() {
            next = f64::INFINITY;
        }
        for control in &self.loops {
            next = next.min(control.next_sample_s);
            if let Some((t, _)) = control.pending.front() {
                next = next.min(*t);
            }
        }
        for drive in &self.drives {
            next = next.min(drive.next_arrival_s());
        }
        self.taps.iter().fold(next, |next, tap| next.min(tap.next_s))
    }

    /// Serves every instant that is due: delayed readings, samples, arrivals, record. Gives whether there was one.
    fn serve(&mut self, observer: &mut impl Observer<L>) -> Result<bool, EngineError> {
        let t = self.t_s;
        if !due(self.next_instant_s(), t) {
            return Ok(false);
        }
        self.refresh_signals();
        self.take_taps();
        for i in 0..self.loops.len() {
            while due(self.loops[i].next_sample_s, t) {
                self.sample(i)?;
            }
        }
        let recorded = due(self.next_record as f64 / self.record_rate_hz, t) && !self.programs[0].recorded.is_empty();
        let mut values = if recorded { self.plant_record() } else { Vec::new() };
        self.arrivals()?;
        if recorded {
            self.command_record(&mut values);
            observer.record(t, &values);
            self.next_record += 1;
        }
        Ok(true)
    }

    fn take_taps(&mut self) {
        let t = self.t_s;
        for (i, control) in self.loops.iter().enumerate() {
            let clock = &self.programs[0].wiring[i].clock;
            for tap in [control.reading, control.motion].into_iter().flatten().filter_map(|(_, tap)| tap) {
                let value = self.signals[self.taps[tap].signal];
                self.taps[tap].take(t, value, |k| clock.sample_time_s(k));
            }
        }
        let rate_hz = self.record_rate_hz;
        for &tap in self.record_taps.iter().flatten() {
            let value = self.signals[self.taps[tap].signal];
            self.taps[tap].take(t, value, |k| k as f64 / rate_hz);
        }
    }

    fn read(&mut self, tapped: Tapped, tap: Option<usize>) -> L {
        let signal = tap.map_or(self.signals[tapped.signal], |tap| self.taps[tap].pop());
        self.sensors[tapped.sensor].read(self.t_s, signal)
    }

    fn sample(&mut self, i: usize) -> Result<(), EngineError> {
        let reading = self.loops[i].reading.map(|(tapped, tap)| self.read(tapped, tap));
        let motion = self.loops[i].motion.map(|(tapped, tap)| self.read(tapped, tap));
        let wiring = &self.programs[0].wiring[i];
        let inputs = Inputs {
            reading: reading.unwrap_or_else(L::zero),
            motion: motion.unwrap_or_else(L::zero),
            motion_is_velocity: wiring.motion_is_velocity,
        };
        let sample_s = self.loops[i].next_sample_s;
        let reference = L::from_fn(|l| self.programs[l].wiring[i].reference.value(sample_s));
        let control = &mut self.loops[i];
        let controller = &mut control.controller;
        let output = dispatch(
            #[inline(always)]
            || controller.sample(sample_s, &inputs, reference),
        );
        control.reference = reference;
        control.next_sample += 1;
        control.next_sample_s = wiring.clock.sample_time_s(control.next_sample);
        if control.delay_s > 0.0 {
            control.pending.push_back((sample_s + control.delay_s, output));
            return Ok(());
        }
        self.apply(i, output)
    }

    /// Outputs and delayed commands that arrive now.
    fn arrivals(&mut self) -> Result<(), EngineError> {
        for i in 0..self.loops.len() {
            while let Some(&(at, output)) = self.loops[i].pending.front()
                && due(at, self.t_s)
            {
                self.loops[i].pending.pop_front();
                self.apply(i, output)?;
            }
        }
        for i in 0..self.drives.len() {
            while due(self.drives[i].next_arrival_s(), self.t_s) {
                if let Some(input) = self.drives[i].arrive() {
                    self.set_input(i, input)?;
                }
            }
        }
        Ok(())
    }

    /// Output of controller `i` takes effect; controllers on one drive add.
    fn apply(&mut self, i: usize, output: L) -> Result<(), EngineError> {
        self.loops[i].output = output;
        let drive = self.programs[0].wiring[i].drive;
        let mut command = L::zero();
        for (control, wiring) in self.loops.iter().zip(&self.programs[0].wiring) {
            if wiring.drive == drive {
                command += control.output;
            }
        }
        match self.drives[drive].issue(self.t_s, command) {
            Some(input) => self.set_input(drive, input),
            None => Ok(()),
        }
    }

    fn set_input(&mut self, drive: usize, input: L) -> Result<(), EngineError> {
        let layout = self.programs[0].motion.layout();
        if layout.ramp(drive).is_none() {
            self.xi[layout.input(drive)] = input;
            return Ok(());
        }
        for l in 0..L::WIDTH {
            take_lane(&self.xi, l, &mut self.scratch);
            self.lanes[l].set_input(drive, input.lane(l), &mut self.scratch)?;
            put_lane(&mut self.xi, l, &self.scratch);
        }
        Ok(())
    }

    /// Brings the wanted signals up to date.
    fn refresh_signals(&mut self) {
        let width = self.xi.len();
        for (l, lane) in self.lanes.iter().enumerate() {
            let flow = lane.flow();
            if !flow.linear {
                take_lane(&self.xi, l, &mut self.scratch);
                crate::extrapolation::fill_terms(&lane.motion, flow, &mut self.scratch);
                put_lane(&mut self.xi, l, &self.scratch);
            }
            if self.signal_rows_for[l] != lane.current {
                self.signal_rows_for[l] = lane.current;
                for (rows, row) in self.signal_rows.chunks_exact_mut(width).zip(&flow.signals) {
                    for (j, entry) in rows.iter_mut().enumerate() {
                        entry.set_lane(l, row.as_ref().map_or(0.0, |row| row[j]));
                    }
                }
            }
        }
        let (signals, rows, xi) = (&mut self.signals, &self.signal_rows, &self.xi);
        dispatch(
            #[inline(always)]
            || {
                for (signal, row) in signals.iter_mut().zip(rows.chunks_exact(width)) {
                    let mut sum = L::zero();
                    for (&r, &x) in row.iter().zip(xi) {
                        sum = r.mul_add(x, sum);
                    }
                    *signal = sum;
                }
            },
        );
    }

    fn plant_record(&mut self) -> Vec<L> {
        let recorded = self.programs[0].recorded.clone();
        let taps = self.record_taps.clone();
        let value = |(recorded, tap): (&Recorded, &Option<usize>)| match *recorded {
            Recorded::Plant(i) => self.signals[i],
            Recorded::Reading(sensor, signal) => self.read(Tapped { sensor, signal }, *tap),
            Recorded::Touching(i) => L::from_fn(|l| f64::from(u8::from(self.lanes[l].touches(i)))),
            Recorded::Command(_) | Recorded::Output(_) | Recorded::Reference(_) => L::zero(),
        };
        recorded.iter().zip(&taps).map(value).collect()
    }

    fn command_record(&self, values: &mut [L]) {
        for (value, recorded) in values.iter_mut().zip(&self.programs[0].recorded) {
            match *recorded {
                Recorded::Command(i) => *value = self.drives[i].command,
                Recorded::Output(i) => *value = self.loops[i].output,
                Recorded::Reference(i) => *value = self.loops[i].reference,
                _ => {}
            }
            for (l, lane) in self.lanes.iter().enumerate().filter(|(_, lane)| lane.has_ended()) {
                debug_assert!(lane.has_ended());
                value.set_lane(l, f64::NAN);
            }
        }
    }

    /// Carries every lane over `span_s`.
    fn propagate(&mut self, span_s: f64) -> Result<(), EngineError> {
        if self.fixed.is_some() {
            return self.fixed_steps(span_s);
        }
        let strokes = self.strokes();
        let span_fs = (span_s * FEMTOSECONDS).round() as u64;
        let alone = self.lanes[0].ledger.is_some();
        if let Some(index) = (!alone).then(|| self.transition_index(span_fs)).flatten() {
            self.travel(index)?;
        } else {
            self.steps += 1;
            for l in 0..L::WIDTH {
                self.go_alone(l, self.t_s, span_s)?;
            }
        }
        self.charge_controllers(&strokes);
        Ok(())
    }

    fn fixed_steps(&mut self, span_s: f64) -> Result<(), EngineError> {
        let Some(mut fixed) = self.fixed.take() else { return Ok(()) };
        let strokes = self.strokes();
        let result = fixed.run(&mut self.lanes, &mut self.xi, self.t_s, span_s);
        self.fixed = Some(fixed);
        self.steps += result?;
        self.charge_controllers(&strokes);
        Ok(())
    }

    /// The transition for a span that has been seen before.
    fn transition_index(&mut self, span_fs: u64) -> Option<usize> {
        if let Some(i) = self.transitions.iter().position(|transition| transition.span_fs == span_fs) {
            return Some(i);
        }
        if span_fs == 0 || self.transitions.len() == SPANS_KEPT {
            return None;
        }
        if !self.seen_spans.contains(&span_fs) {
            self.seen_spans.push_back(span_fs);
            if self.seen_spans.len() > SPANS_KEPT {
                self.seen_spans.pop_front();
            }
            return None;
        }
        self.transitions.push(Transition::new(span_fs, &self.lanes));
        Some(self.transitions.len() - 1)
    }

    /// All lanes together, by the exponential of the span; those that meet an event go on alone.
    fn travel(&mut self, index: usize) -> Result<(), EngineError> {
        self.transitions[index].refresh(&mut self.lanes)?;
        let span_s = self.transitions[index].span_fs as f64 / FEMTOSECONDS;
        let mut travelling = L::Mask::from_fn(|l| self.lanes[l].flow().linear && !self.lanes[l].has_ended());
        for l in (0..L::WIDTH).filter(|&l| !travelling.test(l)) {
            self.go_alone(l, self.t_s, span_s)?;
        }
        let transition = &self.transitions[index];
        self.product.resize(transition.len(), L::zero());
        let most = (0..L::WIDTH).map(|l| transition.parts[l]).max().unwrap_or(1);
        for part in 0..most {
            let here = travelling & L::Mask::from_fn(|l| part < transition.parts[l]);
            if !here.any() {
                break;
            }
            self.steps += 1;
            let (xi, product) = (&mut self.xi, &mut self.product);
            let stopped = dispatch(
                #[inline(always)]
                || transition.step(here, xi, product),
            );
            if stopped.any() {
                for l in (0..L::WIDTH).filter(|&l| stopped.test(l)) {
                    let gone_s = span_s * part as f64 / transition.parts[l] as f64;
                    take_lane(&self.xi, l, &mut self.scratch);
                    self.lanes[l].advance(&mut self.scratch, self.t_s + gone_s, span_s - gone_s)?;
                    put_lane(&mut self.xi, l, &self.scratch);
                }
                travelling = travelling & !stopped;
            }
        }
        self.settle(travelling);
        Ok(())
    }

    /// After a shared step: joins what sticks together, and ends lanes whose state has left all bounds.
    fn settle(&mut self, travelled: L::Mask) {
        let states = self.programs[0].motion.layout().states();
        let mut size = L::zero();
        for x in &self.xi[..states] {
            size += x.abs();
        }
        let fine = size.lt(L::splat(LaneCore::BOUND));
        for l in (0..L::WIDTH).filter(|&l| travelled.test(l)) {
            if !fine.test(l) {
                self.lanes[l].end = RunEnd::Diverged { t_s: self.t_s };
            }
            if self.lanes[l].flow().equations.stuck.iter().any(|pair| pair.iter().all(Option::is_some)) {
                take_lane(&self.xi, l, &mut self.scratch);
                self.lanes[l].join(&mut self.scratch);
                put_lane(&mut self.xi, l, &self.scratch);
            }
        }
    }

    fn go_alone(&mut self, l: usize, t_s: f64, span_s: f64) -> Result<(), EngineError> {
        take_lane(&self.xi, l, &mut self.scratch);
        self.lanes[l].advance(&mut self.scratch, t_s, span_s)?;
        put_lane(&mut self.xi, l, &self.scratch);
        Ok(())
    }

    /// Strokes of all drives before an interval, where the ledger needs them.
    fn strokes(&self) -> Vec<Vec<f64>> {
        if self.lanes[0].ledger.is_none() {
            return Vec::new();
        }
        self.lanes.iter().enumerate().map(|(l, lane)| lane.strokes(&self.xi, l)).collect()
    }

    /// Charges each controller with its command times the stroke of the interval.
    fn charge_controllers(&mut self, before: &[Vec<f64>]) {
        for (l, before) in before.iter().enumerate() {
            let after = self.lanes[l].strokes(&self.xi, l);
            let programs = &self.programs[0];
            let works = self.loops.iter().zip(&programs.wiring).map(|(control, wiring)| {
                let is_force = programs.motion.assembly().drives[wiring.drive].velocity_source.is_none();
                if is_force { control.output.lane(l) * (after[wiring.drive] - before[wiring.drive]) } else { 0.0 }
            });
            if let Some(ledger) = &mut self.lanes[l].ledger {
                ledger.charge_controllers(works);
            }
        }
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

impl LaneCore {
    /// Whether contact `i` pushes (or is clamped).
    pub(crate) fn touches(&self, i: usize) -> bool {
        use feeler_plant::description::Engagement;
        use feeler_plant::motion::Switch;
        match self.motion.assembly().contacts[i].engagement {
            Engagement::Clamped => true,
            Engagement::Free => false,
            Engagement::Unilateral => {
                let mode = self.flow().equations.mode;
                let switch = self.motion.switches().iter().position(|&s| s == Switch::Contact(i));
                switch.is_some_and(|s| mode.get(s) == SwitchState::Plus)
            }
        }
    }

    fn strokes<L: Lane>(&self, xi: &[L], l: usize) -> Vec<f64> {
        let stroke = |row: &Vec<f64>| row.iter().zip(xi).map(|(r, x)| r * x.lane(l)).sum();
        self.flow().equations.stroke.iter().map(|rows| stroke(&rows[0])).collect()
    }
}
