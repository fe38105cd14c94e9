//! Arguments of `feeler frf`.

use std::path::PathBuf;

use clap::builder::TypedValueParser;
use clap::{Args, ValueEnum, ValueHint};
use feeler_lti::spectral::Estimator;
use feeler_plant::description::Engagement;
use feeler_studies::frf::{self, FrfRequest, NoiseEstimator};

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler frf scenario.toml --clamped                white noise, as in the paper\n  \
    feeler frf scenario.toml --excitation multisine   noise and distortion apart\n  \
    feeler frf scenario.toml --estimator hv --segment 4 --out out/frf\n  \
    feeler frf measured/ --experiment clamped-1.csv   a record of a dataset\n\n\
    For a dataset, --from, --to, --estimator, --segment, --period and --confidence apply. Options that make \
    an excitation apply to a machine only. The linear response includes the hold and the sampling of the \
    experiment.")]
pub(crate) struct Frf {
    /// Scenario file (TOML), or a dataset's folder or dataset.toml
    #[arg(value_name = "FILE|DATASET", value_hint = ValueHint::AnyPath)]
    pub(crate) source: PathBuf,
    /// Set a key of the scenario, as in bodies.tip.mass=6; may be repeated; not for a dataset
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) settings: Vec<String>,
    /// Input, an actuator's command (or a dataset's column) [default: that of the first controller's
    /// actuator]
    #[arg(long, value_name = "SIGNAL")]
    pub(crate) input: Option<String>,
    /// Output (or a dataset's column) [default: the reading of the first controller's sensor, filter, delay
    /// and noise included]
    #[arg(long, value_name = "SIGNAL")]
    pub(crate) output: Option<String>,
    /// Excitation, or that of a dataset [default: the multisine that the scenario itself plays, else
    /// white-noise; for a dataset, recognised from its command]
    #[arg(long, value_enum)]
    pub(crate) excitation: Option<ExcitationKind>,
    /// Estimator, for noise and for a dataset's chirp [default: local-polynomial; for a dataset, the one
    /// that suits its command]
    #[arg(long, value_enum)]
    pub(crate) estimator: Option<EstimatorKind>,
    /// Lowest frequency, Hz
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub(crate) from: Option<f64>,
    /// Highest frequency, Hz [default: 0.8 of half the sampling rate; for a dataset, where its command has
    /// power]
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub(crate) to: Option<f64>,
    /// Root mean square of the excitation, SI. A force is at least five times the dry friction [default: that
    /// of the scenario's own multisine, else a tenth of the drive's limit, else 1 N or 0.01 m/s]
    #[arg(long, value_name = "SIZE", allow_negative_numbers = true)]
    pub(crate) rms: Option<f64>,
    /// Mean of the command, SI [default: 0]
    #[arg(long, value_name = "SIZE", allow_negative_numbers = true)]
    pub(crate) offset: Option<f64>,
    /// Length of noise or chirp, s [default: 60]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) duration: Option<f64>,
    /// Length of the segments of noise that --estimator h1, h2 and hv average, s [default: a fifteenth of the
    /// noise, an eighth of a record]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) segment: Option<f64>,
    /// Period of the multisine, s [default: 1; of a dataset, found in its command]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) period: Option<f64>,
    /// Periods of the multisine that are evaluated [default: 4]
    #[arg(long, value_name = "N", value_parser = at_least_two())]
    pub(crate) periods: Option<usize>,
    /// Draws of the multisine's phases [default: 4]
    #[arg(long, value_name = "N", value_parser = at_least_two())]
    pub(crate) realisations: Option<usize>,
    /// Frequencies of the stepped sine [default: 40]
    #[arg(long, value_name = "N", value_parser = at_least_two())]
    pub(crate) points: Option<usize>,
    /// Time for which each command is held, s [default: the controller's period, else 1 ms]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub(crate) hold: Option<f64>,
    /// Seed of excitation and noise [default: that of the file]
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// Attach every contact
    #[arg(long, conflicts_with = "free")]
    pub(crate) clamped: bool,
    /// Remove every contact
    #[arg(long)]
    pub(crate) free: bool,
    /// Confidence of the bands
    #[arg(long, value_name = "SHARE", default_value_t = 0.95)]
    pub(crate) confidence: f64,
    /// CSV file of a dataset; may be repeated
    #[arg(long = "experiment", value_name = "NAME")]
    pub(crate) experiments: Vec<String>,
    /// Folder for report.html, frf.csv and frf.json, made if absent; nothing is written without it
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// Print as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Kinds of excitation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ExcitationKind {
    /// Band-limited Gaussian noise, as in the paper
    WhiteNoise,
    /// Multisines of random phase, which separate noise and nonlinear distortion
    Multisine,
    /// A linear chirp and silence after it
    Chirp,
    /// One sine after the other
    SteppedSine,
}

/// Estimators of a response to noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum EstimatorKind {
    /// Polynomials through neighbouring lines of the whole record: removes leakage
    LocalPolynomial,
    /// Averaged: unbiased by noise on the output
    H1,
    /// Averaged: unbiased by noise on the input
    H2,
    /// Averaged: equal noise on both
    Hv,
}

impl Frf {
    /// The requested response.
    pub(crate) fn request(&self) -> FrfRequest {
        let clamped = self.clamped.then_some(Engagement::Clamped);
        FrfRequest {
            input: self.input.clone(),
            output: self.output.clone(),
            excitation: self.excitation.map(ExcitationKind::asked),
            estimator: self.estimator.map(EstimatorKind::asked),
            from_hz: self.from,
            to_hz: self.to,
            rms: self.rms,
            offset: self.offset,
            duration_s: self.duration,
            segment_s: self.segment,
            period_s: self.period,
            periods: self.periods,
            realisations: self.realisations,
            points: self.points,
            hold_s: self.hold,
            seed: self.seed,
            engagement: clamped.or(self.free.then_some(Engagement::Free)),
            confidence: self.confidence,
            experiments: self.experiments.clone(),
        }
    }
}

impl ExcitationKind {
    fn asked(self) -> frf::ExcitationKind {
        match self {
            Self::WhiteNoise => frf::ExcitationKind::WhiteNoise,
            Self::Multisine => frf::ExcitationKind::Multisine,
            Self::Chirp => frf::ExcitationKind::Chirp,
            Self::SteppedSine => frf::ExcitationKind::SteppedSine,
        }
    }
}

impl From<frf::ExcitationKind> for ExcitationKind {
    fn from(kind: frf::ExcitationKind) -> Self {
        match kind {
            frf::ExcitationKind::WhiteNoise => Self::WhiteNoise,
            frf::ExcitationKind::Multisine => Self::Multisine,
            frf::ExcitationKind::Chirp => Self::Chirp,
            frf::ExcitationKind::SteppedSine => Self::SteppedSine,
        }
    }
}

impl EstimatorKind {
    fn asked(self) -> NoiseEstimator {
        match self {
            Self::LocalPolynomial => NoiseEstimator::LocalPolynomial,
            Self::H1 => NoiseEstimator::Averaged(Estimator::H1),
            Self::H2 => NoiseEstimator::Averaged(Estimator::H2),
            Self::Hv => NoiseEstimator::Averaged(Estimator::Hv),
        }
    }
}

fn at_least_two() -> impl TypedValueParser<Value = usize> {
    clap::value_parser!(u32).range(2..=100_000).map(|count| count as usize)
}
