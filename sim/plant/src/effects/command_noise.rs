//! `command-noise`: noise on the commands of a drive.

use std::f64::consts::TAU;

use super::prelude::*;

parameters! { CommandNoise
    sigma: log(Dimension::FORCE, Some(0.0), 1.0, (0.0, 1e6), "one sigma of what is added to each command"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: CommandNoise::KIND,
    name: "command-noise",
    place: Place::Drive,
    order: 110,
    hosts: &[HostKind::Actuator],
    site: "a drive that gives a force, not a velocity source",
    parameters: CommandNoise::PARAMETERS,
    summary: "noise on the commands of a drive",
    example: "\
[actuators.drive.effects.command-noise]
sigma = \"2 N\"
",
    sections: "\
## Model
Every command that is issued gets a normally distributed error of standard deviation `sigma`, before delay,
deadband, gain and limit. The drive holds it until the next command. The record holds the command without this
error. With `period` the time between commands, the one-sided density of the noise at low frequency is
`2 sigma^2 period`. A data sheet's density `n` in N/sqrt(Hz) gives `sigma = n / sqrt(2 period)`. `sigma` has
the unit of the command: a length under a position servo, a current on a motor that a current commands.

## Where it comes from
An analogue command line, the ripple of a current loop, an amplifier's noise. Also a record that holds a
measured current, with its noise, in place of the command.

## How it shows
The motion shakes without cause in the record. The same command gives another motion each time. While the
command changes, `timing-jitter` scatters it too; under a constant command only noise remains. Averaging many
repetitions removes it. No fit finds it, because the numbers are not in the record: a diagnosis counts it as
noise of the command.

## How it is recognised
Repeat one experiment several times and average: what differs from run to run is noise. No record of the
command explains it.

## Numerical treatment
Each command gets its noise at its own instant, from a stream of the drive that depends on the run's seed.
Linear theory leaves noise out.

## Source
H. W. Ott, Electromagnetic Compatibility Engineering, Wiley (2009): noise on analogue lines.
",
    law: LawDrawing {
        axes: ["time", "command at the drive"],
        start: 0.0,
        with: &[Curve::Function(|t| {
            0.6 * (TAU * t).sin() + 0.1 * ((211.0 * t).sin() + (137.0 * t).sin() + (89.0 * t).sin())
        })],
        without: &[Curve::Function(|t| 0.6 * (TAU * t).sin())],
        labels: &[(0.35, 0.75, "sigma")],
    },
    traits: &[Trait::OfCommand, Trait::Noise],
    change: Change::plant::<CommandNoise>(),
};

impl ChangesPlant for CommandNoise {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let drive = machine.force_drive_mut(host, &DEFINITION)?;
        if drive.velocity_source.is_some() {
            return Err(EffectError::WrongSite { kind: Self::KIND, needs: DEFINITION.site });
        }
        drive.noise = drive.noise.hypot(self.sigma);
        Ok(())
    }
}
