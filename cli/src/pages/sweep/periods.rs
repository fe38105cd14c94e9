//! Number of impacts per period of the motion, over one axis.

use feeler_studies::sweep::DrawnAxis;

use super::palette::labels;
use super::report::Report;
use crate::numbers::plain;
use crate::pages::parts::Page;

/// Largest number of rows of the table.
const MOST_ROWS: usize = 24;

/// A variant at its place on the axis.
#[derive(Clone, Debug)]
struct Variant {
    at: f64,
    outcome: String,
    /// Number of impacts per period; `None` if no two impacts are alike.
    impacts: Option<usize>,
    frequency_hz: Option<f64>,
}

impl Variant {
    fn chatters(&self) -> bool {
        self.outcome == "chatter"
    }

    fn is_like(&self, other: &Self) -> bool {
        (&self.outcome, self.impacts) == (&other.outcome, other.impacts)
    }
}

/// The variants by increasing value, divided into stretches with one outcome and one number of impacts per
/// period.
fn stretches(variants: &[Variant]) -> Vec<&[Variant]> {
    variants.chunk_by(Variant::is_like).collect()
}

/// Places at which the number of impacts per period doubles between neighbours, up or down the axis.
fn doublings(stretches: &[&[Variant]], key: &str) -> Vec<String> {
    let between = stretches.windows(2).filter_map(|pair| Some((pair[0].last()?, pair[1].first()?)));
    let sentences = between.filter_map(|(a, b)| {
        let (from, to) = (a.impacts?, b.impacts?);
        let doubles = a.chatters() && b.chatters() && (to == 2 * from || from == 2 * to);
        doubles
            .then(|| format!("between {key} = {} and {} ({from} to {to} impacts)", plain(a.at), plain(b.at)))
    });
    sentences.collect()
}

impl Report<'_> {
    /// The variants of a panel that chatter, by their number of impacts per period.
    pub(super) fn periods(&self, axis: &DrawnAxis, rows: &[usize], title: &str, page: &mut Page) {
        let column = |name: &str| self.table.reals(name).unwrap_or_default();
        let (at, impacts, frequencies) =
            (column(&axis.key), column("impacts_per_period"), column("frequency_hz"));
        let value = |column: &[Option<f64>], row: usize| column.get(row).copied().flatten();
        let variant = |&row: &usize| {
            Some(Variant {
                at: value(&at, row)?,
                outcome: self.outcomes[row].clone(),
                impacts: value(&impacts, row).map(|impacts| impacts as usize),
                frequency_hz: value(&frequencies, row),
            })
        };
        let mut variants: Vec<Variant> = rows.iter().filter_map(variant).collect();
        if !variants.iter().any(Variant::chatters) {
            return;
        }
        variants.sort_by(|a, b| a.at.total_cmp(&b.at));
        let stretches = stretches(&variants);
        page.heading(&if title.is_empty() { "Periods".to_owned() } else { format!("Periods, {title}") });
        let found = doublings(&stretches, &axis.key);
        page.paragraph(&if found.is_empty() {
            "After how many impacts the motion repeats. Its period doubles nowhere between neighbours."
                .to_owned()
        } else {
            format!(
                "After how many impacts the motion repeats. Its period doubles, which halves its frequency, \
                 {}.",
                found.join("; ")
            )
        });
        if stretches.len() > MOST_ROWS {
            page.paragraph(&format!(
                "The table has the first {MOST_ROWS} of {} stretches; sweep.parquet has all.",
                stretches.len()
            ));
        }
        let row = |stretch: &&[Variant]| {
            let (first, last) = (stretch.first()?, stretch.last()?);
            let hz = |variant: &Variant| variant.frequency_hz.map_or_else(|| "-".to_owned(), plain);
            let impacts = match (first.chatters(), first.impacts) {
                (true, Some(impacts)) => impacts.to_string(),
                (true, None) => "no two alike".to_owned(),
                _ => "-".to_owned(),
            };
            let outcome = labels().find(|(name, _)| *name == first.outcome);
            let outcome = outcome.map_or_else(|| first.outcome.clone(), |(_, label)| label.to_owned());
            Some(vec![plain(first.at), plain(last.at), outcome, impacts, hz(first), hz(last)])
        };
        let shown: Vec<Vec<String>> = stretches.iter().take(MOST_ROWS).filter_map(row).collect();
        let from = if axis.unit.is_empty() {
            format!("{} from", axis.key)
        } else {
            format!("{} ({}) from", axis.key, axis.unit)
        };
        let head = [from.as_str(), "to", "outcome", "impacts per period", "repeats at (Hz)", "to (Hz)"];
        page.table(&head, &[0, 1, 4, 5], &shown);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn variants(impacts: &[Option<usize>]) -> Vec<Variant> {
        let at = |(i, impacts): (usize, &Option<usize>)| Variant {
            at: 1.0 + 0.5 * i as f64,
            outcome: if *impacts == Some(0) { "settled" } else { "chatter" }.to_owned(),
            impacts: impacts.filter(|count| *count > 0),
            frequency_hz: impacts.filter(|count| *count > 0).map(|count| 20.0 / count as f64),
        };
        impacts.iter().enumerate().map(at).collect()
    }

    #[test]
    fn truth_doublings_are_found_up_and_down_the_axis() {
        let (one, two, four, chaos) = (Some(1), Some(2), Some(4), None);
        let found = variants(&[Some(0), one, one, two, two, four, chaos, one, two]);
        let stretches = stretches(&found);
        let lengths: Vec<usize> = stretches.iter().map(|stretch| stretch.len()).collect();
        assert_eq!(lengths, [1, 2, 2, 1, 1, 1, 1]);
        assert_eq!(
            doublings(&stretches, "kp"),
            [
                "between kp = 2 and 2.5 (1 to 2 impacts)",
                "between kp = 3 and 3.5 (2 to 4 impacts)",
                "between kp = 4.5 and 5 (1 to 2 impacts)",
            ]
        );
        let falls = variants(&[two, one]);
        assert_eq!(doublings(&super::stretches(&falls), "kp"), ["between kp = 1 and 1.5 (2 to 1 impacts)"]);
        let steady = variants(&[one, one]);
        assert!(doublings(&super::stretches(&steady), "kp").is_empty());
    }
}
