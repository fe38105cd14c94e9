//! `coulomb-friction`: one level of dry friction.

use feeler_plant::effects::{CoulombFriction, Kind};

use super::start::levels;
use super::{Balance, Element, Force, Glance, Known};

impl Known for CoulombFriction {
    const BALANCE: Option<Balance<Self>> = Some(Balance::forces(
        &[Force::positive(|at| at.direction)],
        |of, _| Self { level: of[0] },
        |own| (vec![own.level], 0.0),
    ));
    const APART: &'static [(Kind, &'static str)] = &[
        (
            Kind::StribeckFriction,
            "move at several steady speeds, down to creeping: only one of them rises again towards \
             standstill",
        ),
        (
            Kind::LoadFriction,
            "repeat the strokes with another payload or clamping force: only one of them grows with it",
        ),
        (
            Kind::DriveDeadband,
            "push the axis by hand or with a spring scale: friction stays, a dead band of the drive does not",
        ),
    ];

    fn starts(_: &Element<'_>, glance: &Glance) -> Vec<Self> {
        levels(glance.command).map(|level| Self { level }).to_vec()
    }
}
