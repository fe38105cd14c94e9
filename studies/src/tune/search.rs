//! Searches the space of knobs for the largest bandwidth, by linear theory. A grid comes first, a finer one
//! where the first meets the limits, and a pattern search from the best of both.

use std::collections::HashMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use feeler_control::ControllerSpec;
use rayon::prelude::*;

use super::knobs::{Knob, Knobs};
use super::spec::Spec;
use super::theory::{Figures, LinearPlant};

/// Points of a grid, over all knobs together.
const GRID: f64 = 600.0;
/// Smallest number of points per knob.
const LEAST: usize = 4;
/// Starts of the pattern search.
const STARTS: usize = 4;
/// The pattern search ends at this step, as a power of ten: half a per cent, a tenth of the promised accuracy
/// of the bandwidth.
pub(super) const FINEST: f64 = 0.002;
/// Largest number of steps of one pattern search.
const MOST_STEPS: usize = 200;

/// A point: the decimal logarithm of each knob's magnitude, minus infinity for zero.
pub(super) type Point = Vec<f64>;

/// A point with its score: the bandwidth in Hz if every limit is met, otherwise negative, by how far limits
/// are missed.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Scored {
    pub(super) point: Point,
    pub(super) score: f64,
}

/// Every point that has been evaluated, on every machine in use.
pub(super) struct TuneSearch<'a> {
    spec: &'a Spec,
    knobs: &'a Knobs,
    plants: &'a [LinearPlant],
    known: Mutex<HashMap<(usize, Vec<u64>), f64>>,
    pub(super) evaluations: AtomicUsize,
}

impl<'a> TuneSearch<'a> {
    pub(super) fn new(spec: &'a Spec, knobs: &'a Knobs, plants: &'a [LinearPlant]) -> Self {
        Self { spec, knobs, plants, known: Mutex::default(), evaluations: AtomicUsize::new(0) }
    }

    pub(super) fn sizes(point: &[f64]) -> Vec<f64> {
        point.iter().map(|x| 10.0_f64.powf(*x)).collect()
    }

    /// Figures of linear theory for a point on one machine; `None` if the loop is unstable or theory has no
    /// answer.
    pub(super) fn figures(&self, point: &[f64], machine: usize) -> Option<Figures> {
        self.plants[machine].figures(&self.knobs.spec(&Self::sizes(point))).ok().flatten()
    }

    /// Whether a loop is stable on a machine by linear theory.
    pub(super) fn is_stable(&self, spec: &ControllerSpec, machine: usize) -> bool {
        self.plants[machine].figures(spec).is_ok_and(|figures| figures.is_some())
    }

    fn score_on(&self, point: &[f64], machine: usize) -> f64 {
        let key = (machine, point.iter().map(|x| x.to_bits()).collect::<Vec<_>>());
        let known = self.known.lock().ok().and_then(|known| known.get(&key).copied());
        if let Some(score) = known {
            return score;
        }
        self.evaluations.fetch_add(1, Ordering::Relaxed);
        let score = self.figures(point, machine).map_or(f64::NEG_INFINITY, |figures| {
            let missed = figures.missed_by(self.spec.limits_of(true));
            if missed > 0.0 { -missed } else { figures.bandwidth_hz }
        });
        if let Ok(mut known) = self.known.lock() {
            known.insert(key, score);
        }
        score
    }

    /// The worst score over machines.
    pub(super) fn score(&self, point: &[f64], machines: &[usize]) -> f64 {
        let mut worst = f64::INFINITY;
        for &machine in machines {
            worst = worst.min(self.score_on(point, machine));
            if worst == f64::NEG_INFINITY {
                break;
            }
        }
        worst
    }

    fn scored(&self, points: Vec<Point>, machines: &[usize]) -> Vec<Scored> {
        let scored = points.into_par_iter().map(|point| {
            let score = self.score(&point, machines);
            Scored { point, score }
        });
        scored.collect()
    }

    /// All points of both grids and the best of the pattern searches, best first, and the spacing of the
    /// finer grid.
    pub(super) fn ranked(&self, machines: &[usize]) -> (Vec<Scored>, f64) {
        let knobs = &self.knobs.knobs;
        let dimensions = i32::try_from(knobs.len()).unwrap_or(i32::MAX);
        let count = (GRID.powf(f64::from(dimensions).recip()) as usize).max(LEAST);
        let whole: Vec<[f64; 2]> = knobs.iter().map(|knob| knob.range.map(f64::log10)).collect();
        let mut found = self.scored(grid(knobs, &whole, count), machines);
        sort(&mut found);
        let coarse = spacing(&whole, count);
        let finer: Vec<[f64; 2]> = (0..knobs.len())
            .map(|i| {
                let best = found.iter().filter(|scored| scored.score > 0.0).chain(found.first());
                let at = best.map(|scored| scored.point[i]).filter(|x| x.is_finite());
                let [low, high] =
                    at.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
                let [first, last] = whole[i];
                if low > high {
                    whole[i]
                } else {
                    [(low - coarse[i]).max(first), (high + coarse[i]).min(last)]
                }
            })
            .collect();
        found.extend(self.scored(grid(knobs, &finer, count), machines));
        // The present controller is a candidate, so that tuning never makes it worse.
        found.extend(self.scored(vec![knobs.iter().map(Knob::present).collect()], machines));
        sort(&mut found);
        let step = spacing(&finer, count).into_iter().fold(FINEST, f64::max);
        let starts: Vec<Scored> = apart(&found, step, STARTS);
        let better = starts.into_par_iter().map(|start| self.climbed(start, step, machines));
        let better: Vec<Scored> = better.collect();
        found.extend(better);
        sort(&mut found);
        (found, step)
    }

    /// A pattern search (Hooke and Jeeves, J. ACM 8, 1961) by theory alone.
    fn climbed(&self, start: Scored, step: f64, machines: &[usize]) -> Scored {
        self.climb(start, step, machines, &mut |_| true)
    }

    /// The same search among points that are also `accepted`; only better points are checked.
    pub(super) fn climb(
        &self,
        mut best: Scored,
        mut step: f64,
        machines: &[usize],
        accepted: &mut dyn FnMut(&Scored) -> bool,
    ) -> Scored {
        for _ in 0..MOST_STEPS {
            let mut around = self.scored(neighbours(&self.knobs.knobs, &best.point, step), machines);
            sort(&mut around);
            around.retain(|scored| scored.score > best.score);
            match around.into_iter().find(|scored| accepted(scored)) {
                Some(better) => best = better,
                None if step <= FINEST => break,
                None => step *= 0.5,
            }
        }
        best
    }
}

fn sort(found: &mut [Scored]) {
    found.sort_by(|a, b| b.score.total_cmp(&a.score));
}

fn spacing(ranges: &[[f64; 2]], count: usize) -> Vec<f64> {
    ranges.iter().map(|[low, high]| (high - low) / (count - 1) as f64).collect()
}

/// Every combination of `count` values per knob, and of zero if the knob allows it.
fn grid(knobs: &[Knob], ranges: &[[f64; 2]], count: usize) -> Vec<Point> {
    let mut points = vec![Vec::new()];
    for (knob, [low, high]) in knobs.iter().zip(ranges) {
        let even = (0..count).map(|i| low + (high - low) * i as f64 / (count - 1) as f64);
        let values: Vec<f64> = even.chain(knob.may_be_zero.then_some(f64::NEG_INFINITY)).collect();
        let with = |point: &Point| {
            let extended = values.iter().map(|value| [point.as_slice(), &[*value]].concat());
            extended.collect::<Vec<_>>()
        };
        points = points.iter().flat_map(with).collect();
    }
    points
}

/// The points a step away along each knob, and along each pair of knobs.
fn neighbours(knobs: &[Knob], point: &[f64], step: f64) -> Vec<Point> {
    let moved = |i: usize, by: f64| {
        let [low, high] = knobs[i].range.map(f64::log10);
        let to = if point[i].is_finite() { point[i] + by } else { low };
        match to {
            to if to > high + FINEST => None,
            to if to >= low - FINEST => Some(to.clamp(low, high)),
            _ => knobs[i].may_be_zero.then_some(f64::NEG_INFINITY),
        }
    };
    let with = |changes: &[(usize, f64)]| {
        let mut next = point.to_vec();
        for &(i, by) in changes {
            next[i] = moved(i, by)?;
        }
        (next != point).then_some(next)
    };
    let mut found = Vec::new();
    for i in 0..point.len() {
        found.extend([step, -step].into_iter().filter_map(|by| with(&[(i, by)])));
        for j in 0..i {
            let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
            found.extend(signs.into_iter().filter_map(|[a, b]| with(&[(i, a * step), (j, b * step)])));
        }
    }
    found
}

/// At most `count` points of a ranking, best first, no two within one and a half steps of each other.
fn apart(ranked: &[Scored], step: f64, count: usize) -> Vec<Scored> {
    let mut chosen: Vec<Scored> = Vec::new();
    let near = |a: &Point, b: &Point| {
        a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits() || (a - b).abs() <= 1.5 * step)
    };
    for scored in ranked.iter().filter(|scored| scored.score > f64::NEG_INFINITY) {
        if chosen.len() < count && chosen.iter().all(|known| !near(&known.point, &scored.point)) {
            chosen.push(scored.clone());
        }
    }
    chosen
}
