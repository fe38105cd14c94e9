//! A force over position or speed by its values at evenly spaced points.

/// Number of points.
pub const POINTS: usize = 9;
/// Length over which a corner is rounded, over the spacing of the points.
const ROUNDING: f64 = 0.25;

/// A force that follows straight lines between its points, with rounded corners. Before the first and after
/// the last point it levels out.
///
/// Each point turns the line by the change of slope there, as half the sum of the distance `u` from the point
/// and `sqrt(u^2 + ROUNDING^2)`, in spacings. The course is therefore an analytic function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TabulatedForce {
    /// Position or speed of the first point, m or m/s.
    from: f64,
    /// Distance of the points.
    spacing: f64,
    /// Force at each point, N.
    forces: [f64; POINTS],
}

impl TabulatedForce {
    /// The table with its points evenly spaced from `from` to `to`, which lies above.
    pub fn between(from: f64, to: f64, forces: [f64; POINTS]) -> Self {
        Self { from, spacing: (to - from) / (POINTS - 1) as f64, forces }
    }

    /// The table of these values: first and last place, then the force at each point.
    ///
    /// # Panics
    /// If there are fewer.
    pub fn of(values: &[f64]) -> Self {
        Self::between(values[0], values[1], std::array::from_fn(|i| values[2 + i]))
    }

    /// The table with `share` of each force.
    #[must_use]
    pub fn scaled(&self, share: f64) -> Self {
        Self { forces: self.forces.map(|force| share * force), ..*self }
    }

    /// Place and force of each point.
    pub fn points(&self) -> [[f64; 2]; POINTS] {
        std::array::from_fn(|i| [self.from + self.spacing * i as f64, self.forces[i]])
    }

    /// Whether no force acts anywhere.
    pub fn is_null(&self) -> bool {
        self.forces.iter().all(|force| *force == 0.0)
    }

    /// Rise of the force from one point to the next, N: `i` counts from the stretch before the first point.
    fn rise(&self, i: usize) -> f64 {
        if i == 0 || i == POINTS { 0.0 } else { self.forces[i] - self.forces[i - 1] }
    }

    /// Sum over the points of the turn there times a function of the distance from it, in spacings.
    fn turned(&self, x: f64, by: impl Fn(f64) -> f64) -> f64 {
        let u = (x - self.from) / self.spacing;
        (0..POINTS).map(|i| (self.rise(i + 1) - self.rise(i)) * by(u - i as f64)).sum()
    }

    /// The force at a place, N. It stays between the smallest and the largest of the points' forces, since
    /// the rounding is a mean with positive weights.
    pub fn force(&self, x: f64) -> f64 {
        self.forces[0] + self.turned(x, |u| 0.5 * (u + root(u)))
    }

    /// Derivative of the force by its place.
    pub fn slope(&self, x: f64) -> f64 {
        self.turned(x, |u| 0.5 * (1.0 + u / root(u))) / self.spacing
    }

    /// Potential energy, J, up to a constant.
    pub fn potential(&self, x: f64) -> f64 {
        let bend = |u: f64| 0.25 * (u * (u + root(u)) + ROUNDING * ROUNDING * (u / ROUNDING).asinh());
        -self.forces[0] * (x - self.from) - self.spacing * self.turned(x, bend)
    }

    /// The largest slope between two points, which no slope exceeds, N/m.
    pub fn stiffness(&self) -> f64 {
        (0..=POINTS).map(|i| self.rise(i).abs()).fold(0.0, f64::max) / self.spacing
    }
}

/// A distance with its corner at zero rounded.
fn root(u: f64) -> f64 {
    (u * u + ROUNDING * ROUNDING).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORCES: [f64; POINTS] = [1.0, 1.0, 2.0, 6.0, 3.0, -4.0, -4.0, 0.5, 2.0];

    /// At a point the rounding moves the curve by an eighth of the change of slope there. A point `n`
    /// spacings away adds at most `ROUNDING^2 / (4 n)` of its change of slope.
    #[test]
    fn truth_the_course_passes_its_points_but_for_the_rounding() {
        let table = TabulatedForce::between(-0.2, 0.6, FORCES);
        let turn = |i: usize| table.rise(i + 1) - table.rise(i);
        for (i, force) in FORCES.into_iter().enumerate() {
            let others = (0..POINTS).filter(|j| *j != i);
            let far: f64 = others.map(|j| turn(j).abs() / (64.0 * i.abs_diff(j) as f64)).sum();
            let off = table.force(0.1 * i as f64 - 0.2) - force - turn(i) / 8.0;
            assert!(off.abs() <= far + 1e-12, "{i}: {off} beside {far}");
        }
        // Beyond its ends the table keeps the force of the last point.
        for (x, force) in [(-10.0, 1.0), (10.0, 2.0)] {
            assert!((table.force(x) - force).abs() < 1e-3 && table.slope(x).abs() < 1e-4, "{x}");
        }
        let same = TabulatedForce::between(-0.2, 0.6, [3.0; POINTS]);
        assert!([-1.0, 0.11, 2.0].iter().all(|x| same.force(*x).to_bits() == 3.0_f64.to_bits()));
    }

    /// A central difference is off by a sixth of the square of its step times the third derivative. Here that
    /// is at most a turn of 11 N over the cube of the rounding, 1e6 N/m^3. That of the slope is a hundred
    /// times as large.
    #[test]
    fn truth_slope_and_force_are_derivatives() {
        let table = TabulatedForce::between(-0.2, 0.6, FORCES);
        let h = 1e-6;
        for x in [-0.35, -0.2, -0.013, 0.1, 0.1007, 0.29, 0.58, 0.9] {
            let by = |of: &dyn Fn(f64) -> f64| (of(x + h) - of(x - h)) / (2.0 * h);
            assert!((by(&|x| table.potential(x)) + table.force(x)).abs() < 1e-6, "{x}");
            assert!((by(&|x| table.force(x)) - table.slope(x)).abs() < 1e-4, "{x}");
            assert!(table.slope(x).abs() <= table.stiffness() * (1.0 + 1e-12), "{x}");
        }
    }
}
