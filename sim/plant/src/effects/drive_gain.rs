//! `drive-gain`: force constant error: the command is scaled.

use super::{Change, ChangesPlant, Definition, EffectError, Host, HostKind, Parameters, Place, Trait};
use crate::assembly::Assembly;
use crate::units::Dimension;

parameters! { DriveGain
    gain: linear(
        Dimension::NONE, Some(1.0), 0.9, (-10.0, 10.0), "what the drive makes of one unit of command"
    ),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: DriveGain::KIND,
    name: "drive-gain",
    place: Place::Drive,
    hosts: &[HostKind::Actuator],
    site: "",
    parameters: DriveGain::PARAMETERS,
    summary: "force constant error: the command is scaled",
    documentation: "\
## Model
The drive acts on `gain * u`, before its limits. A negative gain is a drive that is wired the wrong way round.

## Where it comes from
A force constant from the data sheet, demagnetised or hot magnets, gear efficiency, a mis-set current scale.

## How it shows
Every response to the command changes by one factor, at all frequencies and sizes, while forces that do not come from
the command (weight, friction, contact) keep theirs. Free acceleration alone cannot tell it from `added-mass`; the
static force in contact can. In contact alone it looks like `force-gain`, which free motion does not show.

## Source
M. Gautier and S. Briot, Global identification of joint drive gains and dynamic parameters of robots, ASME Journal of
Dynamic Systems, Measurement, and Control 136 (2014).
",
    traits: &[Trait::PlainNumber],
    change: Change::plant::<DriveGain>(),
};

impl ChangesPlant for DriveGain {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { gain } = self;
        machine.drive_mut(host, &DEFINITION)?.gain *= gain;
        Ok(())
    }
}
