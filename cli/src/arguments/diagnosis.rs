//! What can be asked of `feeler diagnose`, `feeler blind` and `feeler replay`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Subcommand, ValueHint};

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler diagnose scenarios/datasets/bench-axis            results in out/<name of the dataset>\n  \
    feeler diagnose bench --out bench-answer --apply         and what to change in the machine file\n  \
    feeler diagnose bench --json | jq .verdict\n\n\
    Writes into the output folder: diagnosis.json, report.html (a page that needs no network), machine.toml (the repaired\n\
    machine with the commands of one experiment, which `feeler run` takes), and next-experiment.csv where one would tell more.")]
pub(crate) struct Diagnose {
    /// Dataset: a folder with dataset.toml, or that file
    #[arg(value_hint = ValueHint::AnyPath)]
    pub(crate) dataset: PathBuf,
    /// Folder for the results, made if absent [default: out/ and the name of the dataset]
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// Wall time that it may take: `90 s`, `3 min`, or `unlimited`. What was not tried by then is named
    #[arg(long, value_name = "TIME", default_value = "120 s", value_parser = budget)]
    pub(crate) budget: BudgetTime,
    /// List what to change in the believed machine, as lines of its file
    #[arg(long, conflicts_with = "json")]
    pub(crate) apply: bool,
    /// Print the diagnosis as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// How long a diagnosis may take; none for as long as it takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BudgetTime(pub(crate) Option<Duration>);

fn budget(text: &str) -> Result<BudgetTime, String> {
    let text = text.trim();
    if text == "unlimited" {
        return Ok(BudgetTime(None));
    }
    let (number, factor) = match text.strip_suffix("min") {
        Some(minutes) => (minutes, 60.0),
        None => (text.strip_suffix('s').unwrap_or(text), 1.0),
    };
    let seconds = number.trim().parse::<f64>().ok().map(|number| number * factor);
    let time = seconds.filter(|seconds| *seconds > 0.0).and_then(|s| Duration::try_from_secs_f64(s).ok());
    time.map(|time| BudgetTime(Some(time)))
        .ok_or_else(|| "not a time: say '90 s', '3 min' or 'unlimited'".into())
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
    feeler blind make --wild --cases 200 --seed 3 --out wild      slow motion, much friction, a measured command\n\n\
    About four of twelve cases are no single effect of the library: nothing, two effects, or one of no library;\n\
    of wild cases eleven of twenty.")]
pub(crate) struct BlindMake {
    /// How many
    #[arg(long, value_name = "N", default_value_t = 24, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) cases: u32,
    /// Seed of everything random
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Record them as real machines are recorded: slow motion, friction up to most of the command, noise on
    /// the command, coarse encoders, lost rows
    #[arg(long)]
    pub(crate) wild: bool,
    /// Folder for the cases, made if absent
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: PathBuf,
}

#[derive(Args, Debug)]
#[command(after_help = "Example:\n  \
    feeler blind run blind                           stopped and started again it goes on where it was\n  \
    feeler blind run others --answers answers        datasets from elsewhere: any folder of dataset folders\n\n\
    Every case leaves answer.json, which is scored, and diagnosis.json; a case that has an answer.json is not run again.")]
pub(crate) struct BlindRun {
    /// Folder that `feeler blind make` has filled, or any folder of dataset folders
    #[arg(value_hint = ValueHint::DirPath)]
    pub(crate) folder: PathBuf,
    /// Folder for the answers, made if absent [default: answers in FOLDER]
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) answers: Option<PathBuf>,
    /// Keep the last check experiment of each dataset from the diagnosis, where no others were held back
    #[arg(long)]
    pub(crate) hold_back: bool,
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
    Writes into the output folder: one CSV per experiment with the predicted columns under their own names (started from the\n\
    first row, then never corrected), and replay.json with the errors.")]
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
