//! The desired value of a loop, as data.

/// The desired value of a loop, in the unit of the loop.
#[derive(Clone, Debug, PartialEq)]
pub enum ReferenceSpec {
    /// One value for ever.
    Constant(f64),
    /// Each value holds from its time (s) until the next; zero before the first.
    Steps(Vec<(f64, f64)>),
    /// Straight lines between the points `(time in s, value)`; the first and last values hold outside. A ramp
    /// is two points.
    PiecewiseLinear(Vec<(f64, f64)>),
    /// A sine whose frequency is swept over `duration_s` from zero onwards; outside only `offset`.
    Chirp {
        /// Course of the frequency.
        sweep: ChirpSweep,
        amplitude: f64,
        start_hz: f64,
        end_hz: f64,
        /// Length of the sweep, s.
        duration_s: f64,
        offset: f64,
    },
    /// A periodic sum of cosines of equal amplitude and random phase. Source: Pintelon and Schoukens, "System
    /// Identification: A Frequency Domain Approach", 2nd ed., sections 2.6 and 5.3. Of several draws of the
    /// phases, the one with the smallest crest factor is kept.
    Multisine {
        /// The excited multiples of `1 / period_s`.
        lines: Lines,
        /// Lower edge of the band, Hz, included.
        low_hz: f64,
        /// Upper edge of the band, Hz, included.
        high_hz: f64,
        period_s: f64,
        /// Root mean square about the mean.
        rms: f64,
        offset: f64,
    },
    /// Gaussian noise with a flat spectrum between two frequencies.
    WhiteNoise {
        /// Lower edge of the band, Hz.
        low_hz: f64,
        /// Upper edge of the band, Hz.
        high_hz: f64,
        /// Root mean square about the mean.
        rms: f64,
        offset: f64,
    },
    /// A maximum-length pseudo-random binary sequence of `2^order - 1` chips, started at a random chip.
    Prbs {
        /// Length of the shift register.
        order: u32,
        /// Duration of each chip, s.
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
        /// Interpolation between samples.
        between: Between,
        /// Added to every value.
        offset: f64,
    },
}

/// Sweep of a chirp's frequency.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ChirpSweep {
    /// A constant number of hertz per second.
    #[default]
    Linear,
    /// A constant number of octaves per second.
    Logarithmic,
}

/// The excited lines of a multisine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lines {
    #[default]
    All,
    /// Odd lines: components at even lines are even distortion.
    Odd,
    /// Odd lines with one of every four omitted at random: components at these are odd distortion.
    OddSparse,
}

/// Interpolation of a table between its samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Between {
    /// Each value holds until the next.
    #[default]
    Hold,
    Linear,
}

impl ReferenceSpec {
    /// Samples that each hold until the next.
    pub fn samples(times_s: Vec<f64>, values: Vec<f64>) -> Self {
        Self::Table { times_s, values, between: Between::default(), offset: 0.0 }
    }
}
