//! `force-ripple`: cogging, a force that is periodic in position.

use std::f64::consts::TAU;

use super::prelude::*;
use crate::assembly::Ripple;

parameters! { ForceRipple
    amplitude: log(Dimension::FORCE, Some(0.0), 5.0, (0.0, 1e6), "largest ripple force"),
    pitch: log(Dimension::LENGTH, None, 0.03, (ABOVE_ZERO, 1e3), "distance after which the ripple repeats"),
    phase: linear(Dimension::NONE, None, 1.0, (-TAU, TAU), "phase of the ripple at position zero, in rad"),
    harmonic: linear(
        Dimension::NONE, None, 1.0, (ABOVE_ZERO, 1e4), "times that the ripple repeats over the pitch"
    ) or 1.0,
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ForceRipple::KIND,
    name: "force-ripple",
    place: Place::Drive,
    order: 100,
    hosts: &[HostKind::Actuator],
    site: "a drive that gives a force",
    parameters: ForceRipple::PARAMETERS,
    summary: "cogging: a force periodic in position",
    example: "\
[actuators.drive.effects.force-ripple]
amplitude = \"6 N\"
pitch = \"2 mm\"
phase = 1.0
",
    sections: "\
## Model
The drive adds the force `amplitude sin(2 pi harmonic x / pitch + phase)`. `x` is the position of the driven
body relative to the one that carries the reaction. It acts whatever the command, and no limit of the drive
clips it: it is the detent force. Ripple that grows with the current is not described. Ripple of a geared
motor is tied to the motor's angle. Give as `pitch` the travel of the axis per motor turn (a turn over the
gear ratio). Give as `harmonic` how often it repeats per motor turn. For cogging that is the least common
multiple of the numbers of slots and poles. Tolerances of manufacture add ripple as often as the motor has
slots, or poles. On a linear motor, `pitch` is the period of the magnets, north to north. The ends of its iron
core then have `harmonic` 2. Its slots have the least common multiple of slots and poles, over the pairs of
poles. On a screw, `pitch` is the lead.

## Where it comes from
Permanent magnets that pull at teeth and at the ends of an iron core, gears, ball screws.

## How it shows
The missing force repeats with position, not with time: its frequency rises with speed. Over a stroke much
shorter than `pitch / harmonic` it is a constant and a slope, like a `constant-load` and a spring. A slow axis
rests in its valleys much as under `coulomb-friction`, but ripple returns its energy.

## How it is recognised
Plot the missing force against position: it is a wave. Slow strokes over several pitches show it best. The
wave has the same pitch at every speed. With the drive off, the axis still falls into the same places: no
other effect of a drive does that.

## Numerical treatment
The force is a sine of the position, so an extrapolation method integrates the mode to machine precision.
Linear theory takes its slope where the machine rests: a stiffness.

## Source
J. F. Gieras, Z. J. Piech and B. Z. Tomczuk, Linear Synchronous Motors, CRC Press (2011): cogging and force
ripple.
",
    law: LawDrawing {
        axes: ["position", "added force"],
        start: -1.0,
        with: &[Curve::Function(|x| 0.7 * (2.0 * TAU * x + 1.0).sin())],
        without: &[],
        labels: &[(0.5, 0.85, "amplitude"), (-0.75, -0.9, "pitch / harmonic")],
    },
    traits: &[Trait::DriveFlaw],
    change: Change::plant::<ForceRipple>(),
};

impl ChangesPlant for ForceRipple {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { amplitude, pitch, phase, harmonic } = self;
        let drive = machine.force_drive_mut(host, &DEFINITION)?;
        if amplitude > 0.0 {
            drive.ripples.push(Ripple { amplitude, pitch: pitch / harmonic, phase });
        }
        Ok(())
    }
}
