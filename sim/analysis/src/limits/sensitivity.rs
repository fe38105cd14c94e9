//! Sensitivity of the bandwidth and of other limits to each parameter of a machine: what to stiffen, lighten
//! or damp first.

use std::f64::consts::TAU;

use feeler_control::ControllerSpec;
use feeler_lti::C64;
use feeler_plant::assembly::{Assembly, Source};
use feeler_plant::description::{Actuator, Body, Contact, Engagement, Spring};
use nalgebra::DMatrix;
use serde::Serialize;

use crate::error::AnalysisError;
use crate::limits::waterfall::Stage;
use crate::loops::closed_loop::ClosedLoop;
use crate::loops::control_loop::{ControlLoop, LoopController};
use crate::machine::linearise::LinearMachine;
use crate::workers::Workers;

/// Relative step of the central differences; their error is its square.
const DIFFERENCE: f64 = 1e-3;
/// Largest number of analysed parameters. Of more, only those with the largest effect on the response of the
/// machine are analysed.
const MOST_NUMBERS: usize = 32;
/// A loss below this share of the gain does not count.
const NO_LOSS: f64 = 0.1;

/// Sensitivity of the loop to one parameter of the machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sensitivity {
    /// Key of the parameter.
    pub key: String,
    /// Value of the parameter, SI.
    pub value: f64,
    /// Derivative of the bandwidth, Hz per unit of the parameter.
    pub bandwidth_hz_per_unit: f64,
    /// Relative change of the bandwidth over relative change of the parameter. If the drive saturates first,
    /// the saturation frequency takes the place of the bandwidth.
    pub bandwidth_relative: f64,
    /// Relative change of the largest stable gain over relative change of the parameter.
    pub largest_gain_relative: f64,
    /// Whether bandwidth and gain change in opposite directions.
    pub trades: bool,
}

/// The criterion by which parameters are ranked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum RankedBy {
    /// Bandwidth and largest stable gain together; parameters that trade one for the other come last.
    BandwidthAndGain,
    /// The largest stable gain alone: the bandwidth lies on the flank of a mode's peak and measures the
    /// height of that peak.
    LargestGain,
    /// The saturation frequency, which is the bandwidth that is achieved.
    Saturation,
}

impl Sensitivity {
    /// The signed worth of a change: relative change of the ranked quantity over relative change of the
    /// parameter. NaN if there is nothing to compare.
    pub fn worth(&self, by: RankedBy) -> f64 {
        match by {
            RankedBy::BandwidthAndGain => self.bandwidth_relative + self.largest_gain_relative,
            RankedBy::LargestGain => self.largest_gain_relative,
            RankedBy::Saturation => self.bandwidth_relative,
        }
    }

    /// Whether the parameter trades one ranked quantity for another.
    pub fn is_trade(&self, by: RankedBy) -> bool {
        by == RankedBy::BandwidthAndGain && self.trades
    }
}

/// Sorts by falling worth; trades and parameters without a worth come last.
pub(crate) fn rank(sensitivities: &mut [Sensitivity], by: RankedBy) {
    let size = |s: &Sensitivity| if s.worth(by).is_nan() { -1.0 } else { s.worth(by).abs() };
    sensitivities.sort_by(|a, b| a.is_trade(by).cmp(&b.is_trade(by)).then(size(b).total_cmp(&size(a))));
}

impl ControlLoop {
    /// Sensitivities of bandwidth and largest gain of the sampled loop to every nonzero mass, stiffness and
    /// damping. Of large machines, only those that matter most at the edge of stability and at the bandwidth.
    /// If the drive saturates below the bandwidth, also those of the saturation frequency to these parameters
    /// and to the limits, with the gain kept. Sorted by falling worth; empty if no gain is stable.
    ///
    /// # Errors
    /// Those of [`Self::sampled_bands`].
    pub fn sensitivities(&self, key: &str, workers: Workers) -> Result<Vec<Sensitivity>, AnalysisError> {
        let assembly = self.assembly();
        let base = self.sampled_stage("", key, &self.sampled_bands(key)?, None)?;
        if base.largest_gain == Some(0.0) {
            return Ok(Vec::new());
        }
        let saturates = base.saturates(self.saturation_hz(key, base.largest_gain)?);
        let mut numbers = self.numbers();
        if numbers.len() > MOST_NUMBERS {
            let effects = self.effects(key, &base, &numbers, workers)?;
            let mut order: Vec<usize> = (0..numbers.len()).collect();
            order.sort_by(|&a, &b| effects[b].total_cmp(&effects[a]));
            numbers = order.into_iter().take(MOST_NUMBERS).map(|i| numbers[i].clone()).collect();
        }
        if saturates {
            numbers.extend(self.limits());
        }
        let answer = |(name, slot): &(String, Slot)| -> Result<Option<Sensitivity>, AnalysisError> {
            let value = *slot.of(&mut assembly.clone(), &mut self.controllers().to_vec());
            if value == 0.0 {
                return Ok(None);
            }
            // Largest gain, and the bandwidth or the saturation frequency below it.
            let at = |factor: f64| -> Result<[Option<f64>; 2], AnalysisError> {
                let altered =
                    self.altered(|assembly, controllers| *slot.of(assembly, controllers) *= factor)?;
                let (largest_gain, bandwidth_hz) = altered.stage_near(key, &base, !saturates)?;
                let achieved =
                    if saturates { altered.saturation_hz(key, base.largest_gain)? } else { bandwidth_hz };
                Ok([largest_gain, achieved])
            };
            let (low, high) = (at(1.0 - DIFFERENCE)?, at(1.0 + DIFFERENCE)?);
            let slope = |which: usize| {
                low[which].zip(high[which]).map_or(f64::NAN, |(a, b)| (b - a) / (DIFFERENCE * (a + b)))
            };
            let (largest_gain_relative, bandwidth_relative) = (slope(0), slope(1));
            let middle = low[1].zip(high[1]).map_or(f64::NAN, |(a, b)| 0.5 * (a + b));
            Ok(Some(Sensitivity {
                key: name.clone(),
                value,
                bandwidth_hz_per_unit: bandwidth_relative * middle / value,
                bandwidth_relative,
                largest_gain_relative,
                trades: trades(bandwidth_relative, largest_gain_relative),
            }))
        };
        let answers = workers.collect(numbers.len(), |i| answer(&numbers[i]));
        let answers = answers.into_iter().collect::<Result<Vec<_>, _>>()?;
        let mut sensitivities: Vec<Sensitivity> = answers.into_iter().flatten().collect();
        rank(&mut sensitivities, if saturates { RankedBy::Saturation } else { RankedBy::BandwidthAndGain });
        Ok(sensitivities)
    }

    /// Largest gain and bandwidth of a loop that differs slightly from that of `base`. With many states the
    /// search starts from the values of `base`.
    fn stage_near(
        &self,
        key: &str,
        base: &Stage,
        with_bandwidth: bool,
    ) -> Result<(Option<f64>, Option<f64>), AnalysisError> {
        let near = base.edge_hz.map(|edge_hz| self.edge_near(key, edge_hz)).transpose()?.flatten();
        let Some((largest, near_hz)) = near.zip(base.bandwidth_hz) else {
            let stage = self.sampled_stage("", key, &self.sampled_bands(key)?, None)?;
            return Ok((stage.largest_gain, stage.bandwidth_hz));
        };
        if !with_bandwidth {
            return Ok((Some(largest), None));
        }
        let (controller, gain) = self.gain_of_key(key)?;
        let half = self.at_half_of(controller, &gain, largest)?;
        let nyquist_hz = 0.5 / half.controllers()[controller].spec.period_s;
        let closed = ClosedLoop::sampled(&half, controller)?;
        let found = closed.map(|closed| closed.bandwidth_near_hz(near_hz)).transpose()?;
        Ok((Some(largest), found.map(|found| found.unwrap_or(nyquist_hz))))
    }

    /// Masses, stiffnesses and dampings of all elements that act; an absent contact does not.
    fn numbers(&self) -> Vec<(String, Slot)> {
        let assembly = self.assembly();
        let mut numbers: Vec<(String, Slot)> = Vec::new();
        for (i, node) in assembly.nodes.iter().enumerate().skip(1) {
            numbers.push((Body::MASS.of(&node.name), Slot::Mass(i)));
        }
        for (i, link) in assembly.links.iter().enumerate().filter(|(_, link)| !link.rigid) {
            numbers.push((Spring::STIFFNESS.of(&link.name), Slot::LinkStiffness(i)));
            numbers.push((Spring::DAMPING.of(&link.name), Slot::LinkDamping(i)));
        }
        let taken = &self.plant().motion().assembly().contacts;
        for (i, contact) in
            taken.iter().enumerate().filter(|(_, contact)| contact.engagement != Engagement::Free)
        {
            numbers.push((Contact::STIFFNESS.of(&contact.name), Slot::ContactStiffness(i)));
            numbers.push((Contact::DAMPING.of(&contact.name), Slot::ContactDamping(i)));
        }
        numbers
    }

    /// Limits of drives and controllers, if any.
    fn limits(&self) -> Vec<(String, Slot)> {
        let mut limits = Vec::new();
        for (i, drive) in self.assembly().drives.iter().enumerate() {
            if drive.limit.is_finite() {
                limits.push((Actuator::LIMIT.of(&drive.name), Slot::DriveLimit(i)));
            }
            if drive.rate_limit.is_finite() {
                limits.push((Actuator::RATE_LIMIT.of(&drive.name), Slot::DriveRateLimit(i)));
            }
        }
        for (i, controller) in
            self.controllers().iter().enumerate().filter(|(_, c)| c.spec.output_limit.is_some())
        {
            limits.push((ControllerSpec::OUTPUT_LIMIT.of(&controller.name), Slot::OutputLimit(i)));
        }
        limits
    }
}

impl ControlLoop {
    /// Effect of each number on the loop, to first order: the larger of two relative changes. The first is
    /// the change of the gain at the edge of stability. The second is the change of the frequency at which
    /// the machine answers as at the bandwidth.
    fn effects(
        &self,
        key: &str,
        base: &Stage,
        numbers: &[(String, Slot)],
        workers: Workers,
    ) -> Result<Vec<f64>, AnalysisError> {
        let (controller, gain) = self.gain_of_key(key)?;
        let own = &self.controllers()[controller];
        let Some(sensor) = own.sensor_of_gain(&gain) else { return Ok(vec![0.0; numbers.len()]) };
        let matrices = |of: &LinearMachine| -> Result<[DMatrix<C64>; 3], AnalysisError> {
            let output = of.output(Source::Sensor(sensor))?.c;
            let output = DMatrix::from_fn(1, output.ncols(), |_, j| output[j]);
            let input = of.b().columns(own.drive, 1).into_owned();
            Ok([of.a().clone(), input, output].map(|m| m.map(|v| C64::new(v, 0.0))))
        };
        let plant = matrices(self.plant())?;
        // Hold and delay turn the phase only.
        let late_s = 0.5 * own.spec.period_s + own.spec.delay_s;
        let at = |f: Option<f64>| Probe::new(&plant, TAU * f?, late_s);
        let (edge, bandwidth) = (at(base.edge_hz), at(base.bandwidth_hz));
        let effect = |slot: Slot| -> Result<f64, AnalysisError> {
            let altered =
                self.altered(|assembly, controllers| *slot.of(assembly, controllers) *= 1.0 + DIFFERENCE)?;
            let altered = matrices(altered.plant())?;
            let of_gain = edge.as_ref().map_or(0.0, |edge| edge.of_gain(edge.change(&plant, &altered)));
            let moves = |at: &Probe| (at.change(&plant, &altered) / at.slope).norm();
            Ok(of_gain.max(bandwidth.as_ref().map_or(0.0, moves)) / DIFFERENCE)
        };
        workers.collect(numbers.len(), |i| effect(numbers[i].1)).into_iter().collect()
    }
}

/// The machine between drive and sensor at one frequency.
struct Probe {
    /// States of the machine, and of the transposed machine, under a unit input.
    states: [DMatrix<C64>; 2],
    value: C64,
    /// Logarithmic derivative over the logarithm of the frequency.
    slope: C64,
}

impl Probe {
    fn new([a, b, c]: &[DMatrix<C64>; 3], w: f64, late_s: f64) -> Option<Self> {
        let s = C64::new(0.0, w);
        let resolvent = DMatrix::from_diagonal_element(a.nrows(), a.nrows(), s) - a;
        let adjoint = resolvent.transpose().lu().solve(&c.transpose())?;
        let states = resolvent.lu().solve(b)?;
        let value = (c * &states)[(0, 0)];
        let slope = -s * ((adjoint.transpose() * &states)[(0, 0)] / value + late_s);
        Some(Self { states: [states, adjoint], value, slope })
    }

    /// Relative change of the response to first order.
    fn change(&self, [a, b, c]: &[DMatrix<C64>; 3], [a2, b2, c2]: &[DMatrix<C64>; 3]) -> C64 {
        let [x, y] = &self.states;
        let change = (c2 - c) * x + y.transpose() * ((a2 - a) * x + (b2 - b));
        change[(0, 0)] / self.value
    }

    /// Relative change of the gain at which the loop oscillates. The phase of the loop is fixed there, so the
    /// frequency changes.
    fn of_gain(&self, change: C64) -> f64 {
        (change.re - self.slope.re * change.im / self.slope.im).abs()
    }
}

/// Whether two changes have opposite signs and the loss is significant.
fn trades(a: f64, b: f64) -> bool {
    a * b < 0.0 && a.abs().min(b.abs()) > NO_LOSS * a.abs().max(b.abs())
}

/// One parameter of a machine or its controllers.
#[derive(Clone, Copy)]
enum Slot {
    Mass(usize),
    LinkStiffness(usize),
    LinkDamping(usize),
    ContactStiffness(usize),
    ContactDamping(usize),
    DriveLimit(usize),
    DriveRateLimit(usize),
    OutputLimit(usize),
}

impl Slot {
    fn of<'a>(self, assembly: &'a mut Assembly, controllers: &'a mut [LoopController]) -> &'a mut f64 {
        match self {
            Self::Mass(i) => &mut assembly.nodes[i].mass_kg,
            Self::LinkStiffness(i) => &mut assembly.links[i].stiffness,
            Self::LinkDamping(i) => &mut assembly.links[i].damping,
            Self::ContactStiffness(i) => &mut assembly.contacts[i].law.stiffness,
            Self::ContactDamping(i) => &mut assembly.contacts[i].law.damping,
            Self::DriveLimit(i) => &mut assembly.drives[i].limit,
            Self::DriveRateLimit(i) => &mut assembly.drives[i].rate_limit,
            Self::OutputLimit(i) => controllers[i].spec.output_limit.get_or_insert(f64::INFINITY),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(key: &str, bandwidth_relative: f64, largest_gain_relative: f64) -> Sensitivity {
        let trades = trades(bandwidth_relative, largest_gain_relative);
        Sensitivity {
            key: key.into(),
            value: 1.0,
            bandwidth_hz_per_unit: 0.0,
            bandwidth_relative,
            largest_gain_relative,
            trades,
        }
    }

    #[test]
    fn truth_what_raises_both_comes_before_what_trades_one_for_the_other() {
        let mut all = [
            number("trade", 0.3, -1.0),
            number("nothing known", f64::NAN, 0.2),
            number("both", 0.1, 0.3),
            number("mass", -0.3, 0.01),
        ];
        let mut order = |by| {
            rank(&mut all, by);
            all.iter().map(|s| s.key.clone()).collect::<Vec<_>>()
        };
        assert_eq!(order(RankedBy::BandwidthAndGain), ["both", "mass", "nothing known", "trade"]);
        assert_eq!(order(RankedBy::LargestGain), ["trade", "both", "nothing known", "mass"]);
        assert_eq!(order(RankedBy::Saturation)[3], "nothing known");
    }
}
