//! The part that the library does not explain: its location and its shape.

use feeler_plant::description::{Engagement, Quantity};
use feeler_plant::effects::Place;
use nalgebra::{DMatrix, DVector};

use crate::fit::least_squares::{Fitted, Task};
use crate::fit::missing::{missing_acceleration, moving_mass};
use crate::fit::scored::Scored;

/// Mean square residual, in sigmas, above which a channel is not explained.
pub(crate) const ADEQUATE: f64 = 1.8;

/// The place that the residual of a model indicates, and the reason.
#[derive(Clone, Debug)]
pub(crate) struct Pointer {
    pub(crate) place: Place,
    pub(crate) channel: usize,
    pub(crate) is_contact: bool,
    /// Whether the residual depends clearly on the quantity that indicates the place.
    pub(crate) is_clear: bool,
    pub(crate) evidence: String,
}

/// Smallest share of the missing force that must correlate with position, velocity or drive force. On three
/// blind seeds six places were named with less, and all were wrong.
const CLEAR: f64 = 0.05;

/// Largest ratio of a channel's mean square residual to that of noise, over the experiments of one
/// engagement, that noise alone explains.
const NOISE_ALONE: f64 = 1.25;

/// Whether no channel shows more than noise (standard deviation per channel) in the experiments of any
/// engagement. The mean over all experiments would hide a weak cause that acts in one engagement only. So
/// would the share that no model is expected to explain.
pub(crate) fn is_quiet(task: &Task<'_>, scored: &Scored, noise: &[f64]) -> bool {
    let mut groups: Vec<(Option<Engagement>, Vec<f64>, f64)> = Vec::new();
    for (r, record) in task.dataset.records.iter().enumerate() {
        let share = |(c, misfit): (usize, &f64)| {
            let noise = task.weights.noise_of(r, c, noise).max(f64::MIN_POSITIVE);
            let sigmas = task.weights.sigma[r][c] / noise;
            // A channel that is ignored here has no misfit.
            if sigmas.is_finite() { misfit * sigmas.powi(2) } else { 0.0 }
        };
        let shares: Vec<f64> = scored.misfits[r].iter().enumerate().map(share).collect();
        match groups.iter_mut().find(|(engagement, ..)| *engagement == record.engagement) {
            Some((_, sums, count)) => {
                sums.iter_mut().zip(&shares).for_each(|(sum, share)| *sum += share);
                *count += 1.0;
            }
            None => groups.push((record.engagement, shares, 1.0)),
        }
    }
    groups.iter().all(|(_, sums, count)| sums.iter().all(|sum| sum / count <= NOISE_ALONE))
}

/// Mean over records of a channel's misfit.
pub(crate) fn channel_misfits(scored: &Scored) -> Vec<f64> {
    let n = scored.misfits.len() as f64;
    (0..scored.misfits[0].len()).map(|c| scored.misfits.iter().map(|m| m[c]).sum::<f64>() / n).collect()
}

/// Share of a channel's misfit after calibration that an explained channel may keep. Real friction and
/// contacts differ slightly from every law of the library, mostly near reversals and touch-down.
const DISCREPANCY: f64 = 0.12;

/// Channels that a model does not explain, each with its residual in standard deviations. Their misfit keeps
/// a larger share than the usual difference between real effects and the laws of the library.
pub(crate) fn unexplained(calibrated: &Scored, scored: &Scored) -> Vec<(usize, f64)> {
    let excess = |m: f64| (m - 1.0).max(0.0);
    let before = channel_misfits(calibrated);
    let after = channel_misfits(scored).into_iter().enumerate();
    let is_fair = |(c, m): &(usize, f64)| *m <= ADEQUATE || excess(*m) <= DISCREPANCY * excess(before[*c]);
    after.filter(|left| !is_fair(left)).map(|(c, m)| (c, m.sqrt())).collect()
}

/// Share of the variance of `y` that a regression on some columns explains.
pub(crate) fn explained(columns: &[Vec<f64>], y: &[f64]) -> f64 {
    let n = columns.len() + 1;
    let value = |i: usize, k: usize| if i == 0 { 1.0 } else { columns[i - 1][k] };
    let mut a = DMatrix::<f64>::zeros(n, n);
    let mut b = DVector::<f64>::zeros(n);
    for (k, &y) in y.iter().enumerate() {
        for i in 0..n {
            b[i] += value(i, k) * y;
            for j in 0..n {
                a[(i, j)] += value(i, k) * value(j, k);
            }
        }
    }
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    let total: f64 = y.iter().map(|y| (y - mean).powi(2)).sum();
    for i in 0..n {
        a[(i, i)] *= 1.0 + 1e-9;
        a[(i, i)] += 1e-12;
    }
    let Some(x) = a.cholesky().map(|factor| factor.solve(&b)) else { return 0.0 };
    let left: f64 = y
        .iter()
        .enumerate()
        .map(|(k, y)| (y - (0..n).map(|i| x[i] * value(i, k)).sum::<f64>()).powi(2))
        .sum();
    if total > 0.0 { 1.0 - left / total } else { 0.0 }
}

/// Missing force of a fitted model on some records, `[x, v, F_drive, F_missing]`, averaged over `average`
/// rows.
pub(crate) fn portrait(
    task: &Task<'_>,
    scored: &Scored,
    records: &[usize],
    average: usize,
    touching: Option<bool>,
) -> Vec<[f64; 4]> {
    let mass = moving_mass(task.dataset, scored);
    let mut points = Vec::new();
    for &r in records {
        let Some(prediction) = task.predict(&scored.fitted.model, &scored.fitted.theta, r) else { continue };
        let missing = missing_acceleration(task.dataset, r, &prediction);
        for (k, block) in missing.chunks(average).enumerate() {
            let at = k * average + block.len() / 2;
            if touching.is_some_and(|wanted| prediction.touching[at] != wanted) {
                continue;
            }
            let [x, v, force] = prediction.stroke[at];
            points.push([x, v, force, mass * block.iter().sum::<f64>() / block.len() as f64]);
        }
    }
    points
}

/// Force that the believed and the repaired machine lack along a record, `[t, x, v, F_believed, F_repaired]`,
/// averaged to at most [`LACKING_POINTS`].
pub(crate) fn lacking(task: &Task<'_>, calibrated: &Scored, repaired: &Scored, r: usize) -> Vec<[f64; 5]> {
    let record = &task.dataset.records[r];
    let average = record.len().div_ceil(LACKING_POINTS).max(1);
    let theta = calibrated.fitted.model.start();
    let given = Scored { fitted: Fitted { theta, ..calibrated.fitted.clone() }, ..calibrated.clone() };
    let [given, repaired] = [&given, repaired].map(|scored| portrait(task, scored, &[r], average, None));
    let rows = given.into_iter().zip(repaired).enumerate();
    let at = |k: usize| record.start_s + record.spacing_s * (average * k) as f64;
    rows.map(|(k, ([x, v, _, before], [.., after]))| [at(k), x, v, before, after]).collect()
}

/// Largest number of points of the missing force along a record.
const LACKING_POINTS: usize = 2000;

/// Smallest ratio of mean square residuals of two encoders along one chain that shows that the chain is not
/// rigid. Also the smallest such mean square of their difference.
const APART: f64 = 3.0;

/// Larger residuals are not printed as numbers.
const MOST_SIGMAS: f64 = 1000.0;

/// A residual in standard deviations, or a bound if its number would be meaningless.
pub(crate) fn in_sigmas(value: f64) -> String {
    if value > MOST_SIGMAS { "more than 1000 sigma".into() } else { format!("{value:.1} sigma") }
}

/// The joint whose two ends move apart; `None` if there is none. A common motion does not appear in the
/// difference.
fn parted(task: &Task<'_>, misfits: &[f64]) -> Option<Pointer> {
    let apart = (0..misfits.len()).filter(|&c| task.weights.is_elongation(c) && misfits[c] > APART);
    let channel = apart.max_by(|&a, &b| misfits[a].total_cmp(&misfits[b]))?;
    let (what, sigmas) = (task.weighed_as(channel), misfits[channel].sqrt());
    let evidence = format!("{what} departs {}: the two ends of the joint move apart", in_sigmas(sigmas));
    Some(Pointer { place: Place::Transmission, channel, is_contact: false, is_clear: true, evidence })
}

/// The place that the residuals of a model indicate.
pub(crate) fn point(task: &Task<'_>, scored: &Scored) -> Pointer {
    let dataset = task.dataset;
    let misfits = channel_misfits(scored);
    if let Some(pointer) = parted(task, &misfits) {
        return pointer;
    }
    let own: Vec<usize> = (0..misfits.len()).filter(|&c| !task.weights.is_elongation(c)).collect();
    let worst = own.iter().copied().max_by(|&a, &b| misfits[a].total_cmp(&misfits[b])).unwrap_or(0);
    let quantity = |c: usize| dataset.channels[c].quantity(&dataset.machine);
    let phase = |c: usize| {
        let mut sums = [(0.0, 0.0); 2];
        for (r, misfit) in scored.misfits.iter().enumerate() {
            let is_free = dataset.records[r].engagement == Some(feeler_plant::description::Engagement::Free);
            let slot = &mut sums[usize::from(!is_free)];
            slot.0 += misfit[c];
            slot.1 += 1.0;
        }
        sums.map(|(sum, n)| if n > 0.0 { sum / n } else { 0.0 })
    };
    let [free, contact] = phase(worst);
    let is_contact = !dataset.machine.contacts.is_empty() && contact > 2.0 * free;
    let positions = own.iter().filter(|&&c| quantity(c) == Quantity::Position);
    let least = positions.map(|&c| misfits[c]).fold(f64::INFINITY, f64::min);
    let name = &dataset.channels[worst].column;
    let says = |what: &str| format!("`{name}` departs {}: {what}", in_sigmas(misfits[worst].sqrt()));
    let is_read = (0..misfits.len()).any(|c| quantity(c) == Quantity::Acceleration);
    let mut is_clear = true;
    let (place, evidence) = match quantity(worst) {
        Quantity::Position if is_read => (
            Place::Base,
            says("encoder and accelerometers disagree smoothly, as when what the encoder rides on moves"),
        ),
        Quantity::Position if misfits[worst] > APART * least.max(1.0) => {
            (Place::Transmission, says("encoders along the chain disagree"))
        }
        Quantity::Position | Quantity::Acceleration => {
            let accelerations: Vec<usize> =
                (0..misfits.len()).filter(|&c| quantity(c) == Quantity::Acceleration).collect();
            let (small, large) = accelerations.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), &c| {
                (low.min(misfits[c]), high.max(misfits[c]))
            });
            if large > 2.0 * small {
                (Place::Transmission, says("accelerometers along the chain disagree"))
            } else if is_contact {
                (Place::Contact, says("a force is missing in contact only"))
            } else {
                let points = portrait(task, scored, &task.fitted, 8, Some(false));
                let column = |f: &dyn Fn(&[f64; 4]) -> f64| points.iter().map(f).collect::<Vec<f64>>();
                let y = column(&|p| p[3]);
                let span = points.iter().map(|p| p[0].abs()).fold(1e-12, f64::max);
                let fast = points.iter().map(|p| p[1].abs()).fold(1e-12, f64::max);
                let position: Vec<Vec<f64>> = (1..=4).map(|n| column(&|p| (p[0] / span).powi(n))).collect();
                let speed: Vec<Vec<f64>> = vec![
                    column(&|p| p[1]),
                    column(&|p| p[1].signum()),
                    column(&|p| p[1] * p[1].abs()),
                    column(&|p| (p[1] / (0.05 * fast)).tanh()),
                ];
                let force: Vec<Vec<f64>> =
                    vec![column(&|p| p[2]), column(&|p| p[2].signum()), column(&|p| p[2] * p[2].abs())];
                let shares = [explained(&position, &y), explained(&speed, &y), explained(&force, &y)];
                let best = (0..3).max_by(|&a, &b| shares[a].total_cmp(&shares[b])).unwrap_or(0);
                let what = ["position", "velocity", "drive force"][best];
                is_clear = shares[best] > CLEAR;
                let place = if best == 2 { Place::Drive } else { Place::Guide };
                (
                    place,
                    says(&format!(
                        "the missing force goes with {what} ({:.0} % of it)",
                        100.0 * shares[best]
                    )),
                )
            }
        }
        Quantity::Force | Quantity::SpringForce => {
            // If a force acted, the motion would depart too; here only the reading does.
            (Place::ForceSensor, says("the force reading departs while the motion is explained"))
        }
        _ => (Place::Guide, says("it is not explained")),
    };
    Pointer { place, channel: worst, is_contact, is_clear, evidence }
}
