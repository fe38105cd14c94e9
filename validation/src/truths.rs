//! Closed forms, each written out from its source, independent of the simulator.

use std::f64::consts::PI;

use feeler_lti::C64;
use feeler_plant::description::{ActuatorKind, MotorInput};
use nalgebra::{Matrix4, Vector4};

use crate::paper::PaperAxis;

/// Largest proportional gain of a rigid axis with a force lag `tau` (no back-EMF), and the angular frequency
/// of its oscillation. They are `b / (tau k_s) + tau b / m + b^2 / (m k_s)`, `omega^2 = (b + tau k_s) / (tau
/// m)`; `b` is the total damping.
pub(crate) fn lagged_axis_largest_gain(m: f64, b: f64, k_s: f64, tau: f64) -> (f64, f64) {
    let gain = b / (tau * k_s) + tau * b / m + b * b / (m * k_s);
    (gain, ((b + tau * k_s) / (tau * m)).sqrt())
}

/// Largest proportional gain of an undamped two-mass axis:
/// `1 + K = (m1 (k + k_s) + m2 k)^2 / (4 m1 m2 k k_s)`.
pub(crate) fn two_mass_largest_gain(m1: f64, m2: f64, k: f64, k_s: f64) -> f64 {
    let sum = m1 * (k + k_s) + m2 * k;
    sum * sum / (4.0 * m1 * m2 * k * k_s) - 1.0
}

/// Largest `T G k` of an integral force loop on a pure stiffness with `n` whole samples of delay:
/// `2 sin(pi / (2 (2 n + 1)))`; n = 1 is Whitney's.
pub(crate) fn integral_loop_largest_gain(n: u32) -> f64 {
    2.0 * (PI / (2.0 * f64::from(2 * n + 1))).sin()
}

/// Restitution of a Kelvin-Voigt impact released at zero force (Schwager and Poeschel 2007).
pub(crate) fn kelvin_voigt_restitution(zeta: f64) -> f64 {
    let root = (1.0 - zeta * zeta).sqrt();
    // omega_n t_c = atan2(2 zeta root, 2 zeta^2 - 1) / root.
    (-zeta * (2.0 * zeta * root).atan2(2.0 * zeta * zeta - 1.0) / root).exp()
}

/// Restitution of a Hunt-Crossley impact for `a v_i`: the root of
/// `a v_i - ln(1 + a v_i) = -a v_o - ln(1 - a v_o)`, over `a v_i`.
pub(crate) fn hunt_crossley_restitution(a_v: f64) -> f64 {
    let left = a_v - a_v.ln_1p();
    let (mut low, mut high) = (0.0, a_v.min(1.0));
    for _ in 0..200 {
        let w = 0.5 * (low + high);
        if -w - (-w).ln_1p() < left { low = w } else { high = w }
    }
    0.5 * (low + high) / a_v
}

/// Describing function of a one-sided spring, for motions with amplitude A about the free gap x0, as a share
/// of its stiffness; `r = x0 / A`.
pub(crate) fn one_sided_spring(r: f64) -> f64 {
    if r.abs() >= 1.0 {
        if r > 0.0 { 1.0 } else { 0.0 }
    } else {
        0.5 + (r.asin() + r * (1.0 - r * r).sqrt()) / PI
    }
}

/// Smallest damping of a mechanism that keeps a virtual wall passive (Colgate and Schenkel): `K T / 2 + |B|`.
pub(crate) fn virtual_wall_damping(k: f64, b: f64, period_s: f64) -> f64 {
    0.5 * k * period_s + b.abs()
}

/// Transfer function of an axis from its command to the elastic force of the sensor. It follows the paper's
/// equations of motion (Figs. 1, 2, 3, 6, 9, 12).
pub(crate) fn axis_response(axis: &PaperAxis, s: C64) -> C64 {
    let (m1, m2) = axis.masses_kg;
    let m = m1 + m2;
    let (ks, bs) = axis.contact;
    let br = axis.guide_n_s_per_m;
    let sensor = s * bs + ks;
    // Compression of the sensor, and displacement of the motor against the reacting body, per unit of drive
    // force.
    let (compression, stroke) = match (axis.transmission, axis.base, axis.workpiece) {
        (None, None, None) => {
            let d = (s * s * m + s * (br + bs) + ks).inv();
            (d, d)
        }
        (Some((k, b)), None, None) => {
            let t = s * b + k;
            let tip = s * s * m2 + sensor + t;
            let determinant = (s * s * m1 + s * br + t) * tip - t * t;
            (t / determinant, tip / determinant)
        }
        (None, Some((mb, kb, bb)), None) => {
            let yields = (s * s * m).inv() + (s * s * mb + s * bb + kb).inv();
            let d = yields / ((sensor + s * br) * yields + 1.0);
            (d, d)
        }
        (None, None, Some((mw, kw, bw))) => {
            let work = sensor / (s * s * mw + s * bw + kw);
            let d = ((s * s * m + s * br) * (work + 1.0) + sensor).inv();
            (d, d * (work + 1.0))
        }
        (transmission, base, workpiece) => full_machine(axis, transmission, base, workpiece, s),
    };
    match axis.drive {
        ActuatorKind::Force { bandwidth_hz } => {
            let lag = bandwidth_hz.map_or(C64::new(1.0, 0.0), |f| s / (2.0 * PI * f) + 1.0);
            compression * ks / lag
        }
        ActuatorKind::VelocitySource { damping_n_s_per_m: ba, time_constant_s: tau } => {
            let force = (s * tau + 1.0 + s * stroke * ba).inv() * ba;
            compression * ks * force
        }
        ActuatorKind::PositionServo(servo) => {
            let forward = s.inv() * servo.ki + servo.kp;
            compression * ks * forward / (stroke * (forward + s * servo.kd) + 1.0)
        }
        ActuatorKind::DcMotor(motor) => {
            let per_current = motor.gear_ratio * motor.torque_constant;
            let ba = per_current * motor.gear_ratio * motor.back_emf() / motor.resistance_ohm;
            let tau = motor.inductance_h / motor.resistance_ohm;
            let per_volt = (s * tau + 1.0 + s * stroke * ba).inv() * (per_current / motor.resistance_ohm);
            let force = match motor.input {
                MotorInput::Voltage => per_volt,
                MotorInput::Duty => per_volt * motor.supply_voltage_v.unwrap_or(1.0),
                MotorInput::Current => C64::new(per_current, 0.0),
            };
            compression * ks * force
        }
        ActuatorKind::Imposed => compression * ks / stroke,
        // Inputs of a servo have no force of their own.
        ActuatorKind::TargetVelocity | ActuatorKind::FeedForward => C64::new(0.0, 0.0),
    }
}

/// Motor, tip, workpiece and base as four equations. NaN unless all of them are present: the smaller models
/// have their own forms.
fn full_machine(
    axis: &PaperAxis,
    transmission: Option<(f64, f64)>,
    base: Option<(f64, f64, f64)>,
    workpiece: Option<(f64, f64, f64)>,
    s: C64,
) -> (C64, C64) {
    let (Some((k, b)), Some((mb, kb, bb)), Some((mw, kw, bw))) = (transmission, base, workpiece) else {
        return (C64::new(f64::NAN, 0.0), C64::new(f64::NAN, 0.0));
    };
    let (m1, m2) = axis.masses_kg;
    let guide = s * axis.guide_n_s_per_m;
    let (t, c, w) = (s * b + k, s * axis.contact.1 + axis.contact.0, s * bw + kw);
    let o = C64::new(0.0, 0.0);
    let matrix = Matrix4::new(
        s * s * m1 + guide + t,
        -t,
        o,
        -guide, //
        -t,
        s * s * m2 + t + c,
        -c,
        o, //
        o,
        -c,
        s * s * mw + c + w,
        -w, //
        -guide,
        o,
        -w,
        s * s * mb + s * bb + kb + guide + w,
    );
    let one = C64::new(1.0, 0.0);
    let x = matrix
        .lu()
        .solve(&Vector4::new(one, o, o, -one))
        .unwrap_or_else(|| Vector4::from_element(C64::new(f64::NAN, 0.0)));
    (x[1] - x[2], x[0] - x[3])
}
