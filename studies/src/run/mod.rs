//! Runs a scenario and reports what happened in it.
//!
//! ```
//! use feeler_files::Document;
//! use feeler_studies::run::{Outcome, run};
//!
//! let text = r#"
//! [bodies.tip]
//! mass = 2.0
//! [contacts.tool]
//! between = ["tip", "ground"]
//! stiffness = 1e4
//! damping = 200.0
//! [actuators.drive]
//! on = "tip"
//! reacts_on = "ground"
//! kind = "force"
//! [sensors.force]
//! reads = "tool.force"
//! [controllers.force]
//! law = "explicit-force"
//! reads = "force"
//! drives = "drive"
//! period = "1 ms"
//! feed_forward = 1.0
//! reference = 10.0
//! [run]
//! duration = 1.0
//! "#;
//! let document = Document::parse(text, "press.toml")?;
//! let result = run(&document.scenario, &mut |_| {})?;
//! assert_eq!(result.summary.outcome, Outcome::Settled);
//! assert!(result.summary.energy.is_some_and(|energy| energy.relative_residual < 1e-9));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod as_swept;
mod cell;
mod engine;
mod error;
mod measure;
mod record;
mod summary;
mod variants;
mod verdict;

use std::time::Instant;

use feeler_engine::{
    EnergyBalance, Observer, Peak, Program, RunEnd, RunSettings, Scenario, Simulation, Trace,
};
use feeler_lanes::Lane;
use feeler_lti::spectral::{AmplitudeSpectrum, Window, amplitude_spectrum};
use feeler_plant::assembly::Assembly;

pub use as_swept::run_as_swept;
pub use cell::{CellRun, CellSummary, LimitMet, run_cell};
pub use engine::simulation;
pub use error::RunError;
pub(crate) use error::system_error;
pub use measure::chatter::Oscillation;
pub use measure::contact::{ContactRun, Interval};
pub use measure::energy::{EnergyItem, EnergyTable};
pub use measure::force_loop::ForceLoop;
pub use measure::settling::{ForceResponse, Tracking};
pub(crate) use measure::standing::nothing_can_touch;
pub use record::event::EventRecord;
pub use record::recording::controlled;
pub use record::trace_file::{about_parquet, record_csv, write_csv, write_parquet};
pub use summary::{ContactSummary, Summary};
pub(crate) use variants::measure_resting;
pub use variants::{LANES, Measured, PreparedRun, measure};
pub use verdict::{MOST_EXTENSION, Outcome, RunVerdict, Undecided};

use measure::saturation::Limits;
use measure::standing::Standing;
use record::recording::{self, Recording};
use summary::{FinishedRun, SPECTRUM_ROWS};

/// Number of slices of a run, each followed by a progress report.
const SLICES: usize = 200;

/// Progress of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Simulated time reached, s.
    pub t_s: f64,
    /// Time at which it ends, s.
    pub duration_s: f64,
}

/// All results of a run.
#[derive(Clone, Debug)]
pub struct RunResult {
    /// The requested signals of the scenario, at its rate.
    pub trace: Trace,
    /// The record for the measures: those signals with contacts, drives, controllers and bodies, at the
    /// scenario's rate or more.
    pub record: Trace,
    /// Each contact with its intervals of pushing.
    pub contacts: Vec<ContactRun>,
    /// The force loop whose reference the measures refer to.
    pub force_loop: Option<ForceLoop>,
    /// Whether a drive or controller was at its limit, for each row of the record.
    pub saturated: Vec<bool>,
    /// Figures of the run.
    pub summary: Summary,
}

impl RunResult {
    /// Amplitude spectrum of the main contact's force over the tail of the run; `None` without a contact or a
    /// tail.
    pub fn tail_spectrum(&self) -> Option<AmplitudeSpectrum> {
        let contact = self.contacts.get(self.summary.main_contact?)?;
        let rows = self.tail_rows();
        let force = self.record.column(&contact.force_signal())?.get(rows)?;
        let period_s = self.record_spacing_s()?;
        amplitude_spectrum(force, period_s, Window::Hann).ok()
    }

    /// Rows of the record in the tail.
    pub fn tail_rows(&self) -> std::ops::Range<usize> {
        let end = self.record.t_s.len();
        let start = self.record.t_s.partition_point(|&t| t < self.summary.verdict.tail_s[0]);
        start.max(end.saturating_sub(SPECTRUM_ROWS))..end
    }

    fn record_spacing_s(&self) -> Option<f64> {
        let t = &self.record.t_s;
        Some((t.last()? - t.first()?) / (t.len().checked_sub(1).filter(|&n| n > 0)? as f64))
    }
}

/// Runs a scenario with its energy ledger, and calls `progress` from time to time; the calls do not change
/// the run. A motion too fast for the ledger is run again without it.
///
/// # Errors
/// A machine or wiring with mistakes, and exponentials that cannot be computed. A motion that diverges is a
/// result.
pub fn run(scenario: &Scenario, progress: &mut dyn FnMut(Progress)) -> Result<RunResult, RunError> {
    recorded(scenario, &Recording::new(scenario), Manner { energy: true, extends: false }, progress)
}

/// Runs a scenario once over the file's duration, without the energy ledger, with rows at the instants of a
/// sweep.
///
/// # Errors
/// As [`run`].
pub fn run_once(scenario: &Scenario) -> Result<RunResult, RunError> {
    let manner = Manner { energy: false, extends: false };
    recorded(scenario, &Recording::as_swept(scenario), manner, &mut |_| {})
}

/// Whether a run is measured with a ledger, and whether it is extended.
#[derive(Clone, Copy, Debug)]
struct Manner {
    /// Whether it keeps the energy ledger.
    energy: bool,
    /// Whether the run is extended until its outcome is decided.
    extends: bool,
}

fn recorded(
    scenario: &Scenario,
    recording: &Recording,
    Manner { energy, extends }: Manner,
    progress: &mut dyn FnMut(Progress),
) -> Result<RunResult, RunError> {
    let started = Instant::now();
    let settings = RunSettings { energy, ..recording.settings(&scenario.run) };
    let program = Program::new(&Scenario { run: settings, ..scenario.clone() })?;
    let assembly = program.motion().assembly().clone();
    let mut record = Trace::new(program.record_names());
    let mut simulation = simulation(program, scenario.machine.axis)?;
    let duration_s = scenario.run.duration_s;
    let mut until_s = duration_s;
    loop {
        advance(&mut simulation, &mut record, until_s, recording.rate_hz, progress)?;
        if simulation.outpaces_ledger(0) {
            let manner = Manner { energy: false, extends };
            let mut again = recorded(scenario, recording, manner, progress)?;
            again.summary.wall_s = started.elapsed().as_secs_f64();
            return Ok(again);
        }
        until_s *= 2.0;
        let is_longest = extends && until_s > MOST_EXTENSION * duration_s;
        recording::drop_undefined_rows(&mut record);
        let ended = Ended { is_longest, is_last: !extends, ..Ended::of(&simulation, 0) };
        let Judged { contacts, force_loop, limits, mut summary } =
            Judged::new(scenario, &assembly, &record, &ended, simulation.energy(0));
        if is_longest || !extends || !summary.verdict.may_be_decided() {
            summary.wall_s = started.elapsed().as_secs_f64();
            let trace = recording.wanted(&record);
            return Ok(RunResult {
                trace,
                record,
                contacts,
                force_loop,
                saturated: limits.saturated,
                summary,
            });
        }
    }
}

/// The end of a run, or its present state.
#[derive(Clone, Debug)]
struct Ended {
    end: Option<RunEnd>,
    /// Time that the motion reached, s.
    end_s: f64,
    /// Whether no further extension is possible.
    is_longest: bool,
    /// Whether this run is the last, without a longer one after it.
    is_last: bool,
    standing: Standing,
    /// Largest force of every stretch of contact, per contact; empty if the engine does not keep peaks.
    peaks: Vec<Vec<Peak>>,
    /// Zero if several variants ran side by side: their steps are counted together.
    steps: u64,
}

impl Ended {
    fn of<L: Lane>(simulation: &Simulation<L>, lane: usize) -> Self {
        let end = simulation.end(lane);
        let end_s = match end {
            Some(RunEnd::Diverged { t_s } | RunEnd::EventStorm { t_s }) => t_s,
            Some(RunEnd::Completed | RunEnd::Stopped { .. }) | None => simulation.time_s(),
        };
        Self {
            end,
            end_s,
            is_longest: false,
            is_last: false,
            standing: Standing::of(simulation, lane),
            peaks: simulation.peaks(lane),
            steps: if L::WIDTH == 1 { simulation.steps() } else { 0 },
        }
    }
}

/// A record with its evaluation.
#[derive(Clone, Debug)]
struct Judged {
    contacts: Vec<ContactRun>,
    force_loop: Option<ForceLoop>,
    limits: Limits,
    summary: Summary,
}

impl Judged {
    fn new(
        scenario: &Scenario,
        assembly: &Assembly,
        record: &Trace,
        ended: &Ended,
        energy: Option<EnergyBalance>,
    ) -> Self {
        let force_loop = ForceLoop::find(scenario);
        let contacts = measure::contact::contacts(scenario, assembly, record, &ended.peaks, ended.end_s);
        let limits = Limits::of(scenario, assembly, record);
        let finished = FinishedRun {
            scenario,
            assembly,
            record,
            contacts: &contacts,
            force_loop: force_loop.as_ref(),
            limits: &limits,
            end: ended.end,
            end_s: ended.end_s,
            is_longest: ended.is_longest,
            is_last: ended.is_last,
            standing: &ended.standing,
            steps: ended.steps,
            energy,
        };
        let summary = finished.summary();
        Self { contacts, force_loop, limits, summary }
    }
}

/// Runs to the end in slices that end at instants of the record, so slicing does not change any bit.
fn advance(
    simulation: &mut Simulation<f64>,
    observer: &mut impl Observer<f64>,
    duration_s: f64,
    rate_hz: f64,
    progress: &mut dyn FnMut(Progress),
) -> Result<(), RunError> {
    let rows = (duration_s * rate_hz).floor();
    for slice in 1..SLICES {
        let until_s = (rows * slice as f64 / SLICES as f64).floor() / rate_hz;
        if until_s > simulation.time_s() && until_s < duration_s {
            simulation.run_to(until_s, observer)?;
            progress(Progress { t_s: simulation.time_s(), duration_s });
        }
        if simulation.end(0).is_some_and(RunEnd::is_final) {
            return Ok(());
        }
    }
    simulation.run_to(duration_s, observer)?;
    progress(Progress { t_s: simulation.time_s(), duration_s });
    Ok(())
}
