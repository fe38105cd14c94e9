//! The equations of motion of one mode.

use nalgebra::{DMatrix, DVector};

use super::forces::{Forces, source_rate};
use super::layout::{GAP_TIME_S, add, scaled};
use super::{Mode, Motion, Row, StopSide, Switch, SwitchState};

/// All that holds while no switch changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Equations {
    /// The mode in which they hold.
    pub mode: Mode,
    /// `x' = derivative xi`: one row per state.
    pub derivative: Vec<Row>,
    /// What ends the mode: every guard is positive while it lasts.
    pub guards: Vec<Guard>,
    /// Arguments of the nonlinear terms that act; none in a linear mode.
    pub arguments: Vec<Option<[Row; 2]>>,
    /// Pairs of coordinates whose speeds are equal because a guide between them sticks (`None`: ground).
    pub stuck: Vec<[Option<usize>; 2]>,
    /// Compression and its rate, per contact.
    pub compression: Vec<[Row; 2]>,
    /// Total force, per contact.
    pub contact_force: Vec<Row>,
    /// Elastic part of it.
    pub contact_spring_force: Vec<Row>,
    /// Force on the second body with load and friction, per link.
    pub link_force: Vec<Row>,
    /// Elastic part of it.
    pub link_spring_force: Vec<Row>,
    /// Friction force on the second body, per link.
    pub link_friction: Vec<Row>,
    /// Elongation and its rate, per link.
    pub elongation: Vec<[Row; 2]>,
    /// Force on the pushed body, per drive.
    pub drive_force: Vec<Row>,
    /// Position and velocity of the pushed body against the reacting one, per drive.
    pub stroke: Vec<[Row; 2]>,
}

impl Equations {
    /// Whether the mode is linear, so that a matrix exponential solves it.
    pub fn is_linear(&self) -> bool {
        self.arguments.iter().all(Option::is_none)
    }
}

/// A quantity that is positive while a mode lasts, and what happens when it is no longer.
#[derive(Clone, Debug, PartialEq)]
pub struct Guard {
    /// Index of the switch.
    pub switch: usize,
    /// The quantity, a row of the extended vector.
    pub row: Row,
    /// What the switch does.
    pub value: GuardValue,
}

/// Where a switch goes when a guard is crossed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuardValue {
    /// To this state.
    To(SwitchState),
    /// A guide comes to rest: it sticks, or slides the other way, whichever the forces ask for.
    Stop,
}

impl Motion {
    /// The equations of motion in a mode.
    pub fn equations(&self, mode: Mode) -> Equations {
        let mut forces = self.forces(mode);
        let load = self.contact_load(&mut forces);
        let mut friction = vec![self.layout.zero(); self.assembly.links.len()];
        let mut stuck = Vec::new();
        for (i, link) in self.assembly.links.iter().enumerate() {
            match self.state_of(mode, Switch::Friction(i)) {
                Some(SwitchState::Plus) => {
                    friction[i] = scaled(-1.0, &self.sliding_level(i, 1.0, &load, &mut forces))
                }
                Some(SwitchState::Minus) => friction[i] = self.sliding_level(i, -1.0, &load, &mut forces),
                Some(SwitchState::Rest) => {
                    stuck.push((i, [self.coordinates.of(link.a), self.coordinates.of(link.b)]))
                }
                None => {}
            }
        }
        let mut acceleration = self.accelerations(&forces, &friction);
        self.stick(&stuck, &mut acceleration, &mut friction);
        let derivative = self.derivatives(mode, &forces, acceleration);
        let guards = self.guards(mode, &forces, &friction, &load);
        let link_force = forces
            .link
            .iter()
            .zip(&friction)
            .map(|(force, friction)| force.iter().zip(friction).map(|(a, b)| a + b).collect())
            .collect();
        Equations {
            mode,
            derivative,
            guards,
            arguments: forces.arguments,
            stuck: stuck.into_iter().map(|(_, pair)| pair).collect(),
            compression: forces.compression,
            contact_force: forces.contact,
            contact_spring_force: forces.contact_spring,
            link_force,
            link_spring_force: forces.link_spring,
            link_friction: friction,
            elongation: forces.elongation,
            drive_force: forces.drive,
            stroke: forces.stroke,
        }
    }

    /// Sum of the sizes of all contact forces, which loads guides whose friction grows with it.
    fn contact_load(&self, forces: &mut Forces) -> Row {
        let mut load = self.layout.zero();
        let mut absolute = vec![false; self.assembly.contacts.len()];
        for (j, term) in self.terms.iter().enumerate() {
            if let super::NonlinearLaw::Load { contact } = term.law {
                forces.arguments[j] = Some([forces.contact[contact].clone(), self.layout.zero()]);
                load[self.layout.term(j)] += 1.0;
                absolute[contact] = true;
            }
        }
        for (force, _) in forces.contact.iter().zip(absolute).filter(|(_, absolute)| !absolute) {
            add(&mut load, 1.0, force);
        }
        load
    }

    fn sliding_level(&self, i: usize, direction: f64, load: &Row, forces: &mut Forces) -> Row {
        let friction = self.assembly.links[i].friction;
        let mut level = scaled(friction.load_ratio, load);
        level[self.layout.one()] += if direction > 0.0 { friction.forward } else { friction.backward };
        for (j, term) in self.terms.iter().enumerate() {
            if matches!(term.law, super::NonlinearLaw::Stribeck { link, .. } if link == i) {
                forces.arguments[j] = Some([forces.elongation[i][1].clone(), self.layout.zero()]);
                level[self.layout.term(j)] += 1.0;
            }
        }
        level
    }

    fn accelerations(&self, forces: &Forces, friction: &[Row]) -> Vec<Row> {
        let mut rows = vec![self.layout.zero(); self.coordinates.count()];
        let mut push = |node, factor: f64, force: &Row| {
            if let Some(g) = self.coordinates.of(node) {
                add(&mut rows[g], factor / self.coordinates.mass_kg(g), force);
            }
        };
        for (i, link) in self.assembly.links.iter().enumerate() {
            for force in [&forces.link[i], &friction[i]] {
                push(link.b, 1.0, force);
                push(link.a, -1.0, force);
            }
        }
        for (contact, force) in self.assembly.contacts.iter().zip(&forces.contact) {
            push(contact.b, 1.0, force);
            push(contact.a, -1.0, force);
        }
        for (drive, force) in self.assembly.drives.iter().zip(&forces.drive) {
            push(drive.on, 1.0, force);
            push(drive.reacts_on, -1.0, force);
        }
        rows
    }

    /// Makes coordinates that stick to each other move as one, and finds the friction forces `lambda` that
    /// hold them: `J M^-1 J^T lambda = -J a`, of least size where several guides share the work.
    fn stick(&self, stuck: &[(usize, [Option<usize>; 2])], acceleration: &mut [Row], friction: &mut [Row]) {
        if stuck.is_empty() {
            return;
        }
        let n = self.coordinates.count();
        let jacobian = DMatrix::from_fn(stuck.len(), n, |k, g| {
            let [a, b] = stuck[k].1;
            f64::from(i8::from(b == Some(g)) - i8::from(a == Some(g)))
        });
        let mut mobility = jacobian.clone();
        for g in 0..n {
            mobility.column_mut(g).scale_mut(1.0 / self.coordinates.mass_kg(g));
        }
        let gram = &mobility * jacobian.transpose();
        let largest = gram.amax();
        let inverse =
            gram.pseudo_inverse(1e-12 * largest).unwrap_or_else(|_| DMatrix::zeros(stuck.len(), stuck.len()));
        for column in 0..self.layout.width() {
            let free = DVector::from_fn(n, |g, _| acceleration[g][column]);
            let lambda = -&inverse * (&jacobian * free);
            for (k, (link, _)) in stuck.iter().enumerate() {
                friction[*link][column] = lambda[k];
            }
        }
        // The joint motion is that of the joined masses; written this way, rows of bodies at rest are zero
        // and rows of joined ones equal, to the bit.
        let mut group: Vec<Option<usize>> = (0..n).map(Some).collect();
        for _ in 0..n {
            for (_, [a, b]) in stuck {
                let [ga, gb] = [a, b].map(|end| end.and_then(|g| group[g]));
                let low = ga.min(gb);
                for end in [a, b].into_iter().flatten() {
                    group[*end] = low;
                }
            }
        }
        let original = acceleration.to_vec();
        for g in 0..n {
            let mut row = self.layout.zero();
            if group[g].is_some() {
                let members: Vec<usize> = (0..n).filter(|&h| group[h] == group[g]).collect();
                let total: f64 = members.iter().map(|&h| self.coordinates.mass_kg(h)).sum();
                for h in members {
                    add(&mut row, self.coordinates.mass_kg(h) / total, &original[h]);
                }
            }
            acceleration[g] = row;
        }
    }

    fn derivatives(&self, mode: Mode, forces: &Forces, acceleration: Vec<Row>) -> Vec<Row> {
        let layout = &self.layout;
        let mut derivative = vec![layout.zero(); layout.states()];
        for (g, row) in acceleration.into_iter().enumerate() {
            derivative[layout.q(g)] = layout.unit(layout.v(g));
            derivative[layout.v(g)] = row;
        }
        for i in 0..self.assembly.drives.len() {
            for (state, row) in self.drive_derivatives(i, mode, &forces.stroke[i][1]) {
                derivative[state] = row;
            }
        }
        self.filter_derivatives(forces, &mut derivative);
        for first in (0..self.assembly.contacts.len()).filter_map(|i| layout.moving_gap(i)) {
            derivative[first] = layout.unit(first + 1);
            derivative[first + 1] = scaled(1.0 / GAP_TIME_S, &layout.unit(first + 2));
            derivative[first + 2] = scaled(1.0 / GAP_TIME_S, &layout.unit(first + 3));
        }
        derivative
    }

    fn guards(&self, mode: Mode, forces: &Forces, friction: &[Row], load: &Row) -> Vec<Guard> {
        use GuardValue::{Stop, To};
        use SwitchState::{Minus, Plus, Rest};
        let mut guards = Vec::new();
        for (switch, &what) in self.switches.iter().enumerate() {
            let state = mode.get(switch);
            let mut guard = |row, value| guards.push(Guard { switch, row, value });
            match what {
                Switch::Contact(i) => {
                    let [d, rate] = &forces.compression[i];
                    let pushing = self.pushing_rows(i, d, rate);
                    match state {
                        Rest => guard(scaled(-1.0, d), To(Plus)),
                        Plus => pushing.into_iter().for_each(|(row, next)| guard(row, To(next))),
                        Minus => {
                            // Only the rate can make a compressed contact push again.
                            if let Some((row, _)) = pushing.into_iter().find(|(_, next)| *next == Minus) {
                                guard(scaled(-1.0, &row), To(Plus));
                            }
                            guard(d.clone(), To(Rest));
                        }
                    }
                }
                Switch::Stop(i, side) => {
                    let link = &self.assembly.links[i];
                    let sign = if side == StopSide::Upper { 1.0 } else { -1.0 };
                    let [e, e_rate] = &forces.elongation[i];
                    let mut d = scaled(sign, e);
                    d[self.layout.one()] -= 0.5 * link.play;
                    let mut push = scaled(link.stiffness, &d);
                    add(&mut push, sign * link.damping, e_rate);
                    for (j, term) in self.terms.iter().enumerate() {
                        let tag: i8 = if side == StopSide::Upper { 1 } else { -1 };
                        if matches!(term.law, super::NonlinearLaw::Cubic { link, side, .. } if link == i && side == tag)
                        {
                            push[self.layout.term(j)] += 1.0;
                        }
                    }
                    match state {
                        Rest => guard(scaled(-1.0, &d), To(Plus)),
                        Plus => guard(push, To(if link.damping > 0.0 { Minus } else { Rest })),
                        Minus => {
                            guard(scaled(-1.0, &push), To(Plus));
                            guard(d, To(Rest));
                        }
                    }
                }
                Switch::Friction(i) => {
                    let rate = &forces.elongation[i][1];
                    match state {
                        Plus => guard(rate.clone(), Stop),
                        Minus => guard(scaled(-1.0, rate), Stop),
                        Rest => {
                            let [forward, backward] = self.static_levels(i, load);
                            let mut room_forward = forward;
                            add(&mut room_forward, 1.0, &friction[i]);
                            guard(room_forward, To(Plus));
                            let mut room_backward = backward;
                            add(&mut room_backward, -1.0, &friction[i]);
                            guard(room_backward, To(Minus));
                        }
                    }
                }
                Switch::Ramp(i) => {
                    if let (Some(ramp), Plus | Minus) = (self.layout.ramp(i), state) {
                        let sign = if state == Plus { 1.0 } else { -1.0 };
                        let mut left = self.layout.zero();
                        left[self.layout.input(i)] = sign;
                        left[ramp] = -sign;
                        guard(left, To(Rest));
                    }
                }
                Switch::Limit(i) => self.limit_guards(i, state, forces, &mut guard),
            }
        }
        guards
    }

    fn limit_guards(
        &self,
        i: usize,
        state: SwitchState,
        forces: &Forces,
        guard: &mut impl FnMut(Row, GuardValue),
    ) {
        use SwitchState::{Minus, Plus, Rest};
        let drive = &self.assembly.drives[i];
        let (Some(source), Some(force)) = (drive.velocity_source, self.layout.drives[i].force) else {
            return;
        };
        let rate = source_rate(source, &self.lagged_command(i), &forces.stroke[i][1], force);
        match state {
            Rest => {
                for (sign, to) in [(-1.0, Plus), (1.0, Minus)] {
                    let mut room = self.layout.zero();
                    room[force] = sign;
                    room[self.layout.one()] = drive.limit;
                    guard(room, GuardValue::To(to));
                }
            }
            Plus => guard(rate, GuardValue::To(Rest)),
            Minus => guard(scaled(-1.0, &rate), GuardValue::To(Rest)),
        }
    }

    /// Rows that are all positive while contact `i` pushes, and where the contact goes when one no longer is:
    /// with damping the force vanishes while the contact is still compressed.
    fn pushing_rows(&self, i: usize, d: &Row, rate: &Row) -> Vec<(Row, SwitchState)> {
        let law = self.assembly.contacts[i].law;
        if law.damping > 0.0 {
            let total = |law| matches!(law, super::NonlinearLaw::Contact { contact, .. } if contact == i);
            let force = if let Some(j) = self.terms.iter().position(|term| total(term.law)) {
                self.layout.unit(self.layout.term(j))
            } else {
                let mut force = scaled(law.stiffness, d);
                add(&mut force, law.damping, rate);
                force
            };
            return vec![(force, SwitchState::Minus)];
        }
        let mut rows = vec![(d.clone(), SwitchState::Rest)];
        let released = |law| matches!(law, super::NonlinearLaw::Release { contact, .. } if contact == i);
        if let Some(j) = self.terms.iter().position(|term| released(term.law)) {
            rows.push((self.layout.unit(self.layout.term(j)), SwitchState::Minus));
        } else if law.alpha > 0.0 {
            let mut factor = scaled(law.alpha, rate);
            factor[self.layout.one()] += 1.0;
            rows.push((factor, SwitchState::Minus));
        }
        rows
    }

    /// The largest friction forces of a sticking link against forward and backward motion.
    fn static_levels(&self, i: usize, load: &Row) -> [Row; 2] {
        let friction = self.assembly.links[i].friction;
        [friction.forward, friction.backward].map(|level| {
            let mut row = scaled(friction.load_ratio, load);
            row[self.layout.one()] += level + friction.stribeck_excess;
            row
        })
    }
}
