//! Arguments of `feeler import`.

use std::path::PathBuf;

use clap::{Args, ValueHint};

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler import bag.mcap                                      list what it holds\n  \
    feeler import bag_folder --out elbow --joint elbow --urdf robot.urdf\n  \
    feeler import a.csv b.csv --out axis --target q_des --position q\n  \
    feeler import bag.mcap --json | jq '.runs[].tables[].columns[].name'\n\n\
    Reads MCAP logs and ROS 2 bags (CDR or JSON), LeRobot data sets, Parquet, npz, npy and CSV, as files or \
    folders. Writes a dataset with a first machine, or one folder for each of several joints.")]
pub(crate) struct Import {
    /// Logs: files, or folders of them
    #[arg(required = true, value_name = "LOG", value_hint = ValueHint::AnyPath)]
    pub(crate) logs: Vec<PathBuf>,
    /// Folder for the dataset, made if absent; nothing is written without it
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// Believed machine: a machine file
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with_all = ["urdf", "mjcf"])]
    pub(crate) machine: Option<PathBuf>,
    /// Believed machine: a URDF
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with = "mjcf")]
    pub(crate) urdf: Option<PathBuf>,
    /// Believed machine: an MJCF, with the loops of its actuators
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) mjcf: Option<PathBuf>,
    /// Only this joint, by its name in the log or the model
    #[arg(long, value_name = "NAME")]
    pub(crate) joint: Option<String>,
    /// Column of the target position [default: guessed]
    #[arg(long, value_name = "COLUMN")]
    pub(crate) target: Option<String>,
    /// Column of the speed that goes to the servo with the target
    #[arg(long, value_name = "COLUMN")]
    pub(crate) target_velocity: Option<String>,
    /// Column of the force that the servo adds to its own
    #[arg(long, value_name = "COLUMN")]
    pub(crate) feed_forward: Option<String>,
    /// Column of the commanded force, current, voltage or duty
    #[arg(long, value_name = "COLUMN")]
    pub(crate) command: Option<String>,
    /// Column of the measured position [default: guessed]
    #[arg(long, value_name = "COLUMN")]
    pub(crate) position: Option<String>,
    /// Column of the measured effort
    #[arg(long, value_name = "COLUMN")]
    pub(crate) effort: Option<String>,
    /// Unit of the clock
    #[arg(long, value_name = "UNIT", value_parser = ["s", "ms", "us", "ns"])]
    pub(crate) clock: Option<String>,
    /// Rate of the rows if no column is a clock, Hz
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub(crate) rate: Option<f64>,
    /// Print the contents, guesses and datasets as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

fn positive(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|rate| rate.is_finite() && *rate > 0.0);
    value.ok_or_else(|| "a number above zero is needed".into())
}
