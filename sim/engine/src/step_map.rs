//! One step of a fixed-step method in a linear mode: as the inputs are held, the whole step is a linear map, formed once per mode.
//!
//! With `M` the derivative of the extended vector, an RK4 step is the polynomial `I + hM + (hM)^2/2 + (hM)^3/6 + (hM)^4/24` of it, and a semi-implicit
//! Euler step is `v += h M_v xi`, then `q += h v`: the same methods with the same errors, but for rounding.

use feeler_lanes::{Blocks, Lane, LaneMask};
use nalgebra::DMatrix;

use crate::flow::Flow;
use crate::lane::LaneCore;
use crate::scenario::Integrator;

/// The step of every lane, each in its own mode.
#[derive(Debug)]
pub(crate) struct StepMap<L> {
    /// Length of the step, s.
    pub(crate) step_s: f64,
    filled_at: u64,
    filled_for: Vec<usize>,
    /// The states after the step, then the guards.
    matrix: Blocks<L>,
    width: usize,
    states: usize,
    guards: usize,
}

impl<L: Lane> StepMap<L> {
    pub(crate) fn new(step_s: f64, lanes: &[LaneCore]) -> Self {
        let layout = lanes[0].motion.layout();
        let (states, width) = (layout.states(), layout.linear_width());
        let matrix = Blocks::zeros(states, width);
        Self { step_s, filled_at: 0, filled_for: vec![usize::MAX; L::WIDTH], matrix, width, states, guards: 0 }
    }

    /// Fills in the rows of lanes whose mode has changed since, where it is linear.
    pub(crate) fn refresh(&mut self, method: Integrator, formation: u64, lanes: &[LaneCore]) {
        if self.filled_at == formation {
            return;
        }
        self.filled_at = formation;
        let most = lanes.iter().map(|lane| lane.flow().equations.guards.len()).max().unwrap_or(0);
        if most > self.guards {
            self.guards = most;
            self.matrix = Blocks::zeros(self.states + most, self.width);
            self.filled_for.fill(usize::MAX);
        }
        for (l, lane) in lanes.iter().enumerate().filter(|(_, lane)| lane.flow().linear && !lane.has_ended()) {
            if self.filled_for[l] == lane.current {
                continue;
            }
            self.filled_for[l] = lane.current;
            let coordinates = lane.motion.layout().coordinates();
            let step = map(lane.flow(), method, coordinates, self.step_s);
            let row = |i: usize| step.row(i).iter().copied().collect::<Vec<_>>();
            for i in 0..self.states {
                self.matrix.set_row(l, i, &row(i));
            }
            for i in 0..self.guards {
                let guard = lane.flow().equations.guards.get(i);
                // A guard that this lane does not have reads zero, which is no crossing.
                let after = guard.map_or_else(Vec::new, |guard| {
                    (0..self.width).map(|j| guard.row.iter().zip(step.column(j).iter()).map(|(g, s)| g * s).sum()).collect()
                });
                self.matrix.set_row(l, self.states + i, &after);
            }
        }
    }

    /// Rows of the product, padded.
    pub(crate) fn padded_rows(&self) -> usize {
        self.matrix.padded_rows()
    }

    /// Moves the lanes of `here` by up to `most` steps and gives how many: fewer where a lane has left its mode at the end of one (first mask), or has left all
    /// bounds and stays where it was (second).
    #[inline(always)]
    pub(crate) fn steps(&self, most: u64, here: L::Mask, xi: &mut [L], y: &mut [L]) -> (u64, L::Mask, L::Mask) {
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

/// The step over the extended vector, a square matrix: inputs and the constant stay.
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
