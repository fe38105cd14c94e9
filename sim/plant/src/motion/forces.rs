//! Forces of links, contacts and drives as rows, in a given mode.

use super::layout::{add, difference, scaled};
use super::{ContactState, Mode, Motion, NonlinearLaw, Row};
use crate::assembly::{NodeId, StopSide};
use crate::description::Engagement;

/// The rows from which all others of a mode are built.
pub(super) struct Forces {
    /// Compression and its rate, per contact.
    pub(super) compression: Vec<[Row; 2]>,
    /// Total force, per contact; zero while it is open.
    pub(super) contact: Vec<Row>,
    /// Elastic part, per contact.
    pub(super) contact_spring: Vec<Row>,
    /// Force on the second node from springs, dampers and loads, per link (friction comes later).
    pub(super) link: Vec<Row>,
    /// Elastic part of the force on the second node, per link.
    pub(super) link_spring: Vec<Row>,
    /// Elongation and its rate, per link.
    pub(super) elongation: Vec<[Row; 2]>,
    /// Force of the bristles on the second node and the rate of their deflection, per link that has any.
    pub(super) bristle: Vec<Option<[Row; 2]>>,
    /// Force on the pulled node, per weight.
    pub(super) weight: Vec<Row>,
    /// Force on the pushed node, per drive.
    pub(super) drive: Vec<Row>,
    /// Position and velocity of the pushed node relative to the reaction node, per drive.
    pub(super) stroke: Vec<[Row; 2]>,
    /// Arguments of every term that acts in this mode.
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
            bristle: Vec::new(),
            weight: Vec::new(),
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
            self.bristle_force(mode, i, &mut forces);
        }
        for i in 0..self.assembly.weights.len() {
            self.weight_force(i, &mut forces);
        }
        for i in 0..self.assembly.drives.len() {
            let cold = self.path(i, mode, &forces.stroke[i]).force;
            let mut force = cold.clone();
            if let Some(heat) = layout.drives[i].heat {
                self.derate(i, &cold, heat, &mut force, &mut forces.arguments);
            }
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

    /// Reduces the force of drive `i` by the loss from the heat of its winding.
    fn derate(&self, i: usize, cold: &Row, heat: usize, force: &mut Row, arguments: &mut [Option<[Row; 2]>]) {
        let layout = &self.layout;
        for (j, term) in self.terms.iter().enumerate() {
            match term.law {
                NonlinearLaw::Heat { drive, .. } if drive == i => {
                    arguments[j] = Some([cold.clone(), layout.zero()]);
                }
                NonlinearLaw::Derating { drive } if drive == i => {
                    arguments[j] = Some([cold.clone(), layout.unit(heat)]);
                    force[layout.term(j)] -= 1.0;
                }
                _ => {}
            }
        }
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
                    // While the law pulls, its value is still needed to detect when it pushes again.
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
            let damping = self.damping(mode, i);
            let mut act = |side: Option<StopSide>, at: f64, state: ContactState| {
                if state == ContactState::Open {
                    return;
                }
                let sign = side.map_or(1.0, StopSide::sign);
                let mut d = scaled(sign, &e);
                d[layout.one()] -= sign * at;
                let pushes = state == ContactState::Pushing;
                if pushes {
                    add(&mut spring, -sign * link.stiffness, &d);
                    add(&mut force, -damping, &rate);
                }
                for (j, term) in self.terms.iter().enumerate() {
                    let NonlinearLaw::Cubic { link, side: of, .. } = term.law else { continue };
                    if link == i && of == side {
                        // While the side would pull, its value is still needed to detect when it pushes
                        // again.
                        forces.arguments[j] = Some([d.clone(), layout.zero()]);
                        spring[layout.term(j)] -= if pushes { sign } else { 0.0 };
                    }
                }
            };
            let mut is_stopped = false;
            for (side, at) in link.stops() {
                act(Some(side), at, self.stop_state(mode, i, side));
                is_stopped = true;
            }
            if !is_stopped {
                act(None, 0.0, ContactState::Pushing);
            }
            add(&mut force, 1.0, &spring);
            self.speed_force(mode, i, &rate, forces, &mut force);
            force[layout.one()] += link.load;
        }
        forces.link.push(force);
        forces.link_spring.push(spring);
    }

    /// Damping of link `i` in its direction of motion.
    pub(super) fn damping(&self, mode: Mode, i: usize) -> f64 {
        let link = &self.assembly.links[i];
        link.damping * (1.0 + link.asymmetry * self.direction(mode, i).sign())
    }

    /// Adds drag and table of link `i`, whose elongation changes at `rate`.
    fn speed_force(&self, mode: Mode, i: usize, rate: &Row, forces: &mut Forces, force: &mut Row) {
        let sign = self.direction(mode, i).sign();
        for (j, term) in self.terms.iter().enumerate() {
            let by = match term.law {
                NonlinearLaw::Drag { link, .. } if link == i => -sign,
                NonlinearLaw::OverSpeed { link, .. } if link == i => 1.0,
                _ => 0.0,
            };
            if by != 0.0 {
                forces.arguments[j] = Some([rate.clone(), self.layout.zero()]);
                force[self.layout.term(j)] += by;
            }
        }
    }

    /// Bristles of a link at rest only bend; those of a sliding link also straighten.
    fn bristle_force(&self, mode: Mode, i: usize, forces: &mut Forces) {
        let layout = &self.layout;
        let parts = self.assembly.links[i].bristle.zip(layout.bristle(i));
        let found = parts.map(|(bristle, state)| {
            let mut rate = forces.elongation[i][1].clone();
            let sign = self.direction(mode, i).sign();
            for (j, term) in self.terms.iter().enumerate() {
                if sign != 0.0 && matches!(term.law, NonlinearLaw::Slip { link, .. } if link == i) {
                    forces.arguments[j] = Some([forces.elongation[i][1].clone(), layout.unit(state)]);
                    rate[layout.term(j)] -= sign;
                }
            }
            let mut force = scaled(-bristle.damping, &rate);
            force[state] -= bristle.stiffness;
            [force, rate]
        });
        forces.bristle.push(found);
    }

    fn weight_force(&self, i: usize, forces: &mut Forces) {
        let weight = &self.assembly.weights[i];
        let mut force = self.layout.zero();
        for (j, term) in self.terms.iter().enumerate() {
            if matches!(term.law, NonlinearLaw::Weight { weight, .. } if weight == i) {
                let [x, _] = self.relative(weight.on, weight.reacts_on);
                forces.arguments[j] = Some([x, self.layout.zero()]);
                force[self.layout.term(j)] += 1.0;
            }
        }
        forces.weight.push(force);
    }
}
