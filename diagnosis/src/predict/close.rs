//! The motion to machine precision, without observer correction.
//!
//! Guards are evaluated so often that each has at most one minimum in between, and events are located to
//! machine precision. Nonlinear laws are extrapolated: the second-order average over a span is computed for
//! one, two, three ... equal parts. The polynomial through the results is evaluated at a length of zero
//! (Aitken and Neville; Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, II.9).

use feeler_plant::motion::dot;
use feeler_plant::motion::modes::{GuardFunction, Instant, Storm, first_crossing, may_dip, trace};

use super::machine::Moving;
use super::state::State;
use crate::error::DiagnosisError;

/// Accuracy to which an event is located, s.
const LOCATED_S: f64 = 1e-15;
/// Share of the time between two guard evaluations over which a nonlinear law is extrapolated.
const NONLINEAR_SHARE: f64 = 0.5;
/// Largest number of columns of the extrapolation.
const COLUMNS: usize = 10;
/// Largest difference of two columns, relative to the magnitude of every state over the span. It allows for
/// rounding errors of the parts, times the weights of the extrapolation of some hundreds.
const AGREEMENT: f64 = 1e-13;
/// Smallest share of a span. A kink of the motion within such a share is not resolved; the error is of the
/// order of that time squared.
const SMALLEST_SHARE: f64 = 1e-9;
/// Share of a span over which the slope of a nonlinear law is computed.
const SLOPE_SHARE: f64 = 1e-5;

impl Moving {
    /// Advances the state by `span_s`, through the events on the way.
    pub(super) fn advance_closely(&mut self, state: &mut State, span_s: f64) -> Result<(), DiagnosisError> {
        let mut storm = Storm::default();
        let mut is_storm = false;
        let mut gone_s = 0.0;
        self.fill(state);
        while span_s - gone_s > f64::EPSILON * span_s {
            let push = storm.push_s();
            let (part_s, recurs) = self.part(state, span_s, span_s - gone_s)?;
            let h = push.map_or(part_s, |push| push.min(part_s));
            let mut next = Vec::new();
            self.carry_closely(state, h, recurs && push.is_none(), &mut next)?;
            let fired = if push.is_some() || is_storm { None } else { self.first_to_fire(state, &next, h) };
            let moved = fired.map_or(h, |(_, s)| s);
            match fired {
                Some((_, s)) if s > 0.0 => {
                    self.carry_closely(state, s, false, &mut next)?;
                    state.xi.copy_from_slice(&next);
                }
                Some((guard, _)) => {
                    // A correction has moved the state beyond the guard.
                    let equations = &self.flows[state.flow].equations;
                    if dot(&equations.guards[guard].row, &state.xi) < 0.0 {
                        self.motion.stop_exactly(equations, guard, &mut state.xi);
                    }
                }
                None => state.xi.copy_from_slice(&next),
            }
            self.motion.join(&self.flows[state.flow].equations, &mut state.xi);
            storm.moved(moved, push.is_some());
            gone_s += moved;
            if let Some((guard, _)) = fired {
                self.switch(state, guard);
                is_storm |= storm.fired(gone_s);
            }
        }
        self.fill(state);
        Ok(())
    }

    /// Time to the next guard evaluation, within the `left_s` of a span, and whether this time recurs.
    fn part(&mut self, state: &State, span_s: f64, left_s: f64) -> Result<(f64, bool), DiagnosisError> {
        let flow = &mut self.flows[state.flow];
        let share = if flow.linear { 1.0 } else { NONLINEAR_SHARE };
        let parts = (span_s / (share * flow.look_s()?)).ceil().max(1.0);
        let part_s = span_s / parts;
        // The last part differs from the others by rounding only.
        Ok(if left_s > part_s * (1.0 - 4.0 * parts * f64::EPSILON) {
            (part_s, true)
        } else {
            (left_s, false)
        })
    }

    /// Advances over one span in one mode, to machine precision; nonlinear terms are updated at the end.
    fn carry_closely(
        &mut self,
        state: &State,
        span_s: f64,
        recurs: bool,
        out: &mut Vec<f64>,
    ) -> Result<(), DiagnosisError> {
        if self.flows[state.flow].linear {
            return self.flows[state.flow].move_by(span_s, recurs, &state.xi, out);
        }
        let mut at = state.clone();
        let (mut gone_s, mut h) = (0.0, span_s);
        while span_s - gone_s > f64::EPSILON * span_s {
            h = h.min(span_s - gone_s);
            let is_last_resort = h <= SMALLEST_SHARE * span_s;
            if self.extrapolate(&at, h, recurs && h.to_bits() == span_s.to_bits(), is_last_resort, out)? {
                at.xi.copy_from_slice(out);
                gone_s += h;
                h *= 2.0;
            } else {
                h *= 0.5;
            }
        }
        out.clone_from(&at.xi);
        Ok(())
    }

    /// Extrapolates one span of a nonlinear mode. Returns whether two columns agree, or need not.
    fn extrapolate(
        &mut self,
        state: &State,
        span_s: f64,
        recurs: bool,
        is_last_resort: bool,
        out: &mut Vec<f64>,
    ) -> Result<bool, DiagnosisError> {
        let states = self.motion.layout().states();
        let sizes = self.sizes(state, span_s);
        let mut table: Vec<Vec<f64>> = Vec::new();
        for column in 0..COLUMNS {
            let parts = (column + 1) as f64;
            let mut at = state.clone();
            for _ in 0..=column {
                self.move_by(&mut at, span_s / parts, recurs, out)?;
                at.xi.copy_from_slice(out);
            }
            // Row `column` of the extrapolation table replaces the previous row.
            let mut value = at.xi[..states].to_vec();
            for (k, entry) in table.iter_mut().enumerate().take(column) {
                let factor = parts / (parts - (k + 1) as f64) - 1.0;
                let before = std::mem::replace(entry, value.clone());
                for (value, before) in value.iter_mut().zip(&before) {
                    *value += (*value - before) / factor;
                }
            }
            let agrees = column > 0
                && value
                    .iter()
                    .zip(&table[column - 1])
                    .zip(&sizes)
                    .all(|((new, old), size)| (new - old).abs() <= AGREEMENT * size + f64::MIN_POSITIVE);
            table.push(value);
            if agrees || (is_last_resort && column > 0) {
                out[..states].copy_from_slice(&table[column]);
                self.motion.fill_terms(&self.flows[state.flow].equations, out);
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Magnitude of every state over a span: its own, plus those of all terms that change it. If these nearly
    /// cancel, their rounding errors remain.
    fn sizes(&self, state: &State, span_s: f64) -> Vec<f64> {
        let parts = |row: &[f64]| row.iter().zip(&state.xi).map(|(r, x)| (r * x).abs()).sum::<f64>();
        let rows = &self.flows[state.flow].equations.derivative;
        rows.iter().zip(&state.xi).map(|(row, x)| x.abs() + span_s * parts(row)).collect()
    }

    /// The guard that fires first on the way to `next`, and the time, s.
    fn first_to_fire(&mut self, state: &State, next: &[f64], span_s: f64) -> Option<(usize, f64)> {
        let mut first: Option<(usize, f64)> = None;
        for i in 0..self.flows[state.flow].equations.guards.len() {
            let start = self.guard_at(i, state, &state.xi, 0.0, span_s);
            let end = self.guard_at(i, state, next, span_s, span_s);
            let trace = trace(&self.flows[state.flow].equations.guards[i].row, &state.xi, start.slope);
            // A correction has moved the state beyond the guard, and the state is returning.
            let comes_back = start.value < -trace && end.value >= 0.0;
            let stays = start.value > trace && end.value > 0.0 && !may_dip(&start, &end);
            if comes_back || stays {
                continue;
            }
            let mut course = Along { moving: self, state, guard: i };
            let fires = first_crossing(&mut course, [start, end], trace, LOCATED_S);
            if let Some(s) = fires.filter(|s| first.is_none_or(|(_, first)| *s < first)) {
                first = Some((i, s));
            }
        }
        first
    }

    /// The value and slope of a guard in the mode of `state`, at `xi`.
    fn guard_at(&self, guard: usize, state: &State, xi: &[f64], s: f64, span_s: f64) -> Instant {
        let flow = &self.flows[state.flow];
        let row = &flow.equations.guards[guard].row;
        let value = dot(row, xi);
        if flow.linear {
            return Instant { s, value, slope: flow.slope(row, xi) };
        }
        let delta = SLOPE_SHARE * span_s;
        let mut moved = xi.to_vec();
        for (x, row) in moved.iter_mut().zip(&flow.equations.derivative) {
            *x += delta * dot(row, xi);
        }
        self.motion.fill_terms(&flow.equations, &mut moved);
        Instant { s, value, slope: (dot(row, &moved) - value) / delta }
    }
}

/// A guard along the motion that starts at a state.
struct Along<'a> {
    moving: &'a mut Moving,
    state: &'a State,
    guard: usize,
}

impl GuardFunction for Along<'_> {
    fn at(&mut self, s: f64) -> Option<Instant> {
        let mut xi = Vec::new();
        self.moving.carry_closely(self.state, s, false, &mut xi).ok()?;
        Some(self.moving.guard_at(self.guard, self.state, &xi, s, s))
    }
}
