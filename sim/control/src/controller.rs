//! A controller compiled for its lanes.

use std::fmt;

use feeler_catalogue::LOW_PASS;
use feeler_lanes::{Lane, LaneMask};

use crate::admittance::{AdmittanceConfig, AdmittanceState};
use crate::approach::{ApproachConfig, ApproachState};
use crate::error::ControlError;
use crate::filter::{Section, SectionState};
use crate::impedance::{ImpedanceConfig, ImpedanceState};
use crate::law::{AdmittanceGains, ForceGains, ImpedanceGains, Law};
use crate::listing::Listing;
use crate::motion::{MotionConfig, MotionState};
use crate::pid::{PidConfig, PidState, limited, list_limited};
use crate::spec::ControllerSpec;

/// Signals that a controller reads at one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inputs<L> {
    /// The sensor named by `reads`: a force, or the position for the position law.
    pub reading: L,
    /// The position or velocity sensor for damping, approach, impedance and admittance; zero without one.
    pub motion: L,
    /// Whether `motion` is a velocity. A position is differentiated if a velocity is needed. A velocity is
    /// integrated from the first sample if a position is needed.
    pub motion_is_velocity: bool,
}

#[derive(Clone)]
enum LawConfig<L: Lane> {
    OpenLoop,
    Force(PidConfig<L>),
    Position(PidConfig<L>),
    Impedance(ImpedanceConfig<L>),
    Admittance(AdmittanceConfig<L>),
}

/// State of the law of all lanes; each law uses its own part.
#[derive(Clone, Copy, Default)]
struct LawState<L> {
    pid: PidState<L>,
    impedance: ImpedanceState<L>,
    admittance: AdmittanceState<L>,
}

#[derive(Clone)]
struct Config<L: Lane> {
    /// Name of the law.
    name: &'static str,
    law: LawConfig<L>,
    low_pass: Option<Section<L>>,
    notch: Option<Section<L>>,
    motion: MotionConfig<L>,
    approach: ApproachConfig<L>,
    /// Zero in lanes with a continuous output; `None` if all are continuous.
    resolution: Option<L>,
    limit: L,
}

/// State that changes in a run.
#[derive(Clone, Copy)]
struct State<L: Lane> {
    started: bool,
    law: LawState<L>,
    low_pass: SectionState<L>,
    notch: SectionState<L>,
    motion: MotionState<L>,
    approach: ApproachState<L>,
    saturated: L::Mask,
}

/// A controller of `L::WIDTH` variants with the same law and sample instants, and different numbers.
///
/// One sample has these steps. Low-pass and notch of the reading; position and velocity from the motion
/// sensor; approach or contact phase, lane by lane; the law. Then rounding to the output resolution, and the
/// output limit. A law that starts, at the first sample or when an approach ends, has no history. Its
/// integral and derivative are zero, and its lead is settled at the present error.
#[derive(Clone)]
pub struct Controller<L: Lane> {
    config: Config<L>,
    state: State<L>,
}

impl<L: Lane> Controller<L> {
    /// Compiles `per_lane[i]` into lane `i`. The laws' gains, the approach, the filters, the resolution and
    /// the limit may differ between lanes. The kind of law, the period, the offset and the jitter may not.
    ///
    /// # Errors
    /// A wrong number of specs, a number out of its range, or lanes that cannot run side by side.
    pub fn new(per_lane: &[ControllerSpec]) -> Result<Self, ControlError> {
        if per_lane.len() != L::WIDTH {
            return Err(ControlError::LaneCount { lanes: L::WIDTH, given: per_lane.len() });
        }
        let timing = |spec: &ControllerSpec| [spec.period_s, spec.offset_s, spec.jitter_s].map(f64::to_bits);
        for (lane, spec) in per_lane.iter().enumerate() {
            spec.check()?;
            if spec.law.name() != per_lane[0].law.name() {
                return Err(ControlError::LawsDiffer { lane });
            }
            if timing(spec) != timing(&per_lane[0]) {
                return Err(ControlError::TimingDiffers { lane });
            }
        }
        let period_s = per_lane[0].period_s;
        let config = Config {
            name: per_lane[0].law.name(),
            law: LawConfig::new(per_lane, period_s),
            low_pass: Section::of_lanes(|i| {
                per_lane[i].reading_low_pass.map(|filter| match filter.damping_ratio {
                    Some(zeta) => Section::low_pass_second(filter.cutoff_hz, zeta, period_s),
                    None => Section::low_pass_first(filter.cutoff_hz, period_s),
                })
            }),
            notch: Section::of_lanes(|i| {
                let notch = per_lane[i].reading_notch?;
                Some(Section::notch(notch.frequency_hz, notch.damping_ratio, notch.depth, period_s))
            }),
            motion: MotionConfig::new(period_s, L::from_fn(|i| per_lane[i].velocity_filter_s)),
            approach: ApproachConfig::new(|i| per_lane[i].approach),
            resolution: per_lane
                .iter()
                .any(|spec| spec.output_resolution.is_some())
                .then(|| L::from_fn(|i| per_lane[i].output_resolution.unwrap_or(0.0))),
            limit: L::from_fn(|i| per_lane[i].output_limit.unwrap_or(f64::INFINITY)),
        };
        Ok(Self { config, state: State::new() })
    }

    /// Takes the inputs of the sample at `t_s` and returns the command to apply after the delay. Does not
    /// allocate.
    ///
    /// The difference equations use the nominal period, since a real controller assumes its clock is exact;
    /// `t_s` moves the approach's ramp.
    #[inline(always)]
    pub fn sample(&mut self, t_s: f64, inputs: &Inputs<L>, reference: L) -> L {
        self.sample_fed(t_s, inputs, reference, L::zero())
    }

    /// [`Self::sample`] with a force that the force and the position law add to their output before its
    /// limit.
    #[inline(always)]
    pub fn sample_fed(&mut self, t_s: f64, inputs: &Inputs<L>, reference: L, fed: L) -> L {
        let Self { config, state } = self;
        let mut y = inputs.reading;
        for (filter, of_filter) in
            [(&config.low_pass, &mut state.low_pass), (&config.notch, &mut state.notch)]
        {
            if let Some(filter) = filter {
                if !state.started {
                    *of_filter = filter.settled(y);
                }
                y = filter.update(of_filter, y);
            }
        }
        state.started = true;
        let motion = if matches!(config.law, LawConfig::Position(_)) && !inputs.motion_is_velocity {
            y
        } else {
            inputs.motion
        };
        let (x, v) = config.motion.update(&mut state.motion, motion, inputs.motion_is_velocity);
        let phase = config.approach.update(&mut state.approach, L::splat(t_s), y, x, v);

        let (r, limit, fresh) = (reference, config.limit, phase.fresh);
        let law = &mut state.law;
        let in_contact = match &config.law {
            LawConfig::OpenLoop => r,
            LawConfig::Force(pid) | LawConfig::Position(pid) => {
                pid.update(&mut law.pid, r, y, v, fed, limit, fresh)
            }
            LawConfig::Impedance(impedance) => impedance.update(&mut law.impedance, r, y, x, v, fresh),
            LawConfig::Admittance(admittance) => admittance.update(&mut law.admittance, r, y, x, v, fresh),
        };
        let wanted = L::select(phase.contact, in_contact, phase.output);
        state.saturated = wanted.gt(limit) | wanted.lt(-limit);

        limited(config.resolution.as_ref().map_or(wanted, |&q| rounded(wanted, q)), limit)
    }

    /// Resets to the state before the first sample.
    pub fn reset(&mut self) {
        self.state = State::new();
    }

    /// Lanes whose law was running at the last sample; the others were approaching.
    pub fn in_contact_phase(&self) -> L::Mask {
        self.state.approach.contact()
    }

    /// Lanes whose output exceeded its limit at the last sample.
    pub fn saturated(&self) -> L::Mask {
        self.state.saturated
    }
}

impl<L: Lane> fmt::Debug for Controller<L> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Controller")
            .field("law", &self.config.name)
            .field("lanes", &L::WIDTH)
            .finish_non_exhaustive()
    }
}

impl Controller<f64> {
    /// The computation of one sample, as a program; `motion_is_velocity` as in [`Inputs`].
    ///
    /// ```
    /// use feeler_control::{Controller, ControllerSpec, ForceGains, Law};
    ///
    /// let gains = ForceGains { kp: 0.5, ..ForceGains::default() };
    /// let controller = Controller::<f64>::new(&[ControllerSpec::new(Law::ExplicitForce(gains), 1e-3)])?;
    /// let listing = controller.listing(None);
    /// assert!(listing.constants.contains(&("KP".into(), 0.5)));
    /// # Ok::<(), feeler_control::ControlError>(())
    /// ```
    pub fn listing(&self, motion_is_velocity: Option<bool>) -> Listing {
        let config = &self.config;
        let mut listing = Listing::default();
        let l = &mut listing;
        let reads = !matches!(config.law, LawConfig::OpenLoop) || config.approach.is_present();
        let mut y = "reading".to_owned();
        let notch = ControllerSpec::NOTCH.key.name;
        for (name, filter) in [(LOW_PASS, &config.low_pass), (notch, &config.notch)] {
            if let Some(filter) = filter.as_ref().filter(|_| reads) {
                l.truth_state("started");
                y = filter.list(l, name, &y, "!s.started");
            }
        }
        let is_position = matches!(config.law, LawConfig::Position(_));
        let differences_reading = is_position && motion_is_velocity != Some(true);
        let integrates = !is_position || config.approach.is_present();
        let (x, v) = match (differences_reading, motion_is_velocity) {
            (true, _) => config.motion.list(l, &y, false, integrates),
            (false, Some(is_velocity)) => config.motion.list(l, "motion", is_velocity, integrates),
            (false, None) => ("0.0".into(), "0.0".into()),
        };
        let (fresh, wanted) = config.approach.list_phase(l, &y, &x);
        let limit = Some(config.limit).filter(|limit| limit.is_finite());
        if let Some(limit) = limit {
            l.constant("LIMIT", limit);
        }
        let output = match &config.law {
            LawConfig::OpenLoop => "reference".into(),
            LawConfig::Force(pid) | LawConfig::Position(pid) => pid.list(l, &y, &v, limit.is_some(), &fresh),
            LawConfig::Impedance(impedance) => impedance.list(l, &y, &x, &v, &fresh),
            LawConfig::Admittance(admittance) => admittance.list(l, &y, &x, &v, &fresh),
        };
        let mut output = config.approach.list_output(l, &output, wanted.as_deref(), &x, &v);
        if l.has_state("started") {
            l.set("started", "true");
        }
        if let Some(resolution) = config.resolution {
            l.constant("RESOLUTION", resolution);
            l.rounded("steps", &format!("{output} / RESOLUTION"));
            l.number("rounded", "steps * RESOLUTION");
            output = "rounded".into();
        }
        if limit.is_some() {
            list_limited(l, "limited", &output);
            output = "limited".into();
        }
        l.output = output;
        listing
    }
}

impl<L: Lane> LawConfig<L> {
    /// Compiles the laws of the lanes. All of `per_lane` have the same kind of law as the first.
    fn new(per_lane: &[ControllerSpec], period_s: f64) -> Self {
        match per_lane[0].law {
            Law::OpenLoop => Self::OpenLoop,
            Law::ExplicitForce(_) => Self::Force(PidConfig::new(period_s, |i| per_lane[i].law.pid_gains())),
            Law::Position(_) => Self::Position(PidConfig::new(period_s, |i| per_lane[i].law.pid_gains())),
            Law::Impedance(_) => {
                Self::Impedance(ImpedanceConfig::new(period_s, |i| per_lane[i].law.impedance_gains()))
            }
            Law::Admittance(_) => {
                Self::Admittance(AdmittanceConfig::new(period_s, |i| per_lane[i].law.admittance_gains()))
            }
        }
    }
}

impl Law {
    fn pid_gains(&self) -> ForceGains {
        match *self {
            Self::ExplicitForce(gains) => gains,
            Self::Position(gains) => gains.into(),
            _ => ForceGains::default(),
        }
    }

    fn impedance_gains(&self) -> ImpedanceGains {
        if let Self::Impedance(gains) = *self { gains } else { ImpedanceGains::default() }
    }

    fn admittance_gains(&self) -> AdmittanceGains {
        if let Self::Admittance(gains) = *self { gains } else { AdmittanceGains::default() }
    }
}

impl<L: Lane> State<L> {
    fn new() -> Self {
        Self {
            started: false,
            law: LawState::default(),
            low_pass: SectionState::default(),
            notch: SectionState::default(),
            motion: MotionState::default(),
            approach: ApproachState::new(),
            saturated: L::Mask::splat(false),
        }
    }
}

/// `u` rounded to a multiple of `resolution`, if that is above zero.
#[inline(always)]
fn rounded<L: Lane>(u: L, resolution: L) -> L {
    let multiple = (u / resolution).map(f64::round_ties_even) * resolution;
    L::select(resolution.gt(L::zero()), multiple, u)
}

/// Length of [`State::vector`].
pub(crate) const STATE_LENGTH: usize = 15;

impl State<f64> {
    /// The state with the numbers `x`, some samples into a contact phase.
    fn in_contact([a, b, c, d, e, f, g, h, i, j, k, l, m, n, o]: [f64; STATE_LENGTH]) -> Self {
        Self {
            started: true,
            low_pass: SectionState::from_array([a, b]),
            notch: SectionState::from_array([n, o]),
            motion: MotionState::from_array([c, d, e]),
            law: LawState {
                pid: PidState::from_array([f, g, h, i, j]),
                impedance: ImpedanceState::from_array([k]),
                admittance: AdmittanceState::from_array([l, m]),
            },
            approach: ApproachState::in_contact(),
            saturated: false,
        }
    }

    /// Every number that one sample passes to the next in a contact phase.
    fn vector(&self) -> [f64; STATE_LENGTH] {
        let [a, b] = self.low_pass.to_array();
        let [c, d, e] = self.motion.to_array();
        let [f, g, h, i, j] = self.law.pid.to_array();
        let [k] = self.law.impedance.to_array();
        let [l, m] = self.law.admittance.to_array();
        let [n, o] = self.notch.to_array();
        [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o]
    }
}

impl Controller<f64> {
    /// One sample of the contact phase from state `x`: the next state and the output.
    pub(crate) fn step_from(
        &mut self,
        x: [f64; STATE_LENGTH],
        inputs: &Inputs<f64>,
        reference: f64,
    ) -> ([f64; STATE_LENGTH], f64) {
        self.state = State::in_contact(x);
        let output = self.sample(0.0, inputs, reference);
        (self.state.vector(), output)
    }
}
