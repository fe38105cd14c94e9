//! The next experiment: among templates, the one after which two causes that look alike would differ most (Box and Hill 1967; Atkinson and Fedorov's
//! T-optimality 1975). Each template is run on one cause's machine; the other's is then fitted to it, so that only what calibration cannot absorb counts.

use std::f64::consts::TAU;

use feeler_plant::description::Engagement;

use crate::dataset::{Dataset, Record};
use crate::diagnose::Judge;
use crate::fit::{Fitted, Task};
use crate::predict::Predictor;
use crate::report::NextExperiment;
use crate::search::{Scored, score};

/// Share of the stroke of the records below which a template out of contact moves nothing.
const LEAST_STROKE: f64 = 0.02;
/// Length of a template, s.
const SECONDS: f64 = 2.0;
/// Share of the largest command seen so far that templates use, from small to large.
const LEVELS: [f64; 3] = [0.05, 0.3, 0.9];
/// Lines of a multisine.
const LINES: usize = 24;
/// Fitting steps of the rival on a template.
const STEPS: usize = 3;
/// Odds below which a template separates nothing.
const LEAST_ODDS: f64 = 3.0;
/// Largest odds that are quoted.
const MOST_ODDS: f64 = 1e6;

struct Template {
    what: String,
    engagement: Engagement,
    command: Vec<f64>,
}

/// The template that best tells `rival` from `accepted`; none where none does.
pub(crate) fn next_experiment(judge: &Judge<'_>, accepted: &Scored, rival: &Scored) -> Option<NextExperiment> {
    let dataset = judge.dataset;
    if dataset.drives.len() != 1 {
        return None;
    }
    let spacing_s = dataset.records[0].spacing_s;
    let templates = templates(dataset, spacing_s);
    let odds = |template: &Template| {
        Some(f64::midpoint(expected(judge, accepted, rival, template, spacing_s)?, expected(judge, rival, accepted, template, spacing_s)?))
    };
    let (nats, best) = templates.iter().filter_map(|template| Some((odds(template)?, template))).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let expected_odds = nats.exp().min(MOST_ODDS);
    if expected_odds < LEAST_ODDS {
        return None;
    }
    let kind = |scored: &Scored| scored.causes.last().map_or("", |cause| cause.definition.kind);
    Some(NextExperiment {
        what: best.what.clone(),
        separates: [kind(accepted), kind(rival)],
        expected_odds,
        engagement: match best.engagement {
            Engagement::Free => "free",
            Engagement::Clamped => "clamped",
            Engagement::Unilateral => "unilateral",
        },
        spacing_s,
        command: best.command.clone(),
    })
}

/// Evidence for `truth` over `other` that a record of the template would bring, nats.
fn expected(judge: &Judge<'_>, truth: &Scored, other: &Scored, template: &Template, spacing_s: f64) -> Option<f64> {
    let dataset = judge.dataset;
    let rows = template.command.len();
    let record = |series: Vec<Vec<f64>>| Record {
        name: template.what.clone(),
        engagement: Some(template.engagement),
        is_check: false,
        repeat: None,
        start_s: 0.0,
        times_s: Vec::new(),
        spacing_s,
        commands: vec![template.command.clone()],
        series,
        silent: vec![false; dataset.channels.len()],
    };
    let rest = record(vec![vec![0.0; rows]; dataset.channels.len()]);
    let Fitted { model, theta, .. } = &truth.fitted;
    let assembly = model.assembly(theta, rest.engagement)?;
    let seen = Predictor::with(assembly, model.presliding(theta), dataset, &rest).ok()?.free().ok()?;
    if !seen.series.iter().flatten().all(|x| x.is_finite()) {
        return None;
    }
    let (low, high) = seen.stroke.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| (low.min(s[0]), high.max(s[0])));
    if template.engagement == Engagement::Free && high - low < LEAST_STROKE * judge.search.seen.stroke_m {
        return None;
    }
    let imagined = Dataset { records: vec![record(seen.series)], ..dataset.clone() };
    let reference = truth_prediction(&imagined, truth)?;
    let task = Task { dataset: &imagined, weights: crate::fit::Weights::new(&imagined, &[reference]), fitted: vec![0] };
    let own = score(&task, truth.causes.clone(), truth.fitted.clone());
    let fitted = task.fit(&other.fitted.model, &other.fitted.theta, STEPS);
    let others = score(&task, other.causes.clone(), fitted);
    // What noise alone leaves is one; the imagined record has none.
    let looks = crate::odds::looks(&imagined.records[0]);
    Some(own.misfits[0].iter().zip(&others.misfits[0]).map(|(a, b)| 0.5 * looks * ((1.0 + b) / (1.0 + a)).ln()).sum())
}

fn truth_prediction(dataset: &Dataset, truth: &Scored) -> Option<crate::predict::Prediction> {
    let Fitted { model, theta, .. } = &truth.fitted;
    let assembly = model.assembly(theta, dataset.records[0].engagement)?;
    Predictor::with(assembly, model.presliding(theta), dataset, &dataset.records[0]).ok()?.anchored().ok()
}

/// Multisines of three levels in two bands and slow strokes, free; clamped and in contact where the records have that.
fn templates(dataset: &Dataset, spacing_s: f64) -> Vec<Template> {
    let rows = (SECONDS / spacing_s).round() as usize;
    let largest = dataset.records.iter().flat_map(|record| record.commands.iter().flatten()).fold(0.0_f64, |m, u| m.max(u.abs()));
    let mut engagements: Vec<Engagement> = Vec::new();
    for record in &dataset.records {
        let engagement = record.engagement.unwrap_or(Engagement::Free);
        if !engagements.contains(&engagement) {
            engagements.push(engagement);
        }
    }
    let top = 0.25 / spacing_s;
    let mut found = Vec::new();
    for engagement in engagements {
        let place = match engagement {
            Engagement::Free => "out of contact",
            Engagement::Clamped => "with the tool clamped",
            Engagement::Unilateral => "pressed against the work",
        };
        for level in LEVELS {
            let peak = level * largest;
            // Pressing takes a mean force that the excitation never takes away.
            let mean = if engagement == Engagement::Unilateral { 0.6 * peak } else { 0.0 };
            let swing = if engagement == Engagement::Unilateral { 0.4 * peak } else { peak };
            for (low, high) in [(1.0, 0.04 * top), (0.04 * top, top)] {
                found.push(Template {
                    what: format!("a multisine from {low:.0} to {high:.0} Hz with peaks of {peak:.1} N about {mean:.1} N, {place}"),
                    engagement,
                    command: multisine(rows, spacing_s, low, high).into_iter().map(|x| mean + swing * x).collect(),
                });
            }
            if engagement != Engagement::Clamped {
                found.push(Template {
                    what: format!("slow strokes at 1 Hz with {peak:.1} N about {mean:.1} N, {place}"),
                    engagement,
                    command: (0..rows).map(|k| mean + swing * (TAU * k as f64 * spacing_s).sin()).collect(),
                });
            }
        }
    }
    found
}

/// A multisine of unit peak on a logarithmic grid, phases after Schroeder.
fn multisine(rows: usize, spacing_s: f64, low_hz: f64, high_hz: f64) -> Vec<f64> {
    let line = |i: usize| low_hz * (high_hz / low_hz).powf(i as f64 / (LINES - 1) as f64);
    let phase = |i: usize| -std::f64::consts::PI * (i * i) as f64 / LINES as f64;
    let raw: Vec<f64> =
        (0..rows).map(|k| (0..LINES).map(|i| (TAU * line(i) * k as f64 * spacing_s + phase(i)).sin()).sum::<f64>()).collect();
    let peak = raw.iter().fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs()));
    raw.into_iter().map(|x| x / peak).collect()
}
