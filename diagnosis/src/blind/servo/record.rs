//! Targets that are sent to a servo, and the recorded position.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use super::super::axis::State;
use super::super::noise::Random;
use super::draw::Drawn;
use super::firmware::Memory;

/// Integration steps per radian of the highest frequency.
const STEPS_PER_RADIAN: f64 = 12.0;
/// Ratio of an encoder's noise to its resolution.
const ENCODER_NOISE: f64 = 0.2;
/// Number of partial waves of a motion, and their range of frequencies over the loop's frequency.
const PARTIALS: usize = 14;
const SPAN: [f64; 2] = [0.06, 1.6];
/// Time for the joint to settle before the first row, in radians of the loop.
const SETTLING: f64 = 60.0;

/// The target of the servo.
#[derive(Clone, Debug)]
pub(super) enum Asked {
    /// Amplitude (rad), frequency (rad/s) and phase.
    Waves(Vec<[f64; 3]>),
    /// Levels (rad) of this duration, s.
    Steps(Vec<f64>, f64),
    /// Triangle wave: amplitude (rad) and period (s).
    Strokes(f64, f64),
}

impl Asked {
    /// Waves across the loop's band, with smaller amplitudes at higher frequencies. `share` is a fraction of
    /// the case's amplitude.
    pub(super) fn waves(drawn: &Drawn, share: f64, random: &mut Random) -> Self {
        let omega = TAU * drawn.conditions.loop_hz;
        let ratio = SPAN[1] / SPAN[0];
        let mut waves: Vec<[f64; 3]> = (0..PARTIALS)
            .map(|k| {
                let multiple = SPAN[0] * ratio.powf(k as f64 / (PARTIALS - 1) as f64);
                [(1.0 / (multiple + 0.1)).sqrt(), multiple * omega, random.between(0.0, TAU)]
            })
            .collect();
        let most: f64 = waves.iter().map(|[part, ..]| part * part).sum::<f64>().sqrt() * 1.5;
        for wave in &mut waves {
            wave[0] *= share * drawn.built.amplitude / most;
        }
        Self::Waves(waves)
    }

    /// Steps between random levels; each lasts at least six radians of the loop.
    pub(super) fn steps(drawn: &Drawn, share: f64, random: &mut Random) -> Self {
        let omega = TAU * drawn.conditions.loop_hz;
        let amplitude = share * drawn.built.amplitude;
        let level =
            |k: usize| amplitude * random.between(0.2, 1.0) * if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        Self::Steps((0..16).map(level).collect(), 12.0 / omega)
    }

    pub(super) fn strokes(drawn: &Drawn, share: f64, radians: f64) -> Self {
        Self::Strokes(share * drawn.built.amplitude, radians / (TAU * drawn.conditions.loop_hz))
    }

    /// The target at an instant.
    fn at(&self, t_s: f64) -> f64 {
        match self {
            Self::Waves(waves) => waves.iter().map(|[a, omega, phase]| a * (omega * t_s + phase).sin()).sum(),
            Self::Steps(levels, each_s) => levels[(t_s / each_s).max(0.0) as usize % levels.len()],
            Self::Strokes(amplitude, round_s) => {
                let turn = (t_s / round_s).rem_euclid(1.0);
                amplitude * if turn < 0.5 { 4.0 * turn - 1.0 } else { 3.0 - 4.0 * turn }
            }
        }
    }
}

/// A record of `seconds` as CSV. A target is sent with every row and held until the next row. Before the
/// first row the joint holds the first target.
pub(super) fn measure(drawn: &Drawn, asked: &Asked, seconds: f64, random: &mut Random) -> String {
    let (axis, firmware, conditions) = (&drawn.built.axis, &drawn.built.firmware, &drawn.conditions);
    let spacing_s = 1.0 / conditions.rate_hz;
    let fastest = axis.fastest().max(drawn.built.omega());
    let longest_s = (1.0 / (STEPS_PER_RADIAN * fastest)).min(firmware.period_s);
    let steps_a_sample = (firmware.period_s / longest_s).ceil();
    let step_s = firmware.period_s / steps_a_sample;
    let target = |t_s: f64| asked.at(((t_s / spacing_s + 1e-9).floor() * spacing_s).max(0.0));
    let settling_s = SETTLING / (TAU * conditions.loop_hz);
    let mut state = State::resting_at(target(0.0));
    let mut memory = Memory::default();
    let mut text = String::from("t_s,target_rad,position_rad\n");
    let mut steps = 0_u64;
    for k in 0..(seconds / spacing_s) as usize {
        let jitter = (conditions.jitter_share * random.normal()).clamp(-0.3, 0.3) * spacing_s;
        let read_s = k as f64 * spacing_s + jitter;
        while steps as f64 * step_s < settling_s + read_s {
            let t_s = steps as f64 * step_s - settling_s;
            if steps.is_multiple_of(steps_a_sample as u64) {
                firmware.sample(&mut memory, target(t_s - firmware.delay_s), state.motor[0]);
            }
            let torque = firmware.torque(&memory, state.motor[1]);
            axis.step(&mut state, torque, step_s);
            steps += 1;
        }
        let steps_read = state.motor[0] / firmware.resolution + ENCODER_NOISE * random.normal();
        let position = steps_read.round() * firmware.resolution;
        // The logger records the target that it has just sent, even if it reads the position later.
        let _ = writeln!(text, "{read_s:.6},{:.7},{position:.7}", target(k as f64 * spacing_s));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::draw::draw;
    use super::*;

    fn nothing(seed: u64) -> Drawn {
        let mut drawn = draw(3, &mut Random::new(seed), &|_| true);
        drawn.conditions.jitter_share = 0.0;
        drawn.built.axis.friction.level = 0.0;
        drawn.built.axis.gravity = None;
        drawn.built.firmware.resolution = 1e-7;
        drawn
    }

    fn numbers(text: &str) -> Vec<Vec<f64>> {
        text.lines().skip(1).map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
    }

    #[test]
    fn truth_a_servo_under_a_load_sags_by_load_over_gain() {
        let mut drawn = nothing(4);
        let torque = 0.1 * drawn.built.firmware.kp * drawn.built.amplitude;
        drawn.built.axis.constant_load = torque;
        let asked = Asked::Steps(vec![0.0], 1.0);
        let rows = numbers(&measure(&drawn, &asked, 1.0, &mut Random::new(1)));
        // After sixty radians of the loop the transient is below e^-20.
        let sag = torque / drawn.built.firmware.kp;
        assert!((rows[0][2] / sag - 1.0).abs() < 1e-4, "{} {sag}", rows[0][2]);
    }

    #[test]
    fn truth_a_slow_stroke_is_followed_with_the_lag_of_damping_over_gain_and_the_delay() {
        let mut drawn = nothing(7);
        drawn.built.amplitude = 1.0;
        let round_s = 40.0 / drawn.conditions.loop_hz;
        let rows = numbers(&measure(&drawn, &Asked::Strokes(1.0, round_s), round_s, &mut Random::new(1)));
        let (speed, built) = (4.0 / round_s, &drawn.built);
        let damping = built.axis.damping + built.firmware.kd;
        // On a ramp a held target is late by half a row. A held torque and the speed from a difference are
        // each late by half a sample.
        let held_s = 0.5 / drawn.conditions.rate_hz + built.firmware.period_s;
        let lag_s = damping / built.firmware.kp + built.firmware.delay_s + held_s;
        let row = &rows[rows.len() / 4];
        let wanted = speed * (row[0] - lag_s) - 1.0;
        assert!((row[2] - wanted).abs() < speed * (held_s + 1e-4), "{} {wanted}", row[2]);
    }
}
