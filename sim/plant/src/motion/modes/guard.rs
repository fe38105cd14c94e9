//! The ends of a machine's mode, as rows.

use super::{ContactState, DirectionState, Mode, Switch, SwitchState};
use crate::assembly::StopSide;
use crate::motion::forces::Forces;
use crate::motion::layout::{add, scaled};
use crate::motion::{Motion, NonlinearLaw, Row};

/// A quantity that is positive while a mode lasts, and the switch that follows when it is not.
///
/// # When a guard fires
/// Let `g(t)` be the quantity along the motion of the mode, entered or carried to `t0`. Over `(t0, t1]`
///
/// | `g(t0)` | the guard fires |
/// |---|---|
/// | above zero | at the first `t` in `(t0, t1]` with `g(t) <= 0` |
/// | within `eps` of zero, and `g` grows | as if it were above zero: this is the trace of the last event |
/// | within `eps` of zero, and `g` does not grow | at `t0` |
/// | below zero | at `t0` |
///
/// `eps` is the rounding of the terms of `g`. The guard that fires first ends the mode; among guards that
/// fire at one instant, the first in the order of [`super::super::Equations::guards`]. A quantity that only
/// touches zero between two evaluations and rises again has fired. Evaluations are so close that it has one
/// minimum between them, which [`super::first_crossing`] finds.
#[derive(Clone, Debug, PartialEq)]
pub struct Guard {
    pub switch: usize,
    /// The quantity, a row of the extended vector.
    pub row: Row,
    /// The new state of the switch when it fires.
    pub value: GuardValue,
}

/// The new state of a switch when a guard fires.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GuardValue {
    To(SwitchState),
    /// A guide comes to rest: it sticks or slides the other way, depending on the forces.
    Stop,
}

impl Motion {
    /// The guards of all switches, in their order.
    pub(in crate::motion) fn guards(
        &self,
        mode: Mode,
        forces: &Forces,
        friction: &[Row],
        load: &Row,
    ) -> Vec<Guard> {
        let mut guards = Vec::new();
        for (switch, &what) in self.switches.iter().enumerate() {
            let of_switch = match what {
                Switch::Contact(i) => {
                    let [depth, rate] = &forces.compression[i];
                    to(mode.contact(switch).guards(depth, || self.pushing_rows(i, depth, rate)))
                }
                Switch::Stop(i, side) => {
                    let [depth, pushing] = self.stop_rows(mode, i, side, forces);
                    to(mode.contact(switch).guards(&depth, || {
                        vec![(pushing, ContactState::after_flank(self.assembly.links[i].damping))]
                    }))
                }
                Switch::Friction(i) => mode
                    .friction(switch)
                    .guards(&forces.elongation[i][1], || self.friction_room(i, &friction[i], load))
                    .into_iter()
                    .map(|(row, next)| {
                        (row, next.map_or(GuardValue::Stop, |next| GuardValue::To(next.into())))
                    })
                    .collect(),
                Switch::Direction(i) => {
                    let rate = &forces.elongation[i][1];
                    to(mode.direction(switch).guards(rate, || self.rest_room(rate)))
                }
                Switch::Ramp(i) => to(mode.ramp(switch).guards(|| self.left_to_ramp(i))),
                Switch::Limit(i) | Switch::Line(i) | Switch::Deadband(i) => {
                    to(self.bound_guards(what, i, mode, &forces.stroke[i]))
                }
            };
            guards.extend(of_switch.into_iter().map(|(row, value)| Guard { switch, row, value }));
        }
        guards
    }

    /// Rows that are all positive while contact `i` pushes, and the next state when one is not.
    fn pushing_rows(&self, i: usize, depth: &Row, rate: &Row) -> Vec<(Row, ContactState)> {
        let law = &self.assembly.contacts[i].law;
        let term_of = |is_it: fn(NonlinearLaw) -> Option<usize>| {
            let j = self.terms.iter().position(|term| is_it(term.law) == Some(i))?;
            Some(self.layout.unit(self.layout.term(j)))
        };
        let force = || {
            let total =
                |law| if let NonlinearLaw::Contact { contact, .. } = law { Some(contact) } else { None };
            term_of(total).unwrap_or_else(|| {
                let mut force = scaled(law.stiffness, depth);
                add(&mut force, law.damping, rate);
                force
            })
        };
        let factor = || {
            let release =
                |law| if let NonlinearLaw::Release { contact, .. } = law { Some(contact) } else { None };
            term_of(release).unwrap_or_else(|| {
                let mut factor = scaled(law.alpha, rate);
                factor[self.layout.one()] += 1.0;
                factor
            })
        };
        ContactState::while_pushing(law, depth, force, factor)
    }

    /// Compression of one side of link `i`, and the force of its law.
    fn stop_rows(&self, mode: Mode, i: usize, side: StopSide, forces: &Forces) -> [Row; 2] {
        let link = &self.assembly.links[i];
        let sign = side.sign();
        let [e, e_rate] = &forces.elongation[i];
        let mut depth = scaled(sign, e);
        let at = link.stops().find(|(s, _)| *s == side).map_or(0.0, |(_, at)| at);
        depth[self.layout.one()] -= sign * at;
        let mut push = scaled(link.stiffness, &depth);
        add(&mut push, sign * self.damping(mode, i), e_rate);
        for (j, term) in self.terms.iter().enumerate() {
            if matches!(term.law, NonlinearLaw::Cubic { link, side: of, .. } if link == i && of == Some(side))
            {
                push[self.layout.term(j)] += 1.0;
            }
        }
        [depth, push]
    }

    /// Remaining friction before a sticking link slides forward and backward.
    fn friction_room(&self, i: usize, held: &Row, load: &Row) -> [Row; 2] {
        let friction = self.assembly.links[i].friction;
        [(friction.forward, 1.0), (friction.backward, -1.0)].map(|(level, sign)| {
            let mut row = scaled(friction.load_ratio, load);
            row[self.layout.one()] += level + friction.stribeck_excess;
            if let Some(j) = self.level_term(i) {
                row[self.layout.term(j)] += 1.0;
            }
            add(&mut row, sign, held);
            row
        })
    }

    /// Distances of a speed from the start of forward and backward motion.
    fn rest_room(&self, rate: &Row) -> [Row; 2] {
        [-1.0, 1.0].map(|sign| {
            let mut room = scaled(sign, rate);
            room[self.layout.one()] += DirectionState::REST_M_PER_S;
            room
        })
    }
}

fn to<T: Into<SwitchState>>(guards: Vec<(Row, T)>) -> Vec<(Row, GuardValue)> {
    guards.into_iter().map(|(row, next)| (row, GuardValue::To(next.into()))).collect()
}
