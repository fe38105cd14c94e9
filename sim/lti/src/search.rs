//! One-dimensional searches: the root of a function that changes sign, and the maximum between two points.

/// Bisections after which a bracket of doubles cannot shrink any more, whatever its ends.
const MAX_HALVINGS: usize = 200;
/// In the first bracket, interpolation is moved towards the middle by this share of the bracket.
const TRUNCATION: f64 = 0.2;
/// A step of Newton's method below this, relative to the position, ends the search: the next step would be
/// its square.
const PLACE: f64 = 1e-12;

/// The point where `f` changes sign between `a` and `b`, by bisection down to `relative_width` of the point.
///
/// It bisects because the functions of this crate (largest growth rate, crossings of a phase) have kinks and
/// square-root behaviour. There faster methods lose their advantage.
pub(crate) fn bisect<E>(
    mut a: f64,
    mut b: f64,
    relative_width: f64,
    mut f: impl FnMut(f64) -> Result<f64, E>,
) -> Result<f64, E> {
    let positive_at_a = f(a)? > 0.0;
    for _ in 0..MAX_HALVINGS {
        // Far apart, bisect the exponent; close together, the difference.
        let middle = if a > 0.0 && b > 4.0 * a { (a * b).sqrt() } else { a + 0.5 * (b - a) };
        if (b - a).abs() <= relative_width * a.abs().max(b.abs()) || middle <= a || middle >= b {
            break;
        }
        if (f(middle)? > 0.0) == positive_at_a {
            a = middle;
        } else {
            b = middle;
        }
    }
    Ok(a + 0.5 * (b - a))
}

/// The point where a smooth `f` changes sign between `a` and `b`, down to `relative_width` of the larger. The
/// interpolation never needs more than one value more than bisection (I. Oliveira and R. Takahashi, ACM
/// Trans. Mathematical Software 47, 2020: ITP).
pub(crate) fn smooth_root<E>(
    mut a: f64,
    mut b: f64,
    relative_width: f64,
    mut f: impl FnMut(f64) -> Result<f64, E>,
) -> Result<f64, E> {
    let (mut fa, mut fb) = (f(a)?, f(b)?);
    let half_width = 0.5 * relative_width * a.abs().max(b.abs());
    let truncation = TRUNCATION / (b - a);
    let mut reach = half_width * 2.0_f64.powf(((b - a) / half_width).log2().ceil());
    while b - a > 2.0 * half_width && reach > 0.0 {
        let middle = a + 0.5 * (b - a);
        let chord = (fb * a - fa * b) / (fb - fa);
        let side = (middle - chord).signum();
        let moved = truncation * (b - a).powi(2);
        let inner = if moved <= (middle - chord).abs() { chord + side * moved } else { middle };
        let slack = reach - 0.5 * (b - a);
        let x = if (inner - middle).abs() <= slack { inner } else { middle - side * slack };
        if !(x > a && x < b) {
            break;
        }
        let fx = f(x)?;
        if (fx > 0.0) == (fa > 0.0) {
            (a, fa) = (x, fx);
        } else {
            (b, fb) = (x, fx);
        }
        reach *= 0.5;
    }
    Ok(a + 0.5 * (b - a))
}

/// The point and value of the maximum of `f` between `a` and `b`, if `f` has one, by golden section.
///
/// A maximum is flat: its position is found to about 1e-8 of the interval, its value to machine precision.
pub(crate) fn maximum<E>(
    mut a: f64,
    mut b: f64,
    mut f: impl FnMut(f64) -> Result<f64, E>,
) -> Result<(f64, f64), E> {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut x, mut y) = (b - ratio * (b - a), a + ratio * (b - a));
    let (mut fx, mut fy) = (f(x)?, f(y)?);
    while b - a > 1e-9 * a.abs().max(b.abs()) {
        if fx >= fy {
            (b, y, fy) = (y, x, fx);
            x = b - ratio * (b - a);
            fx = f(x)?;
        } else {
            (a, x, fx) = (x, y, fy);
            y = a + ratio * (b - a);
            fy = f(y)?;
        }
    }
    Ok(if fx >= fy { (x, fx) } else { (y, fy) })
}

/// The position of the maximum of a function between `a` and `b` nearest uphill of `start`. It is found by
/// Newton's method on its slope, kept inside the bracket. `slope_and_curvature` gives the first two
/// derivatives, both times any positive factor.
pub(crate) fn largest(
    mut a: f64,
    mut b: f64,
    start: f64,
    slope_and_curvature: impl Fn(f64) -> [f64; 2],
) -> f64 {
    let mut x = start;
    for _ in 0..MAX_HALVINGS {
        let [slope, curvature] = slope_and_curvature(x);
        if slope > 0.0 {
            a = x;
        } else {
            b = x;
        }
        let newton = x - slope / curvature;
        let next = if curvature < 0.0 && (a..=b).contains(&newton) { newton } else { 0.5 * (a + b) };
        let step = (next - x).abs();
        x = next;
        if step <= PLACE * x.abs() {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_root_and_maximum_of_simple_functions() {
        let root = bisect(1e-9, 1e9, 1e-15, |x| Ok::<_, ()>(x * x - 2.0)).unwrap();
        assert!((root - 2.0_f64.sqrt()).abs() < 1e-15);
        let mut values = 0;
        let smooth = smooth_root(0.5, 3.0, 1e-15, |x: f64| {
            values += 1;
            Ok::<_, ()>(x * x - 2.0)
        });
        assert!((smooth.unwrap() - 2.0_f64.sqrt()).abs() < 2e-15 && values < 20, "{values}");
        // A pole changes sign as well, and a step has no slope.
        let [pole, step] = [|x: f64| 1.0 / (x - 1.2), |x: f64| (x - 1.2).signum()]
            .map(|f| smooth_root(1.0, 3.0, 1e-15, |x| Ok::<_, ()>(f(x))).unwrap());
        assert!((pole - 1.2).abs() < 5e-15 && (step - 1.2).abs() < 5e-15, "{pole} {step}");
        let (place, value) = maximum(0.0, 3.0, |x: f64| Ok::<_, ()>(x.sin())).unwrap();
        assert!((place - std::f64::consts::FRAC_PI_2).abs() < 1e-7 && (value - 1.0).abs() < 1e-15);
    }

    #[test]
    fn truth_the_largest_value_is_found_from_its_slope() {
        let derivatives = |x: f64| [x.cos(), -x.sin()];
        let top = std::f64::consts::FRAC_PI_2;
        // From 0.1 Newton's method alone would jump to 10.07, and from -1 the curvature has the wrong sign.
        for start in [0.1, 1.0, 2.9, -1.0] {
            assert!(
                (largest(-1.0, 3.0, start, derivatives) - top).abs() < 4.0 * f64::EPSILON,
                "from {start}"
            );
        }
        // A function that rises to the end of the bracket has its maximum there.
        assert!((largest(-1.0, 1.0, 0.0, derivatives) - 1.0).abs() < 2.0 * PLACE);
    }
}
