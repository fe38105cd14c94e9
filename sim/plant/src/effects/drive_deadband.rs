//! `drive-deadband`: commands within the width have no effect; beyond it the width is subtracted.

use super::prelude::*;

parameters! { DriveDeadband
    width: log(Dimension::FORCE, Some(0.0), 5.0, (0.0, 1e6), "half-width of the dead zone"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: DriveDeadband::KIND,
    name: "drive-deadband",
    place: Place::Drive,
    order: 60,
    hosts: &[HostKind::Actuator],
    site: "",
    parameters: DriveDeadband::PARAMETERS,
    summary: "commands within the width do nothing, and beyond it the width is lost",
    example: "\
[actuators.drive.effects.drive-deadband]
width = \"4 N\"
",
    sections: "\
## Model
The drive acts on `u - width sign(u)` for `|u| > width` and on zero otherwise, before its gain. `width` has
the unit of the command: a speed on a velocity source; a voltage, a duty cycle or a current on a motor. Under
a position servo it is a deadband of the error for `kp` and `ki`, and the width a length.

## Where it comes from
Overlapped valves, a threshold in the set point. On a voltage or a duty cycle, the dead time between upper and
lower switch of a bridge. The voltage that it costs has the sign of the current, so it is this effect only
while that is the sign of the command. A current loop hides it.

## How it shows
A force of constant size is lost, and it has the sign of the command: it matters less the larger the command.
`coulomb-friction` removes a force of constant size too, but with the sign of the velocity. The two agree
while the drive pushes the way it moves. They differ while it brakes, and while something else pushes a
resting axis. In a closed loop an integral part crosses the band by itself, but each change of sign takes
`2 width / (ki e)` seconds. A limit cycle follows only if the loop is unstable at a lower gain
(`gain may fall to` in `feeler analyze`).

## How it is recognised
Plot the missing force against the command: it is minus the command up to `width`, and `-width sign(u)`
beyond. Repeat at two levels: the share that is missing falls with the level.

## Numerical treatment
It acts on held commands and is exact. Under a continuous servo it is a mode of the error, whose begin and
end are events. Linear theory takes it as crossed: the drive answers in full.

## Source
G. Tao and P. V. Kokotovic, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, Wiley
(1996): the dead-zone.
",
    law: LawDrawing {
        axes: ["command", "drive force"],
        start: -1.0,
        with: &[
            Curve::Points(&[(-0.9, -0.6), (-0.3, 0.0), (0.3, 0.0), (0.9, 0.6)]),
            Curve::Dimension([0.0, 0.3], -0.2),
        ],
        without: &[Curve::UNCHANGED],
        labels: &[(0.05, -0.45, "width")],
    },
    traits: &[Trait::DriveFlaw, Trait::OfCommand, Trait::BeforeGain],
    change: Change::plant::<DriveDeadband>(),
};

impl ChangesPlant for DriveDeadband {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { width } = self;
        machine.drive_mut(host, &DEFINITION)?.deadband += width;
        Ok(())
    }
}
