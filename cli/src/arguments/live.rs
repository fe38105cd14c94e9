//! Arguments of `feeler live` and `feeler compare`.

use std::path::PathBuf;

use clap::{Args, ValueHint};

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler live scenario.toml               prints an address; Ctrl-C ends it\n  \
    feeler live scenario.toml --set controllers.force.kp=0.4\n  \
    feeler live machine.toml --data bench   records over the predictions\n\n\
    Only this computer can reach the page, under an address that nobody can guess.")]
pub(crate) struct Live {
    /// Scenario file (TOML)
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// Set a key of the file, as in controllers.force.kp=0.8; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) settings: Vec<String>,
    /// Dataset whose records are drawn over the predictions
    #[arg(long, value_name = "DATASET", value_hint = ValueHint::AnyPath)]
    pub(crate) data: Option<PathBuf>,
    /// Machine file of a diagnosis of that dataset, as a third curve
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, requires = "data")]
    pub(crate) repaired: Option<PathBuf>,
    /// Port of the loopback address; 0 takes any free one
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    pub(crate) port: u16,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler compare first.toml second.toml   what differs, and both over each other\n  \
    feeler compare out/first out/second     folders that `feeler run` wrote\n  \
    feeler compare scenario.toml --set controllers.force.kp=0.4\n  \
    feeler compare bench-one bench-two      records of datasets over each other\n  \
    feeler compare first.toml second.toml --json | jq .differing\n\n\
    Writes report.html and compare.json into the output folder.")]
pub(crate) struct Compare {
    /// Scenario files, folders of runs, or datasets
    #[arg(required = true, value_hint = ValueHint::AnyPath)]
    pub(crate) what: Vec<PathBuf>,
    /// Compare a single file with a variant of it: set a key, as in controllers.force.kp=0.8; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) settings: Vec<String>,
    /// Folder for the results, made if absent
    #[arg(long, short, value_name = "DIR", default_value = "out/compare", value_hint = ValueHint::DirPath)]
    pub(crate) out: PathBuf,
    /// Print the comparison as JSON
    #[arg(long)]
    pub(crate) json: bool,
}
