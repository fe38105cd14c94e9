//! The numbers that are tuned: those of one controller, each over a range, and how they change it.

use feeler_analysis::{gain, gain_names, leading_gain, with_gain};
use feeler_control::{ControllerSpec, GainPart, Law, LeadSpec, LowPassSpec, NotchSpec};
use feeler_engine::Scenario;
use feeler_files::rounded;

use super::error::{TuneError, refused};
use super::spec::{Spec, TuneLimit, TunedPart};
use crate::why::scale_errors;

/// Largest factor on the gains on errors, up and down.
const FACTOR: f64 = 1e3;
/// Range of a gain about a size that its unit suggests.
const BELOW: f64 = 1e-3;
const ABOVE: f64 = 1e2;
/// Range of the filters' frequencies, over the sampling rate; above it the bilinear transform distorts them.
const SLOWEST: f64 = 2e-3;
const FASTEST: f64 = 0.45;
/// Range of a lead's pole over its zero: the lead amplifies noise by this ratio.
const LEAD_RATIO: [f64; 2] = [1.5, 12.0];
/// Largest number of tuned numbers: the size of a grid is a power of it.
const MOST: usize = 6;
/// Digits that are enough for any gain.
const DIGITS: usize = 4;

#[derive(Clone, Debug, PartialEq)]
enum What {
    /// A factor on all gains on errors.
    Factor,
    Gain(String),
    /// The corner of the low-pass.
    Filter,
    Lead,
    /// Ratio of the lead's pole to its zero.
    LeadRatio,
    Notch,
}

/// A number that is tuned.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Knob {
    what: What,
    /// Range of its magnitude.
    pub(super) range: [f64; 2],
    /// Whether the number may be zero, which removes its part of the controller.
    pub(super) may_be_zero: bool,
    /// Whether its values are below zero.
    is_negative: bool,
    /// Present magnitude of the number.
    now: f64,
}

impl Knob {
    /// Magnitude of a limit, and whether it is the smallest one allowed.
    fn size_of(&self, limit: &TuneLimit<String>) -> (f64, bool) {
        (if self.is_negative { -limit.bound } else { limit.bound }, limit.at_least != self.is_negative)
    }

    /// Widens the range so that a limit lies within it.
    fn reach(&mut self, limit: &TuneLimit<String>) {
        match self.size_of(limit) {
            (size, true) if size > 0.0 => self.range[1] = self.range[1].max(ABOVE * size),
            (size, false) if size > 0.0 => self.range[0] = self.range[0].min(BELOW * size),
            _ => {}
        }
    }

    /// Cuts the range at a limit; returns whether any value is left.
    fn keep(&mut self, limit: &TuneLimit<String>) -> bool {
        match self.size_of(limit) {
            (size, true) => {
                self.range[0] = self.range[0].max(size);
                self.may_be_zero &= size <= 0.0;
            }
            (size, false) => self.range[1] = self.range[1].min(size),
        }
        0.0 < self.range[0] && self.range[0] <= self.range[1]
    }

    /// The decimal logarithm of the present magnitude within the range; minus infinity for zero.
    pub(super) fn present(&self) -> f64 {
        if self.now == 0.0 && self.may_be_zero {
            f64::NEG_INFINITY
        } else {
            self.now.clamp(self.range[0], self.range[1]).log10()
        }
    }
}

/// The leading gain of a controller that has every gain of the specification.
pub(super) fn leading(base: &ControllerSpec, spec: &Spec) -> Result<&'static str, TuneError> {
    let Some(leading) = leading_gain(base) else {
        return Err(refused(
            "the controller has no gains: its output is the reference",
            "name another by --spec \"controller = NAME\"",
        ));
    };
    let names = gain_names(&base.law);
    let limited = spec.gain_limits.iter().map(|limit| &limit.of);
    match spec.gains.iter().flatten().chain(limited).find(|name| !names.contains(&name.as_str())) {
        Some(name) => Err(refused(
            format!("--spec: the law {} has no gain `{name}`", base.law.name()),
            format!("name one of {}", names.join(", ")),
        )),
        None => Ok(leading),
    }
}

#[derive(Clone, Debug)]
pub(super) struct Knobs {
    base: ControllerSpec,
    pub(super) knobs: Vec<Knob>,
}

impl Knobs {
    /// The knobs of a specification.
    pub(super) fn new(scenario: &Scenario, base: &ControllerSpec, spec: &Spec) -> Result<Self, TuneError> {
        let known = gain_names(&base.law).join(", ");
        let leading = leading(base, spec)?;
        let mut knobs = match &spec.gains {
            Some(gains) if gains.is_empty() => {
                return Err(refused("--spec: `gains =` names none", format!("name some of {known}")));
            }
            Some(gains) => {
                gains.iter().map(|name| gain_knob(scenario, base, name)).collect::<Result<Vec<_>, _>>()?
            }
            None => usual(scenario, base, leading)?,
        };
        for limit in &spec.gain_limits {
            let Some(knob) = knobs.iter_mut().find(|knob| knob.what == What::Gain(limit.of.clone())) else {
                return Err(refused(
                    format!("--spec: `{}` is limited, but not tuned by itself", limit.of),
                    format!("add gains = {}, with every gain to tune", limit.of),
                ));
            };
            knob.reach(limit);
        }
        for limit in &spec.gain_limits {
            let Some(knob) = knobs.iter_mut().find(|knob| knob.what == What::Gain(limit.of.clone())) else {
                continue;
            };
            if !knob.keep(limit) {
                return Err(refused(
                    format!("--spec: no value of `{}` is within its limits", limit.of),
                    format!("give limits with the sign of its present value, {}", gain(base, &limit.of)?),
                ));
            }
        }
        for part in &spec.parts {
            knobs.extend(part_knobs(base, *part)?);
        }
        if knobs.len() > MOST {
            return Err(refused(
                format!("--spec: {} numbers are to be tuned, {MOST} at most", knobs.len()),
                "name fewer gains, or fewer parts",
            ));
        }
        Ok(Self { base: base.clone(), knobs })
    }

    /// The controller with these magnitudes of its knobs, in digits that a file shows.
    pub(super) fn spec(&self, sizes: &[f64]) -> ControllerSpec {
        let mut spec = self.base.clone();
        let mut lead_hz = None;
        for (knob, &size) in self.knobs.iter().zip(sizes) {
            let value = rounded(if knob.is_negative { -size } else { size }, DIGITS);
            match &knob.what {
                What::Factor => {
                    scale_errors(&mut spec.law, size);
                    round_gains(&mut spec.law, &self.base.law);
                }
                What::Gain(name) => {
                    if let Ok(with) = with_gain(&spec, name, value) {
                        spec.law = with.law;
                    }
                }
                What::Filter => {
                    let damping_ratio = self.base.reading_low_pass.and_then(|filter| filter.damping_ratio);
                    spec.reading_low_pass =
                        (value > 0.0).then_some(LowPassSpec { cutoff_hz: value, damping_ratio });
                }
                What::Lead => lead_hz = Some(value),
                What::LeadRatio => {
                    if let (Law::ExplicitForce(gains), Some(zero_hz)) = (&mut spec.law, lead_hz) {
                        gains.lead = (zero_hz > 0.0)
                            .then(|| LeadSpec { zero_hz, pole_hz: rounded(zero_hz * size, DIGITS) });
                    }
                }
                What::Notch => {
                    let notch = self.base.reading_notch.unwrap_or(NotchSpec {
                        frequency_hz: value,
                        damping_ratio: NotchSpec::DEFAULT_DAMPING_RATIO,
                        depth: NotchSpec::DEFAULT_DEPTH,
                    });
                    spec.reading_notch = (value > 0.0).then_some(NotchSpec { frequency_hz: value, ..notch });
                }
            }
        }
        spec
    }

    /// The controller with all parts and gains active. Its wiring serves every other one.
    pub(super) fn all_at_work(&self) -> ControllerSpec {
        let middle: Vec<f64> = self.knobs.iter().map(|knob| (knob.range[0] * knob.range[1]).sqrt()).collect();
        self.spec(&middle)
    }

    /// A controller with a share of its gains on errors, and everything else unchanged.
    pub(super) fn with_share(spec: &ControllerSpec, share: f64) -> ControllerSpec {
        let mut less = spec.clone();
        scale_errors(&mut less.law, share);
        round_gains(&mut less.law, &spec.law);
        less
    }
}

/// A machine's own controller with the tuned keys of another: timing, approach and limits stay the machine's.
pub(super) fn installed(own: &ControllerSpec, tuned: &ControllerSpec) -> ControllerSpec {
    ControllerSpec {
        law: tuned.law.clone(),
        reading_low_pass: tuned.reading_low_pass,
        reading_notch: tuned.reading_notch,
        ..own.clone()
    }
}

/// Rounds the gains that have changed.
fn round_gains(law: &mut Law, was: &Law) {
    for field in law.gains() {
        if let (Some(now), Some(before)) = (field.number(law), field.number(was))
            && now.to_bits() != before.to_bits()
        {
            field.set_number(law, rounded(now, DIGITS));
        }
    }
}

/// One knob for all gains on errors, and one for damping if there is any.
fn usual(scenario: &Scenario, base: &ControllerSpec, leading: &str) -> Result<Vec<Knob>, TuneError> {
    if gain(base, leading)? == 0.0 {
        return Ok(vec![gain_knob(scenario, base, leading)?]);
    }
    let mut scaled = base.law.clone();
    scale_errors(&mut scaled, 2.0);
    let is_kept = |value: Option<f64>, scaled| value == scaled && value != Some(0.0);
    let kept = (base.law.gain(GainPart::Damping))
        .filter(|damping| is_kept(damping.number(&base.law), damping.number(&scaled)));
    let range = [FACTOR.recip(), FACTOR];
    let mut knobs = Vec::new();
    if scaled != base.law {
        knobs.push(Knob { what: What::Factor, range, may_be_zero: false, is_negative: false, now: 1.0 });
    }
    if let Some(damping) = kept {
        knobs.push(gain_knob(scenario, base, damping.key.name)?);
    }
    Ok(knobs)
}

/// A gain over the range that its unit, the sampling and the masses suggest.
fn gain_knob(scenario: &Scenario, base: &ControllerSpec, name: &str) -> Result<Knob, TuneError> {
    let present = gain(base, name)?;
    let leads = leading_gain(base) == Some(name);
    let size = if present == 0.0 { typical(scenario, base, name)? } else { present.abs() };
    Ok(Knob {
        what: What::Gain(name.into()),
        range: [BELOW * size, ABOVE * size],
        may_be_zero: !leads,
        is_negative: present < 0.0,
        now: present.abs(),
    })
}

/// A typical magnitude of a gain that is zero so far, from the leading gain, the period and the masses.
fn typical(scenario: &Scenario, base: &ControllerSpec, name: &str) -> Result<f64, TuneError> {
    let leading = leading_gain(base).map_or(Ok(1.0), |leading| gain(base, leading))?.abs();
    let leading = if leading > 0.0 { leading } else { 1.0 };
    let mass_kg: f64 = scenario.machine.bodies.values().map(|body| body.mass_kg).fold(0.0, f64::max);
    let stiffness = scenario.machine.contacts.values().map(|contact| contact.stiffness).fold(0.0, f64::max);
    // Integral over proportional gain: a tenth of the sampling rate; derivative: ten periods.
    let is = |part| base.law.gain(part).is_some_and(|gain| gain.key.name == name);
    Ok(if is(GainPart::Damping) {
        (mass_kg * stiffness).sqrt().max(f64::MIN_POSITIVE)
    } else if is(GainPart::Integral) {
        0.1 * leading / base.period_s
    } else if is(GainPart::Derivative) {
        10.0 * leading * base.period_s
    } else {
        leading
    })
}

fn part_knobs(base: &ControllerSpec, part: TunedPart) -> Result<Vec<Knob>, TuneError> {
    let range = [SLOWEST / base.period_s, FASTEST / base.period_s];
    let knob = |what, range, may_be_zero, now| Knob { what, range, may_be_zero, is_negative: false, now };
    Ok(match part {
        TunedPart::Filter => {
            let now = base.reading_low_pass.map_or(0.0, |filter| filter.cutoff_hz);
            vec![knob(What::Filter, range, base.reading_low_pass.is_none(), now)]
        }
        TunedPart::Notch => {
            let now = base.reading_notch.map_or(0.0, |notch| notch.frequency_hz);
            vec![knob(What::Notch, range, base.reading_notch.is_none(), now)]
        }
        TunedPart::Lead => {
            let Law::ExplicitForce(gains) = &base.law else {
                return Err(refused(
                    format!("--spec: the law {} has no lead", base.law.name()),
                    "leave the lead out, or write the law explicit-force",
                ));
            };
            let [zero, ratio] =
                gains.lead.map_or([0.0, LEAD_RATIO[0]], |lead| [lead.zero_hz, lead.pole_hz / lead.zero_hz]);
            vec![
                knob(What::Lead, range, gains.lead.is_none(), zero),
                knob(What::LeadRatio, LEAD_RATIO, false, ratio),
            ]
        }
    })
}
