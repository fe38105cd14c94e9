//! A machine in motion: modes, events and inputs, one record at a time.

use feeler_plant::assembly::{Assembly, Source};
use feeler_plant::motion::{Mode, Motion, Row, dot};

use super::flow::Flows;
use super::state::State;
use crate::error::DiagnosisError;

/// Number of events within one row after which the rest of the row ignores guards: chatter is then faster
/// than the record can show.
const MOST_EVENTS: usize = 24;
/// Number of secant steps that locate an event. Rows are short against the motion, so this is enough.
const SECANT_STEPS: usize = 3;
/// Share to which an interval shrinks that begins at the trace of an event, and how often.
const GROWN_SHARE: f64 = 0.25;
const GROWN_STEPS: usize = 4;
/// Share of a row below which a remainder is a rounding error.
const SLIVER: f64 = 1e-9;

/// Two shares of a span, and the values of a guard there: the first is not below zero, the second is.
#[derive(Clone, Copy, Debug)]
struct Bracket {
    from: [f64; 2],
    to: [f64; 2],
}

impl Bracket {
    /// The share at which the line through both values is zero.
    fn share(&self) -> f64 {
        let ([a, at_a], [b, at_b]) = (self.from, self.to);
        a + (b - a) * at_a / (at_a - at_b)
    }
}

/// Precision with which a motion is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Precision {
    /// Row by row, for the many predictions of a fit. Guards are evaluated this many times per row, and
    /// nonlinear laws are averaged between the evaluations.
    Rows(usize),
    /// To machine precision; see [`super::close`].
    Rounding,
}

/// A machine with the modes that it has reached.
#[derive(Debug)]
pub(super) struct Moving {
    pub(super) motion: Motion,
    pub(super) flows: Flows,
    pub(super) precision: Precision,
    /// Whether the motion of any body is imposed.
    is_imposed: bool,
    next: Vec<f64>,
    probe: Vec<f64>,
    from: Vec<f64>,
}

impl Moving {
    pub(super) fn new(
        mut assembly: Assembly,
        channels: Vec<Source>,
        spacing_s: f64,
        precision: Precision,
    ) -> Result<Self, DiagnosisError> {
        // A dataset does not state when a feed began, so feeds are left out.
        for contact in &mut assembly.contacts {
            contact.profile = None;
        }
        let motion = Motion::new(assembly).map_err(|problems| DiagnosisError::Machine { problems })?;
        let checks = if let Precision::Rows(checks) = precision { checks } else { 1 };
        let flows = Flows::new(channels, spacing_s, checks);
        let is_imposed = motion.assembly().drives.iter().any(|drive| drive.imposed.is_some());
        Ok(Self {
            is_imposed,
            motion,
            flows,
            precision,
            next: Vec::new(),
            probe: Vec::new(),
            from: Vec::new(),
        })
    }

    /// The initial state with filters at rest, after `change` has modified it.
    pub(super) fn start(&mut self, change: impl Fn(&Self, &mut [f64])) -> State {
        let mut xi = self.motion.initial_vector();
        change(self, &mut xi);
        let Ok(beginning) = self.motion.begin(&mut self.flows, Mode::default(), &mut xi);
        self.motion.settle_filters(&self.flows[beginning.index].equations, &mut xi);
        State { xi, flow: beginning.index, loops: Vec::new() }
    }

    /// Sets the positions of bodies with an imposed motion, from `t_s` onwards.
    pub(super) fn impose(&self, state: &mut State, t_s: f64) {
        if self.is_imposed {
            self.motion.set_gaps(t_s, &mut state.xi);
        }
        self.motion.join(&self.flows[state.flow].equations, &mut state.xi);
    }

    /// The row of a signal in the mode of a state.
    pub(super) fn signal(&self, state: &State, source: Source) -> Row {
        self.motion.signal(&self.flows[state.flow].equations, source).unwrap_or_default()
    }

    /// Value of a signal in a state.
    pub(super) fn value(&self, state: &State, source: Source) -> f64 {
        dot(&self.signal(state, source), &state.xi)
    }

    /// Brings the nonlinear terms up to date.
    pub(super) fn fill(&self, state: &mut State) {
        self.motion.fill_terms(&self.flows[state.flow].equations, &mut state.xi);
    }

    /// The signals of a row: the channels before gain, delay and quantisation, then the others (see
    /// [`super::flow`]).
    #[inline(always)]
    pub(super) fn evaluate_signals(&self, state: &State, out: &mut Vec<f64>) {
        self.flows[state.flow].evaluate_signals(&state.xi, out);
    }

    /// Gives a drive a new input. A drive with a limited rate starts its ramp here.
    pub(super) fn set_input(&mut self, state: &mut State, drive: usize, value: f64) {
        let mode = self.flows[state.flow].equations.mode;
        let next = self.motion.take_input(mode, drive, value, &mut state.xi);
        if next != mode {
            state.flow = self.flows.number_of(&self.motion, next);
        }
    }

    /// Advances the state by `span_s`, a span that recurs.
    #[inline(always)]
    pub(super) fn advance(&mut self, state: &mut State, span_s: f64) -> Result<(), DiagnosisError> {
        if self.precision == Precision::Rounding {
            return self.advance_closely(state, span_s);
        }
        let flow = &mut self.flows[state.flow];
        if flow.linear {
            flow.carry(span_s, &state.xi, &mut self.next)?;
            if self.arrives(state) {
                return Ok(());
            }
        } else if !flow.has_sliding_bristles() && flow.checks_in(span_s) > 1 {
            self.fill(state);
            if self.average_once(state, span_s)? && self.arrives(state) {
                self.fill(state);
                return Ok(());
            }
        }
        let checks = self.flows[state.flow].checks_in(span_s);
        let part_s = span_s / checks as f64;
        (0..checks).try_for_each(|_| self.advance_through_events(state, part_s))
    }

    /// Takes over the states in `next`, unless a guard fires on the way.
    #[inline(always)]
    fn arrives(&mut self, state: &mut State) -> bool {
        let flow = &self.flows[state.flow];
        let (states, guards) = self.next.split_at(flow.states());
        let arrives = guards.iter().all(|guard| *guard >= 0.0);
        if arrives {
            state.xi[..states.len()].copy_from_slice(states);
            self.motion.join(&flow.equations, &mut state.xi);
        }
        arrives
    }

    /// Advances over a whole span into `next`, with nonlinear terms averaged once. Returns whether these are
    /// even enough for that.
    #[inline(always)]
    fn average_once(&mut self, state: &State, span_s: f64) -> Result<bool, DiagnosisError> {
        let flow = &mut self.flows[state.flow];
        let states = flow.states();
        flow.carry(span_s, &state.xi, &mut self.next)?;
        self.probe.clone_from(&state.xi);
        self.probe[..states].copy_from_slice(&self.next[..states]);
        let mut from = state.xi.clone();
        let is_even = self.motion.average_even_terms(&flow.equations, &mut from, &self.probe);
        if is_even {
            flow.carry(span_s, &from, &mut self.next)?;
        }
        Ok(is_even)
    }

    /// Advances the state by `span_s`, through the events on the way.
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
                // Otherwise a surface that a correction moves against its sliding direction gains energy.
                self.motion.stop_exactly(&self.flows[state.flow].equations, guard, &mut state.xi);
                self.switch(state, guard);
                left *= 1.0 - share;
                events += 1;
            } else {
                state.xi.copy_from_slice(&next);
                left = 0.0;
            }
            self.next = next;
            self.motion.join(&self.flows[state.flow].equations, &mut state.xi);
        }
        self.fill(state);
        Ok(())
    }

    /// Advances over one span in one mode, in as many parts as its bristles need.
    pub(super) fn move_by(
        &mut self,
        state: &mut State,
        span_s: f64,
        recurring: bool,
        out: &mut Vec<f64>,
    ) -> Result<(), DiagnosisError> {
        let i = state.flow;
        if self.flows[i].linear {
            return self.flows[i].move_by(span_s, recurring, &state.xi, out);
        }
        let parts = self.flows[i].parts(span_s);
        let part_s = span_s / parts as f64;
        let mut from = std::mem::take(&mut self.from);
        from.clone_from(&state.xi);
        for part in 0..parts {
            if part > 0 {
                std::mem::swap(&mut from, out);
            }
            self.average(i, part_s, recurring, &mut from, out)?;
        }
        self.from = from;
        Ok(())
    }

    /// Advances over one span in mode `i`, with nonlinear terms averaged over it (second order).
    fn average(
        &mut self,
        i: usize,
        span_s: f64,
        recurring: bool,
        from: &mut [f64],
        out: &mut Vec<f64>,
    ) -> Result<(), DiagnosisError> {
        let flow = &mut self.flows[i];
        if flow.has_sliding_bristles() {
            // Bristles settle within a fraction of a span. Their rate at its start, held throughout, would
            // be amplified by their damping.
            self.probe.clear();
            self.probe.extend_from_slice(from);
            self.motion.average_terms(&flow.equations, from, &self.probe, span_s);
        }
        flow.move_by(span_s, recurring, from, out)?;
        self.motion.fill_terms(&flow.equations, out);
        self.motion.average_terms(&flow.equations, from, out, span_s);
        flow.move_by(span_s, recurring, from, out)?;
        self.motion.fill_terms(&flow.equations, out);
        Ok(())
    }

    /// The first guard that falls below zero on the way to `next`, and the share of the span.
    fn first_crossing(
        &mut self,
        state: &State,
        next: &mut [f64],
        span_s: f64,
    ) -> Result<Option<(usize, f64)>, DiagnosisError> {
        let mut first: Option<(usize, Bracket)> = None;
        for i in 0..self.flows[state.flow].equations.guards.len() {
            let flow = &self.flows[state.flow];
            let row = &flow.equations.guards[i].row;
            let (start, end) = (dot(row, &state.xi), dot(row, next));
            if end >= 0.0 {
                continue;
            }
            if start < 0.0 || (start <= 0.0 && flow.slope(row, &state.xi) <= 0.0) {
                // The guard has just fired in the other direction, or a correction has moved the state beyond
                // it.
                return Ok(Some((i, 0.0)));
            }
            let mut bracket = Bracket { from: [0.0, start], to: [1.0, end] };
            if start <= 0.0 {
                self.shrink(&mut bracket, state, i, span_s)?;
            }
            if first.as_ref().is_none_or(|(_, other)| bracket.share() < other.share()) {
                first = Some((i, bracket));
            }
        }
        let Some((i, mut bracket)) = first else { return Ok(None) };
        for _ in 0..SECANT_STEPS {
            let share = bracket.share();
            let value = self.guard_after(state, i, share * span_s)?;
            if value > 0.0 {
                bracket.from = [share, value];
            } else {
                bracket.to = [share, value];
            }
            if bracket.from[1] <= bracket.to[1] {
                return Ok(Some((i, share)));
            }
        }
        Ok(Some((i, bracket.share())))
    }

    /// Shrinks the bracket of a guard that begins at the trace of the last event, until it begins where the
    /// guard has grown. A guard that grows for an instant only fires at once.
    fn shrink(
        &mut self,
        bracket: &mut Bracket,
        state: &State,
        guard: usize,
        span_s: f64,
    ) -> Result<(), DiagnosisError> {
        for _ in 0..GROWN_STEPS {
            let share = GROWN_SHARE * bracket.to[0];
            let value = self.guard_after(state, guard, share * span_s)?;
            if value >= 0.0 {
                bracket.from = [share, value];
                break;
            }
            bracket.to = [share, value];
        }
        Ok(())
    }

    /// Value of a guard after a part of a span.
    fn guard_after(&mut self, state: &State, guard: usize, span_s: f64) -> Result<f64, DiagnosisError> {
        let flow = &mut self.flows[state.flow];
        flow.carry_once(span_s, &state.xi, &mut self.probe)?;
        Ok(dot(&flow.equations.guards[guard].row, &self.probe))
    }

    /// Applies the change of state when a guard fires.
    pub(super) fn switch(&mut self, state: &mut State, guard: usize) {
        let Ok(switched) = self.motion.switch(&mut self.flows, state.flow, guard, &mut state.xi);
        state.flow = switched.index;
    }
}
