//! Fixed steps: semi-implicit Euler, RK4, and another engine's, with all lanes together. Events occur at the
//! ends of steps.
//!
//! These methods serve comparisons, and users who must reproduce the steps of another tool. A step ends early
//! at a controller's sample or a command's arrival, so these instants are exact. Within a step the mode does
//! not change, so both methods are first order through an impact. In linear modes a step is one product (see
//! [`crate::carry::step_map`]); nonlinear modes use the stages one by one.

use feeler_lanes::{Lane, LaneMask, dispatch};
use feeler_plant::motion::dot;

use crate::carry::bodies::BodyEngine;
use crate::carry::formation::Formation;
use crate::carry::lane::LaneCore;
use crate::carry::lanes::{put_lane, take_lane};
use crate::carry::step_map::StepMap;
use crate::error::{EngineError, RunEnd};
use crate::run::settings::Integrator;

/// Largest number of switches in one lane at the end of one step; more means that modes require each other.
const MOST_SWITCHES: usize = 16;
/// A remainder below this share of a step is rounding. Step lengths that differ by less are equal.
const SLIVER: f64 = 1e-9;
/// Largest number of step lengths whose maps are kept.
const MAPS_KEPT: usize = 16;

#[derive(Debug)]
pub(crate) struct FixedStep<L> {
    method: Integrator,
    step_s: f64,
    coordinates: usize,
    states: usize,
    /// Engines that move the bodies, one per lane; empty for this engine's own methods.
    bodies: Vec<Box<dyn BodyEngine>>,
    maps: Vec<StepMap<L>>,
    product: Vec<L>,
    /// Work space of the staged methods for one lane: slope, weighted sum of slopes, point of the next slope,
    /// and state.
    slope: Vec<f64>,
    sum: Vec<f64>,
    probe: Vec<f64>,
    scratch: Vec<f64>,
}

impl<L: Lane> FixedStep<L> {
    pub(crate) fn new(
        method: Integrator,
        step_s: f64,
        lanes: &[LaneCore],
        bodies: Vec<Box<dyn BodyEngine>>,
    ) -> Self {
        let layout = lanes[0].motion.layout();
        Self {
            method,
            step_s,
            coordinates: layout.coordinates(),
            states: layout.states(),
            bodies,
            maps: Vec::new(),
            product: Vec::new(),
            slope: vec![0.0; layout.states()],
            sum: vec![0.0; layout.states()],
            probe: Vec::new(),
            scratch: Vec::new(),
        }
    }

    /// Moves every lane by `span_s` and returns the number of steps.
    pub(crate) fn run(
        &mut self,
        lanes: &mut [LaneCore],
        formation: &mut Formation<L>,
        xi: &mut [L],
        t_s: f64,
        span_s: f64,
    ) -> Result<u64, EngineError> {
        let steps = (span_s / self.step_s - SLIVER).ceil().max(1.0) as u64;
        let last_s = span_s - (steps - 1) as f64 * self.step_s;
        let whole = if (last_s - self.step_s).abs() <= SLIVER * self.step_s { steps } else { steps - 1 };
        let mut done = 0;
        while done < steps {
            let (h, most) = if done < whole { (self.step_s, whole - done) } else { (last_s, 1) };
            let step_s = self.step_s;
            let end_of = |k: u64| t_s + if k == steps { span_s } else { k as f64 * step_s };
            let index =
                if lanes[0].ledger.is_none() && self.bodies.is_empty() { self.map(h, lanes) } else { None };
            // A lane's own mode alone decides whether the lane uses the map or the stages. So its numbers do
            // not depend on its neighbours.
            let by_map = if index.is_some() { formation.travelling } else { L::Mask::splat(false) };
            let most = if formation.all_linear && index.is_some() { most } else { 1 };
            let (mut taken, mut changed) = (most, false);
            if let Some(index) = index.filter(|_| by_map.any()) {
                let map = &mut self.maps[index];
                map.refresh(self.method, formation.number, lanes);
                self.product.resize(map.padded_rows().max(self.product.len()), L::zero());
                let product = &mut self.product;
                let (crossed, lost);
                (taken, crossed, lost) = dispatch(
                    #[inline(always)]
                    || map.steps(most, by_map, xi, product),
                );
                changed = crossed.any() || lost.any();
                if changed || formation.any_joined {
                    self.events(lanes, xi, end_of(done + taken), crossed, lost)?;
                }
            }
            done += taken;
            if !by_map.all() {
                changed |= self.stages(lanes, xi, h, end_of(done), by_map)?;
            }
            if changed {
                formation.form(lanes);
            }
        }
        Ok(steps)
    }

    /// The map of a step of this length; `None` after too many different lengths.
    fn map(&mut self, step_s: f64, lanes: &[LaneCore]) -> Option<usize> {
        let known = self.maps.iter().position(|map| (map.step_s - step_s).abs() <= SLIVER * self.step_s);
        if known.is_none() && self.maps.len() < MAPS_KEPT {
            self.maps.push(StepMap::new(step_s, lanes));
            return Some(self.maps.len() - 1);
        }
        known
    }

    /// One step, through the stages of the method, of every lane outside `by_map`. Returns whether a lane has
    /// changed its mode or ended.
    fn stages(
        &mut self,
        lanes: &mut [LaneCore],
        xi: &mut [L],
        h: f64,
        t_s: f64,
        by_map: L::Mask,
    ) -> Result<bool, EngineError> {
        let mut changed = false;
        for (l, lane) in
            lanes.iter_mut().enumerate().filter(|(l, lane)| !by_map.test(*l) && !lane.has_ended())
        {
            let mode = lane.current;
            take_lane(xi, l, &mut self.scratch);
            let mut state = std::mem::take(&mut self.scratch);
            let before = powers(lane, &state);
            match self.method {
                Integrator::Rk4 => self.rk4(lane, &mut state, h),
                Integrator::External => self.external(lane, l, &mut state, h)?,
                Integrator::SemiImplicitEuler | Integrator::Exact => {
                    self.semi_implicit_euler(lane, &mut state, h);
                }
            }
            lane.motion.fill_terms(&lane.flow().equations, &mut state);
            charge(lane, &state, &before, h);
            let size: f64 = state[..self.states].iter().map(|x| x.abs()).sum();
            if size < LaneCore::BOUND {
                switch_all(lane, &mut state, t_s)?;
                lane.note_peaks(&state, t_s);
                put_lane(xi, l, &state);
            } else {
                lane.end = Some(RunEnd::Diverged { t_s });
            }
            self.scratch = state;
            changed |= lane.current != mode || lane.has_ended();
        }
        Ok(changed)
    }

    fn semi_implicit_euler(&mut self, lane: &LaneCore, xi: &mut [f64], h: f64) {
        let n = self.coordinates;
        lane.motion.fill_terms(&lane.flow().equations, xi);
        slopes(lane, xi, &mut self.slope);
        for (x, &slope) in xi[n..self.states].iter_mut().zip(&self.slope[n..]) {
            *x += h * slope;
        }
        for g in 0..n {
            xi[g] += h * xi[n + g];
        }
    }

    /// Drives and filters move by semi-implicit Euler. The external engine of the lane moves the bodies under
    /// the forces at the start of the step.
    fn external(&mut self, lane: &LaneCore, l: usize, xi: &mut [f64], h: f64) -> Result<(), EngineError> {
        let n = self.coordinates;
        lane.motion.fill_terms(&lane.flow().equations, xi);
        slopes(lane, xi, &mut self.slope);
        for (x, &slope) in xi[2 * n..self.states].iter_mut().zip(&self.slope[2 * n..]) {
            *x += h * slope;
        }
        let coordinates = lane.motion.coordinates();
        self.probe.clear();
        self.probe.extend((0..n).map(|g| coordinates.mass_kg(g) * self.slope[n + g]));
        let (positions, rest) = xi.split_at_mut(n);
        self.bodies[l].step(h, &self.probe, positions, &mut rest[..n])
    }

    /// The classical method: slopes at the start, twice in the middle and at the end, with weights 1, 2, 2,
    /// 1.
    fn rk4(&mut self, lane: &LaneCore, xi: &mut [f64], h: f64) {
        self.probe.clear();
        self.probe.extend_from_slice(xi);
        self.sum.fill(0.0);
        for (reach, weight) in [(0.5, 1.0), (0.5, 2.0), (1.0, 2.0), (0.0, 1.0)] {
            lane.motion.fill_terms(&lane.flow().equations, &mut self.probe);
            slopes(lane, &self.probe, &mut self.slope);
            for ((&slope, sum), (probe, &x)) in
                self.slope.iter().zip(&mut self.sum).zip(self.probe.iter_mut().zip(xi.iter()))
            {
                *sum += weight * slope;
                *probe = x + reach * h * slope;
            }
        }
        for (x, &sum) in xi[..self.states].iter_mut().zip(&self.sum) {
            *x += h / 6.0 * sum;
        }
    }

    /// Switches the lanes whose guards have fired, and ends those that have diverged.
    fn events(
        &mut self,
        lanes: &mut [LaneCore],
        xi: &mut [L],
        t_s: f64,
        crossed: L::Mask,
        lost: L::Mask,
    ) -> Result<(), EngineError> {
        for (l, lane) in lanes.iter_mut().enumerate() {
            if lost.test(l) {
                lane.end = Some(RunEnd::Diverged { t_s });
            } else if crossed.test(l) || (lane.joins_bodies() && !lane.has_ended()) {
                take_lane(xi, l, &mut self.scratch);
                switch_all(lane, &mut self.scratch, t_s)?;
                put_lane(xi, l, &self.scratch);
            }
        }
        Ok(())
    }
}

/// Makes every switch that the guards require at the end of a step.
fn switch_all(lane: &mut LaneCore, xi: &mut [f64], t_s: f64) -> Result<(), EngineError> {
    for _ in 0..MOST_SWITCHES {
        let violated = lane.flow().equations.guards.iter().position(|guard| dot(&guard.row, xi) < 0.0);
        let Some(guard) = violated else { break };
        lane.stop_exactly(guard, xi);
        lane.switch(guard, xi, t_s)?;
    }
    lane.join(xi);
    Ok(())
}

fn slopes(lane: &LaneCore, xi: &[f64], slope: &mut [f64]) {
    for (slope, row) in slope.iter_mut().zip(&lane.flow().equations.derivative) {
        *slope = dot(row, xi);
    }
}

/// Powers of all meters of a lane, if the ledger is kept.
fn powers(lane: &LaneCore, xi: &[f64]) -> Vec<f64> {
    if lane.ledger.is_none() {
        return Vec::new();
    }
    lane.flow().ledger.meters.iter().map(|meter| dot(&meter.force, xi) * dot(&meter.speed, xi)).collect()
}

/// Charges the meters by the trapezoidal rule, which has the order of the methods' own errors.
fn charge(lane: &mut LaneCore, xi: &[f64], before: &[f64], h: f64) {
    let after = powers(lane, xi);
    if let Some(ledger) = &mut lane.ledger {
        for (sum, (a, b)) in ledger.meters.iter_mut().zip(before.iter().zip(&after)) {
            *sum += 0.5 * h * (a + b);
        }
    }
}
