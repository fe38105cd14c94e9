//! Faulty records: each fault has its message, and other formats give the same message as CSV.

mod formats;
mod together;

use std::fmt::Write as _;
use std::fs;

use feeler_diagnosis::dataset::{Dataset, in_words};
use tempfile::TempDir;

const MACHINE: &str = r#"
[bodies.tip]
mass = 5.0
[springs.guide]
between = ["ground", "tip"]
damping = 60.0
[actuators.drive]
on = "tip"
reacts_on = "ground"
kind = "force"
[sensors.encoder]
reads = "tip.position"
noise = 1.0e-7
[sensors.accelerometer]
reads = "tip.acceleration"
noise = 0.01
"#;
const DATASET: &str = r#"
machine = "machine.toml"
[columns.command_n]
signal = "drive.command"
[columns.encoder_m]
signal = "encoder.reading"
[columns.acceleration_mps2]
signal = "accelerometer.reading"
"#;
const HEADER: [&str; 4] = ["t_s", "command_n", "encoder_m", "acceleration_mps2"];
const ROWS: usize = 2000;
const SPACING_S: f64 = 1e-3;

type Rows = Vec<[f64; 4]>;

/// A motion with known acceleration: sums of sines, with a little noise.
fn sound() -> Rows {
    let mut seed: u64 = 1;
    let mut noise = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let row = |k: usize| {
        let t = k as f64 * SPACING_S;
        let (mut x, mut a) = (0.0, 0.0);
        for (omega, size) in [(7.0_f64, 4e-3), (31.0, 1.3e-3), (83.0, 4e-4), (140.0, 2e-4)] {
            x += size * (omega * t + omega).sin();
            a -= size * omega * omega * (omega * t + omega).sin();
        }
        [t, 5.0 * a + 1.0, x + 1e-7 * noise(), a + 0.01 * noise()]
    };
    (0..ROWS).map(row).collect()
}

fn csv(rows: &Rows) -> String {
    let mut text = HEADER.join(",") + "\n";
    for row in rows {
        let _ = writeln!(text, "{}", row.map(|x| x.to_string()).join(","));
    }
    text
}

fn folder(files: &[(&str, &[u8])]) -> TempDir {
    let folder = TempDir::new().expect("a folder");
    fs::write(folder.path().join("machine.toml"), MACHINE).expect("it is written");
    let mut dataset = DATASET.to_owned();
    for (name, _) in files {
        let _ = write!(dataset, "\n[[experiments]]\nfile = \"{name}\"\n");
    }
    fs::write(folder.path().join("dataset.toml"), dataset).expect("it is written");
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).expect("it is written");
    }
    folder
}

/// The error or the warnings for two experiments; the first is faulty.
fn said_of(spoilt: &str) -> Result<String, String> {
    said_of_both(spoilt, &csv(&sound()))
}

fn said_of_both(a: &str, b: &str) -> Result<String, String> {
    let folder = folder(&[("a.csv", a.as_bytes()), ("b.csv", b.as_bytes())]);
    match Dataset::load(folder.path()) {
        Ok(dataset) => Ok(dataset.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")),
        Err(error) => Err(error.to_string()),
    }
}

fn spoil(change: impl Fn(usize, &mut [f64; 4])) -> String {
    let mut rows = sound();
    rows.iter_mut().enumerate().for_each(|(k, row)| change(k, row));
    csv(&rows)
}

fn error_says(spoilt: &str, words: &[&str]) {
    let said = said_of(spoilt).expect_err("an error");
    assert!(words.iter().all(|word| said.contains(word)), "{words:?} in: {said}");
}

fn warning_says(spoilt: &str, words: &[&str]) {
    let said = said_of(spoilt).expect("a warning");
    assert!(words.iter().all(|word| said.contains(word)), "{words:?} in: {said}");
}

#[test]
fn truth_sound_records_have_no_fault() {
    assert_eq!(said_of(&csv(&sound())), Ok(String::new()));
}

#[test]
fn truth_faults_that_nothing_mends_are_errors_with_place_and_remedy() {
    error_says(
        &csv(&sound()).replacen("acceleration_mps2", "other", 1),
        &["a.csv", "`acceleration_mps2`", "missing", "remove it from [columns]"],
    );
    error_says(
        &csv(&sound()).replacen("encoder_m", "encoder_m [m]", 1),
        &["a.csv: `encoder_m`", "rename `encoder_m [m]` to `encoder_m` in the file"],
    );
    error_says(
        &spoil(|k, row| row[2] = if (100..290).contains(&k) { f64::NAN } else { row[2] }),
        &["a.csv:102", "`encoder_m`", "no number", "190 such cells"],
    );
    let sound = csv(&sound());
    let row = sound.lines().nth(101).expect("a row");
    error_says(
        &sound.replacen(row, "0.1,1.0,oops,1.0", 1),
        &["a.csv:102", "`encoder_m`", "no number here (cut the file there"],
    );
    error_says(
        &spoil(|k, row| row[0] -= if k == 50 { 5e-3 } else { 0.0 }),
        &["a.csv:52", "does not advance", "clock"],
    );
    error_says(
        &spoil(|k, row| row[0] += if k >= 500 { 0.3 } else { 0.0 }),
        &["a.csv:502", "0.3000 s are missing", "split the file"],
    );
    error_says(&spoil(|_, row| row[1] = 3.0), &["`command_n`", "never changes", "excite the drive"]);
    error_says(&csv(&self::sound()[..20].to_vec()), &["only 20 rows", "at least 50"]);
    error_says("", &["a.csv: it is empty"]);
    error_says("\u{0}\u{1}not text", &["a.csv: it is not a text"]);
    error_says(
        &sound.replacen("encoder_m", "Encoder_m", 1),
        &["the file has `Encoder_m`", "rename `Encoder_m` to `encoder_m`"],
    );
    error_says("t_s,command_n,encoder_m,acceleration_mps2\n", &["no rows below the header", "at least 50"]);
}

#[test]
fn truth_faults_that_an_assumption_mends_are_warnings_that_state_it() {
    warning_says(
        &spoil(|_, row| row[3] = 0.5),
        &["`acceleration_mps2`", "never changes", "check the wiring"],
    );
    warning_says(
        &spoil(|_, row| row[3] = row[3].clamp(-1.0, 1.0)),
        &["`acceleration_mps2`", "rows sit at", "widen its range"],
    );
    warning_says(
        &spoil(|_, row| row[3] = (row[3] / 0.25).round() * 0.25),
        &["`acceleration_mps2`", "multiples of 0.250, coarser than believed"],
    );
    // A fast motion saturates the converter for a few rows at a time.
    warning_says(
        &spoil(|k, row| row[3] = if k % 40 < 3 { 9.0 } else { row[3] }),
        &["`acceleration_mps2`", "7.5 % of rows sit at 9 "],
    );
    warning_says(
        &spoil(|k, row| row[0] += if k % 2 == 0 { 1e-4 } else { 0.0 }),
        &["even spacing", "interpolation"],
    );
    warning_says(
        &spoil(|k, row| row[2] = if k == 100 { f64::NAN } else { row[2] }),
        &["a.csv:102: `encoder_m`: one cell is empty", "counts as unknown"],
    );
    warning_says(
        &spoil(|k, row| row[2] = if k % 500 == 100 { f64::NAN } else { row[2] }),
        &["a.csv:102: `encoder_m`: 4 cells are empty or NaN", "up to 1 together"],
    );
    warning_says(
        &spoil(|k, row| row[3] = 0.012 * (k as f64).sin()),
        &["`acceleration_mps2`", "times its noise", "excite more strongly"],
    );
}

/// A drive gives no more than its limit, whatever the command says.
#[test]
fn truth_commands_beyond_the_limit_of_the_drive_are_told() {
    let (limit_n, rows) = (20.0, sound());
    let text = csv(&rows);
    let folder = folder(&[("a.csv", text.as_bytes()), ("b.csv", text.as_bytes())]);
    let said = |limit_n: f64| {
        let limited = MACHINE.replace("kind = \"force\"", &format!("kind = \"force\"\nlimit = {limit_n}"));
        fs::write(folder.path().join("machine.toml"), limited).expect("it is written");
        in_words(&Dataset::load(folder.path()).expect("it loads").warnings).join("\n")
    };
    let beyond = |k: &usize| rows[*k][1].abs() > limit_n;
    let (first, count) = ((0..ROWS).find(beyond).expect("a row"), (0..ROWS).filter(beyond).count());
    let told = said(limit_n);
    // The header is row 1.
    let place = format!("a.csv:{}: `command_n`: {count} rows exceed the limit of the drive, 20", first + 2);
    assert!(told.starts_with(&place) && told.contains("as in another experiment"), "{told}");
    assert_eq!(said(1e3), "");
}

/// A simulated record may have only rounding of its numbers as scatter.
#[test]
fn regress_rounding_is_not_reported_as_noise() {
    let text = spoil(|k, row| row[2] = 4e-3 * (7.0 * k as f64 * SPACING_S).sin());
    let folder = folder(&[("a.csv", text.as_bytes()), ("b.csv", text.as_bytes())]);
    fs::write(folder.path().join("machine.toml"), MACHINE.replace("noise = 1.0e-7\n", ""))
        .expect("it is written");
    let dataset = Dataset::load(folder.path()).expect("it is read");
    let said = in_words(&dataset.warnings).join("\n");
    assert!(said.contains("`encoder_m`: no noise is stated, and its readings have none"), "{said}");
}

/// White noise on a command of some tens of newtons. Uniform noise between ±0.2 N has a standard
/// deviation of 0.4 / sqrt(12).
#[test]
fn regress_noise_of_a_command_that_is_not_stated_is_told() {
    let mut seed: u64 = 7;
    let mut rows = sound();
    for row in &mut rows {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        row[1] += 0.4 * ((seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5);
    }
    let text = csv(&rows);
    let folder = folder(&[("a.csv", text.as_bytes()), ("b.csv", text.as_bytes())]);
    let said = || in_words(&Dataset::load(folder.path()).expect("it is read").warnings).join("\n");
    let told = said();
    assert!(told.contains("`command_n`: no noise is stated") && told.contains("readings, 0.12"), "{told}");
    let path = folder.path().join("dataset.toml");
    let stated = fs::read_to_string(&path).expect("it is there");
    let stated = stated.replace("\"drive.command\"", "\"drive.command\"\nnoise = 0.115");
    fs::write(&path, stated).expect("it is written");
    assert_eq!(said(), "");
}

/// A missing column does not hide faults of other columns in its file.
#[test]
fn regress_a_missing_column_is_reported_beside_other_faults() {
    let spoilt = spoil(|k, row| {
        if (100..200).contains(&k) {
            row[3] = f64::NAN;
        }
    });
    error_says(
        &spoilt.replace("encoder_m", "position_m"),
        &["`encoder_m`: the column is missing", "`acceleration_mps2`: no number here"],
    );
}

/// Without noise in the machine file, it is estimated from the scatter of the readings: 0.01 m/s² on a motion
/// of 8 m/s² and more.
#[test]
fn regress_noise_that_is_not_stated_comes_from_the_records() {
    let text = csv(&sound());
    let folder = folder(&[("a.csv", text.as_bytes()), ("b.csv", text.as_bytes())]);
    fs::write(folder.path().join("machine.toml"), MACHINE.replace("noise = 0.01\n", ""))
        .expect("it is written");
    let dataset = Dataset::load(folder.path()).expect("it is sound");
    let said = dataset.warnings.iter().map(ToString::to_string).collect::<Vec<_>>();
    let [only] = said.as_slice() else { panic!("{said:?}") };
    assert!(
        only.contains("`acceleration_mps2`: no noise is stated") && only.contains("state `noise`"),
        "{only}"
    );
    assert!(!dataset.is_noise_stated("acceleration_mps2") && dataset.is_noise_stated("encoder_m"));
    // Uniform noise between ±0.005 has a standard deviation of 0.01 / sqrt(12). A median of 2000 rows
    // estimates it within a tenth.
    let sigma = 0.01 / 12.0_f64.sqrt();
    assert!((dataset.channels[1].noise / sigma - 1.0).abs() < 0.1, "{}", dataset.channels[1].noise);
}

/// Three lost rows, four empty cells of the encoder, and an accelerometer that reads only every fourth row.
#[test]
fn truth_rows_without_a_reading_are_unknown_to_the_diagnosis() {
    let rows = sound();
    let mut text = HEADER.join(",") + "\n";
    for (k, [t, u, x, a]) in rows.iter().enumerate().filter(|(k, _)| !(500..503).contains(k)) {
        let encoder = if (900..904).contains(&k) { String::new() } else { x.to_string() };
        let acceleration = if k % 4 == 0 { a.to_string() } else { String::new() };
        let _ = writeln!(text, "{t},{u},{encoder},{acceleration}");
    }
    let folder = folder(&[("a.csv", text.as_bytes())]);
    let dataset = Dataset::load(folder.path()).expect("it loads");
    let record = &dataset.records[0];
    assert_eq!(record.len(), ROWS);
    let unknown = |c: usize| (0..ROWS).filter(|&k| record.bridged[c][k]).collect::<Vec<_>>();
    assert_eq!(unknown(0), [500, 501, 502, 900, 901, 902, 903]);
    let between: Vec<usize> = (0..ROWS).filter(|k| k % 4 != 0 || *k == 500).collect();
    assert_eq!(unknown(1), between);
    let said = in_words(&dataset.warnings).join(
        "
",
    );
    assert!(
        said.contains("`encoder_m` has 1993 readings at 1000 Hz") && said.contains("4 rows bridged"),
        "{said}"
    );
    assert!(said.contains("3 rows (0.0030 s) are missing") && said.contains("count as unknown"), "{said}");
}

/// More cells are empty than a recorder loses, but never many in a row: the rows belong to other channels.
#[test]
fn truth_many_single_empty_cells_are_rows_without_a_reading() {
    let rows = sound();
    let mut text = HEADER.join(",") + "\n";
    let is_empty = |k: usize| k % 10 == 5 || k % 7 == 3;
    for (k, [t, u, x, a]) in rows.iter().enumerate() {
        let encoder = if is_empty(k) { String::new() } else { x.to_string() };
        let _ = writeln!(text, "{t},{u},{encoder},{a}");
    }
    let folder = folder(&[("a.csv", text.as_bytes())]);
    let dataset = Dataset::load(folder.path()).expect("it loads");
    let record = &dataset.records[0];
    assert_eq!(record.len(), ROWS);
    assert_eq!(record.bridged[0], (0..ROWS).map(is_empty).collect::<Vec<_>>());
    assert!(record.bridged[1].is_empty(), "the other channel has every reading");
}

#[test]
fn truth_a_clock_that_runs_fast_is_outvoted() {
    let (sound, fast) = (csv(&sound()), spoil(|_, row| row[0] *= 1.01));
    let folder =
        folder(&[("a.csv", fast.as_bytes()), ("b.csv", sound.as_bytes()), ("c.csv", sound.as_bytes())]);
    let said = Dataset::load(folder.path())
        .expect("it is loaded")
        .warnings
        .iter()
        .map(ToString::to_string)
        .collect::<Vec<_>>();
    let named =
        |line: &String| line.starts_with("a.csv: rows are 1.010 ms apart, in most experiments 1.000 ms");
    assert!(said.iter().any(named) && !said.iter().any(|line| line.starts_with("b.csv")), "{said:?}");
    // With two experiments it is unknown which clock is right.
    assert!(said_of(&fast).is_ok_and(|said| !said.contains("apart")));
}

#[test]
fn truth_what_experiments_share_is_told_once() {
    let coarse = spoil(|_, row| row[3] = (row[3] / 0.25).round() * 0.25);
    let folder =
        folder(&[("a.csv", coarse.as_bytes()), ("b.csv", coarse.as_bytes()), ("c.csv", coarse.as_bytes())]);
    let dataset = Dataset::load(folder.path()).expect("it is loaded");
    let said = in_words(&dataset.warnings);
    let [only] = said.as_slice() else { panic!("{said:?}") };
    assert!(
        only.starts_with("a.csv: `acceleration_mps2`") && only.contains(", as in 2 other experiments ("),
        "{only}"
    );
}

#[test]
fn truth_a_coarse_channel_at_rest_is_not_blamed_for_the_noise_that_it_rounds_away() {
    let coarse = |x: f64| (x / 0.25).round() * 0.25;
    let moving = spoil(|_, row| row[3] = coarse(row[3]));
    // At rest within half a step, all readings are zeros of either sign.
    let at_rest = spoil(|k, row| row[3] = if k % 3 == 0 { -0.0 } else { 0.0 });
    let said = said_of_both(&moving, &at_rest).expect("a warning");
    assert!(
        said.starts_with("a.csv") && said.contains("coarser than believed") && said.lines().count() == 1,
        "{said}"
    );
}

#[test]
fn truth_units_and_clocks_that_disagree_are_stated() {
    let metres_as_millimetres = spoil(|_, row| row[3] *= 1e3);
    warning_says(&metres_as_millimetres, &["`acceleration_mps2`", "`encoder_m`", "about 1000", "SI"]);
    let rows = sound();
    let late = spoil(|k, row| row[3] = rows[k.saturating_sub(6)][3]);
    warning_says(&late, &["`acceleration_mps2`", "behind `encoder_m`", "6.0"]);
}

/// Counts, opposite sign, an offset, and a column given by its number.
#[test]
fn truth_units_scale_and_offset_bring_numbers_to_the_signal() {
    let text = csv(&sound());
    let mut raw = "t_s,a,counts,c\n".to_owned();
    for [t, command, place, acceleration] in sound() {
        let _ = writeln!(raw, "{t},{},{},{}", -command, place * 1e3 * 4.0 + 8.0, acceleration);
    }
    let folder = folder(&[("a.csv", raw.as_bytes()), ("b.csv", raw.as_bytes())]);
    let file = folder.path().join("dataset.toml");
    let changed = fs::read_to_string(&file)
        .expect("it is there")
        .replace("\"drive.command\"\n", "\"drive.command\"\ncolumn = 2\nscale = -1\n")
        .replace(
            "[columns.encoder_m]\n",
            "[columns.counts]\nunit = \"mm\"\nscale = 0.25\noffset = \"-2 mm\"\n",
        )
        .replace("[columns.acceleration_mps2]\n", "[columns.c]\n");
    fs::write(&file, changed).expect("it is written");
    let dataset = Dataset::load(folder.path()).expect("it is loaded");
    let sound_folder = self::folder(&[("a.csv", text.as_bytes()), ("b.csv", text.as_bytes())]);
    let plain = Dataset::load(sound_folder.path()).expect("it is loaded");
    assert_eq!(dataset.records[0].commands, plain.records[0].commands);
    for (a, b) in dataset.records[0].series.iter().zip(&plain.records[0].series) {
        // Rounding errors of numbers up to 10.
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-13));
    }
}

#[test]
fn truth_files_that_are_not_what_they_say_are_named() {
    for name in ["a.mcap", "a.parquet"] {
        let folder = folder(&[(name, b"not a log"), ("b.csv", csv(&sound()).as_bytes())]);
        let said = Dataset::load(folder.path()).unwrap_err().to_string();
        assert!(said.contains(name), "{said}");
    }
}
