//! `command-delay`: a delay of the command, by any real number of seconds.

use super::prelude::*;

parameters! { CommandDelay
    delay: linear(Dimension::TIME, Some(0.0), 1e-3, (0.0, 1.0), "how late the drive acts on each command"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: CommandDelay::KIND,
    name: "command-delay",
    place: Place::Drive,
    order: 20,
    hosts: &[HostKind::Actuator],
    site: "",
    parameters: CommandDelay::PARAMETERS,
    summary: "the command arrives late, by any real number of seconds",
    example: "\
[actuators.drive.effects.command-delay]
delay = \"1.2 ms\"
",
    sections: "\
## Model
The drive receives `u(t - delay)`. Commands are held between controller samples, so the delayed command is
placed exactly in time, whatever the step.

## Where it comes from
Field buses, computation time that the controller's own `delay` does not count, buffered amplifiers.

## How it shows
The phase of every response to the command falls in proportion to frequency, at unchanged magnitude.
`actuator-lag` departs from it only at second order in frequency times delay. `force-delay` costs a force loop
the same phase, but free motion does not show it. A late encoder (the key `delay` of its sensor) shows the
same lag in free motion. An accelerometer, or the instant of an impact in the force reading, separates the
two.

## How it is recognised
The lag of the response grows in proportion to frequency while its magnitude stays. A cross-correlation of
measured and predicted acceleration shows the same shift in every experiment.

## Numerical treatment
Each held command takes effect at its own instant, to machine precision. Linear theory keeps the delay exact,
as a factor of the frequency response or as states of the sampled loop.

## Source
K. J. Åström and B. Wittenmark, Computer-Controlled Systems, Prentice Hall (1997): sampling of systems with
a time delay.
",
    law: LawDrawing {
        axes: ["time", "command at the drive"],
        start: 0.0,
        with: &[Curve::LATE_STEP],
        without: &[Curve::STEP],
        labels: &[(0.12, 0.1, "delay")],
    },
    traits: &[Trait::Delay],
    change: Change::plant::<CommandDelay>(),
};

impl ChangesPlant for CommandDelay {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { delay } = self;
        machine.drive_mut(host, &DEFINITION)?.delay += delay;
        Ok(())
    }
}
