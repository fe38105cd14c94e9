//! The position loop of a servo, as its firmware computes it.

/// Gains, limits and clock of a loop. Units are N m and rad.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Firmware {
    /// Torque per position error, N m/rad.
    pub(super) kp: f64,
    /// Torque per speed, N m s/rad: from the firmware in an industrial drive, from back-EMF in a hobby servo.
    pub(super) kd: f64,
    /// Torque at rest at the full supply voltage, N m.
    pub(super) limit: f64,
    /// Torque at the largest current, N m.
    pub(super) current_limit: f64,
    /// Speed at which the supply leaves no torque, rad/s; `None` if the supply does not limit the speed.
    pub(super) no_load_speed: Option<f64>,
    /// Dead band of the error, rad: a larger error is reduced by it.
    pub(super) deadband: f64,
    /// Factor that the loop applies to its target.
    pub(super) target_gain: f64,
    /// Delay of a target, s.
    pub(super) delay_s: f64,
    /// Time between samples of the loop, s.
    pub(super) period_s: f64,
    /// Resolution of the position that the loop reads, rad.
    pub(super) resolution: f64,
    /// Whether the winding gives `kd` at every instant; otherwise the loop differences its readings.
    pub(super) is_back_emf: bool,
}

/// State of the loop between its samples.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Memory {
    last: Option<f64>,
    held: f64,
}

impl Firmware {
    /// A sample of the loop: reads target and position, and sets the torque that is held until the next
    /// sample.
    pub(super) fn sample(&self, memory: &mut Memory, target: f64, position: f64) {
        let read = (position / self.resolution).round() * self.resolution;
        let error = self.target_gain * target - read;
        let seen = error - error.clamp(-self.deadband, self.deadband);
        let speed = (read - memory.last.unwrap_or(read)) / self.period_s;
        memory.last = Some(read);
        memory.held = self.kp * seen - if self.is_back_emf { 0.0 } else { self.kd * speed };
    }

    /// The torque at a speed: the held one less back-EMF, within the limits of supply and current.
    pub(super) fn torque(&self, memory: &Memory, speed: f64) -> f64 {
        let asked = memory.held - if self.is_back_emf { self.kd * speed } else { 0.0 };
        let lost = self.no_load_speed.map_or(0.0, |no_load| self.limit * speed / no_load);
        asked.clamp(-self.limit - lost, self.limit - lost).clamp(-self.current_limit, self.current_limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn firmware() -> Firmware {
        Firmware {
            kp: 20.0,
            kd: 0.5,
            limit: 4.0,
            current_limit: f64::INFINITY,
            no_load_speed: None,
            deadband: 0.01,
            target_gain: 1.0,
            delay_s: 0.0,
            period_s: 1e-3,
            resolution: 1e-3,
            is_back_emf: false,
        }
    }

    #[test]
    fn truth_torque_is_gain_times_what_the_deadband_leaves_of_the_error() {
        let mut memory = Memory::default();
        let own = firmware();
        // The position is read as 0.05. The dead band leaves 0.04 of the error of 0.05.
        own.sample(&mut memory, 0.1, 0.0504);
        assert!((own.torque(&memory, 9.0) - 20.0 * 0.04).abs() < 1e-12);
        // A step of 1 mrad within 1 ms is 1 rad/s.
        own.sample(&mut memory, 0.1, 0.0512);
        assert!((own.torque(&memory, 9.0) - (20.0 * 0.039 - 0.5)).abs() < 1e-9);
    }

    #[test]
    fn truth_a_winding_brakes_at_every_instant_and_its_line_falls_with_speed() {
        let own = Firmware { is_back_emf: true, no_load_speed: Some(8.0), ..firmware() };
        let mut memory = Memory::default();
        own.sample(&mut memory, 1.0, 0.0);
        for (speed, torque) in [(0.0, 4.0), (4.0, 2.0), (8.0, 0.0), (-4.0, 6.0)] {
            assert!((own.torque(&memory, speed) - torque).abs() < 1e-12, "{speed}");
        }
    }
}
