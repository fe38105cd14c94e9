//! Fixed steps: semi-implicit Euler and RK4, all lanes together, events taken at the ends of steps.
//!
//! They are here to be compared with and for those who must reproduce another tool's steps. A step ends early at a controller's sample or a command's
//! arrival, so these are placed exactly; within a step the mode does not change, which makes both methods first order through an impact.

use feeler_lanes::{Lane, LaneMask, dispatch};

use crate::error::{EngineError, RunEnd};
use crate::lane::LaneCore;
use crate::scenario::Integrator;
use crate::simulation::{put_lane, take_lane};

/// Switches in one lane at the end of one step; more means that modes ask for each other.
const MOST_SWITCHES: usize = 16;
/// A remainder of a step below this share of it is rounding.
const SLIVER: f64 = 1e-9;

/// A row of the derivative or of a guard: its entries that are not zero in every lane.
type Sparse<L> = Vec<(usize, L)>;

/// Stepper of all lanes.
#[derive(Debug)]
pub(crate) struct FixedStep<L> {
    method: Integrator,
    step_s: f64,
    coordinates: usize,
    states: usize,
    /// Flow of each lane for which the rows were filled in.
    filled_for: Vec<usize>,
    derivative: Vec<Sparse<L>>,
    guards: Vec<Sparse<L>>,
    nonlinear: bool,
    slope: Vec<L>,
    sum: Vec<L>,
    probe: Vec<L>,
    /// States before the step.
    last: Vec<L>,
    scratch: Vec<f64>,
}

impl<L: Lane> FixedStep<L> {
    pub(crate) fn new(method: Integrator, step_s: f64, lanes: &[LaneCore]) -> Self {
        let layout = lanes[0].motion.layout();
        let width = layout.width();
        Self {
            method,
            step_s,
            coordinates: layout.coordinates(),
            states: layout.states(),
            filled_for: vec![usize::MAX; L::WIDTH],
            derivative: Vec::new(),
            guards: Vec::new(),
            nonlinear: false,
            slope: vec![L::zero(); layout.states()],
            sum: vec![L::zero(); layout.states()],
            probe: vec![L::zero(); width],
            last: vec![L::zero(); layout.states()],
            scratch: Vec::new(),
        }
    }

    /// Moves every lane by `span_s` and gives the number of steps.
    pub(crate) fn run(&mut self, lanes: &mut [LaneCore], xi: &mut [L], t_s: f64, span_s: f64) -> Result<u64, EngineError> {
        let steps = (span_s / self.step_s - SLIVER).ceil().max(1.0) as u64;
        for k in 0..steps {
            let start_s = k as f64 * self.step_s;
            let h = if k + 1 == steps { span_s - start_s } else { self.step_s };
            self.refresh(lanes);
            self.last.copy_from_slice(&xi[..self.states]);
            let before = powers(lanes, xi);
            match self.method {
                Integrator::Rk4 => self.rk4(lanes, xi, h),
                Integrator::SemiImplicitEuler | Integrator::Exact => self.semi_implicit_euler(lanes, xi, h),
            }
            charge(lanes, xi, &before, h);
            self.events(lanes, xi, t_s + start_s + h)?;
        }
        Ok(steps)
    }

    fn refresh(&mut self, lanes: &[LaneCore]) {
        if lanes.iter().zip(&self.filled_for).all(|(lane, &filled)| lane.current == filled) {
            return;
        }
        for (filled, lane) in self.filled_for.iter_mut().zip(lanes) {
            *filled = lane.current;
        }
        self.nonlinear = lanes.iter().any(|lane| !lane.flow().linear);
        let width = self.probe.len();
        let row = |of: &dyn Fn(&LaneCore) -> Option<Vec<f64>>| -> Sparse<L> {
            let rows: Vec<_> = lanes.iter().map(of).collect();
            let entry = |j: usize| L::from_fn(|l| rows[l].as_ref().map_or(0.0, |row| row[j]));
            (0..width).map(|j| (j, entry(j))).filter(|(_, entry)| *entry != L::zero()).collect()
        };
        self.derivative = (0..self.states).map(|i| row(&|lane| Some(lane.flow().equations.derivative[i].clone()))).collect();
        let most = lanes.iter().map(|lane| lane.flow().equations.guards.len()).max().unwrap_or(0);
        self.guards = (0..most).map(|i| row(&|lane| lane.flow().equations.guards.get(i).map(|guard| guard.row.clone()))).collect();
    }

    fn fill_terms(&mut self, lanes: &[LaneCore], xi: &mut [L]) {
        if !self.nonlinear {
            return;
        }
        for (l, lane) in lanes.iter().enumerate().filter(|(_, lane)| !lane.flow().linear) {
            take_lane(xi, l, &mut self.scratch);
            crate::extrapolation::fill_terms(&lane.motion, lane.flow(), &mut self.scratch);
            put_lane(xi, l, &self.scratch);
        }
    }

    fn semi_implicit_euler(&mut self, lanes: &[LaneCore], xi: &mut [L], h: f64) {
        self.fill_terms(lanes, xi);
        let n = self.coordinates;
        let h = L::splat(h);
        dispatch(
            #[inline(always)]
            || {
                for (slope, row) in self.slope[n..].iter_mut().zip(&self.derivative[n..]) {
                    *slope = product(row, xi);
                }
                for (x, &slope) in xi[n..self.states].iter_mut().zip(&self.slope[n..]) {
                    *x = h.mul_add(slope, *x);
                }
                for g in 0..n {
                    xi[g] = h.mul_add(xi[n + g], xi[g]);
                }
            },
        );
    }

    /// The classical method: slopes at the start, twice in the middle, at the end, weighted 1, 2, 2, 1.
    fn rk4(&mut self, lanes: &[LaneCore], xi: &mut [L], h: f64) {
        self.probe.copy_from_slice(xi);
        for (stage, (reach, weight)) in [(0.5, 1.0), (0.5, 2.0), (1.0, 2.0), (0.0, 1.0)].into_iter().enumerate() {
            let mut probe = std::mem::take(&mut self.probe);
            self.fill_terms(lanes, &mut probe);
            self.probe = probe;
            let (reach, weight) = (L::splat(reach * h), L::splat(weight));
            dispatch(
                #[inline(always)]
                || {
                    for (slope, row) in self.slope.iter_mut().zip(&self.derivative) {
                        *slope = product(row, &self.probe);
                    }
                    let states = self.slope.iter().zip(&mut self.sum).zip(&mut self.probe).zip(xi.iter());
                    for (((&slope, sum), probe), &x) in states {
                        *sum = if stage == 0 { slope } else { weight.mul_add(slope, *sum) };
                        *probe = reach.mul_add(slope, x);
                    }
                },
            );
        }
        let sixth = L::splat(h / 6.0);
        for (x, &sum) in xi[..self.states].iter_mut().zip(&self.sum) {
            *x = sixth.mul_add(sum, *x);
        }
    }

    /// Switches every lane whose guards ask for it, and ends those that have diverged.
    fn events(&mut self, lanes: &mut [LaneCore], xi: &mut [L], t_s: f64) -> Result<(), EngineError> {
        self.fill_terms(lanes, xi);
        let mut crossed = L::Mask::splat(false);
        let mut size = L::zero();
        dispatch(
            #[inline(always)]
            || {
                for row in &self.guards {
                    crossed = crossed | product(row, xi).lt(L::zero());
                }
                for x in &xi[..self.states] {
                    size += x.abs();
                }
            },
        );
        let fine = size.lt(L::splat(LaneCore::BOUND));
        for (l, lane) in lanes.iter_mut().enumerate() {
            if !fine.test(l) && !lane.has_ended() {
                lane.end = RunEnd::Diverged { t_s };
            }
            if lane.has_ended() {
                // It stays at its last state within bounds.
                for (x, last) in xi.iter_mut().zip(&self.last) {
                    x.set_lane(l, last.lane(l));
                }
            }
            if lane.has_ended() || (!crossed.test(l) && lane.flow().equations.stuck.is_empty()) {
                continue;
            }
            take_lane(xi, l, &mut self.scratch);
            for _ in 0..MOST_SWITCHES {
                let violated = lane.flow().equations.guards.iter().position(|guard| crate::lane::dot(&guard.row, &self.scratch) < 0.0);
                let Some(guard) = violated else { break };
                lane.stop_exactly(guard, &mut self.scratch);
                lane.switch(guard, &mut self.scratch, t_s)?;
            }
            lane.join(&mut self.scratch);
            put_lane(xi, l, &self.scratch);
        }
        Ok(())
    }
}

/// Powers of all meters of all lanes, where the ledger is kept.
fn powers<L: Lane>(lanes: &[LaneCore], xi: &[L]) -> Vec<Vec<f64>> {
    let power = |(l, lane): (usize, &LaneCore)| {
        let dot = |row: &[f64]| row.iter().zip(xi).map(|(r, x)| r * x.lane(l)).sum::<f64>();
        lane.flow().ledger.meters.iter().map(|meter| dot(&meter.force) * dot(&meter.speed)).collect()
    };
    lanes.iter().enumerate().filter(|(_, lane)| lane.ledger.is_some()).map(power).collect()
}

/// Charges the meters by the trapezoidal rule: of the order of the methods' own errors.
fn charge<L: Lane>(lanes: &mut [LaneCore], xi: &[L], before: &[Vec<f64>], h: f64) {
    if before.is_empty() {
        return;
    }
    let after = powers(lanes, xi);
    for (lane, (before, after)) in lanes.iter_mut().zip(before.iter().zip(&after)) {
        if let Some(ledger) = &mut lane.ledger {
            for (sum, (a, b)) in ledger.meters.iter_mut().zip(before.iter().zip(after)) {
                *sum += 0.5 * h * (a + b);
            }
        }
    }
}

#[inline(always)]
fn product<L: Lane>(row: &[(usize, L)], xi: &[L]) -> L {
    let mut sum = L::zero();
    for &(j, factor) in row {
        sum = factor.mul_add(xi[j], sum);
    }
    sum
}
