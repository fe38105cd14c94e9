//! `feeler frf`.

mod distortion;
mod evaluate;
mod measured;
mod simulated;
mod writing;

pub(crate) use writing::{Row, row};

use feeler_analysis::AnalysisError;
use feeler_analysis::frf::Experiment;
use feeler_lti::C64;
use feeler_lti::spectral::{Estimator, Evidence, ResponseEstimate};
use feeler_plant::description::{Machine, Quantity, SignalName};

use crate::arguments::{EstimatorKind, Frf};
use crate::numbers::plain;
use crate::terminal::failure::BadInput;
use crate::terminal::table;
use crate::{pages, terminal};

/// Rows of the printed table; files have all.
const MOST_ROWS: usize = 24;
/// Frequencies at which the coherence is at least this count when responses are compared: the first of these
/// with enough of them.
const COHERENT: [f64; 3] = [0.99, 0.9, 0.5];
/// Where an estimate has no coherence, a frequency counts whose phase is known to so many degrees: half of
/// the response's size.
const KNOWN_DEG: f64 = 30.0;
/// Enough frequencies, as a share of all.
const ENOUGH: f64 = 0.05;

/// A response estimated from records, with the linear one at the same frequencies.
pub(crate) struct Response {
    pub(crate) title: String,
    pub(crate) about: String,
    pub(crate) input: String,
    pub(crate) output: String,
    /// What a sensor reads whose reading is the output.
    pub(crate) reads: Option<String>,
    /// Excitation and estimator in words.
    pub(crate) how: String,
    /// What was assumed.
    pub(crate) notes: Vec<String>,
    pub(crate) hold_s: f64,
    pub(crate) estimate: ResponseEstimate,
    pub(crate) linear: Vec<C64>,
    /// Whether each frequency stands for itself, with nothing measured on the way to the next.
    pub(crate) isolated: bool,
    /// The linear response at frequencies (Hz) between those of the estimate, where nothing was measured.
    pub(crate) between: Vec<(f64, C64)>,
    pub(crate) told_apart: Option<ToldApart>,
    pub(crate) confidence: f64,
}

/// What multisines tell apart.
pub(crate) struct ToldApart {
    /// Variance of one realisation by noise.
    pub(crate) noise: Vec<f64>,
    /// And by nonlinear distortion, below zero by chance where there is none.
    pub(crate) distortion: Vec<f64>,
    /// Whether there is distortion at all.
    pub(crate) evidence: Evidence,
}

/// How the estimate compares with the linear response.
pub(crate) struct Agreement {
    /// Coherence from which a frequency counts; absent where the estimate has none.
    pub(crate) coherence: Option<f64>,
    /// Frequencies that count.
    pub(crate) compared: usize,
    /// Largest differences among them.
    pub(crate) decibels: f64,
    pub(crate) degrees: f64,
    /// Share of all frequencies at which the linear response lies within the confidence band.
    pub(crate) within: f64,
}

impl Response {
    /// Input and output in words.
    pub(crate) fn path(&self) -> String {
        let reads = self
            .reads
            .as_ref()
            .map_or_else(String::new, |signal| format!(", the sensor's reading of {signal}"));
        format!("from {} to {}{reads}", self.input, self.output)
    }

    pub(crate) fn agreement(&self) -> Agreement {
        let all = || (0..self.linear.len()).filter(|&i| self.linear[i].norm() > 0.0);
        let known = self.estimate.coherence.as_ref();
        let bands = self.estimate.confidence(self.confidence);
        let is_known = |i: usize| bands[i].phase_half_width_rad.to_degrees() <= KNOWN_DEG;
        let from = |least: f64| {
            all().filter(|&i| known.map_or_else(|| is_known(i), |c| c[i] >= least)).collect::<Vec<usize>>()
        };
        let enough = |least: &f64| from(*least).len() as f64 >= ENOUGH * self.linear.len() as f64;
        let least = COHERENT.into_iter().find(enough).unwrap_or(COHERENT[2]);
        let counts = from(least);
        let ratio = |i: usize| self.estimate.response[i] / self.linear[i];
        let inside = (0..self.linear.len()).filter(|&i| {
            let radius = bands[i].magnitude_high - self.estimate.response[i].norm();
            (self.estimate.response[i] - self.linear[i]).norm() <= radius
        });
        Agreement {
            coherence: known.map(|_| least),
            compared: counts.len(),
            decibels: counts.iter().map(|&i| (20.0 * ratio(i).norm().log10()).abs()).fold(0.0, f64::max),
            degrees: counts.iter().map(|&i| ratio(i).arg().to_degrees().abs()).fold(0.0, f64::max),
            within: inside.count() as f64 / self.linear.len().max(1) as f64,
        }
    }

    /// The comparison, and what the multisines tell apart, in words.
    pub(crate) fn sentences(&self) -> Vec<String> {
        let agreement = self.agreement();
        let coherent = (agreement.coherence).map_or_else(
            || format!(" known to {KNOWN_DEG}°"),
            |least| format!(" with a coherence of {} or more", plain(least)),
        );
        let mut said = vec![if agreement.compared == 0 && agreement.coherence.is_none() {
            format!(
                "No frequency is known to {KNOWN_DEG}° of phase: noise outweighs the excitation, and nothing can be compared."
            )
        } else if agreement.compared == 0 {
            format!(
                "No frequency has a coherence of {}: output and input have little to do with each other.",
                COHERENT[2]
            )
        } else {
            format!(
                "At the {} {}{coherent}, measured and linear response differ by {} dB and {}° at most; the linear response lies within \
                 the {} % confidence band at {} % of all frequencies.",
                agreement.compared,
                if agreement.compared == 1 { "frequency" } else { "frequencies" },
                plain(agreement.decibels),
                plain(agreement.degrees),
                plain(100.0 * self.confidence),
                plain((100.0 * agreement.within).round()),
            )
        }];
        said.extend(self.incoherent());
        said.extend(self.told_apart.as_ref().map(|levels| self.levels(levels)));
        said
    }
}

impl Response {
    /// Where there is distortion; none where all of it may be noise.
    fn distortion_bands(&self) -> Vec<distortion::DistortionBand> {
        let beyond = self.told_apart.as_ref().filter(|levels| levels.evidence.is_beyond_noise);
        beyond.map_or_else(Vec::new, |levels| {
            distortion::bands(levels, &self.estimate.frequencies_hz, &self.estimate.response)
        })
    }

    /// How large noise and distortion are, and whether there is distortion.
    fn levels(&self, ToldApart { noise, evidence, .. }: &ToldApart) -> String {
        let relative = |variances: &[f64]| -> Vec<f64> {
            let mut shares: Vec<f64> =
                variances.iter().zip(&self.estimate.response).map(|(v, g)| v / g.norm_sqr()).collect();
            shares.retain(|share| share.is_finite());
            shares
        };
        let median = |mut shares: Vec<f64>| {
            shares.sort_by(f64::total_cmp);
            shares.get(shares.len() / 2).copied().unwrap_or(0.0)
        };
        let decibels = |share: f64| {
            if share > 0.0 {
                format!("{} dB", plain((10.0 * share.log10()).round()))
            } else {
                "nothing".to_owned()
            }
        };
        let noise = median(relative(noise));
        let shows_from = noise * evidence.least_share;
        let bands = self.distortion_bands();
        let distortion = if !evidence.is_beyond_noise {
            format!("none beyond the noise (it would show from {} on)", decibels(shows_from))
        } else if bands.is_empty() {
            "at single frequencies only".to_owned()
        } else {
            distortion::words(bands, decibels)
        };
        format!(
            "Relative to the response: noise {} (median over frequency), nonlinear distortion {distortion}, each of one realisation.",
            decibels(noise)
        )
    }
}

/// Coherence below which a response is mostly something else.
const INCOHERENT: f64 = 0.8;
/// Spans of frequency that are named.
const MOST_SPANS: usize = 4;

impl Response {
    /// Where the output has little to do with the input.
    fn incoherent(&self) -> Option<String> {
        let (coherence, f) = (self.estimate.coherence.as_ref()?, &self.estimate.frequencies_hz);
        let mut spans: Vec<[f64; 2]> = Vec::new();
        let mut before = false;
        for (value, &f) in coherence.iter().zip(f) {
            let low = *value < INCOHERENT;
            match spans.last_mut() {
                Some(span) if low && before => span[1] = f,
                _ if low => spans.push([f, f]),
                _ => {}
            }
            before = low;
        }
        let count = coherence.iter().filter(|value| **value < INCOHERENT).count();
        spans.sort_by(|a, b| (b[1] - b[0]).total_cmp(&(a[1] - a[0])));
        let more = if spans.len() > MOST_SPANS { " and elsewhere" } else { "" };
        spans.truncate(MOST_SPANS);
        spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let named = spans.iter().map(|[a, b]| {
            if a < b { format!("from {} to {}", plain(*a), plain(*b)) } else { format!("at {}", plain(*a)) }
        });
        let named = named.collect::<Vec<_>>().join(", ");
        (count > 0).then(|| {
            format!(
                "Coherence is below {INCOHERENT} at {count} of {} frequencies ({named} Hz{more}): there noise, leakage, nonlinearity or something else that \
                 acts on the machine makes up a good part of the output.",
                f.len()
            )
        })
    }
}

/// Frequencies (Hz) between those of an estimate at which nothing was measured: all the way from each to the
/// next where they are isolated, and in the gaps where they are not.
fn between(frequencies_hz: &[f64], isolated: bool) -> Vec<f64> {
    let spacing = frequencies_hz.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let gaps = frequencies_hz.windows(2).filter(|pair| isolated || pair[1] - pair[0] > GAP * spacing);
    let filled = gaps.flat_map(|pair| {
        let ratio = pair[1] / pair[0];
        let count = ((ratio.ln() / STEP).ceil() as usize).clamp(2, 200);
        (1..count).map(move |i| pair[0] * ratio.powf(i as f64 / count as f64))
    });
    filled.collect()
}

/// Times the least spacing from which on there is a gap between two frequencies.
const GAP: f64 = 1.5;
/// Step between frequencies at which a curve is drawn, as a share of them.
const STEP: f64 = 0.01;

pub(crate) fn run(arguments: &Frf) -> anyhow::Result<()> {
    let named_dataset = arguments.source.file_name().is_some_and(|name| name == "dataset.toml");
    let response = if arguments.source.is_dir() || named_dataset {
        measured::respond(arguments)?
    } else {
        simulated::respond(arguments)?
    };
    let mut written = String::new();
    if let Some(folder) = &arguments.out {
        let files = [
            ("frf.csv", writing::csv(&response)),
            ("frf.json", serde_json::to_string_pretty(&writing::json(&response))? + "\n"),
            ("report.html", pages::frf::page(&response)),
        ];
        written = terminal::write_all(folder, &files)?;
    }
    terminal::print(&if arguments.json {
        serde_json::to_string_pretty(&writing::json(&response))?
    } else {
        text(&response) + &written
    })
}

fn text(response: &Response) -> String {
    let estimate = &response.estimate;
    let lines = estimate.frequencies_hz.len();
    // Evenly spaced on a logarithmic scale.
    let (first, last) = (estimate.frequencies_hz[0], estimate.frequencies_hz[lines - 1]);
    let mut shown: Vec<usize> = (0..MOST_ROWS)
        .map(|i| first * (last / first).powf(i as f64 / (MOST_ROWS - 1) as f64))
        .map(|f| estimate.frequencies_hz.partition_point(|g| *g < f * (1.0 - 1e-9)).min(lines - 1))
        .collect();
    shown.dedup();
    let rows = shown.iter().map(|&i| {
        let row = writing::row(response, i);
        let number = |value: f64| if value.is_finite() { plain(value) } else { "-".to_owned() };
        vec![
            plain(row.frequency_hz),
            format!("{:.2}", row.magnitude_db),
            number(row.half_width_db),
            format!("{:.1}", row.phase_deg),
            number(row.phase_half_width_deg),
            number(row.coherence),
            format!("{:.2}", row.linear_db),
            format!("{:.1}", row.linear_deg),
        ]
    });
    let header = [
        "frequency (Hz)",
        "measured (dB)",
        "± (dB)",
        "phase (deg)",
        "± (deg)",
        "coherence",
        "linear (dB)",
        "linear (deg)",
    ];
    let mut parts = vec![format!("{}\n{}", response.path(), response.how)];
    parts.extend(
        (!response.notes.is_empty())
            .then(|| response.notes.iter().map(|n| format!("note: {n}")).collect::<Vec<_>>().join("\n")),
    );
    parts.push(table(&header, &[0, 1, 2, 3, 4, 5, 6, 7], rows));
    parts.push(response.sentences().join("\n"));
    parts.join("\n\n")
}

/// What the sensor reads whose reading a signal is.
fn sensed(machine: &Machine, signal: &SignalName) -> Option<String> {
    let sensor = machine.sensors.get(&signal.element).filter(|_| signal.quantity == Quantity::Reading)?;
    Some(sensor.reads.to_string())
}

/// Checks of what every source of records has in common.
fn require(holds: bool, message: impl FnOnce() -> String, remedy: &str) -> anyhow::Result<()> {
    if holds { Ok(()) } else { Err(BadInput::error(message(), remedy)) }
}

/// Whether anything of the input arrives at the output, by linear theory.
fn require_path(
    arguments: &Frf,
    experiment: &Experiment,
    (low_hz, high_hz): (f64, f64),
    input: &str,
) -> anyhow::Result<()> {
    let ends = [low_hz, (low_hz * high_hz).sqrt(), high_hz];
    let response = experiment.linear_response(&ends).map_err(|error| refused(arguments, &error))?;
    require(
        response.iter().any(|value| value.norm() > 0.0),
        || {
            format!(
                "nothing of {input} arrives at {}: the machine has no response between them as it is engaged",
                experiment.output
            )
        },
        "name another --output, as the acceleration of a body; a contact that is absent feels nothing, and one of force k d^1.5 has no stiffness without \
         a mean force, which --offset gives",
    )
}

/// A length of segments is for an estimator that averages over them.
fn require_segments(arguments: &Frf, averages: bool) -> anyhow::Result<()> {
    require(
        arguments.segment.is_none() || averages,
        || {
            "--segment is the length of what H1, H2 and Hv average of noise, and nothing is averaged here"
                .to_owned()
        },
        "add --estimator h1, h2 or hv for noise, or leave --segment out",
    )
}

fn band(arguments: &Frf, hold_s: f64, lowest_hz: f64, excited_hz: Option<f64>) -> anyhow::Result<(f64, f64)> {
    let nyquist = 0.5 / hold_s;
    let usual = excited_hz.unwrap_or(nyquist).min(0.8 * nyquist);
    let (low, high) = (arguments.from.unwrap_or(lowest_hz), arguments.to.unwrap_or(usual));
    require(
        low > 0.0 && low < high && high < nyquist,
        || {
            let why = if low <= 0.0 {
                "a frequency must be above zero".to_owned()
            } else if low >= high {
                "it ends before it begins".to_owned()
            } else {
                format!("samples come every {hold_s} s, so frequencies end at {nyquist} Hz")
            };
            format!("no band from {low} to {high} Hz: {why}")
        },
        "name a band with --from and --to, in Hz",
    )?;
    require(
        arguments.confidence > 0.0 && arguments.confidence < 1.0,
        || format!("a confidence of {} is no probability", arguments.confidence),
        "write it as in --confidence 0.95",
    )?;
    Ok((low, high))
}

fn estimator(kind: EstimatorKind) -> Option<Estimator> {
    match kind {
        EstimatorKind::LocalPolynomial => None,
        EstimatorKind::H1 => Some(Estimator::H1),
        EstimatorKind::H2 => Some(Estimator::H2),
        EstimatorKind::Hv => Some(Estimator::Hv),
    }
}

/// Everything that a file or a request can be wrong in; the rest is a mistake of the program.
fn refused(arguments: &Frf, error: &AnalysisError) -> anyhow::Error {
    let remedy = match error {
        AnalysisError::RunEnded { .. } => {
            "the machine runs away under this excitation: try --clamped, or less with --rms"
        }
        AnalysisError::Lti(_) => "longer records, a shorter --segment or a narrower band may help",
        _ => "see feeler frf --help for what can be asked",
    };
    BadInput::error(format!("{}: {error}", arguments.source.display()), remedy)
}
