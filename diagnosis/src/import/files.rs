//! The files of a dataset.

use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::Path;

use feeler_logs::Series;

use crate::error::DiagnosisError;

/// A name without characters that are special in file systems.
pub(super) fn file_name(name: &str) -> String {
    let plain: String = name
        .chars()
        .map(|c| if c.is_alphanumeric() || matches!(c, '-' | '_' | '.') { c } else { '-' })
        .collect();
    let plain = plain.trim_matches(['-', '.']).to_owned();
    if plain.is_empty() { "joint".into() } else { plain }
}

fn unwritable(path: &Path) -> impl FnOnce(std::io::Error) -> DiagnosisError + use<> {
    let path = path.to_owned();
    move |source| DiagnosisError::Unwritable { problem: feeler_studies::unwritable(&path, &source) }
}

pub(super) fn create(folder: &Path) -> Result<(), DiagnosisError> {
    fs::create_dir_all(folder).map_err(unwritable(folder))?;
    let dataset = folder.join("dataset.toml");
    if dataset.exists() {
        return Err(DiagnosisError::Unreadable {
            file: dataset,
            reason: "there is a dataset already".into(),
            remedy: "name another folder with --out, or delete this one",
        });
    }
    Ok(())
}

pub(super) fn save(path: &Path, text: &str) -> Result<(), DiagnosisError> {
    fs::write(path, text).map_err(unwritable(path))
}

/// Writes a table; an empty cell is an unknown value.
pub(super) fn table(path: &Path, header: &[&str], series: &Series) -> Result<(), DiagnosisError> {
    let write = || {
        let mut file = BufWriter::with_capacity(1 << 18, File::create(path)?);
        writeln!(file, "t_s,{}", header.join(","))?;
        let mut line = String::new();
        for (k, t) in series.times_s.iter().enumerate() {
            line.clear();
            let _ = write!(line, "{t}");
            for values in &series.values {
                let value = values.get(k).copied().unwrap_or(f64::NAN);
                let _ = if value.is_finite() { write!(line, ",{value}") } else { write!(line, ",") };
            }
            line.push('\n');
            file.write_all(line.as_bytes())?;
        }
        file.flush()
    };
    write().map_err(unwritable(path))
}
