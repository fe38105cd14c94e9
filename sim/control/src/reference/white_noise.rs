//! Band-limited white noise.

use std::f64::consts::{PI, TAU};
use std::sync::{Arc, OnceLock};

use super::keys::{BAND, RMS, key};
use crate::error::{ControlError, finite, not_negative, positive};
use crate::noise::Stream;

/// Draws on each side of an instant that contribute to its value. The transition at each edge of the band is
/// 1 / 16 of the bandwidth to either side.
const HALF_WIDTH: usize = 16;

const WIDTH: usize = 2 * HALF_WIDTH;

/// Index of the draw at t = 0, so that earlier instants have draws too.
const ORIGIN: u64 = 1 << 40;

/// Index of the first draw for t = 0.
const FIRST: u64 = ORIGIN - (HALF_WIDTH as u64 - 1);

/// Number of first draws in a block, and the number of blocks that are kept. A run samples each draw many
/// times.
const BLOCK: usize = 64;
const BLOCKS: usize = 256;

/// The draws of one block, with those that follow its last first draw.
type Block = Box<[[f64; 2]; BLOCK + WIDTH]>;

/// Noise of a band `f_c - B` to `f_c + B` as `a(t) cos(2 pi f_c t) - b(t) sin(2 pi f_c t)` (Rice,
/// "Mathematical Analysis of Random Noise", Bell Syst. Tech. J. 1944/45, section 3.7). a and b are
/// independent noises of the band 0 to B. Each is a sum of white draws, one per `1 / (2 B)`. They multiply
/// sinc pulses under a Hann window. The weights are scaled to a unit sum of squares, so the variance is the
/// same at every instant.
#[derive(Clone, Debug)]
pub(super) struct WhiteNoise {
    centre_hz: f64,
    /// Draws per second, the width of the band in Hz.
    rate_hz: f64,
    rms: f64,
    stream: Stream,
    /// The draws from `t = 0` onwards, each block drawn when it is first needed. They depend on their index
    /// only.
    drawn: Arc<[OnceLock<Block>]>,
}

impl WhiteNoise {
    pub(super) fn new(band_hz: [f64; 2], rms: f64, stream: Stream) -> Result<Self, ControlError> {
        let [low, high] = [not_negative(key(&BAND), band_hz[0])?, positive(key(&BAND), band_hz[1])?];
        if low >= high {
            let why = "the upper edge";
            return Err(ControlError::TooLarge { key: key(&BAND), value: low, bound: high, why });
        }
        let rate_hz = high - low;
        Ok(Self {
            centre_hz: 0.5 * (low + high),
            rate_hz,
            rms: finite(key(&RMS), rms)?,
            stream,
            drawn: std::iter::repeat_with(OnceLock::new).take(BLOCKS).collect(),
        })
    }

    pub(super) fn value(&self, t_s: f64) -> f64 {
        let position = t_s * self.rate_hz;
        let start = position.floor() - (HALF_WIDTH - 1) as f64;
        let (index, at) = (ORIGIN.wrapping_add_signed(start as i64), position - start);
        let from = index.checked_sub(FIRST).and_then(|from| usize::try_from(from).ok());
        let kept = from.and_then(|from| Some((self.drawn.get(from / BLOCK)?, from % BLOCK)));
        let [a, b] = if let Some((block, within)) = kept {
            let draw = || Box::new(self.stream.normal_pairs_from(index - within as u64));
            weighted(at, &block.get_or_init(draw)[within..within + WIDTH])
        } else {
            weighted(at, &self.stream.normal_pairs_from::<WIDTH>(index))
        };
        let (sin, cos) = (TAU * (self.centre_hz * t_s).fract()).sin_cos();
        self.rms * (a * cos - b * sin)
    }
}

/// The sums of both kinds of draws under the windowed pulses of unit power, `at` draws after the first.
///
/// The sines of all pulses differ in sign only. The window is `(1 + cos) / 2` of an angle that grows by the
/// same step, so a rotation gives the next; 32 of them round to 1e-15.
fn weighted(at: f64, draws: &[[f64; 2]]) -> [f64; 2] {
    // The whole part of `at` is HALF_WIDTH - 1, an odd number; the sine from the nearer end is exact.
    let mut sine = -(PI * (at - at.round()).abs()).sin();
    let (step_sin, step_cos) = (PI / HALF_WIDTH as f64).sin_cos();
    let (mut sin, mut cos) = (PI * at / HALF_WIDTH as f64).sin_cos();
    let (mut sums, mut power) = ([0.0_f64; 2], 0.0_f64);
    for (k, draw) in draws.iter().enumerate() {
        let x = at - k as f64;
        let sinc = if x == 0.0 { 1.0 } else { sine / (PI * x) };
        let weight = sinc * 0.5 * (1.0 + cos);
        sums[0] += weight * draw[0];
        sums[1] += weight * draw[1];
        power += weight * weight;
        sine = -sine;
        // The next pulse is one draw later.
        (sin, cos) = (sin * step_cos - cos * step_sin, cos * step_cos + sin * step_sin);
    }
    sums.map(|sum| sum / power.sqrt())
}
