//! `coulomb-friction`: one level of dry friction.

use feeler_plant::effects::{CoulombFriction, Kind};

use super::start::levels;
use super::{Element, Glance, Known};

impl Known for CoulombFriction {
    const APART: &'static [(Kind, &'static str)] = &[
        (
            Kind::StribeckFriction,
            "move at steady speeds from creeping up: only one of them rises again towards standstill",
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
