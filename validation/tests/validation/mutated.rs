//! Files with a mistake, as a user's slip makes them, or with a number as extreme as "ideal" values often
//! are.
//!
//! Each case takes a file of the project, changes one to three of its tokens, and reads and runs the result
//! for ten milliseconds. A rejected file gives an error; nothing panics and nothing takes long.

use std::path::{Path, PathBuf};

use feeler_files::{CellFile, DatasetFile, Draft, SweepFile};
use feeler_studies::run::{run, run_cell};

/// Replacements of a number.
const NUMBERS: [&str; 22] = [
    "0",
    "-1",
    "1e-300",
    "1e300",
    "-1e300",
    "1e9",
    "1e-9",
    "1e12",
    "1e-12",
    "1e6",
    "1e-6",
    "inf",
    "-inf",
    "nan",
    "9223372036854775807",
    "true",
    "[]",
    "{}",
    "\"x\"",
    "\"1e9 Hz\"",
    "\"1e-9 ms\"",
    "\"1 kg\"",
];
/// Factors for the other half of the numbers.
const DECADES: [f64; 8] = [1e-6, 1e-3, 0.1, 0.5, 2.0, 10.0, 1e3, 1e6];
/// Setting of the simulated time.
const DURATION: &str = "run.duration=0.01";
/// Largest number of changed tokens in one file.
const CHANGES: u64 = 3;

/// Result of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fate {
    /// The file was refused, or the run was, with an error.
    Refused,
    Ran,
    /// The file was read, but cannot be run.
    Read,
}

/// A case: a file with mistakes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FuzzCase {
    pub(crate) number: u64,
    /// The original file.
    pub(crate) from: PathBuf,
    pub(crate) text: String,
}

/// Cases from the scenario, sweep and dataset files of a folder.
#[derive(Clone, Debug)]
pub(crate) struct Fuzz {
    files: Vec<(PathBuf, String)>,
}

impl Fuzz {
    /// The cases from all files below a folder.
    pub(crate) fn of(folder: &Path) -> Self {
        let mut files = Vec::new();
        gather(folder, &mut files);
        files.sort();
        Self { files }
    }

    /// Case `number`, always the same.
    pub(crate) fn case(&self, number: u64) -> FuzzCase {
        let mut draws = Draws(number.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x5DEE_CE66);
        let (from, text) = &self.files[draws.below(self.files.len() as u64)];
        let mut text = text.clone();
        for _ in 0..=draws.below(CHANGES) {
            text = changed(&text, &mut draws);
        }
        FuzzCase { number, from: from.clone(), text }
    }
}

impl FuzzCase {
    /// Reads and runs the case.
    pub(crate) fn run(&self) -> Fate {
        let name = self.from.display().to_string();
        let is = |what: &str| self.from.iter().any(|part| part == what);
        if is("datasets") {
            return DatasetFile::parse(&self.text, &name).map_or(Fate::Refused, |_| Fate::Read);
        }
        if is("sweeps") {
            return SweepFile::parse(&self.text, &name).map_or(Fate::Refused, |_| Fate::Read);
        }
        let Ok(mut draft) = Draft::parse(&self.text, &name) else { return Fate::Refused };
        if draft.set(DURATION).is_err() {
            return Fate::Refused;
        }
        if draft.has_arm() {
            let ran = CellFile::build(draft).ok().and_then(|file| run_cell(&file, &mut |_| {}).ok());
            return if ran.is_some() { Fate::Ran } else { Fate::Refused };
        }
        let ran = draft.build().ok().and_then(|document| run(&document.scenario, &mut |_| {}).ok());
        if ran.is_some() { Fate::Ran } else { Fate::Refused }
    }
}

fn gather(folder: &Path, files: &mut Vec<(PathBuf, String)>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            gather(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "toml")
            && let Ok(text) = std::fs::read_to_string(&path)
        {
            files.push((path, text));
        }
    }
}

/// A text with one token, line or end of it changed.
fn changed(text: &str, draws: &mut Draws) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let telling: Vec<usize> =
        (0..lines.len()).filter(|&i| !lines[i].trim().is_empty() && !lines[i].starts_with('#')).collect();
    if telling.is_empty() {
        return text.to_owned();
    }
    let at = telling[draws.below(telling.len() as u64)];
    match draws.below(16) {
        0 => drop(lines.remove(at)),
        1 => lines.insert(at, lines[at].clone()),
        2 => {
            let other = telling[draws.below(telling.len() as u64)];
            lines.swap(at, other);
        }
        3 => {
            let cut = lines[at].char_indices().map(|(i, _)| i).nth(draws.below(20)).unwrap_or(0);
            lines[at].truncate(cut);
        }
        4 => lines.truncate(at),
        _ => lines[at] = with_another_number(&lines[at], draws),
    }
    lines.join("\n") + "\n"
}

/// A line with one of its numbers replaced, sometimes without its unit.
fn with_another_number(line: &str, draws: &mut Draws) -> String {
    let starts: Vec<usize> = line
        .char_indices()
        .filter(|&(i, c)| {
            c.is_ascii_digit()
                && !line[..i]
                    .ends_with(|before: char| before.is_alphanumeric() || before == '.' || before == '_')
        })
        .map(|(i, _)| i)
        .collect();
    let Some(&start) = starts.get(draws.below(starts.len().max(1) as u64)) else {
        let (key, _) = line.split_once('=').unwrap_or((line, ""));
        return format!("{key}= {}", NUMBERS[draws.below(NUMBERS.len() as u64)]);
    };
    let length = line[start..]
        .find(|c: char| !(c.is_ascii_digit() || ".eE+-".contains(c)))
        .unwrap_or(line.len() - start);
    let (before, rest) = (&line[..start], &line[start + length..]);
    let written: Option<f64> = line[start..start + length].parse().ok().filter(|_| draws.below(2) == 0);
    let scaled = written.map(|number| format!("{:e}", number * DECADES[draws.below(DECADES.len() as u64)]));
    let number = scaled.as_deref().unwrap_or_else(|| NUMBERS[draws.below(NUMBERS.len() as u64)]);
    format!("{before}{number}{rest}")
}

/// A sequence of random numbers (`SplitMix64`).
struct Draws(u64);

impl Draws {
    fn below(&mut self, most: u64) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % most.max(1)) as usize
    }
}
