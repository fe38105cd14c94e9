//! Forces of links, contacts and drives as rows, in a given mode.

use super::layout::{add, difference, scaled};
use super::{ContactState, Layout, LimitState, Mode, Motion, NonlinearLaw, RampState, Row, StopSide, Switch};
use crate::assembly::{Drive, NodeId};
use crate::description::Engagement;

/// The rows from which everything else in a mode is made.
pub(super) struct Forces {
    /// Compression and its rate, per contact.
    pub(super) compression: Vec<[Row; 2]>,
    /// Total force, per contact; zero while it is open.
    pub(super) contact: Vec<Row>,
    /// Elastic part, per contact.
    pub(super) contact_spring: Vec<Row>,
    /// Force on the second node from springs, dampers and loads, per link (friction comes later).
    pub(super) link: Vec<Row>,
    /// Its elastic part.
    pub(super) link_spring: Vec<Row>,
    /// Elongation and its rate, per link.
    pub(super) elongation: Vec<[Row; 2]>,
    /// Force on the pushed node, per drive.
    pub(super) drive: Vec<Row>,
    /// Position and velocity of the pushed node against the reacting one, per drive.
    pub(super) stroke: Vec<[Row; 2]>,
    /// For every term that acts in this mode, its arguments.
    pub(super) arguments: Vec<Option<[Row; 2]>>,
}

impl Motion {
    /// The relative position and velocity of two nodes, `a - b`.
    pub(super) fn relative(&self, a: NodeId, b: NodeId) -> [Row; 2] {
        let position = |node| self.layout.position(&self.assembly, &self.coordinates, node);
        let velocity = |node| self.layout.velocity(&self.coordinates, node);
        [difference(&position(a), &position(b)), difference(&velocity(a), &velocity(b))]
    }

    pub(super) fn forces(&self, mode: Mode) -> Forces {
        let layout = &self.layout;
        let mut forces = Forces {
            compression: (0..self.assembly.contacts.len()).map(|i| self.compression(i)).collect(),
            contact: Vec::new(),
            contact_spring: Vec::new(),
            link: Vec::new(),
            link_spring: Vec::new(),
            elongation: self.assembly.links.iter().map(|link| self.relative(link.b, link.a)).collect(),
            drive: Vec::new(),
            stroke: self
                .assembly
                .drives
                .iter()
                .map(|drive| self.relative(drive.on, drive.reacts_on))
                .collect(),
            arguments: vec![None; self.terms.len()],
        };
        for i in 0..self.assembly.contacts.len() {
            self.contact_force(mode, i, &mut forces);
        }
        for i in 0..self.assembly.links.len() {
            self.link_force(mode, i, &mut forces);
        }
        for (i, drive) in self.assembly.drives.iter().enumerate() {
            let mut force = self.drive_output(i, drive);
            for (j, term) in self.terms.iter().enumerate() {
                if matches!(term.law, NonlinearLaw::Ripple { drive, .. } if drive == i) {
                    forces.arguments[j] = Some([forces.stroke[i][0].clone(), layout.zero()]);
                    force[layout.term(j)] += 1.0;
                }
            }
            forces.drive.push(force);
        }
        forces
    }

    fn compression(&self, i: usize) -> [Row; 2] {
        let part = &self.assembly.contacts[i];
        let [mut d, mut rate] = self.relative(part.a, part.b);
        let nodes = &self.assembly.nodes;
        d[self.layout.one()] -= match part.engagement {
            Engagement::Clamped => nodes[part.a].position_m - nodes[part.b].position_m,
            Engagement::Unilateral | Engagement::Free => part.gap,
        };
        if let (Some(offset), Some(profile)) = (self.layout.moving_gap(i), &part.profile) {
            d[offset] -= 1.0;
            rate[offset + 1] -= 1.0;
            if part.engagement == Engagement::Clamped {
                d[self.layout.one()] += profile.at(0.0).0;
            }
        }
        [d, rate]
    }

    fn contact_force(&self, mode: Mode, i: usize, forces: &mut Forces) {
        let layout = &self.layout;
        let part = &self.assembly.contacts[i];
        let [d, rate] = forces.compression[i].clone();
        let state = self.contact_state(mode, i);
        let mut force = layout.zero();
        let mut spring = layout.zero();
        if part.law.is_linear() {
            if state == ContactState::Pushing {
                add(&mut spring, part.law.stiffness, &d);
                force.clone_from(&spring);
                add(&mut force, part.law.damping, &rate);
            }
        } else {
            let (pushes, pulls) = (state == ContactState::Pushing, state == ContactState::Releasing);
            for (j, term) in self.terms.iter().enumerate() {
                let (acts, row) = match term.law {
                    // While the law pulls, its value is still needed to see when it pushes again.
                    NonlinearLaw::Contact { contact, .. } => {
                        (contact == i && (pushes || (pulls && part.law.damping > 0.0)), Some(&mut force))
                    }
                    NonlinearLaw::Release { contact, .. } => (contact == i && (pushes || pulls), None),
                    NonlinearLaw::Elastic { contact, .. } => (contact == i && pushes, Some(&mut spring)),
                    _ => (false, None),
                };
                if acts {
                    forces.arguments[j] = Some([d.clone(), rate.clone()]);
                    if let Some(row) = row.filter(|_| pushes) {
                        row[layout.term(j)] = 1.0;
                    }
                }
            }
        }
        forces.contact.push(force);
        forces.contact_spring.push(spring);
    }

    fn link_force(&self, mode: Mode, i: usize, forces: &mut Forces) {
        let layout = &self.layout;
        let link = &self.assembly.links[i];
        let [e, rate] = forces.elongation[i].clone();
        let mut spring = layout.zero();
        let mut force = layout.zero();
        if !link.rigid {
            let mut side = |sign: f64, tag: i8, offset: f64, state: ContactState| {
                if state == ContactState::Open {
                    return;
                }
                let mut d = scaled(sign, &e);
                d[layout.one()] -= offset;
                let pushes = state == ContactState::Pushing;
                if pushes {
                    add(&mut spring, -sign * link.stiffness, &d);
                    add(&mut force, -link.damping, &rate);
                }
                for (j, term) in self.terms.iter().enumerate() {
                    if matches!(term.law, NonlinearLaw::Cubic { link, side, .. } if link == i && side == tag)
                    {
                        // While the side would pull, its value is still needed to see when it pushes again.
                        forces.arguments[j] = Some([d.clone(), layout.zero()]);
                        spring[layout.term(j)] -= if pushes { sign } else { 0.0 };
                    }
                }
            };
            if link.play > 0.0 {
                for (stop, sign, tag) in [(StopSide::Upper, 1.0, 1), (StopSide::Lower, -1.0, -1)] {
                    side(sign, tag, 0.5 * link.play, self.stop_state(mode, i, stop));
                }
            } else {
                side(1.0, 0, 0.0, ContactState::Pushing);
            }
            add(&mut force, 1.0, &spring);
            force[layout.one()] += link.load;
        }
        forces.link.push(force);
        forces.link_spring.push(spring);
    }

    /// The command of a drive after the static part of its chain and its lags.
    pub(super) fn lagged_command(&self, i: usize) -> Row {
        let states = &self.layout.drives[i];
        let last = states.lags.last().copied().or(states.ramp).unwrap_or_else(|| self.layout.input(i));
        self.layout.unit(last)
    }

    fn drive_output(&self, i: usize, drive: &Drive) -> Row {
        match (drive.velocity_source, self.layout.drives[i].force) {
            (Some(_), Some(force)) => self.layout.unit(force),
            _ => self.lagged_command(i),
        }
    }

    /// What the states of drive `i` do: pairs of state and derivative.
    pub(super) fn drive_derivatives(&self, i: usize, mode: Mode, stroke_rate: &Row) -> Vec<(usize, Row)> {
        let layout: &Layout = &self.layout;
        let drive = &self.assembly.drives[i];
        let states = &layout.drives[i];
        let mut derivatives = Vec::new();
        let mut command = layout.unit(layout.input(i));
        if let Some(ramp) = states.ramp {
            let mut slope = layout.zero();
            let state =
                self.number_of(Switch::Ramp(i)).map_or(RampState::AtTarget, |switch| mode.ramp(switch));
            slope[layout.one()] = state.slope(drive.rate_limit);
            derivatives.push((ramp, slope));
            command = layout.unit(ramp);
        }
        for (&state, &tau) in states.lags.iter().zip(&drive.lags) {
            let own = layout.unit(state);
            derivatives.push((state, scaled(1.0 / tau, &difference(&command, &own))));
            command = own;
        }
        if let (Some(source), Some(force)) = (drive.velocity_source, states.force) {
            let is_held =
                self.number_of(Switch::Limit(i)).is_some_and(|i| mode.limit(i) != LimitState::Within);
            let row = if is_held { layout.zero() } else { source_rate(source, &command, stroke_rate, force) };
            derivatives.push((force, row));
        }
        derivatives
    }
}

/// `(b_a (v_c - v) - f_a) / tau`, the paper's Fig. 2.
pub(super) fn source_rate(
    source: crate::assembly::VelocitySource,
    command: &Row,
    stroke_rate: &Row,
    force: usize,
) -> Row {
    let mut row = scaled(source.damping, &difference(command, stroke_rate));
    row[force] -= 1.0;
    scaled(1.0 / source.time_constant, &row)
}
