//! Drives as rows: from a command to a force, in a given mode.

use super::layout::{GAP_TIME_S, add, difference, scaled};
use super::{LimitState, Mode, Motion, NonlinearLaw, RampState, Row, Switch, SwitchState};
use crate::assembly::VelocitySource;

/// The steps from a command to a force.
pub(super) struct Path {
    /// The error of a continuous servo, before its deadband.
    error: Row,
    /// The error after its deadband.
    acting: Row,
    /// The commanded force.
    wanted: Row,
    /// The command within the limit.
    limited: Row,
    /// The force within the speed line, before lags.
    pub(super) given: Row,
    /// Force on the pushed node, before ripples.
    pub(super) force: Row,
}

impl Motion {
    /// The command of drive `i` after the static part of its chain.
    fn command_row(&self, i: usize) -> Row {
        self.layout.unit(self.layout.drives[i].ramp.unwrap_or_else(|| self.layout.input(i)))
    }

    /// The command of drive `i` after its lags.
    fn lagged_command(&self, i: usize) -> Row {
        match self.layout.drives[i].lags.last() {
            Some(&last) => self.layout.unit(last),
            None => self.command_row(i),
        }
    }

    /// From the command of drive `i` to its force, in a mode.
    pub(super) fn path(&self, i: usize, mode: Mode, [x, v]: &[Row; 2]) -> Path {
        let (layout, drive) = (&self.layout, &self.assembly.drives[i]);
        let (mut error, mut acting) = (layout.zero(), layout.zero());
        let servo = drive.continuous_servo();
        let wanted = match (servo, drive.velocity_source, layout.force(i)) {
            (Some(servo), ..) => {
                error = difference(&self.command_row(i), x);
                acting.clone_from(&error);
                if let Some(within) = self.bound(Switch::Deadband(i), mode, &error) {
                    acting = difference(&error, &within);
                }
                let mut wanted = scaled(servo.kp, &acting);
                add(&mut wanted, -servo.kd, v);
                if let Some(integral) = layout.drives[i].integral {
                    wanted[integral] += 1.0;
                }
                for (input, feed) in self.assembly.feeds_of(i) {
                    add(&mut wanted, feed.gain(servo), &self.command_row(input));
                }
                wanted
            }
            (None, None, _) if drive.feeds.is_some() => layout.zero(),
            (None, Some(_), Some(force)) => layout.unit(force),
            (None, Some(source), None) => self.built_up(i, source, v),
            (None, None, _) => self.lagged_command(i),
        };
        // A force with its own dynamics is held at its limit by its own state.
        let is_held = layout.force(i).is_none();
        let bounded = self.bound(Switch::Limit(i), mode, &wanted).filter(|_| is_held);
        let limited = bounded.unwrap_or_else(|| wanted.clone());
        let given = self.bounded_by_speed(i, mode, &limited, v);
        let lag = layout.drives[i].lags.last().filter(|_| servo.is_some());
        let force = lag.map_or_else(|| given.clone(), |&lag| layout.unit(lag));
        Path { error, acting, wanted, limited, given, force }
    }

    /// `gain u - damping v`.
    fn built_up(&self, i: usize, source: VelocitySource, v: &Row) -> Row {
        let mut row = scaled(source.gain, &self.lagged_command(i));
        add(&mut row, -source.damping, v);
        row
    }

    /// A row after a limit or deadband switch: the row itself within its bound, else the bound. `None` if
    /// there is no such switch.
    fn bound(&self, switch: Switch, mode: Mode, row: &Row) -> Option<Row> {
        let state = mode.limit(self.number_of(switch)?);
        Some(match state.effort(self.half_width(switch)) {
            None => row.clone(),
            Some(effort) => scaled(effort, &self.layout.unit(self.layout.one())),
        })
    }

    fn bounded_by_speed(&self, i: usize, mode: Mode, row: &Row, v: &Row) -> Row {
        let line = self.assembly.drives[i].line;
        let state = self.number_of(Switch::Line(i)).map(|switch| mode.limit(switch));
        match (line, state.and_then(|state| state.effort(line?.force))) {
            (Some(line), Some(effort)) => {
                let mut row = scaled(-line.slope, v);
                row[self.layout.one()] += effort;
                row
            }
            _ => row.clone(),
        }
    }

    fn half_width(&self, switch: Switch) -> f64 {
        match switch {
            Switch::Limit(i) => self.assembly.drives[i].limit,
            Switch::Deadband(i) => self.assembly.drives[i].deadband,
            _ => f64::INFINITY,
        }
    }

    /// Derivatives of the states of drive `i`: pairs of state and derivative.
    pub(super) fn drive_derivatives(&self, i: usize, mode: Mode, stroke: &[Row; 2]) -> Vec<(usize, Row)> {
        let (layout, drive) = (&self.layout, &self.assembly.drives[i]);
        let states = &layout.drives[i];
        let mut derivatives = Vec::new();
        if let Some(ramp) = states.ramp {
            let mut slope = layout.zero();
            let state =
                self.number_of(Switch::Ramp(i)).map_or(RampState::AtTarget, |switch| mode.ramp(switch));
            match states.pace.filter(|_| state != RampState::AtTarget) {
                Some(pace) => slope[pace] = 1.0,
                None => slope[layout.one()] = state.slope(drive.rate_limit),
            }
            derivatives.push((ramp, slope));
        }
        let servo = drive.continuous_servo();
        // The lags of a servo follow its force, those of other drives their command.
        let path = servo.map(|servo| (servo, self.path(i, mode, stroke)));
        let mut followed = path.as_ref().map_or_else(|| self.command_row(i), |(_, path)| path.given.clone());
        for (&state, &tau) in states.lags.iter().zip(&drive.lags) {
            let own = layout.unit(state);
            derivatives.push((state, scaled(1.0 / tau, &difference(&followed, &own))));
            followed = own;
        }
        if let (Some((servo, path)), Some(integral)) = (path, states.integral) {
            // The excess of the commanded over the actual force resets the integral with the time constant kp
            // / ki.
            let mut row = scaled(servo.ki, &path.acting);
            add(&mut row, servo.ki / servo.kp, &difference(&path.given, &path.wanted));
            derivatives.push((integral, row));
        }
        if let (Some(source), Some(force)) = (drive.velocity_source, states.force) {
            let is_held =
                self.number_of(Switch::Limit(i)).is_some_and(|i| mode.limit(i) != LimitState::Within);
            let row = if is_held { layout.zero() } else { self.source_rate(i, source, &stroke[1], force) };
            derivatives.push((force, row));
        }
        if let Some(first) = states.imposed {
            derivatives.push((first, scaled(1.0 / GAP_TIME_S, &layout.unit(first + 1))));
        }
        if let (Some(warming), Some(heat)) = (drive.warming, states.heat) {
            let mut row = layout.unit(heat);
            row[heat] = -1.0 / warming.time_constant;
            for (j, term) in self.terms.iter().enumerate() {
                if matches!(term.law, NonlinearLaw::Heat { drive, .. } if drive == i) {
                    row[layout.term(j)] = 1.0 / warming.time_constant;
                }
            }
            derivatives.push((heat, row));
        }
        derivatives
    }

    /// `(gain u - damping v - f) / tau`, the paper's Fig. 2.
    fn source_rate(&self, i: usize, source: VelocitySource, v: &Row, force: usize) -> Row {
        let mut row = self.built_up(i, source, v);
        row[force] -= 1.0;
        scaled(1.0 / source.time_constant, &row)
    }

    /// The acceleration of a coordinate whose motion drive `i` imposes.
    pub(super) fn imposed_acceleration(&self, i: usize) -> Option<Row> {
        Some(scaled(1.0 / GAP_TIME_S, &self.layout.unit(self.layout.imposed(i)?)))
    }

    /// The distance from the command of drive `i` to its target.
    pub(super) fn left_to_ramp(&self, i: usize) -> Row {
        let mut left = self.layout.zero();
        if let Some(ramp) = self.layout.ramp(i) {
            left[self.layout.input(i)] = 1.0;
            left[ramp] = -1.0;
        }
        left
    }

    /// Rows that are positive while a limit, a speed line or a deadband of drive `i` stays in its state, and
    /// the next state.
    pub(super) fn bound_guards(
        &self,
        switch: Switch,
        i: usize,
        mode: Mode,
        stroke: &[Row; 2],
    ) -> Vec<(Row, LimitState)> {
        let Some(state) = self.number_of(switch).map(|number| mode.limit(number)) else { return Vec::new() };
        let (layout, drive) = (&self.layout, &self.assembly.drives[i]);
        let path = self.path(i, mode, stroke);
        let (row, half, slope) = match (switch, drive.line) {
            (Switch::Deadband(_), _) => (path.error, drive.deadband, 0.0),
            (Switch::Line(_), Some(line)) => (path.limited, line.force, line.slope),
            _ => (path.wanted, drive.limit, 0.0),
        };
        // Distances of the row above `half - slope v`, and above `-half - slope v`.
        let [above_upper, above_lower] = [-half, half].map(|offset| {
            let mut row = row.clone();
            add(&mut row, slope, &stroke[1]);
            row[layout.one()] += offset;
            row
        });
        let rate = match (switch, drive.velocity_source, layout.force(i)) {
            (Switch::Limit(_), Some(source), Some(force)) => self.source_rate(i, source, &stroke[1], force),
            _ if state == LimitState::AtLower => above_lower.clone(),
            _ => above_upper.clone(),
        };
        state.guards(|| [scaled(-1.0, &above_upper), above_lower], rate)
    }

    /// Effect of a bound switch on the state when it is reached. A force with its own dynamics is set to the
    /// limit, since a fixed step may exceed it.
    pub(super) fn hold_force(&self, i: usize, to: SwitchState, xi: &mut [f64]) {
        if let (SwitchState::Limit(state), Some(force)) = (to, self.layout.force(i))
            && let Some(held) = state.effort(self.assembly.drives[i].limit)
        {
            xi[force] = held;
        }
    }
}
