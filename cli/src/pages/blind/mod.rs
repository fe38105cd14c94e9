//! The page of a blind benchmark.

mod matrix;

use feeler_diagnosis::blind::{CaseScore, Measure, MeasureUnit, Score};

use crate::numbers::{count, percent, plain};
use crate::pages::parts::{Chart, ChartKind, Page, Series};

pub(crate) fn page(score: &Score) -> String {
    let mut page = Page::new(
        "Blind benchmark of the diagnosis",
        "Datasets whose hidden effect the diagnosis never sees, from a bench that shares no code with it.",
    );
    let missed = score.measures.iter().filter(|measure| measure.value.is_some() && !measure.reached).count();
    let wanted =
        score.measures.iter().filter(|measure| measure.value.is_some() && !measure.wanted.is_empty()).count();
    let answered = match score.unanswered {
        0 => count(score.cases.len(), "case", "cases"),
        none => format!("{}, {none} more without an answer", count(score.cases.len(), "case", "cases")),
    };
    page.lead(&format!("{answered}; {missed} of {} missed.", count(wanted, "goal is", "goals are")));
    page.table(&["measure", "value", "cases", "to reach", ""], &[1, 2], &measure_rows(score));
    page.heading("What was hidden, what was answered");
    page.paragraph(
        "Single effects, effects of no library, and cases where nothing is hidden; how often \
                    each answer was given.",
    );
    page.picture(
        "Confusion,",
        "rows: hidden effect; columns: first cause named. Blue: right, or rightly refused; orange: wrong. \
         Numbers count cases.",
        &matrix::drawing(&score.confusion),
    );
    page.heading("Stated probability against frequency");
    page.paragraph(
        "Every cause named in an answer, binned by its stated probability; on the dashed line, stated and \
         observed frequencies agree.",
    );
    let mut chart = Chart::new(ChartKind::Line, "Reliability,", "stated probability", "how often right");
    chart.caption = "the table gives the number of causes of each point.".into();
    chart.x = std::iter::once(0.0)
        .chain(score.reliability.iter().map(|bin| bin.mean_stated))
        .chain([1.0])
        .collect();
    let right =
        std::iter::once(f64::NAN).chain(score.reliability.iter().map(|bin| bin.frequency)).chain([f64::NAN]);
    chart.series = vec![
        Series::new("how often right", "", right.collect()).dots(),
        Series::new("as stated", "", chart.x.clone()).dashed(),
    ];
    page.chart(&chart);
    let share = |value: f64| format!("{} %", percent(value));
    let rows: Vec<Vec<String>> = score
        .reliability
        .iter()
        .map(|bin| {
            vec![
                format!("{} to {}", share(bin.stated[0]), share(bin.stated[1])),
                share(bin.mean_stated),
                share(bin.frequency),
                bin.count.to_string(),
            ]
        })
        .collect();
    page.table(&["stated", "mean", "right", "causes"], &[1, 2, 3], &rows);
    page.heading("Every case");
    let rows: Vec<Vec<String>> = score.cases.iter().map(case_row).collect();
    page.table(&CASE_COLUMNS, &[], &rows);
    page.render()
}

/// Columns of the table of cases.
pub(crate) const CASE_COLUMNS: [&str; 6] = ["case", "hidden", "answered", "verdict", "plain regression", ""];

pub(crate) fn case_row(case: &CaseScore) -> Vec<String> {
    let mark = match (case.right, case.sure_and_wrong) {
        (true, false) => "right",
        (true, true) => "right, and more accused",
        (false, false) => "missed",
        (false, true) => "missed, and sure",
    };
    vec![
        case.case.clone(),
        case.hidden.join(" + "),
        case.answered.join(" + "),
        case.verdict.clone(),
        case.regression.clone().unwrap_or_default(),
        mark.to_owned(),
    ]
}

/// The table of measures.
pub(crate) fn measure_rows(score: &Score) -> Vec<Vec<String>> {
    let value = |measure: &Measure| match measure.value {
        None => "-".to_owned(),
        Some(value) => match measure.unit {
            MeasureUnit::Seconds => plain(value),
            MeasureUnit::Share => format!("{} %", percent(value)),
        },
    };
    let mark = |measure: &Measure| {
        if measure.wanted.is_empty() || measure.value.is_none() {
            ""
        } else if measure.reached {
            "reached"
        } else {
            "missed"
        }
    };
    let row = |measure: &Measure| {
        vec![
            measure.what.to_owned(),
            value(measure),
            measure.cases.to_string(),
            measure.wanted.clone(),
            mark(measure).to_owned(),
        ]
    };
    score.measures.iter().map(row).collect()
}
