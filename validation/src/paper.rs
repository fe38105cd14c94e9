//! The paper's machines with the numbers of the reference axis (Figs. 1, 3, 6, 9, 12 and 18), built from
//! their parts.

use std::f64::consts::TAU;

use feeler_analysis::{AnalysisError, ControlLoop, View, leading_gain};
use feeler_control::{ControllerSpec, ForceGains, Law};
use feeler_engine::{ControllerUse, Scenario};
use feeler_plant::description::{
    Actuator, ActuatorKind, Body, Contact, Engagement, GROUND, Machine, Quantity, Sensor, SignalName, Spring,
};

/// The gain under study: the leading gain of the first controller. Without one the name is empty, which every
/// analysis refuses.
pub(crate) fn gain_of(whole: &ControlLoop) -> &'static str {
    whole.controllers().first().and_then(|controller| leading_gain(&controller.spec)).unwrap_or_default()
}

/// Numbers of an axis in SI units; an absent part is rigid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperAxis {
    /// Masses of motor and tip, which move as one without a transmission.
    pub masses_kg: (f64, f64),
    /// Damping of the guide under the motor.
    pub guide_n_s_per_m: f64,
    /// Stiffness and damping of the force sensor.
    pub contact: (f64, f64),
    /// Stiffness and damping between motor and tip.
    pub transmission: Option<(f64, f64)>,
    /// Mass, stiffness and damping of the base, on which guide, workpiece and the drive's reaction sit.
    pub base: Option<(f64, f64, f64)>,
    /// Mass, stiffness and damping of the workpiece.
    pub workpiece: Option<(f64, f64, f64)>,
    /// The drive of the motor.
    pub drive: ActuatorKind,
    /// Whether the controller reads the total contact force, or its elastic part.
    pub total_force: bool,
}

/// The model of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PaperModel {
    /// Fig. 1.
    Rigid,
    /// Fig. 6: a flexible transmission.
    Flexible,
    /// Fig. 9: a flexible base.
    Base,
    /// Fig. 12: a flexible workpiece.
    Workpiece,
    /// Fig. 18: all three.
    AllThree,
}

impl PaperModel {
    /// All models.
    pub const ALL: [Self; 5] = [Self::Rigid, Self::Flexible, Self::Base, Self::Workpiece, Self::AllThree];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rigid => "rigid",
            Self::Flexible => "flexible",
            Self::Base => "base",
            Self::Workpiece => "workpiece",
            Self::AllThree => "all three",
        }
    }
}

/// The velocity source of the reference axis: 600 N s/m, 2 ms.
pub const SOURCE: ActuatorKind =
    ActuatorKind::VelocitySource { damping_n_s_per_m: 600.0, time_constant_s: 2e-3 };
/// A drive whose command is the force.
pub const IDEAL: ActuatorKind = ActuatorKind::Force { bandwidth_hz: None };

impl PaperAxis {
    /// A model of the paper with the reference axis' numbers.
    pub fn reference(model: PaperModel, drive: ActuatorKind) -> Self {
        let wb = TAU * 12.0;
        let has = |one: PaperModel| model == one || model == PaperModel::AllThree;
        Self {
            masses_kg: (7.0, 5.0),
            guide_n_s_per_m: 60.0,
            contact: (2e5, 120.0),
            transmission: has(PaperModel::Flexible).then_some((1.2e6, 120.0)),
            base: has(PaperModel::Base).then_some((180.0, 180.0 * wb * wb, 2.0 * 0.03 * 180.0 * wb)),
            workpiece: has(PaperModel::Workpiece).then_some((3.0, 1.5e6, 150.0)),
            drive,
            total_force: false,
        }
    }

    /// The machine. Bodies `motor`, `tip` and, if present, `base` and `workpiece`; contact `tool` (clamped),
    /// actuator `drive`, sensors `force` and `encoder` (of the motor against its guide's body).
    pub fn machine(&self, name: &str) -> Machine {
        let mut machine = Machine::new(name);
        machine.bodies.insert("motor".into(), Body::new(self.masses_kg.0));
        machine.bodies.insert("tip".into(), Body::new(self.masses_kg.1));
        let (mut floor, mut work) = (GROUND, GROUND);
        if let Some((mass_kg, k, c)) = self.base {
            machine.bodies.insert("base".into(), Body::new(mass_kg));
            machine.springs.insert("mount".into(), Spring::new(GROUND, "base", k, c));
            (floor, work) = ("base", "base");
        }
        if let Some((mass_kg, k, c)) = self.workpiece {
            machine.bodies.insert("workpiece".into(), Body::new(mass_kg));
            machine.springs.insert("fixture".into(), Spring::new(floor, "workpiece", k, c));
            work = "workpiece";
        }
        machine.springs.insert("guide".into(), Spring::new(floor, "motor", 0.0, self.guide_n_s_per_m));
        let (k, c) = self.transmission.unwrap_or_default();
        let rigid = self.transmission.is_none();
        machine.springs.insert("transmission".into(), Spring { rigid, ..Spring::new("motor", "tip", k, c) });
        let contact = Contact {
            engagement: Engagement::Clamped,
            ..Contact::kelvin_voigt("tip", work, self.contact.0, self.contact.1)
        };
        machine.contacts.insert("tool".into(), contact);
        let drive = Actuator { kind: self.drive, ..Actuator::ideal("motor", floor) };
        machine.actuators.insert("drive".into(), drive);
        let force = if self.total_force { Quantity::Force } else { Quantity::SpringForce };
        machine.sensors.insert("force".into(), Sensor::ideal(SignalName::new("tool", force)));
        let relative_to = (floor != GROUND).then(|| floor.to_string());
        let encoder = Sensor { relative_to, ..Sensor::ideal(SignalName::new("motor", Quantity::Position)) };
        machine.sensors.insert("encoder".into(), encoder);
        machine
    }

    /// The loop of proportional force control every `period_s`, `delay_s` late, clamped to the workpiece.
    pub(crate) fn kp_loop(&self, period_s: f64, delay_s: f64) -> Result<ControlLoop, AnalysisError> {
        let gains = ForceGains { kp: 0.1, ..ForceGains::default() };
        ControlLoop::new(&self.force_loop(gains, period_s, delay_s), &View::CLAMPED)
    }

    /// The machine under explicit force control every `period_s`, `delay_s` late.
    pub fn force_loop(&self, gains: ForceGains, period_s: f64, delay_s: f64) -> Scenario {
        let mut spec = ControllerSpec::new(Law::ExplicitForce(gains), period_s);
        spec.delay_s = delay_s;
        let control = ControllerUse::new(spec, "drive").reading("force");
        Scenario::new(self.machine("axis")).with_controller("force", control)
    }
}

/// A row of the table of models, computed independently of this project with `SciPy`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelRow {
    pub model: PaperModel,
    /// Whether a velocity source drives it.
    pub source: bool,
    /// Numbers of poles and zeros.
    pub order: (usize, usize),
    /// |s| / 2 pi of the poles, Hz, three decimals.
    pub poles_hz: &'static [f64],
    /// |s| / 2 pi of the zeros, Hz, three decimals.
    pub zeros_hz: &'static [f64],
    /// Largest gain up to which the continuous loop is stable, and its printed decimals; `None` if the last
    /// interval of stable gains has no end.
    pub continuous: Option<(f64, i32)>,
    /// Largest gain with a hold at 1 kHz and 0, 1, 2 samples of delay, four decimals.
    pub sampled: Option<[f64; 3]>,
}

impl ModelRow {
    /// Name of the row.
    pub fn name(&self) -> String {
        format!("{}, {}", self.model.name(), if self.source { "source" } else { "ideal" })
    }

    /// Its axis.
    pub fn axis(&self) -> PaperAxis {
        PaperAxis::reference(self.model, if self.source { SOURCE } else { IDEAL })
    }
}

const RIGID: ModelRow = ModelRow {
    model: PaperModel::Rigid,
    source: false,
    order: (2, 0),
    poles_hz: &[20.547],
    zeros_hz: &[],
    continuous: None,
    sampled: Some([1.8070, 0.6067, 0.3689]),
};

/// The table of models.
pub const MODEL_TABLE: [ModelRow; 6] = [
    RIGID,
    ModelRow {
        source: true,
        order: (3, 0),
        poles_hz: &[21.738, 71.094],
        continuous: Some((0.0034, 4)),
        sampled: None,
        ..RIGID
    },
    ModelRow {
        model: PaperModel::Flexible,
        order: (4, 1),
        poles_hz: &[19.967, 105.049],
        zeros_hz: &[1591.549],
        continuous: Some((5.6083, 4)),
        sampled: Some([1.5068, 0.5641, 0.3502]),
        ..RIGID
    },
    ModelRow {
        model: PaperModel::Base,
        order: (4, 2),
        poles_hz: &[11.458, 21.518],
        zeros_hz: &[11.619],
        sampled: Some([1.8475, 0.6234, 0.3804]),
        ..RIGID
    },
    ModelRow {
        model: PaperModel::Workpiece,
        order: (4, 2),
        poles_hz: &[19.270, 119.995],
        zeros_hz: &[112.540],
        sampled: Some([1.5741, 0.5705, 0.3519]),
        ..RIGID
    },
    ModelRow {
        model: PaperModel::AllThree,
        order: (8, 5),
        poles_hz: &[11.322, 19.788, 103.789, 121.826],
        zeros_hz: &[11.529, 112.661, 1591.549],
        continuous: Some((4.968, 3)),
        sampled: Some([1.4167, 0.5607, 0.3534]),
        ..RIGID
    },
];
