//! Arguments of commands that print lists and definitions: effects, templates, schemas, completions.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum, ValueHint};
use feeler_files::template_names;
use feeler_plant::effects::{Kind, LIBRARY};

#[derive(Args, Debug)]
#[command(after_help = format!("Examples:\n  \
    feeler effects                     all of them\n  \
    feeler effects {0}    one: equation, parameters, source\n  \
    feeler effects {0} --out law.svg\n  \
    feeler effects --json", Kind::CoulombFriction))]
pub(crate) struct Effects {
    /// Explain this effect
    #[arg(
        value_name = "KIND",
        value_parser = PossibleValuesParser::new(LIBRARY.iter().map(|effect| effect.name)),
        hide_possible_values = true
    )]
    pub(crate) kind: Option<String>,
    /// Draw its law as SVG, in place of its page
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath, requires = "kind")]
    pub(crate) out: Option<PathBuf>,
    /// Print as JSON
    #[arg(long, conflicts_with = "out")]
    pub(crate) json: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler new --list\n  \
    feeler new flexible > axis.toml\n  \
    feeler new chatter --out chatter.toml\n  \
    feeler new dataset --out bench\n  \
    feeler new arm --urdf robot.urdf --out robot.toml")]
pub(crate) struct New {
    /// Template to start from
    #[arg(
        value_name = "TEMPLATE",
        required_unless_present = "list",
        value_parser = PossibleValuesParser::new(template_names())
    )]
    pub(crate) template: Option<String>,
    /// URDF with the joints of the arm file (template `arm`)
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, required_if_eq("template", "arm"))]
    pub(crate) urdf: Option<PathBuf>,
    /// File to write, or folder for a template of several files; existing files are kept [default: standard
    /// output]
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::AnyPath)]
    pub(crate) out: Option<PathBuf>,
    /// List the templates
    #[arg(long, conflicts_with_all = ["template", "out"])]
    pub(crate) list: bool,
}

#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    feeler schema > machine.schema.json   #:schema ./machine.schema.json on top\n  \
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
    /// Scenarios of a whole arm
    Arm,
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
