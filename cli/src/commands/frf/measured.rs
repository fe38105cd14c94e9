//! Records of a dataset.

use feeler_analysis::frf::{Experiment, NoiseMethod, response_from_noise};
use feeler_diagnosis::DiagnosisError;
use feeler_diagnosis::dataset::{Dataset, Record};
use feeler_lti::spectral::{
    CrossSpectra, Estimator, LocalPolynomialSettings, Realisation, ResponseEstimate, WelchSettings, best_linear_approximation,
    cross_spectra, periodic_response, smoothed_spectra,
};
use feeler_plant::description::{Engagement, Quantity, SignalName};
use feeler_plant::names::did_you_mean;
use feeler_scenarios::format::DatasetFile;

use super::{Response, band, estimator, refused, require, require_segments};
use crate::arguments::{EstimatorKind, ExcitationKind, Frf};
use crate::failure::BadInput;
use crate::numbers::with_unit;

/// Segments of which averaged spectra are formed where no length is given.
const SEGMENTS: f64 = 8.0;
/// Share of the command's power within the band that is looked at unless another is asked for.
const POWER: f64 = 0.995;
/// Power of the command at a frequency over that at its strongest, below which a response there would be noise over noise.
const LEAST_POWER: f64 = 1e-5;
/// Lines on each side over which the spectra of a chirp are averaged.
const HALF_WIDTH: usize = 1;

/// What of the dataset is looked at.
struct Chosen<'a> {
    input: String,
    drive: usize,
    output: String,
    signal: SignalName,
    series: usize,
    records: Vec<&'a Record>,
}

pub(super) fn respond(arguments: &Frf) -> anyhow::Result<Response> {
    refuse_experiment(arguments)?;
    let file = DatasetFile::load(&arguments.source)?;
    let data = Dataset::load(&arguments.source).map_err(|error| unusable(arguments, error))?;
    let mut notes: Vec<String> = Vec::new();
    let chosen = choose(arguments, &file, &data, &mut notes)?;
    let first = chosen.records[0];
    let spacing_s = first.spacing_s;
    let length_s = chosen.records.iter().map(|r| r.len()).min().unwrap_or(0) as f64 * spacing_s;
    let command = command_spectra(&first.commands[chosen.drive], spacing_s);
    let (low, high) = band(arguments, spacing_s, 2.0 / length_s, command.as_ref().and_then(excited_hz))?;
    let (mut estimate, mut told_apart, how) = estimate(arguments, &chosen, (low, high), length_s)?;
    let kept = powered(&estimate.frequencies_hz, command.as_ref());
    let dropped = kept.iter().filter(|kept| !**kept).count();
    if dropped > 0 {
        keep(&mut estimate, told_apart.as_mut(), &kept);
        notes.push(format!("{dropped} of {} frequencies are left out: the command has next to no power there", kept.len()));
    }

    let engagement = first.engagement.unwrap_or(Engagement::Unilateral);
    let mut machine = data.machine.clone();
    for contact in machine.contacts.values_mut() {
        contact.engagement = first.engagement.unwrap_or(contact.engagement);
    }
    if engagement == Engagement::Unilateral && !machine.contacts.is_empty() {
        notes.push("the tool may leave the workpiece in these records; the linear response takes it as touching all the time".to_owned());
    }
    let actuator = machine.actuators.get_index(chosen.drive).map(|(name, _)| name.clone()).unwrap_or_default();
    // Every recorded command is held until the next row, whatever the controller's period: that is the hold of the overlay.
    let experiment = Experiment { machine, actuator, output: chosen.signal.clone(), hold_s: spacing_s, offset: 0.0, seed: 0 };
    let linear = experiment.linear_response(&estimate.frequencies_hz).map_err(|error| refused(arguments, &error))?;
    let names: Vec<&str> = chosen.records.iter().map(|r| r.name.as_str()).collect();
    Ok(Response {
        title: data.name.clone(),
        about: file.about.clone(),
        input: chosen.input,
        output: chosen.output,
        how: format!("measured: {}; {how}", names.join(", ")),
        notes,
        hold_s: spacing_s,
        estimate,
        linear,
        told_apart,
        confidence: arguments.confidence,
    })
}

/// What chooses an experiment on the simulated machine has no say in one that has been recorded.
fn refuse_experiment(arguments: &Frf) -> anyhow::Result<()> {
    let given = [
        ("--set", !arguments.settings.is_empty()),
        ("--rms", arguments.rms.is_some()),
        ("--duration", arguments.duration.is_some()),
        ("--hold", arguments.hold.is_some()),
        ("--seed", arguments.seed.is_some()),
        ("--clamped", arguments.clamped),
        ("--free", arguments.free),
    ];
    let Some((name, _)) = given.into_iter().find(|(_, given)| *given) else { return Ok(()) };
    Err(BadInput::error(
        format!("{name} belongs to an experiment on the simulated machine, and this is a dataset"),
        "leave it out, or name a scenario file",
    ))
}

fn choose<'a>(arguments: &Frf, file: &DatasetFile, data: &'a Dataset, notes: &mut Vec<String>) -> anyhow::Result<Chosen<'a>> {
    let of_column = |column: &str| file.columns.get(column).map(|c| c.signal.to_string()).unwrap_or_default();
    let commands: Vec<(usize, &str)> = data.drives.iter().map(|(drive, column)| (*drive, column.as_str())).collect();
    let named = |wanted: &str, column: &str| wanted == column || wanted == of_column(column);
    let input = match &arguments.input {
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
        return Err(BadInput::error("the dataset has no command of a drive", "record one, and name it in [columns]"));
    };
    let outputs: Vec<&str> = data.channels.iter().map(|c| c.column.as_str()).collect();
    let series = if let Some(wanted) = &arguments.output {
        outputs.iter().position(|c| named(wanted, c)).ok_or_else(|| unknown("output", wanted, outputs.iter().copied()))?
    } else {
        let is = |i: &usize, quantity| data.channels[*i].quantity(&data.machine) == quantity;
        let named = arguments.experiments.first().and_then(|wanted| data.records.iter().find(|r| r.name == *wanted));
        let free = named.or(data.records.first()).is_some_and(|r| r.engagement == Some(Engagement::Free));
        let wanted = if free { Quantity::Acceleration } else { Quantity::SpringForce };
        (0..outputs.len()).rev().find(|i| is(i, wanted)).unwrap_or(0)
    };
    let Some(signal) = outputs.get(series).and_then(|c| file.columns.get(*c)).map(|c| c.signal.clone()) else {
        return Err(BadInput::error("the dataset has nothing but commands", "record an output, and name it in [columns]"));
    };
    let all = || data.records.iter().map(|r| r.name.as_str());
    let mut records = Vec::new();
    for wanted in &arguments.experiments {
        records.push(data.records.iter().find(|r| r.name == *wanted).ok_or_else(|| unknown("experiment", wanted, all()))?);
    }
    if records.is_empty() {
        records.extend(data.records.first());
        notes.push(format!("the first of {} experiments; --experiment names others, several are averaged", data.records.len()));
    }
    let Some(first) = records.first() else { return Err(BadInput::error("the dataset has no experiment", "add one as [[experiments]]")) };
    let alike = |r: &&Record| r.engagement == first.engagement && (r.spacing_s - first.spacing_s).abs() < 1e-9 * first.spacing_s;
    require(
        records.iter().all(alike),
        || "these experiments differ in engagement or sample time, so they have no response in common".to_owned(),
        "average only experiments that are alike",
    )?;
    let (input, output) = (of_column(column), signal.to_string());
    Ok(Chosen { input, drive, output, signal, series, records })
}

type Estimated = (ResponseEstimate, Option<[Vec<f64>; 2]>, String);

fn estimate(arguments: &Frf, chosen: &Chosen<'_>, band_hz: (f64, f64), length_s: f64) -> anyhow::Result<Estimated> {
    let spacing_s = chosen.records[0].spacing_s;
    let pairs: Vec<(Vec<f64>, Vec<f64>)> =
        chosen.records.iter().map(|r| (centred(&r.commands[chosen.drive]), centred(&r.series[chosen.series]))).collect();
    let lti = |error: feeler_lti::LtiError| refused(arguments, &error.into());
    let averages = arguments.estimator != EstimatorKind::LocalPolynomial || pairs.len() > 1;
    require_segments(arguments, averages)?;
    match arguments.excitation {
        ExcitationKind::SteppedSine => Err(BadInput::error(
            "a stepped sine is not evaluated from records: they do not say where each frequency begins",
            "use --excitation white-noise, which suits any record, or multisine or chirp",
        )),
        ExcitationKind::Multisine => {
            let Some(period_s) = arguments.period else {
                return Err(BadInput::error("the period of a measured multisine must be known", "give it with --period, in s"));
            };
            let samples_per_period = (period_s / spacing_s).round() as usize;
            let shortest = pairs.iter().map(|(u, _)| u.len()).min().unwrap_or(0);
            let periods = shortest / samples_per_period.max(1);
            require(
                samples_per_period >= 4 && periods >= 2,
                || format!("records of {} hold no two periods of {}", with_unit(length_s, "s"), with_unit(period_s, "s")),
                "two periods are needed to tell noise; leave the period out and use --excitation white-noise",
            )?;
            // The first period holds the transient, where there are others.
            let transient_periods = usize::from(periods > 2);
            let whole = periods * samples_per_period;
            let realisations: Vec<Realisation<'_>> = (pairs.iter())
                .map(|(u, y)| Realisation {
                    input: &u[..whole],
                    output: &y[..whole],
                    period_s: spacing_s,
                    samples_per_period,
                    transient_periods,
                })
                .collect();
            let lines: Vec<usize> = excited_lines(&pairs[0].0[..samples_per_period], period_s, band_hz);
            let how = format!("multisine of period {}, {periods} periods, {} realisations", with_unit(period_s, "s"), realisations.len());
            if let [only] = realisations.as_slice() {
                return Ok((periodic_response(only, &lines).map_err(lti)?, None, how));
            }
            let best = best_linear_approximation(&realisations, &lines).map_err(lti)?;
            let count = realisations.len() as f64;
            let noise = best.noise_variance.into_iter().map(|v| v * count).collect();
            Ok((best.estimate, Some([noise, best.distortion_variance]), how))
        }
        ExcitationKind::Chirp => {
            let spectra =
                pairs.iter().map(|(u, y)| smoothed_spectra(u, y, spacing_s, HALF_WIDTH)).collect::<Result<Vec<_>, _>>().map_err(lti)?;
            let kind = estimator(arguments.estimator).unwrap_or(Estimator::H1);
            let all = CrossSpectra::averaged(&spectra).map_err(lti)?;
            Ok((all.response(kind, band_hz.0, band_hz.1).map_err(lti)?, None, format!("chirp, {kind:?}")))
        }
        ExcitationKind::WhiteNoise => {
            if let ([(u, y)], false) = (pairs.as_slice(), averages) {
                let method = NoiseMethod::LocalPolynomial(LocalPolynomialSettings::default());
                let found = response_from_noise(u, y, spacing_s, method, band_hz).map_err(|error| refused(arguments, &error))?;
                return Ok((found, None, "local polynomials (leakage taken away)".to_owned()));
            }
            let segment_s = arguments.segment.unwrap_or(length_s / SEGMENTS);
            let settings = WelchSettings::hann((segment_s / spacing_s).round() as usize);
            let spectra =
                pairs.iter().map(|(u, y)| cross_spectra(u, y, spacing_s, &settings)).collect::<Result<Vec<_>, _>>().map_err(lti)?;
            let kind = estimator(arguments.estimator).unwrap_or(Estimator::H1);
            let all = CrossSpectra::averaged(&spectra).map_err(lti)?;
            let how = format!("{kind:?} of segments of {}", with_unit(segment_s, "s"));
            Ok((all.response(kind, band_hz.0, band_hz.1).map_err(lti)?, None, how))
        }
    }
}

/// Where the power of a command lies; absent where the record is too short to tell.
fn command_spectra(command: &[f64], spacing_s: f64) -> Option<CrossSpectra> {
    let settings = WelchSettings::hann((command.len() as f64 / SEGMENTS) as usize);
    cross_spectra(command, command, spacing_s, &settings).ok()
}

/// Frequency below which nearly all power of a command lies; above it a response would be noise over noise.
fn excited_hz(spectra: &CrossSpectra) -> Option<f64> {
    let whole: f64 = spectra.input.iter().sum();
    let mut below = 0.0;
    let last = spectra.input.iter().position(|power| {
        below += power;
        below >= POWER * whole
    })?;
    Some(spectra.frequencies_hz[last])
}

/// Which frequencies the command excites: where its power is at least [`LEAST_POWER`] of the strongest's.
fn powered(frequencies_hz: &[f64], spectra: Option<&CrossSpectra>) -> Vec<bool> {
    let Some(spectra) = spectra else { return vec![true; frequencies_hz.len()] };
    let strongest = spectra.input.iter().copied().fold(0.0, f64::max);
    let power = |f: f64| {
        let after = spectra.frequencies_hz.partition_point(|&line| line < f);
        // The stronger of both neighbours: a line of a multisine may lie between them.
        [after.saturating_sub(1), after].into_iter().filter_map(|i| spectra.input.get(i)).copied().fold(0.0, f64::max)
    };
    frequencies_hz.iter().map(|&f| power(f) >= LEAST_POWER * strongest).collect()
}

/// Drops the frequencies that are not kept.
fn keep(estimate: &mut ResponseEstimate, told_apart: Option<&mut [Vec<f64>; 2]>, kept: &[bool]) {
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
    told_apart.into_iter().flatten().for_each(|variance| of(variance, kept));
}

/// A record about its mean: the operating point is no part of a response.
fn centred(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    values.iter().map(|v| v - mean).collect()
}

/// Lines of a periodic input that carry at least a thousandth of its strongest line's amplitude.
fn excited_lines(period: &[f64], period_s: f64, (low_hz, high_hz): (f64, f64)) -> Vec<usize> {
    let n = period.len() as f64;
    let amplitude = |line: usize| {
        let w = std::f64::consts::TAU * line as f64 / n;
        let sum: feeler_lti::C64 = period.iter().enumerate().map(|(k, v)| feeler_lti::C64::cis(-w * k as f64) * *v).sum();
        sum.norm()
    };
    let lines: Vec<(usize, f64)> =
        ((low_hz * period_s).ceil() as usize..=(high_hz * period_s).floor() as usize).map(|line| (line, amplitude(line))).collect();
    let strongest = lines.iter().map(|l| l.1).fold(0.0, f64::max);
    lines.into_iter().filter(|l| l.1 > 1e-3 * strongest).map(|l| l.0).collect()
}

fn unknown<'a>(what: &str, wanted: &str, known: impl Iterator<Item = &'a str>) -> anyhow::Error {
    BadInput::error(format!("the dataset has no {what} `{wanted}`"), did_you_mean(wanted, known))
}

fn unusable(arguments: &Frf, error: DiagnosisError) -> anyhow::Error {
    match error {
        DiagnosisError::Format(error) => error.into(),
        other => BadInput::error(format!("{}: {other}", arguments.source.display()), "feeler check names every mistake of a dataset"),
    }
}
