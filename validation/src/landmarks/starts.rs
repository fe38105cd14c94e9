//! Starting points of fits: chains from the frequencies of the landmarks alone.

use std::f64::consts::TAU;

use feeler_control::Stream;

use super::PAPER;
use super::chain::{LINKS, LandmarkChain};

/// Bodies of the chain without its base.
const BODIES: usize = LINKS + 1;
/// Total mass of these bodies, kg: arbitrary, since the landmarks do not determine the size of a chain.
const MOVING_KG: f64 = 60.0;
const MOUNT_DAMPING_RATIO: f64 = 0.03;
/// Damping of the guide over the moving mass, 1/s.
const GUIDE_PER_S: f64 = 0.05;
/// Stiffness of the sensor over that of the stiffest joint, and its damping ratio at the frequency of the
/// force's landmark.
const SENSOR_STIFFER: f64 = 10.0;
const SENSOR_DAMPING_RATIO: f64 = 0.005;

/// Parameters that the landmarks do not determine.
struct Guess {
    /// Share of each of the chain's modes, the rigid one first, in the motion of the motor after a push on
    /// the motor.
    shares: [f64; BODIES],
    /// Mass of the base over that of the rest.
    base: f64,
    /// Damping ratio of the joints at the middle of the resonances.
    joints: f64,
    /// Damping ratio of the source with the chain as one body.
    source: f64,
}

impl Guess {
    /// The middle of every range. The motor has half of the mass, and the flexible modes have equal shares.
    /// The base is as heavy as the rest, and the source is critically damped.
    const NEUTRAL: Self =
        Self { shares: [0.5, 0.125, 0.125, 0.125, 0.125], base: 1.0, joints: 0.01, source: 1.0 };

    /// A random choice. The motor has 20 to 90 % of the mass, and the flexible modes have shares within a
    /// decade. The base has a third to ten times the rest. Joints are damped by 0.3 to 5 %, and a source has
    /// half to twice the critical damping.
    fn drawn(number: u64) -> Self {
        let stream = Stream::new(number, "start of a fit");
        let between = |index, low: f64, high: f64| low * (high / low).powf(stream.uniform_at(index));
        let rigid = 0.2 + 0.7 * stream.uniform_at(0);
        let flexible: [f64; LINKS] = std::array::from_fn(|i| between(1 + i as u64, 0.3, 3.0));
        let scale = (1.0 - rigid) / flexible.iter().sum::<f64>();
        Self {
            shares: std::array::from_fn(|i| if i == 0 { rigid } else { scale * flexible[i - 1] }),
            base: between(5, 0.3, 10.0),
            joints: between(6, 0.003, 0.05),
            source: between(7, 0.5, 2.0),
        }
    }
}

impl LandmarkChain {
    /// The start with this number: a chain with the paper's four flexible resonances when nothing holds it.
    /// There is one such chain for each set of shares of the modes in the motor's motion. This is Gantmacher
    /// and Krein's inverse problem, solved by Lanczos's recursion. The chain stands on a base at the paper's
    /// first resonance. Its source turns the acceleration of the rigid chain through zero degrees at the
    /// frequency of the paper's end-point. Undetermined parameters are guessed. Start 0 takes the middle of
    /// every range, the others draw from them, always the same for a number.
    pub fn start(number: u64) -> Self {
        let guess = if number == 0 { Guess::NEUTRAL } else { Guess::drawn(number) };
        let squares =
            std::array::from_fn(|i| if i == 0 { 0.0 } else { (TAU * PAPER.resonances_hz[i]).powi(2) });
        let (masses, stiffness_n_per_m) = with_resonances(&squares, &guess.shares);
        let middle = TAU * PAPER.resonances_hz[1..].iter().product::<f64>().powf(1.0 / LINKS as f64);
        let w = TAU * PAPER.end_hz;
        let time_constant_s = 1.0 / (2.0 * guess.source * w);
        let sensor = SENSOR_STIFFER * stiffness_n_per_m.into_iter().fold(0.0, f64::max);
        Self {
            base_kg: guess.base * MOVING_KG,
            mount: [PAPER.resonances_hz[0], MOUNT_DAMPING_RATIO],
            motor_kg: masses[0],
            guide_n_s_per_m: GUIDE_PER_S * MOVING_KG,
            masses_kg: std::array::from_fn(|i| masses[i + 1]),
            stiffness_n_per_m,
            damping_n_s_per_m: stiffness_n_per_m.map(|k| 2.0 * guess.joints * k / middle),
            source: [MOVING_KG * w * w * time_constant_s, time_constant_s],
            sensor: [sensor, 2.0 * SENSOR_DAMPING_RATIO * sensor / (TAU * PAPER.force_hz)],
        }
    }
}

/// Masses (kg, in total [`MOVING_KG`]) and springs (N/m) of a free chain. It has these squared frequencies,
/// and these shares of its modes at its first body.
fn with_resonances(squares: &[f64; BODIES], shares: &[f64; BODIES]) -> ([f64; BODIES], [f64; LINKS]) {
    // The chain's matrix M^-1/2 K M^-1/2 is the tridiagonal one of Lanczos's recursion on the squares,
    // started at the roots of the shares.
    let mut vectors: Vec<[f64; BODIES]> = vec![shares.map(f64::sqrt)];
    let (mut diagonal, mut beside) = ([0.0; BODIES], [0.0; LINKS]);
    for j in 0..BODIES {
        let q = vectors[j];
        let mut next: [f64; BODIES] = std::array::from_fn(|i| squares[i] * q[i]);
        diagonal[j] = dot(&q, &next);
        if j == LINKS {
            break;
        }
        // Twice, so that rounding leaves no component of the earlier vectors.
        for _ in 0..2 {
            for v in &vectors {
                let part = dot(v, &next);
                (0..BODIES).for_each(|i| next[i] -= part * v[i]);
            }
        }
        beside[j] = dot(&next, &next).sqrt();
        vectors.push(next.map(|value| value / beside[j]));
    }
    // For rigid motion the matrix maps M^1/2 times it to zero.
    let mut roots = [1.0; BODIES];
    for i in 0..LINKS {
        let before = if i == 0 { 0.0 } else { beside[i - 1] * roots[i - 1] };
        roots[i + 1] = (diagonal[i] * roots[i] - before) / beside[i];
    }
    let scale = (MOVING_KG / dot(&roots, &roots)).sqrt();
    let roots = roots.map(|root| root * scale);
    (roots.map(|root| root * root), std::array::from_fn(|i| beside[i] * roots[i] * roots[i + 1]))
}

fn dot(a: &[f64; BODIES], b: &[f64; BODIES]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::SMatrix;

    /// Five bodies' eigenvalues, relative to the largest: a hundred roundings.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn truth_a_free_chain_starts_with_the_papers_resonances() {
        for number in 0..20 {
            let chain = LandmarkChain::start(number);
            let masses: Vec<f64> = std::iter::once(chain.motor_kg).chain(chain.masses_kg).collect();
            let mut k = SMatrix::<f64, BODIES, BODIES>::zeros();
            for (i, stiffness) in chain.stiffness_n_per_m.into_iter().enumerate() {
                for (a, b, sign) in [(i, i, 1.0), (i + 1, i + 1, 1.0), (i, i + 1, -1.0), (i + 1, i, -1.0)] {
                    k[(a, b)] += sign * stiffness / (masses[a] * masses[b]).sqrt();
                }
            }
            let mut found: Vec<f64> = k.symmetric_eigenvalues().iter().copied().collect();
            found.sort_by(f64::total_cmp);
            let largest = found[LINKS];
            assert!(
                found[0].abs() < ROUNDING * largest && masses.iter().all(|m| *m > 0.0),
                "{found:?} {masses:?}"
            );
            for (found, named_hz) in found.iter().zip(PAPER.resonances_hz).skip(1) {
                let expected = (TAU * named_hz).powi(2);
                assert!(
                    (found - expected).abs() < ROUNDING * largest,
                    "start {number}: {found} instead of {expected}"
                );
            }
        }
    }
}
