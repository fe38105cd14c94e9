//! `feeler completions`.

use clap::CommandFactory;

use crate::arguments::{Arguments, Completions};
use crate::terminal;
use crate::terminal::failure::Failure;

pub(crate) fn run(arguments: &Completions) -> crate::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Arguments::command(), "feeler", &mut script);
    terminal::print(&String::from_utf8(script).map_err(Failure::internal)?)
}
