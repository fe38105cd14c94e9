//! The `feeler` command: simulates robot force control from files.
//!
//! Exit codes: 0 done, 1 a check failed, 2 bad input, 3 internal. Results go to standard output, everything
//! else to standard error.

mod arguments;
mod commands;
mod live;
mod pages;
mod repaired;
mod terminal;
mod units;
mod watched;
mod words;

use std::process::ExitCode;

use clap::Parser;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use feeler_studies::numbers;

use arguments::{Arguments, Command};
use terminal::failure::{self, Failure, Result};

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        // Help and version are not failures; the parser prints them to the right streams.
        Err(error) => {
            let error = with_tip(error);
            let code = if error.use_stderr() { failure::BAD_INPUT } else { failure::DONE };
            return if error.print().is_ok() {
                ExitCode::from(code)
            } else {
                ExitCode::from(failure::INTERNAL)
            };
        }
    };
    match std::panic::catch_unwind(|| dispatch(&arguments)) {
        Ok(Ok(())) => ExitCode::from(failure::DONE),
        Ok(Err(failure)) => failure.report(),
        // The panic hook has printed the message and the place.
        Err(_) => ExitCode::from(failure::INTERNAL),
    }
}

/// The parser's error, with a tip if a setting lacks quotes and its rest was parsed as further arguments.
fn with_tip(mut error: clap::Error) -> clap::Error {
    let unquoted = match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::String(argument))
            if error.kind() == ErrorKind::UnknownArgument && !argument.starts_with('-') =>
        {
            let words: Vec<_> = std::env::args_os().collect();
            words.windows(3).any(|three| three[0] == "--set" && three[2] == argument.as_str())
        }
        _ => false,
    };
    if unquoted {
        let tip = "quote a setting that contains blanks, as in --set 'contacts.tool.gap=5 mm'";
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
    error
}

fn dispatch(arguments: &Arguments) -> Result<()> {
    match &arguments.command {
        Command::Run(run) => commands::run::run(run),
        Command::Live(live) => commands::live::run(live),
        Command::Compare(compare) => commands::compare::run(compare),
        Command::Sweep(sweep) => commands::sweep::run(sweep),
        Command::Merge(merge) => commands::merge::run(merge),
        Command::Why(why) => commands::why::run(why),
        Command::Tune(tune) => commands::tune::run(tune),
        Command::Import(import) => commands::import::run(import),
        Command::Diagnose(diagnose) => commands::diagnose::run(diagnose),
        Command::Blind(blind) => commands::blind::run(blind),
        Command::Replay(replay) => commands::replay::run(replay),
        Command::Check(check) => commands::check::run(check),
        Command::Analyze(analyze) => commands::analyze::run(analyze),
        Command::Frf(frf) => commands::frf::run(frf),
        Command::Reduce(reduce) => commands::reduce::run(reduce),
        Command::Validate(validate) => commands::validate::run(validate),
        Command::Figures(figures) => commands::figures::run(figures),
        Command::FitLandmarks(fit) => commands::fit_landmarks::run(fit),
        Command::Effects(effects) => commands::effects::run(effects),
        Command::New(new) => commands::new::run(new),
        Command::Schema(schema) => commands::schema::run(schema),
        Command::Completions(completions) => commands::completions::run(completions),
    }
}
