//! `force-ripple`: cogging: a force periodic in position.

use std::f64::consts::TAU;

use super::{
    ABOVE_ZERO, Change, ChangesPlant, Definition, EffectError, Host, HostKind, Parameters, Place, Trait,
};
use crate::assembly::{Assembly, Ripple};
use crate::units::Dimension;

parameters! { ForceRipple
    amplitude: log(Dimension::FORCE, Some(0.0), 5.0, (0.0, 1e6), "largest ripple force"),
    pitch: log(Dimension::LENGTH, None, 0.03, (ABOVE_ZERO, 1e3), "distance after which the ripple repeats"),
    phase: linear(Dimension::NONE, None, 1.0, (-TAU, TAU), "phase of the ripple at position zero, rad"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ForceRipple::KIND,
    name: "force-ripple",
    place: Place::Drive,
    hosts: &[HostKind::Actuator],
    site: "",
    parameters: ForceRipple::PARAMETERS,
    summary: "cogging: a force periodic in position",
    documentation: "\
## Model
The drive adds the force `amplitude sin(2 pi x / pitch + phase)`, `x` the position of the driven body relative to the
one that carries the reaction. It acts whatever the command.

## Where it comes from
Permanent magnets that pull at teeth and at the ends of an iron core, gears, ball screws.

## How it shows
The missing force repeats with position, not with time: its frequency rises with speed. Over a stroke much shorter
than the pitch it is a constant and a slope: `constant-load` then looks the same. A slow axis rests in its valleys
much as under `coulomb-friction`, but it returns its energy.

## Source
J. F. Gieras, Z. J. Piech and B. Z. Tomczuk, Linear Synchronous Motors, CRC Press (2011): cogging and force ripple.
",
    traits: &[Trait::DriveFlaw],
    change: Change::plant::<ForceRipple>(),
};

impl ChangesPlant for ForceRipple {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { amplitude, pitch, phase } = self;
        let drive = machine.drive_mut(host, &DEFINITION)?;
        if amplitude > 0.0 {
            drive.ripples.push(Ripple { amplitude, pitch, phase });
        }
        Ok(())
    }
}
