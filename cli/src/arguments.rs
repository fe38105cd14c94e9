//! Command line of `feeler`: one definition gives parsing, help and completions.

mod diagnosis;
mod frf;
mod groups;
mod import;
mod live;
mod reduce;
mod reference;
mod tune;

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand, ValueEnum, ValueHint};
use feeler_engine::Integrator;
use feeler_studies::sweep::Shard;

/// Folder of the scenario files, relative to the root of the project.
pub(crate) const DEFAULT_SCENARIOS: &str = "scenarios";

pub(crate) use diagnosis::{Blind, BlindMake, BlindRun, BlindScore, Diagnose, Replay};
pub(crate) use frf::{ExcitationKind, Frf};
pub(crate) use import::Import;
pub(crate) use live::{Compare, Live};
pub(crate) use reduce::Reduce;
pub(crate) use reference::{Completions, Effects, FileKind, New, Schema};
pub(crate) use tune::Tune;

/// Simulate robot force control, and see why it chatters.
#[derive(Debug, Parser)]
#[command(
    name = "feeler",
    version,
    propagate_version = true,
    max_term_width = 80,
    help_template = groups::template(&Command::augment_subcommands(clap::Command::new("feeler"))),
    after_help = "Examples:\n  \
        feeler new chatter --out chatter.toml    a scenario to start from\n  \
        feeler run chatter.toml                  run it: summary, trace, report.html\n  \
        feeler run chatter.toml --set controllers.force.kp=0.4\n\n\
        Exit codes: 0 done, 1 a check failed, 2 bad input, 3 internal error."
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a scenario: print a summary, write trace, summary and report
    Run(Run),
    /// Serve a page with a slider for every number of a scenario; run and theory follow
    Live(Live),
    /// Compare runs, scenarios or datasets on one page
    Compare(Compare),
    /// Run a scenario in many variants, over the axes of a sweep file
    Sweep(Sweep),
    /// Combine the shards of a sweep
    Merge(Merge),
    /// Find why a scenario chatters, by runs without one ingredient, and what cures it
    Why(Why),
    /// Choose gains, and a filter, lead or notch, for the largest bandwidth without chatter
    Tune(Tune),
    /// List what a robot's logs hold, and make datasets of them
    Import(Import),
    /// Find where a machine departs from its records, which effect causes it, and how sure that is
    Diagnose(Diagnose),
    /// Drive a machine with a dataset's recorded commands, and measure its prediction error
    Replay(Replay),
    /// Measure the diagnosis on data whose hidden effect it never sees
    #[command(subcommand)]
    Blind(Blind),
    /// Check machine, scenario, sweep and dataset files without running them
    Check(Check),
    /// Linear theory of a scenario: poles, zeros, modes, stable gains, margins, what limits the loop
    Analyze(Analyze),
    /// Measure a frequency response, simulated or from a dataset, and compare it with the linear one
    Frf(Frf),
    /// Reduce a robot arm to one axis along a contact normal, or map its force bandwidth
    Reduce(Reduce),
    /// Compare the simulation with closed forms, independent numbers and the paper's claims
    Validate(Validate),
    /// Draw the paper's figures from the reference axis
    Figures(Figures),
    /// Fit a chain of masses to the landmarks that the paper measured on a robot
    FitLandmarks(FitLandmarks),
    /// List the effects that a machine can have, or explain one
    Effects(Effects),
    /// Print or write a scenario to start from
    New(New),
    /// Print the JSON Schema of a kind of file, for editors
    Schema(Schema),
    /// Print shell completions
    Completions(Completions),
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler run scenario.toml                     results in out/<its name>\n  \
    feeler run scenario.toml --out first --csv   results in first/, with trace.csv\n  \
    feeler run scenario.toml --set 'contacts.tool.gap=5 mm'\n  \
    feeler run scenario.toml --integrator rk4 --set 'run.step=50 us'\n  \
    feeler run scenario.toml --engine rapier --set 'run.step=20 us'\n  \
    feeler run scenario.toml --json | jq .outcome\n  \
    feeler run scenarios/arms/press-low-gain.toml    a whole arm, seen in motion\n\n\
    Writes trace.parquet (t_s, then the recorded signals), summary.json, and report.html, a page of plots \
    that needs no network. With --csv it writes trace.csv too. docs/outcomes.md explains the outcomes.")]
#[expect(clippy::struct_excessive_bools, reason = "each is a flag of the command line")]
pub(crate) struct Run {
    /// Scenario file (TOML)
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// Set a key of the file, as in controllers.force.kp=0.8; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) settings: Vec<String>,
    /// Folder for the results, made if absent [default: out/ and the name of the scenario, with the
    /// settings of the command line]
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// Also write the trace as CSV
    #[arg(long)]
    pub(crate) csv: bool,
    /// Run again whenever the file changes
    #[arg(long, conflicts_with = "json")]
    pub(crate) watch: bool,
    /// Print the summary as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Run like a variant of a sweep: extended until the outcome is decided, recorded at a sweep's rate,
    /// without an energy ledger
    #[arg(long)]
    pub(crate) as_sweep: bool,
    /// Threads for writing the results [default: one per processor]; results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Integrator, instead of the file's
    #[arg(long, value_name = "NAME", value_parser = integrators())]
    pub(crate) integrator: Option<String>,
    /// Engine that moves the bodies, instead of the file's
    #[arg(long, value_name = "NAME", value_parser = ["feeler", "rapier"])]
    pub(crate) engine: Option<String>,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler sweep map.toml                  results in out/<name of the sweep>\n  \
    feeler sweep map.toml --threads 8 --out first\n  \
    feeler sweep map.toml --shard 3/16     one of sixteen parts, for feeler merge\n\n\
    Writes sweep.parquet (one row per variant), report.html, and drawings as SVG and PNG. You can kill a \
    sweep at any time. The same command continues it and ends with the same bytes.")]
pub(crate) struct Sweep {
    /// Sweep file (TOML)
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// Folder for the results, made if absent [default: out/ and the name of the sweep]
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// Threads [default: one per processor]; results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Run only part K of N, with K from 1 to N; all parts together are the sweep
    #[arg(long, value_name = "K/N")]
    pub(crate) shard: Option<Shard>,
    /// Print the number of variants with each outcome as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler merge out/map               all shards wrote into one folder\n  \
    feeler merge a b c --out map       each into its own")]
pub(crate) struct Merge {
    /// Folders that hold the shards
    #[arg(required = true, value_hint = ValueHint::DirPath)]
    pub(crate) folders: Vec<PathBuf>,
    /// Folder for the results [default: the first of the folders]
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// Print the number of variants with each outcome as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler why scenario.toml\n  \
    feeler why scenario.toml --out why       with why/report.html and why/why.json\n  \
    feeler why scenario.toml --json | jq .causes\n  \
    feeler why scenario.toml --try 1 --out cured.toml\n\n\
    Runs the scenario again without one ingredient at a time (delay, flexibility, friction, ...), then \
    without two or three. The smallest set whose absence removes the chatter is the cause.")]
pub(crate) struct Why {
    /// Scenario file (TOML)
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// Set a key of the file, as in controllers.force.kp=0.8; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) settings: Vec<String>,
    /// Folder for why.json and report.html, made if absent; with --try, the file to write
    #[arg(long, short, value_name = "DIR|FILE", value_hint = ValueHint::AnyPath)]
    pub(crate) out: Option<PathBuf>,
    /// Write FILE with remedy N of the table applied, comments kept, to the file that --out names
    #[arg(long = "try", value_name = "N", requires = "out")]
    pub(crate) remedy: Option<usize>,
    /// Print as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler check scenario.toml\n  \
    feeler check scenarios/*/*.toml measured/dataset.toml\n\n\
    Reports all mistakes of a file together, each with its line and remedy.\n\
    The exit code is 1 if one keeps the file from being used; warnings leave it 0.")]
pub(crate) struct Check {
    /// Machine, scenario, sweep or dataset files, or dataset folders
    #[arg(required = true, value_hint = ValueHint::AnyPath)]
    pub(crate) files: Vec<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler analyze scenario.toml\n  \
    feeler analyze scenario.toml --out theory   Bode, Nyquist, root locus, modes\n  \
    feeler analyze scenario.toml --output motor.position --clamped\n  \
    feeler analyze scenario.toml --gain controllers.force.ki\n  \
    feeler analyze scenario.toml --json | jq .gain.sampled.stable\n\n\
    `sampled` is the loop with the file's period, delay, filters and hold; `continuous` is without them.")]
pub(crate) struct Analyze {
    /// Scenario file (TOML)
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// Set a key of the file, as in controllers.force.kp=0.8; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) settings: Vec<String>,
    /// Input: an actuator's command, or the force from outside on a body, as in tip.force [default: the
    /// command of the first controller's actuator]
    #[arg(long, value_name = "SIGNAL")]
    pub(crate) input: Option<String>,
    /// Output whose poles, zeros and modes are listed; gains and margins stay those of the loop [default:
    /// what the first controller reads]
    #[arg(long, value_name = "SIGNAL")]
    pub(crate) output: Option<String>,
    /// Gain whose stable range is computed, as in controllers.force.kp [default: the first controller's
    /// leading gain]
    #[arg(long, value_name = "KEY")]
    pub(crate) gain: Option<String>,
    /// Attach every contact, as the paper's linear models do
    #[arg(long, conflicts_with_all = ["free", "preload"])]
    pub(crate) clamped: bool,
    /// Remove every contact
    #[arg(long, conflicts_with = "preload")]
    pub(crate) free: bool,
    /// Press the first contact with this force (N) and linearise there
    #[arg(long, value_name = "FORCE", allow_negative_numbers = true)]
    pub(crate) preload: Option<f64>,
    /// Folder for report.html and analyze.json, made if absent; nothing is written without it
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// Print as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler validate --quick\n  \
    feeler validate --critical-gains ../shared/reference/critical-gains.json\n  \
    feeler validate convergence\n\n\
    The exit code is 1 if a check fails.")]
pub(crate) struct Validate {
    /// The checks to run
    #[arg(value_enum, default_value_t = Checks::All)]
    pub(crate) checks: Checks,
    /// Only the checks that take seconds
    #[arg(long)]
    pub(crate) quick: bool,
    /// Independent critical gains (JSON) to compare linear theory with
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) critical_gains: Option<PathBuf>,
    /// Folder of the scenario files, with the paper's machines
    #[arg(long, value_name = "DIR", default_value = DEFAULT_SCENARIOS, value_hint = ValueHint::DirPath)]
    pub(crate) scenarios: PathBuf,
    /// Print as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Groups of checks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Checks {
    /// Everything
    All,
    /// Error of the three integrators against step size, through an impact
    Convergence,
    /// Rapier against the exact engine, by step size
    Engines,
}

#[derive(Args, Debug)]
#[command(after_help = "Example:\n  \
    feeler figures --out figures       SVG files, and captions.md")]
pub(crate) struct Figures {
    /// Folder for the figures, made if absent
    #[arg(long, short, value_name = "DIR", default_value = "out/figures", value_hint = ValueHint::DirPath)]
    pub(crate) out: PathBuf,
}

#[derive(Args, Debug)]
#[command(after_help = "Example:\n  \
    feeler fit-landmarks --out chain.toml     from 12 starts (seconds)\n  \
    feeler fit-landmarks --starts 1           from the first of them\n  \
    feeler fit-landmarks --start chain.toml   from your machine with these bodies\n\n\
    The result is one chain that shows the landmarks of the paper's Figs. 15 to 17. Its parameters are not \
    the robot's, which were never published. The table lists the parameters that the landmarks determine.")]
pub(crate) struct FitLandmarks {
    /// Number of starts: chains with the paper's flexible resonances, and fixed guesses for all other
    /// parameters
    #[arg(
        long,
        value_name = "N",
        default_value_t = 12,
        value_parser = clap::value_parser!(u64).range(1..=10_000),
        conflicts_with = "start"
    )]
    pub(crate) starts: u64,
    /// Machine file to start from instead: bodies base, motor and link1 to link4, as `--out` writes
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) start: Option<PathBuf>,
    /// Largest number of steps of each fit
    #[arg(long, value_name = "N", default_value_t = 2000, allow_negative_numbers = true)]
    pub(crate) iterations: usize,
    /// Machine file to write (TOML)
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) out: Option<PathBuf>,
    /// Print as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

fn integrators() -> PossibleValuesParser {
    PossibleValuesParser::new(Integrator::ALL.iter().map(|(_, name)| *name))
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::*;
    use clap::CommandFactory;

    #[test]
    fn truth_the_definition_is_consistent() {
        Arguments::command().debug_assert();
    }

    /// Columns of a help text on the page.
    const COLUMNS: usize = 80;

    /// The help of a command and of those below it, as sections of the page.
    fn sections(command: &mut clap::Command, name: &str, text: &mut String) {
        // `--help` prints the long form only if it says more than the short one.
        let help = command.clone().try_get_matches_from([name, "--help"]).unwrap_err().to_string();
        let lines = help.lines().map(str::trim_end).collect::<Vec<_>>().join("\n");
        let _ = writeln!(text, "\n## `{name}`\n\n```text\n{}\n```", lines.trim());
        for below in command.get_subcommands_mut().filter(|below| below.get_name() != "help") {
            let name = format!("{name} {}", below.get_name());
            sections(below, &name, text);
        }
    }

    /// Hand-written lines fit a terminal; clap breaks longer lines anywhere.
    #[test]
    fn truth_examples_fit_a_terminal() {
        fn visit(command: &clap::Command) {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            for line in help.lines().filter(|line| line.starts_with("  ")) {
                assert!(line.chars().count() <= COLUMNS, "{}: {line}", command.get_name());
            }
            command.get_subcommands().for_each(visit);
        }
        visit(&Arguments::command());
    }

    /// With `FEELER_UPDATE_DOCS=1` the page is written instead.
    #[test]
    fn truth_the_page_of_commands_is_their_help() {
        let mut command = Arguments::command().term_width(COLUMNS).disable_help_subcommand(true);
        command.build();
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/commands.md");
        let committed = std::fs::read_to_string(&path).unwrap_or_default();
        // The beginning of the page is written by hand.
        let beginning = committed.split("\n## ").next().unwrap_or_default();
        let mut text = String::from(beginning);
        sections(&mut command, "feeler", &mut text);
        if std::env::var_os("FEELER_UPDATE_DOCS").is_some() {
            return std::fs::write(&path, &text).unwrap();
        }
        assert!(
            committed == text,
            "docs/commands.md is stale: FEELER_UPDATE_DOCS=1 cargo test -p feeler commands"
        );
    }
}
