//! Stable gains of a loop with many states whose gain acts in one place: `A0 + k b c`.
//!
//! Such a loop has an eigenvalue s where `1 = k G(s)` with `G(s) = c (s I - A0)^-1 b`. It is on the border of
//! stability at the frequencies at which G is real, with the gain `1 / G`. Between two such gains the number
//! of unstable motions is constant. At each it changes in the direction in which the root crosses
//! (D-decomposition; Neimark 1948). One reduction of A0 and one value of G at each frequency cost as much as
//! a few eigenvalue problems.

use nalgebra::{DMatrix, DVector};

use crate::domain::{C64, TimeDomain};
use crate::eigen::eigenvalues;
use crate::error::LtiError;
use crate::gain_interval::{GainEdge, GainSearch, StableGains, StableInterval, sample_growth};
use crate::response::TransferEvaluator;
use crate::search::smooth_root;
use crate::state_space::StateSpace;

/// Rounding within which a matrix counts as one column times one row.
const ONE_PLACE: f64 = 1e-10;
/// Frequencies in each decade, before refinement.
const POINTS_PER_DECADE: f64 = 24.0;
/// Factor by which frequencies extend beyond the slowest and the fastest pole.
const BEYOND: f64 = 1e3;
/// Distances from the frequency of a pole, in units of its distance from the border.
const BESIDE: [f64; 8] = [0.0, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0];
/// Largest change of the phase of G between neighbours, rad, up to the limit on divisions.
const TURN: f64 = 0.5;
/// Responses below this share of the one that belongs to the largest gain of a search are skipped, since no
/// gain of the search lies between two of them. Far beyond the modes of a long chain their phase is only
/// rounding.
const NEGLIGIBLE: f64 = 0.1;
const HALVINGS: usize = 24;
/// Width to which a frequency is located.
const LOCATED: f64 = 1e-15;
/// Largest imaginary part of G, as a share of G, at which it counts as real.
const REAL: f64 = 1e-6;
/// Widths, as shares of a frequency, of the search for a crossing that has moved slightly.
const NEAR: [f64; 4] = [1e-3, 5e-3, 2e-2, 8e-2];

/// A loop whose gain acts in one place.
#[derive(Debug)]
pub struct RankOneLoop<'a, T: TimeDomain> {
    domain: T,
    zero: &'a DMatrix<f64>,
    slope: &'a DMatrix<f64>,
    column: DVector<f64>,
    response: TransferEvaluator,
}

/// A gain with a root on the border, its frequency, and the increase of the number of unstable motions.
struct Crossing {
    gain: f64,
    w: f64,
    change: isize,
}

impl<'a, T: TimeDomain> RankOneLoop<'a, T> {
    /// From A0 and A1 of `A0 + k A1`; `None` if A1 is not one column times one row.
    pub fn new(domain: T, zero: &'a DMatrix<f64>, slope: &'a DMatrix<f64>) -> Option<Self> {
        if slope.is_empty() {
            return None;
        }
        let (row, at) = slope.iamax_full();
        let largest = slope[(row, at)];
        let (b, c) = (slope.columns(at, 1).into_owned(), slope.rows(row, 1) / largest);
        let is_one =
            largest.is_finite() && largest != 0.0 && (&b * &c - slope).amax() <= ONE_PLACE * largest.abs();
        let column = b.column(0).into_owned();
        let system =
            is_one.then(|| StateSpace::with_domain(zero.clone(), b, c, DMatrix::zeros(1, 1), domain).ok());
        Some(Self { domain, zero, slope, column, response: TransferEvaluator::new(&system.flatten()?) })
    }

    fn response(&self, w: f64) -> Result<C64, LtiError> {
        Ok(self.response.at(self.domain.boundary_point(w))?[(0, 0)])
    }

    /// The new gain of an edge at frequency `w` after a small change of the loop; `None` if no edge is near.
    ///
    /// # Errors
    /// [`LtiError::AtPole`].
    pub fn gain_near(&self, w: f64) -> Result<Option<f64>, LtiError> {
        for share in NEAR {
            let (low, high) = (w * (1.0 - share), (w * (1.0 + share)).min(self.domain.nyquist_rad_per_s()));
            if (self.response(low)?.im > 0.0) != (self.response(high)?.im > 0.0) {
                let w = smooth_root(low, high, LOCATED, |w| Ok::<_, LtiError>(self.response(w)?.im))?;
                let value = self.response(w)?;
                return Ok((value.im.abs() <= REAL * value.norm()).then(|| value.re.recip()));
            }
        }
        Ok(None)
    }

    /// Every interval of stable gains of a search from zero onwards. `None` if the count of unstable motions
    /// disagrees with the eigenvalues, so that another method is needed.
    ///
    /// # Errors
    /// Those of [`eigenvalues`].
    pub fn stable_gains(mut self, search: &GainSearch) -> Result<Option<StableGains>, LtiError> {
        self.response = self.response.for_many_points();
        let largest = search.scale * 10_f64.powf(f64::from(search.decades));
        let mut crossings = self.crossings(NEGLIGIBLE / largest)?;
        crossings.retain(|crossing| crossing.gain > search.lower && crossing.gain < largest);
        crossings.sort_by(|a, b| a.gain.total_cmp(&b.gain));
        let inside = |i: usize| match (i.checked_sub(1).map(|i| crossings[i].gain), crossings.get(i)) {
            (None, None) => search.scale,
            (None, Some(high)) => 0.5 * high.gain,
            (Some(low), None) => 2.0 * low,
            (Some(low), Some(high)) => 0.5 * (low + high.gain),
        };
        let sample = |i: usize| {
            let gain = inside(i);
            sample_growth(self.domain, &(self.zero + self.slope * gain), gain, search.growth_limit_per_s)
        };
        let first = sample(0)?;
        let mut unstable = first.unstable().cast_signed();
        let mut stable = vec![first.is_stable()];
        let mut counts = Vec::new();
        for (i, crossing) in crossings.iter().enumerate() {
            unstable += crossing.change;
            counts.push(unstable);
            if unstable > 0 {
                stable.push(false);
                continue;
            }
            // The interval that matters most is checked by a sample.
            let found = sample(i + 1)?;
            if found.unstable().cast_signed() != unstable {
                return Ok(None);
            }
            stable.push(found.is_stable());
        }
        // At the largest gains rounding may carry eigenvalues over the border. The count at the middle
        // crossing decides then, unless the sample itself is stable.
        if let Some(last) = counts.len().checked_sub(1)
            && unstable > 0
        {
            let end = sample(last + 1)?;
            let is_counted =
                |i: usize| Ok::<_, LtiError>(sample(i + 1)?.unstable().cast_signed() == counts[i]);
            if end.unstable().cast_signed() != unstable && (end.is_stable() || !is_counted(last / 2)?) {
                return Ok(None);
            }
        }
        let mut intervals = Vec::new();
        let mut lower: Option<Option<GainEdge>> = stable[0].then_some(None);
        for (crossing, pair) in crossings.iter().zip(stable.windows(2)) {
            match (pair[0], pair[1]) {
                (false, true) => lower = Some(Some(self.edge(crossing)?)),
                (true, false) => {
                    let upper = Some(self.edge(crossing)?);
                    intervals.push(StableInterval { lower: lower.take().flatten(), upper });
                }
                _ => {}
            }
        }
        intervals.extend(lower.map(|lower| StableInterval { lower, upper: None }));
        Ok(Some(StableGains { intervals }))
    }

    /// The motion that begins to grow at a crossing: `(s I - A0)^-1 b`.
    fn edge(&self, crossing: &Crossing) -> Result<GainEdge, LtiError> {
        let s = self.domain.boundary_point(crossing.w);
        let n = self.zero.nrows();
        let resolvent = DMatrix::from_fn(n, n, |i, j| {
            C64::new(-self.zero[(i, j)], 0.0) + if i == j { s } else { C64::new(0.0, 0.0) }
        });
        let column = self.column.map(|entry| C64::new(entry, 0.0));
        let vector = resolvent.lu().solve(&column).ok_or(LtiError::AtPole { re: s.re, im: s.im })?;
        let norm = vector.norm();
        Ok(GainEdge {
            gain: crossing.gain,
            frequency_hz: crossing.w / std::f64::consts::TAU,
            eigenvalue: s,
            eigenvector: vector / C64::new(norm, 0.0),
        })
    }

    /// Crossings at which the response is not below `least` on both sides.
    fn crossings(&self, least: f64) -> Result<Vec<Crossing>, LtiError> {
        let frequencies = self.frequencies()?;
        let mut found = Vec::new();
        let nyquist = self.domain.nyquist_rad_per_s();
        for end in [0.0, nyquist].into_iter().filter(|end| end.is_finite()) {
            // At a pole there is no gain.
            if let Ok(value) = self.response(end)
                && value.re > least
            {
                let gain = value.re.recip();
                found.push(Crossing { gain, w: end, change: self.outwards(end)? });
            }
        }
        let mut before: Option<(f64, C64)> = None;
        for w in frequencies {
            // A pole on the border is skipped: near it the response is large, so its gain is almost zero.
            let Ok(value) = self.response(w) else { continue };
            if let Some(start) = before.filter(|(_, from)| from.norm().max(value.norm()) > least) {
                self.between(start, (w, value), HALVINGS, &mut found)?;
            }
            before = Some((w, value));
        }
        Ok(found)
    }

    /// Crossings between two frequencies, refined as the phase requires.
    fn between(
        &self,
        start: (f64, C64),
        end: (f64, C64),
        halvings: usize,
        found: &mut Vec<Crossing>,
    ) -> Result<(), LtiError> {
        let middle = 0.5 * (start.0 + end.0);
        let turn = (end.1 / start.1).arg().abs();
        if turn > TURN
            && halvings > 0
            && middle > start.0
            && middle < end.0
            && let Ok(value) = self.response(middle)
        {
            self.between(start, (middle, value), halvings - 1, found)?;
            return self.between((middle, value), end, halvings - 1, found);
        }
        if (start.1.im > 0.0) == (end.1.im > 0.0) {
            return Ok(());
        }
        let w = smooth_root(start.0, end.0, LOCATED, |w| Ok::<_, LtiError>(self.response(w)?.im))?;
        let value = self.response(w)?;
        if value.re > 0.0 && value.im.abs() <= REAL * value.norm() {
            found.push(Crossing { gain: value.re.recip(), w, change: 2 * self.outwards(w)? });
        }
        Ok(())
    }

    /// 1 if the root at this frequency becomes unstable as the gain rises, -1 if it becomes stable: from `1 =
    /// k G(s)`, `ds/dk = -G^2 / G'`.
    fn outwards(&self, w: f64) -> Result<isize, LtiError> {
        let point = self.domain.boundary_point(w);
        let (value, slope) = self.response.with_derivative(point)?;
        let moved = -value[(0, 0)] * value[(0, 0)] / slope[(0, 0)];
        // Outwards for a sampled loop, to the right for a continuous one.
        let out =
            if self.domain.nyquist_rad_per_s().is_finite() { (point.conj() * moved).re } else { moved.re };
        Ok(if out > 0.0 { 1 } else { -1 })
    }

    /// Frequencies of the response, rising: spaced by a constant ratio, and about every pole.
    fn frequencies(&self) -> Result<Vec<f64>, LtiError> {
        let poles: Vec<C64> = eigenvalues(self.zero)?
            .into_iter()
            .map(|pole| self.domain.s_of_point(pole))
            .filter(|pole| pole.is_finite() && pole.norm() > 0.0)
            .collect();
        let nyquist = self.domain.nyquist_rad_per_s();
        let fastest = poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max).max(1e-6);
        let slowest = poles.iter().map(|pole| pole.norm()).fold(fastest, f64::min).max(1e-9 * fastest);
        let (from, to) = (slowest / BEYOND, (fastest * BEYOND).min(nyquist));
        let count = (POINTS_PER_DECADE * (to / from).log10()).ceil().max(1.0);
        let mut all: Vec<f64> =
            (0..=count as u32).map(|i| from * (to / from).powf(f64::from(i) / count)).collect();
        for pole in poles {
            let beside = BESIDE.iter().flat_map(|share| [share * pole.re.abs(), -share * pole.re.abs()]);
            all.extend(beside.map(|offset| pole.im.abs() + offset));
        }
        all.retain(|w| *w > 0.0 && *w < nyquist);
        all.sort_by(f64::total_cmp);
        all.dedup();
        Ok(all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::Continuous;
    use crate::gain_interval::stable_gains;

    /// Edges are as exact as the eigenvalues of forty states.
    const SAME: f64 = 1e-7;

    /// A chain of lightly damped masses, driven at one end and measured at the other or in the middle.
    fn chain(masses: usize, read: usize) -> (DMatrix<f64>, DMatrix<f64>) {
        let n = masses;
        let mut a = DMatrix::zeros(2 * n, 2 * n);
        for i in 0..n {
            a[(i, n + i)] = 1.0;
            let (k, c) = (1e4 * (1.0 + 0.1 * i as f64), 4.0);
            for (j, sign) in [(Some(i), -1.0), (i.checked_sub(1), 1.0)] {
                if let Some(j) = j {
                    a[(n + i, j)] += sign * k;
                    a[(n + i, n + j)] += sign * c;
                }
            }
            if i + 1 < n {
                let k = 1e4 * (1.0 + 0.1 * (i + 1) as f64);
                a[(n + i, i)] -= k;
                a[(n + i, i + 1)] += k;
                a[(n + i, n + i)] -= c;
                a[(n + i, n + i + 1)] += c;
            }
        }
        let mut slope = DMatrix::zeros(2 * n, 2 * n);
        slope[(n, read)] = -1.0;
        (a, slope)
    }

    #[test]
    fn prop_edges_are_those_of_the_search_by_eigenvalues() {
        for (masses, read) in [(4, 3), (6, 0), (8, 5), (20, 19)] {
            let (zero, slope) = chain(masses, read);
            let search = GainSearch::non_negative(1e4).unwrap();
            let found =
                RankOneLoop::new(Continuous, &zero, &slope).unwrap().stable_gains(&search).unwrap().unwrap();
            let plain = stable_gains(Continuous, |k| &zero + &slope * k, &search).unwrap();
            let edges = |gains: &StableGains| {
                let edges = gains.intervals.iter().flat_map(|i| [i.lower.clone(), i.upper.clone()]);
                edges.map(|edge| edge.map(|edge| (edge.gain, edge.frequency_hz))).collect::<Vec<_>>()
            };
            let (found, plain) = (edges(&found), edges(&plain));
            assert_eq!(found.len(), plain.len(), "{masses} {read}: {found:?} {plain:?}");
            for (a, b) in found.iter().zip(&plain) {
                match (a, b) {
                    (Some(a), Some(b)) => assert!(
                        (a.0 - b.0).abs() <= SAME * b.0 && (a.1 - b.1).abs() <= SAME * b.1,
                        "{masses} {read}: {a:?} {b:?}"
                    ),
                    (a, b) => assert_eq!(a.is_some(), b.is_some(), "{masses} {read}"),
                }
            }
        }
    }

    /// 1 % more stiffness moves the edge, and the search near it finds the new place.
    #[test]
    fn truth_an_edge_is_found_again_after_a_small_change() {
        let (zero, slope) = chain(5, 4);
        let search = GainSearch::non_negative(1e4).unwrap();
        let edge = |zero: &DMatrix<f64>| {
            let found = RankOneLoop::new(Continuous, zero, &slope).unwrap().stable_gains(&search).unwrap();
            found.unwrap().intervals[0].upper.clone().unwrap()
        };
        let before = edge(&zero);
        let mut stiffer = zero.clone();
        stiffer.row_mut(6).scale_mut(1.01);
        let near = RankOneLoop::new(Continuous, &stiffer, &slope).unwrap();
        let near = near.gain_near(std::f64::consts::TAU * before.frequency_hz).unwrap().unwrap();
        let after = edge(&stiffer);
        assert!(
            (near - after.gain).abs() < SAME * after.gain && (near - before.gain).abs() > 1e-6 * before.gain,
            "{near} {after:?}"
        );
    }
}
