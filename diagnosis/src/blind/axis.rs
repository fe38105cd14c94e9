//! Hand-written equations of a driven axis: a motor, a load, a guide and a drive, integrated in small
//! semi-implicit steps. Units are N, m and kg, or N m, rad and kg m² for a rotary axis.

/// Damping ratio of the bristle: its damping over twice the root of stiffness times moving mass.
const BRISTLE_DAMPING: f64 = 0.6;

/// Dry friction: a bristle deflects, and slides when its force reaches the level.
#[derive(Clone, Debug, Default)]
pub(super) struct Friction {
    /// Level far above Stribeck's speed, N.
    pub(super) level: f64,
    /// Half the difference of the levels of the two directions, over their mean.
    pub(super) asymmetry: f64,
    /// Addition to the level at rest, N, and the speed over which it fades, m/s.
    pub(super) stribeck: Option<[f64; 2]>,
    /// Deflection at which the bristle slides, m.
    pub(super) bristle_m: f64,
    /// A stretch of the stroke with a higher level: relative height, centre (m), width (m).
    pub(super) tight_spot: Option<[f64; 3]>,
    /// Share by which the level varies over the stroke, and the period, m.
    pub(super) wave: Option<[f64; 2]>,
    /// Share of the level that is lost as the guide warms, and the time constant of warming, s.
    pub(super) warming: Option<[f64; 2]>,
}

/// The elements between command and force.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    pub(super) gain: f64,
    pub(super) lag_s: f64,
    pub(super) delay_s: f64,
    pub(super) deadband: f64,
    pub(super) limit: f64,
    /// Share of the force that is lost per unit of command, 1/N.
    pub(super) sag: f64,
    /// Share of the force that is lost per unit of speed, s/m.
    pub(super) fading: f64,
    /// Amplitude (N), pitch (m) and phase (rad) of force ripple.
    pub(super) ripple: Option<[f64; 3]>,
}

impl Default for Drive {
    fn default() -> Self {
        Self {
            gain: 1.0,
            lag_s: 0.0,
            delay_s: 0.0,
            deadband: 0.0,
            limit: f64::INFINITY,
            sag: 0.0,
            fading: 0.0,
            ripple: None,
        }
    }
}

/// An elastic joint between motor and load.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joint {
    pub(super) stiffness: f64,
    pub(super) damping: f64,
    /// Free play from flank to flank, m.
    pub(super) play: f64,
}

/// Everything about the real axis.
#[derive(Clone, Debug, Default)]
pub(super) struct Axis {
    pub(super) motor_kg: f64,
    pub(super) load_kg: f64,
    /// Viscous damping of the guide, N s/m.
    pub(super) damping: f64,
    pub(super) friction: Friction,
    /// Force on the motor, N.
    pub(super) constant_load: f64,
    /// Largest torque of gravity, N m, and the angle to add before the sine, rad.
    pub(super) gravity: Option<[f64; 2]>,
    /// Damping added in the positive direction and taken from the other, N s/m.
    pub(super) directional: f64,
    /// Drag that grows with the square of speed, N s²/m².
    pub(super) drag: f64,
    /// A cable: its slack, m, and its stiffness beyond it, N/m.
    pub(super) cable: Option<[f64; 2]>,
    /// A stop: where it is, m, and its stiffness, N/m.
    pub(super) stop: Option<[f64; 2]>,
    pub(super) drive: Drive,
    /// `None` if motor and load move as one.
    pub(super) joint: Option<Joint>,
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct State {
    /// Position, m, and speed, m/s.
    pub(super) motor: [f64; 2],
    pub(super) load: [f64; 2],
    bristle: f64,
    drive: f64,
    time_s: f64,
}

impl State {
    /// At rest, motor and load at one position.
    pub(super) fn resting_at(position: f64) -> Self {
        Self { motor: [position, 0.0], load: [position, 0.0], ..Self::default() }
    }
}

impl Axis {
    /// Mass of motor and load, kg.
    pub(super) fn mass_kg(&self) -> f64 {
        self.motor_kg + self.load_kg
    }

    /// Moves by `step_s` under a command that has arrived at the drive.
    pub(super) fn step(&self, state: &mut State, command: f64, step_s: f64) {
        let [x, v] = state.motor;
        let wanted = self.drive.force(command) * kept(self.drive.fading * v.abs());
        state.drive += (wanted - state.drive) * (step_s / self.drive.lag_s.max(step_s));
        let ripple = self.drive.ripple.map_or(0.0, |[amplitude, pitch, phase]| {
            amplitude * (std::f64::consts::TAU * x / pitch + phase).sin()
        });
        let on_motor = state.drive + ripple - self.smooth(x, v) - self.dry(state, step_s);
        let on_load =
            -self.gravity.map_or(0.0, |[amplitude, phase]| amplitude * (state.load[0] + phase).sin());
        let [motor, load] = match &self.joint {
            None => [(on_motor + on_load) / self.mass_kg(); 2],
            Some(joint) => {
                let force = joint.force(x - state.load[0], v - state.load[1]);
                [(on_motor - force) / self.motor_kg, (on_load + force) / self.load_kg]
            }
        };
        for (body, acceleration) in [(&mut state.motor, motor), (&mut state.load, load)] {
            body[1] += step_s * acceleration;
            body[0] += step_s * body[1];
        }
        state.time_s += step_s;
    }

    /// Force that the guide takes from the motor, dry friction excluded.
    fn smooth(&self, x: f64, v: f64) -> f64 {
        let beyond = |[at, stiffness]: [f64; 2]| stiffness * (x - at).max(0.0);
        self.damping * v + self.directional * v.abs() + self.drag * v * v.abs() - self.constant_load
            + self.cable.map_or(0.0, beyond)
            + self.stop.map_or(0.0, beyond)
    }

    /// Dahl's bristle under a level that depends on speed, place and time.
    fn dry(&self, state: &mut State, step_s: f64) -> f64 {
        let friction = &self.friction;
        let [x, v] = state.motor;
        let rest = friction.stribeck.map_or(0.0, |[above, speed]| above * (-(v / speed).powi(2)).exp());
        let tight = friction
            .tight_spot
            .map_or(0.0, |[height, centre, width]| height * (-((x - centre) / width).powi(2)).exp());
        let wave =
            friction.wave.map_or(0.0, |[share, period]| share * (std::f64::consts::TAU * x / period).sin());
        let warmed =
            friction.warming.map_or(0.0, |[share, time]| share * (1.0 - (-state.time_s / time).exp()));
        let level = (friction.level * (1.0 + friction.asymmetry * v.signum()) + rest)
            * (1.0 + tight)
            * (1.0 + wave)
            * (1.0 - warmed);
        if level <= 0.0 {
            return 0.0;
        }
        let length = friction.bristle_m;
        let stiffness = level / length;
        let rate = v - v.abs() * state.bristle / length;
        state.bristle = (state.bristle + step_s * rate).clamp(-length, length);
        let damping = BRISTLE_DAMPING * 2.0 * (stiffness * self.mass_kg()).sqrt();
        stiffness * state.bristle + damping * rate
    }

    /// The highest frequency that a step must follow, rad/s.
    pub(super) fn fastest(&self) -> f64 {
        let friction = &self.friction;
        let level =
            friction.level * (1.0 + friction.asymmetry.abs()) + friction.stribeck.map_or(0.0, |s| s[0]);
        let bristle = if level > 0.0 { (level / friction.bristle_m / self.mass_kg()).sqrt() } else { 0.0 };
        let joint = self
            .joint
            .map_or(0.0, |joint| (joint.stiffness * (1.0 / self.motor_kg + 1.0 / self.load_kg)).sqrt());
        let stop = self.stop.map_or(0.0, |[_, stiffness]| (stiffness / self.mass_kg()).sqrt());
        bristle.max(joint).max(stop)
    }
}

/// Share of a force that remains after a loss of this share: a tenth at least.
fn kept(lost: f64) -> f64 {
    1.0 - lost.min(0.9)
}

impl Drive {
    /// The force of a command that has arrived, before the lag.
    fn force(&self, command: f64) -> f64 {
        let through = command - command.clamp(-self.deadband, self.deadband);
        let made = through * self.gain * kept(self.sag * through.abs());
        made.clamp(-self.limit, self.limit)
    }
}

impl Joint {
    fn force(&self, stretch: f64, rate: f64) -> f64 {
        let half = 0.5 * self.play;
        let taut = stretch - stretch.clamp(-half, half);
        if self.play > 0.0 && taut == 0.0 { 0.0 } else { self.stiffness * taut + self.damping * rate }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Step of the tests, s.
    const STEP_S: f64 = 1e-5;
    /// A semi-implicit step is of first order: its error is about the step times the fastest rate, 60 per
    /// second here.
    const FIRST_ORDER: f64 = 60.0 * STEP_S;

    fn pendulum() -> Axis {
        Axis { motor_kg: 0.3, load_kg: 0.7, gravity: Some([12.0, 0.0]), ..Axis::default() }
    }

    fn moved(axis: &Axis, state: &mut State, command: f64, seconds: f64) {
        for _ in 0..(seconds / STEP_S).round() as usize {
            axis.step(state, command, STEP_S);
        }
    }

    #[test]
    fn truth_a_level_arm_begins_to_fall_as_its_weight_says() {
        let axis = Axis { gravity: Some([12.0, std::f64::consts::FRAC_PI_2]), ..pendulum() };
        let mut state = State::default();
        let seconds = 0.02;
        moved(&axis, &mut state, 0.0, seconds);
        // The arm has turned by 2.4 mrad: its weight is level still, to three parts in a million.
        assert!((state.load[0] / (-0.5 * 12.0 * seconds * seconds) - 1.0).abs() < 2.0 * FIRST_ORDER);
    }

    #[test]
    fn truth_a_swing_keeps_its_energy() {
        let axis = pendulum();
        let mut state = State::resting_at(1.2);
        let energy = |state: &State| 0.5 * state.load[1].powi(2) - 12.0 * state.load[0].cos();
        let before = energy(&state);
        moved(&axis, &mut state, 0.0, 3.0);
        assert!((energy(&state) - before).abs() < FIRST_ORDER * before.abs());
    }

    #[test]
    fn truth_friction_holds_below_its_level_and_takes_its_level_above() {
        let friction = Friction { level: 5.0, bristle_m: 1e-3, ..Friction::default() };
        let axis = Axis { motor_kg: 1.0, load_kg: 1.0, friction, ..Axis::default() };
        let mut state = State::default();
        moved(&axis, &mut state, 4.0, 2.0);
        // Dahl's curve bends by ln 5 lengths at four fifths of the level; the sudden start bends it further.
        assert!(state.motor[0].abs() < 5e-3 && state.motor[1].abs() < 1e-6);
        moved(&axis, &mut state, 9.0, 1.0);
        let before = state.motor[1];
        moved(&axis, &mut state, 9.0, 0.5);
        assert!(((state.motor[1] - before) / 0.5 / 2.0 - 1.0).abs() < FIRST_ORDER);
    }

    #[test]
    fn truth_a_joint_with_play_lets_the_load_wait() {
        let joint = Joint { stiffness: 100.0, damping: 1.0, play: 0.02 };
        assert!(joint.force(0.009, 3.0).abs() < f64::EPSILON);
        assert!((joint.force(-0.03, 0.0) + 2.0).abs() < 1e-12);
    }

    #[test]
    fn truth_a_drive_takes_its_deadband_and_keeps_its_limit() {
        let drive = Drive { deadband: 2.0, gain: 1.5, limit: 10.0, ..Drive::default() };
        for (command, force) in [(1.9, 0.0), (4.0, 3.0), (-4.0, -3.0), (50.0, 10.0)] {
            assert!((drive.force(command) - force).abs() < 1e-12);
        }
    }
}
