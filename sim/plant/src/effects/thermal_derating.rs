//! `thermal-derating`: a drive that weakens as its winding warms.

use super::prelude::*;
use crate::assembly::Warming;

parameters! { ThermalDerating
    force: log(
        Dimension::FORCE, Some(f64::INFINITY), 100.0, (ABOVE_ZERO, f64::INFINITY),
        "constant cold force of which half is left once warm"
    ),
    time_constant: log(Dimension::TIME, None, 30.0, (ABOVE_ZERO, 1e6), "time to cover 63 % of a warming"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ThermalDerating::KIND,
    name: "thermal-derating",
    place: Place::Drive,
    order: 85,
    hosts: &[HostKind::Actuator],
    site: "a drive that gives a force",
    parameters: ThermalDerating::PARAMETERS,
    summary: "a drive weakens as its winding warms",
    example: "\
[actuators.drive.effects.thermal-derating]
force = \"80 N\"
time_constant = \"0.2 s\"
",
    sections: "\
## Model
The drive gives `f / (1 + h)`, with `f` the force of the cold drive after its gain, lags and limits. The heat
`h` follows the loss of the current, which is proportional to the square of `f`:
`time_constant dh/dt + h = (f / force)^2`. It begins at zero, cold. If the cold force is `force`, half of it
remains in the end. If it is half of `force`, four fifths remain. Warm, the drive holds `force / 2` at most. A
loop that needs more raises its command, the force falls, and the command ends at its limit. The current of a
motor is that of the cold drive: the torque per current falls.

## Where it comes from
Magnets weaken with temperature, by about 0.1 % per kelvin for neodymium and 0.2 % for ferrite. That is 7 to
14 % at 70 K, within 10 to 60 minutes. On a command of force or current, for magnets alone, choose `force` 2.5
to 4 times the steady cold force. They weaken in proportion to their heat, so the law holds for losses up to
about a fifth. On a voltage or a duty cycle weaker magnets do not follow it: see `loop-gain`. There the
resistance of copper rises by 0.39 % per kelvin, within seconds to a minute. For copper at 70 K choose `force`
1.9 times the steady cold force. Stall force per volt, `k / R` with the torque constant `k`, and damping by
back-EMF, `k^2 / R`, then fall alike, as in this law. So does the current: fit no measured current. Firmware
of servos reduces the torque of a hot motor.

## How it shows
The same command gives less force after minutes of work than at the start, and recovers while the drive gives
none. If the drive was warm before, records much shorter than `time_constant` show a constant `loop-gain` or
`drive-gain`. Grease that warms lowers friction: motion per command then rises, where this effect lets it
fall. `force-limit` caps large forces alone, cold and warm.

## How it is recognised
Repeat one motion for several time constants, then again after a time without force. The force per command
falls quickly at first, then ever more slowly, and recovers after that time. A diagnosis tries it on records
of at least 30 s. It takes each to begin cold, and a finding says so. The heat continues through the pieces of
one long record, and through files on one clock. In a pause between them the drive counts as giving no force,
so it cools.

## Numerical treatment
The heat is one more state, and the law is smooth: an extrapolation method integrates it to machine precision.
Its steps follow the machine's oscillations, so long runs take longer than without it. Linear theory takes the
drive cold.

## Source
J. Pyrhönen, T. Jokinen and V. Hrabovcova, Design of Rotating Electrical Machines, Wiley (2008): losses, heat
and permanent magnets.
",
    law: LawDrawing {
        axes: ["time under a constant command", "drive force"],
        start: 0.0,
        with: &[Curve::Function(|time| 0.8 / (2.0 - (-time / 0.25).exp()))],
        without: &[Curve::Points(&[(0.0, 0.8), (1.0, 0.8)])],
        labels: &[(0.3, 0.62, "time_constant")],
    },
    traits: &[Trait::DriveFlaw, Trait::Drift],
    change: Change::plant::<ThermalDerating>(),
};

impl ChangesPlant for ThermalDerating {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { force, time_constant } = self;
        let drive = machine.force_drive_mut(host, &DEFINITION)?;
        if force.is_finite() {
            drive.warming = Some(Warming { force, time_constant, heat: 0.0 });
        }
        Ok(())
    }
}
