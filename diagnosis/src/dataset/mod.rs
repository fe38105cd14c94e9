//! Measured series: read from files, checked, and assigned to the signals of the believed machine.

mod bridge;
mod check;
mod compare;
mod consistency;
mod data;
mod effort;
pub(crate) mod fault;
mod fault_words;
pub(crate) mod laps;
mod lateness;
mod looped;
mod pieces;
mod quantum;
pub(crate) mod rattle;
mod read;
mod regrid;
mod scatter;
mod targets;
mod units;
mod work;

pub(crate) use bridge::breaks;
pub use data::{Channel, Dataset, Driven, Record};
pub use looped::Looped;
pub(crate) use quantum::quantum;

pub use fault::{Fault, FaultKind, Yardstick, in_words, problems};
pub(crate) use scatter::{noise_of_command, of_readings as scatter_of, rms};

use std::path::Path;

use feeler_files::{DatasetFile, ExperimentRole, followed_by};
use feeler_plant::assembly::{Source, resolve};
use feeler_plant::description::{Machine, Quantity};
use indexmap::IndexMap;

use crate::error::DiagnosisError;

impl Dataset {
    /// Reads a dataset folder (or its `dataset.toml`) and every series that it lists.
    ///
    /// # Errors
    /// Mistakes in the files, series that cannot be read, and faults of the series that no stated assumption
    /// can repair.
    pub fn load(path: &Path) -> Result<Self, DiagnosisError> {
        let file = DatasetFile::load(path)?;
        let machine = file.machine.scenario.machine.clone();
        let tolerance = file.machine.tolerance.clone();
        Self::of(&file, machine, tolerance)
    }

    /// Reads a dataset with another machine in place of the believed one.
    ///
    /// # Errors
    /// As [`Dataset::load`], and a column whose signal this machine does not have.
    pub fn load_for(path: &Path, machine: &Machine) -> Result<Self, DiagnosisError> {
        let file = DatasetFile::load(path)?;
        for (name, column) in &file.columns {
            if followed_by(&column.signal).is_some() {
                continue;
            }
            resolve(machine, &column.signal).map_err(|reason| DiagnosisError::Signal {
                column: name.clone(),
                signal: column.signal.to_string(),
                reason: reason.message,
                remedy: reason.remedy,
            })?;
        }
        Self::of(&file, machine.clone(), IndexMap::new())
    }

    fn of(
        file: &DatasetFile,
        machine: Machine,
        tolerance: IndexMap<String, f64>,
    ) -> Result<Self, DiagnosisError> {
        let mut dataset =
            Self { tolerance, ..Self::new(&file.name, machine, Vec::new(), Vec::new(), Vec::new()) };
        dataset.assign(file)?;
        let held: Vec<&str> = dataset.drives.iter().map(|driven| driven.column.as_str()).collect();
        let tables = file
            .experiments
            .iter()
            .map(|experiment| read::table(file, &experiment.file, &held))
            .collect::<Result<Vec<_>, _>>()?;
        let faults = check::assemble(&mut dataset, &file.experiments, tables);
        let (fatal, warnings): (Vec<Fault>, Vec<Fault>) =
            faults.into_iter().partition(|fault| fault.kind.is_fatal());
        if !fatal.is_empty() {
            return Err(DiagnosisError::Data { faults: fatal });
        }
        dataset.warnings = warnings;
        dataset.estimate_noise(file);
        let contradictions = consistency::check(&dataset, &file.columns);
        // If a wrong unit is reported, its effects on noise and resolution are not.
        dataset.warnings.retain(|fault| {
            let named = |other: &&Fault| {
                other.column == fault.column && matches!(other.kind, FaultKind::Units { .. })
            };
            let follows = matches!(
                fault.kind,
                FaultKind::BelowNoise { .. } | FaultKind::WeakExcitation { .. } | FaultKind::Quantised { .. }
            );
            !(follows && contradictions.iter().any(|other| named(&other)))
        });
        dataset.warnings.extend(contradictions);
        let roles: Vec<Option<ExperimentRole>> =
            file.experiments.iter().map(|experiment| experiment.role).collect();
        dataset.split(&roles);
        dataset.join();
        Ok(dataset)
    }

    /// Assigns the columns of a file to drives, loops and signals of the machine.
    fn assign(&mut self, file: &DatasetFile) -> Result<(), DiagnosisError> {
        let refused = |column: &str, reason: String, remedy: &str| DiagnosisError::Signal {
            column: column.to_owned(),
            signal: file.columns[column].signal.to_string(),
            reason,
            remedy: remedy.into(),
        };
        for (name, column) in &file.columns {
            let driven =
                |drive| Driven { drive, column: name.clone(), hold_s: column.hold_s, noise: column.noise };
            if let Some(controller) = followed_by(&column.signal) {
                let looped = Looped::of(&file.machine.scenario, &self.machine, controller);
                let looped = looped.ok_or_else(|| {
                    let reason = format!("it lacks what `{controller}` reads or drives");
                    refused(name, reason, "keep the names of sensors and actuators")
                })?;
                self.drives.push(driven(looped.drive));
                self.loops.push(looped);
                continue;
            }
            let Ok(source) = resolve(&self.machine, &column.signal) else { continue };
            if let Source::Drive(drive, Quantity::Command) = source {
                self.drives.push(driven(drive));
                continue;
            }
            let (noise, resolution) = match source {
                Source::Sensor(i) => {
                    let sensor = &self.machine.sensors[i];
                    (sensor.noise, sensor.resolution.unwrap_or(0.0))
                }
                _ => (0.0, 0.0),
            };
            self.channels.push(Channel {
                column: name.clone(),
                source,
                noise: column.noise.unwrap_or(noise),
                resolution: column.resolution.unwrap_or(resolution),
            });
        }
        let twice = (1..self.drives.len())
            .find(|&i| self.drives[..i].iter().any(|other| other.drive == self.drives[i].drive));
        twice.map_or(Ok(()), |i| {
            let remedy = "name one of the two: what the controller followed, or the command";
            Err(refused(&self.drives[i].column, "another column commands this drive already".into(), remedy))
        })
    }

    /// Estimates the noise from the scatter of the readings if neither the column nor its sensor states it,
    /// and adds a warning.
    fn estimate_noise(&mut self, file: &DatasetFile) {
        for c in 0..self.channels.len() {
            let channel = &self.channels[c];
            let is_stated = channel.noise > 0.0
                || file.columns.get(&channel.column).is_some_and(|column| column.noise.is_some());
            if is_stated || self.records.is_empty() {
                continue;
            }
            let scatter = scatter::of_channel(&self.records, c);
            // The scatter includes rounding to a stated resolution, which is accounted for separately.
            let noise = (scatter.powi(2) - channel.resolution.powi(2) / 12.0).max(0.0).sqrt();
            self.channels[c].noise = noise;
            self.warn_of_noise(self.channels[c].column.clone(), scatter);
        }
        // The noise of other commands does not count.
        let Some(first) = self.drives.first().filter(|first| first.noise.is_none()) else { return };
        let scatter = scatter::of_drive(&self.records, 0);
        if self.is_forced(first.drive) && scatter > 0.0 {
            self.warn_of_noise(first.column.clone(), scatter);
        }
    }

    fn warn_of_noise(&mut self, column: String, scatter: f64) {
        let kind = FaultKind::NoiseNotStated { scatter };
        self.warnings.push(Fault { file: self.name.clone(), column: Some(column), row: None, kind });
    }

    /// If no experiment is set aside for scoring, sets aside about every third, so that every kind of
    /// experiment is fitted and scored. Reports those whose stated role was `fit`.
    fn split(&mut self, roles: &[Option<ExperimentRole>]) {
        if self.records.iter().any(|record| record.is_check) || self.records.len() < 2 {
            return;
        }
        let kind = |record: &Record| record.engagement.map(|e| e as u8);
        let mut seen: Vec<(Option<u8>, usize)> = Vec::new();
        for i in 0..self.records.len() {
            let this = kind(&self.records[i]);
            let at = seen.iter().position(|(k, _)| *k == this).unwrap_or_else(|| {
                seen.push((this, 0));
                seen.len() - 1
            });
            seen[at].1 += 1;
            self.records[i].is_check = seen[at].1 % 3 == 2;
        }
        if !self.records.iter().any(|record| record.is_check)
            && let Some(last) = self.records.last_mut()
        {
            last.is_check = true;
        }
        for (record, role) in self.records.iter().zip(roles) {
            if record.is_check && role.is_some() {
                self.warnings.push(Fault {
                    file: record.name.clone(),
                    column: None,
                    row: None,
                    kind: FaultKind::SetAside,
                });
            }
        }
    }
}
