//! Control laws: their gains, and the keys of these in files.

use feeler_catalogue::{
    Absent, Bound, Content, Contents, Dimension, Field, Form, GainPart, Key, KeyKind, KeyRole, Keyed, Keys,
    Slot, Unit, Word, field, form, keys, number, optional, required, word,
};

/// A control law with its gains.
#[derive(Clone, Debug, PartialEq)]
pub enum Law {
    /// The output is the reference.
    OpenLoop,
    /// Explicit force control: the reading is a force, and the reference is the desired force.
    ExplicitForce(ForceGains),
    /// Position control: the reading is a position, and the reference is the desired position.
    Position(PositionGains),
    /// A programmed stiffness and damping about a reference position.
    Impedance(ImpedanceGains),
    /// A virtual body moved by the force error, tracked by an inner position loop.
    Admittance(AdmittanceGains),
}

impl Law {
    /// The law with this name in files.
    pub fn named(name: &str) -> Option<Self> {
        Self::FORMS.iter().find(|form| form.name == name).map(|form| (form.start)())
    }

    /// The law's name in files.
    pub fn name(&self) -> &'static str {
        self.form().map_or("", |form| form.name)
    }

    /// The gains of the law, the most important first.
    pub fn gains(&self) -> Vec<&'static Field<Self>> {
        let rank =
            |field: &Field<Self>| if let KeyRole::Gain { rank, .. } = field.role { Some(rank) } else { None };
        let mut gains: Vec<_> = self.fields().filter(|field| rank(field).is_some()).collect();
        gains.sort_by_key(|field| rank(field));
        gains
    }

    /// The gain of a part of the law; `None` if the law has no such part.
    pub fn gain(&self, part: GainPart) -> Option<&'static Field<Self>> {
        self.fields().find(|field| matches!(field.role, KeyRole::Gain { part: own, .. } if own == part))
    }

    /// Unit of the reference.
    pub fn follows(&self) -> Unit {
        match self {
            Self::OpenLoop => Unit::Output,
            Self::ExplicitForce(_) | Self::Admittance(_) => Unit::Of(Dimension::FORCE),
            Self::Position(_) | Self::Impedance(_) => Unit::Of(Dimension::LENGTH),
        }
    }

    /// Whether the law requires a motion sensor.
    pub fn needs_motion(&self) -> bool {
        match self {
            Self::OpenLoop | Self::Position(_) => false,
            Self::ExplicitForce(gains) => gains.damping != 0.0,
            Self::Impedance(_) | Self::Admittance(_) => true,
        }
    }
}

/// Gains of explicit force control, `u = feed_forward r + C(z) e - damping v`, `e = r - f`, with `C` a PID in
/// series with an optional lead. Gains default to zero. Units follow the drive: the output is a force, or a
/// velocity for a velocity source.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ForceGains {
    /// Gain from the reference to the output.
    pub feed_forward: f64,
    /// Proportional gain, output per N.
    pub kp: f64,
    /// Integral gain, output per N s.
    pub ki: f64,
    /// Derivative gain, output per N/s.
    pub kd: f64,
    /// Joint damping, output per m/s of the motion sensor.
    pub damping: f64,
    /// Time constant of the first-order filter on the derivative, s; zero for none.
    pub derivative_filter_s: f64,
    /// Lead (or lag) compensator in series with the PID.
    pub lead: Option<LeadSpec>,
    /// Behaviour of the integrator at the output limit.
    pub anti_windup: AntiWindup,
}

/// Gains of position control, `u = kp e + ki int(e) + kd de/dt - damping v`, `e = r - x`. Gains default to
/// zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PositionGains {
    /// Proportional gain, output per m.
    pub kp: f64,
    /// Integral gain, output per m s.
    pub ki: f64,
    /// Derivative gain on the error, output per m/s.
    pub kd: f64,
    /// Damping on the measured velocity alone (no kick when the reference steps), output per m/s.
    pub damping: f64,
    /// Time constant of the first-order filter on the derivative, s; zero for none.
    pub derivative_filter_s: f64,
    /// Behaviour of the integrator at the output limit.
    pub anti_windup: AntiWindup,
}

/// Gains of impedance control (Hogan, "Impedance Control", ASME J. Dyn. Sys. Meas. Control 107, 1985):
/// `f_d = stiffness (x_r - x) + damping (v_r - v)`, `u = f_d + force_gain (f_d - f)`.
///
/// With a force drive the force gain divides the apparent inertia by `1 + force_gain`; zero needs no force
/// sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImpedanceGains {
    /// Stiffness of the programmed spring, N/m.
    pub stiffness: f64,
    /// Damping of the programmed damper, N s/m.
    pub damping: f64,
    /// Gain of the inner force loop, dimensionless.
    pub force_gain: f64,
}

/// Gains of admittance control: `mass a_v + damping v_v + stiffness (x_v - x_0) = r - f` moves a virtual
/// body, and `u = kp (x_v - x) + kd (v_v - v) + velocity_feed_forward v_v` makes the axis follow it. `x_0` is
/// the position at which the law starts.
///
/// `velocity_feed_forward = 1` and `kd = 0` suit a velocity source.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AdmittanceGains {
    /// Virtual mass, kg; may be zero if the damping is not.
    pub mass: f64,
    /// Virtual damping, N s/m.
    pub damping: f64,
    /// Virtual stiffness, N/m.
    pub stiffness: f64,
    /// Inner loop: output per m.
    pub kp: f64,
    /// Inner loop: output per m/s.
    pub kd: f64,
    /// Output per m/s of the virtual body's velocity.
    pub velocity_feed_forward: f64,
}

/// A lead compensator `(1 + s / w_z) / (1 + s / w_p)`: gain 1 at zero frequency, `pole_hz / zero_hz` at high
/// frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeadSpec {
    pub zero_hz: f64,
    /// Frequency of the pole, Hz; below that of the zero it is a lag.
    pub pole_hz: f64,
}

/// Behaviour of an integrator at the output limit (Astrom and Hagglund, "Advanced PID Control", 2006, section
/// 3.5).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AntiWindup {
    /// Stops while the output exceeds its limit and the error would increase the excess (conditional
    /// integration).
    #[default]
    Conditional,
    /// Is reset at the rate (limited output - unlimited output) / `tracking_time_s`.
    BackCalculation { tracking_time_s: f64 },
    /// Winds up.
    Off,
}

const TIME: Unit = Unit::Of(Dimension::TIME);
const FREQUENCY: Unit = Unit::Of(Dimension::FREQUENCY);

const PER_FORCE: Unit = Unit::OutputPer(Dimension::FORCE);
const PER_FORCE_TIME: Unit = Unit::OutputPer(Dimension::new(1.0, 1.0, -1.0));
const PER_FORCE_RATE: Unit = Unit::OutputPer(Dimension::FORCE_RATE);
const PER_LENGTH: Unit = Unit::OutputPer(Dimension::LENGTH);
const PER_LENGTH_TIME: Unit = Unit::OutputPer(Dimension::new(0.0, 1.0, 1.0));
const PER_VELOCITY: Unit = Unit::OutputPer(Dimension::VELOCITY);

/// A gain whose key is its own name. Its rank is its position among the law's gains, the most important
/// first.
macro_rules! gain {
    ($law:ident.$gain:ident, $unit:expr, $rank:expr, $part:ident, $text:expr) => {
        gain!($law.$gain, $unit, $rank, $part, $text, Bound::Any)
    };
    ($law:ident.$gain:ident, $unit:expr, $rank:expr, $part:ident, $text:expr, $bound:expr) => {
        field!(Law: Law::$law(gains) => gains.$gain, number(stringify!($gain), $unit, $bound, 0.0, $text),
            KeyRole::Gain { rank: $rank, part: GainPart::$part })
    };
}

/// A parameter of an admittance's virtual body, which counts as a gain.
macro_rules! virtual_body {
    ($gain:ident, $dimension:expr, $rank:expr, $part:ident, $text:expr) => {
        gain!(Admittance.$gain, Unit::Of($dimension), $rank, $part, $text, Bound::NotNegative)
    };
}

impl Law {
    /// The mass of an admittance's virtual body.
    pub const ADMITTANCE_MASS: Field<Self> = virtual_body!(mass, Dimension::MASS, 3, Other, "virtual mass");
    /// Its damping.
    pub const ADMITTANCE_DAMPING: Field<Self> =
        virtual_body!(damping, Dimension::DAMPING, 4, Damping, "virtual damping");
}

const DERIVATIVE_FILTER: Key = number(
    "derivative_filter",
    TIME,
    Bound::NotNegative,
    0.0,
    "time constant of the first-order filter on the derivative",
);

const EXPLICIT_FORCE: &[Field<Law>] = &[
    gain!(ExplicitForce.feed_forward, PER_FORCE, 4, Other, "from the reference to the output"),
    gain!(ExplicitForce.kp, PER_FORCE, 0, Proportional, "proportional gain"),
    gain!(ExplicitForce.ki, PER_FORCE_TIME, 1, Integral, "integral gain"),
    gain!(ExplicitForce.kd, PER_FORCE_RATE, 2, Derivative, "derivative gain"),
    gain!(ExplicitForce.damping, PER_VELOCITY, 3, Damping, "joint damping, on the motion sensor's velocity"),
    field!(Law: Law::ExplicitForce(gains) => gains.derivative_filter_s, DERIVATIVE_FILTER),
    field!(Law: Law::ExplicitForce(gains) => gains.lead,
        optional("lead", KeyKind::Table(&LEAD),
            "lead compensator in series: { zero, pole }, gain 1 at zero frequency")),
    field!(Law: Law::ExplicitForce(gains) => gains.anti_windup, ANTI_WINDUP),
];

const POSITION: &[Field<Law>] = &[
    gain!(Position.kp, PER_LENGTH, 0, Proportional, "proportional gain"),
    gain!(Position.ki, PER_LENGTH_TIME, 1, Integral, "integral gain"),
    gain!(Position.kd, PER_VELOCITY, 2, Derivative, "derivative gain, on the error"),
    gain!(Position.damping, PER_VELOCITY, 3, Damping, "on the measured velocity alone"),
    field!(Law: Law::Position(gains) => gains.derivative_filter_s, DERIVATIVE_FILTER),
    field!(Law: Law::Position(gains) => gains.anti_windup, ANTI_WINDUP),
];

const IMPEDANCE: &[Field<Law>] = &[
    gain!(Impedance.stiffness, PER_LENGTH, 0, Proportional, "of the programmed spring"),
    gain!(Impedance.damping, PER_VELOCITY, 1, Damping, "of the programmed damper"),
    gain!(Impedance.force_gain, Unit::Of(Dimension::NONE), 2, Reading, "of the inner force loop"),
];

const ADMITTANCE: &[Field<Law>] = &[
    Law::ADMITTANCE_MASS,
    Law::ADMITTANCE_DAMPING,
    virtual_body!(stiffness, Dimension::STIFFNESS, 5, Other, "virtual stiffness"),
    gain!(Admittance.kp, PER_LENGTH, 0, Proportional, "inner loop, on position"),
    gain!(Admittance.kd, PER_VELOCITY, 1, Derivative, "inner loop, on velocity"),
    gain!(Admittance.velocity_feed_forward, PER_VELOCITY, 2, Other, "on the virtual body's velocity"),
];

/// The key of the sensor that a law controls. It belongs to the wiring.
pub const READS: Key = required("reads", KeyKind::Name("a force sensor"), "the sensor it controls");
const READS_POSITION: Key = Key { kind: KeyKind::Name("a position sensor"), ..READS };
const READS_INNER: Key = Key {
    absent: Absent::Nothing,
    text: "the force sensor; needed if force_gain is not zero or there is an approach",
    ..READS
};
const READS_ANSWERED: Key = Key { text: "the force sensor", ..READS };

/// The keys of each law, in addition to those of every controller.
impl Keyed for Law {
    const FIELDS: &'static [Field<Self>] = &[];
    const FORMS: &'static [Form<Self>] = &[
        form!("explicit-force", "u = feed_forward r + kp e + ki int(e) + kd de/dt - damping v, e = r - f",
            Law: Law::ExplicitForce(_), Law::ExplicitForce(ForceGains::default()), EXPLICIT_FORCE, &[READS]),
        form!("position", "u = kp e + ki int(e) + kd de/dt - damping v, e = r - x", Law: Law::Position(_),
            Law::Position(PositionGains::default()), POSITION, &[READS_POSITION]),
        form!("impedance", "f_d = stiffness (x_r - x) + damping (v_r - v), u = f_d + force_gain (f_d - f)",
            Law: Law::Impedance(_), Law::Impedance(ImpedanceGains::default()), IMPEDANCE, &[READS_INNER]),
        form!(
            "admittance",
            "mass a_v + damping v_v + stiffness (x_v - x_0) = r - f; u = kp (x_v - x) + kd (v_v - v) + \
             velocity_feed_forward v_v",
            Law: Law::Admittance(_),
            Law::Admittance(AdmittanceGains::default()),
            ADMITTANCE,
            &[READS_ANSWERED]
        ),
        form!("open-loop", "the output is the reference: an excitation of the drive", Law: Law::OpenLoop,
            Law::OpenLoop, &[] as &[Field<Law>]),
    ];
}

static LEAD: Keys = Keys { keys: keys!(LeadSpec::FIELDS), choice: None };

impl Keyed for LeadSpec {
    const FIELDS: &'static [Field<Self>] = &[
        field!(LeadSpec: zero_hz,
            required("zero", KeyKind::Quantity(FREQUENCY, Bound::Positive), "frequency of the zero")),
        field!(LeadSpec: pole_hz,
            required("pole", KeyKind::Quantity(FREQUENCY, Bound::Positive),
                "frequency of the pole; below the zero's it is a lag")),
    ];

    fn blank() -> Option<Self> {
        Some(Self { zero_hz: 1.0, pole_hz: 1.0 })
    }
}

const CONDITIONAL: &str = "conditional";
const OFF: &str = "off";
const TRACKING_TIME: &str = "tracking_time";

/// The key of [`AntiWindup`].
pub const ANTI_WINDUP: Key = Key {
    name: "anti_windup",
    kind: KeyKind::WordOrTable(ANTI_WINDUPS, &TRACKING),
    absent: Absent::Word(CONDITIONAL),
    text: "behaviour of the integrator at the output limit; { tracking_time = ... } drives it back with that \
           time constant",
};
const ANTI_WINDUPS: &[Word] =
    &[word(CONDITIONAL, "it stops while the error would drive the output further"), word(OFF, "it winds up")];
static TRACKING: Keys = Keys {
    keys: &[required(TRACKING_TIME, KeyKind::Quantity(TIME, Bound::Positive), "tracking time constant")],
    choice: None,
};

impl Slot for AntiWindup {
    fn content(&self) -> Option<Content> {
        Some(match self {
            Self::Conditional => Content::Word(CONDITIONAL),
            Self::Off => Content::Word(OFF),
            Self::BackCalculation { tracking_time_s } => {
                let mut table = Contents::new(None);
                table.insert(TRACKING_TIME, Content::Number(*tracking_time_s));
                Content::Table(table)
            }
        })
    }

    fn of(content: &Content) -> Option<Self> {
        match content {
            Content::Table(table) => {
                let tracking_time_s = f64::of(table.get(TRACKING_TIME)?)?;
                Some(Self::BackCalculation { tracking_time_s })
            }
            Content::Word(OFF) => Some(Self::Off),
            Content::Word(CONDITIONAL) => Some(Self::Conditional),
            _ => None,
        }
    }
}
