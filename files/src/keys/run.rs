//! `[run]`.

use feeler_catalogue::{Absent, Bound, Key, Kind, Shape, Unit, Word, number, optional, word};
use feeler_plant::units::Dimension;

/// Integrators.
const INTEGRATORS: &[Word] = &[
    word("exact", "matrix exponentials between located events: exact to rounding at any step"),
    word("rk4", "classical fourth-order Runge-Kutta at the fixed step"),
    word("semi-implicit-euler", "semi-implicit Euler at the fixed step"),
];

/// Engines.
const ENGINES: &[Word] = &[
    word("feeler", "Feeler's own, by the integrator named"),
    word(RAPIER, "Rapier moves the bodies, by its own integrator at the step; first order, for comparison"),
];

/// The word for Rapier's engine.
pub(crate) const RAPIER: &str = "rapier";

/// `[run]`
pub(crate) static RUN: Shape = Shape {
    keys: &[
        number("duration", Unit::Of(Dimension::TIME), Bound::Above(0.0, 1e7), 1.0, "how long"),
        number(
            "step",
            Unit::Of(Dimension::TIME),
            Bound::Above(1e-9, 1e3),
            1e-4,
            "base step; the exact integrator needs none, and the record uses it",
        ),
        Key {
            name: "engine",
            kind: Kind::Word(ENGINES),
            absent: Absent::Word("feeler"),
            text: "what moves the bodies",
        },
        Key {
            name: "integrator",
            kind: Kind::Word(INTEGRATORS),
            absent: Absent::Word("exact"),
            text: "how to step; of no account where another engine moves the bodies; where absent, more than 32 bodies are stepped by rk4 if the step is short \
                   enough for the fastest motion",
        },
        Key {
            name: "seed",
            kind: Kind::Count(0, u64::MAX),
            absent: Absent::Count(1),
            text: "seed of every random stream",
        },
        optional(
            "record",
            Kind::Signals,
            "signals to record; where absent, contact forces, positions and velocities of driven bodies, commands and readings",
        ),
        optional(
            "record_rate",
            Kind::Quantity(Unit::Of(Dimension::FREQUENCY), Bound::Positive),
            "rate of the record; one over the step where absent",
        ),
        Key {
            name: "energy",
            kind: Kind::Flag,
            absent: Absent::Flag(false),
            text: "whether to keep the energy ledger",
        },
    ],
    choice: None,
};
