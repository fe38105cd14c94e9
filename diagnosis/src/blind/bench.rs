//! Hand-written equations of a bench: base, motor, tip and workpiece in a row, a drive and sensors,
//! integrated in small semi-implicit steps.

pub(super) const STEP_S: f64 = 4e-6;
/// Deflection at which a bristle slides, m.
const BRISTLE_M: f64 = 3e-6;
/// Damping ratio of the bristle with the moving mass.
const BRISTLE_DAMPING: f64 = 0.6;
/// Stiffness of a transmission with play, N/m.
const PLAY_STIFFNESS: f64 = 2e7;
/// Damping of a transmission with play, N s/m.
const PLAY_DAMPING: f64 = 900.0;

/// How the end of the axis is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Hold {
    /// The end is free.
    Free,
    /// The tool is attached to the workpiece.
    Clamped,
    /// The workpiece is a wall that the tool can leave.
    Wall,
}

/// An elastic joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Compliance {
    pub(super) stiffness: f64,
    pub(super) damping: f64,
    /// Free play, m.
    pub(super) play: f64,
}

impl Compliance {
    /// A spring and a damper side by side.
    pub(super) fn elastic(stiffness: f64, damping: f64) -> Self {
        Self { stiffness, damping, play: 0.0 }
    }

    /// A stiff link with free play.
    pub(super) fn with_play(width_m: f64) -> Self {
        Self { stiffness: PLAY_STIFFNESS, damping: PLAY_DAMPING, play: width_m }
    }
}

/// Parameters of the real bench; every effect changes some of these.
#[derive(Clone, Debug)]
pub(super) struct Bench {
    pub(super) base_kg: f64,
    pub(super) motor_kg: f64,
    pub(super) tip_kg: f64,
    pub(super) workpiece_kg: f64,
    pub(super) guide_damping: f64,
    pub(super) wall_stiffness: f64,
    pub(super) wall_damping: f64,
    pub(super) wall_exponent: f64,
    pub(super) wall_cubic: f64,
    pub(super) hunt_crossley: f64,
    pub(super) gap_m: f64,
    pub(super) limit_n: f64,
    pub(super) mount: Option<Compliance>,
    pub(super) transmission: Option<Compliance>,
    pub(super) fixture: Option<Compliance>,
    pub(super) coulomb: f64,
    pub(super) asymmetry: f64,
    /// Addition to the friction level at rest (N) and velocity of Stribeck's curve (m/s).
    pub(super) stribeck: Option<[f64; 2]>,
    pub(super) load_ratio: f64,
    pub(super) constant_load: f64,
    pub(super) drive_gain: f64,
    pub(super) drive_lag_s: f64,
    pub(super) drive_delay_s: f64,
    pub(super) deadband: f64,
    pub(super) slew: f64,
    /// Amplitude (N), pitch (m) and phase (rad) of force ripple.
    pub(super) ripple: Option<[f64; 3]>,
    pub(super) force_gain: f64,
    pub(super) force_bias: f64,
    pub(super) force_lag_s: f64,
    pub(super) force_delay_s: f64,
    pub(super) force_resolution: f64,
    pub(super) tool_kg: f64,
    pub(super) encoder_resolution: f64,
    /// Drag that grows with the square of speed, N s²/m². It is hidden as an effect outside the library.
    pub(super) drag: f64,
    /// A cable that pulls back the further it is drawn, N/m beyond its slack.
    pub(super) cable: f64,
    /// A drive that loses force the harder it is driven: share lost at 100 N.
    pub(super) sag: f64,
    /// A force reading that creeps: share of the force that comes late, with this time constant.
    pub(super) creep: Option<[f64; 2]>,
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct State {
    base: [f64; 2],
    motor: [f64; 2],
    tip: [f64; 2],
    workpiece: [f64; 2],
    bristle: f64,
    drive: f64,
    lagged: f64,
    crept: f64,
}

/// The readings of the sensors.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Truths {
    pub(super) encoder_m: f64,
    pub(super) motor_acceleration: f64,
    pub(super) tip_acceleration: f64,
    /// Force after lag and creep, before gain and bias, N.
    pub(super) force_n: f64,
}

/// Distance of `x` beyond free play of width `play`.
fn beyond(x: f64, play: f64) -> f64 {
    x - x.clamp(-0.5 * play, 0.5 * play)
}

impl Bench {
    /// Moves by one step under a command that has arrived at the drive.
    pub(super) fn step(&self, state: &mut State, command: f64, hold: Hold) -> Truths {
        let h = STEP_S;
        let wanted = self.drive_force(command, state);
        state.drive = if self.drive_lag_s > 0.0 {
            state.drive + (wanted - state.drive) * h / self.drive_lag_s
        } else {
            wanted
        };
        let stroke = state.motor[0] - state.base[0];
        let speed = state.motor[1] - state.base[1];
        let ripple = self.ripple.map_or(0.0, |[amplitude, pitch, phase]| {
            amplitude * (std::f64::consts::TAU * stroke / pitch + phase).sin()
        });
        let drive = state.drive + ripple;
        let (contact, spring) = self.contact(state, hold);
        let guide = self.guide(state, speed, stroke, contact);
        // Forces on motor, tip, base and workpiece.
        let mut on_motor = drive - guide;
        let mut on_tip = -contact;
        let mut on_base = guide - drive;
        let mut on_workpiece = contact;
        if let Some(link) = &self.transmission {
            let force = elastic(link, state.motor[0] - state.tip[0], state.motor[1] - state.tip[1]);
            on_motor -= force;
            on_tip += force;
        }
        if let Some(link) = &self.fixture {
            let force = elastic(link, state.workpiece[0] - state.base[0], state.workpiece[1] - state.base[1]);
            on_workpiece -= force;
            on_base += force;
        }
        if let Some(link) = &self.mount {
            on_base -= elastic(link, state.base[0], state.base[1]);
        }
        let (motor, tip) = if self.transmission.is_some() {
            (on_motor / self.motor_kg, on_tip / self.tip_kg)
        } else {
            let both = (on_motor + on_tip) / (self.motor_kg + self.tip_kg);
            (both, both)
        };
        let (base, workpiece) = match (self.mount.is_some(), self.fixture.is_some()) {
            (false, false) => (0.0, 0.0),
            (false, true) => (0.0, on_workpiece / self.workpiece_kg),
            (true, true) => (on_base / self.base_kg, on_workpiece / self.workpiece_kg),
            (true, false) => {
                let both = (on_base + on_workpiece) / (self.base_kg + self.workpiece_kg);
                (both, both)
            }
        };
        for (body, acceleration) in [
            (&mut state.motor, motor),
            (&mut state.tip, tip),
            (&mut state.base, base),
            (&mut state.workpiece, workpiece),
        ] {
            body[1] += h * acceleration;
            body[0] += h * body[1];
        }
        let sensed = spring + self.tool_kg * tip;
        state.lagged = if self.force_lag_s > 0.0 {
            state.lagged + (sensed - state.lagged) * h / self.force_lag_s
        } else {
            sensed
        };
        let force_n = match self.creep {
            Some([share, time]) => {
                state.crept += (state.lagged - state.crept) * h / time;
                state.lagged * (1.0 - share) + share * state.crept
            }
            None => state.lagged,
        };
        Truths {
            encoder_m: state.motor[0] - state.base[0],
            motor_acceleration: motor,
            tip_acceleration: tip,
            force_n,
        }
    }

    fn drive_force(&self, command: f64, state: &State) -> f64 {
        let through = command - command.clamp(-self.deadband, self.deadband);
        let scaled = through * self.drive_gain * (1.0 - self.sag * (through.abs() / 100.0));
        let limited = scaled.clamp(-self.limit_n, self.limit_n);
        if self.slew.is_finite() {
            state.drive + (limited - state.drive).clamp(-self.slew * STEP_S, self.slew * STEP_S)
        } else {
            limited
        }
    }

    /// Total force between tip and workpiece, and the part that the spring carries, N.
    fn contact(&self, state: &State, hold: Hold) -> (f64, f64) {
        if hold == Hold::Free {
            return (0.0, 0.0);
        }
        let gap = if hold == Hold::Wall { self.gap_m } else { 0.0 };
        let pressed = state.tip[0] - state.workpiece[0] - gap;
        let speed = state.tip[1] - state.workpiece[1];
        if hold == Hold::Wall && pressed <= 0.0 {
            return (0.0, 0.0);
        }
        // A clamped tool can pull as well as push.
        let curve = if (self.wall_exponent - 1.0).abs() > 1e-12 {
            pressed.abs().powf(self.wall_exponent).copysign(pressed)
        } else {
            pressed
        };
        let linear = self.wall_stiffness * curve;
        let spring = linear + self.wall_cubic * pressed.powi(3);
        let damper = if hold == Hold::Wall && self.hunt_crossley > 0.0 {
            self.hunt_crossley * spring * speed
        } else {
            self.wall_damping * speed
        };
        let whole = spring + damper;
        if hold == Hold::Wall && whole < 0.0 { (0.0, spring) } else { (whole, spring) }
    }

    /// Force that the guide takes from the motor.
    fn guide(&self, state: &mut State, speed: f64, stroke: f64, contact: f64) -> f64 {
        let smooth =
            self.guide_damping * speed + self.drag * speed * speed.abs() + self.cable * stroke.max(0.0)
                - self.constant_load;
        let sided = self.coulomb * (1.0 + self.asymmetry * speed.signum());
        let curve =
            self.stribeck.map_or(0.0, |[above, velocity]| above * (-(speed / velocity).powi(2)).exp());
        let level = sided + curve + self.load_ratio * contact.abs();
        if level <= 0.0 {
            state.bristle = 0.0;
            return smooth;
        }
        // Dahl's bristle deflects with the motion, and slides when its force reaches the level.
        let stiffness = level / BRISTLE_M;
        let rate = speed - speed.abs() * state.bristle / BRISTLE_M;
        state.bristle = (state.bristle + STEP_S * rate).clamp(-BRISTLE_M, BRISTLE_M);
        let damping = BRISTLE_DAMPING * 2.0 * (stiffness * (self.motor_kg + self.tip_kg)).sqrt();
        smooth + stiffness * state.bristle + damping * rate
    }

    /// A reading of the force sensor.
    pub(super) fn read_force(&self, force_n: f64) -> f64 {
        self.force_gain * force_n + self.force_bias
    }
}

fn elastic(link: &Compliance, stretch: f64, rate: f64) -> f64 {
    let taut = beyond(stretch, link.play);
    let damped = if link.play > 0.0 && taut == 0.0 { 0.0 } else { link.damping * rate };
    link.stiffness * taut + damped
}

#[cfg(test)]
mod tests {
    use super::super::cases::ideal;
    use super::*;

    /// A semi-implicit step is of first order: the relative error is about the step times the fastest rate.
    const FIRST_ORDER: f64 = 1e-3;

    #[test]
    fn truth_a_free_mass_answers_a_constant_force_with_a_lag_of_its_damping() {
        let mut bench = ideal();
        bench.guide_damping = 60.0;
        let mut state = State::default();
        let mass = bench.motor_kg + bench.tip_kg;
        let seconds = 0.2;
        for _ in 0..(seconds / STEP_S) as usize {
            bench.step(&mut state, 10.0, Hold::Free);
        }
        let closed_form = 10.0 / 60.0 * (1.0 - (-60.0 / mass * seconds).exp());
        assert!((state.motor[1] / closed_form - 1.0).abs() < FIRST_ORDER);
    }

    #[test]
    fn truth_dry_friction_holds_below_its_level_and_takes_its_level_above() {
        let mut bench = ideal();
        bench.guide_damping = 0.0;
        bench.coulomb = 12.0;
        let mut state = State::default();
        let mut last = Truths::default();
        for _ in 0..50_000 {
            last = bench.step(&mut state, 9.0, Hold::Free);
        }
        // On Dahl's curve the deflection at three quarters of the level is ln 4 bristle lengths. The sudden
        // start adds to it.
        assert!(last.encoder_m.abs() < 5.0 * BRISTLE_M && state.motor[1].abs() < 1e-6);
        for _ in 0..50_000 {
            last = bench.step(&mut state, 24.0, Hold::Free);
        }
        let mass = bench.motor_kg + bench.tip_kg;
        assert!((last.motor_acceleration * mass - 12.0).abs() < 12.0 * FIRST_ORDER);
    }
}
