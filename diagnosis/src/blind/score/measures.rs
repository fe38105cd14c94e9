//! Counts over all cases, and the table of measures.

use super::super::regression::named;
use super::answered::{Calibration, Measure, MeasureUnit, ScoredValue};
use super::goals::Goals;
use super::judge::{Hides, Judged};
use super::reliability;

/// Range for the share of true values within their stated 90 % intervals.
const COVERED: [f64; 2] = [0.85, 0.95];

/// Counts of right answers.
#[derive(Default)]
struct Tally {
    right: usize,
    of: usize,
}

impl Tally {
    fn add(&mut self, right: bool) {
        self.of += 1;
        self.right += usize::from(right);
    }

    fn share(&self) -> Option<f64> {
        (self.of > 0).then(|| self.right as f64 / self.of as f64)
    }

    fn measure(&self, what: &'static str, goal: Goal) -> Measure {
        Measure::share(what, self.share(), self.of, goal)
    }
}

/// Goal of a measure.
#[derive(Clone, Copy)]
enum Goal {
    None,
    AtLeast(f64),
    AtMost(f64),
    Within([f64; 2]),
}

impl Goal {
    fn reached(self, value: f64) -> bool {
        match self {
            Self::None => true,
            Self::AtLeast(least) => value >= least,
            Self::AtMost(most) => value <= most,
            Self::Within([low, high]) => (low..=high).contains(&value),
        }
    }

    fn words(self, unit: MeasureUnit) -> String {
        let size = |x: f64| match unit {
            MeasureUnit::Share => format!("{:.0} %", 100.0 * x),
            MeasureUnit::Seconds => format!("{x:.0}"),
        };
        match self {
            Self::None => String::new(),
            Self::AtLeast(least) => format!("at least {}", size(least)),
            Self::AtMost(0.0) => "never".into(),
            Self::AtMost(most) => format!("at most {}", size(most)),
            Self::Within([low, high]) => format!("{:.0} to {}", 100.0 * low, size(high)),
        }
    }
}

impl Measure {
    fn new(what: &'static str, value: Option<f64>, unit: MeasureUnit, cases: usize, goal: Goal) -> Self {
        let reached = value.is_some_and(|value| goal.reached(value));
        Self { what, value, unit, cases, wanted: goal.words(unit), reached }
    }

    fn share(what: &'static str, value: Option<f64>, cases: usize, goal: Goal) -> Self {
        Self::new(what, value, MeasureUnit::Share, cases, goal)
    }

    fn median(what: &'static str, values: &[f64], unit: MeasureUnit, goal: Goal) -> Self {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        Self::new(what, sorted.get(sorted.len() / 2).copied(), unit, sorted.len(), goal)
    }
}

/// Everything that is counted.
#[derive(Default)]
pub(super) struct Tallies {
    sure_and_wrong: Tally,
    place: Tally,
    first: Tally,
    decidable: Tally,
    top3: Tally,
    pair: Tally,
    pair_alike: Tally,
    outside: Tally,
    alarm: Tally,
    inside: Tally,
    free_run: Tally,
    undecidable: Tally,
    undecidable_named: Tally,
    regression: [Tally; 2],
    beside_regression: [Tally; 2],
    errors: Vec<f64>,
    closed: Vec<f64>,
    claims: Vec<f64>,
    times: Vec<f64>,
    /// Probabilities that were stated, and whether they were right.
    pub(super) stated: Vec<(f64, bool)>,
}

impl Tallies {
    pub(super) fn add(&mut self, judged: &Judged<'_>) {
        let answer = judged.answer;
        let right = judged.is_right();
        self.times.push(answer.wall_s);
        self.sure_and_wrong.add(judged.is_sure_and_wrong());
        match judged.hides {
            Hides::Nothing => self.alarm.add(!right),
            Hides::NoLibrary(_) => self.outside.add(right),
            Hides::One(one) => {
                let place = judged.place_is(one);
                self.place.add(place);
                self.first.add(right);
                self.top3.add(judged.is_among_first_three(one));
                self.closed.push(answer.claimed);
                self.add_regression(judged, right, place);
            }
            Hides::Several(_) => {
                self.pair.add(right);
                self.pair_alike.add(judged.names_all_or_alike());
                self.closed.push(answer.claimed);
            }
        }
        if let Some([believed, repaired]) = answer.free_run {
            self.free_run.add(repaired > believed);
        }
        if let Some(closed) = answer.closed_held_back.filter(|_| !judged.accepted.is_empty()) {
            self.claims.push((answer.claimed - closed).abs());
        }
        let is_hidden = |kind: &str| judged.case.effects.iter().any(|hidden| hidden.kind == kind);
        for effect in &answer.effects {
            if is_hidden(&effect.kind) || !judged.case.allowed.contains(&effect.kind) {
                self.stated.push((effect.probability, is_hidden(&effect.kind)));
            }
        }
        self.add_values(&judged.values());
    }

    /// Adds a single effect to the comparison with the plain regression.
    fn add_regression(&mut self, judged: &Judged<'_>, right: bool, place: bool) {
        let Hides::One(one) = judged.hides else { return };
        if let Some(undecidable) = judged.is_undecidable() {
            self.undecidable.add(undecidable);
            if undecidable {
                self.undecidable_named.add(judged.is_named_at_all(one));
            } else {
                self.decidable.add(right);
            }
        }
        if judged.regression.is_empty() {
            return;
        }
        let best = named(judged.regression);
        self.regression[0].add(best.is_some_and(|best| best.kind == one.kind));
        self.regression[1].add(best.is_some_and(|best| best.place == one.place));
        self.beside_regression[0].add(right);
        self.beside_regression[1].add(place);
    }

    fn add_values(&mut self, values: &[ScoredValue]) {
        for value in values {
            self.errors.extend(value.fitted.map(|fitted| (fitted / value.hidden - 1.0).abs()));
            // A value that was not fitted has no interval.
            if let Some([low, high]) = value.interval.filter(|[low, high]| high > low) {
                self.inside.add((low..=high).contains(&value.hidden));
            }
        }
    }

    pub(super) fn measures(&self, reliability: &[Calibration], goals: &Goals) -> Vec<Measure> {
        let calibration = (!self.stated.is_empty()).then(|| reliability::error(reliability));
        let worst = self.times.iter().copied().reduce(f64::max);
        let mut measures = vec![
            self.sure_and_wrong.measure("\"explained\" but wrong", Goal::AtMost(goals.sure_and_wrong)),
            self.place.measure("place right, single effect of the library", Goal::AtLeast(goals.place)),
            self.first.measure(
                "kind right at rank 1, look-alikes as a set of at most 3",
                Goal::AtLeast(goals.kind),
            ),
            self.top3.measure("kind among the first 3", Goal::None),
            self.pair.measure("both of two effects found", Goal::AtLeast(goals.pair)),
            self.pair_alike.measure("both of two, or declared look-alikes of them", Goal::None),
            self.outside.measure("effect of no library: refused, place right", Goal::AtLeast(goals.outside)),
            self.alarm.measure("false alarm where nothing is hidden", Goal::AtMost(goals.alarm)),
            Measure::median("parameter error, median", &self.errors, MeasureUnit::Share, Goal::AtMost(0.05)),
            self.inside.measure("true values inside their stated 90 % interval", Goal::Within(COVERED)),
            Measure::median(
                "share of the gap closed, median",
                &self.closed,
                MeasureUnit::Share,
                Goal::AtLeast(0.9),
            ),
            Measure::median(
                "claimed against held-back closing, median difference",
                &self.claims,
                MeasureUnit::Share,
                Goal::AtMost(0.1),
            ),
            Measure::share(
                "expected calibration error of stated probabilities",
                calibration,
                self.stated.len(),
                Goal::AtMost(goals.calibration),
            ),
            self.free_run
                .measure("free run of the repaired machine worse than the believed one", Goal::AtMost(0.0)),
            Measure::median(
                "wall time of a diagnosis (s), median",
                &self.times,
                MeasureUnit::Seconds,
                Goal::AtMost(goals.median_s),
            ),
            Measure::new(
                "wall time of a diagnosis (s), worst",
                worst,
                MeasureUnit::Seconds,
                self.times.len(),
                Goal::AtMost(goals.worst_s),
            ),
        ];
        measures.extend(self.beside());
        measures
    }

    /// Measures of the plain regression and of the diagnosis on the same cases. The regression must never be
    /// better.
    fn beside(&self) -> Vec<Measure> {
        let [kind, place] = &self.regression;
        let as_good = |tally: &Tally| tally.share().map_or(Goal::None, Goal::AtLeast);
        vec![
            kind.measure("plain regression: kind right", Goal::None),
            self.beside_regression[0].measure("diagnosis on the same cases: kind right", as_good(kind)),
            place.measure("plain regression: place right", Goal::None),
            self.beside_regression[1].measure("diagnosis on the same cases: place right", as_good(place)),
            self.undecidable
                .measure("not decidable: the truth, fitted, is not ahead of every other cause", Goal::None),
            self.undecidable_named
                .measure("not decidable: kind named, as cause, rival or look-alike", Goal::None),
            self.decidable.measure("decidable: kind right at rank 1", Goal::None),
        ]
    }
}
