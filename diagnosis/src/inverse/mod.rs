//! Inverse dynamics: the balance of forces between measured command and measured motion. Both are low-passed
//! at a few times the frequency of the motion.
//!
//! Nothing is simulated, so the noise of a command does not accumulate. Slow motion under a noisy command is
//! therefore clearer in a balance than in a prediction. A balance does not cover contact, impacts or hidden
//! modes.

mod base;
mod family;
mod noise;
mod reversal;
mod reversing;
mod rows;
mod shaping;
mod smooth;
mod solve;

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use base::Base;
pub(crate) use base::Part;
use rows::{Measured, Moving, Named, Reversals, Rows, corner_hz};
use solve::{Term, mean, residual, solve, sum};

pub(crate) use family::Family;
pub(crate) use reversal::Reversal;
pub(crate) use smooth::Smooth;

use crate::dataset::{Channel, Dataset, Record, rms};
use crate::fit::candidates::Candidate;
use crate::fit::wander::command_noise;
use crate::kinds::{Extent, Form, Shown, dossier};
use crate::predict::pace;
use feeler_plant::description::{Engagement, Quantity, Site};
use feeler_plant::effects::{Kind, Trait};

/// Rows kept for each independent one: rows at twice the corner frequency are independent.
const ROWS_PER_INDEPENDENT: f64 = 2.0;
/// Additional evidence for each further unknown, nats.
const PER_UNKNOWN: f64 = 1.5;
/// Unknowns of the reversals of friction: its presliding length and its lead.
const REVERSAL_UNKNOWNS: usize = 2;
/// Smallest numbers of kept rows. The fitted experiments must determine every unknown, and the evidence of
/// the check experiments grows with their rows.
const FEWEST_FITTED: usize = 60;
const FEWEST_CHECKED: usize = 24;

/// Experiments prepared for balances of forces.
pub(crate) struct Inverse {
    base: Base,
    fitted: Vec<Rows>,
    checked: Vec<Rows>,
    /// How friction turns by itself. The search of a set of causes begins there.
    reversals: Arc<Reversals>,
    /// Shapes and reversals of sets of causes that were found.
    known: Mutex<HashMap<Vec<(Site, Kind)>, Known>>,
    /// Whether the instant at which commands act within their rows is fitted.
    is_shifted: bool,
    extent: Extent,
    /// Time of the first row, and from there to the last one, s.
    from_s: f64,
    span_s: f64,
    /// Weight of the balance relative to predictions.
    pub(crate) weight: f64,
    /// Whether the command has measurement noise. It accumulates in predictions, but not in a balance.
    pub(crate) is_noisy: bool,
    /// Mean square of the noise of the command in the balance, N^2.
    command_noise: f64,
    /// Weighed square residuals of the calibrated machine on the check experiments.
    alone: Vec<f64>,
}

/// Shapes of causes, and how friction reverses beside them.
type Known = (Vec<f64>, Reversal);

/// The balance of a set of causes.
#[derive(Clone, Debug)]
pub(crate) struct Balanced {
    /// Gain over calibration alone on the check experiments, nats.
    pub(crate) nats: f64,
    /// Parameters of each cause.
    pub(crate) values: Vec<Vec<f64>>,
    /// Factors on mass, damping and effects of the believed machine, fitted with these causes.
    pub(crate) believed: Vec<(Part, f64)>,
    /// How friction reverses beside these causes.
    pub(crate) reversal: Reversal,
}

/// Largest share of its force that a drive loses with speed.
const MOST_FADED: f64 = 0.95;

/// Causes with their shapes.
#[derive(Clone)]
struct Shaped<'a> {
    causes: &'a [Candidate],
    shown: Vec<Shown>,
    shapes: Vec<f64>,
    /// Number of unknowns that the balance fits.
    unknowns: usize,
    reversals: Arc<Reversals>,
    /// Whether the instant at which commands act is free, so that a lag or delay needs no exact shape.
    is_floating: bool,
}

impl Shaped<'_> {
    /// Gain from command to force.
    fn gain(&self) -> f64 {
        let gains = self.shown.iter().zip(&self.shapes);
        gains.filter(|(shown, _)| matches!(shown.form, Form::Gain)).map(|(_, gain)| *gain).product()
    }

    /// Whether a cause makes the command act late.
    fn is_late(&self) -> bool {
        self.shown.iter().any(|shown| matches!(shown.form, Form::Lag | Form::Delay))
    }

    /// Time constant of the lag between command and force, s.
    fn lag_s(&self) -> f64 {
        let lags = self.shown.iter().zip(&self.shapes);
        lags.filter(|(shown, _)| matches!(shown.form, Form::Lag)).map(|(_, lag_s)| *lag_s).sum()
    }
}

impl Inverse {
    /// Prepares the free experiments with a position and a force command. `None` if there are none to fit or
    /// none to check, or if the believed machine does not move as a single axis.
    pub(crate) fn new(dataset: &Dataset) -> Option<Self> {
        let base = Base::of(dataset)?;
        let channel = base.position;
        let is_used = |record: &&Record| {
            let is_free = dataset.machine.contacts.is_empty() || record.engagement == Some(Engagement::Free);
            is_free && !record.silent[channel]
        };
        let used: Vec<_> = dataset.records.iter().filter(is_used).collect();
        let corners = used.iter().filter_map(|record| {
            let [motion, _] = pace(&record.series[channel], record.spacing_s)?;
            Some(corner_hz(motion, record.spacing_s))
        });
        // All experiments share one corner, because likelihoods of different bands cannot be compared.
        let corner = corners.fold(f64::INFINITY, f64::min);
        let is_sampled = dataset.is_sampled(0);
        let ready = |is_check: bool| -> Vec<Rows> {
            let of = |record: &&Record| {
                let (command, position) = (record.commands.first()?, &record.series[channel]);
                let (start_s, spacing_s) = (record.start_s, record.spacing_s);
                let measured = Measured { start_s, spacing_s, command, position, is_held: !is_sampled };
                Some(Rows::new(&measured, corner))
            };
            used.iter().filter(|record| record.is_check == is_check).filter_map(of).collect()
        };
        if !corner.is_finite() {
            return None;
        }
        let (mut fitted, mut checked) = (ready(false), ready(true));
        let kept = |rows: &[Rows]| rows.iter().map(|rows| rows.thin(&rows.speed).len()).sum::<usize>();
        if kept(&fitted) < FEWEST_FITTED || kept(&checked) < FEWEST_CHECKED {
            return None;
        }
        let extent = Rows::extent(&fitted);
        let most_kept_values = rows::MOST_KEPT_VALUES / (fitted.len() + checked.len()).max(1);
        for rows in fitted.iter_mut().chain(&mut checked) {
            (rows.middle, rows.most_kept_values) = (extent.middle(), most_kept_values);
            rows.carry(|position| base.load(position));
        }
        let ends = fitted.iter().filter_map(|rows| rows.times_s().last().copied());
        let from_s =
            fitted.iter().filter_map(|rows| rows.times_s().first().copied()).fold(f64::MAX, f64::min);
        let span_s = (ends.fold(from_s, f64::max) - from_s).max(f64::MIN_POSITIVE);
        let (weight, is_noisy) = (weight(dataset), is_noisy(dataset));
        let noise = |record: &&Record| {
            let command = record.commands.first()?;
            let left = rows::left_of_noise(command, corner, record.spacing_s);
            Some(command_noise(dataset, command).powi(2) * left)
        };
        // Known once reversals are.
        let alone = Vec::new();
        let changes = |rows: &Rows| rows.thin(&rows.command_rate).iter().any(|rate| rate.abs() > 0.0);
        let is_shifted = is_sampled && fitted.iter().any(changes);
        let (reversals, known) = (Arc::default(), Mutex::default());
        let mut inverse = Self {
            base,
            fitted,
            checked,
            reversals,
            known,
            is_shifted,
            extent,
            from_s,
            span_s,
            weight,
            is_noisy,
            command_noise: mean(&used.iter().filter_map(noise).collect::<Vec<f64>>()),
            alone,
        };
        inverse.reversals = Arc::new(inverse.reversals(inverse.free_reversal()));
        inverse.weigh_rows();
        inverse.alone = inverse.squares(&inverse.shaped(&[], true)?, None)?;
        (mean(&inverse.alone) > 0.0).then_some(inverse)
    }

    /// The believed machine alone.
    fn nothing(&self) -> Shaped<'static> {
        let reversals = self.reversals.clone();
        Shaped {
            causes: &[],
            shown: Vec::new(),
            shapes: Vec::new(),
            unknowns: 0,
            reversals,
            is_floating: false,
        }
    }

    /// The causes that a balance involves.
    pub(crate) fn shown_of(&self, causes: &[Candidate]) -> Vec<Candidate> {
        let is_shown =
            |cause: &&Candidate| self.base.shows(cause) && dossier(cause.definition.kind).balance.is_some();
        causes.iter().filter(is_shown).copied().collect()
    }

    /// Factors on mass, damping and effects of the believed machine, from all coefficients.
    fn factors(&self, shaped: &Shaped<'_>, coefficients: &[f64]) -> Vec<(Part, f64)> {
        let sides = self.base.sides(shaped.causes).zip(coefficients);
        sides.map(|((_, side), found)| side.over(found * shaped.gain())).collect()
    }

    /// Root mean square of the missing force over the drive force on the check experiments: with the believed
    /// machine alone, and with the causes.
    pub(crate) fn missing(&self, causes: &[Candidate]) -> Option<[f64; 2]> {
        let left = self.squares(&self.shaped(causes, true)?, None)?;
        Some([&self.alone, &left].map(|left| self.force(left) / self.drive_force()))
    }

    /// Balances a set of causes; `None` if the balance does not involve one of them.
    pub(crate) fn weigh(&self, causes: &[Candidate]) -> Option<Balanced> {
        self.weighed(causes, &self.shaped(causes, true)?)
    }

    /// As [`Self::weigh`], with the reversals of the one of the causes that suits best.
    pub(crate) fn weigh_roughly(&self, causes: &[Candidate]) -> Option<Balanced> {
        self.weighed(causes, &self.shaped(causes, false)?)
    }

    fn weighed(&self, causes: &[Candidate], shaped: &Shaped<'_>) -> Option<Balanced> {
        let left = self.squares(shaped, None)?;
        let (terms, target) = self.balance(&self.moving_fitted(&shaped.reversals), shaped, None);
        let coefficients = solve(&terms, &target)?;
        let parameters: usize = causes.iter().map(|cause| cause.definition.parameters.len()).sum();
        let unknowns = parameters + self.of_reversals(causes);
        Some(Balanced {
            nats: nats(&self.alone, &left) - PER_UNKNOWN * unknowns as f64,
            values: self.values(shaped, &coefficients),
            believed: self.factors(shaped, &coefficients),
            reversal: shaped.reversals.reversal,
        })
    }

    /// Number of unknowns of reversals that causes add: those of the first dry friction.
    fn of_reversals(&self, causes: &[Candidate]) -> usize {
        let adds = self.base.has_dry_friction(causes) && !self.base.has_dry_friction(&[]);
        if adds { REVERSAL_UNKNOWNS } else { 0 }
    }

    /// Mean weighed square residual on the fitted experiments; infinite if they do not determine it.
    fn left(&self, shaped: &Shaped<'_>, smooth: Option<Family>) -> f64 {
        let rows = self.moving_fitted(&shaped.reversals);
        let (terms, target) = self.balance(&rows, shaped, smooth);
        let left = |x: Vec<f64>| mean(&self.without_lag(shaped, &rows, &residual(&terms, &x, &target)));
        solve(&terms, &target).map_or(f64::INFINITY, left)
    }

    /// Root mean square of a force on the check experiments, from its weighed squares.
    fn force(&self, squares: &[f64]) -> f64 {
        let weights = self.checked.iter().flat_map(|rows| &rows.weights);
        mean(&squares.iter().zip(weights).map(|(x, weight)| x / (weight * weight)).collect::<Vec<_>>()).sqrt()
    }

    /// Root mean square of the drive force on the check experiments.
    fn drive_force(&self) -> f64 {
        let all: Vec<f64> = self.checked.iter().flat_map(|rows| rows.thin(&rows.smooth)).collect();
        rms(&all).max(f64::MIN_POSITIVE)
    }

    /// Weighed square residuals on the check experiments of causes fitted on the others. A smooth force is
    /// included if given.
    fn squares(&self, shaped: &Shaped<'_>, smooth: Option<Family>) -> Option<Vec<f64>> {
        let rows = [self.moving_fitted(&shaped.reversals), self.moving_checked(&shaped.reversals)];
        let [mut fitted, mut checked] = [0, 1].map(|i: usize| self.balance(&rows[i], shaped, smooth));
        if smooth == Some(Family::Command) {
            let mut made = solve(&fitted.0, &fitted.1)?;
            if self.is_shifted {
                // The shift of a measured command contains its noise.
                let bands = shaped.shown.iter().filter(|shown| matches!(shown.form, Form::Deadband)).count();
                let shift = made.len() - 1 - bands;
                made[shift] = 0.0;
            }
            for ((terms, target), rows) in [&mut fitted, &mut checked].into_iter().zip(&rows) {
                let weights: Vec<f64> = rows.iter().flat_map(|rows| rows.weights.iter().copied()).collect();
                let command = sum(terms, &made, target.len());
                terms.extend(self.drive_terms(&command, &weights));
            }
        }
        let coefficients = solve(&fitted.0, &fitted.1)?;
        let squares = self.without_lag(shaped, &rows[1], &residual(&checked.0, &coefficients, &checked.1));
        mean(&squares).is_finite().then_some(squares)
    }

    /// All weighed terms of some experiments, and their target sum.
    fn balance(
        &self,
        rows: &[Moving<'_>],
        shaped: &Shaped<'_>,
        smooth: Option<Family>,
    ) -> (Vec<Term>, Vec<f64>) {
        let mut joined: Option<(Vec<Term>, Vec<f64>)> = None;
        for rows in rows {
            let (terms, target) = self.balance_of(rows, shaped, smooth);
            match &mut joined {
                None => joined = Some((terms, target)),
                Some((all, whole)) => {
                    all.iter_mut().zip(terms).for_each(|(all, term)| all.series.extend(term.series));
                    whole.extend(target);
                }
            }
        }
        joined.unwrap_or_default()
    }

    fn balance_of(
        &self,
        rows: &Moving<'_>,
        shaped: &Shaped<'_>,
        smooth: Option<Family>,
    ) -> (Vec<Term>, Vec<f64>) {
        let mut terms = self.base.terms(rows, shaped.causes);
        let (mut gain, mut limit) = (1.0, f64::INFINITY);
        let mut of_command = Vec::new();
        for ((shown, &shape), cause) in shaped.shown.iter().zip(&shaped.shapes).zip(shaped.causes) {
            let is_dry = cause.definition.has(Trait::DryFriction);
            let low = |is_signed: bool| if is_signed { f64::NEG_INFINITY } else { 0.0 };
            match shown.form {
                Form::Forces(forces) => terms.extend(forces.iter().map(|force| Term {
                    series: rows.force(
                        Named::Cause(force.of as usize, shape.to_bits()),
                        is_dry,
                        shape,
                        force.of,
                    ),
                    low: low(force.is_signed),
                    high: f64::INFINITY,
                })),
                Form::Mass => {
                    let series = rows.acceleration.clone();
                    terms.push(Term { series, low: low(true), high: f64::INFINITY });
                }
                Form::Deadband => {
                    let usual = self.extent.command;
                    let series = rows.smooth.iter().map(|u| direction(*u, usual)).collect();
                    of_command.push(Term { series, low: 0.0, high: f64::INFINITY });
                }
                Form::Gain => gain = shape,
                Form::Limit => limit = shape,
                Form::Lag | Form::Delay => {}
            }
        }
        if let Some(Family::Fading { per_speed }) = smooth {
            let left: Vec<f64> =
                rows.speed.iter().map(|v| 1.0 - (per_speed * v.abs()).min(MOST_FADED)).collect();
            for term in &mut terms {
                term.series.iter_mut().zip(&left).for_each(|(x, left)| *x /= left);
            }
        }
        for (shown, &shape) in shaped.shown.iter().zip(&shaped.shapes) {
            for term in &mut terms {
                match shown.form {
                    Form::Lag => {
                        let rate = rows.rate(&term.series);
                        term.series.iter_mut().zip(rate).for_each(|(x, rate)| *x += shape * rate);
                    }
                    Form::Delay => term.series = rows.earlier(&term.series, shape),
                    _ => {}
                }
            }
        }
        for term in &mut terms {
            (term.low, term.high) = (term.low / gain, term.high / gain);
        }
        if self.is_shifted || shaped.is_floating {
            let late_s = if shaped.is_floating { f64::INFINITY } else { rows.most_late_s() };
            let series = rows.command_rate.clone();
            terms.push(Term { series, low: -late_s, high: late_s });
        }
        terms.extend(of_command);
        terms.extend(smooth.into_iter().flat_map(|family| self.guide_terms(rows, family)));
        for term in &mut terms {
            term.series = rows.weighed(&term.series);
        }
        let command =
            if limit.is_finite() { rows.command(|u| u.clamp(-limit, limit)) } else { rows.smooth.clone() };
        (terms, rows.weighed(&command))
    }

    /// Extracts the parameters of the causes from all coefficients.
    fn values(&self, shaped: &Shaped<'_>, coefficients: &[f64]) -> Vec<Vec<f64>> {
        let gain = shaped.gain();
        let mut next = self.base.sides(shaped.causes).count();
        // The coefficients of dead bands come last.
        let mut last = coefficients.len()
            - shaped.shown.iter().filter(|shown| matches!(shown.form, Form::Deadband)).count();
        let of = |(shown, &shape): (&Shown, &f64)| {
            let own: Vec<f64> = match shown.form {
                Form::Forces(forces) => {
                    coefficients[next..next + forces.len()].iter().map(|c| c * gain).collect()
                }
                Form::Mass => vec![coefficients[next] * gain],
                Form::Deadband => vec![coefficients[last]],
                _ => Vec::new(),
            };
            if matches!(shown.form, Form::Deadband) {
                last += 1;
            } else {
                next += own.len();
            }
            (shown.values)(&own, shape)
        };
        shaped.shown.iter().zip(&shaped.shapes).map(of).collect()
    }
}

/// Weight of a balance: a half if only positions correct predictions, because these then show little of slow
/// forces. Otherwise zero.
fn weight(dataset: &Dataset) -> f64 {
    let is_read = |channel: &Channel| channel.quantity(&dataset.machine) == Quantity::Acceleration;
    if dataset.channels.iter().any(is_read) { 0.0 } else { HALF }
}

fn is_noisy(dataset: &Dataset) -> bool {
    let is_noise = |command: &Vec<f64>| command_noise(dataset, command) > 0.0;
    dataset.records.iter().all(|record| record.commands.first().is_some_and(is_noise))
}

/// Weight of a balance that carries as much information as predictions.
const HALF: f64 = 0.5;

/// Share of the largest command over which the command's smooth sign changes.
const COMMAND_TURNS: f64 = 0.01;

fn direction(command: f64, largest: f64) -> f64 {
    (command / (COMMAND_TURNS * largest).max(f64::MIN_POSITIVE)).tanh()
}

/// Evidence of kept rows for square residuals `new` against `old`, nats.
fn nats(old: &[f64], new: &[f64]) -> f64 {
    let independent = new.len() as f64 / ROWS_PER_INDEPENDENT;
    0.5 * independent * (mean(old).max(f64::MIN_POSITIVE) / mean(new).max(f64::MIN_POSITIVE)).ln()
}

#[cfg(test)]
mod tests;
