//! `force-limit`: the drive force is clipped.

use super::prelude::*;

parameters! { ForceLimit
    limit: log(Dimension::FORCE, Some(f64::INFINITY), 50.0, (ABOVE_ZERO, f64::INFINITY), "largest force"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ForceLimit::KIND,
    name: "force-limit",
    place: Place::Drive,
    order: 70,
    hosts: &[HostKind::Actuator],
    site: "a drive that gives a force",
    parameters: ForceLimit::PARAMETERS,
    summary: "the drive force is clipped",
    example: "\
[actuators.drive.effects.force-limit]
limit = \"25 N\"
",
    sections: "\
## Model
The drive acts on the command clipped to `[-limit, limit]`, after its gain and before any lag. On a velocity
source, a position servo or a motor the force itself is clipped. Of several limits the smallest holds.

## Where it comes from
Amplifier current, motor temperature, a slipping clutch, a parameter in the drive that nobody remembers.

## How it shows
Nothing below the limit. Above it the drive force is flat, large steps fall short, and an integrating
controller winds up and overshoots. An impact may still exceed the limit, because the mass that is stopped
makes its force, not the drive. `slew-limit` also shows in large and fast commands only, but it skews them
and does not cap slow ones.

## How it is recognised
Plot the missing force against the command: it is zero up to the limit and `limit sign(u) - u` beyond, with
`u` the command after its gain. Large steps and errors that last show it, small signals do not.

## Numerical treatment
The held command is clipped, which is exact. For a velocity source or a continuous servo the limit is a
mode of the force, whose begin and end are events. Linear theory takes the limit as not reached; describing
functions predict limit cycles at it.

## Source
K. J. Åström and T. Hägglund, Advanced PID Control, ISA (2006): actuator limits and windup.
",
    law: LawDrawing {
        axes: ["command", "drive force"],
        start: -1.0,
        with: &[Curve::Points(&[(-0.9, -0.5), (-0.5, -0.5), (0.5, 0.5), (0.9, 0.5)])],
        without: &[Curve::UNCHANGED],
        labels: &[(0.55, 0.3, "limit")],
    },
    traits: &[Trait::Saturation],
    change: Change::plant::<ForceLimit>(),
};

impl ChangesPlant for ForceLimit {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { limit } = self;
        let drive = machine.force_drive_mut(host, &DEFINITION)?;
        drive.limit = drive.limit.min(limit);
        Ok(())
    }
}
