//! The page of a measured frequency response.

pub(crate) mod words;

use feeler_lti::C64;
use feeler_studies::frf::{FrequencyResponse, FrfRow, row};

use super::analyze::degrees;
use crate::numbers::{plain, with_unit};
use crate::pages::parts::{Chart, ChartKind, Line, Page, Series, Tile, by_extremes};

/// Largest number of points of each curve.
const MOST_POINTS: usize = 4000;
/// Name shared by charts that zoom together.
const TOGETHER: &str = "frequency";

/// The page of a response.
pub(crate) fn page(response: &FrequencyResponse) -> String {
    let mut page = Page::new(&format!("{}: frequency response", response.title), &response.about);
    page.lead(&words::headline(response));
    page.paragraph(&format!("{}.", capital(&words::path(response))));
    page.paragraph(&format!("{}.", capital(&response.how)));
    for sentence in &words::sentences(response) {
        page.paragraph(sentence);
    }
    for note in &response.notes {
        page.paragraph(&format!("{}.", capital(note)));
    }
    page.tiles(&tiles(response));
    page.heading("Response");
    page.paragraph(&format!(
        "The linear response is that of the machine with its command held for {} and its output sampled as \
         often, delays exact.",
        with_unit(response.hold_s, "s")
    ));
    for chart in charts(response) {
        page.chart(&chart);
    }
    page.render()
}

fn tiles(response: &FrequencyResponse) -> Vec<Tile> {
    let agreement = response.agreement();
    let tile = |name, value: String, remark: String| Tile::new(name, value, remark);
    vec![
        tile("frequencies", response.linear.len().to_string(), format!("{} compared", agreement.compared)),
        tile(
            "largest difference",
            words::apart(agreement.widest[0], " dB"),
            format!("at {}, over all frequencies", with_unit(agreement.widest[1], "Hz")),
        ),
        tile(
            "largest where well known",
            words::apart(agreement.decibels, " dB"),
            format!("at the {} compared", agreement.compared),
        ),
        tile(
            "largest in phase",
            words::apart(agreement.degrees, "°"),
            format!("at the {} compared", agreement.compared),
        ),
        tile(
            "within the band",
            format!("{} %", plain((100.0 * agreement.within).round())),
            "of frequencies".into(),
        ),
    ]
}

/// A frequency of the charts: one of the estimate, or one in between that has only the linear response.
struct Place {
    frequency_hz: f64,
    row: Option<FrfRow>,
    linear: C64,
    measured: C64,
}

/// The frequencies of the charts, rising: those of the estimate, thinned out if there are many, and those in
/// between.
fn places(response: &FrequencyResponse) -> Vec<Place> {
    let estimate = &response.estimate;
    let decibels: Vec<f64> = estimate.response.iter().map(|g| 20.0 * g.norm().log10()).collect();
    let of_estimate = by_extremes(&[&decibels], decibels.len(), MOST_POINTS).into_iter().map(|i| Place {
        frequency_hz: estimate.frequencies_hz[i],
        row: Some(row(response, i)),
        linear: response.linear[i],
        measured: estimate.response[i],
    });
    let none = C64::new(f64::NAN, f64::NAN);
    let between = response.between.iter().map(|&(frequency_hz, linear)| Place {
        frequency_hz,
        row: None,
        linear,
        measured: none,
    });
    let mut places: Vec<Place> = of_estimate.chain(between).collect();
    places.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    places
}

fn charts(response: &FrequencyResponse) -> Vec<Chart> {
    let drawing = Drawing { response, places: places(response) };
    let linear_deg = degrees(&drawing.places.iter().map(|place| place.linear).collect::<Vec<_>>());
    // Noise may shift a continued phase by whole turns. The ratio to the linear response avoids this.
    let off: Vec<C64> = drawing.places.iter().map(|place| place.measured / place.linear).collect();
    let measured_deg =
        linear_deg.iter().zip(&off).map(|(linear, off)| linear + off.arg().to_degrees()).collect();
    let phase = drawing.chart(
        "Phase,",
        "measured and by linear theory; whole turns are chosen so that both are close.",
        "phase (°)",
        vec![
            drawing.measured("measured", "°", measured_deg),
            Series::new("linear", "°", linear_deg).dashed(),
        ],
    );
    let mut all = vec![drawing.magnitude(), phase, drawing.difference(&off)];
    if response.estimate.coherence.is_some() {
        let caption = "the share of the output that the input explains linearly; below 1 there is noise, \
                       leakage or nonlinearity.";
        let series = drawing.measured("coherence", "", drawing.column(&|r| r.coherence));
        all.push(drawing.chart("Coherence,", caption, "coherence", vec![series]));
    }
    if let Some(levels) = &response.separated {
        all.extend(drawing.levels(levels.evidence.is_beyond_noise));
    }
    all
}

/// The charts of a response over their frequencies.
struct Drawing<'a> {
    response: &'a FrequencyResponse,
    places: Vec<Place>,
}

impl Drawing<'_> {
    fn column(&self, of: &dyn Fn(&FrfRow) -> f64) -> Vec<f64> {
        self.places.iter().map(|place| place.row.as_ref().map_or(f64::NAN, of)).collect()
    }

    fn measured(&self, name: &str, unit: &str, values: Vec<f64>) -> Series {
        let series = Series::new(name, unit, values);
        if self.response.isolated { series.dots() } else { series }
    }

    fn chart(&self, title: &str, caption: &str, label: &str, series: Vec<Series>) -> Chart {
        let mut chart = Chart::new(ChartKind::Line, title, "frequency (Hz)", label);
        caption.clone_into(&mut chart.caption);
        (chart.x_log, chart.together) = (true, Some(TOGETHER));
        chart.x = self.places.iter().map(|place| place.frequency_hz).collect();
        chart.series = series;
        chart
    }

    fn magnitude(&self) -> Chart {
        let band = format!("{} % band", plain(100.0 * self.response.confidence));
        let edge =
            |side: &str, values| self.measured(&format!("{band}, {side}"), "dB", values).faint().coloured(0);
        let linear = self.places.iter().map(|place| 20.0 * place.linear.norm().log10()).collect();
        let mut chart = self.chart(
            "Magnitude,",
            "measured and by linear theory, with the confidence band of the measurement.",
            "magnitude (dB)",
            vec![
                self.measured("measured", "dB", self.column(&|r| r.magnitude_db)),
                Series::new("linear", "dB", linear).dashed(),
                edge("low", self.column(&|r| r.low_db)),
                edge("high", self.column(&|r| r.high_db)),
            ],
        );
        chart.between.push([3, 2]);
        chart
    }

    /// Ratio of measured to linear response, with well and poorly known parts separated.
    fn difference(&self, off: &[C64]) -> Chart {
        let (estimate, is_known) = (&self.response.estimate, self.response.is_known());
        let known_at: Vec<f64> =
            estimate.frequencies_hz.iter().zip(&is_known).filter(|(_, k)| **k).map(|(f, _)| *f).collect();
        let apart = |wanted: bool| {
            let of = |(place, g): (&Place, &C64)| {
                let known = known_at.binary_search_by(|f| f.total_cmp(&place.frequency_hz)).is_ok();
                if known == wanted { 20.0 * g.norm().log10() } else { f64::NAN }
            };
            self.places.iter().zip(off).map(of).collect::<Vec<f64>>()
        };
        let mut chart = self.chart(
            "Difference,",
            "measured over linear, magnitude; in a second colour where noise or nonlinearity is large.",
            "difference (dB)",
            vec![
                self.measured("where well known", "dB", apart(true)),
                Series::new("where poorly known", "dB", apart(false)).dots(),
            ],
        );
        chart.lines.push(Line { y: 0.0, label: "no difference".into() });
        chart
    }

    /// Levels of noise and distortion; `None` if both are rounding errors.
    fn levels(&self, is_beyond_noise: bool) -> Option<Chart> {
        let is_level = |row: &FrfRow| words::is_level(row.noise_db, row.magnitude_db);
        if !is_beyond_noise && !self.places.iter().filter_map(|place| place.row.as_ref()).any(is_level) {
            return None;
        }
        let caption = if is_beyond_noise {
            "differences between periods are noise; further differences between realisations are nonlinear \
             distortion."
        } else {
            "differences between periods are noise; there is no sign of nonlinear distortion."
        };
        let level = |name: &str, of: &dyn Fn(&FrfRow) -> f64| self.measured(name, "dB", self.column(of));
        let mut series = vec![level("response", &|r| r.magnitude_db), level("noise", &|r| r.noise_db)];
        series.extend(is_beyond_noise.then(|| level("nonlinear distortion", &|r| r.distortion_db)));
        Some(self.chart("Noise and distortion,", caption, "level (dB)", series))
    }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
