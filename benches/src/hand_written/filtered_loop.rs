//! A whole force loop: the flexible axis with a low-pass filter in its sensor, a delayed reading, and a PI
//! controller with a limit.

use std::f64::consts::TAU;

use super::control::{Control, ProportionalIntegral};
use super::fma;
use super::plants::{FlexibleAxis, Plant};

/// The flexible axis with the filter's output as its fifth state.
#[derive(Clone, Copy, Debug)]
pub struct FilteredLoop {
    axis: FlexibleAxis,
    corner_rad_per_s: f64,
}

impl Default for FilteredLoop {
    fn default() -> Self {
        Self { axis: FlexibleAxis::default(), corner_rad_per_s: TAU * 400.0 }
    }
}

impl Plant<5> for FilteredLoop {
    const READ_LATE: usize = 3;

    #[inline(always)]
    fn start(&self) -> [f64; 5] {
        let [x_m, x_t, v_m, v_t] = self.axis.start();
        [x_m, x_t, v_m, v_t, 0.0]
    }

    #[inline(always)]
    fn controller(&self) -> impl Control {
        ProportionalIntegral::default()
    }

    #[inline(always)]
    fn reading_n(&self, state: &[f64; 5], _contact_n: f64) -> f64 {
        state[4]
    }

    #[inline(always)]
    fn compression(&self, &[x_m, x_t, v_m, v_t, _]: &[f64; 5]) -> [f64; 2] {
        self.axis.compression(&[x_m, x_t, v_m, v_t])
    }

    #[inline(always)]
    fn contact_force_n(&self, compression: [f64; 2]) -> f64 {
        self.axis.contact_force_n(compression)
    }

    #[inline(always)]
    fn accelerations(&self, &[x_m, x_t, v_m, v_t, _]: &[f64; 5], drive_n: f64, contact_n: f64) -> [f64; 5] {
        let [motor, tip, ..] = self.axis.accelerations(&[x_m, x_t, v_m, v_t], drive_n, contact_n);
        [motor, tip, 0.0, 0.0, 0.0]
    }

    #[inline(always)]
    fn slopes(&self, state: &[f64; 5], drive_n: f64, contact_n: f64) -> [f64; 5] {
        let [motor, tip, ..] = self.accelerations(state, drive_n, contact_n);
        let &[_, _, v_m, v_t, filtered] = state;
        [v_m, v_t, motor, tip, fma(self.corner_rad_per_s, contact_n, -self.corner_rad_per_s * filtered)]
    }
}
