//! A machine in motion: modes, events and inputs, one record at a time.

use feeler_plant::assembly::{Assembly, Source};
use feeler_plant::motion::{GuardValue, Mode, Motion, StopSide, Switch, SwitchState};

use super::flow::{Flow, dot};
use crate::error::DiagnosisError;

/// Events within one row after which the row is finished without looking at guards: a modelled clatter faster
/// than the record can show.
const MOST_EVENTS: usize = 12;
/// Secant steps that place an event; each is exact to the next, and rows are short against the motion.
const SECANT_STEPS: usize = 3;
/// A remainder of a row below this share is rounding.
const SLIVER: f64 = 1e-9;

/// Where a machine is, and in which mode.
#[derive(Clone, Debug)]
pub(super) struct State {
    pub(super) xi: Vec<f64>,
    pub(super) flow: usize,
}

/// A machine with the modes it has met.
#[derive(Debug)]
pub(super) struct Moving {
    pub(super) motion: Motion,
    channels: Vec<Source>,
    /// Spacing of rows.
    spacing_s: f64,
    pub(super) flows: Vec<Flow>,
    next: Vec<f64>,
    probe: Vec<f64>,
}

impl Moving {
    pub(super) fn new(
        mut assembly: Assembly,
        channels: Vec<Source>,
        spacing_s: f64,
    ) -> Result<Self, DiagnosisError> {
        // A feed is not in the dataset: when it began, relative to a record, nobody knows.
        for contact in &mut assembly.contacts {
            contact.profile = None;
        }
        let motion = Motion::new(assembly).map_err(|problems| DiagnosisError::Machine { problems })?;
        Ok(Self { motion, channels, spacing_s, flows: Vec::new(), next: Vec::new(), probe: Vec::new() })
    }

    /// The state at the start, filters at rest.
    pub(super) fn start(&mut self) -> State {
        let layout = self.motion.layout();
        let mut xi = self.motion.initial_state();
        xi.resize(layout.width(), 0.0);
        xi[layout.one()] = 1.0;
        let mode = self.natural_mode(&xi);
        let flow = self.flow_of(mode);
        let mut state = State { xi, flow };
        self.fill(&mut state);
        self.motion.settle_filters(&self.flows[flow].equations, &mut state.xi);
        state
    }

    /// The mode that positions and speeds ask for.
    fn natural_mode(&self, xi: &[f64]) -> Mode {
        let equations = self.motion.equations(Mode::default());
        let mut mode = Mode::default();
        for (i, &switch) in self.motion.switches().iter().enumerate() {
            let closed = |yes: bool| if yes { SwitchState::Plus } else { SwitchState::Rest };
            let state = match switch {
                Switch::Contact(c) => closed(dot(&equations.compression[c][0], xi) > 0.0),
                Switch::Stop(link, side) => {
                    let e = dot(&equations.elongation[link][0], xi);
                    let half = 0.5 * self.motion.assembly().links[link].play;
                    closed(if side == StopSide::Upper { e > half } else { -e > half })
                }
                Switch::Friction(link) => match dot(&equations.elongation[link][1], xi) {
                    v if v > 0.0 => SwitchState::Plus,
                    v if v < 0.0 => SwitchState::Minus,
                    _ => SwitchState::Rest,
                },
                Switch::Limit(_) | Switch::Ramp(_) => SwitchState::Rest,
            };
            mode = mode.with(i, state);
        }
        mode
    }

    pub(super) fn flow_of(&mut self, mode: Mode) -> usize {
        if let Some(i) = self.flows.iter().position(|flow| flow.equations.mode == mode) {
            return i;
        }
        self.flows.push(Flow::new(&self.motion, mode, &self.channels, self.spacing_s));
        self.flows.len() - 1
    }

    /// Brings the nonlinear terms up to date. Earlier terms may be arguments of later ones.
    pub(super) fn fill(&self, state: &mut State) {
        let flow = &self.flows[state.flow];
        if flow.linear {
            return;
        }
        for (j, (term, arguments)) in self.motion.terms().iter().zip(&flow.equations.arguments).enumerate() {
            let value =
                arguments.as_ref().map_or(0.0, |[a, b]| term.value(dot(a, &state.xi), dot(b, &state.xi)));
            state.xi[self.motion.layout().term(j)] = value;
        }
    }

    /// The channels as the plant has them, before gains, delays and quantisation, then what else is looked at
    /// in every row.
    #[inline(always)]
    pub(super) fn look(&self, state: &State, out: &mut Vec<f64>) {
        self.flows[state.flow].look(&state.xi, out);
    }

    /// Gives a drive a new input; where its rate is limited it starts to ramp there.
    pub(super) fn set_input(&mut self, state: &mut State, drive: usize, value: f64) {
        state.xi[self.motion.layout().input(drive)] = value;
        let Some(ramp) = self.motion.layout().ramp(drive) else { return };
        let Some(switch) = self.motion.switches().iter().position(|&s| s == Switch::Ramp(drive)) else {
            return;
        };
        let left = value - state.xi[ramp];
        let towards = match left {
            l if l > 0.0 => SwitchState::Plus,
            l if l < 0.0 => SwitchState::Minus,
            _ => SwitchState::Rest,
        };
        let mode = self.flows[state.flow].equations.mode.with(switch, towards);
        state.flow = self.flow_of(mode);
    }

    /// Carries the state over `span_s`, a span that recurs.
    #[inline(always)]
    pub(super) fn advance(&mut self, state: &mut State, span_s: f64) -> Result<(), DiagnosisError> {
        let flow = &mut self.flows[state.flow];
        if flow.linear {
            flow.carry(span_s, &state.xi, &mut self.next)?;
            let states = flow.states();
            let guards = &self.next[states..states + flow.equations.guards.len()];
            if guards.iter().all(|guard| *guard >= 0.0) {
                state.xi[..states].copy_from_slice(&self.next[..states]);
                if !flow.equations.stuck.is_empty() {
                    self.join(state);
                }
                return Ok(());
            }
        }
        self.advance_through_events(state, span_s)
    }

    /// Carries the state over `span_s` through the events on the way.
    fn advance_through_events(&mut self, state: &mut State, span_s: f64) -> Result<(), DiagnosisError> {
        let mut left = span_s;
        let mut events = 0;
        while left > SLIVER * span_s {
            self.fill(state);
            let whole = left.to_bits() == span_s.to_bits();
            let mut next = std::mem::take(&mut self.next);
            self.move_by(state, left, whole, &mut next)?;
            let crossed =
                if events < MOST_EVENTS { self.first_crossing(state, &mut next, left)? } else { None };
            if let Some((guard, share)) = crossed {
                if share > 0.0 {
                    self.move_by(state, share * left, false, &mut next)?;
                    state.xi.copy_from_slice(&next);
                }
                self.switch(state, guard);
                left *= 1.0 - share;
                events += 1;
            } else {
                state.xi.copy_from_slice(&next);
                left = 0.0;
            }
            self.next = next;
            self.join(state);
        }
        self.fill(state);
        Ok(())
    }

    /// One span in one mode. Nonlinear terms are averaged over it (trapezoidal, second order).
    fn move_by(
        &mut self,
        state: &mut State,
        span_s: f64,
        recurring: bool,
        out: &mut Vec<f64>,
    ) -> Result<(), DiagnosisError> {
        let i = state.flow;
        self.flows[i].move_by(span_s, recurring, &state.xi, out)?;
        if self.flows[i].linear {
            return Ok(());
        }
        let first = self.motion.layout().term(0);
        let start = state.xi[first..].to_vec();
        let mut end = State { xi: std::mem::take(out), flow: i };
        self.fill(&mut end);
        for (j, value) in start.iter().enumerate() {
            state.xi[first + j] = 0.5 * (value + end.xi[first + j]);
        }
        *out = end.xi;
        self.flows[i].move_by(span_s, recurring, &state.xi, out)?;
        let mut end = State { xi: std::mem::take(out), flow: i };
        self.fill(&mut end);
        *out = end.xi;
        state.xi[first..].copy_from_slice(&start);
        Ok(())
    }

    /// The first guard that falls below zero on the way to `next`, and at which share of the span.
    fn first_crossing(
        &mut self,
        state: &State,
        next: &mut [f64],
        span_s: f64,
    ) -> Result<Option<(usize, f64)>, DiagnosisError> {
        let flow = &self.flows[state.flow];
        let mut first: Option<(usize, f64)> = None;
        for (i, guard) in flow.equations.guards.iter().enumerate() {
            let end = dot(&guard.row, next);
            if end >= 0.0 {
                continue;
            }
            let start = dot(&guard.row, &state.xi);
            if start <= 0.0 {
                // Just crossed the other way, or pushed over by a correction: it switches unless it is on its
                // way back.
                if start < 0.0 || end < start {
                    return Ok(Some((i, 0.0)));
                }
                continue;
            }
            let share = start / (start - end);
            if first.is_none_or(|(_, s)| share < s) {
                first = Some((i, share));
            }
        }
        let Some((i, mut share)) = first else { return Ok(None) };
        let row = flow.equations.guards[i].row.clone();
        let (mut a, mut fa, mut b, mut fb) = (0.0, dot(&row, &state.xi), 1.0, dot(&row, next));
        for _ in 0..SECANT_STEPS {
            self.flows[state.flow].carry_once(share * span_s, &state.xi, &mut self.probe)?;
            let f = dot(&row, &self.probe);
            if f > 0.0 {
                (a, fa) = (share, f);
            } else {
                (b, fb) = (share, f);
            }
            if fa <= fb {
                break;
            }
            share = a + (b - a) * fa / (fa - fb);
        }
        Ok(Some((i, share)))
    }

    fn switch(&mut self, state: &mut State, index: usize) {
        let guard = self.flows[state.flow].equations.guards[index].clone();
        let mode = self.flows[state.flow].equations.mode;
        let to = match guard.value {
            GuardValue::To(to) => to,
            GuardValue::Stop => self.after_stop(state, mode, guard.switch),
        };
        if let Switch::Ramp(drive) = self.motion.switches()[guard.switch]
            && let Some(ramp) = self.motion.layout().ramp(drive)
        {
            state.xi[ramp] = state.xi[self.motion.layout().input(drive)];
        }
        state.flow = self.flow_of(mode.with(guard.switch, to));
        self.join(state);
        self.fill(state);
    }

    /// A guide has come to rest: whether it sticks, or slides on the other way.
    fn after_stop(&mut self, state: &State, mode: Mode, switch: usize) -> SwitchState {
        let flow = self.flow_of(mode.with(switch, SwitchState::Rest));
        let mut rested = State { xi: state.xi.clone(), flow };
        self.fill(&mut rested);
        let guards = &self.flows[flow].equations.guards;
        let exceeded =
            guards.iter().find(|guard| guard.switch == switch && dot(&guard.row, &rested.xi) < 0.0);
        match exceeded.map(|guard| guard.value) {
            Some(GuardValue::To(to)) => to,
            _ => SwitchState::Rest,
        }
    }

    /// Makes speeds that stick together equal.
    fn join(&self, state: &mut State) {
        for &[a, b] in &self.flows[state.flow].equations.stuck {
            let v = |g| self.motion.layout().v(g);
            match (a, b) {
                (Some(a), Some(b)) => state.xi[v(b)] = state.xi[v(a)],
                (Some(g), None) | (None, Some(g)) => state.xi[v(g)] = 0.0,
                (None, None) => {}
            }
        }
    }
}
