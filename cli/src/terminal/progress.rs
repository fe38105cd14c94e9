//! A progress bar with an estimate, for work of more than a second.

use std::io::{self, IsTerminal};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::stderr;
use crate::numbers::{plain, with_unit};

/// Work shorter than this shows no bar.
const PATIENCE: Duration = Duration::from_secs(1);
/// Positions of the bar.
const STEPS: u64 = 1000;

/// Shows the progress of some work; silent if standard error is not a terminal.
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

    /// Records the completed share of the work.
    pub(crate) fn at(&mut self, share: f64) {
        if !self.wanted || (self.bar.is_none() && self.started.elapsed() < PATIENCE) {
            return;
        }
        let bar = self.bar.get_or_insert_with(|| bar(&self.label, self.started.elapsed()));
        bar.set_position((share * STEPS as f64) as u64);
    }

    /// Removes the bar.
    pub(crate) fn done(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}

/// An indicator for work without a known length; silent if standard error is not a terminal. Ends when it is
/// dropped.
pub(crate) struct Busy(Option<ProgressBar>);

impl Busy {
    pub(crate) fn new(label: impl Into<String>) -> Self {
        let bar = io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new_spinner().with_message(label.into());
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        Self(bar)
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}

/// Interval of log lines if standard error is not a terminal.
const LOG_EVERY: Duration = Duration::from_secs(30);

/// Shows the progress of many runs, with their rate and an estimate: a bar on a terminal, an occasional line
/// in a log. Any thread may report.
pub(crate) struct Rate {
    label: String,
    started: Instant,
    shown: Mutex<Shown>,
}

struct Shown {
    bar: Option<ProgressBar>,
    logged: Instant,
}

impl Rate {
    pub(crate) fn new(label: impl Into<String>) -> Self {
        let now = Instant::now();
        Self { label: label.into(), started: now, shown: Mutex::new(Shown { bar: None, logged: now }) }
    }

    /// Records that `done` runs have ended, `found` existed before, and the total number.
    pub(crate) fn at(&self, done: u64, found: u64, total: u64) {
        let elapsed = self.started.elapsed();
        // A thread that finds it locked leaves the update to the next one.
        let Ok(mut shown) = self.shown.try_lock() else { return };
        if done == 0 || elapsed < PATIENCE {
            return;
        }
        let rate = done as f64 / elapsed.as_secs_f64();
        let left_s = total.saturating_sub(done + found) as f64 / rate;
        let text = format!(
            "{} of {total}, {} per second, {} left",
            done + found,
            plain(rate),
            with_unit(left_s.round(), "s")
        );
        if io::stderr().is_terminal() {
            let bar = shown.bar.get_or_insert_with(|| bar(&self.label, elapsed).with_style(rate_style()));
            bar.set_length(total);
            bar.set_position(done + found);
            bar.set_message(format!("{}: {text}", self.label));
        } else if shown.logged.elapsed() >= LOG_EVERY {
            shown.logged = Instant::now();
            stderr::complain(&format!("{}: {text}", self.label));
        }
    }

    /// Removes the bar.
    pub(crate) fn done(self) {
        if let Ok(Shown { bar: Some(bar), .. }) = self.shown.into_inner() {
            bar.finish_and_clear();
        }
    }
}

fn rate_style() -> ProgressStyle {
    ProgressStyle::with_template("[{bar:30}] {msg}").unwrap_or_else(|_| ProgressStyle::default_bar())
}

fn bar(label: &str, elapsed: Duration) -> ProgressBar {
    let bar = ProgressBar::new(STEPS).with_elapsed(elapsed).with_message(label.to_owned());
    match ProgressStyle::with_template("{msg} [{bar:40}] {percent} %, {eta} left") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// Shows the current step of work whose steps cannot be counted: a spinner with the time on a terminal, a
/// line for each step in a log.
pub(crate) struct Steps {
    label: String,
    started: Instant,
    bar: Option<ProgressBar>,
}

impl Steps {
    pub(crate) fn new(label: impl Into<String>) -> Self {
        let bar = io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::new_spinner();
            bar.enable_steady_tick(TICK);
            match ProgressStyle::with_template("{spinner} {msg}, {elapsed}") {
                Ok(style) => bar.with_style(style),
                Err(_) => bar,
            }
        });
        Self { label: label.into(), started: Instant::now(), bar }
    }

    /// Names the current step.
    pub(crate) fn at(&self, what: &str) {
        match &self.bar {
            Some(bar) => bar.set_message(format!("{}: {what}", self.label)),
            None => stderr::complain(&format!(
                "{}: {what} ({:.0} s)",
                self.label,
                self.started.elapsed().as_secs_f64()
            )),
        }
    }

    /// Removes the spinner.
    pub(crate) fn done(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Interval between the positions of a spinner.
const TICK: Duration = Duration::from_millis(120);
