//! Believed values at the limits of their tolerances: their true values may lie beyond. Values fitted
//! together with them are then off as well.

use feeler_plant::description::Site;
use feeler_plant::effects::Place;

use crate::dataset::Dataset;
use crate::fit::candidates::{Candidate, candidates};
use crate::fit::scored::Scored;
use crate::kinds::{SURELY_LATE_ROWS, dossier};

/// Largest delay of commands without a stated hold that raises no doubt, rows. A fast drive interpolates
/// between rows or holds each value, and both act early. A later command may be a short lag.
const UNDOUBTED_ROWS: f64 = 0.2;

/// The subject of a doubt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Doubted {
    /// A believed value, or presliding.
    Value,
    /// Commands that act before they are given. No cause makes them.
    Early,
    /// Commands that act late.
    Late,
    /// A cause that the records neither show nor exclude.
    Cause,
}

/// A cause that may be hidden, or a value that it may have moved.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Doubt {
    /// Place of that value; `None` if it may be at several.
    pub(crate) place: Option<Place>,
    pub(crate) about: Doubted,
    /// The doubt in words.
    pub(crate) what: String,
}

/// The believed values at the limits of their tolerances, commands that act late or at the limit of their
/// timing, and the softest presliding.
pub(super) fn limits(dataset: &Dataset, accepted: &Scored) -> Vec<Doubt> {
    let (model, theta) = (&accepted.fitted.model, &accepted.fitted.theta);
    let all = candidates(&dataset.machine);
    let value = |(site, key, [believed, fitted]): (Site, String, [f64; 2])| {
        let off = if believed == 0.0 {
            format!("{fitted:+.3}")
        } else {
            format!("{:+.0} %", 100.0 * (fitted / believed - 1.0))
        };
        let then =
            if accepted.causes.is_empty() { "" } else { "; then the values of the causes are off too" };
        let what = format!(
            "{key} ends at the limit of its tolerance ({off}): its true value may lie beyond{then} (state a \
             wider tolerance, or correct the believed value)"
        );
        let place = all.iter().find(|cause| cause.site == site).map(|cause| cause.place);
        Doubt { place, about: Doubted::Value, what }
    };
    let values = model.at_limits(theta).into_iter().map(value);
    let rows = model.leeway(theta).late_rows;
    let is_doubtful = model.is_timing_at_limit(theta) || rows > UNDOUBTED_ROWS;
    let column = dataset.first_sampled().filter(|_| is_doubtful);
    let about = if rows < 0.0 { Doubted::Early } else { Doubted::Late };
    let timing = |what: String| Doubt { place: Some(Place::Drive), about, what };
    let shifted = column.map(|column| {
        format!(
            "commands of `{column}` act {rows:+.2} rows late, as fitted: something else may shift them, such \
             as a delay or a lag (state `hold`)"
        )
    });
    let soft = model.is_presliding_softest(theta).then(|| {
        let what =
            "before it slides, a guide yields as softly as fits allow: something else may give way there";
        Doubt { place: None, about: Doubted::Value, what: what.into() }
    });
    let commands = shifted.into_iter().chain(in_all(dataset, accepted)).map(timing);
    values.chain(commands).chain(soft).collect()
}

/// The delay of commands without a stated hold, in words, if causes make it longer than a hold does, but not
/// longer than a hold and its uncertain timing.
fn in_all(dataset: &Dataset, accepted: &Scored) -> Option<String> {
    let (model, theta) = (&accepted.fitted.model, &accepted.fitted.theta);
    let column = dataset.first_sampled()?;
    let spacing_s = dataset.records.first()?.spacing_s;
    let is_late = |(_, cause): &(usize, &Candidate)| {
        dataset.is_sampled_at(cause.site) && dossier(cause.definition.kind).is_late()
    };
    let late = accepted.causes.iter().enumerate().filter(is_late).map(|(i, _)| model.parameters(i, theta)[0]);
    let late_s = late.reduce(|a, b| a + b)?;
    let rows = model.leeway(theta).late_rows + late_s / spacing_s;
    (rows < SURELY_LATE_ROWS).then(|| {
        format!(
            "commands of `{column}` act {rows:.2} rows late in all, as fitted: up to {SURELY_LATE_ROWS} rows \
             may be a hold with uncertain timing (state `hold`)"
        )
    })
}
