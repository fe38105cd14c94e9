//! `encoder-resolution`: quantisation.

use super::prelude::*;

parameters! { EncoderResolution
    resolution: log(Dimension::LENGTH, Some(0.0), 5e-6, (0.0, 1.0), "step between neighbouring readings"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: EncoderResolution::KIND,
    name: "encoder-resolution",
    place: Place::Encoder,
    order: 400,
    hosts: &[HostKind::MotionSensor],
    site: "",
    parameters: EncoderResolution::PARAMETERS,
    summary: "quantisation of a motion reading",
    example: "\
[sensors.encoder.effects.encoder-resolution]
resolution = \"50 um\"
",
    sections: "\
## Model
The reading is rounded to the nearest multiple of `resolution`, after gain, offset and noise. If the sensor
has a `resolution` of its own, that rounding comes first. The reading of a velocity or an acceleration is
rounded in its own unit: write `resolution` as a plain SI number.

## Where it comes from
Encoder lines and their interpolation, integers in a counter, a coarse encoder before the gear.

## How it shows
Positions take few values. Velocities from their differences are multiples of `resolution` over the sample
time: in slow motion they are spikes, and joint damping passes these to the drive. Where the position crosses
many steps in each sample, rounding is white noise of `resolution / sqrt(12)` rms.

A virtual wall of stiffness `K` and damping `B` needs dry friction above `K resolution / 2` and viscous
friction above `K period / 2 + B`. With less it may sustain a limit cycle. `force-resolution` does the same in
the force channel. `timing-jitter` also scatters differences, but in proportion to speed.

## How it is recognised
List the values of the reading: they are multiples of one step. Slow motion shows the stairs.

## Numerical treatment
Each reading is rounded at its instant. Linear theory leaves rounding out: a limit cycle of about one step is
seen only in simulation.

## Source
J. J. Abbott and A. M. Okamura, Effects of position quantization and sampling rate on virtual-wall passivity,
IEEE Transactions on Robotics 21 (2005): limits of `K` by viscous and by dry friction.
",
    law: LawDrawing {
        axes: ["position", "encoder reading"],
        start: -1.0,
        with: &[Curve::ROUNDED],
        without: &[Curve::UNCHANGED],
        labels: &[(0.3, -0.2, "resolution")],
    },
    traits: &[Trait::Quantisation],
    change: Change::plant::<EncoderResolution>(),
};

impl ChangesPlant for EncoderResolution {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        machine.sensor_mut(host, &DEFINITION)?.round_to(self.resolution);
        Ok(())
    }
}
