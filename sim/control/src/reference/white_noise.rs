//! Band-limited white noise.

use std::f64::consts::{PI, TAU};

use crate::error::{finite, not_negative, positive};
use crate::{ControlError, Stream};

/// Draws on each side of an instant that contribute to its value. The transition at each edge of the band is
/// 1 / 16 of the bandwidth to either side.
const HALF_WIDTH: usize = 16;

const WIDTH: usize = 2 * HALF_WIDTH;

/// Index of the draw at t = 0, so that earlier instants have draws too.
const ORIGIN: u64 = 1 << 40;

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
}

impl WhiteNoise {
    pub(super) fn new(band_hz: [f64; 2], rms: f64, stream: Stream) -> Result<Self, ControlError> {
        let [low, high] =
            [not_negative("reference.band", band_hz[0])?, positive("reference.band", band_hz[1])?];
        let rate_hz = positive("reference.band width", high - low)?;
        Ok(Self { centre_hz: 0.5 * (low + high), rate_hz, rms: finite("reference.rms", rms)?, stream })
    }

    pub(super) fn value(&self, t_s: f64) -> f64 {
        let position = t_s * self.rate_hz;
        let start = position.floor() - (HALF_WIDTH - 1) as f64;
        let draws: [[f64; 2]; WIDTH] =
            self.stream.normal_pairs_from(ORIGIN.wrapping_add_signed(start as i64));
        let (mut a, mut b, mut power) = (0.0, 0.0, 0.0);
        for (k, [draw_a, draw_b]) in draws.iter().enumerate() {
            let weight = windowed_sinc(position - (start + k as f64));
            a += weight * draw_a;
            b += weight * draw_b;
            power += weight * weight;
        }
        let (sin, cos) = (TAU * (self.centre_hz * t_s).fract()).sin_cos();
        self.rms * (a * cos - b * sin) / power.sqrt()
    }
}

fn windowed_sinc(x: f64) -> f64 {
    let sinc = if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    let hann = (0.5 * PI * x / HALF_WIDTH as f64).cos();
    sinc * hann * hann
}
