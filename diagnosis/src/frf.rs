//! Frequency responses from the records of a dataset.

use feeler_analysis::frf::FrfExperiment;
use feeler_files::DatasetFile;
use feeler_lti::spectral::{CrossSpectra, ResponseEstimate, WelchSettings, cross_spectra};
use feeler_plant::description::{Engagement, Quantity, SignalName};
use feeler_plant::names::did_you_mean;
use feeler_studies::Refusal;
use feeler_studies::frf::{
    Evaluated, FrequencyResponse, FrfError, FrfRequest, RecordPair, SEGMENTS, Separated, between,
    choose as choose_method, evaluate, require, require_path, sensed,
};
use feeler_studies::numbers::{count, plain};

use crate::dataset::{Dataset, Fault, Record};

/// Share of the command's power within the default band.
const POWER: f64 = 0.995;
/// Smallest ratio of the command's power at a frequency to its largest power. Below it a response would be a
/// ratio of noise.
const LEAST_POWER: f64 = 1e-4;

/// Number of frequencies on each side that decide whether a frequency is kept.
const NEIGHBOURS: usize = 10;
/// A response at fewer frequencies is drawn as points, because a line would hide the gaps between them.
const FEW: usize = 100;

/// The part of a dataset that is analysed.
struct Chosen<'a> {
    input: String,
    drive: usize,
    output: String,
    signal: SignalName,
    series: usize,
    records: Vec<&'a Record>,
}

/// The response between two columns of a dataset, and the linear response of its machine. Options of the
/// request that define an excitation are ignored.
///
/// # Errors
/// If the records cannot meet the request, or linear theory does not apply to the machine.
pub fn measured_response(
    file: &DatasetFile,
    data: &Dataset,
    request: &FrfRequest,
) -> Result<FrequencyResponse, FrfError> {
    let mut notes: Vec<String> = Vec::new();
    let chosen = choose(request, file, data, &mut notes)?;
    notes.extend(warnings(data, &chosen.records));
    let first = chosen.records[0];
    let spacing_s = first.spacing_s;
    let length_s = chosen.records.iter().map(|r| r.len()).min().unwrap_or(0) as f64 * spacing_s;
    let pairs: Vec<RecordPair> = chosen
        .records
        .iter()
        .map(|r| (centred(&r.commands[chosen.drive]), centred(&r.series[chosen.series])))
        .collect();
    let choice = choose_method(request, &pairs, spacing_s, length_s)?;
    let is_of_lines = choice.method.is_of_lines();
    notes.extend(choice.why.clone());
    let command = if is_of_lines { None } else { command_spectra(&first.commands[chosen.drive], spacing_s) };
    let band_hz = request.band(spacing_s, 2.0 / length_s, command.as_ref().and_then(excited_hz))?;
    let mut found = evaluate(&choice, &pairs, spacing_s, band_hz)?;
    require(
        !found.estimate.frequencies_hz.is_empty(),
        || format!("the command excites nothing between {} and {} Hz", plain(band_hz.0), plain(band_hz.1)),
        "name another band with --from and --to, other experiments, or leave --period and --excitation out",
    )?;
    drop_unknown(request, &mut found, is_of_lines, command.as_ref(), &mut notes)?;
    let estimate = found.estimate;
    let isolated = found.isolated || estimate.frequencies_hz.len() < FEW;

    let engagement = first.engagement.unwrap_or(Engagement::Unilateral);
    let mut machine = data.machine.clone();
    for contact in machine.contacts.values_mut() {
        contact.engagement = first.engagement.unwrap_or(contact.engagement);
    }
    if engagement == Engagement::Unilateral && !machine.contacts.is_empty() {
        notes.push(
            "the tool may leave the workpiece in these records; the linear response takes it as \
                    touching all the time"
                .to_owned(),
        );
    }
    let actuator =
        machine.actuators.get_index(chosen.drive).map(|(name, _)| name.clone()).unwrap_or_default();
    // The overlay holds every recorded command until the next row, whatever the controller's period.
    let experiment = FrfExperiment {
        machine,
        actuator,
        output: chosen.signal.clone(),
        hold_s: spacing_s,
        offset: 0.0,
        seed: 0,
    };
    require_path(&experiment, band_hz, &chosen.input)?;
    let linear = experiment.linear_response(&estimate.frequencies_hz)?;
    let between_hz = between(&estimate.frequencies_hz, isolated);
    let filled = experiment.linear_response(&between_hz)?;
    let names: Vec<&str> = chosen.records.iter().map(|r| r.name.as_str()).collect();
    Ok(FrequencyResponse {
        title: data.name.clone(),
        about: file.about.clone(),
        input: chosen.input,
        output: chosen.output,
        reads: sensed(&data.machine, &chosen.signal),
        how: format!("measured: {}; {}", names.join(", "), found.how),
        notes,
        hold_s: spacing_s,
        estimate,
        linear,
        isolated,
        between: between_hz.into_iter().zip(filled).collect(),
        separated: found.separated,
        confidence: request.confidence,
    })
}

/// Warnings of the dataset's check for these experiments, and the number of warnings for others.
fn warnings(data: &Dataset, looked_at: &[&Record]) -> Vec<String> {
    let is_of_others =
        |file: &str| data.records.iter().any(|r| r.name == file) && !looked_at.iter().any(|r| r.name == file);
    let (others, own): (Vec<&Fault>, Vec<&Fault>) =
        data.warnings.iter().partition(|fault| is_of_others(&fault.file));
    let mut said: Vec<String> = own.into_iter().map(Fault::to_string).collect();
    said.extend(
        (!others.is_empty())
            .then(|| count(others.len(), "remark", "remarks"))
            .map(|remarks| format!("`feeler check` has {remarks} on the other experiments")),
    );
    said
}

fn choose<'a>(
    request: &FrfRequest,
    file: &DatasetFile,
    data: &'a Dataset,
    notes: &mut Vec<String>,
) -> Result<Chosen<'a>, FrfError> {
    let of_column = |column: &str| file.columns.get(column).map(|c| c.signal.to_string()).unwrap_or_default();
    let commands: Vec<(usize, &str)> = data
        .drives
        .iter()
        .filter(|driven| !data.is_looped(driven.drive))
        .map(|driven| (driven.drive, driven.column.as_str()))
        .collect();
    let named = |wanted: &str, column: &str| wanted == column || wanted == of_column(column);
    let input = match &request.input {
        None => commands.first().copied(),
        Some(wanted) => Some(
            commands
                .iter()
                .copied()
                .find(|(_, c)| named(wanted, c))
                .ok_or_else(|| unknown("input", wanted, commands.iter().map(|c| c.1)))?,
        ),
    };
    let Some((drive, column)) = input else {
        return Err(Refusal::new(
            "the dataset has no command of a drive",
            "record one, and name it in [columns]",
        )
        .into());
    };
    let outputs: Vec<&str> = data.channels.iter().map(|c| c.column.as_str()).collect();
    let series = if let Some(wanted) = &request.output {
        outputs
            .iter()
            .position(|c| named(wanted, c))
            .ok_or_else(|| unknown("output", wanted, outputs.iter().copied()))?
    } else {
        let is = |i: &usize, quantity| data.channels[*i].quantity(&data.machine) == quantity;
        let named =
            request.experiments.first().and_then(|wanted| data.records.iter().find(|r| r.name == *wanted));
        let free = named.or(data.records.first()).is_some_and(|r| r.engagement == Some(Engagement::Free));
        let wanted = if free { Quantity::Acceleration } else { Quantity::SpringForce };
        (0..outputs.len()).rev().find(|i| is(i, wanted)).unwrap_or(0)
    };
    let Some(signal) = outputs.get(series).and_then(|c| file.columns.get(*c)).map(|c| c.signal.clone())
    else {
        return Err(Refusal::new(
            "the dataset has nothing but commands",
            "record an output, and name it in [columns]",
        )
        .into());
    };
    let all = || data.records.iter().map(|r| r.name.as_str());
    let mut records = Vec::new();
    for wanted in &request.experiments {
        records.push(
            data.records
                .iter()
                .find(|r| r.name == *wanted)
                .ok_or_else(|| unknown("experiment", wanted, all()))?,
        );
    }
    if records.is_empty() {
        records.extend(data.records.first());
        notes.push(format!(
            "the first of {} experiments; --experiment names others, several are averaged",
            data.records.len()
        ));
    }
    let Some(first) = records.first() else {
        return Err(Refusal::new("the dataset has no experiment", "add one as [[experiments]]").into());
    };
    let alike = |r: &&Record| {
        r.engagement == first.engagement && (r.spacing_s - first.spacing_s).abs() < 1e-9 * first.spacing_s
    };
    require(
        records.iter().all(alike),
        || {
            "these experiments differ in engagement or sample time, so they have no response in common"
                .to_owned()
        },
        "average only experiments that are alike",
    )?;
    let (input, output) = (of_column(column), signal.to_string());
    Ok(Chosen { input, drive, output, signal, series, records })
}

/// Power spectrum of a command; `None` if the record is too short.
fn command_spectra(command: &[f64], spacing_s: f64) -> Option<CrossSpectra> {
    let settings = WelchSettings::hann((command.len() as f64 / SEGMENTS) as usize);
    cross_spectra(command, command, spacing_s, &settings).ok()
}

/// Frequency below which nearly all power of a command lies; above it a response would be a ratio of noise.
fn excited_hz(spectra: &CrossSpectra) -> Option<f64> {
    let whole: f64 = spectra.input.iter().sum();
    let mut below = 0.0;
    let last = spectra.input.iter().position(|power| {
        below += power;
        below >= POWER * whole
    })?;
    Some(spectra.frequencies_hz[last])
}

/// Whether the command excites each frequency: its power is at least [`LEAST_POWER`] of the largest.
fn powered(frequencies_hz: &[f64], spectra: Option<&CrossSpectra>) -> Vec<bool> {
    let Some(spectra) = spectra else { return vec![true; frequencies_hz.len()] };
    let strongest = spectra.input.iter().copied().fold(0.0, f64::max);
    let power = |f: f64| {
        let after = spectra.frequencies_hz.partition_point(|&line| line < f);
        // The larger power of both neighbours, because a line of a multisine may lie between them.
        [after.saturating_sub(1), after]
            .into_iter()
            .filter_map(|i| spectra.input.get(i))
            .copied()
            .fold(0.0, f64::max)
    };
    frequencies_hz.iter().map(|&f| power(f) >= LEAST_POWER * strongest).collect()
}

/// Drops frequencies without power in the command, and those whose phase is unknown.
fn drop_unknown(
    request: &FrfRequest,
    found: &mut Evaluated,
    of_lines: bool,
    command: Option<&CrossSpectra>,
    notes: &mut Vec<String>,
) -> Result<(), FrfError> {
    let all = found.estimate.frequencies_hz.len();
    let powered = powered(&found.estimate.frequencies_hz, command);
    let without_power = powered.iter().filter(|powered| !**powered).count();
    keep(&mut found.estimate, found.separated.as_mut(), &powered);
    let bands = found.estimate.confidence(request.confidence);
    let known: Vec<bool> =
        bands.iter().map(|band| band.phase_half_width_rad < std::f64::consts::PI).collect();
    let unknown = known.iter().filter(|known| !**known).count();
    // Of many frequencies without information some appear known by chance.
    let carried = if of_lines { known.clone() } else { carried(&known) };
    let by_chance =
        known.iter().filter(|known| **known).count() - carried.iter().filter(|carried| **carried).count();
    keep(&mut found.estimate, found.separated.as_mut(), &carried);
    let mut left_out = |count: usize, why: &str| {
        if count > 0 {
            notes.push(format!("{count} of {all} frequencies are left out: {why}"));
        }
    };
    left_out(without_power, "the command has next to no power there");
    left_out(unknown, "other inputs to the machine outweigh the command there, so even the phase is unknown");
    left_out(
        by_chance,
        "the response is unknown at most neighbouring frequencies, so these values are due to chance",
    );
    if found.estimate.frequencies_hz.is_empty() {
        return Err(FrfError::Source(Refusal::new(
            format!("no response is known at any of {all} frequencies from these records"),
            "name other experiments, another output or another band; feeler frf needs a command that \
             excites the machine",
        )));
    }
    Ok(())
}

/// The known frequencies for which at least half of the neighbours are known too.
fn carried(known: &[bool]) -> Vec<bool> {
    let about = |i: usize| &known[i.saturating_sub(NEIGHBOURS)..(i + NEIGHBOURS + 1).min(known.len())];
    let most = |part: &[bool]| 2 * part.iter().filter(|known| **known).count() >= part.len();
    (0..known.len()).map(|i| known[i] && most(about(i))).collect()
}

/// Drops the frequencies that are not kept.
fn keep(estimate: &mut ResponseEstimate, separated: Option<&mut Separated>, kept: &[bool]) {
    fn of<T>(values: &mut Vec<T>, kept: &[bool]) {
        let mut kept = kept.iter();
        values.retain(|_| kept.next().is_none_or(|kept| *kept));
    }
    of(&mut estimate.frequencies_hz, kept);
    of(&mut estimate.response, kept);
    of(&mut estimate.variance, kept);
    of(&mut estimate.degrees_of_freedom, kept);
    if let Some(coherence) = &mut estimate.coherence {
        of(coherence, kept);
    }
    separated
        .into_iter()
        .flat_map(|levels| [&mut levels.noise, &mut levels.distortion])
        .for_each(|variance| of(variance, kept));
}

/// A record without its mean: the operating point is not part of a response.
fn centred(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|v| v - mean).collect()
}

fn unknown<'a>(what: &str, wanted: &str, known: impl Iterator<Item = &'a str>) -> Refusal {
    Refusal::new(format!("the dataset has no {what} `{wanted}`"), did_you_mean(wanted, known))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_frequencies_that_are_known_by_chance_do_not_count() {
        // Up to index 300 nearly all are known; beyond, one in thirty is.
        let known: Vec<bool> = (0..1000).map(|i| if i < 300 { i % 29 != 7 } else { i % 30 == 3 }).collect();
        let kept = carried(&known);
        assert!((0..295).all(|i| kept[i] == known[i]));
        assert!(kept[310..].iter().all(|kept| !kept));
    }
}
