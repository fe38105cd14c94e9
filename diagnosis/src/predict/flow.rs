//! One mode of one machine: its equations as rows, and their propagation over a span.

use std::cell::RefCell;
use std::collections::HashMap;
use std::convert::Infallible;
use std::ops::{Index, IndexMut};
use std::rc::Rc;

use feeler_lanes::{Blocks, dispatch};
use feeler_lti::{eigenvalues, expm};
use feeler_plant::assembly::Source;
use feeler_plant::motion::modes::ModeTable;
use feeler_plant::motion::{Equations, Mode, Motion, Row, dot};
use nalgebra::DMatrix;

use crate::error::DiagnosisError;

/// Largest number of terms of a Taylor series; spans are divided so that far fewer are needed.
const MOST_TERMS: usize = 60;
/// Product of norm and span above which a span is divided before its Taylor series is computed.
const TAYLOR_REACH: f64 = 4.0;
/// Remainder of a Taylor series relative to every state.
const REMAINDER: f64 = 1e-14;
/// Number of rows that are summed in parallel.
const BLOCK: usize = 8;
/// Number of binary subdivisions of a span whose exponentials are kept.
const PARTS: i32 = 16;

/// Largest angle of the fastest oscillation between two guard evaluations, rad. Below a quarter turn, a guard
/// has at most one minimum in between, and its slopes at both ends reveal it.
const CHECK_ANGLE: f64 = 1.2;

/// Largest phase angle of a body on its bristles over one average, rad.
const BRISTLE_ANGLE: f64 = 0.5;
/// Largest number of parts of one span.
const MOST_PARTS: usize = 64;

/// Largest number of maps that a thread keeps, some 10 KB each.
const MOST_MET: usize = 512;

thread_local! {
    /// The maps over spans. A fit predicts several records with the same machine, one after the other.
    static MET: RefCell<HashMap<Vec<u64>, Rc<Blocks<f64>>>> = RefCell::default();
}

/// The flows of the modes that a machine has reached.
#[derive(Debug)]
pub(super) struct Flows {
    channels: Vec<Source>,
    /// Spacing of rows, s, and number of guard evaluations in a row.
    spacing_s: f64,
    checks: usize,
    met: Vec<ModeFlow>,
}

impl Flows {
    /// An empty set of flows, for these channels and rows.
    pub(super) fn new(channels: Vec<Source>, spacing_s: f64, checks: usize) -> Self {
        Self { channels, spacing_s, checks, met: Vec::new() }
    }

    /// The index of a mode's flow, which is built at its first use.
    pub(super) fn number_of(&mut self, motion: &Motion, mode: Mode) -> usize {
        if let Some(i) = self.met.iter().position(|flow| flow.equations.mode == mode) {
            return i;
        }
        self.met.push(ModeFlow::new(motion, mode, &self.channels, self.spacing_s, self.checks));
        self.met.len() - 1
    }
}

impl ModeTable for Flows {
    type Error = Infallible;

    fn index_of(&mut self, motion: &Motion, mode: Mode) -> Result<usize, Infallible> {
        Ok(self.number_of(motion, mode))
    }

    fn equations(&self, index: usize) -> &Equations {
        &self.met[index].equations
    }
}

impl Index<usize> for Flows {
    type Output = ModeFlow;

    #[inline]
    fn index(&self, index: usize) -> &ModeFlow {
        &self.met[index]
    }
}

impl IndexMut<usize> for Flows {
    #[inline]
    fn index_mut(&mut self, index: usize) -> &mut ModeFlow {
        &mut self.met[index]
    }
}

#[derive(Clone, Debug)]
pub(super) struct ModeFlow {
    pub(super) equations: Equations,
    pub(super) linear: bool,
    states: usize,
    width: usize,
    /// Derivatives of the states, row by row.
    derivative: Vec<f64>,
    /// The derivatives in blocks of [`BLOCK`] rows, each stored by columns.
    blocks: Vec<f64>,
    /// Work space for two terms of a Taylor series, and for intermediate states.
    scratch: [Vec<f64>; 2],
    moved: Vec<f64>,
    /// Bound on the rates of the mode, 1/s.
    norm: f64,
    /// Frequency of bodies on sliding bristles, 1/s; zero without bristles.
    bristles_per_s: f64,
    /// Signals of every row: the channels, then position, speed and force of the first drive, then the
    /// contacts' forces and compressions.
    signal_rows: Blocks<f64>,
    /// For each span, the matrix that advances the states and evaluates the guards at each check.
    spans: Vec<(u64, Rc<Blocks<f64>>)>,
    /// The longest span; others are halves and quarters of it.
    longest_s: f64,
    /// Number of guard evaluations in the longest span.
    checks: usize,
    /// Time between two guard evaluations; `None` until first needed.
    look_s: Option<f64>,
}

impl ModeFlow {
    fn new(motion: &Motion, mode: Mode, channels: &[Source], longest_s: f64, checks: usize) -> Self {
        let equations = motion.equations(mode);
        let layout = motion.layout();
        let (states, width) = (layout.states(), layout.width());
        let derivative: Vec<f64> = equations.derivative.iter().flat_map(|row| row.iter().copied()).collect();
        let padded = states.next_multiple_of(BLOCK);
        let mut blocks = vec![0.0; padded * width];
        for (i, row) in derivative.chunks_exact(width).enumerate() {
            for (j, &entry) in row.iter().enumerate() {
                blocks[(i / BLOCK * width + j) * BLOCK + i % BLOCK] = entry;
            }
        }
        let scratch = [(); 2].map(|()| vec![0.0; padded.max(width)]);
        let n = layout.coordinates();
        let sum = |entries: &[f64]| entries.iter().map(|a| a.abs()).sum::<f64>();
        // In coordinates scaled by the frequency, a ratio of stiffness to mass counts with its square root.
        let rate = |(i, row): (usize, &[f64])| match i {
            i if i < n => 0.0,
            i if i < 2 * n => sum(&row[..n]).sqrt() + sum(&row[n..2 * n]),
            i => row[i].abs(),
        };
        let norm = derivative.chunks_exact(width).enumerate().map(rate).fold(0.0, f64::max);
        let bent = (0..motion.assembly().links.len()).filter_map(|i| layout.bristle(i));
        let stiffest =
            |z: usize| (0..n).map(|g| equations.derivative[layout.v(g)][z].abs()).fold(0.0, f64::max);
        let slides = equations.arguments.iter().any(Option::is_some);
        let bristles_per_s = bent.filter(|_| slides).map(stiffest).fold(0.0, f64::max).sqrt();
        let none = Row::new();
        let mut rows: Vec<Row> =
            channels.iter().map(|&source| motion.signal(&equations, source).unwrap_or_default()).collect();
        let [position, speed] = equations.stroke.first().map_or([&none, &none], |[x, v]| [x, v]);
        rows.extend([position, speed, equations.drive_force.first().unwrap_or(&none)].map(Clone::clone));
        rows.extend(equations.contact_force.iter().cloned());
        rows.extend(equations.compression.iter().map(|[depth, _]| depth.clone()));
        let mut signal_rows = Blocks::zeros(rows.len(), width);
        rows.iter().enumerate().for_each(|(i, row)| signal_rows.set_row(0, i, row));
        let linear = equations.is_linear();
        let (spans, moved) = (Vec::new(), Vec::new());
        Self {
            equations,
            linear,
            states,
            width,
            derivative,
            blocks,
            scratch,
            moved,
            norm,
            bristles_per_s,
            signal_rows,
            spans,
            longest_s,
            checks,
            look_s: None,
        }
    }

    /// The longest time between two guard evaluations in which no guard has more than one minimum.
    pub(super) fn look_s(&mut self) -> Result<f64, DiagnosisError> {
        if let Some(known) = self.look_s {
            return Ok(known);
        }
        let rows = DMatrix::from_row_slice(self.states, self.width, &self.derivative);
        let own = eigenvalues(&rows.columns(0, self.states).into_owned())?;
        let fastest = own.iter().map(|lambda| lambda.im.abs()).fold(f64::MIN_POSITIVE, f64::max);
        Ok(*self.look_s.insert(CHECK_ANGLE / fastest))
    }

    /// Number of guard evaluations in a span, in proportion to those in a row.
    pub(super) fn checks_in(&self, span_s: f64) -> usize {
        ((self.checks as f64 * span_s / self.longest_s).ceil() as usize).clamp(1, self.checks)
    }

    /// Slope of a linear functional along the flow, with constant nonlinear terms.
    pub(super) fn slope(&self, row: &[f64], xi: &[f64]) -> f64 {
        row[..self.states]
            .iter()
            .zip(self.derivative.chunks_exact(self.width))
            .filter(|(factor, _)| **factor != 0.0)
            .map(|(factor, derivative)| factor * dot(derivative, xi))
            .sum()
    }

    /// The map of the states over `span_s`, with all other entries constant.
    fn exponential(&mut self, span_s: f64) -> Result<usize, DiagnosisError> {
        let key = span_s.to_bits();
        if let Some(i) = self.spans.iter().position(|(k, _)| *k == key) {
            return Ok(i);
        }
        let carried = MET.with_borrow_mut(|met| {
            let id = self.id(span_s);
            if let Some(carried) = met.get(&id) {
                return Ok(Rc::clone(carried));
            }
            if met.len() == MOST_MET {
                met.clear();
            }
            let carried = Rc::new(self.carried(span_s)?);
            met.insert(id, Rc::clone(&carried));
            Ok::<_, DiagnosisError>(carried)
        })?;
        self.spans.push((key, carried));
        Ok(self.spans.len() - 1)
    }

    /// Everything on which the map over a span depends, bit by bit.
    fn id(&self, span_s: f64) -> Vec<u64> {
        let rows = self.equations.guards.iter().flat_map(|guard| guard.row.iter());
        let numbers = self.derivative.iter().chain(rows).map(|number| number.to_bits());
        let sizes = [span_s.to_bits(), self.checks_in(span_s) as u64, self.states as u64];
        sizes.into_iter().chain(numbers).collect()
    }

    /// The matrix that advances the states over a span and evaluates the guards at each check.
    fn carried(&self, span_s: f64) -> Result<Blocks<f64>, DiagnosisError> {
        let (n, states) = (self.width, self.states);
        let mut a = DMatrix::zeros(n, n);
        a.rows_mut(0, states).copy_from(&DMatrix::from_row_slice(states, n, &self.derivative));
        let checks = self.checks_in(span_s);
        let part = expm(&(a * (span_s / checks as f64)))?;
        let guards = &self.equations.guards;
        let mut carried = Blocks::zeros(states + checks * guards.len(), n);
        let mut until = part.clone();
        for check in 0..checks {
            if check > 0 {
                until = &part * until;
            }
            for (i, guard) in guards.iter().enumerate() {
                let then: Vec<f64> = until
                    .column_iter()
                    .map(|column| guard.row.iter().zip(column.iter()).map(|(g, e)| g * e).sum())
                    .collect();
                carried.set_row(0, states + check * guards.len() + i, &then);
            }
        }
        for i in 0..states {
            carried.set_row(0, i, &until.row(i).iter().copied().collect::<Vec<_>>());
        }
        Ok(carried)
    }

    /// Advances `xi` over a recurring span. `out` receives the states, then the guards at each check, the
    /// last one at the end of the span.
    #[inline(always)]
    pub(super) fn carry(
        &mut self,
        span_s: f64,
        xi: &[f64],
        out: &mut Vec<f64>,
    ) -> Result<(), DiagnosisError> {
        let index = self.exponential(span_s)?;
        let carried = &self.spans[index].1;
        out.resize(carried.padded_rows(), 0.0);
        carried.apply(xi, out);
        Ok(())
    }

    /// The signals of a row (see [`Self::signal_rows`]).
    #[inline(always)]
    pub(super) fn evaluate_signals(&self, xi: &[f64], out: &mut Vec<f64>) {
        out.resize(self.signal_rows.padded_rows(), 0.0);
        self.signal_rows.apply(xi, out);
    }

    /// Advances the extended vector over a span into `out`.
    pub(super) fn move_by(
        &mut self,
        span_s: f64,
        recurring: bool,
        xi: &[f64],
        out: &mut Vec<f64>,
    ) -> Result<(), DiagnosisError> {
        if recurring {
            dispatch(
                #[inline(always)]
                || self.carry(span_s, xi, out),
            )?;
            out.truncate(self.states);
            out.extend_from_slice(&xi[self.states..]);
        } else {
            self.carry_once(span_s, xi, out)?;
        }
        Ok(())
    }

    /// Number of parts of a span over which nonlinear terms are averaged separately, because sliding bristles
    /// are stiff.
    pub(super) fn parts(&self, span_s: f64) -> usize {
        ((self.bristles_per_s * span_s / BRISTLE_ANGLE).ceil() as usize).clamp(1, MOST_PARTS)
    }

    pub(super) fn has_sliding_bristles(&self) -> bool {
        self.bristles_per_s > 0.0
    }

    pub(super) fn states(&self) -> usize {
        self.states
    }

    /// Advances `xi` over any span, into `out`. It uses halves, quarters and so on of the longest span, whose
    /// exponentials are kept, and a Taylor series for the rest. A stiff mode therefore costs no more than a
    /// soft one.
    pub(super) fn carry_once(
        &mut self,
        span_s: f64,
        xi: &[f64],
        out: &mut Vec<f64>,
    ) -> Result<(), DiagnosisError> {
        dispatch(
            #[inline(always)]
            || self.carry_once_by_blocks(span_s, xi, out),
        )
    }

    #[inline(always)]
    fn carry_once_by_blocks(
        &mut self,
        span_s: f64,
        xi: &[f64],
        out: &mut Vec<f64>,
    ) -> Result<(), DiagnosisError> {
        out.clear();
        out.extend_from_slice(xi);
        let mut left = span_s;
        if self.norm * span_s > TAYLOR_REACH {
            let mut moved = std::mem::take(&mut self.moved);
            for i in 0..PARTS {
                let part = self.longest_s * 0.5_f64.powi(i);
                if left >= part {
                    self.carry(part, out, &mut moved)?;
                    out[..self.states].copy_from_slice(&moved[..self.states]);
                    left -= part;
                }
                if self.norm * left <= TAYLOR_REACH {
                    break;
                }
            }
            self.moved = moved;
        }
        self.taylor(left, out);
        Ok(())
    }

    /// Advances `out` by its Taylor series.
    #[inline(always)]
    fn taylor(&mut self, span_s: f64, out: &mut [f64]) {
        let parts = (self.norm * span_s / TAYLOR_REACH).ceil().max(1.0);
        let h = span_s / parts;
        let [term, next] = &mut self.scratch;
        for _ in 0..parts as usize {
            term[..self.width].copy_from_slice(out);
            // Inputs, the constant and held terms have no derivative, so only the first term includes them.
            let mut columns = self.width;
            for k in 1..MOST_TERMS {
                for (block, next) in
                    self.blocks.chunks_exact(BLOCK * self.width).zip(next.chunks_exact_mut(BLOCK))
                {
                    let mut sums = [0.0; BLOCK];
                    for (column, x) in block.chunks_exact(BLOCK).zip(&term[..columns]) {
                        for (sum, a) in sums.iter_mut().zip(column) {
                            *sum += a * x;
                        }
                    }
                    next.copy_from_slice(&sums.map(|sum| sum * h / k as f64));
                }
                columns = self.states;
                let (mut is_settled, mut whole) = (true, 0.0_f64);
                for (out, next) in out[..self.states].iter_mut().zip(&next[..self.states]) {
                    *out += next;
                    is_settled &= next.abs() < REMAINDER * (out.abs() + f64::MIN_POSITIVE);
                    whole += next.abs();
                }
                std::mem::swap(term, next);
                if whole == 0.0 || (is_settled && k > self.states) {
                    break;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
