//! What can be asked of `feeler`: one definition from which parsing, help and completions follow.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand, ValueEnum, ValueHint};
use feeler_engine::Integrator;
use feeler_plant::effects::LIBRARY;
use feeler_scenarios::format::TEMPLATES;

/// Simulate robot force control, and see why it chatters.
#[derive(Debug, Parser)]
#[command(
    name = "feeler",
    version,
    propagate_version = true,
    max_term_width = 100,
    after_help = "Examples:\n  \
        feeler new chatter --out chatter.toml          a scenario to start from\n  \
        feeler run chatter.toml                        run it: summary, trace, report.html\n  \
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
    /// Check machine, scenario, sweep and dataset files without running them
    Check(Check),
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
    feeler run scenario.toml                                     results in out/<name of the scenario>\n  \
    feeler run scenario.toml --out first --csv                   results in first/, with trace.csv\n  \
    feeler run scenario.toml --set controllers.force.kp=0.8 --set 'contacts.tool.gap=5 mm'\n  \
    feeler run scenario.toml --integrator rk4 --set 'run.step=50 us'\n  \
    feeler run scenario.toml --json | jq .outcome\n\n\
    Writes into the output folder: trace.parquet (first column t_s, then the recorded signals), trace.csv\n\
    with --csv, summary.json, and report.html, a page of interactive plots that needs no network.")]
pub(crate) struct Run {
    /// Scenario file (TOML)
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) file: PathBuf,
    /// Set a key of the file, as in controllers.force.kp=0.8; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(crate) settings: Vec<String>,
    /// Folder for the results, made if absent [default: out/<name of the scenario>]
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// Write the trace as CSV too
    #[arg(long)]
    pub(crate) csv: bool,
    /// Print the summary as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Threads for writing the results [default: one per processor]; results do not depend on it
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
    /// Integrator, in place of the file's
    #[arg(long, value_name = "NAME", value_parser = integrators())]
    pub(crate) integrator: Option<String>,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler check scenario.toml\n  \
    feeler check scenarios/*/*.toml measured/dataset.toml\n\n\
    All mistakes of a file are reported together, each with its line and what to do about it.")]
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
    feeler effects                     all of them\n  \
    feeler effects coulomb-friction    one, with its equation, its parameters and its source\n  \
    feeler effects --json")]
pub(crate) struct Effects {
    /// Explain this effect
    #[arg(value_name = "KIND", value_parser = PossibleValuesParser::new(LIBRARY.iter().map(|effect| effect.kind)), hide_possible_values = true)]
    pub(crate) kind: Option<String>,
    /// Print as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler new --list\n  \
    feeler new flexible > axis.toml\n  \
    feeler new chatter --out chatter.toml")]
pub(crate) struct New {
    /// Template to start from
    #[arg(
        value_name = "TEMPLATE",
        required_unless_present = "list",
        value_parser = PossibleValuesParser::new(TEMPLATES.iter().map(|template| template.name))
    )]
    pub(crate) template: Option<String>,
    /// File to write; standard output where absent. An existing file is left alone
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) out: Option<PathBuf>,
    /// List the templates
    #[arg(long, conflicts_with_all = ["template", "out"])]
    pub(crate) list: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler schema > machine.schema.json      then begin a file with: #:schema ./machine.schema.json\n  \
    feeler schema sweep > sweep.schema.json")]
pub(crate) struct Schema {
    /// Kind of file
    #[arg(value_enum, default_value_t = FileKind::Machine)]
    pub(crate) kind: FileKind,
}

/// Kinds of files that have a schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FileKind {
    /// Machines and scenarios
    Machine,
    /// Sweeps over scenarios
    Sweep,
    /// Measured datasets
    Dataset,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler completions bash > ~/.local/share/bash-completion/completions/feeler\n  \
    feeler completions zsh > ~/.zfunc/_feeler\n  \
    feeler completions fish > ~/.config/fish/completions/feeler.fish")]
pub(crate) struct Completions {
    /// Shell
    #[arg(value_enum)]
    pub(crate) shell: clap_complete::Shell,
}

fn integrators() -> PossibleValuesParser {
    PossibleValuesParser::new(Integrator::ALL.iter().map(|(_, name)| *name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn truth_the_definition_is_consistent() {
        Arguments::command().debug_assert();
    }
}
