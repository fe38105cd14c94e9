//! The axis against the simulated arm.

use std::f64::consts::TAU;

use feeler_arm::{FlexibleArm, Others, Reduction, Wall};
use nalgebra::Complex;

use super::{DOWN, poses, six_joint};

/// Tolerance relative to the force's amplitude: the remaining transient after two seconds, and the error of
/// the fourth-order steps.
const SIMULATED: f64 = 5e-3;

#[test]
fn truth_the_simulated_arm_swings_as_its_linear_model_says() {
    let arm = six_joint();
    let q = &poses(&arm)[5];
    // The force keeps the tool in contact, but is too light for a free arm to drift into another pose.
    let (contact, frequency_hz, press, swing) = ([2e4, 400.0], 12.0, 0.2, 0.01);
    for others in [Others::Free, Others::Held] {
        let wall = Wall { gap_m: 0.0, stiffness_n_per_m: contact[0], damping_n_s_per_m: contact[1] };
        let expected =
            arm.response_in_contact(q, DOWN, others, contact, &[frequency_hz]).unwrap()[0].norm() * swing;
        let mut moving = FlexibleArm::new(&arm, q, DOWN, others, wall).unwrap();
        let (per_period, settle, periods) = (160, 24, 6);
        let step_s = 1.0 / frequency_hz / f64::from(per_period);
        let mut sum = Complex::new(0.0, 0.0);
        for i in 0..per_period * (settle + periods) {
            let phase = TAU * f64::from(i) / f64::from(per_period);
            if i >= per_period * settle {
                sum += moving.force_n() * Complex::new(phase.cos(), -phase.sin());
            }
            // Held over the step: a delay of half a step, and a negligible change of the amplitude.
            moving.step(step_s, press + swing * phase.sin()).unwrap();
        }
        let found = 2.0 * sum.norm() / f64::from(per_period * periods);
        println!("{others:?}: {found:.5} N simulated, {expected:.5} N linear");
        assert!((found / expected - 1.0).abs() < SIMULATED, "{others:?}: {found} {expected}");
    }
}

/// Tolerance of the contact mode and phase crossover of the axis, against a multisine on the simulated arm.
const MEASURED: f64 = 0.05;

/// Misfit of the axis against the simulated arm at some of the twenty poses, and the largest of all.
fn measured_misfit(poses: &[Vec<f64>], others: Others) -> f64 {
    let (arm, contact) = (six_joint(), [2e4, 40.0]);
    let mut worst = 0.0_f64;
    for q in poses {
        let (axis, _) = arm.reduce_in_contact(q, DOWN, others, contact).unwrap();
        let found = arm.measure_in_contact(&axis, q, DOWN, others, contact).unwrap();
        let linear = arm.response_in_contact(q, DOWN, others, contact, &found.frequencies_hz).unwrap();
        let apart = found.response.iter().zip(&linear).map(|(a, b)| (a / b - 1.0).norm()).fold(0.0, f64::max);
        let [mode, crossover] = found.misfits();
        println!(
            "{others:?}: contact mode {:.3?} Hz, phase crossover {:.3?} Hz; response off the linear arm by \
             {apart:.1e}; {:.1} s",
            found.contact_mode_hz, found.phase_crossover_hz, found.simulated_s
        );
        assert!(apart < SIMULATED_LINES, "{others:?}: {apart}");
        worst = worst.max(mode).max(crossover);
    }
    worst
}

/// Tolerance of the lines of the simulated arm against its linear model: remaining transient, fourth-order
/// steps, and the amplitude of the motion.
const SIMULATED_LINES: f64 = 2e-3;

#[test]
fn reference_measured_landmarks_are_the_axis_s_at_three_poses() {
    let poses = poses(&six_joint());
    for others in [Others::Held, Others::Free] {
        let worst = measured_misfit(&[poses[0].clone(), poses[9].clone(), poses[18].clone()], others);
        assert!(worst < MEASURED, "{others:?}: {worst}");
    }
}

#[test]
#[ignore = "simulates seven minutes of forty arms; run with --release"]
fn reference_measured_landmarks_are_the_axis_s_at_twenty_poses() {
    for others in [Others::Held, Others::Free] {
        let worst = measured_misfit(&poses(&six_joint()), others);
        println!("{others:?}: worst of twenty {worst:.4}");
        assert!(worst < MEASURED, "{others:?}: {worst}");
    }
}

/// Tolerance of the peak force of an impact.
const IMPACT: f64 = 0.05;

#[test]
fn reference_impact_peaks_are_the_whole_arm_s_at_twenty_poses() {
    let arm = six_joint();
    let (speed, step_s) = (0.05, 5e-5);
    let wall = Wall { gap_m: 0.0, stiffness_n_per_m: 2e4, damping_n_s_per_m: 40.0 };
    for others in [Others::Held, Others::Free] {
        let mut worst = 0.0_f64;
        for q in poses(&arm) {
            let (axis, _) = arm
                .reduce_in_contact(&q, DOWN, others, [wall.stiffness_n_per_m, wall.damping_n_s_per_m])
                .unwrap();
            let mut moving = FlexibleArm::new(&arm, &q, DOWN, others, wall).unwrap();
            moving.throw(others, speed).unwrap();
            let mut peak = 0.0_f64;
            for _ in 0..1600 {
                moving.step(step_s, 0.0).unwrap();
                peak = peak.max(moving.force_n());
            }
            let reduced = reduced_peak(&axis, &wall, speed);
            worst = worst.max((reduced / peak - 1.0).abs());
        }
        println!("{others:?}: peak force of the impact off by up to {worst:.1e}");
        assert!(worst < IMPACT, "{others:?}: {worst}");
    }
}

/// Largest force when the reduced axis meets the wall at the given speed, computed with small steps.
fn reduced_peak(axis: &Reduction, wall: &Wall, speed: f64) -> f64 {
    let h = 1e-6;
    let [mut x1, mut x2, mut v1, mut v2] = [0.0, 0.0, speed, speed];
    let mut beside = vec![[0.0, speed]; axis.branches.len()];
    let mut peak = 0.0_f64;
    for _ in 0..80_000 {
        let force =
            if x2 > 0.0 { (wall.stiffness_n_per_m * x2 + wall.damping_n_s_per_m * v2).max(0.0) } else { 0.0 };
        let joint = axis.stiffness_n_per_m * (x1 - x2) + axis.damping_n_s_per_m * (v1 - v2);
        let [mut back, mut forth] = [0.0; 2];
        for ([x, v], branch) in beside.iter_mut().zip(&axis.branches) {
            let spring = branch.stiffness_n_per_m * (x1 - *x) + branch.damping_n_s_per_m * (v1 - *v);
            let link = branch.to_tool_n_per_m * (*x - x2) + branch.to_tool_n_s_per_m * (*v - v2);
            *v += h * (spring - link) / branch.mass_kg;
            *x += h * *v;
            back += spring;
            forth += link;
        }
        v1 += h * (-joint - back - axis.guide_damping_n_s_per_m * v1) / axis.motor_mass_kg;
        v2 += h * (joint + forth - force) / axis.tip_mass_kg;
        x1 += h * v1;
        x2 += h * v2;
        peak = peak.max(force);
    }
    peak
}
