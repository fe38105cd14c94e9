//! The specification of one controller in a file.

use feeler_catalogue::{
    Bound, CORNER, DAMPING_RATIO, Dimension, Field, KeyKind, Keyed, Keys, LONGEST_DELAY, LOW_PASS, Tabled,
    Unit, field, keys, low_pass, number, optional, required,
};

use crate::error::{APPROACH as APPROACH_NAME, ControlError};
use crate::law::Law;
use crate::reference::ReferenceSpec;

/// The specification of one controller (SI: on a rotational axis read N m for N and rad for m).
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerSpec {
    /// The control law and its gains.
    pub law: Law,
    /// Time between samples, s.
    pub period_s: f64,
    /// Time from a sample until its output acts, s; any number, not only whole periods.
    pub delay_s: f64,
    /// Standard deviation of each sample instant about its nominal time, s.
    pub jitter_s: f64,
    /// Time of the first sample, s.
    pub offset_s: f64,
    /// The phase before contact, if any.
    pub approach: Option<Approach>,
    /// Step of the output (a converter's least significant bit), in units of the output.
    pub output_resolution: Option<f64>,
    /// Largest magnitude of the output, in units of the output; the anti-windup uses it.
    pub output_limit: Option<f64>,
    /// Low-pass that the controller applies to `Inputs::reading` before anything else.
    pub reading_low_pass: Option<LowPassSpec>,
    /// Notch that the controller applies to the reading after its low-pass.
    pub reading_notch: Option<NotchSpec>,
    /// Time constant of the first-order low-pass on a differentiated position, s; zero for none.
    pub velocity_filter_s: f64,
    /// Reference of the loop.
    pub reference: ReferenceSpec,
}

impl ControllerSpec {
    /// A controller with `law` every `period_s`, without delay, jitter, approach or limit, and with a
    /// reference of zero.
    pub fn new(law: Law, period_s: f64) -> Self {
        Self {
            law,
            period_s,
            delay_s: 0.0,
            jitter_s: 0.0,
            offset_s: 0.0,
            approach: None,
            output_resolution: None,
            output_limit: None,
            reading_low_pass: None,
            reading_notch: None,
            velocity_filter_s: 0.0,
            reference: ReferenceSpec::Constant(0.0),
        }
    }

    /// The key of its notch's frequency.
    pub fn notch_frequency() -> String {
        format!("{}.{}", Self::NOTCH.key.name, NotchSpec::FREQUENCY.key.name)
    }

    /// Checks every number but the reference's, which [`crate::Reference::new`] checks.
    ///
    /// # Errors
    /// The first number that is out of its range, with its key.
    pub fn check(&self) -> Result<(), ControlError> {
        in_range(self)?;
        in_range(&self.law)?;
        let low_pass = self.reading_low_pass.map(|filter| (LOW_PASS.to_owned(), filter.cutoff_hz));
        let notch = self.reading_notch.map(|notch| (Self::notch_frequency(), notch.frequency_hz));
        let bound = 0.5 / self.period_s;
        if let Some((key, value)) = [low_pass, notch].into_iter().flatten().find(|(_, at)| *at >= bound) {
            return Err(ControlError::TooLarge { key, value, bound, why: "half the sample rate" });
        }
        if let Some(approach) = &self.approach {
            approach.check()?;
            if matches!(self.law, Law::Position(_)) {
                return Err(ControlError::ApproachNeedsForce);
            }
        }
        if matches!(self.law, Law::Admittance(gains) if gains.mass == 0.0 && gains.damping == 0.0) {
            let [mass, damping] = [Law::ADMITTANCE_MASS, Law::ADMITTANCE_DAMPING].map(|field| field.key.name);
            return Err(ControlError::AdmittanceWithoutMassOrDamping { mass, damping });
        }
        Ok(())
    }
}

fn in_range<T: Keyed>(record: &T) -> Result<(), ControlError> {
    record
        .out_of_range()
        .map_or(Ok(()), |(key, value, bound)| Err(ControlError::OutOfRange { key, value, bound }))
}

/// A low-pass of gain 1 at zero frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowPassSpec {
    /// Cut-off (first order) or natural (second order) frequency, Hz.
    pub cutoff_hz: f64,
    /// Damping ratio of a second-order filter; `None` for first order.
    pub damping_ratio: Option<f64>,
}

/// A notch `(s^2 + 2 depth zeta w s + w^2) / (s^2 + 2 zeta w s + w^2)` of gain 1 at zero frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotchSpec {
    /// Frequency at which it is deepest, Hz.
    pub frequency_hz: f64,
    /// Damping ratio of its poles: half of its relative width.
    pub damping_ratio: f64,
    /// Gain where it is deepest.
    pub depth: f64,
}

impl NotchSpec {
    /// Damping ratio unless the file says otherwise.
    pub const DEFAULT_DAMPING_RATIO: f64 = 0.5;
    /// Depth unless the file says otherwise.
    pub const DEFAULT_DEPTH: f64 = 0.1;
}

/// The phase before contact: the tool moves at a set speed until the reading reaches a force.
///
/// With a force drive the axis follows the ramp `x_0 + speed (t - t_0)`, where `x_0` and `t_0` belong to the
/// first sample of the phase: `u = M w^2 (x_0 + speed (t - t_0) - x) + 2 * 0.7 M w (speed - v)`, `w = 2 pi
/// bandwidth_hz`. With a velocity source the command is the speed itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Speed towards the workpiece, m/s.
    pub speed: f64,
    /// The phase ends at the first sample whose reading is at least this, N.
    pub until: f64,
    /// The phase restarts at the first sample whose reading is below this, N (hysteresis, so at most
    /// `until`). `None`: contact latches.
    pub release: Option<f64>,
    /// Natural frequency of the approach's position loop, Hz.
    pub bandwidth_hz: f64,
    /// The mass that the approach's position loop assumes, kg. The caller fills it in from the machine.
    pub effective_mass: f64,
    pub velocity_drive: bool,
}

impl Approach {
    /// Default natural frequency of the approach's position loop, Hz.
    pub const DEFAULT_BANDWIDTH_HZ: f64 = 8.0;

    /// An approach that latches, with the default bandwidth and a force drive that moves `effective_mass`.
    pub fn new(speed: f64, until: f64, effective_mass: f64) -> Self {
        Self {
            speed,
            until,
            release: None,
            bandwidth_hz: Self::DEFAULT_BANDWIDTH_HZ,
            effective_mass,
            velocity_drive: false,
        }
    }

    fn check(&self) -> Result<(), ControlError> {
        if let Some(value) = self.release.filter(|release| *release > self.until) {
            let (bound, why) = (self.until, "the threshold that ends the approach");
            return Err(ControlError::TooLarge { key: Self::key(&Self::RELEASE), value, bound, why });
        }
        if self.velocity_drive {
            return Ok(());
        }
        if Bound::Positive.admits(self.effective_mass) {
            return Ok(());
        }
        Err(ControlError::ApproachMass { value: self.effective_mass })
    }

    /// The key of a field in a controller, as `approach.until`.
    pub fn key(field: &Field<Self>) -> String {
        format!("{}.{}", ControllerSpec::APPROACH.key.name, field.key.name)
    }
}

const TIME: Unit = Unit::Of(Dimension::TIME);
const FREQUENCY: Unit = Unit::Of(Dimension::FREQUENCY);
const FORCE: Unit = Unit::Of(Dimension::FORCE);

/// No controller samples a billion times a second.
const SHORTEST_PERIOD: Bound = Bound::Within(1e-9, 1e6);

impl Tabled for ControllerSpec {
    const TABLE: &'static str = "controllers";
}

impl ControllerSpec {
    /// Time between its samples.
    pub const PERIOD: Field<Self> = field!(ControllerSpec: period_s,
        required("period", KeyKind::Quantity(TIME, SHORTEST_PERIOD),
            "time between samples; t = 0 is a sample"));
    /// Time from a sample until its output acts.
    pub const DELAY: Field<Self> = field!(ControllerSpec: delay_s,
        number("delay", TIME, LONGEST_DELAY, 0.0,
            "from a sample to the instant at which its output is applied; any number"));
    /// Its largest output.
    pub const OUTPUT_LIMIT: Field<Self> = field!(ControllerSpec: output_limit,
        optional("output_limit", KeyKind::Quantity(Unit::Output, Bound::Positive),
            "largest output, against which the anti-windup works"));
    /// Scatter of its sample instants.
    pub const JITTER: Field<Self> = field!(ControllerSpec: jitter_s,
        number("jitter", TIME, Bound::NotNegative, 0.0,
            "one sigma of each sample instant about its nominal time"));
    /// The notch on its reading.
    pub const NOTCH: Field<Self> = field!(ControllerSpec: reading_notch,
        optional("notch", KeyKind::Table(&NOTCH),
            "notch on the reading, after its low-pass, of gain 1 at zero frequency"));
    /// The phase before contact.
    pub const APPROACH: Field<Self> = field!(ControllerSpec: approach,
        optional(APPROACH_NAME, KeyKind::Table(&APPROACH),
            "the phase before contact: move at a set speed until the reading reaches a force"));
}

impl NotchSpec {
    /// Frequency at which it is deepest.
    pub const FREQUENCY: Field<Self> = field!(NotchSpec: frequency_hz,
        required("frequency", KeyKind::Quantity(FREQUENCY, Bound::Positive), "where it is deepest"));
}

/// Everything except the law and the reference, which have their own keys.
impl Keyed for ControllerSpec {
    const FIELDS: &'static [Field<Self>] = &[
        ControllerSpec::PERIOD,
        ControllerSpec::DELAY,
        ControllerSpec::JITTER,
        field!(ControllerSpec: offset_s,
            number("offset", TIME, Bound::NotNegative, 0.0, "time of the first sample")),
        field!(ControllerSpec: output_resolution,
            optional("output_resolution", KeyKind::Quantity(Unit::Output, Bound::Positive),
                "step of the output")),
        ControllerSpec::OUTPUT_LIMIT,
        field!(ControllerSpec: reading_low_pass,
            low_pass("discrete filter on the reading: a corner frequency, or a table")),
        ControllerSpec::NOTCH,
        field!(ControllerSpec: velocity_filter_s,
            number("velocity_filter", TIME, Bound::NotNegative, 0.0,
                "time constant of the filter on a velocity got by differencing positions")),
        ControllerSpec::APPROACH,
    ];
}

impl Keyed for LowPassSpec {
    const FIELDS: &'static [Field<Self>] =
        &[field!(LowPassSpec: cutoff_hz, CORNER), field!(LowPassSpec: damping_ratio, DAMPING_RATIO)];

    fn blank() -> Option<Self> {
        Some(Self { cutoff_hz: 1.0, damping_ratio: None })
    }
}

static NOTCH: Keys = Keys { keys: keys!(NotchSpec::FIELDS), choice: None };

impl Keyed for NotchSpec {
    const FIELDS: &'static [Field<Self>] = &[
        NotchSpec::FREQUENCY,
        field!(NotchSpec: damping_ratio,
            number("damping_ratio", Unit::Of(Dimension::NONE), Bound::Positive,
                NotchSpec::DEFAULT_DAMPING_RATIO, "of its poles: half of its relative width")),
        field!(NotchSpec: depth,
            number("depth", Unit::Of(Dimension::NONE), Bound::Within(0.0, 1.0), NotchSpec::DEFAULT_DEPTH,
                "gain where it is deepest")),
    ];

    fn blank() -> Option<Self> {
        Some(Self {
            frequency_hz: 1.0,
            damping_ratio: Self::DEFAULT_DAMPING_RATIO,
            depth: Self::DEFAULT_DEPTH,
        })
    }
}

static APPROACH: Keys = Keys { keys: keys!(Approach::FIELDS), choice: None };

impl Approach {
    /// The force that ends it.
    pub const UNTIL: Field<Self> = field!(Approach: until,
        required("until", KeyKind::Quantity(FORCE, Bound::Any),
            "the phase ends at the first sample whose reading is at least this"));
    /// The force below which it starts again.
    pub const RELEASE: Field<Self> = field!(Approach: release,
        optional("release", KeyKind::Quantity(FORCE, Bound::Any),
            "it starts again below this, at most `until`; if absent, contact latches"));
}

/// Values that come from the machine are not keys.
impl Keyed for Approach {
    const FIELDS: &'static [Field<Self>] = &[
        field!(Approach: speed,
            required("speed", KeyKind::Quantity(Unit::Of(Dimension::VELOCITY), Bound::Positive),
                "speed towards the workpiece")),
        Approach::UNTIL,
        Approach::RELEASE,
        field!(Approach: bandwidth_hz,
            number("bandwidth", FREQUENCY, Bound::Positive, Approach::DEFAULT_BANDWIDTH_HZ,
                "of the position loop that moves a force drive")),
    ];

    fn blank() -> Option<Self> {
        Some(Self::new(1.0, 1.0, 1.0))
    }
}
