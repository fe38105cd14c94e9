//! One step of a fixed-step method in a linear mode. With held inputs the whole step is a linear map,
//! computed once per mode.
//!
//! With `M` the derivative of the extended vector, an RK4 step is the polynomial `I + hM + (hM)^2/2 +
//! (hM)^3/6 + (hM)^4/24`. A semi-implicit Euler step is `v += h M_v xi`, then `q += h v`. These are the same
//! methods with the same errors, up to rounding.

use feeler_lanes::{Blocks, Lane, LaneMask};
use nalgebra::DMatrix;

use crate::carry::lane::LaneCore;
use crate::run::settings::Integrator;
use crate::solve::flow::Flow;

/// Largest share of nonzero entries for which a large map is stored as lists. Bodies mostly touch their
/// neighbours, so the cost grows with their number and not with its square.
const SPARSE_SHARE: f64 = 0.3;
/// Maps with up to this number of states are always stored whole.
const SMALL: usize = 12;

/// A map in the form that is applied fastest.
#[derive(Debug)]
enum Matrix<L> {
    Whole(Blocks<L>),
    /// For each row, its start in the lists of columns and factors.
    Lists {
        starts: Vec<usize>,
        columns: Vec<usize>,
        factors: Vec<L>,
    },
}

impl<L: Lane> Matrix<L> {
    /// From one matrix per lane, row by row.
    fn new(of_lanes: &[Vec<f64>], width: usize) -> Self {
        let rows = of_lanes[0].len() / width;
        let used = |at: usize| of_lanes.iter().any(|matrix| matrix[at] != 0.0);
        let count = (0..rows * width).filter(|&at| used(at)).count();
        if rows <= SMALL || count as f64 > SPARSE_SHARE * (rows * width) as f64 {
            let mut blocks = Blocks::zeros(rows, width);
            for (l, matrix) in of_lanes.iter().enumerate() {
                matrix.chunks_exact(width).enumerate().for_each(|(i, row)| blocks.set_row(l, i, row));
            }
            return Self::Whole(blocks);
        }
        let (mut starts, mut columns, mut factors) = (vec![0], Vec::new(), Vec::new());
        for i in 0..rows {
            for j in (0..width).filter(|&j| used(i * width + j)) {
                columns.push(j);
                factors.push(L::from_fn(|l| of_lanes[l][i * width + j]));
            }
            starts.push(columns.len());
        }
        Self::Lists { starts, columns, factors }
    }

    fn padded_rows(&self) -> usize {
        match self {
            Self::Whole(blocks) => blocks.padded_rows(),
            Self::Lists { starts, .. } => starts.len() - 1,
        }
    }

    #[inline(always)]
    fn apply(&self, xi: &[L], y: &mut [L]) {
        match self {
            Self::Whole(blocks) => blocks.apply(xi, y),
            Self::Lists { starts, columns, factors } => {
                for (y, ends) in y.iter_mut().zip(starts.windows(2)) {
                    let mut sum = L::zero();
                    for (&j, &factor) in columns[ends[0]..ends[1]].iter().zip(&factors[ends[0]..ends[1]]) {
                        sum = factor.mul_add(xi[j], sum);
                    }
                    *y = sum;
                }
            }
        }
    }
}

/// The step of every lane, each in its own mode.
#[derive(Debug)]
pub(crate) struct StepMap<L> {
    /// Length of the step, s.
    pub(super) step_s: f64,
    filled_at: u64,
    filled_for: Vec<usize>,
    /// Rows of each lane: the states after the step, then the guards.
    of_lanes: Vec<Vec<f64>>,
    /// Rows of all lanes, side by side.
    matrix: Matrix<L>,
    width: usize,
    states: usize,
    guards: usize,
}

impl<L: Lane> StepMap<L> {
    pub(crate) fn new(step_s: f64, lanes: &[LaneCore]) -> Self {
        let layout = lanes[0].motion.layout();
        let (states, width) = (layout.states(), layout.linear_width());
        let of_lanes = vec![vec![0.0; states * width]; L::WIDTH];
        let matrix = Matrix::new(&of_lanes, width);
        Self {
            step_s,
            filled_at: 0,
            filled_for: vec![usize::MAX; L::WIDTH],
            of_lanes,
            matrix,
            width,
            states,
            guards: 0,
        }
    }

    /// Fills in the rows of lanes whose mode has changed, if it is linear.
    pub(crate) fn refresh(&mut self, method: Integrator, formation: u64, lanes: &[LaneCore]) {
        if self.filled_at == formation {
            return;
        }
        self.filled_at = formation;
        let most = lanes.iter().map(|lane| lane.flow().equations.guards.len()).max().unwrap_or(0);
        let mut changed = most > self.guards;
        if changed {
            self.guards = most;
            // A guard that a lane does not have reads zero, which is not a crossing.
            self.of_lanes.iter_mut().for_each(|rows| rows.resize((self.states + most) * self.width, 0.0));
        }
        for (l, lane) in lanes.iter().enumerate().filter(|(_, lane)| lane.flow().linear && !lane.has_ended())
        {
            if self.filled_for[l] == lane.current {
                continue;
            }
            self.filled_for[l] = lane.current;
            changed = true;
            let step = map(lane.flow(), method, lane.motion.layout().coordinates(), self.step_s);
            let (states, guards) = self.of_lanes[l].split_at_mut(self.states * self.width);
            for (i, row) in states.chunks_exact_mut(self.width).enumerate() {
                row.iter_mut().zip(step.row(i).iter()).for_each(|(entry, step)| *entry = *step);
            }
            guards.fill(0.0);
            for (row, guard) in guards.chunks_exact_mut(self.width).zip(&lane.flow().equations.guards) {
                for (entry, column) in row.iter_mut().zip(step.column_iter()) {
                    *entry = guard.row.iter().zip(column.iter()).map(|(g, s)| g * s).sum();
                }
            }
        }
        if changed {
            self.matrix = Matrix::new(&self.of_lanes, self.width);
        }
    }

    /// Rows of the product, padded.
    pub(crate) fn padded_rows(&self) -> usize {
        self.matrix.padded_rows()
    }

    /// Moves the lanes of `here` by up to `most` steps and returns the number of steps. The number is smaller
    /// if a lane has left its mode at the end of a step (first mask). It is also smaller if a lane has
    /// diverged; that lane stays where it was (second mask).
    #[inline(always)]
    pub(crate) fn steps(
        &self,
        most: u64,
        here: L::Mask,
        xi: &mut [L],
        y: &mut [L],
    ) -> (u64, L::Mask, L::Mask) {
        let (zero, bound) = (L::zero(), L::splat(LaneCore::BOUND));
        for k in 0..most {
            self.matrix.apply(xi, y);
            let mut crossed = L::Mask::splat(false);
            for guard in &y[self.states..self.states + self.guards] {
                crossed = crossed | guard.lt(zero);
            }
            let mut size = zero;
            for y in &y[..self.states] {
                size += y.abs();
            }
            let (crossed, lost) = (here & crossed, here & !size.lt(bound));
            if here.all() && !lost.any() {
                xi[..self.states].copy_from_slice(&y[..self.states]);
            } else {
                let moved = here & !lost;
                for (x, &y) in xi.iter_mut().zip(y.iter()).take(self.states) {
                    *x = L::select(moved, y, *x);
                }
            }
            if (crossed | lost).any() {
                return (k + 1, crossed, lost);
            }
        }
        (most, L::Mask::splat(false), L::Mask::splat(false))
    }
}

/// The step over the extended vector as a square matrix: inputs and the constant do not change.
fn map(flow: &Flow, method: Integrator, coordinates: usize, step_s: f64) -> DMatrix<f64> {
    let n = flow.width;
    let mut rate = DMatrix::zeros(n, n);
    rate.rows_mut(0, flow.states).copy_from(&DMatrix::from_row_slice(flow.states, n, &flow.derivative));
    let rate = rate * step_s;
    let mut step = DMatrix::identity(n, n);
    if method == Integrator::Rk4 {
        // Horner's form.
        for divisor in [4.0, 3.0, 2.0, 1.0] {
            step = DMatrix::identity(n, n) + &rate * step / divisor;
        }
        return step;
    }
    step += &rate;
    for g in 0..coordinates {
        let speed = step.row(coordinates + g).into_owned();
        let mut row = speed * step_s;
        row[g] += 1.0;
        step.row_mut(g).copy_from(&row);
    }
    step
}
