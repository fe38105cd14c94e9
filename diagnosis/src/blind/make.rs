//! Makes the cases: experiments with controllers in the loop, written as datasets.

use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use super::bench::{Bench, Hold, STEP_S, State, Truths};
use super::cases::{Case, case};
use super::noise::{Coloured, Random};
use super::seal::seal;

/// Folder of the datasets.
pub const CASES: &str = "cases";
/// Folder of the experiments that the diagnosis never sees.
pub const HELD_BACK: &str = "held-back";
/// File of the sealed truth.
pub const SEALED: &str = "truth.sealed";

/// Spacing of rows, s, and integration steps between rows.
const ROW_S: f64 = 5e-4;
const STEPS_PER_ROW: usize = 125;
/// Rows between samples of the controller.
const ROWS_PER_SAMPLE: usize = 2;
/// Standard deviation of each sample instant, s.
const JITTER_S: f64 = 8e-6;
/// Standard deviations of the sensors' white noise: encoder (m), accelerometers (m/s²), force (N).
const NOISE: [f64; 3] = [4e-7, 0.05, 0.12];
/// Additional coloured noise: ratio to the white noise, and correlation time, s.
const COLOURED_SHARE: f64 = 0.3;
const MEMORY_S: f64 = 4e-3;

/// The task of one experiment.
#[derive(Clone, Copy, Debug)]
enum Task {
    /// Random-phase sum of sines, force amplitude, band (Hz), while a weak spring holds the stroke.
    Sines { rms_n: f64, band_hz: [f64; 2] },
    /// Slow to-and-fro over the stroke under position control.
    Strokes { stroke_m: f64, period_s: f64 },
    /// Approach to the wall, then steps of force.
    Press { speed_m_per_s: f64, levels_n: [f64; 4] },
}

struct Experiment {
    name: String,
    hold: Hold,
    task: Task,
    seconds: f64,
    role: &'static str,
    repeat: bool,
}

/// Experiments of a case, and those that are held back.
fn experiments(random: &mut Random) -> (Vec<Experiment>, Vec<Experiment>) {
    let mut all = Vec::new();
    let mut add = |name: &str, hold, task, seconds, role, repeat| {
        all.push(Experiment { name: name.into(), hold, task, seconds, role, repeat });
    };
    let sines = |rms_n: f64, high: f64| Task::Sines { rms_n, band_hz: [0.8, high] };
    add("free-sines-1", Hold::Free, sines(18.0, 160.0), 2.0, "fit", false);
    add("free-sines-2", Hold::Free, sines(random.between(24.0, 32.0), 160.0), 2.0, "check", false);
    add("strokes-1", Hold::Free, Task::Strokes { stroke_m: 0.012, period_s: 1.1 }, 2.4, "fit", false);
    add(
        "strokes-2",
        Hold::Free,
        Task::Strokes { stroke_m: random.between(0.016, 0.022), period_s: 1.5 },
        2.4,
        "check",
        false,
    );
    add("clamped-1", Hold::Clamped, sines(14.0, 220.0), 1.8, "fit", false);
    add("clamped-2", Hold::Clamped, sines(30.0, 220.0), 1.8, "fit", false);
    add("clamped-3", Hold::Clamped, sines(random.between(18.0, 26.0), 220.0), 1.8, "check", false);
    let press = |speed: f64, levels_n| Task::Press { speed_m_per_s: speed, levels_n };
    add("press-1", Hold::Wall, press(0.03, [15.0, 30.0, 10.0, 40.0]), 2.5, "fit", true);
    add("press-2", Hold::Wall, press(0.03, [15.0, 30.0, 10.0, 40.0]), 2.5, "fit", true);
    add(
        "press-3",
        Hold::Wall,
        press(random.between(0.04, 0.06), [20.0, 45.0, 25.0, 12.0]),
        2.5,
        "check",
        false,
    );
    let mut held = Vec::new();
    let mut keep = |name: &str, hold, task, seconds| {
        held.push(Experiment { name: name.into(), hold, task, seconds, role: "check", repeat: false });
    };
    keep("free", Hold::Free, sines(random.between(20.0, 28.0), 120.0), 1.5);
    keep("strokes", Hold::Free, Task::Strokes { stroke_m: 0.015, period_s: random.between(1.2, 1.4) }, 2.0);
    keep("clamped", Hold::Clamped, sines(22.0, 180.0), 1.5);
    keep("press", Hold::Wall, press(random.between(0.03, 0.05), [18.0, 35.0, 22.0, 30.0]), 2.0);
    (all, held)
}

/// The law that makes commands from readings.
struct Controller {
    task: Task,
    sines: Vec<[f64; 3]>,
    is_touching: bool,
    touched_s: f64,
    integral: f64,
    /// Target position of the tool before contact, m.
    aim_m: f64,
    /// Reading of the force sensor before the first contact, N: the best available zero.
    rest_n: f64,
}

impl Controller {
    fn new(task: Task, random: &mut Random) -> Self {
        let mut sines = Vec::new();
        if let Task::Sines { rms_n, band_hz: [low, high] } = task {
            let mut hz = low;
            while hz < high {
                sines.push([hz, 0.0, random.between(0.0, std::f64::consts::TAU)]);
                hz += if hz < 20.0 { 1.3 } else { 4.7 };
            }
            let amplitude = rms_n * (2.0 / sines.len() as f64).sqrt();
            for sine in &mut sines {
                sine[1] = amplitude;
            }
        }
        Self { task, sines, is_touching: false, touched_s: 0.0, integral: 0.0, aim_m: 0.0, rest_n: f64::NAN }
    }

    /// The command at a sample.
    fn command(&mut self, t_s: f64, position_m: f64, speed: f64, force_n: f64, hold: Hold) -> f64 {
        let command = match self.task {
            Task::Sines { .. } => {
                let sum: f64 = self
                    .sines
                    .iter()
                    .map(|[hz, amplitude, phase]| {
                        amplitude * (std::f64::consts::TAU * hz * t_s + phase).sin()
                    })
                    .sum();
                if hold == Hold::Free { sum - 900.0 * position_m - 40.0 * speed } else { sum }
            }
            Task::Strokes { stroke_m, period_s } => {
                let omega = std::f64::consts::TAU / period_s;
                let wanted = 0.5 * stroke_m * (1.0 - (omega * t_s).cos());
                let moving = 0.5 * stroke_m * omega * (omega * t_s).sin();
                6000.0 * (wanted - position_m) + 420.0 * (moving - speed)
            }
            Task::Press { speed_m_per_s, levels_n } => {
                if self.rest_n.is_nan() {
                    self.rest_n = force_n;
                }
                if !self.is_touching && force_n - self.rest_n > TOUCH_N {
                    (self.is_touching, self.touched_s) = (true, t_s);
                }
                if self.is_touching {
                    let which = (((t_s - self.touched_s) / 0.5) as usize).min(levels_n.len() - 1);
                    let error = levels_n[which] - force_n;
                    self.integral =
                        (self.integral + 18.0 * error * ROW_S * ROWS_PER_SAMPLE as f64).clamp(-60.0, 60.0);
                    levels_n[which] + 0.25 * error + self.integral - 120.0 * speed
                } else {
                    self.aim_m += speed_m_per_s * ROW_S * ROWS_PER_SAMPLE as f64;
                    4000.0 * (self.aim_m - position_m) + 500.0 * (speed_m_per_s - speed)
                }
            }
        };
        // The converter has twelve bits over 800 N.
        (command.clamp(-390.0, 390.0) / CONVERTER_N).round() * CONVERTER_N
    }
}

/// Force above the reading at rest at which the wall counts as touched, N.
const TOUCH_N: f64 = 3.0;
/// Resolution of the command converter, N.
const CONVERTER_N: f64 = 0.2;

/// Rows of one experiment as CSV.
fn measure(bench: &Bench, experiment: &Experiment, random: &mut Random) -> String {
    let rows = (experiment.seconds / ROW_S) as usize;
    let mut controller = Controller::new(experiment.task, random);
    let mut state = State::default();
    let mut colours = vec![Coloured::new(MEMORY_S, ROW_S); 4];
    let mut seen = Truths::default();
    let mut last_encoder = 0.0;
    let mut command = 0.0;
    // Step indices at which commands arrive at the drive, with the commands.
    let mut arriving: Vec<(usize, f64)> = Vec::new();
    let mut at_drive = 0.0;
    let late_rows = bench.force_delay_s / ROW_S;
    let mut forces: Vec<f64> = Vec::with_capacity(rows);
    let mut text =
        String::from("t_s,command_n,encoder_m,motor_acceleration_mps2,tip_acceleration_mps2,force_n\n");
    let mut step = 0;
    for k in 0..rows {
        let mut noise = |channel: usize, sigma: f64, random: &mut Random| {
            sigma * (random.normal() + COLOURED_SHARE * colours[channel].next(random))
        };
        forces.push(seen.force_n);
        let force = late(&forces, late_rows);
        let quantised =
            |value: f64, step: f64| if step > 0.0 { (value / step).round() * step } else { value };
        let encoder = quantised(seen.encoder_m + noise(0, NOISE[0], random), bench.encoder_resolution);
        let motor = seen.motor_acceleration + noise(1, NOISE[1], random);
        let tip = seen.tip_acceleration + noise(2, NOISE[1], random);
        let force = quantised(bench.read_force(force) + noise(3, NOISE[2], random), bench.force_resolution);
        if k % ROWS_PER_SAMPLE == 0 {
            let speed = (encoder - last_encoder) / (ROW_S * ROWS_PER_SAMPLE as f64);
            last_encoder = encoder;
            command = controller.command(k as f64 * ROW_S, encoder, speed, force, experiment.hold);
            let jitter = (JITTER_S * random.normal().abs()).min(ROW_S);
            arriving.push((step + ((bench.drive_delay_s + jitter) / STEP_S).round() as usize, command));
        }
        let _ =
            writeln!(text, "{:.4},{command},{encoder:.8},{motor:.5},{tip:.5},{force:.5}", k as f64 * ROW_S);
        for _ in 0..STEPS_PER_ROW {
            while arriving.first().is_some_and(|(at, _)| *at <= step) {
                at_drive = arriving.remove(0).1;
            }
            seen = bench.step(&mut state, at_drive, experiment.hold);
            step += 1;
        }
    }
    text
}

/// A series some rows ago, interpolated between rows.
fn late(series: &[f64], rows: f64) -> f64 {
    let at = (series.len() - 1) as f64 - rows;
    if at <= 0.0 {
        return series[0];
    }
    let i = at.floor() as usize;
    let next = series[(i + 1).min(series.len() - 1)];
    series[i] + (at - i as f64) * (next - series[i])
}

const MACHINE: &str = include_str!("believed.toml");
const COLUMNS: &str = include_str!("columns.toml");

/// Writes `cases` cases: datasets, experiments held back, and the sealed truth. `progress` receives the
/// number of cases done.
///
/// # Errors
/// If a file cannot be written.
pub fn make(folder: &Path, cases: usize, seed: u64, progress: &(dyn Fn(usize) + Sync)) -> io::Result<()> {
    write_all(folder, cases, progress, |index| write_case(folder, index, seed))
}

/// Writes cases in parallel, and their sealed truth.
pub(super) fn write_all(
    folder: &Path,
    cases: usize,
    progress: &(dyn Fn(usize) + Sync),
    write_case: impl Fn(usize) -> io::Result<Case> + Sync,
) -> io::Result<()> {
    let done = AtomicUsize::new(0);
    let truth: Vec<Case> = (0..cases)
        .into_par_iter()
        .map(|index| {
            let case = write_case(index)?;
            progress(1 + done.fetch_add(1, Ordering::Relaxed));
            Ok(case)
        })
        .collect::<io::Result<_>>()?;
    let text = serde_json::to_string(&truth).map_err(io::Error::other)?;
    fs::write(folder.join(SEALED), seal(&text))
}

/// Writes one case and gives its truth.
///
/// # Errors
/// If a file cannot be written.
pub(crate) fn write_case(folder: &Path, index: usize, seed: u64) -> io::Result<Case> {
    let mut random = Random::new(seed.wrapping_mul(1_000_003).wrapping_add(index as u64));
    let (bench, case) = case(index, &mut random);
    let (shown, held) = experiments(&mut random);
    let groups = [shown, held].map(|group| {
        let sheet = |experiment: Experiment| {
            let engagement = match experiment.hold {
                Hold::Free => "free",
                Hold::Clamped => "clamped",
                Hold::Wall => "unilateral",
            };
            let repeat = if experiment.repeat { "repeat = \"press\"\n" } else { "" };
            Sheet {
                rows: measure(&bench, &experiment, &mut random),
                keys: format!("engagement = \"{engagement}\"\nrole = \"{}\"\n{repeat}", experiment.role),
                name: experiment.name,
            }
        };
        group.into_iter().map(sheet).collect()
    });
    write_datasets(folder, &case.case, COLUMNS, MACHINE, &groups)?;
    Ok(case)
}

/// An experiment in the form in which files hold it.
pub(super) struct Sheet {
    /// Name of the experiment and of its file.
    pub(super) name: String,
    /// Lines of the experiment's table in `dataset.toml` after the one with the file.
    pub(super) keys: String,
    /// Its rows as CSV.
    pub(super) rows: String,
}

/// Writes the datasets of a case, shown and held back, and the machine file beside the first. `columns` are
/// the tables of columns.
pub(super) fn write_datasets(
    folder: &Path,
    case: &str,
    columns: &str,
    machine: &str,
    groups: &[Vec<Sheet>; 2],
) -> io::Result<()> {
    let files = ["machine.toml".to_owned(), format!("../../{CASES}/{case}/machine.toml")];
    for ((group, sheets), file) in [CASES, HELD_BACK].iter().zip(groups).zip(files) {
        let folder = folder.join(group).join(case);
        fs::create_dir_all(&folder)?;
        let mut dataset = format!("name = \"{case}\"\nmachine = \"{file}\"\n\n{columns}");
        for Sheet { name, keys, rows } in sheets {
            fs::write(folder.join(format!("{name}.csv")), rows)?;
            let _ = write!(dataset, "\n[[experiments]]\nfile = \"{name}.csv\"\n{keys}");
        }
        fs::write(folder.join("dataset.toml"), dataset)?;
    }
    fs::write(folder.join(CASES).join(case).join("machine.toml"), machine)
}
