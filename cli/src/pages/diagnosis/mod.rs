//! The page of a diagnosis: the cause, its place, the certainty, and the next steps.

mod adequacy;
pub(crate) mod advice;
mod charts;
mod heat;
mod portrait;
mod waterfall;
pub(crate) mod words;

pub(crate) use adequacy::WITH_EFFECTS;
use feeler_diagnosis::Examination;
use feeler_diagnosis::report::{Cause, Diagnosis};
use feeler_files::machine_to_toml;

use crate::numbers::{count, fine_percent, percent, plain, two_digits, with_unit};
use crate::pages::parts::{Chart, ChartKind, Page, Series, Tile, by_extremes};
use crate::repaired::with_rounded;
use crate::units::Units;

/// Rungs of the ladder that are listed.
const MOST_RUNGS: usize = 8;

pub(crate) fn page(answer: &Examination) -> String {
    let diagnosis = &answer.diagnosis;
    let units = Units::of(&answer.dataset.machine);
    let mut page = Page::new(&format!("{}: diagnosis", answer.dataset.name), &about(answer));
    page.lead(&words::sentence(&words::verdict(diagnosis)));
    page.tiles(&tiles(answer, units));
    page.paragraph(&words::closed(diagnosis, answer.checks()));
    page.heading("What to do");
    let advice = advice::Advice::of(diagnosis);
    page.steps(&advice.steps);
    for remark in &advice.remarks {
        page.paragraph(remark);
    }
    next(&mut page, diagnosis, units);
    changes(&mut page, answer);
    causes(&mut page, diagnosis);
    page.heading("How far the gap shrinks");
    page.paragraph(
        "Root mean square prediction error over each channel's own variation, on experiments never fitted. \
         Predictions start from the measured motion every 50 ms. The gap is grey; a step that removes or \
         adds to it has a colour.",
    );
    page.hanging_bars(&waterfall::hanging(diagnosis));
    adequacy::add(&mut page, &diagnosis.adequacy, words::is_found(diagnosis));
    places(&mut page, diagnosis);
    missing_force(&mut page, diagnosis, units);
    charts::add(&mut page, answer, units);
    tried(&mut page, diagnosis);
    if !diagnosis.warnings.is_empty() {
        page.heading("Remarks about the data");
        for warning in &diagnosis.warnings {
            page.paragraph(warning);
        }
    }
    page.heading("The repaired machine");
    let machine = with_rounded(machine_to_toml(&diagnosis.machine), answer);
    page.verbatim("machine.toml, without its excitation", &machine);
    page.render()
}

fn about(answer: &Examination) -> String {
    let records = &answer.dataset.records;
    let checks = answer.checks();
    let seconds: f64 = records.iter().map(|record| record.spacing_s * record.len() as f64).sum();
    format!(
        "Machine {} against {}, {} of measurement; {} set aside for scoring and never fitted.",
        answer.dataset.machine.name,
        count(records.len(), "experiment", "experiments"),
        with_unit((10.0 * seconds).round() / 10.0, "s"),
        count(checks, "of them was", "of them were")
    )
}

/// Largest printed number of noise floors: beyond it the noise is irrelevant.
const MOST_FLOORS: f64 = 1000.0;

/// Cause, size and remaining error: the first questions of an engineer.
fn tiles(answer: &Examination, units: Units) -> Vec<Tile> {
    let diagnosis = &answer.diagnosis;
    let gap = &diagnosis.gap;
    let share = |value: f64| format!("{} %", fine_percent(value));
    let tile = |name, value: String, remark: &str| Tile::new(name, value, remark);
    let is_stated =
        answer.dataset.channels.iter().all(|channel| answer.dataset.is_noise_stated(&channel.column));
    // A gap that is small against the signal may be large against the noise. That ratio is shown if the noise
    // is known.
    let beside = |value: f64| match value / gap.floor {
        floors if is_stated && floors <= MOST_FLOORS => format!("{} noise floors", plain(two_digits(floors))),
        _ if is_stated && gap.floor > 0.0 => format!("over {} noise floors", plain(MOST_FLOORS)),
        _ if gap.before > 0.0 => format!("{} % of the machine as given", fine_percent(value / gap.before)),
        _ => String::new(),
    };
    let [missing, left] = diagnosis.missing_force_n.map(|force| with_unit(force, units.force));
    let floor =
        if is_stated { "no model gets below" } else { "no noise is stated: from scatter and repeats" };
    let of_given = if is_stated { beside(gap.before) } else { "error over variation, rms".into() };
    let mut tiles = Vec::new();
    if !diagnosis.places.is_empty() {
        let (places, probability) = words::places(diagnosis);
        tiles.push(tile("where", places, &format!("probability {} %", percent(probability))));
    }
    tiles.extend([
        tile("gap, machine as given", share(gap.before), &of_given),
        tile("after calibration", share(gap.refit), &beside(gap.refit)),
    ]);
    let is_found = words::is_found(diagnosis);
    if is_found {
        tiles.push(tile(WITH_EFFECTS, share(gap.after), &beside(gap.after)));
    }
    tiles.push(tile("noise floor", share(gap.floor), floor));
    if is_found {
        let closed = if gap.closed > 0.0 { share(gap.closed) } else { "none".into() };
        tiles.push(tile("closed", closed, "of what can be closed"));
        tiles.push(tile(
            "force that is missing",
            left,
            &format!("rms, {WITH_EFFECTS}; {missing} after calibration alone"),
        ));
    } else {
        tiles.push(tile("force that is missing", missing, "rms, after calibration"));
    }
    tiles
}

fn next(page: &mut Page, diagnosis: &Diagnosis, units: Units) {
    let Some(next) = &diagnosis.next_experiment else { return };
    let mut chart = Chart::new(
        ChartKind::Line,
        "The next experiment's command,",
        "time (s)",
        format!("command ({})", units.force),
    );
    chart.caption = format!(
        "as written in next-experiment.csv; at up to {} it goes from {} to {} of where it starts.",
        with_unit(next.top_speed_m_per_s, units.velocity),
        with_unit(next.travel_m[0], units.position),
        with_unit(next.travel_m[1], units.position)
    );
    let kept = by_extremes(&[&next.command], next.command.len(), charts::MOST_ROWS);
    chart.x = kept.iter().map(|&k| k as f64 * next.spacing_s).collect();
    chart.series = vec![Series::new("command", units.force, kept.iter().map(|&k| next.command[k]).collect())];
    page.chart(&chart);
}

fn changes(page: &mut Page, answer: &Examination) {
    if answer.difference.is_empty() {
        return;
    }
    page.verbatim("What to change in the believed machine (SI)", answer.difference.to_string().trim());
}

fn causes(page: &mut Page, diagnosis: &Diagnosis) {
    if diagnosis.effects.is_empty() {
        return;
    }
    page.heading("What causes it");
    page.paragraph(
        "Probabilities are among the causes of the library, given these records; `feeler effects KIND` \
         explains each. Credit is the share of an accepted cause in what all accepted ones close. Intervals \
         hold 90 % if the model is right. docs/diagnosis.md says how often both held on benchmarks.",
    );
    let bars: Vec<(String, f64, String)> = diagnosis
        .effects
        .iter()
        .map(|effect| {
            (
                format!("{} on {}", effect.kind, effect.on),
                effect.probability,
                format!("{} %", percent(effect.probability)),
            )
        })
        .collect();
    page.bars(&bars);
    let rows: Vec<Vec<String>> = diagnosis.effects.iter().flat_map(rows_of).collect();
    page.table(&["", "cause", "on", "credit", "parameter", "value", "90 % interval"], &[3, 5, 6], &rows);
}

fn rows_of(effect: &Cause) -> Vec<Vec<String>> {
    let status = if effect.accepted { "found" } else { "rival" };
    let credit = if effect.accepted { format!("{} %", percent(effect.credit)) } else { String::new() };
    let head = [status.to_owned(), effect.kind.to_string(), effect.on.clone(), credit];
    let mut rows = Vec::new();
    for (i, (name, estimate)) in effect.parameters.iter().enumerate() {
        let unit = estimate.unit.as_str();
        let interval = words::interval(estimate).unwrap_or_else(|| "fixed".into());
        let mut row: Vec<String> = if i == 0 { head.to_vec() } else { vec![String::new(); head.len()] };
        row.extend([(*name).to_owned(), with_unit(estimate.value, unit), interval]);
        rows.push(row);
    }
    rows
}

fn places(page: &mut Page, diagnosis: &Diagnosis) {
    page.heading("Where it lies");
    let rows: Vec<Vec<String>> = diagnosis
        .places
        .iter()
        .map(|place| {
            let band = words::band(place.band_hz);
            let probability = format!("{} %", percent(place.probability));
            vec![
                place.place.to_owned(),
                probability,
                place.channel.clone(),
                band,
                place.phase.to_owned(),
                place.evidence.clone(),
            ]
        })
        .collect();
    if !rows.is_empty() {
        page.table(&["place", "probability", "shows most in", "band", "phase", "evidence"], &[1], &rows);
    }
    if diagnosis.cells.is_empty() {
        return;
    }
    let noise = format!("Without colour: no more than {} times the noise.", plain(heat::NOISE));
    let scale = format!(
        "in per cent of each channel's variation, by phase of the motion: palest at {} %, darkest at {} % \
         or more. {noise}",
        plain(100.0 * heat::PALEST),
        plain(100.0 * heat::DARKEST),
    );
    page.picture(
        "Error of the calibrated machine,",
        &scale,
        &heat::by_phase(&diagnosis.cells, |cell| cell.refit, "before"),
    );
    let is_found = words::is_found(diagnosis);
    if is_found {
        page.picture(
            "Error with the effects found,",
            &format!("in the same cells. Cells that are still deep blue are not explained. {noise}"),
            &heat::by_phase(&diagnosis.cells, |cell| cell.after, "after"),
        );
    }
    let levels = format!(
        "over all phases and bands. The error of a linear cause is the same at every level. That of dry \
         friction and free play falls with it, that of limits rises. {noise}"
    );
    page.picture("By level of the command,", &levels, &heat::by_level(&diagnosis.cells, is_found));
}

fn missing_force(page: &mut Page, diagnosis: &Diagnosis, units: Units) {
    // The portrait at the located place comes first.
    let found = diagnosis
        .effects
        .iter()
        .filter(|effect| effect.accepted)
        .max_by(|a, b| a.credit.total_cmp(&b.credit));
    let place = found.map(|effect| effect.place).or(diagnosis.places.first().map(|place| place.place));
    let of_place = diagnosis.ladder.iter().find(|rung| Some(rung.place) == place);
    let Some(first) = of_place.or(diagnosis.ladder.first()) else { return };
    page.heading("The force that is missing");
    page.paragraph(
        "An unknown force (or reading error) is allowed at one place at a time. The evidence says how much \
         of the calibrated machine's error it removes there. Its odds are given as their natural \
         logarithm: log odds of 1 are 2.7 to 1, of 5 they are 150 to 1. The shape of the force suggests its \
         kind. Friction follows the sign of velocity, a load is constant, ripple repeats over position, and \
         a lag follows the drive.",
    );
    let rows: Vec<Vec<String>> = diagnosis
        .ladder
        .iter()
        .take(MOST_RUNGS)
        .map(|rung| {
            let with = rung
                .goes_with
                .iter()
                .map(|(name, share)| format!("{name} {:.0} %", 100.0 * share))
                .collect::<Vec<_>>()
                .join(", ");
            vec![
                rung.place.to_owned(),
                strength(rung.evidence).to_owned(),
                plain(rung.evidence.round()),
                with_unit(rung.rms_n, units.force),
                with,
            ]
        })
        .collect();
    page.table(
        &["allowed at", "evidence", "log odds", "rms", "share of its variance that depends on"],
        &[2, 3],
        &rows,
    );
    let [before, after] = diagnosis.missing_force_n.map(|force| with_unit(force, units.force));
    let found = if words::is_found(diagnosis) { format!(", {after} {WITH_EFFECTS}") } else { String::new() };
    page.paragraph(&format!("On the check experiments {before} rms is missing after calibration{found}."));
    page.paragraph(&format!(
        "Portraits of the force missing at the {} (dots: calibrated machine; line: mean):",
        first.place
    ));
    page.drawings(&portrait::drawings(first, units));
    if !diagnosis.inverse.is_empty() {
        page.paragraph(
            "The force that the machines lack along the first check experiment (blue: machine as given; \
             orange: repaired machine):",
        );
        page.drawings(&portrait::inverse(&diagnosis.inverse, units));
    }
}

/// Evidence in a word: strong at odds of 150 to 1 or more, some at 3 to 1 or more.
fn strength(nats: f64) -> &'static str {
    match nats {
        nats if nats >= 5.0 => "strong",
        nats if nats >= 1.0 => "some",
        _ => "none",
    }
}

/// `a@x+b@y` in words.
fn said(causes: &str) -> String {
    causes.replace('+', " and ").replace('@', " on ")
}

fn tried(page: &mut Page, diagnosis: &Diagnosis) {
    if diagnosis.attempts.is_empty() {
        return;
    }
    page.heading("What was tried");
    page.paragraph(
        "Every effect that the machine can have, each by itself, then beside others. The evidence is that \
         gained over calibration alone, as log odds (1 is 2.7 to 1, 5 are 150 to 1).",
    );
    let mut groups: Vec<(&str, Vec<Vec<String>>)> = Vec::new();
    for attempt in &diagnosis.attempts {
        let (beside, last) = attempt.causes.rsplit_once('+').unwrap_or(("", &attempt.causes));
        let nats = |gain: Option<f64>| gain.map_or_else(|| "-".into(), |gain| plain(gain.round()));
        let row = vec![said(last), nats(attempt.gain_check), nats(attempt.gain_all), attempt.why.to_string()];
        match groups.iter_mut().find(|(known, _)| *known == beside) {
            Some((_, rows)) => rows.push(row),
            None => groups.push((beside, vec![row])),
        }
    }
    groups.sort_by_key(|(beside, _)| beside.matches('@').count());
    for (beside, rows) in groups {
        if !beside.is_empty() {
            page.paragraph(&format!("Beside {}:", said(beside)));
        }
        page.table(&["cause", "log odds, check", "log odds, all", "why (not)"], &[1, 2], &rows);
    }
}
