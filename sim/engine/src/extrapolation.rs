//! Modes that no matrix exponential solves: Gragg-Bulirsch-Stoer extrapolation of the modified midpoint rule, to rounding.
//!
//! Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.9. Steps adapt until two columns of the extrapolation
//! table agree to [`TOLERANCE`], so the result is as good as that of the linear modes.

use feeler_plant::motion::Motion;

use crate::flow::Flow;

/// Columns of the extrapolation table; order 2 per column.
const COLUMNS: usize = 9;
/// Agreement of two columns relative to the size of each state over the step.
const TOLERANCE: f64 = 4e-14;
/// Steps are not cut below this share of the span asked for: the motion then has no smooth solution at working precision.
const SMALLEST_SHARE: f64 = 1e-9;

/// Workspace of the method.
#[derive(Debug, Default)]
pub(crate) struct Extrapolation {
    table: Vec<Vec<f64>>,
    /// Extended vectors of the midpoint rule.
    previous: Vec<f64>,
    current: Vec<f64>,
    slope: Vec<f64>,
    first_slope: Vec<f64>,
}

/// Fills in the nonlinear terms of an extended vector.
pub(crate) fn fill_terms(motion: &Motion, flow: &Flow, xi: &mut [f64]) {
    for (j, arguments) in flow.equations.arguments.iter().enumerate() {
        if let Some([a, b]) = arguments {
            let value = |row: &[f64]| row.iter().zip(xi.iter()).map(|(r, x)| r * x).sum::<f64>();
            let (a, b) = (value(a), value(b));
            xi[motion.layout().term(j)] = motion.terms()[j].value(a, b);
        }
    }
}

/// `x'` and the power of every meter at a full extended vector whose terms are filled in.
fn derivative(flow: &Flow, xi: &[f64], out: &mut [f64]) {
    let dot = |row: &[f64]| row.iter().zip(xi).map(|(r, x)| r * x).sum::<f64>();
    let (states, powers) = out.split_at_mut(flow.states);
    for (o, row) in states.iter_mut().zip(&flow.equations.derivative) {
        *o = dot(row);
    }
    for (power, meter) in powers.iter_mut().zip(&flow.ledger.meters) {
        *power = dot(&meter.force) * dot(&meter.speed);
    }
}

impl Extrapolation {
    /// Advances `xi` (full extended vector) and the meter readings by as much of `span_s` as one step allows, and gives what it advanced;
    /// `None` where no step, however small, converges.
    pub(crate) fn step(&mut self, motion: &Motion, flow: &Flow, xi: &mut [f64], meters: &mut [f64], span_s: f64) -> Option<f64> {
        let mut h = span_s;
        while h >= SMALLEST_SHARE * span_s {
            if let Some(result) = self.attempt(motion, flow, xi, h) {
                xi[..flow.states].copy_from_slice(&result[..flow.states]);
                for (meter, gain) in meters.iter_mut().zip(&result[flow.states..]) {
                    *meter += gain;
                }
                fill_terms(motion, flow, xi);
                return Some(h);
            }
            h *= 0.5;
        }
        None
    }

    fn attempt(&mut self, motion: &Motion, flow: &Flow, xi: &[f64], h: f64) -> Option<Vec<f64>> {
        let n = flow.states + flow.ledger.meters.len();
        self.table.clear();
        self.first_slope.resize(n, 0.0);
        derivative(flow, xi, &mut self.first_slope);
        let mut size: Vec<f64> = (0..n).map(|i| if i < flow.states { xi[i].abs() } else { 0.0 }).collect();
        for (s, slope) in size.iter_mut().zip(&self.first_slope) {
            *s = s.max((h * slope).abs());
        }
        for column in 0..COLUMNS {
            let substeps = 2 * (column + 1);
            let mut row = self.midpoint(motion, flow, xi, h, substeps, n);
            for (s, r) in size.iter_mut().zip(&row) {
                *s = s.max(r.abs());
            }
            // Aitken-Neville in h^2; `row` becomes the newest diagonal entry, the table keeps the last entry of each column.
            let mut error = vec![f64::INFINITY; n];
            for k in 0..column {
                let ratio = (substeps as f64 / (2 * (column - k)) as f64).powi(2);
                let older = &mut self.table[k];
                for i in 0..n {
                    let better = row[i] + (row[i] - older[i]) / (ratio - 1.0);
                    error[i] = (better - row[i]).abs();
                    older[i] = row[i];
                    row[i] = better;
                }
            }
            if column >= 3 && error.iter().zip(&size).all(|(e, s)| *e <= TOLERANCE * s + f64::MIN_POSITIVE) {
                return Some(row);
            }
            if row.iter().any(|x| !x.is_finite()) {
                return None;
            }
            self.table.push(row);
        }
        None
    }

    /// The smoothed modified midpoint rule over `h` in `substeps` (even) parts; meters start at zero.
    fn midpoint(&mut self, motion: &Motion, flow: &Flow, xi: &[f64], h: f64, substeps: usize, n: usize) -> Vec<f64> {
        let states = flow.states;
        let part = h / substeps as f64;
        self.slope.resize(n, 0.0);
        self.previous = xi.to_vec();
        self.current = xi.to_vec();
        let mut previous_meters = vec![0.0; n - states];
        let mut meters: Vec<f64> = self.first_slope[states..].iter().map(|slope| part * slope).collect();
        for (x, slope) in self.current[..states].iter_mut().zip(&self.first_slope) {
            *x += part * slope;
        }
        for _ in 1..substeps {
            fill_terms(motion, flow, &mut self.current);
            derivative(flow, &self.current, &mut self.slope);
            for i in 0..states {
                let next = self.previous[i] + 2.0 * part * self.slope[i];
                self.previous[i] = self.current[i];
                self.current[i] = next;
            }
            for i in 0..meters.len() {
                let next = previous_meters[i] + 2.0 * part * self.slope[states + i];
                previous_meters[i] = meters[i];
                meters[i] = next;
            }
        }
        fill_terms(motion, flow, &mut self.current);
        derivative(flow, &self.current, &mut self.slope);
        let mut result = Vec::with_capacity(n);
        for i in 0..states {
            result.push(0.5 * (self.current[i] + self.previous[i] + part * self.slope[i]));
        }
        for i in 0..meters.len() {
            result.push(0.5 * (meters[i] + previous_meters[i] + part * self.slope[states + i]));
        }
        result
    }
}
