//! Laws without a matrix exponential.

use super::coordinates::Coordinates;
use crate::assembly::{Assembly, Bristle, ForceLaw, PositionForce, Pull, StopSide, TabulatedForce};
use crate::description::Engagement;

/// Share of a law's scale by which its value halfway may depart from the mean of its ends. For a sine,
/// the ends are then a quarter of a period apart. Simpson's rule is off by 0.3 % there.
const UNEVEN: f64 = 0.3;

/// A law `w = f(a, b)` of one or two linear functionals of the state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NonlinearLaw {
    /// `k d^n (1 + alpha d') + c d' + cubic d^3`, with `d`, `d'` as arguments; odd in `d` if the contact is
    /// clamped.
    Contact {
        contact: usize,
        law: ForceLaw,
        /// Whether the contact only pushes.
        unilateral: bool,
    },
    /// The elastic part of that law: its spring force.
    Elastic {
        contact: usize,
        law: ForceLaw,
        /// Whether the contact only pushes.
        unilateral: bool,
    },
    /// The sign of the contact law, for an undamped contact that only pushes: its force divided by the power
    /// of `d` that vanishes with it.
    Release { contact: usize, law: ForceLaw },
    /// `cubic e^3` of a link (or of one side of its play).
    Cubic {
        link: usize,
        /// Side of the link's play; `None` for a link that acts everywhere.
        side: Option<StopSide>,
        /// N/m³.
        cubic: f64,
    },
    /// `excess exp(-(v / velocity)^2)` of a sliding link.
    Stribeck {
        link: usize,
        /// N.
        excess: f64,
        /// m/s.
        velocity: f64,
    },
    /// `|F|` of a clamped contact that loads a guide.
    Load { contact: usize },
    /// The size of the force of a weight that loads a guide.
    Burden { weight: usize, pull: Pull },
    /// A force of a link over the speed of its elongation.
    OverSpeed { link: usize, table: TabulatedForce },
    /// A level of dry friction over the elongation of a link.
    Level { link: usize, table: TabulatedForce },
    /// `drag v^2` of a link.
    Drag {
        link: usize,
        /// N s²/m².
        drag: f64,
    },
    /// The rate at which the bristles of a link that moves forward straighten; see [`Bristle`].
    Slip { link: usize, bristle: Bristle },
    /// A force over position.
    Weight { weight: usize, course: PositionForce },
    /// `amplitude sin(2 pi x / pitch + phase)` of a drive.
    Ripple {
        drive: usize,
        /// N.
        amplitude: f64,
        /// m.
        pitch: f64,
        /// rad.
        phase: f64,
    },
    /// The heating `(f / force)^2` of a winding by the cold force `f` of its drive.
    Heat {
        drive: usize,
        /// N.
        force: f64,
    },
    /// Loss of the cold force `f` of a drive at a heat `h`: `f h / (1 + h)`.
    Derating { drive: usize },
}

/// A nonlinear term of the machine. Its arguments are rows of the [`super::Equations`] in which it acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NonlinearTerm {
    /// The function of its arguments.
    pub law: NonlinearLaw,
}

impl NonlinearTerm {
    /// The value for arguments `a`, `b`.
    pub fn value(&self, a: f64, b: f64) -> f64 {
        match self.law {
            NonlinearLaw::Contact { law, unilateral, .. } => {
                // Damping that grows with compression opposes the motion on both sides of a clamped contact.
                let spring = law.stiffness * power(&law, a, unilateral);
                let growing = if unilateral { spring } else { spring.abs() };
                spring + growing * law.alpha * b + law.damping * b + law.cubic * a * a * a
            }
            NonlinearLaw::Elastic { law, unilateral, .. } => {
                law.stiffness * power(&law, a, unilateral) + law.cubic * a * a * a
            }
            NonlinearLaw::Release { law, .. } => {
                let factor = 1.0 + law.alpha * b;
                let (power, ratio) = release(&law);
                let d = a.max(0.0);
                if power >= 0.0 {
                    factor + ratio * d.powf(power)
                } else {
                    factor * d.powf(-power) / ratio + 1.0
                }
            }
            NonlinearLaw::Cubic { cubic, .. } => cubic * a * a * a,
            NonlinearLaw::Stribeck { excess, velocity, .. } => excess * (-(a / velocity).powi(2)).exp(),
            NonlinearLaw::Load { .. } => a.abs(),
            NonlinearLaw::Burden { pull, .. } => pull.force(a).abs(),
            NonlinearLaw::OverSpeed { table, .. } | NonlinearLaw::Level { table, .. } => table.force(a),
            NonlinearLaw::Drag { drag, .. } => drag * a * a,
            NonlinearLaw::Slip { bristle, .. } => bristle.slip(a, b),
            NonlinearLaw::Weight { course, .. } => course.force(a),
            NonlinearLaw::Ripple { amplitude, pitch, phase, .. } => {
                amplitude * (std::f64::consts::TAU * a / pitch + phase).sin()
            }
            NonlinearLaw::Heat { force, .. } => (a / force).powi(2),
            NonlinearLaw::Derating { .. } => a * b / (1.0 + b),
        }
    }
}

impl NonlinearTerm {
    /// The mean over a span between the arguments at its ends, of second order. The mean of bristles follows
    /// their exponential at the mean speed, so it also holds for spans in which they settle.
    pub fn mean(&self, [a0, b0]: [f64; 2], [a1, b1]: [f64; 2], span_s: f64) -> f64 {
        match self.law {
            NonlinearLaw::Slip { bristle, .. } => {
                let v = 0.5 * (a0 + a1);
                let level = bristle.level(v);
                let bent = (v.signum() * level / bristle.stiffness - b0)
                    * -(-bristle.stiffness * v.abs() / level * span_s).exp_m1();
                v.signum() * (v - bent / span_s)
            }
            _ => 0.5 * (self.value(a0, b0) + self.value(a1, b1)),
        }
    }

    /// The mean over a span in which the arguments change evenly (Simpson's rule). `None` if the value
    /// halfway departs too far from the mean of those at the ends.
    pub fn even_mean(&self, [a0, b0]: [f64; 2], [a1, b1]: [f64; 2]) -> Option<f64> {
        let (start, end) = (self.value(a0, b0), self.value(a1, b1));
        let half = self.value(0.5 * (a0 + a1), 0.5 * (b0 + b1));
        let scale = match self.law {
            NonlinearLaw::Stribeck { excess, .. } => excess,
            NonlinearLaw::Ripple { amplitude, .. } => amplitude.abs(),
            _ => start.abs().max(end.abs()).max(half.abs()),
        };
        let is_even = (half - 0.5 * (start + end)).abs() <= UNEVEN * scale;
        is_even.then_some((start + 4.0 * half + end) / 6.0)
    }

    /// Derivatives of the value by `a` and by `b`, for small motions.
    pub fn gradient(&self, a: f64, b: f64) -> [f64; 2] {
        match self.law {
            NonlinearLaw::Contact { law, unilateral, .. } => {
                let spring = law.stiffness * power(&law, a, unilateral);
                let slope = law.stiffness * power_slope(&law, a, unilateral);
                let (growing, growing_slope) =
                    if unilateral { (spring, slope) } else { (spring.abs(), slope * a.signum()) };
                [
                    slope + growing_slope * law.alpha * b + 3.0 * law.cubic * a * a,
                    growing * law.alpha + law.damping,
                ]
            }
            NonlinearLaw::Elastic { law, unilateral, .. } => {
                [law.stiffness * power_slope(&law, a, unilateral) + 3.0 * law.cubic * a * a, 0.0]
            }
            NonlinearLaw::Release { law, .. } => {
                let factor = 1.0 + law.alpha * b;
                let (power, ratio) = release(&law);
                let d = a.max(0.0);
                if power >= 0.0 {
                    [ratio * power * d.powf(power - 1.0), law.alpha]
                } else {
                    [-factor * power * d.powf(-power - 1.0) / ratio, law.alpha * d.powf(-power) / ratio]
                }
            }
            NonlinearLaw::Cubic { cubic, .. } => [3.0 * cubic * a * a, 0.0],
            NonlinearLaw::Stribeck { velocity, .. } => {
                [-2.0 * a / (velocity * velocity) * self.value(a, b), 0.0]
            }
            NonlinearLaw::Load { .. } => [a.signum(), 0.0],
            NonlinearLaw::Burden { pull, .. } => [pull.force(a).signum() * pull.slope(a), 0.0],
            NonlinearLaw::OverSpeed { table, .. } | NonlinearLaw::Level { table, .. } => {
                [table.slope(a), 0.0]
            }
            NonlinearLaw::Drag { drag, .. } => [2.0 * drag * a, 0.0],
            NonlinearLaw::Slip { bristle, .. } => bristle.slip_slopes(a, b),
            NonlinearLaw::Weight { course, .. } => [course.slope(a), 0.0],
            NonlinearLaw::Ripple { amplitude, pitch, phase, .. } => {
                let k = std::f64::consts::TAU / pitch;
                [amplitude * k * (k * a + phase).cos(), 0.0]
            }
            NonlinearLaw::Heat { force, .. } => [2.0 * a / (force * force), 0.0],
            NonlinearLaw::Derating { .. } => [b / (1.0 + b), a / (1.0 + b).powi(2)],
        }
    }
}

/// `3 - n` and `cubic / k`: exponent and factor of the cubic part divided by the power law.
fn release(law: &ForceLaw) -> (f64, f64) {
    (3.0 - law.exponent, law.cubic / law.stiffness)
}

/// `d^n`. It is zero for `d < 0` if the contact only pushes; for a clamped one it is odd, so that it pulls as
/// it pushes.
fn power(law: &ForceLaw, d: f64, unilateral: bool) -> f64 {
    if unilateral { d.max(0.0).powf(law.exponent) } else { d.abs().powf(law.exponent).copysign(d) }
}

/// Derivative of [`power`]: even in `d` if the contact is clamped.
fn power_slope(law: &ForceLaw, d: f64, unilateral: bool) -> f64 {
    let size = if unilateral { d.max(0.0) } else { d.abs() };
    law.exponent * size.powf(law.exponent - 1.0)
}

pub(super) fn terms(assembly: &Assembly, coordinates: &Coordinates) -> Vec<NonlinearTerm> {
    let mut laws = Vec::new();
    let apart = |a, b| coordinates.of(a) != coordinates.of(b);
    for (contact, part) in assembly.contacts.iter().enumerate() {
        if part.engagement != Engagement::Free && !part.law.is_linear() && apart(part.a, part.b) {
            let unilateral = part.engagement == Engagement::Unilateral;
            laws.push(NonlinearLaw::Contact { contact, law: part.law, unilateral });
            laws.push(NonlinearLaw::Elastic { contact, law: part.law, unilateral });
            let law = part.law;
            // Otherwise the force vanishes with the compression, with a linear factor, or by a damper whose
            // whole force is the guard.
            if unilateral && law.damping <= 0.0 && law.alpha > 0.0 && law.stiffness > 0.0 && law.cubic > 0.0 {
                laws.push(NonlinearLaw::Release { contact, law });
            }
        }
    }
    let mut loads = false;
    for (link, part) in
        assembly.links.iter().enumerate().filter(|(_, part)| !part.rigid && apart(part.a, part.b))
    {
        if part.cubic != 0.0 {
            let mut sides: Vec<_> = part.stops().map(|(side, _)| Some(side)).collect();
            if sides.is_empty() {
                sides.push(None);
            }
            laws.extend(sides.into_iter().map(|side| NonlinearLaw::Cubic { link, side, cubic: part.cubic }));
        }
        let friction = part.friction;
        if friction.stribeck_excess > 0.0 {
            laws.push(NonlinearLaw::Stribeck {
                link,
                excess: friction.stribeck_excess,
                velocity: friction.stribeck_velocity,
            });
        }
        loads |= friction.load_ratio > 0.0;
        laws.extend(friction.over.map(|table| NonlinearLaw::Level { link, table }));
        laws.extend(part.over_speed.map(|table| NonlinearLaw::OverSpeed { link, table }));
        if part.drag > 0.0 {
            laws.push(NonlinearLaw::Drag { link, drag: part.drag });
        }
        laws.extend(part.bristle.map(|bristle| NonlinearLaw::Slip { link, bristle }));
    }
    if loads {
        let clamped = assembly
            .contacts
            .iter()
            .enumerate()
            .filter(|(_, part)| part.engagement == Engagement::Clamped && apart(part.a, part.b));
        laws.extend(clamped.map(|(contact, _)| NonlinearLaw::Load { contact }));
    }
    let weights = || assembly.weights.iter().enumerate().filter(|(_, w)| apart(w.on, w.reacts_on));
    if loads {
        let pulled = weights().filter_map(|(weight, part)| Some((weight, part.course.pull()?)));
        laws.extend(pulled.map(|(weight, pull)| NonlinearLaw::Burden { weight, pull }));
    }
    laws.extend(weights().map(|(weight, part)| NonlinearLaw::Weight { weight, course: part.course }));
    for (drive, part) in assembly.drives.iter().enumerate() {
        let ripples = part.ripples.iter().filter(|ripple| ripple.amplitude != 0.0);
        laws.extend(ripples.map(|r| NonlinearLaw::Ripple {
            drive,
            amplitude: r.amplitude,
            pitch: r.pitch,
            phase: r.phase,
        }));
        if let Some(warming) = part.warming {
            laws.extend([
                NonlinearLaw::Heat { drive, force: warming.force },
                NonlinearLaw::Derating { drive },
            ]);
        }
    }
    laws.into_iter().map(|law| NonlinearTerm { law }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::POINTS;

    /// Error of a central difference with a step of 1e-5 of the scale: 1e-10, and its rounding 1e-11, with a
    /// margin.
    const DIFFERENCE: f64 = 1e-8;

    #[test]
    fn prop_gradients_are_differences_of_values() {
        let law = ForceLaw { stiffness: 3e4, exponent: 1.5, damping: 7.0, alpha: 0.4, cubic: 2e3 };
        let bristle = Bristle { stiffness: 40.0, damping: 2.0, coulomb: 1.0, excess: 0.5, velocity: 0.2 };
        let table = TabulatedForce::between(-0.4, 0.4, std::array::from_fn::<_, POINTS, _>(|i| i as f64));
        let laws = [
            NonlinearLaw::Contact { contact: 0, law, unilateral: true },
            NonlinearLaw::Contact { contact: 0, law, unilateral: false },
            NonlinearLaw::Elastic { contact: 0, law, unilateral: true },
            NonlinearLaw::Release { contact: 0, law },
            NonlinearLaw::Release { contact: 0, law: ForceLaw { exponent: 4.2, ..law } },
            NonlinearLaw::Cubic { link: 0, side: None, cubic: 5e3 },
            NonlinearLaw::Drag { link: 0, drag: 3.0 },
            NonlinearLaw::Slip { link: 0, bristle },
            NonlinearLaw::Weight {
                weight: 0,
                course: PositionForce::Pull(Pull { amplitude: 2.0, period: 1.3, phase: 0.4 }),
            },
            NonlinearLaw::Weight { weight: 0, course: PositionForce::Table(table) },
            NonlinearLaw::OverSpeed { link: 0, table },
            NonlinearLaw::Level { link: 0, table },
            NonlinearLaw::Stribeck { link: 0, excess: 4.0, velocity: 0.2 },
            NonlinearLaw::Load { contact: 0 },
            NonlinearLaw::Burden { weight: 0, pull: Pull { amplitude: 2.0, period: 1.3, phase: 0.4 } },
            NonlinearLaw::Ripple { drive: 0, amplitude: 2.0, pitch: 0.7, phase: 0.3 },
            NonlinearLaw::Heat { drive: 0, force: 0.5 },
            NonlinearLaw::Derating { drive: 0 },
        ];
        for term in laws.map(|law| NonlinearTerm { law }) {
            for (a, b) in [(0.3, 0.2), (-0.3, 0.1), (0.05, -0.4)] {
                let h = 1e-6;
                let by_a = (term.value(a + h, b) - term.value(a - h, b)) / (2.0 * h);
                let by_b = (term.value(a, b + h) - term.value(a, b - h)) / (2.0 * h);
                let [da, db] = term.gradient(a, b);
                let scale = 1.0 + by_a.abs() + by_b.abs() + term.value(a, b).abs();
                assert!(
                    (da - by_a).abs() + (db - by_b).abs() < DIFFERENCE * scale,
                    "{:?} at {a}, {b}",
                    term.law
                );
            }
        }
    }

    /// The mean of a sine over an interval is the difference of cosines over its length.
    #[test]
    fn truth_an_even_mean_is_that_of_the_sine_up_to_a_quarter_of_its_period() {
        let (amplitude, pitch) = (2.0, 0.7);
        let law = NonlinearLaw::Ripple { drive: 0, amplitude, pitch, phase: 0.0 };
        let k = std::f64::consts::TAU / pitch;
        for i in 0..50 {
            let start = 0.03 * f64::from(i);
            let mean = |span: f64| {
                (NonlinearTerm { law }.even_mean([start, 0.0], [start + span, 0.0]), start + span)
            };
            for span in [0.02 * pitch, 0.1 * pitch, 0.24 * pitch] {
                let (found, end) = mean(span);
                let exact = amplitude * ((k * start).cos() - (k * end).cos()) / (k * span);
                // Remainder of Simpson's rule, (k span)^4 / 2880, at a quarter of the period.
                assert!((found.unwrap() - exact).abs() < 3e-3 * amplitude, "{start} {span}");
            }
        }
        // From zero to zero, the mean of the ends says nothing about the maximum halfway.
        assert_eq!(NonlinearTerm { law }.even_mean([0.0, 0.0], [0.5 * pitch, 0.0]), None);
    }
}
