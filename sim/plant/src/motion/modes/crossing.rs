//! The instant at which a guard fires, from evaluations along the motion (see [`super::Guard`] for the
//! rules).

/// A guard this close to zero, relative to its terms, may be the trace of the last event.
pub const AT_ZERO: f64 = 1e-12;
/// A guard that was at zero less than this time ago, s, may also be such a trace. It is ten thousand times
/// the rounding of an event's instant.
pub const AT_ZERO_S: f64 = 1e-13;
/// Bisections of a span in search of an instant at which a guard has grown from zero.
const HALVINGS: i32 = 50;

/// A guard at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instant {
    /// Time since the start of the span, s.
    pub s: f64,
    /// The quantity.
    pub value: f64,
    /// Its slope along the motion, per second.
    pub slope: f64,
}

/// A guard along the motion of one mode, which the integrator can evaluate.
pub trait GuardFunction {
    /// The guard `s` after the start of the span; `None` if the motion is not finite.
    fn at(&mut self, s: f64) -> Option<Instant>;

    /// The value of the guard alone.
    fn value(&mut self, s: f64) -> Option<f64> {
        self.at(s).map(|instant| instant.value)
    }
}

/// Largest distance from zero at which a guard may still be the trace of an event.
pub fn trace(row: &[f64], xi: &[f64], slope: f64) -> f64 {
    let size: f64 = row.iter().zip(xi).map(|(r, x)| (r * x).abs()).sum();
    AT_ZERO * size + AT_ZERO_S * slope.abs()
}

/// The first instant of a span at which a guard fires, located to `close_s`. `start` and `end` are the guard
/// at both ends; in between it has at most one minimum. A value within `trace` of zero is the trace of an
/// event.
pub fn first_crossing(
    course: &mut impl GuardFunction,
    [start, end]: [Instant; 2],
    trace: f64,
    close_s: f64,
) -> Option<f64> {
    if start.value < -trace {
        return Some(0.0);
    }
    let mut left = start;
    if start.value <= trace {
        let grown = (3..HALVINGS).find_map(|k| {
            let instant = course.at(end.s * 0.5_f64.powi(k))?;
            (instant.value > 0.0).then_some(instant)
        });
        match grown {
            Some(instant) => left = instant,
            None => return (end.value < 0.0).then_some(0.0),
        }
    }
    let right = if end.value > 0.0 { dip(course, left, end, end.s, close_s)? } else { end };
    locate(course, left, right, close_s)
}

/// Whether a guard that is positive at both ends of a span may be negative in between, if it has one minimum
/// there. Both tangents lie below a convex function.
#[inline]
pub fn may_dip(start: &Instant, end: &Instant) -> bool {
    start.slope < 0.0
        && end.slope > 0.0
        && (end.slope * start.value - start.slope * end.value + start.slope * end.slope * (end.s - start.s))
            / (end.slope - start.slope)
            <= 0.0
}

/// An instant between two positive values at which the guard is negative, if its single minimum is negative.
fn dip(
    course: &mut impl GuardFunction,
    left: Instant,
    right: Instant,
    span: f64,
    close_s: f64,
) -> Option<Instant> {
    let (mut a, mut b) = (left, right);
    while b.s - a.s > close_s.max(f64::EPSILON * span) {
        if !may_dip(&a, &b) {
            return None;
        }
        let middle = course.at(0.5 * (a.s + b.s))?;
        if middle.value <= 0.0 {
            return Some(middle);
        }
        if middle.slope < 0.0 { a = middle } else { b = middle }
    }
    None
}

/// The zero between a positive value and one that is not positive: regula falsi (Illinois).
fn locate(course: &mut impl GuardFunction, left: Instant, right: Instant, close_s: f64) -> Option<f64> {
    let (mut a, mut fa, mut b, mut fb) = (left.s, left.value, right.s, right.value);
    while b - a > close_s.max(4.0 * f64::EPSILON * b) {
        let secant = (a * fb - b * fa) / (fb - fa);
        let s = if secant > a && secant < b { secant } else { 0.5 * (a + b) };
        let value = course.value(s)?;
        let (from_a, from_b, whole) = (s - a, b - s, b - a);
        if value > 0.0 {
            (a, fa) = (s, value);
            fb = if from_a < 0.1 * whole { 0.5 * fb } else { fb };
        } else {
            (b, fb) = (s, value);
            fa = if from_b < 0.1 * whole { 0.5 * fa } else { fa };
        }
    }
    Some(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tolerance of a located instant, s.
    const CLOSE_S: f64 = 1e-15;
    /// Rounding of an instant of order one.
    const ROUNDING: f64 = 4.0 * f64::EPSILON;

    /// `a + b s + c s^2` as a guard.
    struct Quadratic([f64; 3]);

    impl GuardFunction for Quadratic {
        fn at(&mut self, s: f64) -> Option<Instant> {
            let [a, b, c] = self.0;
            Some(Instant { s, value: a + s * (b + s * c), slope: b + 2.0 * c * s })
        }
    }

    fn fires(c: [f64; 3], trace: f64) -> Option<f64> {
        let mut course = Quadratic(c);
        let ends = [0.0, 1.0].map(|s| course.at(s).unwrap());
        first_crossing(&mut course, ends, trace, CLOSE_S)
    }

    /// Every row of the table of [`crate::motion::Guard`].
    #[test]
    fn truth_a_guard_fires_as_the_contract_says() {
        assert_eq!(fires([1.0, 1.0, 0.0], 1e-12), None);
        let fired = fires([0.3, -1.0, 0.0], 1e-12).unwrap();
        assert!((fired - 0.3).abs() < ROUNDING, "{fired}");
        assert_eq!(fires([-1e-15, 1.0, 0.0], 1e-12), None);
        assert_eq!(fires([1e-15, -1.0, 0.0], 1e-12), Some(0.0));
        assert_eq!(fires([-1e-3, 1.0, 0.0], 1e-12), Some(0.0));
        // The guard grows from the trace of an event, then falls again.
        let fired = fires([0.0, 1.0, -2.0], 1e-12).unwrap();
        assert!((fired - 0.5).abs() < ROUNDING, "{fired}");
    }

    #[test]
    fn truth_a_dip_between_two_positive_ends_fires_where_it_begins() {
        let fired = fires([0.25 * 0.25 - 1e-6, -0.5, 1.0], 1e-12).unwrap();
        // The slope there is 2e-3: rounding of the value over it.
        assert!((fired - 0.249).abs() < 1e3 * ROUNDING, "{fired}");
        assert_eq!(fires([0.25 * 0.25 + 1e-6, -0.5, 1.0], 1e-12), None);
    }
}
