//! Recording conditions of a case, each drawn from the range found in real records.

use serde::{Deserialize, Serialize};

use super::super::noise::Random;

/// Usual sampling rates of recorders, Hz.
const RATES_HZ: [f64; 7] = [50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0, 4000.0];
/// Largest number of rows of a case, all files together.
const MOST_ROWS: f64 = 60_000.0;
/// Periods of the motion in all files of a case.
pub(super) const PERIODS: f64 = 25.0;
/// Smallest number of rows in a period of the motion.
const ROWS_PER_PERIOD: f64 = 30.0;

/// The properties drawn for a case, besides the hidden effects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Conditions {
    /// Whether the axis is rotational (rad, N m) or linear (m, N).
    pub is_rotational: bool,
    /// Ratio of friction to the largest command.
    pub friction_share: f64,
    /// Ratio of the largest torque of gravity to the largest torque of motion; `None` without gravity.
    pub gravity_share: Option<f64>,
    /// Fundamental frequency of the motion, Hz.
    pub motion_hz: f64,
    /// Noise of the measured command over the command's root mean square.
    pub command_noise_share: f64,
    /// Rows per second.
    pub rate_hz: f64,
    /// Columns beside the time: command and motor encoder, and as a third an encoder on the load.
    pub channels: usize,
    /// Files that are shown: one long file, or five.
    pub files: usize,
    /// Share of rows that the recorder lost.
    pub lost_share: f64,
    /// Standard deviation of each sampling instant, over the spacing of rows.
    pub jitter_share: f64,
    /// Whether time stamps show the jitter.
    pub is_jitter_stamped: bool,
    /// Whether records begin in motion.
    pub begins_in_motion: bool,
    /// Step of the encoder, m or rad.
    pub resolution: f64,
    /// Ratio of the believed damping of the guide to the true one.
    pub damping_factor: f64,
    /// Ratio of the believed friction to the true one; `None` if no friction is believed.
    pub friction_factor: Option<f64>,
}

/// Share of wrong levels among the believed ones. Cases that hide friction believe no level, so a third of
/// all cases believe a wrong one.
const WRONG_SHARE: f64 = 0.55;

/// A random factor between `low` and `high`, or its inverse.
fn off(random: &mut Random, low: f64, high: f64) -> f64 {
    random.log_between(low, high).powf(random.sign())
}

/// Draws the conditions of a case; `friction_factor` applies unless friction is the hidden effect.
pub(super) fn draw(random: &mut Random) -> Conditions {
    let is = |random: &mut Random, share: f64| random.share() < share;
    let is_rotational = is(random, 0.5);
    let motion_hz = random.log_between(0.1, 5.0);
    let most_hz = MOST_ROWS * motion_hz / PERIODS;
    let rates: Vec<f64> =
        RATES_HZ.into_iter().filter(|rate| (ROWS_PER_PERIOD * motion_hz..=most_hz).contains(rate)).collect();
    Conditions {
        is_rotational,
        friction_share: random.between(0.05, 0.7),
        gravity_share: (is(random, 0.5) && is_rotational).then(|| random.log_between(0.5, 3.0)),
        motion_hz,
        command_noise_share: random.log_between(0.01, 0.1),
        rate_hz: rates.get(random.pick(rates.len())).copied().unwrap_or(RATES_HZ[0]),
        channels: if is(random, 0.5) { 2 } else { 3 },
        files: if is(random, 0.5) { 1 } else { 5 },
        lost_share: if is(random, 0.5) { random.log_between(2e-4, 5e-3) } else { 0.0 },
        jitter_share: if is(random, 0.5) { random.log_between(5e-3, 0.1) } else { 0.0 },
        is_jitter_stamped: is(random, 0.5),
        begins_in_motion: is(random, 0.5),
        resolution: random.log_between(1e-4, 2e-3),
        damping_factor: off(random, 1.0, 4.0),
        friction_factor: Some(if is(random, WRONG_SHARE) { off(random, 1.15, 2.0) } else { 1.0 }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_conditions_stay_within_those_of_real_records() {
        let drawn: Vec<Conditions> = (0..2000).map(|seed| draw(&mut Random::new(seed))).collect();
        for case in &drawn {
            assert!((0.05..=0.7).contains(&case.friction_share));
            assert!((0.1..=5.0).contains(&case.motion_hz));
            assert!((0.01..=0.1).contains(&case.command_noise_share));
            assert!((50.0..=4000.0).contains(&case.rate_hz));
            assert!((1e-4..=2e-3).contains(&case.resolution));
            assert!((0.25..=4.0).contains(&case.damping_factor));
            assert!(case.rate_hz * PERIODS / case.motion_hz <= MOST_ROWS);
            assert!(case.gravity_share.is_none() || case.is_rotational);
        }
        // Four standard deviations of a share of one half in 2000 draws are 0.045.
        let share = |of: &dyn Fn(&Conditions) -> bool, among: &dyn Fn(&Conditions) -> bool| {
            let among: Vec<&Conditions> = drawn.iter().filter(|case| among(case)).collect();
            among.iter().filter(|case| of(case)).count() as f64 / among.len() as f64
        };
        let all = |_: &Conditions| true;
        assert!((share(&|case| case.channels == 2, &all) - 0.5).abs() < 0.045);
        assert!((share(&|case| case.files == 1, &all) - 0.5).abs() < 0.045);
        // About 1000 draws are rotational: four standard deviations are 0.063.
        assert!(
            (share(&|case| case.gravity_share.is_some(), &|case| case.is_rotational) - 0.5).abs() < 0.063
        );
    }
}
