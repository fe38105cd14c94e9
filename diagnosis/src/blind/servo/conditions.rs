//! Conditions under which a servo joint is recorded.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::super::noise::Random;

/// Step of an encoder of 4096 steps a turn, rad.
const HOBBY_STEP: f64 = TAU / 4096.0;

/// The properties drawn for a case, besides the hidden effects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ServoConditions {
    /// Whether it is a hobby servo: a motor on a bounded voltage, coarse steps, slow rows.
    pub is_hobby: bool,
    /// Frequency of the loop as believed, Hz.
    pub loop_hz: f64,
    /// Rows per second; a target comes with each.
    pub rate_hz: f64,
    /// Step of the encoder, rad.
    pub resolution: f64,
    /// Ratio of the largest torque of gravity to the torque at the largest error; `None` without gravity.
    pub gravity_share: Option<f64>,
    /// Standard deviation of each sampling instant, over the spacing of rows. Time stamps show it.
    pub jitter_share: f64,
}

/// Draws the conditions of a case.
pub(super) fn draw(random: &mut Random) -> ServoConditions {
    let is_hobby = random.share() < 0.6;
    let pick = |random: &mut Random, rates: &[f64]| rates[random.pick(rates.len())];
    let (loop_hz, rate_hz, resolution, gravity) = if is_hobby {
        (random.log_between(2.5, 6.0), pick(random, &[100.0, 200.0]), HOBBY_STEP, 0.6)
    } else {
        let step = random.log_between(2e-6, 3e-5);
        (random.log_between(6.0, 20.0), pick(random, &[500.0, 1000.0]), step, 0.4)
    };
    ServoConditions {
        is_hobby,
        loop_hz,
        rate_hz,
        resolution,
        gravity_share: (random.share() < gravity).then(|| random.log_between(0.05, 0.2)),
        jitter_share: if random.share() < 0.5 { random.log_between(2e-3, 3e-2) } else { 0.0 },
    }
}
