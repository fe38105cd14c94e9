//! `force-gain`: calibration error.

use super::prelude::*;

parameters! { ForceGain
    gain: linear(Dimension::NONE, Some(1.0), 0.9, (-10.0, 10.0), "reading per unit of force"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ForceGain::KIND,
    name: "force-gain",
    place: Place::ForceSensor,
    order: 360,
    hosts: &[HostKind::ForceSensor],
    site: "",
    parameters: ForceGain::PARAMETERS,
    summary: "calibration error: the force reading is scaled",
    example: "\
[sensors.force.effects.force-gain]
gain = 0.8
",
    sections: "\
## Model
The reading is `gain` times what it would be; its offset stays.

## Where it comes from
Calibration with another amplifier or cable, a mis-set range.

## How it shows
In contact every reading is off by one factor, and a force loop settles at the wrong true force. The poles of
the contact stay; those of a closed force loop move as with another loop gain. Command or position separates
it from `contact-stiffness`. In static contact `drive-gain` has the same ratio of command to reading; free
motion separates them.

## How it is recognised
Compare the reading with a known weight, or with the drive's static force. Approach that force from below and
from above, and take the mean of both commands: dry friction then cancels. Every reading in contact is off by
one factor; the frequency of the contact mode is right.

## Numerical treatment
The reading is multiplied, which is exact. Linear theory scales the loop gain.

## Source
E. O. Doebelin, Measurement Systems: Application and Design, McGraw-Hill (2004): static calibration and
sensitivity.
",
    law: LawDrawing {
        axes: ["force", "force reading"],
        start: -1.0,
        with: &[Curve::Points(&[(-0.9, -0.54), (0.9, 0.54)])],
        without: &[Curve::UNCHANGED],
        labels: &[(0.5, 0.12, "gain")],
    },
    traits: &[Trait::PlainNumber, Trait::Gain, Trait::LikeUnits],
    change: Change::plant::<ForceGain>(),
};

impl ChangesPlant for ForceGain {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { gain } = self;
        machine.sensor_mut(host, &DEFINITION)?.gain *= gain;
        Ok(())
    }
}
