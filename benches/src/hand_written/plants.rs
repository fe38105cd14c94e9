//! The equations of motion of the three reference machines, written out.

use super::control::{Control, Proportional};
use super::fma;

/// A machine of `S` states: positions, then speeds, then the states of a sensor's filter.
pub trait Plant<const S: usize> {
    /// Delay of a reading in tenths of a millisecond, fewer than ten.
    const READ_LATE: usize = 0;

    /// State at the start.
    fn start(&self) -> [f64; S];

    /// The controller at its start.
    fn controller(&self) -> impl Control {
        Proportional
    }

    /// Reading of the force sensor, N, for a contact force `contact_n`.
    fn reading_n(&self, _state: &[f64; S], contact_n: f64) -> f64 {
        contact_n
    }

    /// Compression of the contact, m, and its rate, m/s.
    fn compression(&self, state: &[f64; S]) -> [f64; 2];

    /// Force of the contact while it pushes, `k_s d + b_s d'`, N.
    fn contact_force_n(&self, compression: [f64; 2]) -> f64;

    /// Accelerations under drive force and contact force, m/s^2, in the order of the positions; the rest of
    /// the array is ignored.
    fn accelerations(&self, state: &[f64; S], drive_n: f64, contact_n: f64) -> [f64; S];

    /// Slopes of all states.
    #[inline(always)]
    fn slopes(&self, state: &[f64; S], drive_n: f64, contact_n: f64) -> [f64; S] {
        let a = self.accelerations(state, drive_n, contact_n);
        let mut slopes = [0.0; S];
        for i in 0..S / 2 {
            slopes[i] = state[i + S / 2];
            slopes[i + S / 2] = a[i];
        }
        slopes
    }
}

/// Start of every run, m from the wall.
const START_M: f64 = -5e-3;

/// M1: one body against a wall.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    mass_kg: f64,
    guide_n_s_per_m: f64,
    contact_n_per_m: f64,
    contact_n_s_per_m: f64,
}

impl Default for Axis {
    fn default() -> Self {
        Self { mass_kg: 10.0, guide_n_s_per_m: 50.0, contact_n_per_m: 1e5, contact_n_s_per_m: 100.0 }
    }
}

impl Plant<2> for Axis {
    #[inline(always)]
    fn start(&self) -> [f64; 2] {
        [START_M, 0.0]
    }

    #[inline(always)]
    fn compression(&self, &[x, v]: &[f64; 2]) -> [f64; 2] {
        [x, v]
    }

    #[inline(always)]
    fn contact_force_n(&self, [d, d_dot]: [f64; 2]) -> f64 {
        fma(self.contact_n_per_m, d, self.contact_n_s_per_m * d_dot)
    }

    #[inline(always)]
    fn accelerations(&self, &[_, v]: &[f64; 2], drive_n: f64, contact_n: f64) -> [f64; 2] {
        [(drive_n - contact_n - self.guide_n_s_per_m * v) * (1.0 / self.mass_kg), 0.0]
    }
}

/// M2: motor and tip with a flexible transmission against a wall.
#[derive(Clone, Copy, Debug)]
pub struct FlexibleAxis {
    motor_kg: f64,
    tip_kg: f64,
    guide_n_s_per_m: f64,
    transmission_n_per_m: f64,
    transmission_n_s_per_m: f64,
    contact_n_per_m: f64,
    contact_n_s_per_m: f64,
}

impl Default for FlexibleAxis {
    fn default() -> Self {
        Self {
            motor_kg: 6.0,
            tip_kg: 4.0,
            guide_n_s_per_m: 50.0,
            transmission_n_per_m: 4e5,
            transmission_n_s_per_m: 60.0,
            contact_n_per_m: 1e5,
            contact_n_s_per_m: 100.0,
        }
    }
}

impl Plant<4> for FlexibleAxis {
    #[inline(always)]
    fn start(&self) -> [f64; 4] {
        [START_M, START_M, 0.0, 0.0]
    }

    #[inline(always)]
    fn compression(&self, state: &[f64; 4]) -> [f64; 2] {
        [state[1], state[3]]
    }

    #[inline(always)]
    fn contact_force_n(&self, [d, d_dot]: [f64; 2]) -> f64 {
        fma(self.contact_n_per_m, d, self.contact_n_s_per_m * d_dot)
    }

    #[inline(always)]
    fn accelerations(&self, &[x_m, x_t, v_m, v_t]: &[f64; 4], drive_n: f64, contact_n: f64) -> [f64; 4] {
        let spring = fma(self.transmission_n_per_m, x_t - x_m, self.transmission_n_s_per_m * (v_t - v_m));
        let motor = (drive_n + spring - self.guide_n_s_per_m * v_m) * (1.0 / self.motor_kg);
        let tip = (-spring - contact_n) * (1.0 / self.tip_kg);
        [motor, tip, 0.0, 0.0]
    }
}

/// M4: M2 on a flexible base, against a workpiece held by a fixture on the same base.
#[derive(Clone, Copy, Debug)]
pub struct FlexibleCell {
    axis: FlexibleAxis,
    base_kg: f64,
    workpiece_kg: f64,
    mount_n_per_m: f64,
    mount_n_s_per_m: f64,
    fixture_n_per_m: f64,
    fixture_n_s_per_m: f64,
}

impl Default for FlexibleCell {
    fn default() -> Self {
        Self {
            axis: FlexibleAxis::default(),
            base_kg: 200.0,
            workpiece_kg: 5.0,
            mount_n_per_m: 1.1e6,
            mount_n_s_per_m: 600.0,
            fixture_n_per_m: 1e6,
            fixture_n_s_per_m: 200.0,
        }
    }
}

impl Plant<8> for FlexibleCell {
    #[inline(always)]
    fn start(&self) -> [f64; 8] {
        [0.0, START_M, START_M, 0.0, 0.0, 0.0, 0.0, 0.0]
    }

    #[inline(always)]
    fn compression(&self, state: &[f64; 8]) -> [f64; 2] {
        [state[2] - state[3], state[6] - state[7]]
    }

    #[inline(always)]
    fn contact_force_n(&self, compression: [f64; 2]) -> f64 {
        self.axis.contact_force_n(compression)
    }

    #[inline(always)]
    fn accelerations(&self, state: &[f64; 8], drive_n: f64, contact_n: f64) -> [f64; 8] {
        let &[x_b, x_m, x_t, x_w, v_b, v_m, v_t, v_w] = state;
        let mount = fma(self.mount_n_per_m, x_b, self.mount_n_s_per_m * v_b);
        let guide = self.axis.guide_n_s_per_m * (v_m - v_b);
        let fixture = fma(self.fixture_n_per_m, x_w - x_b, self.fixture_n_s_per_m * (v_w - v_b));
        let spring =
            fma(self.axis.transmission_n_per_m, x_t - x_m, self.axis.transmission_n_s_per_m * (v_t - v_m));
        let base = (guide + fixture - mount - drive_n) * (1.0 / self.base_kg);
        let motor = (drive_n + spring - guide) * (1.0 / self.axis.motor_kg);
        let tip = (-spring - contact_n) * (1.0 / self.axis.tip_kg);
        let workpiece = (contact_n - fixture) * (1.0 / self.workpiece_kg);
        [base, motor, tip, workpiece, 0.0, 0.0, 0.0, 0.0]
    }
}
