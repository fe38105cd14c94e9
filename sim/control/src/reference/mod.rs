//! References and excitations: what a loop shall follow, as a pure function of time.
//!
//! [`Reference::value`] may be asked at any instants in any order, and always answers the same; nothing is
//! drawn in passing. An excitation of the drive itself is an open-loop controller with one of these as its
//! reference.

mod chirp;
mod multisine;
mod points;
mod prbs;
mod white_noise;

use chirp::Chirp;
use multisine::Multisine;
use points::Points;
use prbs::Prbs;
use white_noise::WhiteNoise;

use crate::error::finite;
use crate::{ControlError, Stream};

/// Instants closer than this to a jump of a reference belong to the time after it, s: a sample computed as
/// `k T` may fall a rounding short of the instant that the file names.
const TIME_TOLERANCE_S: f64 = 1e-12;

/// What a loop shall follow, in the unit of the loop.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ReferenceSpec {
    /// One value for ever.
    Constant(f64),
    /// Each value from its time (s) on; zero before the first.
    Steps(Vec<(f64, f64)>),
    /// Straight lines between the points `(time in s, value)`; the first and last values hold outside. A ramp
    /// is two points.
    PiecewiseLinear(Vec<(f64, f64)>),
    /// A sine whose frequency is swept over `duration_s` from zero on; `offset` alone outside.
    Chirp {
        /// How the frequency moves.
        sweep: Sweep,
        /// Amplitude.
        amplitude: f64,
        /// Frequency at the start, Hz.
        start_hz: f64,
        /// Frequency at the end, Hz.
        end_hz: f64,
        /// Length of the sweep, s.
        duration_s: f64,
        /// Mean value.
        offset: f64,
    },
    /// A periodic sum of cosines of equal amplitude and random phase (Pintelon and Schoukens, "System
    /// Identification: A Frequency Domain Approach", 2nd ed., sections 2.6 and 5.3). Of several draws of the
    /// phases, the one with the smallest crest factor is kept.
    Multisine {
        /// Which multiples of `1 / period_s` are excited.
        lines: Lines,
        /// Lower edge of the band, Hz, included.
        low_hz: f64,
        /// Upper edge of the band, Hz, included.
        high_hz: f64,
        /// Period, s.
        period_s: f64,
        /// Root mean square about the mean.
        rms: f64,
        /// Mean value.
        offset: f64,
    },
    /// Gaussian noise of flat spectrum between two frequencies.
    WhiteNoise {
        /// Lower edge of the band, Hz.
        low_hz: f64,
        /// Upper edge of the band, Hz.
        high_hz: f64,
        /// Root mean square about the mean.
        rms: f64,
        /// Mean value.
        offset: f64,
    },
    /// A maximum-length pseudo-random binary sequence of `2^order - 1` chips, started at a random chip.
    Prbs {
        /// Length of the shift register.
        order: u32,
        /// Time that each chip is held, s.
        clock_period_s: f64,
        /// Half the distance between the two values.
        amplitude: f64,
        /// Middle of the two values.
        offset: f64,
    },
    /// Samples from a file; the first and last values hold outside.
    Table {
        /// Times, s, increasing.
        times_s: Vec<f64>,
        /// Values at these times.
        values: Vec<f64>,
        /// What lies between samples.
        between: Between,
        /// Added to every value.
        offset: f64,
    },
}

/// How a chirp's frequency moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sweep {
    /// By the same number of hertz per second.
    #[default]
    Linear,
    /// By the same number of octaves per second.
    Logarithmic,
}

/// Which lines of a multisine are excited.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lines {
    /// Every line.
    #[default]
    All,
    /// Odd lines: what appears at even ones is even distortion.
    Odd,
    /// Odd lines with one of every four left out at random: what appears at these is odd distortion.
    OddSparse,
}

/// What a table says between its samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Between {
    /// Each value holds until the next.
    #[default]
    Hold,
    /// Straight lines.
    Linear,
}

/// A [`ReferenceSpec`] ready to be asked for values. Cloning is cheap: long tables are shared.
#[derive(Clone, Debug)]
pub struct Reference {
    shape: Shape,
    offset: f64,
}

#[derive(Clone, Debug)]
enum Shape {
    Constant,
    Points(Points),
    Chirp(Chirp),
    Multisine(Multisine),
    WhiteNoise(WhiteNoise),
    Prbs(Prbs),
}

impl Reference {
    /// Compiles `spec` for the element called `name` in a run with `seed`; both matter to random shapes only.
    ///
    /// # Errors
    /// A number out of its range, points out of order, or a multisine without lines.
    pub fn new(spec: &ReferenceSpec, seed: u64, name: &str) -> Result<Self, ControlError> {
        let stream = || Stream::new(seed, &format!("{name}/reference"));
        let (shape, offset) = match *spec {
            ReferenceSpec::Constant(value) => (Shape::Constant, finite("reference", value)?),
            ReferenceSpec::Steps(ref points) => (Shape::Points(Points::steps(points)?), 0.0),
            ReferenceSpec::PiecewiseLinear(ref points) => (Shape::Points(Points::lines(points)?), 0.0),
            ReferenceSpec::Chirp { sweep, amplitude, start_hz, end_hz, duration_s, offset } => {
                (Shape::Chirp(Chirp::new(sweep, amplitude, start_hz, end_hz, duration_s)?), offset)
            }
            ReferenceSpec::Multisine { lines, low_hz, high_hz, period_s, rms, offset } => (
                Shape::Multisine(Multisine::new(lines, [low_hz, high_hz], period_s, rms, &stream())?),
                offset,
            ),
            ReferenceSpec::WhiteNoise { low_hz, high_hz, rms, offset } => {
                (Shape::WhiteNoise(WhiteNoise::new([low_hz, high_hz], rms, stream())?), offset)
            }
            ReferenceSpec::Prbs { order, clock_period_s, amplitude, offset } => {
                (Shape::Prbs(Prbs::new(order, clock_period_s, amplitude, &stream())?), offset)
            }
            ReferenceSpec::Table { ref times_s, ref values, between, offset } => {
                (Shape::Points(Points::table(times_s, values, between)?), offset)
            }
        };
        Ok(Self { shape, offset: finite("reference.offset", offset)? })
    }

    /// The reference at `t_s`.
    #[inline]
    pub fn value(&self, t_s: f64) -> f64 {
        if matches!(self.shape, Shape::Constant) { self.offset } else { self.offset + self.about_mean(t_s) }
    }

    fn about_mean(&self, t_s: f64) -> f64 {
        match &self.shape {
            Shape::Constant => 0.0,
            Shape::Points(points) => points.value(t_s),
            Shape::Chirp(chirp) => chirp.value(t_s),
            Shape::Multisine(multisine) => multisine.value(t_s),
            Shape::WhiteNoise(noise) => noise.value(t_s),
            Shape::Prbs(prbs) => prbs.value(t_s),
        }
    }
}
