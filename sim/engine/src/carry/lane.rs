//! One variant on its own: the modes it has met, and its motion through events.
//!
//! Lanes travel together between events; whichever meets one goes through it here, alone, and joins the
//! others at the end of the interval.

use feeler_plant::assembly::Source;
use feeler_plant::motion::{GuardValue, Mode, Motion, StopSide, Switch, SwitchState, dot};

use crate::carry::ledger::{EnergyLedger, GAUSS_NODES};
use crate::carry::peaks::Peaks;
use crate::error::{EngineError, RunEnd};
use crate::observe::event::{Event, EventKind};
use crate::solve::crossing::Look;
use crate::solve::extrapolation::Extrapolation;
use crate::solve::flow::Flow;
use crate::solve::taylor::Series;

/// Events at one instant after which time is pushed on a little: rounding may leave two modes each asking for
/// the other.
const EVENTS_BEFORE_PUSH: usize = 4;
/// The first push, s; each further event at the instant doubles it.
const PUSH_S: f64 = 1e-13;
/// Events at one instant after which the run is given up.
const EVENTS_BEFORE_STORM: usize = 60;
/// More events than this within [`STORM_S`] are a storm, too.
const MOST_EVENTS: usize = 1000;
/// A nanosecond for each: thousands of times shorter than the period of the fastest machine.
const STORM_S: f64 = 1e-6;
/// Span of one polynomial over its longest while the ledger is kept: powers oscillate twice as fast as the
/// motion, and eight nodes then integrate them to rounding.
const LEDGER_SHARE: f64 = 1.0 / 3.0;

/// One variant.
#[derive(Debug)]
pub(crate) struct LaneCore {
    pub(crate) motion: Motion,
    wanted: Vec<Source>,
    flows: Vec<Flow>,
    /// Index of the current flow.
    pub(crate) current: usize,
    pub(crate) events: Vec<Event>,
    /// When a span of [`STORM_S`] began, and the events in it.
    recent: (f64, usize),
    pub(crate) ledger: Option<EnergyLedger>,
    pub(crate) peaks: Option<Peaks>,
    pub(crate) end: RunEnd,
    series: Series,
    extrapolation: Extrapolation,
}

impl LaneCore {
    /// Any state beyond this has diverged.
    pub(crate) const BOUND: f64 = 1e12;

    /// A variant at its start: the machine's initial state, and the mode it is in.
    pub(crate) fn new(
        motion: Motion,
        wanted: Vec<Source>,
        energy: bool,
        peaks: bool,
    ) -> Result<(Self, Vec<f64>), EngineError> {
        let mut xi = motion.initial_state();
        xi.resize(motion.layout().width(), 0.0);
        xi[motion.layout().one()] = 1.0;
        let contacts = motion.assembly().contacts.len();
        let mut lane = Self {
            motion,
            wanted,
            flows: Vec::new(),
            current: 0,
            events: Vec::new(),
            recent: (0.0, 0),
            ledger: energy.then(EnergyLedger::default),
            peaks: peaks.then(|| Peaks::new(contacts)),
            end: RunEnd::Completed,
            series: Series::default(),
            extrapolation: Extrapolation::default(),
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

    pub(crate) fn has_ended(&self) -> bool {
        self.end != RunEnd::Completed
    }

    /// Enters the mode that a state which was not reached by motion is in; limits and ramps are as in `old`.
    fn enter_initial_mode(&mut self, old: Mode, xi: &mut [f64], t_s: f64) -> Result<(), EngineError> {
        let equations = self.motion.equations(Mode::default());
        let value = |row: &[f64]| dot(row, xi);
        let mut mode = Mode::default();
        for (i, &switch) in self.motion.switches().iter().enumerate() {
            let state = match switch {
                Switch::Contact(c) => side(value(&equations.compression[c][0]) > 0.0),
                Switch::Stop(link, stop) => {
                    let e = value(&equations.elongation[link][0]);
                    let half = 0.5 * self.motion.assembly().links[link].play;
                    side(if stop == StopSide::Upper { e > half } else { -e > half })
                }
                Switch::Friction(link) => match value(&equations.elongation[link][1]) {
                    v if v > 0.0 => SwitchState::Plus,
                    v if v < 0.0 => SwitchState::Minus,
                    _ => SwitchState::Rest,
                },
                Switch::Limit(_) | Switch::Ramp(_) => old.get(i),
            };
            mode = mode.with(i, state);
        }
        self.enter(mode)?;
        self.motion.fill_terms(&self.flows[self.current].equations, xi);
        let pressed = self.current;
        // What is compressed, but comes apart faster than its law pushes, does not pull. One side's force is
        // nothing to another's, so once round is all.
        let mut parting = Vec::new();
        for guard in &self.flow().equations.guards {
            let switch = self.motion.switches()[guard.switch];
            if matches!(switch, Switch::Contact(_) | Switch::Stop(..))
                && guard.value == GuardValue::To(SwitchState::Minus)
                && dot(&guard.row, xi) < 0.0
            {
                mode = mode.with(guard.switch, SwitchState::Minus);
                parting.push(switch);
            }
        }
        self.enter(mode)?;
        self.motion.fill_terms(&self.flows[self.current].equations, xi);
        if let Some(ledger) = &mut self.ledger {
            ledger.begin(&self.motion, &self.flows[pressed], xi);
            for switch in parting {
                ledger.switch(&self.motion, [pressed, self.current].map(|i| &self.flows[i]), switch, xi);
            }
        }
        if let Some(peaks) = &mut self.peaks {
            peaks.enter(&self.flows[self.current], xi, t_s);
        }
        Ok(())
    }

    /// Begins anew at a state that was not reached by motion: what touches, sticks and slides there is looked
    /// up, and the ledger starts again.
    pub(crate) fn begin_at(&mut self, xi: &mut [f64], t_s: f64) -> Result<(), EngineError> {
        let old = self.flow().equations.mode;
        self.enter_initial_mode(old, xi, t_s)
    }

    /// Makes `mode` the current one.
    fn enter(&mut self, mode: Mode) -> Result<(), EngineError> {
        self.current = self.index_of(mode)?;
        Ok(())
    }

    fn index_of(&mut self, mode: Mode) -> Result<usize, EngineError> {
        if let Some(i) = self.flows.iter().position(|flow| flow.equations.mode == mode) {
            return Ok(i);
        }
        self.flows.push(Flow::new(
            &self.motion,
            mode,
            &self.wanted,
            self.ledger.is_some(),
            self.peaks.is_some(),
        )?);
        Ok(self.flows.len() - 1)
    }

    /// Gives drive `i` a new input. Where the drive's rate is limited it starts to ramp there.
    pub(crate) fn set_input(&mut self, i: usize, value: f64, xi: &mut [f64]) -> Result<(), EngineError> {
        xi[self.motion.layout().input(i)] = value;
        if let Some(ramp) = self.motion.layout().ramp(i)
            && let Some(switch) = self.motion.switches().iter().position(|&s| s == Switch::Ramp(i))
        {
            let left = value - xi[ramp];
            let state = match left {
                l if l > 0.0 => SwitchState::Plus,
                l if l < 0.0 => SwitchState::Minus,
                _ => SwitchState::Rest,
            };
            let mode = self.flow().equations.mode.with(switch, state);
            self.enter(mode)?;
        }
        Ok(())
    }

    /// Moves `xi` from `t_s` on by `span_s`, through every event on the way.
    pub(crate) fn advance(&mut self, xi: &mut [f64], t_s: f64, span_s: f64) -> Result<(), EngineError> {
        let mut elapsed = 0.0;
        let mut at_instant = 0;
        let mut just_switched = false;
        while elapsed < span_s && !self.has_ended() {
            let remaining = span_s - elapsed;
            // A push looks at no guard, so one is followed by a look.
            let push = (just_switched && at_instant >= EVENTS_BEFORE_PUSH)
                .then(|| PUSH_S * f64::from(1_u32 << (at_instant - EVENTS_BEFORE_PUSH).min(20)));
            let (moved, event) = if self.flow().linear {
                self.linear_leg(xi, t_s + elapsed, remaining, push)
            } else {
                self.nonlinear_leg(xi, t_s + elapsed, remaining, push)
            };
            if push.is_none() && moved > 10.0 * PUSH_S {
                at_instant = 0;
            }
            just_switched = event.is_some();
            elapsed += moved;
            // What is left is less than the clock can tell.
            if span_s - elapsed <= f64::EPSILON * (t_s + span_s) {
                elapsed = span_s;
            }
            if let Some(guard) = event {
                at_instant += 1;
                self.switch(guard, xi, t_s + elapsed)?;
                if at_instant > EVENTS_BEFORE_STORM || self.are_too_many(t_s + elapsed) {
                    self.end = RunEnd::EventStorm { t_s: t_s + elapsed };
                }
            }
            // A leg that goes nowhere has found no numbers to go to.
            if (event.is_none() && moved <= 0.0) || xi.iter().any(|x| x.is_nan() || x.abs() > Self::BOUND) {
                self.end = RunEnd::Diverged { t_s: t_s + elapsed };
            }
        }
        Ok(())
    }

    /// Counts an event; whether there are more than any machine has.
    fn are_too_many(&mut self, t_s: f64) -> bool {
        if (t_s - self.recent.0).abs() > STORM_S {
            self.recent = (t_s, 0);
        }
        self.recent.1 += 1;
        self.recent.1 > MOST_EVENTS
    }

    /// One polynomial of a linear mode: how far it went, and the guard that ended it.
    fn linear_leg(
        &mut self,
        xi: &mut [f64],
        t_s: f64,
        remaining: f64,
        push: Option<f64>,
    ) -> (f64, Option<usize>) {
        let flow = &self.flows[self.current];
        let reach = if self.ledger.is_some() { flow.horizon_s * LEDGER_SHARE } else { flow.horizon_s };
        let mut h = push.map_or(reach, |push| push.min(reach)).min(remaining);
        self.series.expand(flow, xi, h);
        let mut event = None;
        if push.is_none() {
            for (i, guard) in flow.equations.guards.iter().enumerate() {
                let polynomial = self.series.functional(&guard.row, xi, flow.width);
                if let Some(s) = polynomial.first_crossing(h, || flow.slope_size(&guard.row, xi))
                    && (event.is_none() || s < h)
                {
                    h = s;
                    event = Some(i);
                }
            }
        }
        if let Some(ledger) = &mut self.ledger {
            let mut node = xi.to_vec();
            for (position, weight) in GAUSS_NODES {
                self.series.evaluate(position * h, &mut node);
                ledger.add_powers(&flow.ledger, &node, weight * h);
            }
        }
        if let Some(peaks) = &mut self.peaks {
            peaks.linear_leg(flow, &self.series, xi, t_s, h);
        }
        self.series.evaluate(h, xi);
        self.join(xi);
        (h, event)
    }

    /// One step of a nonlinear mode.
    fn nonlinear_leg(
        &mut self,
        xi: &mut [f64],
        t_s: f64,
        remaining: f64,
        push: Option<f64>,
    ) -> (f64, Option<usize>) {
        let flow = &self.flows[self.current];
        self.motion.fill_terms(&flow.equations, xi);
        let mut none = Vec::new();
        let span = push.map_or(flow.horizon_s, |push| push.min(flow.horizon_s)).min(remaining);
        let start = xi.to_vec();
        let meters = self.ledger.as_mut().map_or(&mut none, |ledger| &mut ledger.meters);
        let before = meters.clone();
        let Some(mut h) = self.extrapolation.step(&self.motion, flow, xi, meters, span) else {
            return (0.0, None);
        };
        let mut event = None;
        if push.is_none() {
            let mut end = xi.to_vec();
            for (i, guard) in flow.equations.guards.iter().enumerate() {
                let look = Look { motion: &self.motion, flow, start: &start, row: &guard.row };
                if let Some(s) = look.first_crossing(&mut self.extrapolation, &end, h)
                    && (event.is_none() || s < h)
                {
                    h = s;
                    event = Some(i);
                    // The guards that follow are looked at up to there, no further: beyond it the mode may go
                    // where no machine does.
                    let Some(state) = look.at(&mut self.extrapolation, h) else { return (0.0, None) };
                    end = state;
                }
            }
        }
        if event.is_some() {
            xi.copy_from_slice(&start);
            meters.copy_from_slice(&before);
            let mut reached = 0.0;
            while reached < h {
                let Some(part) = self.extrapolation.step(&self.motion, flow, xi, meters, h - reached) else {
                    return (0.0, None);
                };
                reached += part;
            }
        }
        if let Some(peaks) = &mut self.peaks {
            peaks.nonlinear_leg(&self.motion, flow, &mut self.extrapolation, [&start, xi], t_s, h);
        }
        self.join(xi);
        (h, event)
    }

    /// Notes the contact forces at the end of a fixed step.
    pub(crate) fn note_peaks(&mut self, xi: &[f64], t_s: f64) {
        if let Some(peaks) = &mut self.peaks {
            peaks.enter(&self.flows[self.current], xi, t_s);
        }
    }

    /// Looks where a span of the present mode, travelled in one go from `xi` on, crests; `xi` is moved.
    pub(crate) fn crest(&mut self, xi: &mut [f64], t_s: f64, span_fs: u64) -> Result<(), EngineError> {
        match &mut self.peaks {
            Some(peaks) => peaks.crest(&mut self.flows[self.current], &mut self.series, xi, t_s, span_fs),
            None => Ok(()),
        }
    }

    /// Makes speeds that stick together equal to the bit.
    pub(crate) fn join(&self, xi: &mut [f64]) {
        let v = |g| self.motion.layout().v(g);
        for &(member, lead) in &self.flow().joined {
            xi[v(member)] = lead.map_or(0.0, |lead| xi[v(lead)]);
        }
    }

    /// What happens when guard `index` of the current mode is crossed.
    pub(crate) fn switch(&mut self, index: usize, xi: &mut [f64], t_s: f64) -> Result<(), EngineError> {
        let guard = self.flow().equations.guards[index].clone();
        let old = self.current;
        let mode = self.flow().equations.mode;
        let from = mode.get(guard.switch);
        let to = match guard.value {
            GuardValue::To(state) => state,
            GuardValue::Stop => self.after_stop(mode, guard.switch, xi)?,
        };
        let what = self.motion.switches()[guard.switch];
        if let (Switch::Ramp(i), Some(ramp)) = (what, self.ramp_of(what)) {
            xi[ramp] = xi[self.motion.layout().input(i)];
        }
        // A fixed step goes beyond the limit before it is seen to be reached; held there, the force would
        // never be within it again.
        if let (Switch::Limit(i), SwitchState::Plus | SwitchState::Minus) = (what, to)
            && let Some(force) = self.motion.layout().force(i)
        {
            let limit = self.motion.assembly().drives[i].limit;
            xi[force] = if to == SwitchState::Plus { limit } else { -limit };
        }
        self.enter(mode.with(guard.switch, to))?;
        self.join(xi);
        self.motion.fill_terms(&self.flows[self.current].equations, xi);
        if let Some(ledger) = &mut self.ledger {
            ledger.switch(&self.motion, [old, self.current].map(|i| &self.flows[i]), what, xi);
        }
        if let Some(peaks) = &mut self.peaks {
            peaks.enter(&self.flows[self.current], xi, t_s);
        }
        if let Some(kind) = EventKind::of(what, from, to) {
            self.events.push(Event { t_s, kind, switch: what });
        }
        Ok(())
    }

    /// Where a fixed step has carried a sliding guide past rest, puts it at rest.
    pub(crate) fn stop_exactly(&self, guard: usize, xi: &mut [f64]) {
        let guard = &self.flow().equations.guards[guard];
        if let (GuardValue::Stop, Switch::Friction(link)) =
            (guard.value, self.motion.switches()[guard.switch])
        {
            let link = &self.motion.assembly().links[link];
            let of = |node| self.motion.coordinates().of(node);
            let layout = self.motion.layout();
            match (of(link.a), of(link.b)) {
                (Some(a), Some(b)) => {
                    // The joint speed that keeps the momentum.
                    let (ma, mb) =
                        (self.motion.coordinates().mass_kg(a), self.motion.coordinates().mass_kg(b));
                    let joint = (ma * xi[layout.v(a)] + mb * xi[layout.v(b)]) / (ma + mb);
                    xi[layout.v(a)] = joint;
                    xi[layout.v(b)] = joint;
                }
                (Some(g), None) | (None, Some(g)) => xi[layout.v(g)] = 0.0,
                (None, None) => {}
            }
        }
    }

    fn ramp_of(&self, switch: Switch) -> Option<usize> {
        match switch {
            Switch::Ramp(i) => self.motion.layout().ramp(i),
            _ => None,
        }
    }

    /// A guide has come to rest: whether it sticks, or slides on the other way.
    fn after_stop(&mut self, mode: Mode, switch: usize, xi: &mut [f64]) -> Result<SwitchState, EngineError> {
        let index = self.index_of(mode.with(switch, SwitchState::Rest))?;
        let flow = &self.flows[index];
        let mut rested = xi.to_vec();
        self.motion.fill_terms(&flow.equations, &mut rested);
        let exceeded = flow
            .equations
            .guards
            .iter()
            .find(|guard| guard.switch == switch && dot(&guard.row, &rested) < 0.0);
        Ok(match exceeded.map(|guard| guard.value) {
            Some(GuardValue::To(state)) => state,
            _ => SwitchState::Rest,
        })
    }
}

fn side(closed: bool) -> SwitchState {
    if closed { SwitchState::Plus } else { SwitchState::Rest }
}
