//! Composes the answer from the results of the search.

use feeler_plant::description::{Actuator, Machine};
use feeler_plant::effects::{Place, Trait};
use indexmap::IndexMap;

use crate::adequacy::{Adequacy, Criteria, Doubted, Sizes, as_good, as_good_but_small, assess, further};
use crate::answer::causes::{Field, look_alikes};
use crate::answer::errors::{Errors, ROUGH};
use crate::answer::next::next_experiment;
use crate::budget::Stage;
use crate::dataset::in_words;
use crate::fit::least_squares::Fitted;
use crate::fit::scored::Scored;
use crate::gap::ladder::{ladder, missing_force, what_is_left};
use crate::gap::locate::{heart, table};
use crate::gap::size;
use crate::gap::unknown::{self, in_sigmas};
use crate::judge::{Attempts, Judge, LOOK_ALIKE};
use crate::kinds::LATE_ROWS;
use crate::report::{Cause, Diagnosis, Gap, GapCell, Verdict, Where};

/// Smallest probability of a cause that is reported without its rivals.
const SURE: f64 = 0.9;
/// Factor on all probabilities if an answer is not adequate, because the true cause may then be missing. Of
/// 29 such causes on four ordinary seeds 21 were right.
const INADEQUATE: f64 = 0.8;
/// The same where a balance of forces counts. Of 180 such causes on three wild seeds 54 were right.
const INADEQUATE_SLOW: f64 = 0.45;
/// The factor if another explanation may be as good, or a believed value ends at the limit of its tolerance.
/// On these seeds 199 of 278 such causes were right, which their rivals explain in part.
const RIVALLED: f64 = 0.85;
/// Probability of the place that a residual indicates if the causes are unsure or the residual depends on
/// little. On a wild seed 2 of 6 places were right beside unsure causes. At equal probability the place of a
/// cause comes first.
const POINTED: f64 = 0.19;
/// The same if the residual points clearly and no cause was found or left untried.
const POINTED_ALONE: f64 = 0.7;
/// Probability of the place of a drive if commands act late, as fitted, and nothing else is found. On three
/// wild seeds a cause was hidden there in 9 of 10 such cases; Laplace's rule gives 10 of 12. At other
/// doubtful values a cause was hidden in 2 of 6. Their probability is [`POINTED`].
const SHIFTED: f64 = 0.8;
/// Probability of the place of a cause that calibration may hide. On three wild seeds a cause was hidden
/// there in 7 of 16 cases.
const HIDDEN: f64 = 0.45;
/// Causes that make the error of short predictions this many times as large explain nothing.
const WORSE: f64 = 1.1;
/// Smallest number of places among look-alike causes at which the records do not determine the place.
const PLACES_TO_TELL: usize = 3;
/// Smallest ratio of variation to noise that a channel needs in its best experiment.
const ENOUGH_EXCITATION: f64 = 5.0;
/// The ratio that suffices for a single channel: an encoder alone is enough if its resolution is fine.
const ENOUGH_ALONE: f64 = 50.0;

/// The assumption on a winding that warms: no measurement shows its temperature at the start of a record.
fn cold_start(machine: &Machine) -> Option<String> {
    let warms = |drive: &Actuator| drive.effects.iter().any(|effect| effect.definition.has(Trait::Drift));
    let (name, _) = machine.actuators.iter().find(|(_, drive)| warms(drive))?;
    Some(format!(
        "`{name}`: if a record does not follow another on its clock, its winding counts as cold. Rest for \
         several `time_constant` before each: after a warm start the gain is too small and `force` too \
         large. Between records on one clock the drive counts as at rest"
    ))
}

/// The reason for an unsure verdict if all conditions hold. `own` is the probability of the effects found
/// among their look-alikes.
fn unsure(verdict: Verdict, own: f64) -> Option<String> {
    match verdict {
        Verdict::Ambiguous => Some(format!(
            "other causes explain nearly as much: the effects found have a probability of {:.0} %",
            100.0 * own
        )),
        Verdict::NotIdentifiable => Some("the records do not show at which place the cause is".into()),
        Verdict::Explained | Verdict::NoGap | Verdict::UnknownCause => None,
    }
}

impl Judge<'_> {
    /// The reasons why an answer is not called explained, and the proposed machine. `sigma` holds the
    /// deviations of the accepted set's values.
    fn adequacy(
        &self,
        (accepted, sigma): (&Scored, &[f64]),
        field: &Field,
        balanced: &[&Scored],
        attempts: &Attempts,
        sizes: Sizes,
    ) -> (Adequacy, Machine) {
        let mut adequacy = assess(self, accepted, &field.sets, balanced, sizes);
        let all: Vec<&Scored> = attempts.fitted.iter().chain(&attempts.screened).collect();
        adequacy.add_rivals(further(self, accepted, &all, &Criteria::default()));
        if !accepted.causes.is_empty() {
            adequacy.add_rivals(as_good_but_small(self, accepted, &all, &Criteria::default()));
        }
        adequacy.add_rivals(self.maybe_absent(accepted, sigma));
        // After the end of composing every fit stops at its start.
        let is_late = self.search.task.budget.is_over(Stage::Compose) && !attempts.fitted.is_empty();
        let is_unfinished = is_late || attempts.is_cut || !attempts.unfinished.is_empty();
        adequacy.add_untried(attempts.untried.len(), is_unfinished);
        if self.dataset.warnings.iter().any(|fault| fault.kind.is_contradiction()) {
            adequacy.add_contradiction();
        }
        let mut left = unknown::unexplained(&self.search.calibrated, accepted);
        let is_elongation = |c: usize| self.search.task.weights.is_elongation(c);
        left.retain(|(c, sigmas)| adequacy.is_unexplained(*sigmas, is_elongation(*c)));
        let column = |(c, sigmas): (usize, f64)| (self.search.task.weighed_as(c), sigmas);
        adequacy.add_unexplained(left.into_iter().map(column));
        let machine = self.proposed(accepted, &mut adequacy);
        (adequacy, machine)
    }

    /// Whether causes make short predictions worse than calibration does, or remove little of a slight error.
    fn explains_nothing(&self, accepted: &Scored, gap: &Gap, adequacy: &Adequacy) -> bool {
        let is_worse = gap.after > WORSE * gap.refit;
        let removes_much = gap.refit > ROUGH * gap.floor && gap.closed >= adequacy.criteria.least_closed;
        let is_shown = || adequacy.is_replaced || self.is_play(accepted);
        !accepted.causes.is_empty() && (is_worse || adequacy.is_slight() && !removes_much) && !is_shown()
    }

    pub(crate) fn answer(&self, accepted: &Scored, rivals: &[Scored], attempts: &Attempts) -> Diagnosis {
        let task = &self.search.task;
        let checks = self.checks();
        let calibrated = &self.search.calibrated;
        let Errors { refit, after, noise, read, gap } = self.errors(accepted);

        let field = self.field(accepted, rivals);
        let missing_force_n = [calibrated, accepted].map(|scored| missing_force(task, scored, &checks));
        let sizes = self.sizes(accepted, missing_force_n, &gap, read);
        let tried = [attempts.fitted.as_slice(), &attempts.screened].into_iter();
        let balanced: Vec<&Scored> =
            tried.flat_map(|tried| as_good(self, accepted, tried, &Criteria::default())).collect();
        let sigma = self.deviations(accepted);
        let (mut adequacy, machine) =
            self.adequacy((accepted, &sigma.cautious), &field, &balanced, attempts, sizes);
        let adequate = !adequacy.is_short();
        if !adequate && self.explains_nothing(accepted, &gap, &adequacy) {
            return self.answer(calibrated, &[], attempts);
        }
        let known = self.certainty(&adequacy);
        let mut effects = self.causes(accepted, &field, (known, &sigma), &attempts.fitted);
        let look_alikes = look_alikes(accepted, &field, &balanced, &effects, self.gain_or_mass(accepted));
        let removed = self.removed(accepted);
        self.credit(accepted, &removed, &refit, &after, &mut effects);
        let near: Vec<&Scored> = alike(accepted, &field.sets, &field.evidence);
        let is_alone = field.own >= SURE && !adequacy.has_rival();
        let may_be_right = adequate || accepted.causes.is_empty() && adequacy.is_slight();
        let verdict = self.verdict(accepted, may_be_right, is_alone, &near);
        let verdict = self.doubted(verdict, &mut adequacy, gap.refit > ROUGH * gap.floor, attempts);
        if adequacy.shortfalls.is_empty() {
            adequacy.add_rivals(unsure(verdict, field.own).into_iter().collect());
        }
        let (refitted, repaired) = (&calibrated.fitted, &accepted.fitted);
        let believed = refitted.model.start();
        let cells = table(
            task,
            [
                (&refitted.model, &believed),
                (&refitted.model, &refitted.theta),
                (&repaired.model, &repaired.theta),
            ],
            &noise,
        );
        let places = self.places(accepted, &removed, &effects, (verdict, &adequacy), (&field, known), &cells);
        let tried = self.tried(attempts, accepted);
        let inverse =
            checks.first().map_or_else(Vec::new, |&r| unknown::lacking(task, calibrated, accepted, r));
        // If neither cause holds there is nothing to separate.
        let is_late = task.budget.is_over(Stage::Compose);
        let open = near.first().filter(|_| verdict != Verdict::UnknownCause && !is_late);
        let next_experiment = open.and_then(|rival| next_experiment(self, accepted, rival));
        Diagnosis {
            verdict,
            gap,
            presliding: self.presliding(accepted, &adequacy, &machine),
            calibrated: self.machine_of(calibrated, &adequacy),
            adequacy,
            places,
            effects,
            look_alikes,
            attempts: tried,
            warnings: (in_words(&self.dataset.warnings).into_iter())
                .chain(self.timing(accepted))
                .chain(cold_start(&machine))
                .collect(),
            contradictions: (self.dataset.warnings.iter().filter(|fault| fault.kind.is_contradiction()))
                .map(ToString::to_string)
                .chain(self.reversed(accepted))
                .collect(),
            next_experiment,
            cells,
            ladder: ladder(task, calibrated),
            missing_force_n,
            left: what_is_left(task, accepted),
            table: None,
            noise: self.dataset.channels.iter().map(|channel| channel.column.clone()).zip(noise).collect(),
            inverse,
            machine,
        }
    }

    /// The accepted set without each cause in turn.
    fn removed(&self, accepted: &Scored) -> Vec<Scored> {
        (0..accepted.causes.len()).map(|i| self.without(accepted, i)).collect()
    }

    /// Whether an untried cause may be present, or one that delays commands beyond their timing.
    fn is_open(&self, adequacy: &Adequacy) -> bool {
        let Fitted { model, theta, .. } = &self.search.calibrated.fitted;
        adequacy.has_untried() || model.is_timing_at_late_limit(theta)
    }

    /// The times at which commands without a stated hold act.
    fn timing(&self, accepted: &Scored) -> Option<String> {
        let column = self.dataset.first_sampled()?;
        let rows = accepted.fitted.model.leeway(&accepted.fitted.theta).late_rows;
        let row_ms = 1e3 * self.dataset.records.first()?.spacing_s;
        let side = if rows < 0.0 { "before" } else { "after" };
        Some(format!(
            "`{column}`: no hold is stated: its commands act {:.2} ms {side} their rows, as fitted (state \
             `hold`; without it a command that is late by less than {:.2} ms in all may have been held)",
            (rows * row_ms).abs(),
            LATE_ROWS * row_ms
        ))
    }

    /// The answer if a position-dependent force is missing that no effect of the library explains.
    pub(crate) fn position_force(&self, force: f64, attempts: &Attempts) -> Diagnosis {
        let mut answer = self.answer(&self.search.calibrated, &[], attempts);
        answer.verdict = Verdict::UnknownCause;
        answer.adequacy.clear_hidden();
        let evidence = format!(
            "a force that depends on position, about {force:.2} N over {:.4} m, explains what no effect of \
             the library does; it hardly repeats over the stroke",
            self.search.seen.stroke_m()
        );
        let mut found = answer
            .places
            .iter()
            .find(|place| place.place == Place::Guide.name())
            .or(answer.places.first())
            .cloned();
        if let Some(place) = &mut found {
            place.place = Place::Guide.name();
            place.probability = 0.85;
            place.evidence.clone_from(&evidence);
        }
        answer.adequacy.add_left(evidence);
        answer.places = found.into_iter().collect();
        answer
    }

    fn verdict(&self, accepted: &Scored, adequate: bool, is_alone: bool, alike: &[&Scored]) -> Verdict {
        let others = alike.iter().filter_map(|rival| Some(rival.beyond(accepted).last()?.1.place));
        let mut places: Vec<Place> = others.chain(accepted.causes.last().map(|cause| cause.place)).collect();
        places.sort_unstable_by_key(|place| place.name());
        places.dedup();
        match (accepted.causes.is_empty(), adequate) {
            (true, true) if !self.is_excited() => Verdict::NotIdentifiable,
            (true, true) => Verdict::NoGap,
            (_, false) => Verdict::UnknownCause,
            (false, true) if places.len() >= PLACES_TO_TELL => Verdict::NotIdentifiable,
            (false, true) if !is_alone => Verdict::Ambiguous,
            (false, true) => Verdict::Explained,
        }
    }

    /// The verdict if no gap may also mean an untried cause, one that a doubtful value took over, or one that
    /// calibration hides.
    fn doubted(
        &self,
        verdict: Verdict,
        adequacy: &mut Adequacy,
        is_rough: bool,
        attempts: &Attempts,
    ) -> Verdict {
        let is_unknown = is_rough && self.is_open(adequacy);
        if verdict != Verdict::NoGap || is_unknown {
            adequacy.doubts.clear();
            return if is_unknown && verdict == Verdict::NoGap { Verdict::UnknownCause } else { verdict };
        }
        adequacy.add_hidden(self.hidden(attempts));
        if !adequacy.has_untried() && self.search.task.budget.is_over(Stage::Compose) {
            adequacy.add_untried(0, true);
        }
        if adequacy.is_doubted() { Verdict::NotIdentifiable } else { verdict }
    }

    /// Whether the channels vary enough above their noise to draw conclusions. Either most channels do in
    /// their best experiment, or one channel does by far.
    fn is_excited(&self) -> bool {
        let weights = &self.search.task.weights;
        let channels = self.dataset.channels.len();
        let best = |c: usize| {
            let ratios = weights.scale.iter().zip(&weights.noise).filter(|(scale, _)| scale[c].is_finite());
            ratios.map(|(scale, noise)| scale[c] / noise[c]).fold(0.0, f64::max)
        };
        let ratios: Vec<f64> = (0..channels).map(best).collect();
        let enough = ratios.iter().filter(|ratio| **ratio > ENOUGH_EXCITATION).count();
        2 * enough >= channels || ratios.iter().any(|ratio| *ratio > ENOUGH_ALONE)
    }

    /// Shapley value of each accepted effect: its gain of closing, averaged over all orders of adding the
    /// effects. `removed` holds the accepted set without each effect in turn.
    fn credit(
        &self,
        accepted: &Scored,
        removed: &[Scored],
        refit: &[f64],
        after: &[f64],
        effects: &mut [Cause],
    ) {
        let n = accepted.causes.len();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let checks = self.checks();
        let (none, all) = (mean(refit), mean(after));
        let whole = none - all;
        if n == 0 || whole <= 0.0 {
            return;
        }
        // Closing of each subset; bit `i` of its number is effect `i`.
        let closes: Vec<f64> = (0..1_usize << n)
            .map(|subset| {
                if subset == 0 {
                    return 0.0;
                }
                let mut out = (0..n).rev().filter(|i| subset & (1 << i) == 0);
                let Some(first) = out.next() else { return none - all };
                let kept = out.fold(removed[first].clone(), |scored, i| self.without(&scored, i));
                let errors =
                    size::square_errors(&self.search.task, &kept.fitted.model, &kept.fitted.theta, &checks);
                errors.map_or(0.0, |errors| none - mean(&errors))
            })
            .collect();
        let factorial = |n: usize| (1..=n).product::<usize>() as f64;
        for (i, effect) in effects.iter_mut().take(n).enumerate() {
            let share: f64 = (0..1_usize << n)
                .filter(|subset| subset & (1 << i) == 0)
                .map(|subset| {
                    let others = subset.count_ones() as usize;
                    factorial(others) * factorial(n - 1 - others) / factorial(n)
                        * (closes[subset | (1 << i)] - closes[subset])
                })
                .sum();
            effect.credit = (share / whole).clamp(0.0, 1.0);
        }
    }

    /// The places, each with its evidence: the error without the effect at that place, or the residual that
    /// indicates the place.
    fn places(
        &self,
        accepted: &Scored,
        removed: &[Scored],
        effects: &[Cause],
        (verdict, adequacy): (Verdict, &Adequacy),
        (field, known): (&Field, f64),
        cells: &[GapCell],
    ) -> Vec<Where> {
        let mut pointer = unknown::point(
            &self.search.task,
            if accepted.causes.is_empty() || verdict == Verdict::UnknownCause {
                accepted
            } else {
                &self.search.calibrated
            },
        );
        let smooth = adequacy.smooth.filter(|_| verdict == Verdict::UnknownCause);
        if let Some(place) = smooth {
            pointer.place = place;
            pointer.evidence = format!("{}; a smooth force there would balance better", pointer.evidence);
        }
        let mut chances: IndexMap<&'static str, f64> = IndexMap::new();
        for effect in effects {
            let chance = chances.entry(effect.place).or_insert(0.0);
            *chance = chance.max(if effect.accepted { effect.probability } else { 0.0 });
        }
        for (place, chance) in &mut chances {
            *chance = (*chance + known * field.instead(accepted, place)).min(1.0);
        }
        if verdict == Verdict::UnknownCause {
            let is_alone = accepted.causes.is_empty() && pointer.is_clear;
            let is_seen = (is_alone || smooth.is_some()) && !adequacy.has_untried();
            let is_clear = is_seen || adequacy.is_replaced;
            let rest = if is_clear { POINTED_ALONE } else { POINTED };
            let chance = chances.entry(pointer.place.name()).or_insert(0.0);
            *chance = chance.max(rest);
        }
        let doubts = &adequacy.doubts;
        for (doubt, place) in doubts.iter().filter_map(|doubt| Some((doubt, doubt.place?))) {
            let chance = chances.entry(place.name()).or_insert(0.0);
            *chance = chance.max(match doubt.about {
                Doubted::Value | Doubted::Early => POINTED,
                Doubted::Late => SHIFTED,
                Doubted::Cause => HIDDEN,
            });
        }
        let whole = (
            [0.0, 0.5 / self.dataset.records[0].spacing_s],
            if pointer.is_contact { "contact" } else { "free" },
        );
        let with = unknown::channel_misfits(accepted);
        let of_effect = |i: usize| {
            let taken = unknown::channel_misfits(&removed[i]);
            let rise = |c: usize| taken[c] / with[c].max(1.0);
            let worst = (0..taken.len()).max_by(|&a, &b| rise(a).total_cmp(&rise(b))).unwrap_or(0);
            let kind = accepted.causes[i].definition.kind;
            let [without, with] = [taken[worst], with[worst]].map(|misfit| in_sigmas(misfit.sqrt()));
            (
                worst,
                format!(
                    "without {kind} {} departs {without}, with it {with}",
                    self.search.task.weighed_as(worst)
                ),
            )
        };
        let mut places: Vec<Where> = chances
            .into_iter()
            .map(|(place, probability)| {
                let own = accepted.causes.iter().position(|cause| cause.place.name() == place);
                let rival = effects.iter().find(|effect| effect.place == place);
                let doubt = doubts.iter().find(|doubt| doubt.place.is_some_and(|at| at.name() == place));
                let (channel, evidence) = match (own, doubt, rival) {
                    (Some(i), ..) => of_effect(i),
                    (None, Some(doubt), _) => (pointer.channel, doubt.what.clone()),
                    (None, None, Some(rival)) if place != pointer.place.name() => {
                        (pointer.channel, format!("{} there would explain about as much", rival.kind))
                    }
                    _ => (pointer.channel, pointer.evidence.clone()),
                };
                let channel = self.column(channel);
                let (band_hz, phase) = heart(cells, &channel).unwrap_or(whole);
                Where { place, probability, channel, band_hz, phase, evidence }
            })
            .collect();
        places.sort_by(|a, b| b.probability.total_cmp(&a.probability));
        places
    }
}

impl Judge<'_> {
    /// Factor on the probabilities of all causes of an answer.
    fn certainty(&self, adequacy: &Adequacy) -> f64 {
        match (adequacy.is_short(), adequacy.has_rival()) {
            (true, _) if self.weight > 0.0 => INADEQUATE_SLOW,
            (true, _) => INADEQUATE,
            (false, true) => RIVALLED,
            (false, false) => 1.0,
        }
    }

    fn column(&self, channel: usize) -> String {
        self.dataset.channels.get(channel).map_or_else(String::new, |channel| channel.column.clone())
    }
}

/// Rivals that these records can hardly separate from the accepted set.
fn alike<'b>(accepted: &Scored, rivals: &'b [Scored], evidence: &[f64]) -> Vec<&'b Scored> {
    let best = evidence.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let near =
        rivals.iter().zip(evidence).filter(|(rival, e)| !rival.is_same(accepted) && best - **e < LOOK_ALIKE);
    near.map(|(rival, _)| rival).collect()
}
