//! `force-resolution`: quantisation.

use super::prelude::*;

parameters! { ForceResolution
    resolution: log(Dimension::FORCE, Some(0.0), 0.5, (0.0, 1e6), "step between neighbouring readings"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ForceResolution::KIND,
    name: "force-resolution",
    place: Place::ForceSensor,
    order: 380,
    hosts: &[HostKind::ForceSensor],
    site: "",
    parameters: ForceResolution::PARAMETERS,
    summary: "quantisation of the force reading",
    example: "\
[sensors.force.effects.force-resolution]
resolution = \"1 N\"
",
    sections: "\
## Model
The reading is rounded to the nearest multiple of `resolution`, after whatever rounding the sensor has.

## Where it comes from
Converters with few bits over a wide range, integers on a field bus.

## How it shows
Readings take few values. Where the force crosses many steps per sample it is white noise of `resolution /
sqrt(12)` rms. Where it crosses few, and the reference lies between two values, an integrating loop hunts
between them, much as it does with `stribeck-friction`. `encoder-resolution` does the same to positions.

## How it is recognised
List the values of the reading: they are multiples of one step. A slow change of force shows the stairs.

## Numerical treatment
Each reading is rounded at its instant. Linear theory leaves rounding out; a limit cycle within one step is
seen only in simulation.

## Source
B. Widrow and I. Kollár, Quantization Noise, Cambridge University Press (2008).
",
    law: LawDrawing {
        axes: ["force", "force reading"],
        start: -1.0,
        with: &[Curve::ROUNDED],
        without: &[Curve::UNCHANGED],
        labels: &[(0.3, -0.2, "resolution")],
    },
    traits: &[Trait::Quantisation],
    change: Change::plant::<ForceResolution>(),
};

impl ChangesPlant for ForceResolution {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        machine.sensor_mut(host, &DEFINITION)?.round_to(self.resolution);
        Ok(())
    }
}
