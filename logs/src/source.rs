//! From paths to runs: files that belong together.

use std::fs;
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use crate::agreement;
use crate::clock::ClockUnit;
use crate::error::LogError;
use crate::kind::{self, Format};
use crate::table::{Run, Table};
use crate::topics::Topics;
use crate::{arrays, bag, csv, lerobot, mcap, parquet};

/// A bag has fewer channels than this, so that files of one bag stay separate.
const CHANNELS: u64 = 1 << 32;
/// Bytes of a header by which texts are compared, at most.
const LONGEST_HEADER: u64 = 1 << 20;
/// Endings of files that were compressed as a whole.
const PACKED: [&str; 2] = ["zstd", "zst"];
/// Largest depth of folders in the search for logs.
const MOST_DEEP: usize = 3;

/// A unit of reading: files that belong to one log.
#[derive(Clone, Debug, PartialEq)]
pub struct LogSource {
    /// Files that belong together.
    pub files: Vec<PathBuf>,
    pub format: Format,
    clock: Option<ClockUnit>,
    name: String,
    lerobot: Option<PathBuf>,
}

/// The sources at paths of files and folders, in order.
///
/// # Errors
/// A path that cannot be opened or is not a log, or a folder without logs.
pub fn sources(paths: &[&Path]) -> Result<Vec<LogSource>, LogError> {
    let mut found = Vec::new();
    let mut texts = Vec::new();
    for path in paths {
        let state = fs::metadata(path).map_err(LogError::open(path))?;
        if state.is_dir() {
            let before = found.len();
            folder(path, 0, &mut found)?;
            if found.len() == before {
                let what = "this folder holds no log";
                let remedy = "name a folder with MCAP, ROS 2 bag, Parquet, npz, npy or CSV files";
                return Err(LogError::other(path, what, remedy));
            }
        } else if !state.is_file() {
            return Err(LogError::other(path, "it is not a regular file", "name a file or a folder"));
        } else {
            match kind::of(path)? {
                Format::Csv => texts.push((*path).to_owned()),
                format => found.push(LogSource::of(path, format)),
            }
        }
    }
    found.extend(together(texts, None));
    Ok(found)
}

/// Reads the runs of one file, or of its data set.
///
/// # Errors
/// As [`sources`] and [`LogSource::read`].
pub fn read_file(path: &Path, clock: Option<ClockUnit>) -> Result<Vec<Run>, LogError> {
    let state = fs::metadata(path).map_err(LogError::open(path))?;
    if state.is_dir() {
        let mut runs = Vec::new();
        for source in sources(&[path])? {
            runs.extend(LogSource { clock, ..source }.read()?);
        }
        return Ok(runs);
    }
    if !state.is_file() {
        return Err(LogError::other(path, "it is not a regular file", "name a file or a folder"));
    }
    LogSource { clock, ..LogSource::of(path, kind::of(path)?) }.read()
}

impl LogSource {
    /// The same with a known unit of its clocks, which overrides that of the files.
    #[must_use]
    pub fn with_clock(self, clock: Option<ClockUnit>) -> Self {
        Self { clock, ..self }
    }

    fn of(path: &Path, format: Format) -> Self {
        let lerobot = if format == Format::Parquet { lerobot::folder_of(path) } else { None };
        Self { files: vec![path.to_owned()], format, clock: None, name: name_of(path), lerobot }
    }

    /// Reads everything.
    ///
    /// # Errors
    /// A damaged file, with the byte or row. So is one whose clock has a cell without a number.
    pub fn read(&self) -> Result<Vec<Run>, LogError> {
        let runs = self.runs()?;
        let mut tables = runs.iter().flat_map(|run| &run.tables);
        tables.find_map(Table::without_time).map_or(Ok(runs), Err)
    }

    fn runs(&self) -> Result<Vec<Run>, LogError> {
        match self.format {
            Format::Mcap | Format::Sqlite => self.bag(),
            Format::Npy => Ok(vec![arrays::npy(&self.files[0], self.clock)?]),
            Format::Npz => Ok(vec![arrays::npz(&self.files[0], self.clock)?]),
            Format::Parquet => {
                let run = parquet::read(&self.files[0], self.clock)?;
                match &self.lerobot {
                    Some(folder) => lerobot::episodes(run, folder),
                    None => Ok(vec![run]),
                }
            }
            Format::Csv => {
                let mut run = Run { name: self.name.clone(), ..Run::default() };
                for file in &self.files {
                    let mut one = csv::read(file, self.clock)?;
                    run.tables.append(&mut one.tables);
                    run.notes.append(&mut one.notes);
                }
                agreement::agree(&mut run.tables);
                Ok(vec![run])
            }
        }
    }

    fn bag(&self) -> Result<Vec<Run>, LogError> {
        let mut topics = Topics::default();
        for (i, file) in self.files.iter().enumerate() {
            let base = i as u64 * CHANNELS;
            match kind::of(file)? {
                Format::Sqlite => bag::read(file, &mut topics, base)?,
                _ => mcap::read(file, &mut topics, base)?,
            }
        }
        Ok(vec![topics.into_run(&self.files[0], self.name.clone())])
    }
}

/// The ending of a name, in lower case; that of a packed file is that of its content.
fn ending(path: &Path) -> String {
    let of = |path: &Path| path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    match of(path) {
        Some(packed) if PACKED.contains(&packed.as_str()) => {
            path.file_stem().and_then(|stem| of(stem.as_ref()))
        }
        ending => ending,
    }
    .unwrap_or_default()
}

fn name_of(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    let is_packed = path.extension().is_some_and(|ending| PACKED.iter().any(|packed| ending == *packed));
    let inner = Path::new(stem).file_stem().filter(|_| is_packed);
    inner.unwrap_or(stem).to_string_lossy().into_owned()
}

/// Searches a folder for logs: those of one bag or of one run are one source.
fn folder(path: &Path, depth: usize, found: &mut Vec<LogSource>) -> Result<(), LogError> {
    // A dataset among logs was made from them.
    if depth > 0 && path.join("dataset.toml").exists() {
        return Ok(());
    }
    if lerobot::is_one(path) {
        found.extend(lerobot::files(path)?.iter().map(|file| LogSource::of(file, Format::Parquet)));
        return Ok(());
    }
    let mut entries: Vec<PathBuf> =
        fs::read_dir(path).map_err(LogError::open(path))?.filter_map(Result::ok).map(|e| e.path()).collect();
    entries.sort_by_key(|entry| natural(&entry.to_string_lossy()));
    let is_bag = entries.iter().any(|entry| entry.file_name().is_some_and(|name| name == "metadata.yaml"));
    let mut bag = Vec::new();
    let mut texts = Vec::new();
    for entry in &entries {
        if entry.is_dir() {
            if depth < MOST_DEEP {
                folder(entry, depth + 1, found)?;
            }
            continue;
        }
        match ending(entry).as_str() {
            "mcap" | "db3" if is_bag => bag.push(entry.clone()),
            "mcap" | "db3" | "parquet" | "npz" | "npy" => found.push(LogSource::of(entry, kind::of(entry)?)),
            "csv" | "tsv" | "dat" => texts.push(entry.clone()),
            _ => {}
        }
    }
    if let Some(first) = bag.first() {
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let mut source = LogSource::of(first, kind::of(first)?);
        (source.files, source.name) = (bag, name);
        found.push(source);
    }
    found.extend(together(texts, Some(path)));
    Ok(())
}

/// Tables of text: those with equal headers are separate runs, those with different ones are one run.
fn together(texts: Vec<PathBuf>, folder: Option<&Path>) -> Vec<LogSource> {
    let heads: Vec<Vec<u8>> = texts.iter().map(|path| first_line(path).unwrap_or_default()).collect();
    let are_alike = heads.windows(2).any(|pair| pair[0] == pair[1]);
    if texts.len() < 2 || are_alike {
        return texts.iter().map(|path| LogSource::of(path, Format::Csv)).collect();
    }
    let name = folder.and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
    let name = name.unwrap_or_else(|| name_of(&texts[0]));
    vec![LogSource { files: texts, format: Format::Csv, clock: None, name, lerobot: None }]
}

fn first_line(path: &Path) -> io::Result<Vec<u8>> {
    let mut line = Vec::new();
    BufReader::new(fs::File::open(path)?).take(LONGEST_HEADER).read_until(b'\n', &mut line)?;
    Ok(line)
}

/// A key that sorts numbers in names by value: `bag_2` before `bag_10`.
fn natural(name: &str) -> Vec<(String, u64)> {
    let mut parts = Vec::new();
    let mut rest = name;
    while !rest.is_empty() {
        let digits = rest.find(|c: char| c.is_ascii_digit()).unwrap_or(rest.len());
        let end = rest[digits..].find(|c: char| !c.is_ascii_digit()).map_or(rest.len(), |at| digits + at);
        parts.push((rest[..digits].to_owned(), rest[digits..end].parse().unwrap_or(u64::MAX)));
        rest = &rest[end..];
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_numbers_in_names_are_in_order() {
        let mut names = ["bag_10.db3", "bag_2.db3", "a"];
        names.sort_by_key(|name| natural(name));
        assert_eq!(names, ["a", "bag_2.db3", "bag_10.db3"]);
    }
}
