//! Terms of the believed machine in a balance of forces, each value free within its tolerance.

use feeler_plant::assembly::{GROUND_NODE, Pull, assemble};
use feeler_plant::description::{ActuatorKind, ElementKind, Quantity, Site};
use feeler_plant::effects::{Kind, Place, Trait};

use super::rows::{Moving, Named};
use super::solve::Term;
use crate::dataset::Dataset;
use crate::fit::candidates::Candidate;
use crate::kinds::{At, Form, Shown, dossier, overlaps};
use crate::tolerance::{DAMPING, FRACTION};

/// Damping and friction may be smaller than believed by this factor.
const LESS: f64 = 8.0;

/// One believed term of the balance.
#[derive(Clone)]
pub(super) enum Side {
    Mass(f64),
    Damping(f64),
    /// Gravity of a body: largest torque and phase.
    Gravity(f64, f64),
    /// A believed effect: its element, kind, terms, values and tolerance.
    Effect(Site, Kind, Shown, Vec<f64>, f64),
}

/// The part of the machine that a term of the balance describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// All moving masses.
    Mass,
    /// Damping of the guide.
    Damping,
    /// Gravity of the bodies.
    Gravity,
    /// A believed effect on an element.
    Effect(Site, Kind),
}

impl Side {
    /// The part, and the ratio of a coefficient to the believed one.
    pub(super) fn over(&self, coefficient: f64) -> (Part, f64) {
        match self {
            Self::Mass(mass) => (Part::Mass, coefficient / mass),
            Self::Damping(damping) => (Part::Damping, coefficient / damping),
            Self::Gravity(..) => (Part::Gravity, coefficient),
            Self::Effect(site, kind, ..) => (Part::Effect(*site, *kind), coefficient),
        }
    }
}

impl Side {
    fn is_dry(&self) -> bool {
        matches!(self, Self::Effect(_, kind, ..) if kind.definition().has(Trait::DryFriction))
    }
}

pub(super) struct Base {
    sides: Vec<Side>,
    /// Weights on the axis.
    pulls: Vec<Pull>,
    /// Channel of the measured position.
    pub(super) position: usize,
}

impl Base {
    /// Terms of the machine; `None` if the first drive does not move a rigid axis that is connected to the
    /// ground only.
    pub(super) fn of(dataset: &Dataset) -> Option<Self> {
        let machine = &dataset.machine;
        let assembly = assemble(machine).ok()?;
        let drive = dataset.drives.first()?.drive;
        if !matches!(machine.actuators[drive].kind, ActuatorKind::Force { .. })
            || dataset.drives.len() > 1
            || !dataset.loops.is_empty()
        {
            return None;
        }
        let chain = assembly.reached(vec![assembly.drives[drive].on], &[GROUND_NODE], |link| link.rigid);
        let is_in = |node: usize| chain.contains(&node);
        let mut damping = 0.0;
        for link in &assembly.links {
            if is_in(link.a) && is_in(link.b) {
                continue;
            }
            if is_in(link.a) || is_in(link.b) {
                // A spring holds the axis, or another body is attached to it.
                let other = if is_in(link.a) { link.b } else { link.a };
                if link.stiffness != 0.0 || link.cubic != 0.0 || other != GROUND_NODE {
                    return None;
                }
                damping += link.damping;
            }
        }
        let on_axis = assembly.weights.iter().filter(|weight| is_in(weight.on));
        let pulls: Vec<Pull> = on_axis.filter_map(|weight| weight.course.pull()).collect();
        let mass: f64 = chain.iter().map(|node| assembly.nodes[*node].mass_kg).sum();
        let mut sides = vec![Side::Mass(mass)];
        if damping > 0.0 {
            sides.push(Side::Damping(damping));
        }
        let pulled = machine.bodies.values().filter(|body| body.gravity_n != 0.0);
        sides.extend(pulled.map(|body| Side::Gravity(body.gravity_n, body.gravity_phase_rad)));
        for site in machine.sites() {
            for effect in machine.element(site)?.1.effects() {
                let definition = effect.definition;
                let shown = dossier(definition.kind).balance;
                if matches!(definition.place, Place::Drive | Place::Guide | Place::Transmission) {
                    if dossier(definition.kind).needs_load && pulls.is_empty() {
                        continue;
                    }
                    let shown = shown.filter(|shown| matches!(shown.form, Form::Forces(_)))?;
                    let tolerance = if definition.has(Trait::DryFriction) { DAMPING } else { FRACTION };
                    sides.push(Side::Effect(site, definition.kind, shown, effect.values.clone(), tolerance));
                }
            }
        }
        let is_position = |c: &usize| {
            let read = assembly.node_read(dataset.channels[*c].source);
            read.is_some_and(|(node, to, quantity)| {
                quantity == Quantity::Position && is_in(node) && to == GROUND_NODE
            })
        };
        let position = (0..dataset.channels.len()).find(is_position)?;
        (mass.is_finite() && mass > 0.0).then_some(Self { sides, pulls, position })
    }

    /// Whether a balance of this machine can involve a cause: because the cause acts on the axis itself, and
    /// what loads it there is known.
    pub(super) fn shows(&self, cause: &Candidate) -> bool {
        let is_loaded = !dossier(cause.definition.kind).needs_load || !self.pulls.is_empty();
        is_loaded
            && matches!(cause.place, Place::Drive | Place::Guide | Place::Transmission)
            && matches!(cause.site.table, ElementKind::Bodies | ElementKind::Springs | ElementKind::Actuators)
    }

    /// The believed moving mass.
    pub(super) fn mass(&self) -> f64 {
        let of = |side: &Side| if let Side::Mass(mass) = side { Some(*mass) } else { None };
        self.sides.iter().find_map(of).unwrap_or(0.0)
    }

    /// Size of the weights on the axis at a position, N.
    pub(super) fn load(&self, position: f64) -> f64 {
        self.pulls.iter().map(|pull| pull.force(position).abs()).sum()
    }

    /// Whether dry friction acts, beside these causes or as one of them.
    pub(super) fn has_dry_friction(&self, causes: &[Candidate]) -> bool {
        self.sides(causes).any(|(_, side)| side.is_dry())
            || causes.iter().any(|cause| cause.definition.has(Trait::DryFriction))
    }

    /// The numbers of the terms of believed dry friction.
    pub(super) fn dry_sides(&self) -> Vec<usize> {
        self.sides(&[]).filter(|(_, side)| side.is_dry()).map(|(i, _)| i).collect()
    }

    /// The terms that no cause replaces, with their numbers.
    pub(super) fn sides<'a>(&'a self, causes: &'a [Candidate]) -> impl Iterator<Item = (usize, &'a Side)> {
        let stays = |(_, side): &(usize, &Side)| match side {
            Side::Effect(site, kind, ..) => {
                !causes.iter().any(|cause| cause.site == *site && overlaps(cause.definition.kind, *kind))
            }
            _ => true,
        };
        self.sides.iter().enumerate().filter(stays)
    }

    pub(super) fn terms(&self, rows: &Moving<'_>, causes: &[Candidate]) -> Vec<Term> {
        let of = |(i, side): (usize, &Side)| match side {
            Side::Mass(mass) => Term {
                series: rows.acceleration.clone(),
                low: mass / (1.0 + FRACTION),
                high: mass * (1.0 + FRACTION),
            },
            Side::Damping(damping) => {
                Term { series: rows.speed.clone(), low: damping / LESS, high: damping * (1.0 + DAMPING) }
            }
            Side::Gravity(amplitude, phase) => Term {
                series: rows.force(Named::Side(i), false, 0.0, |at| amplitude * (at.position + phase).sin()),
                low: 1.0 / (1.0 + FRACTION),
                high: 1.0 + FRACTION,
            },
            Side::Effect(_, _, shown, values, tolerance) => {
                let (coefficients, shape) = (shown.coefficients)(values);
                let Form::Forces(forces) = shown.form else {
                    return Term { series: Vec::new(), low: 0.0, high: 0.0 };
                };
                let force =
                    |at: At| forces.iter().zip(&coefficients).map(|(force, c)| c * (force.of)(at)).sum();
                Term {
                    series: rows.force(Named::Side(i), side.is_dry(), shape, force),
                    low: 1.0 / (1.0 + tolerance),
                    high: 1.0 + tolerance,
                }
            }
        };
        self.sides(causes).map(of).collect()
    }
}
