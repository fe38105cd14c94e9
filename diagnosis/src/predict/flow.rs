//! One mode of one machine: its rows, and how they carry the state over a span.

use feeler_lti::expm;
use feeler_plant::assembly::Source;
use feeler_plant::motion::{Equations, Mode, Motion, Row};
use nalgebra::DMatrix;

use crate::error::DiagnosisError;

/// Terms after which a Taylor series is given up; spans are cut so that far fewer are needed.
const MOST_TERMS: usize = 60;
/// Norm times span above which a span is cut before its Taylor series is taken.
const TAYLOR_REACH: f64 = 4.0;

/// One mode.
#[derive(Clone, Debug)]
pub(super) struct Flow {
    pub(super) equations: Equations,
    pub(super) linear: bool,
    states: usize,
    width: usize,
    /// Derivatives of the states, row by row.
    derivative: Vec<f64>,
    /// How fast the mode moves, 1/s.
    norm: f64,
    /// Rows of the channels; none for what no row tells.
    pub(super) outputs: Vec<Option<Row>>,
    /// Exponentials by span.
    spans: Vec<(u64, Vec<f64>)>,
}

impl Flow {
    pub(super) fn new(motion: &Motion, mode: Mode, channels: &[Source]) -> Self {
        let equations = motion.equations(mode);
        let layout = motion.layout();
        let (states, width) = (layout.states(), layout.width());
        let derivative: Vec<f64> = equations.derivative.iter().flat_map(|row| row.iter().copied()).collect();
        let n = layout.coordinates();
        let sum = |entries: &[f64]| entries.iter().map(|a| a.abs()).sum::<f64>();
        // In coordinates scaled by the frequency itself a stiffness over a mass counts with its square root.
        let rate = |(i, row): (usize, &[f64])| match i {
            i if i < n => 0.0,
            i if i < 2 * n => sum(&row[..n]).sqrt() + sum(&row[n..2 * n]),
            i => row[i].abs(),
        };
        let norm = derivative.chunks_exact(width).enumerate().map(rate).fold(0.0, f64::max);
        let outputs = channels.iter().map(|&source| motion.signal(&equations, source)).collect();
        Self { linear: equations.is_linear(), equations, states, width, derivative, norm, outputs, spans: Vec::new() }
    }

    /// The rows that carry the states over `span_s` with everything else held.
    fn exponential(&mut self, span_s: f64) -> Result<&[f64], DiagnosisError> {
        let key = span_s.to_bits();
        if let Some(i) = self.spans.iter().position(|(k, _)| *k == key) {
            return Ok(&self.spans[i].1);
        }
        let n = self.width;
        let mut a = DMatrix::zeros(n, n);
        a.rows_mut(0, self.states).copy_from(&DMatrix::from_row_slice(self.states, n, &self.derivative));
        let e = expm(&(a * span_s))?;
        let rows = (0..self.states).flat_map(|i| (0..n).map(|j| e[(i, j)]).collect::<Vec<_>>()).collect();
        self.spans.push((key, rows));
        Ok(&self.spans[self.spans.len() - 1].1)
    }

    /// Carries `xi` over a span that recurs, into `out`.
    pub(super) fn carry(&mut self, span_s: f64, xi: &[f64], out: &mut Vec<f64>) -> Result<(), DiagnosisError> {
        let (states, width) = (self.states, self.width);
        let rows = self.exponential(span_s)?;
        out.clear();
        out.extend(rows.chunks_exact(width).take(states).map(|row| dot(row, xi)));
        out.extend_from_slice(&xi[states..]);
        Ok(())
    }

    /// Carries `xi` over any span by its Taylor series, into `out`.
    pub(super) fn carry_once(&self, span_s: f64, xi: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.extend_from_slice(xi);
        let parts = (self.norm * span_s / TAYLOR_REACH).ceil().max(1.0);
        let h = span_s / parts;
        let mut term = vec![0.0; self.width];
        let mut next = vec![0.0; self.width];
        for _ in 0..parts as usize {
            term.copy_from_slice(out);
            for k in 1..MOST_TERMS {
                let (mut size, mut whole) = (0.0_f64, 0.0_f64);
                for (i, row) in self.derivative.chunks_exact(self.width).enumerate() {
                    next[i] = dot(row, &term) * h / k as f64;
                }
                for i in 0..self.states {
                    out[i] += next[i];
                    size = size.max(next[i].abs() / (out[i].abs() + f64::MIN_POSITIVE));
                    whole += next[i].abs();
                }
                // Inputs, the constant and held terms have no derivative.
                next[self.states..].fill(0.0);
                std::mem::swap(&mut term, &mut next);
                if whole == 0.0 || (size < 1e-14 && k > self.states) {
                    break;
                }
            }
        }
    }
}

pub(super) fn dot(row: &[f64], xi: &[f64]) -> f64 {
    row.iter().zip(xi).map(|(r, x)| r * x).sum()
}
