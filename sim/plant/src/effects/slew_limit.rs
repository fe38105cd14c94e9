//! `slew-limit`: a limit on the rate of the drive force.

use super::prelude::*;

parameters! { SlewLimit
    rate: log(
        Dimension::FORCE_RATE, Some(f64::INFINITY), 5e3, (ABOVE_ZERO, f64::INFINITY), "largest rate of change"
    ),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: SlewLimit::KIND,
    name: "slew-limit",
    place: Place::Drive,
    order: 90,
    hosts: &[HostKind::Actuator],
    site: "a drive that gives a force",
    parameters: SlewLimit::PARAMETERS,
    summary: "the drive force changes at a limited rate",
    example: "\
[actuators.drive.effects.slew-limit]
rate = \"1 kN/s\"
",
    sections: "\
## Model
The drive acts on a value that follows the command with `|df/dt| <= rate`, after gain and limit and before
any lag. Of several limits the smallest holds. On a velocity source the commanded speed is held back, on a
motor the voltage or duty cycle. Under a position servo it is the target. The unit is that of the command
over time.

## Where it comes from
Ramps in the set point, a supply voltage that limits how fast current rises in a winding, valves.

## How it shows
Steps become ramps. Sines are distorted once amplitude times angular frequency exceeds the rate. Above 1.86
times the rate they are triangles. The phase lag then grows with amplitude, which can start an oscillation
that small tests never show. At one amplitude `actuator-lag` looks the same; two amplitudes separate them.

## How it is recognised
Large and fast commands turn into ramps of one slope, small ones do not. Two amplitudes at the same
frequency show it.

## Numerical treatment
A limited command is a ramp, which is a mode. Its end is an event, located to machine precision. Linear theory
takes the limit as not reached.

## Source
P. Hippe, Windup in Control: Its Effects and Their Prevention, Springer (2006): rate constraints.
",
    law: LawDrawing {
        axes: ["time", "drive force"],
        start: 0.0,
        with: &[Curve::Points(&[(0.0, 0.0), (0.1, 0.0), (0.6, 0.6), (1.0, 0.6)])],
        without: &[Curve::STEP],
        labels: &[(0.42, 0.25, "rate")],
    },
    traits: &[Trait::Saturation, Trait::OfCommand],
    change: Change::plant::<SlewLimit>(),
};

impl ChangesPlant for SlewLimit {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { rate } = self;
        let drive = machine.force_drive_mut(host, &DEFINITION)?;
        drive.rate_limit = drive.rate_limit.min(rate);
        Ok(())
    }
}
