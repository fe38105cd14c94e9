//! The equations of motion of one mode.

use nalgebra::{DMatrix, DVector};

use super::forces::Forces;
use super::layout::{GAP_TIME_S, add, scaled};
use super::modes::joined;
use super::{FrictionState, Guard, Mode, Motion, Row, Switch};
use crate::assembly::{Assembly, NodeId};

/// Everything that is valid while no switch changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Equations {
    /// The mode in which they are valid.
    pub mode: Mode,
    /// `x' = derivative xi`: one row per state.
    pub derivative: Vec<Row>,
    /// Ends of the mode: every guard is positive while it lasts.
    pub guards: Vec<Guard>,
    /// Arguments of the nonlinear terms that act; empty in a linear mode.
    pub arguments: Vec<Option<[Row; 2]>>,
    /// Coordinates whose speed equals that of another, or zero, because guides stick. Each appears once, and
    /// the other one is not in the list.
    pub joined: Vec<(usize, Option<usize>)>,
    /// Compression and its rate, per contact.
    pub compression: Vec<[Row; 2]>,
    /// Total force, per contact.
    pub contact_force: Vec<Row>,
    /// Elastic part of the force, per contact.
    pub contact_spring_force: Vec<Row>,
    /// Force on the second body with load and friction, per link.
    pub link_force: Vec<Row>,
    /// Elastic part of the force, per link.
    pub link_spring_force: Vec<Row>,
    /// Friction force on the second body, dry and of bristles, per link.
    pub link_friction: Vec<Row>,
    /// Elastic force of bristles on the second body and the rate at which they bend, per link that has any.
    pub bristles: Vec<Option<[Row; 2]>>,
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

impl Motion {
    /// The equations of motion in a mode.
    pub fn equations(&self, mode: Mode) -> Equations {
        let mut forces = self.forces(mode);
        let load = self.load(&mut forces);
        let mut friction = vec![self.layout.zero(); self.assembly.links.len()];
        let mut stuck = Vec::new();
        for (i, link) in self.assembly.links.iter().enumerate() {
            match self.number_of(Switch::Friction(i)).map(|switch| mode.friction(switch)) {
                Some(FrictionState::Forward) => {
                    friction[i] = scaled(-1.0, &self.sliding_level(i, 1.0, &load, &mut forces));
                }
                Some(FrictionState::Backward) => {
                    friction[i] = self.sliding_level(i, -1.0, &load, &mut forces);
                }
                Some(FrictionState::Stick) => {
                    self.level_over(i, &mut forces);
                    stuck.push((i, [self.coordinates.of(link.a), self.coordinates.of(link.b)]));
                }
                None => {}
            }
        }
        let mut acceleration = self.accelerations(&forces, &friction);
        self.stick(&stuck, &mut acceleration, &mut friction);
        self.imposing_forces(&mut forces, &friction, &acceleration);
        let derivative = self.derivatives(mode, &forces, acceleration);
        let guards = self.guards(mode, &forces, &friction, &load);
        let bristles = self.bristles(&forces, &mut friction);
        let link_force = forces
            .link
            .iter()
            .zip(&friction)
            .map(|(force, friction)| force.iter().zip(friction).map(|(a, b)| a + b).collect())
            .collect();
        let mut equations = Equations {
            mode,
            derivative,
            guards,
            arguments: forces.arguments,
            joined: joined(
                &stuck.iter().map(|(_, pair)| *pair).collect::<Vec<_>>(),
                self.coordinates.count(),
                |g| self.coordinates.is_imposed(g),
            ),
            compression: forces.compression,
            contact_force: forces.contact,
            contact_spring_force: forces.contact_spring,
            link_force,
            link_spring_force: forces.link_spring,
            link_friction: friction,
            bristles,
            elongation: forces.elongation,
            drive_force: forces.drive,
            stroke: forces.stroke,
        };
        self.filter_derivatives(&mut equations);
        equations
    }

    /// Adds the force of bristles to that of dry friction, and returns its elastic part with the rate of the
    /// bristles.
    fn bristles(&self, forces: &Forces, friction: &mut [Row]) -> Vec<Option<[Row; 2]>> {
        let part = |(i, (found, friction)): (usize, (&Option<[Row; 2]>, &mut Row))| {
            let ([force, rate], state) = found.as_ref().zip(self.layout.bristle(i))?;
            add(friction, 1.0, force);
            let stiffness = self.assembly.links[i].bristle?.stiffness;
            Some([scaled(-stiffness, &self.layout.unit(state)), rate.clone()])
        };
        forces.bristle.iter().zip(friction).enumerate().map(part).collect()
    }

    /// Sum of the magnitudes of all contact forces and weights, which load guides with load-dependent
    /// friction.
    fn load(&self, forces: &mut Forces) -> Row {
        let mut load = self.layout.zero();
        let mut absolute = vec![false; self.assembly.contacts.len()];
        for (j, term) in self.terms.iter().enumerate() {
            if let super::NonlinearLaw::Load { contact } = term.law {
                forces.arguments[j] = Some([forces.contact[contact].clone(), self.layout.zero()]);
                load[self.layout.term(j)] += 1.0;
                absolute[contact] = true;
            }
            if let super::NonlinearLaw::Burden { weight, .. } = term.law {
                let weight = &self.assembly.weights[weight];
                let [x, _] = self.relative(weight.on, weight.reacts_on);
                forces.arguments[j] = Some([x, self.layout.zero()]);
                load[self.layout.term(j)] += 1.0;
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
        if let Some(j) = self.level_over(i, forces) {
            level[self.layout.term(j)] += 1.0;
        }
        for (j, term) in self.terms.iter().enumerate() {
            if matches!(term.law, super::NonlinearLaw::Stribeck { link, .. } if link == i) {
                forces.arguments[j] = Some([forces.elongation[i][1].clone(), self.layout.zero()]);
                level[self.layout.term(j)] += 1.0;
            }
        }
        level
    }

    /// The term of the friction level of link `i` over its elongation; also sets its arguments.
    fn level_over(&self, i: usize, forces: &mut Forces) -> Option<usize> {
        let j = self.level_term(i)?;
        forces.arguments[j] = Some([forces.elongation[i][0].clone(), self.layout.zero()]);
        Some(j)
    }

    /// The term of the friction level of link `i` over its elongation.
    pub(super) fn level_term(&self, i: usize) -> Option<usize> {
        let is_it = |law| matches!(law, super::NonlinearLaw::Level { link, .. } if link == i);
        self.terms.iter().position(|term| is_it(term.law))
    }

    /// Forces of links, weights and contacts, each with the node that it pushes and that which it reacts on.
    fn passive_forces<'a>(
        &'a self,
        forces: &'a Forces,
        friction: &'a [Row],
    ) -> impl Iterator<Item = ([NodeId; 2], &'a Row)> {
        let Assembly { links, weights, contacts, .. } = &self.assembly;
        let of_links = links.iter().enumerate().flat_map(|(i, link)| {
            let bristle = forces.bristle[i].as_ref().map(|[force, _]| force);
            let all = [Some(&forces.link[i]), Some(&friction[i]), bristle];
            all.into_iter().flatten().map(|force| ([link.b, link.a], force))
        });
        let of_weights = weights.iter().map(|weight| [weight.on, weight.reacts_on]).zip(&forces.weight);
        let of_contacts = contacts.iter().map(|contact| [contact.b, contact.a]).zip(&forces.contact);
        of_links.chain(of_weights).chain(of_contacts)
    }

    fn accelerations(&self, forces: &Forces, friction: &[Row]) -> Vec<Row> {
        let mut rows = vec![self.layout.zero(); self.coordinates.count()];
        let mut push = |node, factor: f64, force: &Row| {
            if let Some(g) = self.coordinates.of(node) {
                add(&mut rows[g], factor / self.coordinates.mass_kg(g), force);
            }
        };
        for ([on, reacts_on], force) in self.passive_forces(forces, friction) {
            push(on, 1.0, force);
            push(reacts_on, -1.0, force);
        }
        for (drive, force) in self.assembly.drives.iter().zip(&forces.drive) {
            push(drive.on, 1.0, force);
            push(drive.reacts_on, -1.0, force);
        }
        for (g, row) in rows.iter_mut().enumerate() {
            if let Some(imposed) = self.coordinates.imposing(g).and_then(|i| self.imposed_acceleration(i)) {
                *row = imposed;
            }
        }
        rows
    }

    /// The forces of imposed motions: mass times acceleration less all other forces on the mass.
    fn imposing_forces(&self, forces: &mut Forces, friction: &[Row], acceleration: &[Row]) {
        for (g, row) in acceleration.iter().enumerate() {
            let Some(imposing) = self.coordinates.imposing(g) else { continue };
            let mut force = scaled(self.coordinates.mass_kg(g), row);
            let mut less = |node, factor: f64, by: &Row| {
                if self.coordinates.of(node) == Some(g) {
                    add(&mut force, -factor, by);
                }
            };
            for ([on, reacts_on], by) in self.passive_forces(forces, friction) {
                less(on, 1.0, by);
                less(reacts_on, -1.0, by);
            }
            for (drive, by) in self.assembly.drives.iter().zip(&forces.drive) {
                if drive.imposed.is_none() {
                    less(drive.on, 1.0, by);
                    less(drive.reacts_on, -1.0, by);
                }
            }
            forces.drive[imposing] = force;
        }
    }

    /// Makes coordinates that stick to each other move as one, and finds the friction forces `lambda` that
    /// hold them. They satisfy `J M^-1 J^T lambda = -J a`, of minimum norm if several guides share the load.
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
            let inverse =
                if self.coordinates.is_imposed(g) { 0.0 } else { 1.0 / self.coordinates.mass_kg(g) };
            mobility.column_mut(g).scale_mut(inverse);
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
        // The common motion is that of the joined masses. In this form rows of bodies at rest are exactly
        // zero, and rows of joined bodies are bitwise equal.
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
        for g in (0..n).filter(|&g| !self.coordinates.is_imposed(g)) {
            let mut row = self.layout.zero();
            let members: Vec<usize> = (0..n).filter(|&h| group[h] == group[g]).collect();
            if let Some(&lead) = members.iter().find(|&&h| self.coordinates.is_imposed(h)) {
                row.clone_from(&original[lead]);
            } else if group[g].is_some() {
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
            for (state, row) in self.drive_derivatives(i, mode, &forces.stroke[i]) {
                derivative[state] = row;
            }
        }
        for (i, bristle) in forces.bristle.iter().enumerate() {
            if let Some((state, [_, rate])) = self.layout.bristle(i).zip(bristle.as_ref()) {
                derivative[state].clone_from(rate);
            }
        }
        for first in (0..self.assembly.contacts.len()).filter_map(|i| layout.moving_gap(i)) {
            derivative[first] = layout.unit(first + 1);
            derivative[first + 1] = scaled(1.0 / GAP_TIME_S, &layout.unit(first + 2));
            derivative[first + 2] = scaled(1.0 / GAP_TIME_S, &layout.unit(first + 3));
        }
        derivative
    }
}
