//! The page of a measured frequency response.

use feeler_lti::C64;

use super::analyze::degrees;
use crate::commands::frf::{Response, row};
use crate::numbers::{plain, with_unit};
use crate::page::{Chart, ChartKind, Line, Page, Series, Tile, by_extremes};

/// Points of each curve.
const MOST_POINTS: usize = 4000;
/// Charts that zoom together.
const TOGETHER: &str = "frequency";

/// The page of a response.
pub(crate) fn page(response: &Response) -> String {
    let mut page = Page::new(&format!("{}: frequency response", response.title), &response.about);
    page.lead(&format!("From {} to {}.", response.input, response.output));
    page.paragraph(&format!("{}.", capital(&response.how)));
    for sentence in response.sentences().iter().chain(&response.notes) {
        page.paragraph(&capital(sentence));
    }
    page.tiles(&tiles(response));
    page.heading("Response");
    page.paragraph(&format!(
        "The linear response is that of the machine with its command held for {} and its output sampled as often, delays exact.",
        with_unit(response.hold_s, "s")
    ));
    let decibels: Vec<f64> = response.estimate.response.iter().map(|g| 20.0 * g.norm().log10()).collect();
    let kept = by_extremes(&[&decibels], decibels.len(), MOST_POINTS);
    for chart in charts(response, &kept) {
        page.chart(&chart);
    }
    page.render()
}

fn tiles(response: &Response) -> Vec<Tile> {
    let agreement = response.agreement();
    let tile = |name, value: String, remark: String| Tile { name, value, remark };
    vec![
        tile("frequencies", response.linear.len().to_string(), format!("{} compared", agreement.compared)),
        tile("largest difference", format!("{} dB", plain(agreement.decibels)), "from the linear response".into()),
        tile("and in phase", format!("{}°", plain(agreement.degrees)), "from the linear response".into()),
        tile("within the band", format!("{} %", plain((100.0 * agreement.within).round())), "of frequencies".into()),
    ]
}

fn charts(response: &Response, kept: &[usize]) -> Vec<Chart> {
    let estimate = &response.estimate;
    let rows: Vec<_> = kept.iter().map(|&i| row(response, i)).collect();
    let column = |of: &dyn Fn(&crate::commands::frf::Row) -> f64| rows.iter().map(of).collect::<Vec<f64>>();
    let pick = |values: &[C64]| kept.iter().map(|&i| values[i]).collect::<Vec<_>>();
    let band = format!("{} % band", plain(100.0 * response.confidence));
    let new = |title: &str, caption: &str, label: &str, series: Vec<Series>| {
        let mut chart = Chart::new(ChartKind::Line, title, "frequency (Hz)", label);
        caption.clone_into(&mut chart.caption);
        (chart.x_log, chart.together) = (true, Some(TOGETHER));
        chart.x = kept.iter().map(|&i| estimate.frequencies_hz[i]).collect();
        chart.series = series;
        chart
    };
    let magnitude = vec![
        Series::new("measured", "dB", column(&|r| r.magnitude_db)),
        Series::new("linear", "dB", column(&|r| r.linear_db)).dashed(),
        Series::new(format!("{band}, low"), "dB", column(&|r| r.low_db)),
        Series::new(format!("{band}, high"), "dB", column(&|r| r.high_db)),
    ];
    let phase = vec![
        Series::new("measured", "°", degrees(&pick(&estimate.response))),
        Series::new("linear", "°", degrees(&pick(&response.linear))).dashed(),
    ];
    let mut all = vec![
        new("Magnitude,", "measured and by linear theory, with the confidence band of the measurement.", "magnitude (dB)", magnitude),
        new("Phase,", "measured and by linear theory.", "phase (°)", phase),
    ];
    let ratio: Vec<C64> = kept.iter().map(|&i| estimate.response[i] / response.linear[i]).collect();
    let mut off = new(
        "Difference,",
        "measured over linear, magnitude.",
        "difference (dB)",
        vec![Series::new("measured over linear", "dB", ratio.iter().map(|g| 20.0 * g.norm().log10()).collect())],
    );
    off.lines.push(Line { y: 0.0, label: "no difference".into() });
    all.push(off);
    if estimate.coherence.is_some() {
        let caption = "the share of the output that the input explains linearly; below 1 there is noise, leakage or nonlinearity.";
        all.push(new("Coherence,", caption, "coherence", vec![Series::new("coherence", "", column(&|r| r.coherence))]));
    }
    if response.told_apart.is_some() {
        let caption =
            "what differs from period to period is noise; what differs from realisation to realisation beyond it is nonlinear distortion.";
        let series = vec![
            Series::new("response", "dB", column(&|r| r.magnitude_db)),
            Series::new("noise", "dB", column(&|r| r.noise_db)),
            Series::new("nonlinear distortion", "dB", column(&|r| r.distortion_db)),
        ];
        all.push(new("Noise and distortion,", caption, "level (dB)", series));
    }
    all
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
