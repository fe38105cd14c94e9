//! The limits of the bandwidth, from the rigid body under a perfect drive to the loop as built, one
//! ingredient at a time.

use feeler_control::Law;
use feeler_plant::assembly::Assembly;
use serde::{Serialize, Serializer};

use crate::error::AnalysisError;
use crate::limits::flexible::Springs;
use crate::limits::stability::GainBands;
use crate::loops::closed_loop::{ClosedLoop, Shelf};
use crate::loops::control_loop::{ControlLoop, LoopController};
use crate::loops::gain_key::with_gain;
use crate::machine::modes::{ModeClass, ModeInPair, VibrationMode, undamped_hz};
use crate::workers::Workers;

/// Bandwidths are compared at half of the largest stable gain: a gain margin of two.
const SHARE_OF_LIMIT: f64 = 0.5;
/// An ingredient whose absence raises the limit by less than this factor does not limit.
const MATTERS: f64 = 1.05;
/// Modes with less damping than this have a peak.
const RESONANT: f64 = 0.3;
/// A bandwidth up to this many times the mode's frequency lies on the flank of that peak, 3 dB below the
/// value at low frequency.
const FLANK: f64 = 1.3;

/// Which of the paper's three problems, or the controller itself, limits the bandwidth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Limit {
    /// Inertia, damping and the drive.
    RigidBody,
    /// A mode in which actuator and sensor move in opposition.
    NoncolocatedMode,
    /// A mode of base or workpiece.
    ColocatedMode,
    /// Hold, delay and filters.
    Sampling,
    /// The drive's limit.
    Saturation,
    /// A mode that nothing damps: no gain is stable.
    UndampedMode,
    /// Nothing: no gain is too large.
    Nothing,
}

/// One stage of the waterfall: the loop with one more ingredient.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stage {
    /// The ingredient that this stage adds.
    pub added: String,
    /// Largest stable gain; `None` if there is none.
    pub largest_gain: Option<f64>,
    /// Frequency at which the loop begins to oscillate at that gain, Hz; `None` without such a gain.
    pub edge_hz: Option<f64>,
    /// Bandwidth at half that gain, Hz: where the response of the reading to the reference first falls 3 dB
    /// below its value at low frequency. Half of the sampling rate if it never does; `None` if the gain is
    /// unlimited.
    pub bandwidth_hz: Option<f64>,
    /// Bandwidth at the gain of the previous stage, Hz. It isolates the effect of this ingredient; the rest
    /// of the difference comes from the gain that it allows. `None` without a previous gain, or if this loop
    /// is unstable with it.
    pub bandwidth_at_gain_before_hz: Option<f64>,
    /// The share of the reference that is still followed beyond the bandwidth, if integral action ends there.
    pub shelf: Option<Shelf>,
}

impl Stage {
    /// Whether the drive reaches its limit below the bandwidth.
    pub(crate) fn saturates(&self, saturation_hz: Option<f64>) -> bool {
        saturation_hz.zip(self.bandwidth_hz).is_some_and(|(saturation, bandwidth)| saturation < bandwidth)
    }

    /// This stage limited to the bandwidth that saturation leaves.
    fn saturated(self, saturation_hz: Option<f64>) -> Self {
        let bandwidth_hz = self
            .bandwidth_hz
            .map(|bandwidth| saturation_hz.map_or(bandwidth, |saturation| bandwidth.min(saturation)));
        Self { added: "saturation".into(), bandwidth_hz, bandwidth_at_gain_before_hz: bandwidth_hz, ..self }
    }
}

/// The largest gain without an ingredient. Serialised as a number, `"unlimited"`, `"stable"` or `"none"`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Relief {
    /// The largest gain is this many times as large.
    Times(f64),
    /// Every gain is stable.
    Unlimited,
    /// Gains up to a largest one are stable; with the ingredient none is.
    Stable,
    /// No gain is stable, with or without the ingredient.
    NoneEither,
}

impl Relief {
    /// Compares the largest gain with an ingredient to the one without. A gain is zero if no gain is stable,
    /// and infinite if every gain is.
    fn new(with: f64, without: f64) -> Self {
        match (with > 0.0, without > 0.0) {
            (_, true) if without.is_infinite() => Self::Unlimited,
            (true, _) => Self::Times(without / with),
            (false, true) => Self::Stable,
            (false, false) => Self::NoneEither,
        }
    }

    /// As a factor, for comparison.
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

/// All stages of a loop, and the cause that limits its bandwidth.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Waterfall {
    /// From the ideal loop to the loop as built.
    pub stages: Vec<Stage>,
    /// The largest gain without each ingredient, with the others present.
    pub without: Vec<(String, Relief)>,
    /// Saturation frequency, Hz. Above it a reference as large as the final one in the file saturates the
    /// drive, at half of the largest stable gain. Zero if it saturates at rest, `None` if it never does.
    pub saturation_hz: Option<f64>,
    /// Index of a flexible mode on whose falling flank the bandwidth lies; `None` if there is none. The
    /// bandwidth then follows that mode's peak.
    pub rides_mode: Option<usize>,
    /// The cause that limits the bandwidth.
    pub limit: Limit,
}

/// The lightly damped flexible mode whose falling flank contains a frequency.
fn flank(frequency_hz: f64, modes: &[VibrationMode], pairs: &[ModeInPair]) -> Option<usize> {
    let flexible = |i: &usize| {
        !pairs[*i].rigid_body
            && pairs[*i].class != ModeClass::Uninvolved
            && modes[*i].damping_ratio() < RESONANT
    };
    let beside = |i: &usize| (1.0..=FLANK).contains(&(frequency_hz / modes[*i].frequency_hz()));
    (0..modes.len())
        .filter(flexible)
        .filter(beside)
        .max_by(|&i, &j| modes[i].frequency_hz().total_cmp(&modes[j].frequency_hz()))
}

/// Whether a law integrates its error.
fn has_integral_action(law: &Law) -> bool {
    match law {
        Law::ExplicitForce(gains) => gains.ki != 0.0,
        Law::Position(gains) => gains.ki != 0.0,
        Law::OpenLoop | Law::Impedance(_) | Law::Admittance(_) => false,
    }
}

/// Replaces drives by ideal ones with the same gain. A velocity source keeps the damping of its motor and
/// loses its lag.
fn idealise_drives(assembly: &mut Assembly) {
    for i in 0..assembly.drives.len() {
        let drive = &mut assembly.drives[i];
        drive.lags.clear();
        if let Some(source) = drive.velocity_source.take() {
            drive.gain *= source.gain;
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
        (c.spec.reading_low_pass, c.spec.reading_notch) = (None, None);
        c.spec.velocity_filter_s = 0.0;
    }
}

impl ControlLoop {
    fn has_delay(&self) -> bool {
        let late = |delay: f64| delay > 0.0;
        self.assembly().drives.iter().any(|drive| late(drive.delay))
            || self.assembly().sensors.iter().any(|sensor| late(sensor.delay))
            || self.controllers().iter().any(|c| late(c.spec.delay_s))
    }

    fn has_filters(&self) -> bool {
        self.assembly().sensors.iter().any(|sensor| !sensor.filters.is_empty())
            || self.controllers().iter().any(|c| {
                let spec = &c.spec;
                spec.reading_low_pass.is_some()
                    || spec.reading_notch.is_some()
                    || spec.velocity_filter_s > 0.0
            })
    }

    /// The loops with a hold, and then with each further ingredient between reading and command; one more in
    /// each row.
    fn sampled_rows(&self) -> Result<Vec<(String, Self)>, AnalysisError> {
        let held = self.altered(|assembly, controllers| {
            without_delay(assembly, controllers);
            without_filters(assembly, controllers);
        })?;
        let mut rows = vec![("hold".to_owned(), held)];
        if self.has_delay() {
            rows.push((
                "delay".into(),
                self.altered(|assembly, controllers| without_filters(assembly, controllers))?,
            ));
        }
        if self.has_filters() {
            rows.push(("filters".into(), self.clone()));
        }
        Ok(rows)
    }

    /// The waterfall of one gain. `modes` and `pairs` are those of the loop's own actuator and sensor.
    ///
    /// # Errors
    /// Those of [`Self::sampled_bands`] and [`Self::continuous_bands`].
    pub fn waterfall(
        &self,
        key: &str,
        modes: &[VibrationMode],
        pairs: &[ModeInPair],
        workers: Workers,
    ) -> Result<Waterfall, AnalysisError> {
        let flexible = self.flexible_links(modes, pairs);
        let rows: Vec<Springs> = self.in_rows(&flexible);
        let rigid = |assembly: &mut Assembly, links: &[(usize, ModeClass)]| {
            for (i, _) in links {
                assembly.links[*i].rigid = true;
            }
        };
        let ideal = self.altered(|assembly, _| {
            rigid(assembly, &flexible);
            idealise_drives(assembly);
        })?;
        let driven = self.altered(|assembly, _| rigid(assembly, &flexible))?;
        let mut loops = vec![("rigid body".to_owned(), ideal), ("actuator".to_owned(), driven)];
        let mut soft = 0;
        for row in &rows {
            soft += row.links.len();
            let softer = self.altered(|assembly, _| rigid(assembly, &flexible[soft..]))?;
            loops.push((row.name.clone(), softer));
        }
        let sampled_from = loops.len();
        loops.extend(self.sampled_rows()?);
        let bands = workers.collect(loops.len(), |i| match &loops[i].1 {
            continuous if i < sampled_from => continuous.continuous_bands(key),
            sampled => sampled.sampled_bands(key),
        });
        let bands = bands.into_iter().collect::<Result<Vec<_>, _>>()?;
        let stages = workers.collect(loops.len(), |i| {
            let ((added, looped), before) = (&loops[i], i.checked_sub(1).and_then(|i| bands[i].largest()));
            if i < sampled_from {
                looped.continuous_stage(added, key, &bands[i], before)
            } else {
                looped.sampled_stage(added, key, &bands[i], before)
            }
        });
        let mut stages = stages.into_iter().collect::<Result<Vec<Stage>, _>>()?;
        let last = stages[stages.len() - 1].clone();
        let largest_gain = last.largest_gain;
        let limit_gain = largest_gain.unwrap_or(f64::INFINITY);

        let relief = |bands: GainBands| Relief::new(limit_gain, bands.first_upper());
        let mut candidates =
            vec![("sampling".to_string(), Limit::Sampling, relief(self.continuous_bands(key)?))];
        let perfect = self.altered(|assembly, _| idealise_drives(assembly))?;
        candidates.push(("actuator".into(), Limit::RigidBody, relief(perfect.sampled_bands(key)?)));
        let without = workers.collect(rows.len(), |i| {
            self.altered(|assembly, _| rigid(assembly, rows[i].links))?.sampled_bands(key)
        });
        for (row, without) in rows.into_iter().zip(without) {
            let is_noncolocated = row.links.iter().any(|(_, class)| *class == ModeClass::Noncolocated);
            let limit = if is_noncolocated { Limit::NoncolocatedMode } else { Limit::ColocatedMode };
            candidates.push((row.name, limit, relief(without?)));
        }
        let saturation_hz = self.saturation_hz(key, largest_gain)?;
        if saturation_hz.is_some() {
            stages.push(last.clone().saturated(saturation_hz));
        }
        let saturates = last.saturates(saturation_hz);
        let rides_mode = last
            .bandwidth_hz
            .filter(|_| !saturates)
            .and_then(|bandwidth_hz| flank(bandwidth_hz, modes, pairs));
        let worst = candidates
            .iter()
            .max_by(|a, b| a.2.factor().total_cmp(&b.2.factor()))
            .filter(|c| limit_gain.is_finite() && c.2.factor() > MATTERS);
        let undamped = largest_gain == Some(0.0) && !undamped_hz(modes, pairs).is_empty();
        let limit = match worst {
            _ if saturates => Limit::Saturation,
            Some(candidate) => candidate.1,
            None if undamped => Limit::UndampedMode,
            None if limit_gain.is_infinite() => Limit::Nothing,
            None => Limit::RigidBody,
        };
        let without = candidates.into_iter().map(|(name, _, relief)| (name, relief)).collect();
        Ok(Waterfall { stages, without, saturation_hz, rides_mode, limit })
    }

    fn continuous_stage(
        &self,
        added: &str,
        key: &str,
        bands: &GainBands,
        before: Option<f64>,
    ) -> Result<Stage, AnalysisError> {
        self.stage(added, key, bands, before, |loops, controller| {
            let Some(closed) = ClosedLoop::continuous(loops, controller)? else { return Ok((None, None)) };
            let bandwidth_hz = closed.bandwidth_hz()?;
            Ok((bandwidth_hz, bandwidth_hz.map(|f| closed.shelf(f)).transpose()?.flatten()))
        })
    }

    pub(crate) fn sampled_stage(
        &self,
        added: &str,
        key: &str,
        bands: &GainBands,
        before: Option<f64>,
    ) -> Result<Stage, AnalysisError> {
        self.stage(added, key, bands, before, |loops, controller| {
            let nyquist_hz = 0.5 / loops.controllers()[controller].spec.period_s;
            let Some(closed) = ClosedLoop::sampled(loops, controller)? else { return Ok((None, None)) };
            let bandwidth_hz = closed.bandwidth_hz()?.unwrap_or(nyquist_hz);
            Ok((Some(bandwidth_hz), closed.shelf(bandwidth_hz)?))
        })
    }

    /// Bandwidth of a controller in the sampled loop, Hz. It is where the response of its reading to the
    /// reference first falls 3 dB below its value at low frequency. Half of the sampling rate if it never
    /// does; `None` if the controller reads nothing.
    ///
    /// # Errors
    /// Those of [`crate::SampledLoop::open_loop`].
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
        before: Option<f64>,
        follows: impl Fn(&Self, usize) -> Result<(Option<f64>, Option<Shelf>), AnalysisError>,
    ) -> Result<Stage, AnalysisError> {
        let (controller, gain) = self.gain_of_key(key)?;
        let edge = bands.bands.first().and_then(|band| band.upper.as_ref());
        let (bandwidth_hz, shelf) = match edge {
            None => (None, None),
            Some(edge) => follows(&self.at_half_of(controller, &gain, edge.gain)?, controller)?,
        };
        // The previous gain, if this loop is stable with it.
        let kept = before.filter(|largest| *largest > 0.0);
        let kept = kept.filter(|largest| edge.is_some_and(|edge| SHARE_OF_LIMIT * largest < edge.gain));
        let at_gain_before = kept
            .map(|largest| follows(&self.at_half_of(controller, &gain, largest)?, controller))
            .transpose()?;
        Ok(Stage {
            added: added.into(),
            largest_gain: bands.largest(),
            edge_hz: edge.map(|edge| edge.frequency_hz),
            bandwidth_hz,
            bandwidth_at_gain_before_hz: at_gain_before.and_then(|(bandwidth_hz, _)| bandwidth_hz),
            shelf: shelf.filter(|_| has_integral_action(&self.controllers()[controller].spec.law)),
        })
    }

    /// This loop with a gain at half of its largest stable value.
    pub(crate) fn at_half_of(
        &self,
        controller: usize,
        gain: &str,
        largest: f64,
    ) -> Result<Self, AnalysisError> {
        let mut half = self.clone();
        half.set_spec(
            controller,
            with_gain(&self.controllers()[controller].spec, gain, SHARE_OF_LIMIT * largest)?,
        );
        Ok(half)
    }
}
