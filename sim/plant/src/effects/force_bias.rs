//! `force-bias`: offset.

use super::prelude::*;

parameters! { ForceBias
    bias: linear(Dimension::FORCE, Some(0.0), 2.0, (-1e6, 1e6), "reading at zero force"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ForceBias::KIND,
    name: "force-bias",
    place: Place::ForceSensor,
    order: 370,
    hosts: &[HostKind::ForceSensor],
    site: "",
    parameters: ForceBias::PARAMETERS,
    summary: "offset of the force reading",
    example: "\
[sensors.force.effects.force-bias]
bias = \"2 N\"
",
    sections: "\
## Model
The reading is `bias` more than it would be.

## Where it comes from
Drift with temperature, a sensor zeroed in another pose, the weight of the tool, a mounting that strains it.

## How it shows
The reading is off by the same amount in free motion and in contact, and a threshold that detects contact
trips early or late. In contact under force control `constant-load` shifts the command as much, but free of
contact the reading stays at zero. `surface-offset` changes the force only while there is contact.

## How it is recognised
Read the sensor in free motion: it is not zero. The offset is the same in contact.

## Numerical treatment
A constant is added to the reading. Linear theory does not depend on it.

## Source
E. O. Doebelin, Measurement Systems: Application and Design, McGraw-Hill (2004): zero drift.
",
    law: LawDrawing {
        axes: ["force", "force reading"],
        start: -1.0,
        with: &[Curve::Points(&[(-0.9, -0.6), (0.7, 1.0)])],
        without: &[Curve::UNCHANGED],
        labels: &[(-0.35, 0.3, "bias")],
    },
    traits: &[Trait::PlainNumber],
    change: Change::plant::<ForceBias>(),
};

impl ChangesPlant for ForceBias {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { bias } = self;
        machine.sensor_mut(host, &DEFINITION)?.bias += bias;
        Ok(())
    }
}
