//! Step, integrator and record of a run: `[run]` of a file.

use feeler_catalogue::{
    Absent, Bound, Content, Dimension, Field, Key, KeyKind, KeyRole, Keyed, Slot, Unit, Word, field, number,
    optional, word,
};
use feeler_plant::description::SignalName;

/// Stepping of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Integrator {
    /// Matrix exponentials between located events; as precise at any step.
    #[default]
    Exact,
    /// Classical fourth-order Runge-Kutta with the fixed step; events occur at step ends.
    Rk4,
    /// Semi-implicit Euler with the fixed step; events occur at step ends.
    SemiImplicitEuler,
    /// Another engine moves the bodies (see [`crate::BodyEngine`]). Drives and filters use semi-implicit
    /// Euler at its step; events occur at step ends.
    External,
}

impl Integrator {
    /// Every integrator of this engine with its name in files.
    pub const ALL: [(Self, &'static str); 3] =
        [(Self::Exact, "exact"), (Self::Rk4, "rk4"), (Self::SemiImplicitEuler, "semi-implicit-euler")];

    /// Its name in files. Files select [`Self::External`] by the engine, so it has a word for reports.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(integrator, _)| *integrator == self).map_or("external", |(_, name)| name)
    }
}

/// Duration, step and record of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunSettings {
    pub duration_s: f64,
    /// Fixed base step. The exact integrator does not need it and uses it only as the default spacing of the
    /// record.
    pub step_s: f64,
    pub integrator: Integrator,
    /// Seed of every random stream.
    pub seed: u64,
    pub record: Vec<SignalName>,
    /// Rate of the record; the inverse of the step by default.
    pub record_rate_hz: Option<f64>,
    /// Whether to keep the energy ledger.
    pub energy: bool,
    /// Whether to find the largest force of every stretch of contact (see [`crate::Simulation::peaks`]). The
    /// exact integrator searches the motion itself. Fixed steps use their ends, if the ledger is kept.
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

const INTEGRATORS: &[Word] = &[
    word(Integrator::ALL[0].1, "matrix exponentials between located events; as precise at any step"),
    word(Integrator::ALL[1].1, "classical fourth-order Runge-Kutta at the fixed step"),
    word(Integrator::ALL[2].1, "semi-implicit Euler at the fixed step"),
];

const OWN: &str = "feeler";
const RAPIER: &str = "rapier";
const ENGINES: &[Word] = &[
    word(OWN, "Feeler's own, by the integrator named"),
    word(RAPIER, "Rapier moves the bodies, by its own integrator at the step; first order, for comparison"),
];

impl RunSettings {
    /// The table of files.
    pub const TABLE: &'static str = "run";

    /// The key of a field in a file, as `run.step`.
    pub fn key(field: &Field<Self>) -> String {
        format!("{}.{}", Self::TABLE, field.key.name)
    }
}

impl RunSettings {
    /// The engine that moves the bodies.
    pub const ENGINE: Field<Self> = Field {
        key: Key {
            name: "engine",
            kind: KeyKind::Word(ENGINES),
            absent: Absent::Word(OWN),
            text: "what moves the bodies",
        },
        role: KeyRole::Structure,
        get: |run| (run.integrator == Integrator::External).then_some(Content::Word(RAPIER)),
        set: |run, content| {
            if *content == Content::Word(RAPIER) {
                run.integrator = Integrator::External;
            }
        },
    };
    /// Whether energies are kept.
    pub const ENERGY: Field<Self> = Field {
        key: Key {
            name: "energy",
            kind: KeyKind::Flag,
            absent: Absent::Flag(false),
            text: "whether to keep the energy ledger",
        },
        role: KeyRole::Structure,
        get: |run| run.energy.then_some(Content::Flag(true)),
        set: |run, content| run.energy = bool::of(content).unwrap_or(run.energy),
    };
    /// The duration.
    pub const DURATION: Field<Self> = field!(RunSettings: duration_s,
        number("duration", Unit::Of(Dimension::TIME), Bound::Above(0.0, 1e7), 1.0, "how long"));
    /// The base step.
    pub const STEP: Field<Self> = field!(RunSettings: step_s,
        number("step", Unit::Of(Dimension::TIME), Bound::Above(1e-9, 1e3), 1e-4,
            "base step; the exact integrator needs none, and the record uses it"));
    /// Another engine has its own integrator; its key is read before this one.
    pub const INTEGRATOR: Field<Self> = Field {
        key: Key {
            name: "integrator",
            kind: KeyKind::Word(INTEGRATORS),
            absent: Absent::Word(Integrator::ALL[0].1),
            text: "how to step, unless another engine moves the bodies; if absent, rk4 steps more than 32 \
                   bodies if the step is short enough for the fastest motion",
        },
        role: KeyRole::Structure,
        get: |run| (run.integrator != Integrator::External).then(|| Content::Word(run.integrator.name())),
        set: |run, content| {
            let named = Integrator::ALL.iter().find(|(_, name)| *content == Content::Word(name));
            if let Some((integrator, _)) = named.filter(|_| run.integrator != Integrator::External) {
                run.integrator = *integrator;
            }
        },
    };
    /// The recorded signals.
    pub const RECORD: Field<Self> = Field {
        key: optional(
            "record",
            KeyKind::Signals,
            "signals to record; if absent: contact forces, motion of driven bodies, commands and readings",
        ),
        role: KeyRole::Structure,
        get: |run| Some(Content::Texts(run.record.iter().map(ToString::to_string).collect())),
        set: |run, content| {
            if let Content::Texts(signals) = content {
                run.record = signals.iter().filter_map(|signal| signal.parse().ok()).collect();
            }
        },
    };
    /// The rate of the record.
    pub const RECORD_RATE: Field<Self> = field!(RunSettings: record_rate_hz,
        optional("record_rate", KeyKind::Quantity(Unit::Of(Dimension::FREQUENCY), Bound::Positive),
            "rate of the record; if absent, one over the step"));
}

impl Keyed for RunSettings {
    const FIELDS: &'static [Field<Self>] = &[
        RunSettings::DURATION,
        RunSettings::STEP,
        RunSettings::ENGINE,
        RunSettings::INTEGRATOR,
        field!(RunSettings: seed,
            Key { name: "seed", kind: KeyKind::Count(0, u64::MAX), absent: Absent::Count(1),
                text: "seed of every random stream" }),
        RunSettings::RECORD,
        RunSettings::RECORD_RATE,
        RunSettings::ENERGY,
    ];

    fn blank() -> Option<Self> {
        Some(Self::default())
    }
}
