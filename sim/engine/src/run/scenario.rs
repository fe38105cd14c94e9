//! What is to be run: a machine, its controllers, and the run itself.

use feeler_catalogue::{Field, Kind, Record, field, optional, required};
use feeler_control::ControllerSpec;
use feeler_plant::description::{Elements, Machine, SignalName};
use feeler_plant::effects::EffectUse;

/// A machine with its controllers and how to run it.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// The plant.
    pub machine: Machine,
    /// Its controllers, in the order of the file.
    pub controllers: Elements<ControllerUse>,
    /// Duration, step, integrator and what to record.
    pub run: RunSettings,
}

/// A controller and how it is wired.
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerUse {
    /// Law, gains, timing and reference.
    pub spec: ControllerSpec,
    /// Sensor it controls; none for an open-loop excitation.
    pub reads: Option<String>,
    /// Sensor of position or velocity for joint damping, impedance and the approach; where absent, the first
    /// sensor that reads position or velocity of the driven body, if there is one.
    pub motion: Option<String>,
    /// Actuator it drives; several controllers on one actuator add.
    pub drives: String,
    /// Departures from the ideal controller.
    pub effects: Vec<EffectUse>,
}

/// How it is wired; what it reads is a key of its law.
impl Record for ControllerUse {
    const FIELDS: &'static [Field<Self>] = &[
        field!(
            ControllerUse: drives,
            required("drives", Kind::Name("an actuator"), "the actuator whose command it gives")
        ),
        field!(
            ControllerUse: motion,
            optional(
                "motion",
                Kind::Name("a sensor of position or velocity"),
                "sensor for damping, impedance and the approach; where absent, the first that reads position or velocity of the driven body",
            )
        ),
    ];

    fn blank() -> Self {
        Self {
            spec: ControllerSpec::blank(),
            reads: None,
            motion: None,
            drives: String::new(),
            effects: Vec::new(),
        }
    }
}

/// How a run steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Integrator {
    /// Matrix exponentials between located events: exact to rounding at any step.
    #[default]
    Exact,
    /// Classical fourth-order Runge-Kutta at the fixed step, events taken at step ends.
    Rk4,
    /// Semi-implicit Euler at the fixed step, events taken at step ends.
    SemiImplicitEuler,
    /// Another engine moves the bodies (see [`crate::BodyEngine`]); drives and filters go by semi-implicit
    /// Euler at its step, events are taken at step ends.
    External,
}

impl Integrator {
    /// Every integrator of this engine with its name in files.
    pub const ALL: [(Self, &'static str); 3] =
        [(Self::Exact, "exact"), (Self::Rk4, "rk4"), (Self::SemiImplicitEuler, "semi-implicit-euler")];

    /// Its name in files; of [`Self::External`], which files ask for by the engine, a word for reports.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(integrator, _)| *integrator == self).map_or("external", |(_, name)| name)
    }
}

/// Duration, step and record of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunSettings {
    /// How long.
    pub duration_s: f64,
    /// Fixed base step; the exact integrator needs none and uses it only as the default spacing of the
    /// record.
    pub step_s: f64,
    /// How to step.
    pub integrator: Integrator,
    /// Seed of every random stream.
    pub seed: u64,
    /// Signals to record.
    pub record: Vec<SignalName>,
    /// Rate of the record; one over the step where absent.
    pub record_rate_hz: Option<f64>,
    /// Whether to keep the energy ledger.
    pub energy: bool,
    /// Whether to look for the largest force of every stretch of contact (see [`crate::Simulation::peaks`]):
    /// with the exact integrator on the motion itself, with fixed steps at their ends, where the ledger is
    /// kept.
    pub peaks: bool,
}

impl Default for RunSettings {
    fn default() -> Self {
        Self {
            duration_s: 1.0,
            step_s: 1e-4,
            integrator: Integrator::Exact,
            seed: 1,
            record: Vec::new(),
            record_rate_hz: None,
            energy: false,
            peaks: false,
        }
    }
}
