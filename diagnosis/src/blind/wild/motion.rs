//! Slow motions and the servo that follows them.

use std::f64::consts::TAU;

use super::super::axis::Axis;
use super::super::noise::Random;

/// Partial waves of a motion: multiples of the fundamental frequency, and shares of the amplitude.
const PARTIALS: [[f64; 2]; 3] = [[1.0, 0.6], [1.7, 0.25], [2.9, 0.15]];
/// Error at which the servo's force equals the largest command, over the amplitude.
const STIFF_SHARE: f64 = 0.05;
/// Damping ratio of the servo.
const SERVO_DAMPING: f64 = 0.7;
/// Speed, over the largest speed, within which the servo's friction compensation changes sign.
const SIGN_SHARE: f64 = 0.05;
/// Share of friction and gravity that the servo compensates.
const KNOWN_SHARE: f64 = 0.7;

/// Time constant of the start of a motion, in radians of its fundamental.
const RISE: f64 = 0.6;

/// Magnitudes of a case, in units of its axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sizes {
    /// Largest excursion, m.
    pub(super) amplitude: f64,
    /// Fundamental frequency, rad/s.
    pub(super) omega: f64,
    /// Largest force of inertia and viscous damping, N.
    pub(super) moving: f64,
    /// Largest command, N.
    pub(super) command: f64,
}

impl Sizes {
    /// Largest speed, m/s.
    pub(super) fn speed(&self) -> f64 {
        self.amplitude * self.omega
    }

    /// Stiffness of the servo, N/m.
    fn stiffness(&self) -> f64 {
        self.command / (STIFF_SHARE * self.amplitude)
    }

    /// Frequency of the servo with this mass, rad/s.
    pub(super) fn servo(&self, mass_kg: f64) -> f64 {
        (self.stiffness() / mass_kg).sqrt()
    }
}

/// The reference motion of the axis.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    /// Amplitude (m), frequency (rad/s) and phase (rad) of each wave.
    waves: Vec<[f64; 3]>,
    /// Period over which the amplitude rises and falls, s.
    swell_s: Option<f64>,
}

impl Motion {
    /// Waves of random phases; `share` is their amplitude over that of the case.
    pub(super) fn waves(sizes: &Sizes, share: f64, random: &mut Random) -> Self {
        let wave = |[multiple, part]: [f64; 2]| {
            [share * part * sizes.amplitude, multiple * sizes.omega, random.between(0.0, TAU)]
        };
        Self { waves: PARTIALS.map(wave).to_vec(), swell_s: None }
    }

    /// A single sine.
    pub(super) fn stroke(sizes: &Sizes, share: f64, multiple: f64) -> Self {
        Self { waves: vec![[share * sizes.amplitude, multiple * sizes.omega, 0.0]], swell_s: None }
    }

    /// Waves whose amplitude rises and falls.
    pub(super) fn swelling(sizes: &Sizes, random: &mut Random) -> Self {
        Self { swell_s: Some(5.0 * TAU / sizes.omega), ..Self::waves(sizes, 1.0, random) }
    }

    /// Desired position, speed and acceleration.
    fn wanted(&self, t_s: f64) -> [f64; 3] {
        let mut wanted = [0.0; 3];
        for [amplitude, omega, phase] in &self.waves {
            let (sin, cos) = (omega * t_s + phase).sin_cos();
            wanted[0] += amplitude * sin;
            wanted[1] += amplitude * omega * cos;
            wanted[2] -= amplitude * omega * omega * sin;
        }
        let Some(swell_s) = self.swell_s else { return wanted };
        let slow = TAU / swell_s;
        let (sin, cos) = (slow * t_s).sin_cos();
        let (size, rate, curve) = (0.65 - 0.35 * cos, 0.35 * slow * sin, 0.35 * slow * slow * cos);
        let [x, v, a] = wanted;
        [size * x, size * v + rate * x, size * a + 2.0 * rate * v + curve * x]
    }
}

impl Motion {
    /// Start position, m.
    pub(super) fn start(&self) -> f64 {
        self.wanted(0.0)[0]
    }

    /// The motion begun at rest: its time runs slowly at first.
    fn begun_at_rest(&self, t_s: f64, rise_s: f64) -> [f64; 3] {
        let fading = (-t_s / rise_s).exp();
        let [x, v, a] = self.wanted(t_s - rise_s * (1.0 - fading));
        let pace = 1.0 - fading;
        [x, v * pace, a * pace * pace + v * fading / rise_s]
    }
}

/// A stiff position servo with feedforward from a rough model of its axis.
pub(super) struct Servo<'a> {
    motion: &'a Motion,
    axis: &'a Axis,
    sizes: Sizes,
}

impl<'a> Servo<'a> {
    pub(super) fn new(motion: &'a Motion, axis: &'a Axis, sizes: Sizes) -> Self {
        Self { motion, axis, sizes }
    }

    /// The command at a position and speed of the motor.
    pub(super) fn command(&self, t_s: f64, [x, v]: [f64; 2]) -> f64 {
        let (axis, sizes) = (self.axis, &self.sizes);
        let [x_wanted, v_wanted, a_wanted] = self.motion.begun_at_rest(t_s, RISE / sizes.omega);
        let stiffness = sizes.stiffness();
        let damping = 2.0 * SERVO_DAMPING * (stiffness * axis.mass_kg()).sqrt();
        let sign = (v_wanted / (SIGN_SHARE * sizes.speed())).tanh();
        let gravity = axis.gravity.map_or(0.0, |[amplitude, phase]| amplitude * (x_wanted + phase).sin());
        let ahead = axis.mass_kg() * a_wanted
            + axis.damping * v_wanted
            + KNOWN_SHARE * (axis.friction.level * sign + gravity);
        (ahead + stiffness * (x_wanted - x) + damping * (v_wanted - v))
            .clamp(-3.0 * sizes.command, 3.0 * sizes.command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative error of central differences over 0.1 ms: about (3 omega h)^2.
    const DIFFERENCE: f64 = 1e-5;

    #[test]
    fn truth_speed_and_acceleration_are_slopes_of_the_motion() {
        let sizes = Sizes { amplitude: 0.5, omega: 6.0, moving: 3.0, command: 5.0 };
        let motion = Motion::swelling(&sizes, &mut Random::new(3));
        let h = 1e-4;
        for k in 0..50 {
            let t = 0.05 + 0.07 * f64::from(k);
            let [before, at, after] = [t - h, t, t + h].map(|t| motion.begun_at_rest(t, 0.1));
            for (wanted, (after, before)) in at[1..].iter().zip(after.iter().zip(&before)) {
                let slope = (after - before) / (2.0 * h);
                assert!((slope - wanted).abs() < DIFFERENCE * sizes.amplitude * sizes.omega.powi(3));
            }
        }
    }
}
