//! `force-delay`: a delay of the force reading.

use super::prelude::*;

parameters! { ForceDelay
    delay: linear(
        Dimension::TIME, Some(0.0), 1e-3, (0.0, 1.0), "how much later the reading is than the force"
    ),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ForceDelay::KIND,
    name: "force-delay",
    place: Place::ForceSensor,
    order: 350,
    hosts: &[HostKind::ForceSensor],
    site: "",
    parameters: ForceDelay::PARAMETERS,
    summary: "the force reading is late",
    example: "\
[sensors.force.effects.force-delay]
delay = \"1.5 ms\"
",
    sections: "\
## Model
The sensor reads `F(t - delay)`.

## Where it comes from
Converters with a digital filter, field buses, a separate force-torque box that sends packets.

## How it shows
Impacts are recorded late and otherwise unchanged; a force loop loses phase in proportion to frequency.
Positions recorded beside it are on time, which separates it from `command-delay`. `force-lag` also lowers
the peaks.

## How it is recognised
Compare force reading and motion in an impact: the record is late and otherwise unchanged. Positions on the
same clock are on time.

## Numerical treatment
The sensor takes its signal at an instant of its own, so any delay is exact. Linear theory keeps the delay
exact.

## Source
K. J. Åström and B. Wittenmark, Computer-Controlled Systems, Prentice Hall (1997): sampling of systems with
a time delay.
",
    law: LawDrawing {
        axes: ["time", "force reading"],
        start: 0.0,
        with: &[Curve::LATE_STEP],
        without: &[Curve::STEP],
        labels: &[(0.12, 0.1, "delay")],
    },
    traits: &[Trait::Delay],
    change: Change::plant::<ForceDelay>(),
};

impl ChangesPlant for ForceDelay {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { delay } = self;
        machine.sensor_mut(host, &DEFINITION)?.delay += delay;
        Ok(())
    }
}
