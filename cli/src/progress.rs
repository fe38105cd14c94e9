//! A progress bar with an estimate, for whatever takes longer than a second.

use std::io::{self, IsTerminal};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

/// Work shorter than this shows no bar.
const PATIENCE: Duration = Duration::from_secs(1);
/// Positions of the bar.
const STEPS: u64 = 1000;

/// Shows how far some work has come; silent when standard error is no terminal.
pub(crate) struct Progress {
    label: String,
    started: Instant,
    wanted: bool,
    bar: Option<ProgressBar>,
}

impl Progress {
    pub(crate) fn new(label: impl Into<String>) -> Self {
        Self { label: label.into(), started: Instant::now(), wanted: io::stderr().is_terminal(), bar: None }
    }

    /// Notes that this share of the work is done.
    pub(crate) fn at(&mut self, share: f64) {
        if !self.wanted || (self.bar.is_none() && self.started.elapsed() < PATIENCE) {
            return;
        }
        let bar = self.bar.get_or_insert_with(|| bar(&self.label, self.started.elapsed()));
        bar.set_position((share * STEPS as f64) as u64);
    }

    /// Takes the bar away.
    pub(crate) fn done(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}

fn bar(label: &str, elapsed: Duration) -> ProgressBar {
    let bar = ProgressBar::new(STEPS).with_elapsed(elapsed).with_message(label.to_owned());
    match ProgressStyle::with_template("{msg} [{bar:40}] {percent} %, {eta} left") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
