//! The gap along a feed as a profile over time.

use feeler_plant::description::{Knot, Profile, Touched};

use crate::error::GeometryError;
use crate::feed::Feed;
use crate::touching::Touching;

/// Initial number of pieces of a feed: a detail smaller than a sixty-fourth of the path could otherwise lie
/// unseen between the probes.
const FIRST_PIECES: usize = 64;
/// Shortest piece, s: at a sharp edge of the gap the error falls with its length.
const SHORTEST_S: f64 = 1e-7;
/// Largest slope of a change of the gap within the shortest piece, as path along x per lateral path. A
/// steeper one is a wall.
const STEEPEST: f64 = 10.0;
/// Most knots: 24 MB.
const MOST_KNOTS: usize = 1_000_000;
/// Points at which each piece is compared with the shapes. The largest errors of cubics through values and
/// slopes lie in the middle between them.
const PROBES: [f64; 3] = [0.25, 0.5, 0.75];
/// Largest share of the requested error at the probes: at an edge between two of them the error is up to
/// twice as large.
const SEEN: f64 = 0.5;

/// A gap over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Compiled {
    /// How far the tip can travel along x before it touches, as cubics between knots with exact values and
    /// rates.
    pub profile: Profile,
    /// Largest difference from the shapes' own gap, over three probes within every piece, m.
    pub error_m: f64,
    /// Distance queries that were made.
    pub queries: usize,
}

impl Compiled {
    /// Checks that a tip at `travel_m` beyond its zero position is outside the workpiece at the start.
    ///
    /// # Errors
    /// [`GeometryError::Overlap`].
    pub fn check_start(&self, travel_m: f64) -> Result<(), GeometryError> {
        let depth_m = travel_m - self.profile.at(0.0).0;
        if depth_m > self.error_m { Err(GeometryError::Overlap { depth_m }) } else { Ok(()) }
    }
}

/// Measures along a feed and counts the measurements.
struct Probe<'a> {
    touching: &'a Touching,
    feed: &'a Feed,
    queries: usize,
}

impl Probe<'_> {
    /// The gap and its rate, and the touching points.
    fn knot(&mut self, t_s: f64) -> Result<(Knot, Touched), GeometryError> {
        self.queries += 1;
        let (lateral_m, velocity) = self.feed.at(t_s);
        let touch = self.touching.at(lateral_m).map_err(|error| match error {
            GeometryError::Unreachable { y_m, z_m, .. } => {
                GeometryError::Unreachable { y_m, z_m, t_s: Some(t_s) }
            }
            other => other,
        })?;
        // A lateral velocity of zero does not contribute to the rate, even on a wall.
        let rate = touch.slope.iter().zip(velocity).filter(|(_, v)| *v != 0.0).map(|(s, v)| s * v).sum();
        let ([px, py, pz], [nx, ny, nz]) = (touch.point_m, touch.normal);
        Ok((Knot { t_s, offset_m: touch.travel_m, rate_m_per_s: rate }, [px, py, pz, nx, ny, nz]))
    }

    /// Lateral path between two times, m.
    fn way_m(&self, from_s: f64, to_s: f64) -> f64 {
        let ([y, z], [y_end, z_end]) = (self.feed.at(from_s).0, self.feed.at(to_s).0);
        f64::hypot(y_end - y, z_end - z)
    }

    /// Largest difference of the cubic between two knots from the shapes' own gap, over the probes.
    fn apart_m(&mut self, a: &Knot, b: &Knot) -> Result<f64, GeometryError> {
        let mut apart_m = 0.0_f64;
        for share in PROBES {
            let t_s = a.t_s + share * (b.t_s - a.t_s);
            let found_m = Profile::between(a, b, t_s).0;
            let true_m = self.knot(t_s)?.0.offset_m;
            // An infinite rate gives NaN here, which counts as the largest possible error.
            apart_m = apart_m.max(if found_m.is_finite() { (found_m - true_m).abs() } else { f64::INFINITY });
        }
        Ok(apart_m)
    }
}

impl Touching {
    /// The gap along a feed, from zero to `duration_s`, to within `error_m`: pieces are halved until their
    /// error is within this limit.
    ///
    /// A jump of the gap within `error_m` becomes a ramp of 0.1 us. So does a jump within 3e-5 of the size of
    /// both shapes if their distance comes from Parry's iteration, which jumps by as much. (A ball on
    /// triangles or on a hull does not need it.) [`Compiled::error_m`] then gives the actual error.
    ///
    /// # Errors
    /// [`GeometryError::Jump`] if the gap jumps, [`GeometryError::Unresolved`] for an error that pieces of
    /// 0.1 us exceed. [`GeometryError::Knots`] for an error that needs too many pieces, and those of
    /// [`Self::at`].
    pub fn profile(&self, feed: &Feed, duration_s: f64, error_m: f64) -> Result<Compiled, GeometryError> {
        let mut probe = Probe { touching: self, feed, queries: 0 };
        let mut ends: Vec<f64> =
            (0..=FIRST_PIECES).map(|i| duration_s * i as f64 / FIRST_PIECES as f64).collect();
        ends.extend(feed.times(duration_s));
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|a, b| (*a - *b).abs() < SHORTEST_S);
        let mut knots = vec![probe.knot(ends[0])?];
        let mut worst_m = 0.0_f64;
        // Time and size of the largest excess over the requested error.
        let mut missed = (0.0, 0.0_f64);
        for &end_s in &ends[1..] {
            let mut a = knots[knots.len() - 1];
            // Ends of the remaining pieces, the next one last.
            let mut ahead = vec![probe.knot(end_s)?];
            while let Some(b) = ahead.pop() {
                let apart_m = probe.apart_m(&a.0, &b.0)?;
                let is_shortest = b.0.t_s - a.0.t_s < 2.0 * SHORTEST_S;
                let jump_m = (b.0.offset_m - a.0.offset_m).abs();
                // A sufficiently small step is a ramp.
                let is_ramp = is_shortest && jump_m <= error_m.max(self.roughness_m()) && apart_m.is_finite();
                let is_missed = is_shortest
                    && !is_ramp
                    && apart_m > SEEN * error_m
                    && jump_m <= STEEPEST * probe.way_m(a.0.t_s, b.0.t_s);
                if is_missed && apart_m > missed.1 {
                    missed = (a.0.t_s, apart_m);
                }
                if apart_m <= SEEN * error_m || is_ramp || is_missed {
                    worst_m = worst_m.max(apart_m);
                    knots.push(b);
                    a = b;
                    if knots.len() > MOST_KNOTS {
                        return Err(GeometryError::Knots { most: MOST_KNOTS, error_m });
                    }
                } else if is_shortest {
                    return Err(GeometryError::Jump { t_s: a.0.t_s, jump_m });
                } else {
                    let middle = probe.knot(0.5 * (a.0.t_s + b.0.t_s))?;
                    ahead.push(b);
                    ahead.push(middle);
                }
            }
        }
        if missed.1 > 0.0 {
            return Err(GeometryError::Unresolved { t_s: missed.0, apart_m: missed.1 / SEEN, error_m });
        }
        let (knots, touches): (Vec<Knot>, Vec<Touched>) = knots.into_iter().unzip();
        let profile = Profile::new(&knots)
            .map_err(|problem| GeometryError::Mesh {
                what: problem.message,
                remedy: "repair the shapes where the tip passes them",
            })?
            .with_touches(touches);
        Ok(Compiled { profile, error_m: worst_m, queries: probe.queries })
    }
}
