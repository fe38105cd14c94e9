//! Positions in the extended vector `xi = [q, v, z, u, 1, w]`.

use super::Coordinates;
use crate::assembly::{Assembly, Link, NodeId};
use crate::description::LowPass;

/// Unit of time of the higher derivatives of a moving gap or an imposed motion, s.
pub const GAP_TIME_S: f64 = 1e-3;

/// A linear functional of the extended vector.
pub type Row = Vec<f64>;

/// The value of a linear functional over as many entries of `xi` as `row` has.
#[inline]
pub fn dot(row: &[f64], xi: &[f64]) -> f64 {
    row.iter().zip(xi).map(|(r, x)| r * x).sum()
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct DriveStates {
    /// The ramping command, if its rate is limited or it is interpolated.
    pub(super) ramp: Option<usize>,
    /// The rate of the ramping command, if it is interpolated.
    pub(super) pace: Option<usize>,
    /// Lags in series.
    pub(super) lags: Vec<usize>,
    /// The force of a velocity source with a time constant.
    pub(super) force: Option<usize>,
    /// The force of the integral part of a continuous servo.
    pub(super) integral: Option<usize>,
    /// First of the two states of an imposed motion: its acceleration and the rate of that.
    pub(super) imposed: Option<usize>,
    /// The heat of the winding, if it weakens the drive.
    pub(super) heat: Option<usize>,
}

/// Numbering of states, inputs and terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    coordinates: usize,
    states: usize,
    inputs: usize,
    terms: usize,
    pub(super) drives: Vec<DriveStates>,
    /// First state of each filter of each sensor.
    pub(super) filters: Vec<Vec<usize>>,
    /// First of the four states of each contact's moving gap.
    moving_gaps: Vec<Option<usize>>,
    /// Deflection of the bristles of each link.
    bristles: Vec<Option<usize>>,
}

impl Layout {
    pub(super) fn new(assembly: &Assembly, coordinates: &Coordinates, terms: usize) -> Self {
        let mut next = 2 * coordinates.count();
        let mut take = |n: usize| {
            next += n;
            next - n
        };
        let drives = (assembly.drives.iter())
            .map(|drive| DriveStates {
                ramp: drive.ramps().then(|| take(1)),
                pace: (drive.interval > 0.0).then(|| take(1)),
                lags: drive.lags.iter().map(|_| take(1)).collect(),
                force: drive.velocity_source.filter(|source| source.time_constant > 0.0).map(|_| take(1)),
                integral: drive.continuous_servo().filter(|servo| servo.ki > 0.0).map(|_| take(1)),
                imposed: drive.imposed.as_ref().map(|_| take(2)),
                heat: drive.warming.map(|_| take(1)),
            })
            .collect();
        let order = |filter: &LowPass| match filter {
            LowPass::FirstOrder { .. } => 1,
            LowPass::SecondOrder { .. } => 2,
        };
        let filters = assembly
            .sensors
            .iter()
            .map(|sensor| sensor.filters.iter().map(|filter| take(order(filter))).collect())
            .collect();
        let mut take = |n: usize| {
            next += n;
            next - n
        };
        let moving_gaps =
            assembly.contacts.iter().map(|contact| contact.profile.as_ref().map(|_| take(4))).collect();
        let moves = |link: &Link| !link.rigid && coordinates.of(link.a) != coordinates.of(link.b);
        let bristles = (assembly.links.iter())
            .map(|link| link.bristle.filter(|_| moves(link)).map(|_| take(1)))
            .collect();
        Self {
            coordinates: coordinates.count(),
            states: next,
            inputs: assembly.drives.len(),
            terms,
            drives,
            filters,
            moving_gaps,
            bristles,
        }
    }

    /// Position of coordinate `g`.
    pub fn q(&self, g: usize) -> usize {
        g
    }

    /// Position of speed `g`.
    pub fn v(&self, g: usize) -> usize {
        self.coordinates + g
    }

    /// Number of coordinates.
    pub fn coordinates(&self) -> usize {
        self.coordinates
    }

    /// Number of states.
    #[inline]
    pub fn states(&self) -> usize {
        self.states
    }

    /// Number of inputs: one per drive, its command after the static part of its chain. With a rate limit it
    /// is the target of the ramp.
    pub fn inputs(&self) -> usize {
        self.inputs
    }

    /// Position of the input of drive `i`.
    #[inline]
    pub fn input(&self, i: usize) -> usize {
        self.states + i
    }

    /// Position of the constant 1.
    pub fn one(&self) -> usize {
        self.states + self.inputs
    }

    /// Number of states, inputs and the constant: the extended vector of a linear mode.
    #[inline]
    pub fn linear_width(&self) -> usize {
        self.states + self.inputs + 1
    }

    /// Position of nonlinear term `j`.
    pub fn term(&self, j: usize) -> usize {
        self.linear_width() + j
    }

    /// Length of the extended vector.
    pub fn width(&self) -> usize {
        self.linear_width() + self.terms
    }

    /// The state of the ramping command of a drive.
    #[inline]
    pub fn ramp(&self, drive: usize) -> Option<usize> {
        self.drives[drive].ramp
    }

    /// The states of all lags of drives.
    pub fn lags(&self) -> impl Iterator<Item = usize> + '_ {
        self.drives.iter().flat_map(|drive| drive.lags.iter().copied())
    }

    /// The state of the rate of an interpolated command.
    pub fn pace(&self, drive: usize) -> Option<usize> {
        self.drives[drive].pace
    }

    /// The first of the two states of a drive's imposed motion, scaled as those of a moving gap. They are its
    /// acceleration times [`GAP_TIME_S`], and the rate of that times the square.
    pub fn imposed(&self, drive: usize) -> Option<usize> {
        self.drives[drive].imposed
    }

    /// The state of the force of a velocity source.
    pub fn force(&self, drive: usize) -> Option<usize> {
        self.drives[drive].force
    }

    /// The state of the heat of a drive's winding.
    pub fn heat(&self, drive: usize) -> Option<usize> {
        self.drives[drive].heat
    }

    /// The first of the four states of a contact's moving gap: its offset, its rate, and higher derivatives.
    /// They are scaled by [`GAP_TIME_S`] to comparable sizes: `offset`, `offset'`, `GAP_TIME_S offset''`,
    /// `GAP_TIME_S^2 offset'''`.
    pub fn moving_gap(&self, contact: usize) -> Option<usize> {
        self.moving_gaps[contact]
    }

    /// The state of the deflection of the bristles of a link.
    pub fn bristle(&self, link: usize) -> Option<usize> {
        self.bristles[link]
    }

    /// A row of zeros.
    pub fn zero(&self) -> Row {
        vec![0.0; self.width()]
    }

    /// A row that reads one entry.
    pub fn unit(&self, position: usize) -> Row {
        let mut row = self.zero();
        row[position] = 1.0;
        row
    }

    pub(super) fn position(&self, assembly: &Assembly, coordinates: &Coordinates, node: NodeId) -> Row {
        let mut row = self.zero();
        let own = assembly.nodes[node].position_m;
        match coordinates.of(node) {
            Some(g) => {
                row[self.q(g)] = 1.0;
                row[self.one()] = own - assembly.nodes[coordinates.lead(g)].position_m;
            }
            None => row[self.one()] = own,
        }
        row
    }

    pub(super) fn velocity(&self, coordinates: &Coordinates, node: NodeId) -> Row {
        coordinates.of(node).map_or_else(|| self.zero(), |g| self.unit(self.v(g)))
    }
}

/// `row += factor * other`.
pub(super) fn add(row: &mut Row, factor: f64, other: &Row) {
    for (r, o) in row.iter_mut().zip(other) {
        *r += factor * o;
    }
}

/// `factor * row`.
pub(super) fn scaled(factor: f64, row: &Row) -> Row {
    row.iter().map(|r| factor * r).collect()
}

/// `a - b`.
pub(super) fn difference(a: &Row, b: &Row) -> Row {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}
