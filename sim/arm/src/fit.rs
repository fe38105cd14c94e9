//! Bodies that are fitted to the arm's response, where its modes share the tool.
//!
//! The response of the force in contact, the tool's in the air and the motor's, over the frequencies from well below the contact mode to beyond the phase
//! crossover, by least squares of their logarithms (K. Levenberg 1944, D. W. Marquardt 1963). Masses, springs and dampers are squares, so that none is negative.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, DVector};

use crate::branches::Branch;
use crate::flexible::LinearArm;
use crate::reduce::Reduction;

/// Frequencies at which the response is held against the arm's.
const POINTS: u32 = 100;
/// First of them over the contact mode, and last over the phase crossover.
const SPAN: [f64; 2] = [0.2, 1.6];
/// Width of the neighbourhood of a landmark, as a logarithm of frequencies, and its weight over that of all else.
const NEIGHBOURHOOD: f64 = 0.1;
const NEAR: f64 = 4.0;
/// The same width for a crossover that such weights miss.
const CLOSER: f64 = 0.05;
/// Weight of the tool's way in the air, and of the motor's in contact, over that of the contact's force.
const BESIDE: f64 = 0.3;
/// Steps of Levenberg and Marquardt, and the gain per step below which they end.
const STEPS: usize = 100;
const GAIN: f64 = 1e-4;
/// Finite difference of a parameter.
const DIFFERENCE: f64 = 1e-6;

/// What the axis is fitted to: responses of the whole arm.
#[derive(Clone)]
pub(crate) struct Wanted {
    contact: [f64; 2],
    /// Total mass and viscous friction, which are kept.
    mass_kg: f64,
    guide_damping_n_s_per_m: f64,
    s: Vec<Complex<f64>>,
    weights: Vec<f64>,
    /// Weights of the contact's force, beyond these.
    more: Vec<f64>,
    crossover_hz: f64,
    /// Contact force, tool in the air, motor in contact; per drive force.
    responses: Vec<[Complex<f64>; 3]>,
}

/// An axis as squares of parameters: masses of motor, tool and bodies, then stiffness and damping of every spring; all over `scale`.
struct Shape {
    scale: Vec<f64>,
    bodies: usize,
}

impl Wanted {
    pub(crate) fn new(linear: &LinearArm, pair: &Reduction, contact: [f64; 2], landmarks_hz: [f64; 2]) -> Option<Self> {
        let [mode, crossover] = landmarks_hz;
        if !(mode > 0.0 && crossover.is_finite()) {
            return None;
        }
        let (from, to) = (SPAN[0] * mode, SPAN[1] * crossover.max(mode));
        let grid: Vec<f64> = (0..POINTS).map(|i| from * (to / from).powf(f64::from(i) / f64::from(POINTS - 1))).collect();
        let near = |f: f64| landmarks_hz.iter().map(|at| (-((f / at).ln() / NEIGHBOURHOOD).powi(2)).exp()).sum::<f64>();
        let system = &linear.system;
        let (pressed, free) = (system.moved(contact, &grid), system.moved([0.0; 2], &grid));
        let s: Vec<_> = grid.iter().map(|f| Complex::new(0.0, TAU * f)).collect();
        let responses = (pressed.iter().zip(&free).zip(&s)).map(|((p, f), s)| [(contact[0] + contact[1] * s) * p[0], f[0], p[1]]);
        Some(Self {
            contact,
            mass_kg: pair.mass_kg,
            guide_damping_n_s_per_m: pair.guide_damping_n_s_per_m,
            weights: grid.iter().map(|f| 1.0 + NEAR * near(*f)).collect(),
            more: vec![0.0; grid.len()],
            crossover_hz: crossover,
            responses: responses.collect(),
            s,
        })
    }

    /// The arm's phase crossover.
    pub(crate) fn crossover_hz(&self) -> f64 {
        self.crossover_hz
    }

    /// The axis nearest to the arm's responses that is reached from a start.
    pub(crate) fn fit(&self, start: &Reduction) -> Reduction {
        let bodies = start.branches.len();
        let springs = 1 + 2 * bodies;
        let own = start.stiffness_n_per_m;
        let loss = start.damping_n_s_per_m.max(1e-3 * (own * self.mass_kg).sqrt());
        let scale = [vec![self.mass_kg; 2 + bodies], vec![own; springs], vec![loss; springs]].concat();
        let shape = Shape { scale, bodies };
        let mut p = shape.parameters(start);
        let mut left = self.residuals(&shape.axis(self, start, &p));
        let mut damping = 1e-2;
        let mut small = 0;
        for _ in 0..STEPS {
            let n = p.len();
            let mut slopes = DMatrix::zeros(left.len(), n);
            for i in 0..n {
                let mut beside = p.clone();
                beside[i] += DIFFERENCE;
                slopes.set_column(i, &((self.residuals(&shape.axis(self, start, &beside)) - &left) / DIFFERENCE));
            }
            let (normal, gradient) = (slopes.tr_mul(&slopes), slopes.tr_mul(&left));
            let mut gained = None;
            while damping < 1e8 {
                let damped = &normal + DMatrix::identity(n, n) * damping;
                let Some(step) = damped.cholesky().map(|c| c.solve(&gradient)) else { break };
                let next = &p - step;
                let found = self.residuals(&shape.axis(self, start, &next));
                if found.norm_squared() < left.norm_squared() {
                    gained = Some(1.0 - found.norm_squared() / left.norm_squared());
                    (p, left) = (next, found);
                    damping *= 0.2;
                    break;
                }
                damping *= 4.0;
            }
            small = if gained.is_some_and(|gain| gain < GAIN) { small + 1 } else { 0 };
            if gained.is_none() || small > 2 {
                break;
            }
        }
        shape.axis(self, start, &p)
    }

    /// The same, the contact's force about the crossover weighing `factor` times as much as all else: for an arm whose phase falls through -180 degrees hardly, or at a flat
    /// slope.
    pub(crate) fn at_the_crossover(&self, factor: f64) -> Self {
        let near = |s: &Complex<f64>| (-((s.im / TAU / self.crossover_hz).ln() / CLOSER).powi(2)).exp();
        Self { more: self.s.iter().map(|s| factor * near(s)).collect(), ..self.clone() }
    }

    /// Logarithms of the axis's responses over the arm's, real and imaginary, weighted.
    fn residuals(&self, axis: &Reduction) -> DVector<f64> {
        let mut all = Vec::with_capacity(6 * self.s.len());
        for (((s, wanted), weight), more) in self.s.iter().zip(&self.responses).zip(&self.weights).zip(&self.more) {
            let touch = self.contact[0] + self.contact[1] * s;
            let (pressed, free) = (axis.moved(touch, *s), axis.moved(Complex::new(0.0, 0.0), *s));
            let found = [touch * pressed[0], free[0], pressed[1]];
            for (((found, wanted), share), more) in found.iter().zip(wanted).zip([1.0, BESIDE, BESIDE]).zip([*more, 0.0, 0.0]) {
                let off = (found / wanted).ln();
                let w = (share * share * weight + more).sqrt();
                all.extend([w * off.re, w * off.im]);
            }
        }
        DVector::from_vec(all)
    }
}

impl Shape {
    fn parameters(&self, axis: &Reduction) -> DVector<f64> {
        let branches = &axis.branches;
        let masses = [axis.motor_mass_kg, axis.tip_mass_kg].into_iter().chain(branches.iter().map(|b| b.mass_kg));
        let stiffness =
            std::iter::once(axis.stiffness_n_per_m).chain(branches.iter().flat_map(|b| [b.stiffness_n_per_m, b.to_tool_n_per_m]));
        let damping =
            std::iter::once(axis.damping_n_s_per_m).chain(branches.iter().flat_map(|b| [b.damping_n_s_per_m, b.to_tool_n_s_per_m]));
        let values = masses.chain(stiffness).chain(damping).zip(&self.scale).map(|(value, scale)| (value / scale).max(0.0).sqrt());
        DVector::from_iterator(self.scale.len(), values)
    }

    fn axis(&self, wanted: &Wanted, start: &Reduction, p: &DVector<f64>) -> Reduction {
        let value: Vec<f64> = p.iter().zip(&self.scale).map(|(p, scale)| p * p * scale).collect();
        let masses = 2 + self.bodies;
        let share = wanted.mass_kg / value[..masses].iter().sum::<f64>();
        let (stiffness, damping) = value[masses..].split_at(1 + 2 * self.bodies);
        let branch = |i: usize| Branch {
            mass_kg: share * value[2 + i],
            stiffness_n_per_m: stiffness[1 + 2 * i],
            damping_n_s_per_m: damping[1 + 2 * i],
            to_tool_n_per_m: stiffness[2 + 2 * i],
            to_tool_n_s_per_m: damping[2 + 2 * i],
        };
        Reduction {
            motor_mass_kg: share * value[0],
            tip_mass_kg: share * value[1],
            stiffness_n_per_m: stiffness[0],
            damping_n_s_per_m: damping[0],
            guide_damping_n_s_per_m: wanted.guide_damping_n_s_per_m,
            branches: (0..self.bodies).map(branch).collect(),
            ..start.clone()
        }
    }
}
