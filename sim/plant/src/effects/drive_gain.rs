//! `drive-gain`: an error of the force constant scales the command.

use super::prelude::*;

parameters! { DriveGain
    gain: linear(
        Dimension::NONE, Some(1.0), 0.9, (-10.0, 10.0), "what the drive makes of one unit of command"
    ),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: DriveGain::KIND,
    name: "drive-gain",
    place: Place::Drive,
    order: 40,
    hosts: &[HostKind::Actuator],
    site: "",
    parameters: DriveGain::PARAMETERS,
    summary: "force constant error: the command is scaled",
    example: "\
[actuators.drive.effects.drive-gain]
gain = 0.8
",
    sections: "\
## Model
The drive acts on `gain * u`: after its deadband, before its limits. On a drive that is commanded by force or
current, this is also an error of the torque constant: a constant that is a tenth less than believed is
`gain = 0.9`. The limits keep their size: where an amplifier limits the current, lower the limit of force too
(`force-limit`). Under a position servo it scales the target. A negative gain is a drive that is wired the
wrong way round.

## Where it comes from
On a command of force or current, a force constant from the data sheet, demagnetised or hot magnets, a mis-set
current scale. On a duty cycle, a supply voltage that is lower than believed. Under a position servo, wrong
counts per unit of the target.

## How it shows
The force that the command makes changes by one factor, at all frequencies and, within the limits, at all
sizes. Motion does so only on a linear machine in open loop. Forces that do not come from the command (weight,
friction, contact) keep their sizes. Free acceleration alone cannot tell it from `added-mass`; the static
force in contact can. In the force reading of contact it looks like `force-gain`, which changes neither motion
nor compression for the same command.

## How it is recognised
Free acceleration and static contact force are both off by the same factor. One of them alone does not
separate the drive from mass or sensor. Approach the static force from below and from above, and take the mean
of both commands: dry friction then cancels. Under a position servo, compare with a ruler at the tip. If the
target is scaled, encoder and ruler agree; if the encoder is, target and encoder agree.

## Numerical treatment
The held command is multiplied, which is exact. Linear theory scales the loop gain.

## Source
M. Gautier and S. Briot, Global identification of joint drive gains and dynamic parameters of robots, ASME
Journal of Dynamic Systems, Measurement, and Control 136 (2014).
",
    law: LawDrawing {
        axes: ["command", "drive force"],
        start: -1.0,
        with: &[Curve::Points(&[(-0.9, -0.54), (0.9, 0.54)])],
        without: &[Curve::UNCHANGED],
        labels: &[(0.5, 0.12, "gain")],
    },
    traits: &[Trait::PlainNumber, Trait::Gain, Trait::LikeUnits],
    change: Change::plant::<DriveGain>(),
};

impl ChangesPlant for DriveGain {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { gain } = self;
        machine.drive_mut(host, &DEFINITION)?.gain *= gain;
        Ok(())
    }
}
