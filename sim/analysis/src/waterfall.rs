//! What limits the bandwidth: from the rigid body under a perfect drive down to the loop that is built, one ingredient after the other.

use std::f64::consts::TAU;

use feeler_control::Reference;
use feeler_lti::{C64, TransferEvaluator};
use feeler_plant::assembly::{Assembly, Source};
use feeler_plant::description::Quantity;
use serde::{Serialize, Serializer};

use crate::closed_loop::{ClosedLoop, law_of_reference};
use crate::control_loop::{ControlLoop, LoopController};
use crate::error::AnalysisError;
use crate::gain_key::with_gain;
use crate::modes::{Mode, ModeClass, ModeInPair};
use crate::sampled_loop::SampledLoop;
use crate::stability::GainBands;

/// Bandwidths are compared with half of the largest stable gain: a gain margin of two.
const SHARE_OF_LIMIT: f64 = 0.5;
/// Relative step of the central differences; their error is its square.
const DIFFERENCE: f64 = 1e-3;
/// An ingredient whose absence raises the limit by less than this factor does not limit.
const MATTERS: f64 = 1.05;

/// Which of the paper's three problems, or the controller itself, limits the bandwidth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Limit {
    /// Inertia, damping and the drive.
    RigidBody,
    /// A mode in which actuator and sensor part.
    NoncolocatedMode,
    /// A mode of base or workpiece.
    ColocatedMode,
    /// Hold, delay and filters.
    Sampling,
    /// The drive's limit.
    Saturation,
}

/// One step down.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stage {
    /// What has been added.
    pub added: String,
    /// Largest stable gain; absent where there is none.
    pub largest_gain: Option<f64>,
    /// Frequency at which the loop begins to swing there, Hz.
    pub edge_hz: Option<f64>,
    /// Frequency at which, at half that gain, the reading's answer to the reference first falls 3 dB below what it is at low frequency, Hz; half of the
    /// sampling rate where it never does; absent where the gain is unlimited.
    pub bandwidth_hz: Option<f64>,
}

/// How the bandwidth answers to one number of the machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sensitivity {
    /// The number's key.
    pub key: String,
    /// Its value, SI.
    pub value: f64,
    /// Derivative of the bandwidth, Hz per unit of the number.
    pub bandwidth_hz_per_unit: f64,
    /// Relative change of the bandwidth over relative change of the number.
    pub bandwidth_relative: f64,
    /// Relative change of the largest stable gain over relative change of the number.
    pub largest_gain_relative: f64,
}

/// What becomes of the largest gain without an ingredient. Serialised as a number, `"unlimited"`, `"stable"` or `"none"`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relief {
    /// It is this many times as large.
    Times(f64),
    /// Every gain is stable.
    Unlimited,
    /// Gains up to a largest one are stable, where none is with the ingredient.
    Stable,
    /// No gain is stable, as with it.
    NoneEither,
}

impl Relief {
    /// From the largest gain with an ingredient to that without; zero where nothing is stable, infinite where everything is.
    fn new(with: f64, without: f64) -> Self {
        match (with > 0.0, without > 0.0) {
            (_, true) if without.is_infinite() => Self::Unlimited,
            (true, _) => Self::Times(without / with),
            (false, true) => Self::Stable,
            (false, false) => Self::NoneEither,
        }
    }

    /// As a factor, to compare by.
    fn factor(self) -> f64 {
        match self {
            Self::Times(factor) => factor,
            Self::Unlimited | Self::Stable => f64::INFINITY,
            Self::NoneEither => 1.0,
        }
    }
}

impl Serialize for Relief {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Times(factor) => serializer.serialize_f64(*factor),
            Self::Unlimited => serializer.serialize_str("unlimited"),
            Self::Stable => serializer.serialize_str("stable"),
            Self::NoneEither => serializer.serialize_str("none"),
        }
    }
}

/// The whole account.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Waterfall {
    /// From the ideal down to what is built.
    pub stages: Vec<Stage>,
    /// What would become of the largest gain without an ingredient, the others present.
    pub without: Vec<(String, Relief)>,
    /// Frequency above which a reference of the file's size drives the command to its limit, Hz; absent where it never does.
    pub saturation_hz: Option<f64>,
    /// The verdict.
    pub limit: Limit,
}

/// An ideal drive with the same gain: a velocity source keeps the damping of its motor, and loses its lag.
fn idealise_drives(assembly: &mut Assembly) {
    for i in 0..assembly.drives.len() {
        let drive = &mut assembly.drives[i];
        drive.lags.clear();
        if let Some(source) = drive.velocity_source.take() {
            drive.gain *= source.damping;
            let (name, on, reacts_on) = (drive.name.clone(), drive.on, drive.reacts_on);
            assembly.add_link(name, reacts_on, on, 0.0, source.damping);
        }
    }
}

fn without_delay(assembly: &mut Assembly, controllers: &mut [LoopController]) {
    assembly.drives.iter_mut().for_each(|drive| drive.delay = 0.0);
    assembly.sensors.iter_mut().for_each(|sensor| sensor.delay = 0.0);
    for controller in controllers {
        controller.spec.delay_s = 0.0;
    }
}

fn without_filters(assembly: &mut Assembly, controllers: &mut [LoopController]) {
    assembly.sensors.iter_mut().for_each(|sensor| sensor.filters.clear());
    for c in controllers {
        c.spec.reading_low_pass = None;
        c.spec.velocity_filter_s = 0.0;
    }
}

impl ControlLoop {
    /// The account for one gain. `modes` and `pairs` are those of the loop's own actuator and sensor.
    ///
    /// # Errors
    /// Those of [`Self::sampled_bands`] and [`Self::continuous_bands`].
    pub fn waterfall(&self, key: &str, modes: &[Mode], pairs: &[ModeInPair]) -> Result<Waterfall, AnalysisError> {
        let flexible = self.flexible_links(modes, pairs);
        let rigid = |assembly: &mut Assembly, links: &[(usize, ModeClass)]| links.iter().for_each(|(i, _)| assembly.links[*i].rigid = true);
        let mut stages = Vec::new();
        let ideal = self.altered(|assembly, _| {
            rigid(assembly, &flexible);
            idealise_drives(assembly);
        })?;
        stages.push(ideal.continuous_stage("rigid body", key)?);
        stages.push(self.altered(|assembly, _| rigid(assembly, &flexible))?.continuous_stage("actuator", key)?);
        for n in 0..flexible.len() {
            let added = format!("springs.{}", self.assembly().links[flexible[n].0].name);
            stages.push(self.altered(|assembly, _| rigid(assembly, &flexible[n + 1..]))?.continuous_stage(&added, key)?);
        }
        let held = self.altered(|assembly, controllers| {
            without_delay(assembly, controllers);
            without_filters(assembly, controllers);
        })?;
        stages.push(held.sampled_stage("hold", key)?);
        stages.push(self.altered(|assembly, controllers| without_filters(assembly, controllers))?.sampled_stage("delay", key)?);
        let built = self.sampled_stage("filters", key)?;
        let limit_gain = built.largest_gain.unwrap_or(f64::INFINITY);
        stages.push(built);

        let relief = |bands: GainBands| Relief::new(limit_gain, bands.first_upper());
        let mut candidates = vec![("sampling".to_string(), Limit::Sampling, relief(self.continuous_bands(key)?))];
        let perfect = self.altered(|assembly, _| idealise_drives(assembly))?;
        candidates.push(("actuator".into(), Limit::RigidBody, relief(perfect.sampled_bands(key)?)));
        for &(i, class) in &flexible {
            let limit = if class == ModeClass::Noncolocated { Limit::NoncolocatedMode } else { Limit::ColocatedMode };
            let stiff = self.altered(|assembly, _| rigid(assembly, &[(i, class)]))?;
            candidates.push((format!("springs.{}", self.assembly().links[i].name), limit, relief(stiff.sampled_bands(key)?)));
        }
        let saturation_hz = self.saturation_hz(key)?;
        let achieved = stages.last().and_then(|stage| stage.bandwidth_hz);
        if let (Some(saturation), Some(last)) = (saturation_hz, stages.last().cloned()) {
            let bandwidth_hz = last.bandwidth_hz.map(|achieved| achieved.min(saturation));
            stages.push(Stage { added: "saturation".into(), bandwidth_hz, ..last });
        }
        let saturates = saturation_hz.zip(achieved).is_some_and(|(saturation, achieved)| saturation < achieved);
        let worst = candidates
            .iter()
            .max_by(|a, b| a.2.factor().total_cmp(&b.2.factor()))
            .filter(|c| limit_gain.is_finite() && c.2.factor() > MATTERS);
        let limit = if saturates { Limit::Saturation } else { worst.map_or(Limit::RigidBody, |c| c.1) };
        let without = candidates.into_iter().map(|(name, _, relief)| (name, relief)).collect();
        Ok(Waterfall { stages, without, saturation_hz, limit })
    }

    /// How bandwidth and largest gain of the sampled loop answer to every mass, stiffness and damping that is not zero.
    ///
    /// # Errors
    /// Those of [`Self::sampled_bands`].
    pub fn sensitivities(&self, key: &str) -> Result<Vec<Sensitivity>, AnalysisError> {
        let assembly = self.assembly();
        let mut numbers: Vec<(String, Slot)> = Vec::new();
        for (i, node) in assembly.nodes.iter().enumerate().skip(1) {
            numbers.push((format!("bodies.{}.mass", node.name), Slot::Mass(i)));
        }
        for (i, link) in assembly.links.iter().enumerate().filter(|(_, link)| !link.rigid) {
            numbers.push((format!("springs.{}.stiffness", link.name), Slot::LinkStiffness(i)));
            numbers.push((format!("springs.{}.damping", link.name), Slot::LinkDamping(i)));
        }
        for (i, contact) in assembly.contacts.iter().enumerate() {
            numbers.push((format!("contacts.{}.stiffness", contact.name), Slot::ContactStiffness(i)));
            numbers.push((format!("contacts.{}.damping", contact.name), Slot::ContactDamping(i)));
        }
        let mut sensitivities = Vec::new();
        for (name, slot) in numbers {
            let value = *slot.of(&mut assembly.clone());
            if value == 0.0 {
                continue;
            }
            let at = |factor: f64| -> Result<Stage, AnalysisError> {
                self.altered(|assembly, _| *slot.of(assembly) *= factor)?.sampled_stage("", key)
            };
            let (low, high) = (at(1.0 - DIFFERENCE)?, at(1.0 + DIFFERENCE)?);
            let slope =
                |of: &dyn Fn(&Stage) -> Option<f64>| of(&low).zip(of(&high)).map_or(f64::NAN, |(a, b)| (b - a) / (DIFFERENCE * (a + b)));
            let bandwidth_relative = slope(&|stage| stage.bandwidth_hz);
            let middle = low.bandwidth_hz.zip(high.bandwidth_hz).map_or(f64::NAN, |(a, b)| 0.5 * (a + b));
            sensitivities.push(Sensitivity {
                key: name,
                value,
                bandwidth_hz_per_unit: bandwidth_relative * middle / value,
                bandwidth_relative,
                largest_gain_relative: slope(&|stage| stage.largest_gain),
            });
        }
        // Where the loop has no crossover there is no bandwidth to compare by.
        let size = |s: &Sensitivity| if s.bandwidth_relative.is_nan() { -1.0 } else { s.bandwidth_relative.abs() };
        sensitivities.sort_by(|a, b| size(b).total_cmp(&size(a)));
        Ok(sensitivities)
    }

    fn continuous_stage(&self, added: &str, key: &str) -> Result<Stage, AnalysisError> {
        let bands = self.continuous_bands(key)?;
        self.stage(added, key, &bands, |half, controller| match ClosedLoop::continuous(half, controller)? {
            Some(closed) => closed.bandwidth_hz(),
            None => Ok(None),
        })
    }

    fn sampled_stage(&self, added: &str, key: &str) -> Result<Stage, AnalysisError> {
        let bands = self.sampled_bands(key)?;
        self.stage(added, key, &bands, Self::bandwidth_hz)
    }

    /// The bandwidth of a controller in the sampled loop: where its reading, as it answers the reference, first falls 3 dB below what it is at low
    /// frequency, Hz; half of the sampling rate where it never does, none where it reads nothing.
    ///
    /// # Errors
    /// Those of [`SampledLoop::open_loop`].
    pub fn bandwidth_hz(&self, controller: usize) -> Result<Option<f64>, AnalysisError> {
        let nyquist_hz = 0.5 / self.controllers()[controller].spec.period_s;
        let closed = ClosedLoop::sampled(self, controller)?;
        closed.map(|closed| Ok(closed.bandwidth_hz()?.unwrap_or(nyquist_hz))).transpose()
    }

    fn stage(
        &self,
        added: &str,
        key: &str,
        bands: &GainBands,
        bandwidth: impl Fn(&Self, usize) -> Result<Option<f64>, AnalysisError>,
    ) -> Result<Stage, AnalysisError> {
        let (controller, gain) = self.gain_of_key(key)?;
        let edge = bands.bands.first().and_then(|band| band.upper.as_ref());
        let bandwidth_hz = match edge {
            None => None,
            Some(edge) => {
                let mut half = self.clone();
                half.set_spec(controller, with_gain(&self.controllers()[controller].spec, &gain, SHARE_OF_LIMIT * edge.gain)?);
                bandwidth(&half, controller)?
            }
        };
        let largest_gain = if bands.bands.is_empty() { Some(0.0) } else { edge.map(|edge| edge.gain) };
        Ok(Stage { added: added.into(), largest_gain, edge_hz: edge.map(|edge| edge.frequency_hz), bandwidth_hz })
    }

    /// Springs that can be taken for rigid, with the class of the mode that strains each most, by rising frequency of that mode.
    fn flexible_links(&self, modes: &[Mode], pairs: &[ModeInPair]) -> Vec<(usize, ModeClass)> {
        let plant = self.plant();
        let layout = plant.motion().layout();
        let strain = |i: usize, mode: &Mode| {
            let row = &plant.equations().elongation[i][0];
            let e: C64 = (0..layout.coordinates()).map(|g| mode.vector[layout.q(g)] * row[layout.q(g)]).sum();
            let speed: f64 = (0..layout.coordinates()).map(|g| mode.vector[layout.v(g)].norm_sqr()).sum();
            e.norm_sqr() / speed
        };
        let mut links: Vec<(f64, usize, ModeClass)> = Vec::new();
        for (i, link) in plant.motion().assembly().links.iter().enumerate().filter(|(_, link)| !link.rigid && link.stiffness > 0.0) {
            let flexible = (0..modes.len()).filter(|&m| !pairs[m].rigid_body);
            let most =
                flexible.max_by(|&a, &b| (link.stiffness * strain(i, &modes[a])).total_cmp(&(link.stiffness * strain(i, &modes[b]))));
            if let Some(m) = most {
                links.push((modes[m].frequency_hz(), i, pairs[m].class));
            }
        }
        links.sort_by(|a, b| a.0.total_cmp(&b.0));
        links.into_iter().map(|(_, i, class)| (i, class)).collect()
    }

    /// Lowest frequency at which a reference of the size that the file ends with asks for more than the drive gives: more command than the
    /// controller may put out, or more force, or faster changes of it, than the drive can make.
    fn saturation_hz(&self, key: &str) -> Result<Option<f64>, AnalysisError> {
        let (controller, _) = self.gain_of_key(key)?;
        let own = &self.controllers()[controller];
        let drive = &self.assembly().drives[own.drive];
        let command_limit = own.spec.output_limit.unwrap_or(f64::INFINITY);
        if command_limit.is_infinite() && drive.limit.is_infinite() && drive.rate_limit.is_infinite() {
            return Ok(None);
        }
        let size = Reference::new(&own.spec.reference, 0, "")?.value(f64::MAX).abs();
        let open = SampledLoop::new(self)?.open_loop(controller)?;
        // A velocity source's limit is on the force that it makes of the command.
        let force = self.plant().output(Source::Drive(own.drive, Quantity::Force))?;
        let made = SampledLoop::response_to(self, controller, force)?;
        let (around, made, law) = (TransferEvaluator::new(&open), TransferEvaluator::new(&made), law_of_reference(own)?);
        let nyquist = 0.5 / own.spec.period_s;
        for i in 0..=2000 {
            let frequency_hz = nyquist * 1e-3_f64.powf(1.0 - f64::from(i) / 2000.0);
            let w = TAU * frequency_hz;
            let z = C64::cis(w * own.spec.period_s);
            let command = law.at(z)?[(0, 0)] / (around.at(z)?[(0, 0)] + 1.0) * size;
            let force = if drive.velocity_source.is_some() { (command * made.at(z)?[(0, 0)]).norm() } else { command.norm() * drive.gain };
            if command.norm() > command_limit || force > drive.limit || w * force > drive.rate_limit {
                return Ok(Some(frequency_hz));
            }
        }
        Ok(None)
    }
}

/// One number of an assembly.
#[derive(Clone, Copy)]
enum Slot {
    Mass(usize),
    LinkStiffness(usize),
    LinkDamping(usize),
    ContactStiffness(usize),
    ContactDamping(usize),
}

impl Slot {
    fn of(self, assembly: &mut Assembly) -> &mut f64 {
        match self {
            Self::Mass(i) => &mut assembly.nodes[i].mass_kg,
            Self::LinkStiffness(i) => &mut assembly.links[i].stiffness,
            Self::LinkDamping(i) => &mut assembly.links[i].damping,
            Self::ContactStiffness(i) => &mut assembly.contacts[i].law.stiffness,
            Self::ContactDamping(i) => &mut assembly.contacts[i].law.damping,
        }
    }
}
