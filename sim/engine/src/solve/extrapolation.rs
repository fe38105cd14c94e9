//! Modes without a matrix exponential: Gragg-Bulirsch-Stoer extrapolation of the modified midpoint rule, to
//! machine precision.
//!
//! Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.9. Steps adapt until two
//! columns of the extrapolation table agree to [`TOLERANCE`]. The result is as accurate as that of the linear
//! modes.

use feeler_plant::motion::{Motion, dot};

use crate::solve::flow::Flow;

/// Columns of the extrapolation table; order 2 per column.
const COLUMNS: usize = 9;
/// Required agreement of two columns, relative to the size of each state over the step. For a speed that size
/// is at least the speed that the energy of the pushing body would give it.
const TOLERANCE: f64 = 4e-14;
/// Alternatively, required agreement relative to the parts of the state. It applies to differences so small
/// that only rounding remains. It is a few units in the last place of each part, summed over the midpoint
/// rule's substeps.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
/// A step that converges by this column may be doubled.
const EASY_COLUMN: usize = 5;
/// Smallest step as a share of the requested span. A kink of the motion is then crossed directly; the error
/// is the square of so short a time.
const SMALLEST_SHARE: f64 = 1e-9;
/// Relative shift of an argument for the slope of a law.
const SLOPE_SHIFT: f64 = 1e-6;

/// Workspace of the method.
#[derive(Debug, Default)]
pub(crate) struct Extrapolation {
    table: Vec<Vec<f64>>,
    /// Extended vectors of the midpoint rule.
    previous: Vec<f64>,
    current: Vec<f64>,
    slope: Vec<f64>,
    first_slope: Vec<f64>,
    pub(crate) attempts: u64,
    /// Expected length of the next step, s; `None` at first.
    reach_s: Option<f64>,
}

/// `x'` and the power of as many meters as fit into `out`, at a full extended vector with its terms filled
/// in.
fn derivative(flow: &Flow, xi: &[f64], out: &mut [f64]) {
    let (states, powers) = out.split_at_mut(flow.states);
    for (o, row) in states.iter_mut().zip(&flow.equations.derivative) {
        *o = dot(row, xi);
    }
    for (power, meter) in powers.iter_mut().zip(&flow.ledger.meters) {
        *power = dot(&meter.force, xi) * dot(&meter.speed, xi);
    }
}

/// Sum of the magnitudes of the parts of a functional, which bounds its rounding.
fn parts(row: &[f64], sizes: &[f64]) -> f64 {
    row.iter().zip(sizes).map(|(r, size)| r.abs() * size).sum()
}

/// Sizes of the entries of an extended vector. The size of a nonlinear term is at least its value for
/// separate arguments. A small difference of two large positions is no more accurate than they are.
fn sizes(motion: &Motion, flow: &Flow, xi: &[f64]) -> Vec<f64> {
    let mut sizes: Vec<f64> = xi.iter().map(|x| x.abs()).collect();
    for (j, arguments) in flow.equations.arguments.iter().enumerate() {
        if let Some(rows) = arguments {
            let [a, b] = rows.each_ref().map(|row| dot(row, xi));
            let [shift_a, shift_b] = rows.each_ref().map(|row| SLOPE_SHIFT * parts(row, &sizes));
            let term = &motion.terms()[j];
            let value = term.value(a, b);
            let moved =
                (term.value(a + shift_a, b) - value).abs() + (term.value(a, b + shift_b) - value).abs();
            sizes[motion.layout().term(j)] = value.abs().max(moved / SLOPE_SHIFT);
        }
    }
    sizes
}

fn kinetic_energy(motion: &Motion, xi: &[f64]) -> f64 {
    (0..motion.coordinates().count())
        .map(|g| 0.5 * motion.coordinates().mass_kg(g) * xi[motion.layout().v(g)].powi(2))
        .sum()
}

/// An upper estimate of the speed of each coordinate. It has all kinetic energy of the bodies to which
/// nonlinear contacts join it, but at most the speed of the fastest of them.
///
/// A body that another one begins to push starts from rest by some power of time. Relative to itself this
/// motion is never smooth, however short the step. The motion of the pushing body gives its error a scale.
fn swift(motion: &Motion, flow: &Flow, xi: &[f64]) -> Vec<f64> {
    let mass_kg = |g: usize| motion.coordinates().mass_kg(g);
    let speed = |g: usize| xi[motion.layout().v(g)].abs();
    let mut speeds = vec![0.0; motion.coordinates().count()];
    for group in &flow.coupled {
        let joule: f64 = group.iter().map(|&g| 0.5 * mass_kg(g) * speed(g).powi(2)).sum();
        let fastest = group.iter().map(|&g| speed(g)).fold(0.0, f64::max);
        for &g in group {
            speeds[g] = (2.0 * joule / mass_kg(g)).sqrt().min(fastest);
        }
    }
    speeds
}

impl Extrapolation {
    /// Advances `xi` (full extended vector) and the meter readings (if any) by as much of `span_s` as one
    /// step allows, and returns that time. `None` if the motion is not finite.
    pub(crate) fn step(
        &mut self,
        motion: &Motion,
        flow: &Flow,
        xi: &mut [f64],
        meters: &mut [f64],
        span_s: f64,
    ) -> Option<f64> {
        let mut h = self.reach_s.map_or(span_s, |reach| reach.min(span_s));
        loop {
            let last_resort = h <= SMALLEST_SHARE * span_s;
            if let Some((result, column)) = self.attempt(motion, flow, xi, meters, h, last_resort) {
                let reach = if column <= EASY_COLUMN { 2.0 * h } else { h };
                // A step that the end of the span cuts short does not limit the next step.
                self.reach_s = Some(if h < span_s {
                    reach
                } else {
                    self.reach_s.map_or(reach, |known| known.max(reach))
                });
                xi[..flow.states].copy_from_slice(&result[..flow.states]);
                for (meter, gain) in meters.iter_mut().zip(&result[flow.states..]) {
                    *meter += gain;
                }
                motion.fill_terms(&flow.equations, xi);
                return Some(h);
            }
            if last_resort {
                return None;
            }
            h *= 0.5;
        }
    }

    /// One step of `h`, and the column at which it converged. As a last resort it returns a result that has
    /// not converged.
    fn attempt(
        &mut self,
        motion: &Motion,
        flow: &Flow,
        xi: &[f64],
        meters: &[f64],
        h: f64,
        last_resort: bool,
    ) -> Option<(Vec<f64>, usize)> {
        let (states, n) = (flow.states, flow.states + meters.len());
        self.attempts += 1;
        self.table.clear();
        self.first_slope.resize(n, 0.0);
        derivative(flow, xi, &mut self.first_slope);
        let entries: Vec<f64> = xi.iter().map(|x| x.abs()).collect();
        let rows = || flow.equations.derivative.iter().enumerate();
        let over_step =
            |sizes: &[f64]| rows().map(|(i, row)| sizes[i].max(h * parts(row, sizes))).collect::<Vec<f64>>();
        let mut size = over_step(&entries);
        let mut rounding: Vec<f64> =
            over_step(&sizes(motion, flow, xi)).iter().map(|parts| ROUNDING * parts).collect();
        let swift = swift(motion, flow, xi);
        for (g, speed) in swift.iter().enumerate() {
            for (state, least) in [(motion.layout().q(g), h * speed), (motion.layout().v(g), *speed)] {
                size[state] = size[state].max(least);
            }
        }
        // Meters are weighted as shares of the available energy.
        let counted: f64 = meters.iter().map(|joule| joule.abs()).sum();
        size.resize(n, 0.0);
        rounding.resize(n, f64::MIN_POSITIVE);
        for column in 0..COLUMNS {
            let substeps = 2 * (column + 1);
            let mut row = self.midpoint(motion, flow, xi, h, substeps, n);
            let energy = counted + kinetic_energy(motion, xi).max(kinetic_energy(motion, &row));
            for (i, (s, r)) in size.iter_mut().zip(&row).enumerate() {
                *s = s.max(r.abs()).max(if i < states { 0.0 } else { energy });
            }
            // Aitken-Neville in h^2; `row` becomes the newest diagonal entry, the table keeps the last entry
            // of each column.
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
            if row.iter().any(|x| !x.is_finite()) {
                return None;
            }
            let converged = error.iter().zip(&size).zip(&rounding).all(|((e, s), r)| *e <= TOLERANCE * s + r);
            if column >= 3 && (converged || last_resort) {
                return Some((row, column));
            }
            self.table.push(row);
        }
        None
    }

    /// The smoothed modified midpoint rule over `h` in `substeps` (even) parts; meters start at zero.
    fn midpoint(
        &mut self,
        motion: &Motion,
        flow: &Flow,
        xi: &[f64],
        h: f64,
        substeps: usize,
        n: usize,
    ) -> Vec<f64> {
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
            motion.fill_terms(&flow.equations, &mut self.current);
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
        motion.fill_terms(&flow.equations, &mut self.current);
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
