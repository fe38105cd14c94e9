//! The page of an analysis.

mod bode;
pub(crate) mod cycles;
mod planes;
mod shapes;
mod verdict;
pub(crate) mod waterfall;

use feeler_analysis::{Curves, ModeReport, RankedBy, Relief, Report};
use feeler_files::Document;

use crate::numbers::{plain, two_digits, with_unit};
use crate::pages::parts::{Page, Tile, Tone};

pub(crate) use bode::{degrees, open as open_loop, step};
pub(crate) use planes::{loci, nyquist};
pub(crate) use verdict::{achieved_name, as_set, class_name, sentences, subject};

/// Numbers whose sensitivities are drawn as bars; the table has all.
const MOST_BARS: usize = 6;

/// The page of an analysis with sensitivities; notes describe the view of the machine.
pub(crate) fn page(
    document: &Document,
    settings: &[String],
    notes: &[String],
    report: &Report,
    curves: &Curves,
) -> String {
    let machine = &document.scenario.machine;
    let mut page = Page::new(&format!("{}: linear theory", machine.name), &machine.about);
    let said: Vec<String> = as_set(report).into_iter().chain(sentences(report)).collect();
    let (lead, rest) = said.split_first().map_or(("", &[][..]), |(first, rest)| (first.as_str(), rest));
    page.lead(lead);
    for sentence in rest {
        page.paragraph(sentence);
    }
    if report.pair().is_some_and(|of| of.input != report.input || of.output != report.output) {
        page.paragraph(&format!("Looked at {}", subject(report).replace('\n', ". ")));
    }
    for note in notes {
        page.paragraph(&format!("Note: {note}."));
    }
    page.tiles(&tiles(report));
    page.heading("The loop as set");
    for chart in bode::step(curves).into_iter().chain(bode::open(report, curves)) {
        page.chart(&chart);
    }
    if let Some(plane) = planes::nyquist(report, curves) {
        page.plane(&plane);
    }
    limits(&mut page, report);
    sensitivities(&mut page, report);
    modes(&mut page, report);
    assumptions(&mut page, report);
    page.heading("Frequency responses");
    page.paragraph(&format!(
        "From {} to {}. Continuous curves leave out sampling, hold, delays of the controller and filters. \
         Sampled curves have all of them, exactly, and end at half of the sampling rate.",
        report.input, report.output
    ));
    for chart in bode::charts(report, curves) {
        page.chart(&chart);
    }
    limit_cycles(&mut page, report);
    page.heading("Poles and zeros");
    for plane in planes::loci(report, curves) {
        page.plane(&plane);
        if let Some(near) = planes::near_the_limit(report, plane) {
            page.plane(&near);
        }
    }
    if curves.open_sampled.is_some() && curves.locus_sampled.is_none() {
        page.paragraph(
            "The sampled loop has a branch for each of the many samples of its delay: a root \
                        locus would show nothing.",
        );
    }
    page.plane(&planes::map(report));
    page.heading("Scenario");
    if !settings.is_empty() {
        page.paragraph(&format!("Set on the command line: {}", settings.join("; ")));
    }
    page.verbatim("the file as it was analysed", document.text());
    page.render()
}

/// Largest relative change of the largest gain that is reported as unchanged.
const UNCHANGED: f64 = 0.005;
/// Phase margins: below the first a loop is fragile, above the second it is sound.
const PHASE_DEG: [f64; 2] = [30.0, 45.0];
const SENSITIVITY: [f64; 2] = [2.0, 3.0];

/// The figures of the loop as set, and of its limits.
pub(crate) fn tiles(report: &Report) -> Vec<Tile> {
    let mut tiles = Vec::new();
    if let Some(gain) = report.gain() {
        let top = |range: &feeler_analysis::StableRange| match (range.all.bands.is_empty(), range.stable[1]) {
            (true, _) => "none".to_owned(),
            (_, Some(edge)) => plain(edge),
            (_, None) => "unbounded".to_owned(),
        };
        let edge = |range: &feeler_analysis::StableRange| {
            let edge_hz = range.edge_hz.filter(|_| range.stable[1].is_some());
            edge_hz.map_or_else(String::new, |f| format!("oscillates at {}", with_unit(f, "Hz")))
        };
        let set = if gain.is_unstable_as_set() {
            Tile::new("gain as set", plain(gain.present), "unstable").toned(Tone::Bad)
        } else {
            Tile::new("gain as set", plain(gain.present), "stable")
        };
        tiles.push(set);
        tiles.push(Tile::new("stability limit, sampled", top(&gain.sampled), edge(&gain.sampled)));
        if let Some(continuous) = &gain.continuous {
            let tile = Tile::new("the same, continuous", top(continuous), edge(continuous));
            tiles.push(tile.toned(Tone::Quiet));
        }
    }
    if let Some(hz) = report.looped.as_ref().and_then(|looped| looped.bandwidth_hz) {
        tiles.push(Tile::new("bandwidth as set", with_unit(hz, "Hz"), "3 dB below low frequency"));
    }
    if let Some(margins) = report.margins().filter(|margins| margins.unstable_poles == 0) {
        let number = |value: Option<f64>, unit: &str| {
            value.map_or_else(|| "unlimited".to_owned(), |v| with_unit(v, unit))
        };
        tiles.push(Tile::new(
            "gain margin",
            margins.gain.map_or_else(|| "unlimited".to_owned(), plain),
            "factor on the whole output",
        ));
        let crossover = margins
            .crossover_hz
            .map_or_else(|| "no crossover".to_owned(), |f| format!("at {}", with_unit(f, "Hz")));
        let phase = margins.phase_deg.map_or_else(|| "unlimited".to_owned(), |v| format!("{}°", plain(v)));
        let tone = |is_bad: bool, is_good: bool| match (is_bad, is_good) {
            (true, _) => Tone::Bad,
            (_, true) => Tone::Good,
            _ => Tone::Plain,
        };
        let of_phase =
            margins.phase_deg.map_or(Tone::Plain, |v| tone(v.abs() < PHASE_DEG[0], v.abs() >= PHASE_DEG[1]));
        tiles.push(Tile::new("phase margin", phase, crossover).toned(of_phase));
        tiles.push(Tile::new("delay margin", number(margins.delay_s, "s"), "in addition"));
        tiles.push(Tile::new("disk margin", plain(margins.disk), "0 to 2"));
        let peak = margins.sensitivity_peak;
        let of_peak = tone(peak > SENSITIVITY[1], peak <= SENSITIVITY[0]);
        tiles.push(Tile::new("largest sensitivity", plain(peak), "|S|").toned(of_peak));
    }
    tiles
}

fn limit_cycles(page: &mut Page, report: &Report) {
    if report.limit_cycles.is_empty() {
        return;
    }
    page.heading("Chatter by describing functions");
    page.paragraph(
        "The contact only pushes. Its force in an oscillation, taken as mean and first harmonic, is that of \
         a softer contact that also pulls. The table lists the oscillations that the sampled loop then \
         neither damps nor feeds. This is a first approximation: `feeler run` shows the motion itself.",
    );
    page.table(&cycles::HEADER, &cycles::NUMBERS, &cycles::rows(report));
}

/// Headings of the table of nonlinear properties.
pub(crate) const ASSUMPTIONS: [&str; 3] = ["not linear", "", "in the linear model"];

fn assumptions(page: &mut Page, report: &Report) {
    if report.assumptions.is_empty() {
        return;
    }
    page.heading("What the linear model leaves out");
    page.table(&ASSUMPTIONS, &[], &assumption_rows(report));
}

/// One row for each nonlinear property.
pub(crate) fn assumption_rows(report: &Report) -> Vec<Vec<String>> {
    report.assumptions.iter().map(|a| vec![a.of.clone(), a.property.to_owned(), a.taken.clone()]).collect()
}

/// Damping ratio of a mode; zero for an undamped mode, without rounding error.
pub(crate) fn damping_ratio(mode: &ModeReport) -> f64 {
    if mode.damping_ratio.abs() < 1e-12 { 0.0 } else { mode.damping_ratio }
}

fn limits(page: &mut Page, report: &Report) {
    let Some(waterfall) = report.waterfall() else { return };
    page.heading("What limits the bandwidth");
    let controlled = report.pair().map_or("the reading", |of| of.controlled.as_str());
    page.paragraph(&format!(
        "From the rigid body with a perfect drive down to the loop as built, one ingredient after the \
         other. The gain of each row is half of the largest stable one. The bandwidth is the frequency at \
         which {controlled}, as it follows the reference, first falls 3 dB below its value at low \
         frequency. If every gain is stable, nothing limits the bandwidth yet."
    ));
    let bars: Vec<_> = (waterfall.stages.iter())
        .map(|stage| {
            let text = match (stage.bandwidth_hz, stage.largest_gain) {
                (Some(f), Some(gain)) => format!("{}, stability limit {}", with_unit(f, "Hz"), plain(gain)),
                (None, Some(gain)) if gain <= 0.0 => "no gain is stable".to_owned(),
                (None, Some(gain)) => format!("no bandwidth, stability limit {}", plain(gain)),
                (_, None) => "no limit: stable at every gain".to_owned(),
            };
            let size =
                if stage.largest_gain.is_none() { f64::INFINITY } else { stage.bandwidth_hz.unwrap_or(0.0) };
            let name =
                if stage.added == "rigid body" { stage.added.clone() } else { format!("+ {}", stage.added) };
            (name, size, text)
        })
        .collect();
    page.bars(&bars);
    page.paragraph(
        "At half of the stability limit of the row above, the bandwidth shows what an ingredient does by \
         itself. The rest of the difference follows from the gain that it allows.",
    );
    page.table(&waterfall::HEADER, &waterfall::NUMBERS, &waterfall::rows(waterfall));
    page.paragraph(
        "How much higher the stability limit would be without one ingredient, all others present:",
    );
    let rows: Vec<Vec<String>> = (waterfall.without.iter())
        .map(|(name, relief)| {
            let text = match relief {
                Relief::Times(factor) if (factor - 1.0).abs() < UNCHANGED => "unchanged".to_owned(),
                Relief::Times(factor) => format!("{} times", plain(*factor)),
                Relief::Unlimited => "unlimited".to_owned(),
                Relief::Stable => "some are stable, none is with it".to_owned(),
                Relief::NoneEither => "none either".to_owned(),
            };
            vec![name.clone(), text]
        })
        .collect();
    page.table(&["without", "stability limit"], &[1], &rows);
    if let Some(f) = waterfall.saturation_hz {
        page.paragraph(&format!(
            "The final reference of the file asks more of the drive than its limit allows {}, at half of the \
             largest stable gain.",
            if f > 0.0 { format!("from {} on", with_unit(f, "Hz")) } else { "even at rest".to_owned() }
        ));
    }
}

fn sensitivities(page: &mut Page, report: &Report) {
    if report.sensitivities().is_empty() {
        return;
    }
    page.heading("What to stiffen, lighten or damp first");
    let achieved = achieved_name(report);
    let ranked = match report.ranked_by() {
        Some(RankedBy::LargestGain) => {
            "the largest effect on the stability limit first, since the bandwidth lies on the flank of a \
             mode's peak"
        }
        Some(RankedBy::Saturation) => {
            "the largest effect first, on the frequency at which the drive saturates and on the stability \
             limit"
        }
        _ => "the largest effect on both together first; those that raise one and lower the other last",
    };
    page.paragraph(&format!(
        "Change of {achieved} and of the largest stable gain, in per cent, for one per cent more of each \
         number; {ranked}. Blue raises, orange lowers."
    ));
    let bar = |name: String, share: f64| (name, share, format!("{} %", plain(two_digits(share))));
    let bars: Vec<_> = (report.sensitivities().iter().take(MOST_BARS))
        .flat_map(|s| {
            let both = [(achieved, s.bandwidth_relative), ("stability limit", s.largest_gain_relative)];
            both.map(|(what, share)| bar(format!("{}: {what}", s.key), share))
        })
        .filter(|(_, share, _)| share.is_finite())
        .collect();
    page.bars(&bars);
    let percent = |value: f64| if value.is_finite() { plain(value) } else { "-".to_owned() };
    let rows: Vec<Vec<String>> = (report.sensitivities().iter())
        .map(|s| {
            let per_unit = if s.bandwidth_hz_per_unit.is_finite() {
                plain(s.bandwidth_hz_per_unit)
            } else {
                "-".to_owned()
            };
            let trade = if report.ranked_by().is_some_and(|by| s.is_trade(by)) { "trade-off" } else { "" };
            vec![
                s.key.clone(),
                plain(s.value),
                percent(s.bandwidth_relative),
                percent(s.largest_gain_relative),
                per_unit,
                trade.to_owned(),
            ]
        })
        .collect();
    let header = [
        "number",
        "value (SI)",
        &format!("{achieved} (%)"),
        "stability limit (%)",
        &format!("{achieved} (Hz per unit)"),
        "",
    ];
    page.folded_table(&format!("all {} numbers", rows.len()), &header, &[1, 2, 3, 4], &rows);
}

fn modes(page: &mut Page, report: &Report) {
    if report.modes.is_empty() {
        return;
    }
    page.heading("Modes");
    page.paragraph(
        "Colocated: actuator and sensor move in the phase relation of rigid-body motion. Noncolocated: \
         against it. Uninvolved: one of them does not \
         take part. Between modes of one class lies a pair of zeros, so the upper mode takes only the phase \
         that the zeros gave. Between modes of different class there are no zeros. 180° are then lost, \
         unless a pair of zeros farther up returns them. The table lists the phase that each mode takes \
         with its zeros.",
    );
    let edge = report.gain().and_then(|gain| gain.sampled.edge_mode);
    let row = |(i, mode): (usize, &ModeReport)| {
        let class = if mode.rigid_body {
            format!("{}, rigid-body motion", class_name(mode.class))
        } else {
            class_name(mode.class).to_owned()
        };
        let cost = mode.margin_cost_deg.map_or_else(|| "-".to_owned(), plain);
        let breaks = if edge == Some(i) { "unstable first" } else { "" };
        vec![
            plain(mode.frequency_hz),
            plain(damping_ratio(mode)),
            class,
            plain(0.0 - mode.phase_change_deg),
            plain(0.0 - mode.phase_dip_deg),
            cost,
            breaks.to_owned(),
        ]
    };
    let rows: Vec<Vec<String>> = report.modes.iter().enumerate().map(row).collect();
    let header = [
        "frequency (Hz)",
        "damping ratio",
        "class",
        "lost beyond it (°)",
        "largest lag (°)",
        "lost at crossover (°)",
        "",
    ];
    page.table(&header, &[0, 1, 3, 4, 5], &rows);
    page.paragraph(
        "Shapes: displacement of each body towards the workpiece, the largest being 1. An open \
                    orange dot lags or leads by a quarter period.",
    );
    page.drawings(&report.modes.iter().map(shapes::drawing).collect::<Vec<_>>());
}
