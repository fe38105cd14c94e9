//! `command-interpolation`: a drive moves evenly from one command to the next.

use super::prelude::*;

parameters! { CommandInterpolation
    interval: linear(Dimension::TIME, Some(0.0), 3e-3, (0.0, 10.0), "time from one command to the next"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: CommandInterpolation::KIND,
    name: "command-interpolation",
    place: Place::Drive,
    order: 30,
    hosts: &[HostKind::Actuator],
    site: "a drive that gives a force",
    parameters: CommandInterpolation::PARAMETERS,
    summary: "the drive moves evenly from one command to the next instead of jumping",
    example: "\
[actuators.drive.effects.command-interpolation]
interval = \"3 ms\"
",
    sections: "\
## Model
A command that differs from the last one is reached after `interval`, at a constant rate from where the
drive stands. A command that arrives sooner starts a new ramp from where the drive then stands. Under a
position servo the target follows this ramp, and a sampled servo reads it at each of its samples. A rate
limit applies too.

## Where it comes from
Firmware that smooths targets between two messages: interpolation of drives on a field bus, the profile time
of hobby servos.

## How it shows
The motion is smoother than the commands. If at least `interval` passes between commands, it is late by half
of `interval`. `command-delay` of that length gives nearly the same motion, but starts later and jumps.
Commands that follow each other faster are smoothed as by a lag of first order, `actuator-lag`. `slew-limit`
has one rate for small and large steps, and `actuator-lag` approaches each command ever more slowly.

## How it is recognised
Step the target once and read the position at the rate of the servo: it sets out at once and arrives after the
same time, however large the step is. Records of a motion show its delay or its lag only. So a diagnosis does
not try it: it finds `command-delay` or `actuator-lag`.

## Numerical treatment
The way to a command is a ramp with a rate of its own, which is a mode. Its end is an event, located to
machine precision. Linear theory takes it as a delay of `I / 2`, with `I` the interval. If commands come every
`T`, with `T` below `I`, it takes a lag of time constant `I - T / 2` instead. For the target of a sampled
servo it takes a delay of that length.

## Source
L. Biagiotti and C. Melchiorri, Trajectory Planning for Automatic Machines and Robots, Springer (2008): linear
interpolation between points.
",
    law: LawDrawing {
        axes: ["time", "command at the drive"],
        start: 0.0,
        with: &[Curve::Points(&[(0.0, 0.0), (0.1, 0.0), (0.7, 0.6), (1.0, 0.6)])],
        without: &[Curve::STEP],
        labels: &[(0.48, 0.2, "interval")],
    },
    traits: &[Trait::Delay],
    change: Change::plant::<CommandInterpolation>(),
};

impl ChangesPlant for CommandInterpolation {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { interval } = self;
        machine.force_drive_mut(host, &DEFINITION)?.interval += interval;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::fixture;

    #[test]
    fn truth_the_rate_is_that_of_the_way_within_the_limit() {
        let mut machine = fixture::rigid();
        DEFINITION.apply(&mut machine, Host::Actuator(0), &[0.02]).unwrap();
        let drive = &mut machine.drives[0];
        drive.rate_limit = 80.0;
        let paces: Vec<f64> = [1.0, -1.0, 3.0].iter().map(|way| drive.pace(*way)).collect();
        assert_eq!(paces, [50.0, 50.0, 80.0]);
    }

    /// Each command moves the drive by `a = T / I` of what is left, evenly until the next one. Over a held
    /// command that is `a sinc(w T / 2) exp(i w T / 2) / (z - 1 + a)`, here at 20 Hz.
    #[test]
    fn truth_faster_commands_meet_a_lag() {
        for [interval, period, allowed] in [[8e-3, 1e-3, 1e-3], [3e-3, 1e-3, 2e-3], [8e-3, 4e-3, 0.03]] {
            let mut machine = fixture::rigid();
            DEFINITION.apply(&mut machine, Host::Actuator(0), &[interval]).unwrap();
            let drive = &mut machine.drives[0];
            drive.linearise_interpolation(Some(period));
            let w = std::f64::consts::TAU * 20.0;
            let [half, a] = [0.5 * w * period, period / interval];
            let [re, im] = [(2.0 * half).cos() - 1.0 + a, (2.0 * half).sin()];
            let modulus = a * half.sin() / half / re.hypot(im);
            let angle = half - im.atan2(re);
            let tau = drive.lags[0];
            assert!((modulus * (w * tau).hypot(1.0) - 1.0).abs() < allowed, "{interval} {period}");
            assert!((angle + (w * tau).atan()).abs() < allowed, "{interval} {period}");
            assert!(drive.delay == 0.0);
        }
    }
}
