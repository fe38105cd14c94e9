//! The flow of one mode: its equations as matrices, and its exponentials.

use feeler_lti::{C64, balance, eigenvalues};
use feeler_plant::assembly::Source;
use feeler_plant::motion::{
    ContactState, Equations, Guard, Ledger, Mode, Motion, NonlinearLaw, Row, Switch, dot,
};
use nalgebra::DMatrix;

use crate::error::EngineError;
use crate::solve::exponentials::{exponential, over};

/// Largest angle of the fastest oscillation between two evaluations of the guards, rad. It is below a quarter
/// turn, so a guard has at most one minimum in between, which its slopes at both ends reveal.
const CHECK_ANGLE: f64 = 1.2;
/// Largest product of a mode's norm and the span of one Taylor polynomial. With the 30 terms of
/// [`crate::solve::taylor`] the remainder is below 1e-18.
const TAYLOR_REACH: f64 = 3.0;

/// Angle of the fastest oscillation per step of a nonlinear mode, rad.
const NONLINEAR_ANGLE: f64 = 0.5 * CHECK_ANGLE;

/// The fastest oscillation that can be followed, rad/s: ten milliseconds of it take a hundred million
/// evaluations of guards.
const FASTEST: f64 = 1.2e10;
/// Exponentials of pieces that a mode keeps: the nodes of the ledger in a few pieces of equal length.
const REMEMBERED: usize = 64;

/// States that are expanded side by side: one AVX-512 register.
pub(crate) const BLOCK: usize = 8;

/// Rows of a transition per line: value at the end, slope at the start, slope at the end, value at the start.
pub(crate) const ROWS_PER_LINE: usize = 4;
/// Further rows per contact with peaks, after those of the lines: second derivatives of its force at start
/// and end.
pub(crate) const ROWS_PER_BEND: usize = 2;
/// Tolerance for proportional rows: a few roundings.
const PROPORTIONAL: f64 = 8.0 * f64::EPSILON;

/// A quantity that is evaluated along a transition.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    row: Row,
    /// Whether the mode ends when it is no longer positive.
    pub(crate) is_guard: bool,
}

/// One mode of one machine.
#[derive(Clone, Debug)]
pub(crate) struct Flow {
    pub(crate) equations: Equations,
    pub(crate) linear: bool,
    /// Derivatives of the states over the linear part of the extended vector, row by row.
    pub(crate) derivative: Vec<f64>,
    /// The part of `derivative` over the states, column by column, each padded to whole blocks.
    pub(crate) columns: Vec<f64>,
    pub(crate) states: usize,
    pub(crate) width: usize,
    /// Norm of the balanced derivative matrix, 1/s.
    pub(crate) rate: f64,
    /// Longest span of one Taylor polynomial, or of one step if the mode is nonlinear, s.
    pub(crate) horizon_s: f64,
    /// Poles of the linear part, 1/s; `None` while the norm, an upper bound, is sufficient.
    poles: Option<Vec<C64>>,
    /// Whether each contact pushes or is clamped; empty if peaks are not kept.
    pub(crate) pushing: Vec<bool>,
    /// The guards and, if peaks are kept, the forces of pushing contacts. In that case the first lines belong
    /// to the contacts, one for each.
    pub(crate) lines: Vec<Line>,
    /// Rows of the wanted signals; `None` for signals without a row.
    pub(crate) signals: Vec<Option<Row>>,
    /// Energy meters, if the run keeps the ledger.
    pub(crate) ledger: Ledger,
    /// Exponentials of pieces by the bits of their span.
    exponentials: Vec<(u64, DMatrix<f64>)>,
    /// Coordinates that nonlinear contacts join, group by group.
    pub(crate) coupled: Vec<Vec<usize>>,
    /// Transition rows by span.
    transitions: Vec<(u64, Vec<f64>)>,
    /// Rows of noted signals by span.
    noted: Vec<(u64, Vec<f64>)>,
}

impl Flow {
    pub(crate) fn new(
        motion: &Motion,
        mode: Mode,
        wanted: &[Source],
        energy: bool,
        peaks: bool,
    ) -> Result<Self, EngineError> {
        let equations = motion.equations(mode);
        let layout = motion.layout();
        let (states, width) = (layout.states(), layout.linear_width());
        let derivative: Vec<f64> =
            equations.derivative.iter().flat_map(|row| row[..width].iter().copied()).collect();
        let matrix = DMatrix::from_row_slice(states, width, &derivative);
        let square = matrix.columns(0, states).into_owned();
        let balanced = balance(&square).matrix;
        let rate = norm(&balanced).max(f64::MIN_POSITIVE);
        let linear = equations.is_linear();
        let (poles, horizon_s) = if linear {
            (None, TAYLOR_REACH / rate)
        } else {
            let poles = eigenvalues(&square)?;
            let horizon_s = NONLINEAR_ANGLE / fastest(&poles);
            (Some(poles), horizon_s)
        };
        let coupled = if linear { Vec::new() } else { coupled(motion, &equations) };
        let signals = wanted.iter().map(|&source| motion.signal(&equations, source)).collect();
        let ledger = if energy { motion.ledger(&equations) } else { Ledger::default() };
        let contacts = if peaks { motion.assembly().contacts.len() } else { 0 };
        let pushing: Vec<bool> =
            (0..contacts).map(|i| motion.contact_state(mode, i) == ContactState::Pushing).collect();
        Ok(Self {
            lines: lines(motion, &equations, &pushing),
            pushing,
            linear,
            equations,
            columns: square
                .column_iter()
                .flat_map(|column| {
                    (0..states.next_multiple_of(BLOCK)).map(move |i| column.get(i).copied().unwrap_or(0.0))
                })
                .collect(),
            derivative,
            states,
            width,
            rate,
            horizon_s,
            poles,
            exponentials: Vec::new(),
            signals,
            ledger,
            coupled,
            transitions: Vec::new(),
            noted: Vec::new(),
        })
    }

    /// Number of equal parts of a span after each of which the guards must be evaluated.
    pub(crate) fn evaluations(&mut self, span_s: f64) -> Result<u64, EngineError> {
        if span_s * self.rate <= CHECK_ANGLE {
            return Ok(1);
        }
        let fastest = fastest(self.poles()?);
        if fastest > FASTEST {
            return Err(EngineError::TooFast {
                frequency_hz: fastest / std::f64::consts::TAU,
                evaluations_per_s: fastest / CHECK_ANGLE,
            });
        }
        Ok((span_s * fastest / CHECK_ANGLE).ceil().max(1.0) as u64)
    }

    /// Poles of the linear part, 1/s.
    pub(crate) fn poles(&mut self) -> Result<&[C64], EngineError> {
        if self.poles.is_none() {
            let matrix = DMatrix::from_row_slice(self.states, self.width, &self.derivative);
            self.poles = Some(eigenvalues(&matrix.columns(0, self.states).into_owned())?);
        }
        Ok(self.poles.as_deref().unwrap_or_default())
    }

    /// The exponential of a span that is not a multiple of a femtosecond. Recurring ones are kept.
    pub(crate) fn exponential(&mut self, span_s: f64) -> Option<&DMatrix<f64>> {
        let known = self.exponentials.iter().position(|(key, _)| *key == span_s.to_bits());
        let index = if let Some(index) = known {
            index
        } else {
            let matrix = over(&self.derivative, self.width, span_s).ok()?;
            if self.exponentials.len() == REMEMBERED {
                self.exponentials.remove(0);
            }
            self.exponentials.push((span_s.to_bits(), matrix));
            self.exponentials.len() - 1
        };
        Some(&self.exponentials[index].1)
    }

    /// Row `i` of the derivative matrix.
    pub(crate) fn derivative_row(&self, i: usize) -> &[f64] {
        &self.derivative[i * self.width..(i + 1) * self.width]
    }

    /// The slope of a linear functional along the flow, as a row.
    pub(crate) fn slope(&self, row: &[f64]) -> Row {
        let mut slope = vec![0.0; self.width];
        for (i, &factor) in row[..self.states].iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
            for (s, d) in slope.iter_mut().zip(self.derivative_row(i)) {
                *s += factor * d;
            }
        }
        slope
    }

    /// Sum of the magnitudes of the parts of the slope of a linear functional.
    pub(crate) fn slope_size(&self, row: &[f64], xi: &[f64]) -> f64 {
        let parts = |i: usize| self.derivative_row(i).iter().zip(xi).map(|(d, x)| (d * x).abs()).sum::<f64>();
        row[..self.states]
            .iter()
            .enumerate()
            .filter(|(_, factor)| **factor != 0.0)
            .map(|(i, factor)| factor.abs() * parts(i))
            .sum()
    }

    /// The rows that carry the extended vector over `span_fs` femtoseconds, in this order. The states; for
    /// every line its value at the end, its slopes at start and end, and its value at the start. For every
    /// contact with peaks the second derivatives at start and end; the wanted signals at the end.
    pub(crate) fn transition(&mut self, span_fs: u64) -> Result<&[f64], EngineError> {
        if let Some(i) = self.transitions.iter().position(|(key, _)| *key == span_fs) {
            return Ok(&self.transitions[i].1);
        }
        let n = self.width;
        let exponential = exponential(&self.derivative, n, span_fs)?;
        let count = self.states
            + ROWS_PER_LINE * self.lines.len()
            + ROWS_PER_BEND * self.pushing.len()
            + self.signals.len();
        let mut rows = Vec::with_capacity(count * n);
        for i in 0..self.states {
            rows.extend(exponential.row(i).iter());
        }
        for line in &self.lines {
            let value = &line.row[..n];
            let slope = self.slope(value);
            rows.extend(exponential.column_iter().map(|column| dot(value, column.as_slice())));
            rows.extend_from_slice(&slope);
            rows.extend(exponential.column_iter().map(|column| dot(&slope, column.as_slice())));
            rows.extend_from_slice(value);
        }
        for line in &self.lines[..self.pushing.len()] {
            let bend = self.slope(&self.slope(&line.row));
            rows.extend_from_slice(&bend);
            rows.extend(exponential.column_iter().map(|column| dot(&bend, column.as_slice())));
        }
        for signal in &self.signals {
            let row = signal.as_deref().map_or(&[][..], |row| &row[..n]);
            rows.extend(exponential.column_iter().map(|column| dot(row, column.as_slice())));
        }
        self.transitions.push((span_fs, rows));
        Ok(&self.transitions[self.transitions.len() - 1].1)
    }

    /// The rows that give some signals `span_fs` femtoseconds later. Every call must name the same signals.
    pub(crate) fn noted(&mut self, span_fs: u64, signals: &[usize]) -> Result<&[f64], EngineError> {
        if let Some(i) = self.noted.iter().position(|(key, _)| *key == span_fs) {
            return Ok(&self.noted[i].1);
        }
        let n = self.width;
        let exponential = exponential(&self.derivative, n, span_fs)?;
        let mut rows = Vec::with_capacity(signals.len() * n);
        for &signal in signals {
            let row = self.signals[signal].as_deref().map_or(&[][..], |row| &row[..n]);
            rows.extend(exponential.column_iter().map(|column| dot(row, column.as_slice())));
        }
        self.noted.push((span_fs, rows));
        Ok(&self.noted[self.noted.len() - 1].1)
    }
}

/// Groups of coordinates that nonlinear contacts join while they push.
fn coupled(motion: &Motion, equations: &Equations) -> Vec<Vec<usize>> {
    let (layout, count) = (motion.layout(), motion.coordinates().count());
    let mut group: Vec<usize> = (0..count).collect();
    for (term, rows) in motion.terms().iter().zip(&equations.arguments) {
        let (NonlinearLaw::Contact { .. }, Some([depth, _])) = (term.law, rows) else { continue };
        let moved: Vec<usize> = (0..count).filter(|&g| depth[layout.q(g)] != 0.0).map(|g| group[g]).collect();
        let Some(&low) = moved.iter().min() else { continue };
        group.iter_mut().filter(|own| moved.contains(own)).for_each(|own| *own = low);
    }
    let of = |lead: usize| (0..count).filter(|&g| group[g] == lead).collect::<Vec<_>>();
    (0..count).map(of).filter(|members| members.len() > 1).collect()
}

/// The fastest oscillation of a system, rad/s.
fn fastest(poles: &[C64]) -> f64 {
    poles.iter().map(|pole| pole.im.abs()).fold(0.0, f64::max)
}

/// A guard represents a force that is proportional to it, so peaks cost lanes that travel together no
/// additional rows.
fn lines(motion: &Motion, equations: &Equations, pushing: &[bool]) -> Vec<Line> {
    let mut guards: Vec<&Guard> = equations.guards.iter().collect();
    let mut lines = Vec::new();
    for (i, &pushes) in pushing.iter().enumerate() {
        let force = &equations.contact_force[i];
        let stands = |guard: &&Guard| {
            motion.switches()[guard.switch] == Switch::Contact(i)
                && (!pushes || are_proportional(&guard.row, force))
        };
        let guard = guards.iter().position(stands).map(|at| guards.remove(at));
        lines.push(match guard {
            Some(guard) if !pushes => Line { row: guard.row.clone(), is_guard: true },
            _ => Line { row: force.clone(), is_guard: guard.is_some() },
        });
    }
    lines.extend(guards.into_iter().map(|guard| Line { row: guard.row.clone(), is_guard: true }));
    lines
}

/// Whether `b` is `a` times a positive number.
fn are_proportional(a: &[f64], b: &[f64]) -> bool {
    let Some(largest) = (0..a.len()).max_by(|&i, &j| a[i].abs().total_cmp(&a[j].abs())) else { return false };
    let factor = b[largest] / a[largest];
    factor > 0.0 && a.iter().zip(b).all(|(a, b)| (factor * a - b).abs() <= PROPORTIONAL * b.abs())
}

/// The smaller of the largest row sum and the largest column sum.
fn norm(matrix: &DMatrix<f64>) -> f64 {
    let rows = matrix.row_iter().map(|row| row.iter().map(|x| x.abs()).sum()).fold(0.0, f64::max);
    let columns = matrix.column_iter().map(|column| column.iter().map(|x| x.abs()).sum()).fold(0.0, f64::max);
    f64::min(rows, columns)
}
