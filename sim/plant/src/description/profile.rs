//! The motion of a gap: the effect of a surface on a tip that travels over it.

use crate::problem::Problem;

/// An offset of the gap over time: cubics between knots, each with its values and rates, so that both are
/// continuous where neighbours agree.
///
/// Before the first knot the first offset holds, after the last knot the last one.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    knots: Vec<Knot>,
    pieces: Vec<Piece>,
    /// Touching points of shapes at the knots; empty if the gap is not between shapes.
    touches: Vec<Touched>,
}

/// Touching point of shapes: the point on the workpiece, m, and the unit vector from the tip into it.
pub type Touched = [f64; 6];

/// Offset and rate at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    pub t_s: f64,
    /// Added to the contact's gap.
    pub offset_m: f64,
    /// Rate of change of the offset, m/s.
    pub rate_m_per_s: f64,
}

/// A cubic from an instant on: `offset + rate t + curvature t^2 / 2 + jerk t^3 / 6`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Piece {
    /// Time at which it begins, s.
    pub start_s: f64,
    /// Offset there, m.
    pub offset: f64,
    /// First derivative there, m/s.
    pub rate: f64,
    /// Second derivative there, m/s².
    pub curvature: f64,
    /// Third derivative, m/s³.
    pub jerk: f64,
}

impl Piece {
    fn hermite(a: &Knot, b: &Knot) -> Self {
        let span = b.t_s - a.t_s;
        let mean = (b.offset_m - a.offset_m) / span;
        Self {
            start_s: a.t_s,
            offset: a.offset_m,
            rate: a.rate_m_per_s,
            curvature: 2.0 * (3.0 * mean - 2.0 * a.rate_m_per_s - b.rate_m_per_s) / span,
            jerk: 6.0 * (a.rate_m_per_s + b.rate_m_per_s - 2.0 * mean) / (span * span),
        }
    }

    fn held(start_s: f64, offset: f64) -> Self {
        Self { start_s, offset, ..Self::default() }
    }

    fn at(&self, t_s: f64) -> (f64, f64) {
        let t = t_s - self.start_s;
        let offset = self.offset + t * (self.rate + t * (self.curvature / 2.0 + t * self.jerk / 6.0));
        (offset, self.rate + t * (self.curvature + t * self.jerk / 2.0))
    }
}

impl Profile {
    /// The profile through knots.
    ///
    /// # Errors
    /// A [`Problem`] with an empty key for no knots, times that do not increase, and numbers that are not
    /// finite.
    pub fn new(knots: &[Knot]) -> Result<Self, Problem> {
        if knots.is_empty() {
            return Err(Problem::new(
                "",
                "the profile has no knots",
                "give at least one time with its offset",
            ));
        }
        let finite = |k: &Knot| [k.t_s, k.offset_m, k.rate_m_per_s].iter().all(|x| x.is_finite());
        if let Some(k) = knots.iter().position(|k| !finite(k)) {
            return Err(Problem::new("", format!("knot {k} of the profile is not finite"), "remove it"));
        }
        if let Some(k) = knots.windows(2).position(|pair| pair[1].t_s <= pair[0].t_s) {
            let message = format!(
                "knot {} of the profile, at {} s, is not after the one before",
                k + 1,
                knots[k + 1].t_s
            );
            return Err(Problem::new("", message, "sort the knots by time"));
        }
        let last = &knots[knots.len() - 1];
        let held = Piece::held(last.t_s, last.offset_m);
        Ok(Self {
            knots: knots.to_vec(),
            pieces: knots.windows(2).map(|pair| Piece::hermite(&pair[0], &pair[1])).chain([held]).collect(),
            touches: Vec::new(),
        })
    }

    /// The same profile with the touching points at its knots, one each.
    ///
    /// # Panics
    /// If their number is not that of the knots.
    #[must_use]
    pub fn with_touches(mut self, touches: Vec<Touched>) -> Self {
        assert_eq!(touches.len(), self.knots.len(), "one touch for every knot");
        self.touches = touches;
        self
    }

    /// Whether the profile has touching points.
    pub(crate) fn has_touches(&self) -> bool {
        !self.touches.is_empty()
    }

    /// The touching point at an instant, linear between knots; `None` if the profile has none.
    pub fn touch_at(&self, t_s: f64) -> Option<Touched> {
        let (first, last) = (self.touches.first()?, self.touches.last()?);
        let next = self.knots.partition_point(|knot| knot.t_s <= t_s);
        let Some(before) = next.checked_sub(1) else { return Some(*first) };
        let Some(to) = self.touches.get(next) else { return Some(*last) };
        let (from, [a, b]) = (self.touches[before], [self.knots[before].t_s, self.knots[next].t_s]);
        let share = (t_s - a) / (b - a);
        let mut found: Touched = std::array::from_fn(|i| from[i] + share * (to[i] - from[i]));
        let length = found[3..].iter().map(|x| x * x).sum::<f64>().sqrt();
        if length > 0.0 {
            found[3..].iter_mut().for_each(|x| *x /= length);
        }
        Some(found)
    }

    /// A smooth profile through points `(time in s, offset in m)`. The rate at each point is that from the
    /// previous to the next, and zero at both ends.
    ///
    /// # Errors
    /// Those of [`Self::new`].
    pub fn smooth(points: &[(f64, f64)]) -> Result<Self, Problem> {
        let rate =
            |i: usize| match (i.checked_sub(1).and_then(|before| points.get(before)), points.get(i + 1)) {
                (Some((t0, p0)), Some((t1, p1))) => (p1 - p0) / (t1 - t0),
                _ => 0.0,
            };
        let knots: Vec<Knot> = points
            .iter()
            .enumerate()
            .map(|(i, &(t_s, offset_m))| Knot { t_s, offset_m, rate_m_per_s: rate(i) })
            .collect();
        Self::new(&knots)
    }

    /// The knots it goes through.
    pub fn knots(&self) -> &[Knot] {
        &self.knots
    }

    /// The pieces in order of time; the last one is constant.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Offset and rate of the cubic between two knots.
    pub fn between(a: &Knot, b: &Knot, t_s: f64) -> (f64, f64) {
        Piece::hermite(a, b).at(t_s)
    }

    /// The motion from `t_s` onwards, as a piece that begins there.
    pub(crate) fn piece_from(&self, t_s: f64) -> Piece {
        match self.pieces.partition_point(|piece| piece.start_s <= t_s).checked_sub(1) {
            Some(i) => {
                let piece = self.pieces[i];
                let (offset, rate) = piece.at(t_s);
                Piece {
                    start_s: t_s,
                    offset,
                    rate,
                    curvature: piece.curvature + piece.jerk * (t_s - piece.start_s),
                    jerk: piece.jerk,
                }
            }
            None => Piece::held(t_s, self.pieces[0].offset),
        }
    }

    /// Offset and rate at an instant.
    pub fn at(&self, t_s: f64) -> (f64, f64) {
        let piece = self.piece_from(t_s);
        (piece.offset, piece.rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_cubic_is_met_exactly_and_held_outside() {
        let cubic = |t: f64| (1.0 + t * (2.0 - t * (0.5 - 0.25 * t)), 2.0 - t * (1.0 - 0.75 * t));
        let knots: Vec<Knot> = [0.5, 1.0, 2.5]
            .iter()
            .map(|&t| Knot { t_s: t, offset_m: cubic(t).0, rate_m_per_s: cubic(t).1 })
            .collect();
        let profile = Profile::new(&knots).unwrap();
        for t in [0.5, 0.7, 1.0, 1.9, 2.4] {
            let ((p, v), (p0, v0)) = (profile.at(t), cubic(t));
            assert!((p - p0).abs() < 1e-14 && (v - v0).abs() < 1e-13, "{t}: {p} {v}");
        }
        assert_eq!(profile.at(0.1), (knots[0].offset_m, 0.0));
        assert_eq!(profile.at(9.0), (knots[2].offset_m, 0.0));
    }

    #[test]
    fn truth_a_smooth_profile_is_straight_along_a_line() {
        let profile = Profile::smooth(&[(0.0, 0.0), (1.0, 2.0), (2.0, 4.0), (3.0, 6.0)]).unwrap();
        let (p, v) = profile.at(1.4);
        assert!((p - 2.8).abs() < 1e-14 && (v - 2.0).abs() < 1e-14, "{p} {v}");
        assert_eq!(profile.at(0.0), (0.0, 0.0));
        assert_eq!(profile.at(3.0), (6.0, 0.0));
    }

    #[test]
    fn truth_touches_are_straight_between_knots_and_held_outside() {
        let profile = Profile::smooth(&[(0.0, 0.0), (1.0, 0.0)]).unwrap();
        assert_eq!(profile.touch_at(0.5), None);
        let profile =
            profile.with_touches(vec![[1.0, 0.0, 0.0, 1.0, 0.0, 0.0], [3.0, 2.0, 0.0, 0.0, 1.0, 0.0]]);
        let middle = profile.touch_at(0.5).unwrap();
        let expected = [2.0, 1.0, 0.0, 0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.0];
        assert!(middle.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-14), "{middle:?}");
        assert_eq!(profile.touch_at(-1.0).unwrap()[0].to_bits(), 1.0_f64.to_bits());
        assert_eq!(profile.touch_at(9.0).unwrap()[0].to_bits(), 3.0_f64.to_bits());
    }

    #[test]
    fn truth_bad_knots_are_refused() {
        let knot = |t_s, offset_m| Knot { t_s, offset_m, rate_m_per_s: 0.0 };
        assert!(Profile::new(&[]).is_err());
        assert!(Profile::new(&[knot(0.0, f64::NAN)]).is_err());
        let message = Profile::new(&[knot(0.0, 0.0), knot(1.0, 0.0), knot(1.0, 0.0)]).unwrap_err().message;
        assert!(message.contains("knot 2"), "{message}");
    }
}
