//! Arguments of `feeler tune`.

use std::path::PathBuf;

use clap::{Args, ValueHint};

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler tune scenario.toml\n  \
    feeler tune scenario.toml --spec \"phase margin >= 50 deg, overshoot <= 10 %\"\n  \
    feeler tune scenario.toml --spec \"structure = gains+notch\" --out tuned.toml\n  \
    feeler tune scenario.toml --diagnosis out/bench-axis --code out/controller\n\n\
    Clauses of --spec, with commas between them:\n  \
    phase margin >= 45 deg      by linear theory [default: 45 deg]\n  \
    gain margin >= 6 dB         by linear theory, up and down [default: 6 dB]\n  \
    disk margin >= 0.7          by linear theory\n  \
    sensitivity <= 6 dB         peak, by linear theory\n  \
    step overshoot <= 20 %      of the linear step response\n  \
    overshoot <= 10 %           of the simulated force, impact included\n  \
    peak force <= 60 N          in simulation\n  \
    settling time <= 200 ms     in simulation\n  \
    structure = gains+notch     gains, and filter, lead or notch\n  \
    gains = kp+damping          [default: error gains in fixed ratio, and damping]\n  \
    ki >= 5 1/s                 limit of a gain in `gains`; without a unit, SI\n  \
    controller = NAME           [default: the force controller]\n\n\
    Linear theory proposes the gains. The full simulation must come to rest and meet the limits in every \
    run.")]
pub(crate) struct Tune {
    /// Scenario file (TOML)
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// Set a key of the file, as in controllers.force.delay=0.002; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) settings: Vec<String>,
    /// Specification, in the clauses below [default: margins of 45 deg and 6 dB]
    #[arg(long, value_name = "CLAUSES", default_value = "", hide_default_value = true)]
    pub(crate) spec: String,
    /// Folder or diagnosis.json of `feeler diagnose`: its effects are added, and drawn from their intervals
    #[arg(long, value_name = "DIR|FILE", value_hint = ValueHint::AnyPath)]
    pub(crate) diagnosis: Option<PathBuf>,
    /// Machines drawn from the intervals of the diagnosis
    #[arg(
        long,
        value_name = "N",
        default_value_t = 200,
        value_parser = clap::value_parser!(u16).range(1..=10_000),
        requires = "diagnosis"
    )]
    pub(crate) draws: u16,
    /// File to write: the file with the tuned gains, comments kept
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) out: Option<PathBuf>,
    /// Folder for controller.c and controller.rs, made if absent
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) code: Option<PathBuf>,
    /// Print as JSON
    #[arg(long)]
    pub(crate) json: bool,
}
