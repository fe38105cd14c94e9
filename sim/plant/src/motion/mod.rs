//! Equations of motion, one linear set per mode.
//!
//! Between events and with held inputs a machine of springs, dampers, contacts and dry friction is linear:
//! `x' = A xi`. The state is `x = [q, v, z]`, and the extended vector `xi = [x, u, 1, w]`. `q` and `v` are
//! coordinates and speeds of the independent bodies, `z` the states of drives, filters and moving gaps. `u`
//! are the held inputs, `w` the values of nonlinear laws ([`NonlinearTerm`]; most machines have none). The
//! [`Mode`] is the state of all contacts and guides; it ends when a [`Guard`] falls below zero. Every
//! integrator, the linear theory and the second engine use these rows. There is no other definition of the
//! motion.

mod coordinates;
mod drives;
mod energy;
mod equations;
mod forces;
mod layout;
pub mod modes;
mod nonlinear;
mod signals;

pub use crate::assembly::StopSide;
pub use coordinates::Coordinates;
pub use energy::{Ledger, Meter, MeterKind, Storage, StorageKind};
pub use equations::Equations;
pub use layout::{GAP_TIME_S, Layout, Row, dot};
pub use modes::{
    ContactState, DirectionState, FrictionState, Guard, GuardValue, LimitState, Mode, RampState, Switch,
    SwitchState,
};
pub use nonlinear::{NonlinearLaw, NonlinearTerm};

use crate::assembly::Assembly;
use crate::description::Piece;
use crate::problem::Problem;

/// A machine ready to move: coordinates, switches and states are numbered.
#[derive(Clone, Debug)]
pub struct Motion {
    pub(crate) assembly: Assembly,
    /// The machine without the sliding surfaces of guides that yield, if it has any.
    stated: Option<Box<Assembly>>,
    pub(crate) coordinates: Coordinates,
    pub(crate) layout: Layout,
    pub(crate) switches: Vec<Switch>,
    pub(crate) terms: Vec<NonlinearTerm>,
}

impl Motion {
    /// Chooses coordinates and numbers all states and switches.
    ///
    /// # Errors
    /// Joined bodies with different initial velocities, a machine in which nothing moves, or more switches
    /// than a [`Mode`] holds.
    pub fn new(mut assembly: Assembly) -> Result<Self, Vec<Problem>> {
        let stated = assembly.clone();
        let stated = (!assembly.soften().is_empty()).then(|| Box::new(stated));
        let coordinates = Coordinates::new(&assembly)?;
        let switches = modes::switches(&assembly, &coordinates);
        if switches.len() > Mode::CAPACITY {
            let message = format!(
                "{} contacts, plays, frictions and limits that switch; {} is the most",
                switches.len(),
                Mode::CAPACITY
            );
            return Err(vec![Problem::new("", message, "split the machine")]);
        }
        let terms = nonlinear::terms(&assembly, &coordinates);
        let layout = Layout::new(&assembly, &coordinates, terms.len());
        Ok(Self { assembly, stated, coordinates, layout, switches, terms })
    }

    /// Writes the values of the nonlinear terms in a mode into the extended vector.
    #[inline]
    pub fn fill_terms(&self, equations: &Equations, xi: &mut [f64]) {
        for (j, (term, arguments)) in self.terms.iter().zip(&equations.arguments).enumerate() {
            if let Some([a, b]) = arguments {
                xi[self.layout.term(j)] = term.value(dot(a, xi), dot(b, xi));
            }
        }
    }

    /// Writes into `xi` the means of the nonlinear terms in a mode, over a span of `span_s` that ends at
    /// `end`.
    pub fn average_terms(&self, equations: &Equations, xi: &mut [f64], end: &[f64], span_s: f64) {
        let means: Vec<Option<f64>> = (self.terms.iter().zip(&equations.arguments))
            .map(|(term, arguments)| {
                let rows = arguments.as_ref()?;
                let [start, end] = [&*xi, end].map(|xi| rows.each_ref().map(|row| dot(row, xi)));
                Some(term.mean(start, end, span_s))
            })
            .collect();
        for (j, mean) in means.into_iter().enumerate() {
            xi[self.layout.term(j)] = mean.unwrap_or(xi[self.layout.term(j)]);
        }
    }

    /// Writes into `xi` the means of the nonlinear terms over a span that ends at `end`. They hold for longer
    /// spans than [`Self::average_terms`]. Returns `false` if a term changes too unevenly.
    pub fn average_even_terms(&self, equations: &Equations, xi: &mut [f64], end: &[f64]) -> bool {
        let means =
            self.terms.iter().zip(&equations.arguments).enumerate().filter_map(|(j, (term, arguments))| {
                let rows = arguments.as_ref()?;
                let [start, end] = [&*xi, end].map(|xi| rows.each_ref().map(|row| dot(row, xi)));
                Some(term.even_mean(start, end).map(|mean| (j, mean)))
            });
        let Some(means) = means.collect::<Option<Vec<(usize, f64)>>>() else { return false };
        for (j, mean) in means {
            xi[self.layout.term(j)] = mean;
        }
        true
    }

    /// The machine's numbers, with the sliding surfaces of guides that yield.
    pub fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    /// The machine's numbers as stated, without these surfaces.
    pub fn stated(&self) -> &Assembly {
        self.stated.as_deref().unwrap_or(&self.assembly)
    }

    /// Which bodies move together.
    pub fn coordinates(&self) -> &Coordinates {
        &self.coordinates
    }

    /// Positions in the extended vector.
    #[inline]
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The switches, in their order.
    pub fn switches(&self) -> &[Switch] {
        &self.switches
    }

    /// Laws that are not linear.
    pub fn terms(&self) -> &[NonlinearTerm] {
        &self.terms
    }

    /// Writes into a state the pieces of all moving gaps and imposed motions from `t_s` onwards.
    pub fn set_gaps(&self, t_s: f64, state: &mut [f64]) {
        for (i, drive) in self.assembly.drives.iter().enumerate() {
            if let Some(profile) = &drive.imposed {
                self.impose(i, &profile.piece_from(t_s), state);
            }
        }
        for (i, contact) in self.assembly.contacts.iter().enumerate() {
            if let (Some(first), Some(profile)) = (self.layout.moving_gap(i), &contact.profile) {
                let piece = profile.piece_from(t_s);
                let scaled = [
                    piece.offset,
                    piece.rate,
                    GAP_TIME_S * piece.curvature,
                    GAP_TIME_S * GAP_TIME_S * piece.jerk,
                ];
                state[first..first + 4].copy_from_slice(&scaled);
            }
        }
    }

    /// Writes into a state the beginning of a piece of the motion that drive `i` imposes.
    pub fn impose(&self, i: usize, piece: &Piece, state: &mut [f64]) {
        let on = self.assembly.drives[i].on;
        let (Some(first), Some(g)) = (self.layout.imposed(i), self.coordinates.of(on)) else { return };
        let nodes = &self.assembly.nodes;
        let apart = nodes[on].position_m - nodes[self.coordinates.lead(g)].position_m;
        state[self.layout.q(g)] = piece.offset - apart;
        state[self.layout.v(g)] = piece.rate;
        state[first] = GAP_TIME_S * piece.curvature;
        state[first + 1] = GAP_TIME_S * GAP_TIME_S * piece.jerk;
    }

    /// The initial inputs: the target of a servo is its position, other commands are zero.
    fn initial_inputs(&self) -> impl Iterator<Item = (usize, f64)> {
        let position = |node: usize| self.assembly.nodes[node].position_m;
        let servos = self.assembly.drives.iter().enumerate().filter(|(_, d)| d.continuous_servo().is_some());
        servos.map(move |(i, drive)| (i, position(drive.on) - position(drive.reacts_on)))
    }

    /// The extended vector at the start.
    pub fn initial_vector(&self) -> Vec<f64> {
        let mut xi = self.initial_state();
        xi.resize(self.layout.width(), 0.0);
        xi[self.layout.one()] = 1.0;
        for (i, input) in self.initial_inputs() {
            xi[self.layout.input(i)] = input;
        }
        xi
    }

    /// The initial state: positions and velocities as given, drives and filters at rest, windings as warm as
    /// the assembly says, gaps with their initial motion.
    pub fn initial_state(&self) -> Vec<f64> {
        let mut state = vec![0.0; self.layout.states()];
        for g in 0..self.coordinates.count() {
            let lead = &self.assembly.nodes[self.coordinates.lead(g)];
            state[self.layout.q(g)] = lead.position_m;
            state[self.layout.v(g)] = lead.velocity_m_per_s;
        }
        for (i, input) in self.initial_inputs() {
            self.layout.ramp(i).into_iter().for_each(|ramp| state[ramp] = input);
        }
        for (i, drive) in self.assembly.drives.iter().enumerate() {
            if let (Some(heat), Some(warming)) = (self.layout.heat(i), drive.warming) {
                state[heat] = warming.heat;
            }
        }
        self.set_gaps(0.0, &mut state);
        state
    }
}
