//! Bodies fitted to the arm's response, if several of its modes share the tool.
//!
//! The fit uses the response of the contact force, of the tool in the air and of the motor. Its frequencies
//! extend from well below the contact mode to beyond the phase crossover and the edges of the sampled loops.
//! The motor's response alone continues to half the sample rate, which determines the mass at the drive. The
//! method is least squares of the logarithms (K. Levenberg 1944, D. W. Marquardt 1963). Springs and dampers
//! are squares, masses squares plus a minimum, so that none is negative.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, DVector};

use crate::agreement::WholeArm;
use crate::branch::Branch;
use crate::flexible::LinearArm;
use crate::reduce::Reduction;
use crate::sampled::{Edge, Law, PERIOD_S};

/// Number of frequencies at which the response is compared with the arm's.
const POINTS: u32 = 100;
/// First of these frequencies over the contact mode, and last over the highest landmark.
const SPAN: [f64; 2] = [0.2, 1.6];
/// Further frequencies, up to half the sample rate, for the motor's displacement alone, and its weight there.
const BEYOND: u32 = 24;
const OF_MOTOR: f64 = 0.5;
/// Smallest mass of motor, tool or body over the whole. A lighter mass would only join two springs. No data
/// determine it, and it is stiff to simulate.
const LEAST: f64 = 1e-3;
/// Width of the neighbourhood of a landmark, as a logarithm of frequencies, and its weight relative to the
/// rest.
const NEIGHBOURHOOD: f64 = 0.1;
const NEAR: f64 = 4.0;
/// Further frequencies about each landmark, relative to it.
const ABOUT: [f64; 5] = [-0.04, -0.015, 0.0, 0.015, 0.04];
/// Weight of each landmark, relative to the response at one frequency.
const OF_LANDMARKS: f64 = 30.0;
/// Weight of the contact mode relative to the other landmarks, squared; masses and springs alone determine
/// its frequency.
const OF_MODE: f64 = 5.0;
/// Share of the crossover on each side for the slope of the phase, and the smallest accepted slope, rad per
/// logarithm.
const BESIDE_CROSSOVER: f64 = 2e-3;
const FLATTEST: f64 = 0.1;
/// Weight of the tool's displacement in the air, and of the motor's in contact, relative to the contact
/// force.
const BESIDE: f64 = 0.3;
/// Largest number of Levenberg-Marquardt steps, and the gain per step below which they end.
const STEPS: usize = 100;
const GAIN: f64 = 1e-4;
/// Initial value of a parameter that is zero, over its scale: a square has slope zero at zero, so it would
/// never move.
const AWAKE: f64 = 1e-4;
/// Finite difference of a parameter.
const DIFFERENCE: f64 = 1e-6;

/// The responses of the whole arm to which the axis is fitted.
#[derive(Clone)]
pub(crate) struct Wanted {
    contact: [f64; 2],
    /// Total mass and viscous friction, which stay fixed.
    mass_kg: f64,
    guide_damping_n_s_per_m: f64,
    s: Vec<Complex<f64>>,
    /// Contact force, tool in the air, motor in contact; per drive force, with the weights of each.
    responses: Vec<[Complex<f64>; 3]>,
    weights: Vec<[f64; 3]>,
    contact_mode_hz: f64,
    /// Frequency at which the phase falls through -180 degrees, Hz, and its slope there per logarithm of the
    /// frequency, rad.
    crossover: Option<(f64, f64)>,
    loops: Vec<(Law, Edge)>,
    /// Weight of each landmark.
    of_landmarks: f64,
}

/// An axis as squares of parameters: masses of motor, tool and bodies, then stiffness and damping of every
/// spring; all over `scale`.
struct Shape {
    scale: Vec<f64>,
    bodies: usize,
}

impl Wanted {
    /// `None` for an arm whose contact mode is faster than half the sample rate.
    pub(crate) fn new(
        linear: &LinearArm,
        pair: &Reduction,
        contact: [f64; 2],
        whole: &WholeArm,
    ) -> Option<Self> {
        let last = 0.5 / PERIOD_S;
        let landmarks: Vec<f64> =
            whole.frequencies_hz().into_iter().filter(|f| *f > 0.0 && *f < last).collect();
        let [mode, crossover, ..] = whole.frequencies_hz();
        if !(mode > 0.0 && mode < last) {
            return None;
        }
        let (from, to) =
            (SPAN[0] * mode, (SPAN[1] * landmarks.iter().copied().fold(mode, f64::max)).min(last));
        let spread = |from: f64, to: f64, count: u32| {
            (0..count).map(move |i| from * (to / from).powf(f64::from(i) / f64::from(count - 1)))
        };
        let near =
            |f: f64| landmarks.iter().map(|at| (-((f / at).ln() / NEIGHBOURHOOD).powi(2)).exp()).sum::<f64>();
        let beside = BESIDE * BESIDE;
        let within = spread(from, to, POINTS)
            .map(|f| (f, [1.0, beside, beside].map(|share| share * (1.0 + NEAR * near(f)))));
        let beyond = spread(to, last, BEYOND).skip(1).map(|f| (f, [0.0, 0.0, OF_MOTOR * OF_MOTOR]));
        let mut points: Vec<(f64, [f64; 3])> = within.chain(beyond).collect();
        let at = landmarks.iter().flat_map(|at| ABOUT.map(|about| at * (1.0 + about)));
        points.extend(at.map(|f| (f, [1.0, beside, beside].map(|share| share * (1.0 + NEAR * near(f))))));
        let (grid, weights): (Vec<f64>, Vec<[f64; 3]>) = points.into_iter().unzip();
        let system = &linear.system;
        let (pressed, free) = (system.moved(contact, &grid), system.moved([0.0; 2], &grid));
        let s: Vec<_> = grid.iter().map(|f| Complex::new(0.0, TAU * f)).collect();
        let responses = (pressed.iter().zip(&free).zip(&s))
            .map(|((p, f), s)| [(contact[0] + contact[1] * s) * p[0], f[0], p[1]]);
        let slope = |hz: f64| {
            let beside = [hz * (1.0 - BESIDE_CROSSOVER), hz * (1.0 + BESIDE_CROSSOVER)];
            let found = system.response_in_contact(contact, &beside);
            ((found[1] / found[0]).arg() / (2.0 * BESIDE_CROSSOVER)).min(-FLATTEST)
        };
        Some(Self {
            contact,
            contact_mode_hz: mode,
            crossover: crossover.is_finite().then(|| (crossover, slope(crossover))),
            loops: whole.loops(),
            of_landmarks: OF_LANDMARKS,
            mass_kg: pair.mass_kg,
            guide_damping_n_s_per_m: pair.guide_damping_n_s_per_m,
            weights,
            responses: responses.collect(),
            s,
        })
    }

    /// The axis nearest to the arm's responses, from a starting point.
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
                slopes.set_column(
                    i,
                    &((self.residuals(&shape.axis(self, start, &beside)) - &left) / DIFFERENCE),
                );
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

    /// These responses with `factor` times the weight of the landmarks: for an arm whose phase barely falls
    /// through -180 degrees, or with a small slope.
    pub(crate) fn closer(&self, factor: f64) -> Self {
        Self { of_landmarks: factor * self.of_landmarks, ..self.clone() }
    }

    /// Differences of the landmarks of an axis as logarithms, to first order in the differences of its
    /// responses at the arm's landmarks.
    fn landmarks(&self, axis: &Reduction) -> Vec<f64> {
        let at = |hz: f64| {
            let s = Complex::new(0.0, TAU * hz);
            let touch = self.contact[0] + self.contact[1] * s;
            (touch, axis.moved(touch, s))
        };
        let mode = OF_MODE * (axis.contact_mode_hz(self.contact[0]) / self.contact_mode_hz).ln();
        let crossover = self.crossover.map(|(hz, phase_per_log)| {
            let (touch, moved) = at(hz);
            (-touch * moved[0]).arg() / phase_per_log
        });
        let loops = self.loops.iter().map(|(law, edge)| {
            let [tool, motor] = at(edge.frequency_hz).1;
            let off = (-edge.gain
                * law.open_at(edge.frequency_hz, axis.bandwidth_hz, [self.contact[0] * tool, motor]))
            .ln();
            off.re - off.im * edge.size_per_phase
        });
        std::iter::once(mode).chain(crossover).chain(loops).collect()
    }

    /// Logarithms of the axis's responses over the arm's, real and imaginary, weighted.
    fn residuals(&self, axis: &Reduction) -> DVector<f64> {
        let mut all = Vec::with_capacity(6 * self.s.len() + 4);
        all.extend(self.landmarks(axis).into_iter().map(|off| self.of_landmarks.sqrt() * off));
        for ((s, wanted), weights) in self.s.iter().zip(&self.responses).zip(&self.weights) {
            let touch = self.contact[0] + self.contact[1] * s;
            let pressed = axis.moved(touch, *s);
            let mut off = |found: Complex<f64>, wanted: Complex<f64>, weight: f64| {
                let off = weight.sqrt() * (found / wanted).ln();
                all.extend([off.re, off.im]);
            };
            off(pressed[1], wanted[2], weights[2]);
            if weights[0] > 0.0 {
                let [free, _] = axis.moved(Complex::new(0.0, 0.0), *s);
                off(touch * pressed[0], wanted[0], weights[0]);
                off(free, wanted[1], weights[1]);
            }
        }
        DVector::from_vec(all)
    }
}

impl Shape {
    fn parameters(&self, axis: &Reduction) -> DVector<f64> {
        let branches = &axis.branches;
        let masses =
            [axis.motor_mass_kg, axis.tip_mass_kg].into_iter().chain(branches.iter().map(|b| b.mass_kg));
        let stiffness = std::iter::once(axis.stiffness_n_per_m)
            .chain(branches.iter().flat_map(|b| [b.stiffness_n_per_m, b.to_tool_n_per_m]));
        let damping = std::iter::once(axis.damping_n_s_per_m)
            .chain(branches.iter().flat_map(|b| [b.damping_n_s_per_m, b.to_tool_n_s_per_m]));
        let masses = masses.map(|mass| mass - LEAST * self.scale[0]);
        let values = masses
            .chain(stiffness)
            .chain(damping)
            .zip(&self.scale)
            .map(|(value, scale)| (value / scale).max(AWAKE).sqrt());
        DVector::from_iterator(self.scale.len(), values)
    }

    fn axis(&self, wanted: &Wanted, start: &Reduction, p: &DVector<f64>) -> Reduction {
        let masses = 2 + self.bodies;
        let mut value: Vec<f64> = p.iter().zip(&self.scale).map(|(p, scale)| p * p * scale).collect();
        // The mass beyond the minimum is shared out, so that the total mass is kept.
        let beyond = wanted.mass_kg * (1.0 - LEAST * masses as f64) / value[..masses].iter().sum::<f64>();
        value[..masses].iter_mut().for_each(|mass| *mass = LEAST * wanted.mass_kg + beyond * *mass);
        let (stiffness, damping) = value[masses..].split_at(1 + 2 * self.bodies);
        let branch = |i: usize| Branch {
            mass_kg: value[2 + i],
            stiffness_n_per_m: stiffness[1 + 2 * i],
            damping_n_s_per_m: damping[1 + 2 * i],
            to_tool_n_per_m: stiffness[2 + 2 * i],
            to_tool_n_s_per_m: damping[2 + 2 * i],
        };
        Reduction {
            motor_mass_kg: value[0],
            tip_mass_kg: value[1],
            stiffness_n_per_m: stiffness[0],
            damping_n_s_per_m: damping[0],
            guide_damping_n_s_per_m: wanted.guide_damping_n_s_per_m,
            branches: (0..self.bodies).map(branch).collect(),
            ..start.clone()
        }
    }
}
