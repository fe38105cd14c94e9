//! `force-lag`: first-order low-pass in the force channel.

use std::f64::consts::TAU;

use super::prelude::*;
use crate::description::LowPass;

parameters! { ForceLag
    time_constant: log(Dimension::TIME, Some(0.0), 1e-3, (0.0, 10.0), "time to cover 63 % of a step"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: ForceLag::KIND,
    name: "force-lag",
    place: Place::ForceSensor,
    order: 340,
    hosts: &[HostKind::ForceSensor],
    site: "",
    parameters: ForceLag::PARAMETERS,
    summary: "first-order low-pass in the force channel",
    example: "\
[sensors.force.effects.force-lag]
time_constant = \"2 ms\"
",
    sections: "\
## Model
The reading `y` follows the force `F` by `time_constant dy/dt + y = F`, in series with the filters the sensor
has: a corner at `1 / (2 pi time_constant)` Hz.

## Where it comes from
Anti-aliasing filters, strain-gauge amplifiers, averaging in the sensor.

## How it shows
Recorded impacts are lower, later and have a tail; a force loop loses phase and then gain. The motion itself
shows nothing while the loop is open. Well below the corner `force-delay` of the same time looks the same.
In a closed loop `actuator-lag` costs as much phase, but it shows in free motion.

## How it is recognised
Compare force reading and motion in an impact: the recorded peak is lower and later, with a tail. Free
motion shows nothing.

## Numerical treatment
The filter is one more state and exact. Linear theory has it as a pole in the loop.

## Source
G. F. Franklin, J. D. Powell and M. L. Workman, Digital Control of Dynamic Systems, Addison-Wesley (1998):
antialiasing prefilters.
",
    law: LawDrawing {
        axes: ["time", "force reading"],
        start: 0.0,
        with: &[Curve::LAGGED_STEP],
        without: &[Curve::STEP],
        labels: &[(0.34, 0.3, "time_constant")],
    },
    traits: &[Trait::Delay],
    change: Change::plant::<ForceLag>(),
};

impl ChangesPlant for ForceLag {
    fn apply(self, machine: &mut Assembly, host: Host) -> Result<(), EffectError> {
        let Self { time_constant } = self;
        let sensor = machine.sensor_mut(host, &DEFINITION)?;
        if time_constant > 0.0 {
            sensor.filters.push(LowPass::FirstOrder { corner_hz: 1.0 / (TAU * time_constant) });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::fixture::{self, FORCE};

    #[test]
    fn truth_a_time_constant_of_one_over_two_pi_is_one_hertz() {
        let mut machine = fixture::flexible();
        DEFINITION.apply(&mut machine, FORCE, &[1.0 / TAU]).unwrap();
        assert_eq!(machine.sensors[0].filters, [LowPass::FirstOrder { corner_hz: 1.0 }]);
    }
}
