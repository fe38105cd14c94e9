//! Arguments of `feeler diagnose`, `feeler blind` and `feeler replay`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Subcommand, ValueHint};
use feeler_diagnosis::Budget;

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler diagnose scenarios/datasets/bench-axis   results in out/bench-axis\n  \
    feeler diagnose bench --out answer --changes    prints the lines to change\n  \
    feeler diagnose bench --apply                   changes the file\n  \
    feeler diagnose bench --json | jq .verdict\n\n\
    Writes diagnosis.json, report.html (a page that needs no network) and machine.toml, the repaired \
    machine, ready for `feeler run`. A CSV for each drive holds its commands in one experiment, which that \
    machine repeats. If another experiment would separate remaining causes, it also writes \
    next-experiment.csv.")]
pub(crate) struct Diagnose {
    /// Dataset: a folder with dataset.toml, or that file
    #[arg(value_hint = ValueHint::AnyPath)]
    pub(crate) dataset: PathBuf,
    /// Folder for the results, made if absent [default: out/ and the name of the dataset]
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) budget: BudgetTime,
    /// Print the changes to the believed machine, as lines of its file
    #[arg(long, conflicts_with = "json")]
    pub(crate) changes: bool,
    /// Change the dataset's machine file, and keep a copy beside it as .bak; comments stay
    #[arg(long, conflicts_with = "json")]
    pub(crate) apply: bool,
    /// Print the diagnosis as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
pub(crate) struct BudgetTime {
    /// Largest wall time of a diagnosis: `90 s`, `3 min`, or `unlimited`. The report lists what was not tried
    #[arg(
        long,
        value_name = "TIME",
        default_value = "120 s",
        value_parser = limit,
        allow_hyphen_values = true
    )]
    budget: Limit,
}

impl BudgetTime {
    /// The budget, counted from now.
    pub(crate) fn begin(&self) -> Budget {
        self.budget.0.map_or_else(Budget::unlimited, Budget::of)
    }
}

/// `None` if the time is unlimited.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Limit(Option<Duration>);

fn limit(text: &str) -> Result<Limit, String> {
    let text = text.trim();
    if text == "unlimited" {
        return Ok(Limit(None));
    }
    let (number, factor) = match text.strip_suffix("min") {
        Some(minutes) => (minutes, 60.0),
        None => (text.strip_suffix('s').unwrap_or(text), 1.0),
    };
    let seconds = number.trim().parse::<f64>().ok().map(|number| number * factor);
    let time = seconds.filter(|seconds| *seconds > 0.0).and_then(|s| Duration::try_from_secs_f64(s).ok());
    time.map(|time| Limit(Some(time)))
        .ok_or_else(|| "not a time above zero: write '90 s', '3 min' or 'unlimited'".into())
}

/// The three stages of a blind benchmark.
#[derive(Debug, Subcommand)]
pub(crate) enum Blind {
    /// Make cases: datasets, experiments held back, and the sealed truth
    Make(BlindMake),
    /// Diagnose every case that has no answer yet
    Run(BlindRun),
    /// Open the truth and score the answers: tables, score.json and score.html
    Score(BlindScore),
}

#[derive(Args, Debug)]
#[command(after_help = "Example:\n  \
    feeler blind make --cases 240 --seed 7 --out blind\n  \
    feeler blind make --wild --cases 200 --seed 3 --out wild    as real logs are\n  \
    feeler blind make --servo --cases 100 --seed 3 --out servo  position servos\n\n\
    About eight of twelve cases hide exactly one effect of the library. The others hide nothing, two \
    effects, or an effect outside the library. Of wild cases, nine of twenty hide exactly one.")]
pub(crate) struct BlindMake {
    /// Number of cases
    #[arg(
        long,
        value_name = "N",
        default_value_t = 24,
        value_parser = clap::value_parser!(u32).range(1..=100_000)
    )]
    pub(crate) cases: u32,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Record like real machines: slow motion, much friction, noise on the command, coarse encoders, lost
    /// rows
    #[arg(long)]
    pub(crate) wild: bool,
    /// Servo joints, of which only the target and the servo's own position are recorded
    #[arg(long, conflicts_with = "wild")]
    pub(crate) servo: bool,
    /// Folder for the cases, made if absent
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: PathBuf,
}

#[derive(Args, Debug)]
#[command(after_help = "Example:\n  \
    feeler blind run blind                      can be stopped and started again\n  \
    feeler blind run others --answers answers   any folder of dataset folders\n\n\
    Writes diagnosis.json and answer.json for each case. `feeler blind score` reads answer.json. A case \
    with an answer.json is not run again.")]
pub(crate) struct BlindRun {
    /// Folder that `feeler blind make` has filled, or any folder of dataset folders
    #[arg(value_hint = ValueHint::DirPath)]
    pub(crate) folder: PathBuf,
    /// Folder for the answers, made if absent [default: answers in FOLDER]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) answers: Option<PathBuf>,
    /// Hide the last check experiment of each dataset from the diagnosis, if no others were held back
    #[arg(long)]
    pub(crate) hold_back: bool,
    #[command(flatten)]
    pub(crate) budget: BudgetTime,
}

#[derive(Args, Debug)]
#[command(after_help = "Example:\n  \
    feeler blind score blind --json | jq .measures\n  \
    feeler blind score others --answers answers --truth others/truth.json\n\n\
    Writes score.json and score.html (a page that needs no network) among the answers.")]
pub(crate) struct BlindScore {
    /// Folder with the cases
    #[arg(value_hint = ValueHint::DirPath)]
    pub(crate) folder: PathBuf,
    /// Folder with the answers [default: answers in FOLDER]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) answers: Option<PathBuf>,
    /// The truth, sealed or as JSON [default: truth.sealed in FOLDER]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) truth: Option<PathBuf>,
    /// Print the scores as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Example:\n  \
    feeler replay out/bench/machine.toml other-records --out replayed\n\n\
    Prints two errors: of predictions over 50 ms, each from the measured motion, and of a free run. A free \
    run starts from the first row and is never corrected. Writes one CSV per experiment, with the free run's \
    columns under their own names, and replay.json with the errors.")]
pub(crate) struct Replay {
    /// Machine file (TOML)
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) machine: PathBuf,
    /// Dataset: a folder with dataset.toml, or that file
    #[arg(value_hint = ValueHint::AnyPath)]
    pub(crate) dataset: PathBuf,
    /// Folder for the results, made if absent
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: PathBuf,
    /// Print the errors as JSON
    #[arg(long)]
    pub(crate) json: bool,
}
