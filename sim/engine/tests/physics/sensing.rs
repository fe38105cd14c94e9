//! The chain from a signal to a reading, and the instants of readings.

use std::f64::consts::TAU;

use feeler_control::ReferenceSpec;
use feeler_engine::Scenario;
use feeler_plant::description::{GROUND, LowPass, Quantity, Sensor, Spring};

use crate::common::{axis, close, command, drive, effect, free_mass, run, scenario, sensor, spring};

/// A few exponentials of size one.
const EXACT: f64 = 1e-12;
const SPEED_M_PER_S: f64 = 0.3;
const START_M: f64 = 0.04;

/// Readings of the position of a body with constant speed.
fn flight(sensor: Sensor, duration_s: f64) -> Scenario {
    let mut machine = free_mass(1.0, START_M, SPEED_M_PER_S);
    machine.sensors.insert("scale".into(), sensor);
    scenario(machine, duration_s, &["scale.reading"])
}

fn scale() -> Sensor {
    sensor("tip", Quantity::Position)
}

#[test]
fn truth_low_passes_follow_a_ramp_by_their_closed_forms() {
    let (corner_hz, zeta) = (12.0, 0.6_f64);
    let omega = TAU * corner_hz;
    let first = |t: f64| t - (1.0 - (-omega * t).exp()) / omega;
    let damped = omega * (1.0 - zeta * zeta).sqrt();
    let second = |t: f64| {
        let (sin, cos) = (damped * t).sin_cos();
        t - 2.0 * zeta / omega
            + (-zeta * omega * t).exp()
                * (2.0 * zeta / omega * cos + (2.0 * zeta * zeta - 1.0) / damped * sin)
    };
    let filters: [(LowPass, &dyn Fn(f64) -> f64); 2] = [
        (LowPass::FirstOrder { corner_hz }, &first),
        (LowPass::SecondOrder { corner_hz, damping_ratio: zeta }, &second),
    ];
    for (filter, form) in filters {
        for delay_s in [0.0, 0.012_345] {
            let (trace, _) = run(&flight(
                Sensor { low_pass: Some(filter), delay_s, gain: 2.0, bias: -1.0, ..scale() },
                0.3,
            ));
            for (t, reading) in trace.t_s.iter().zip(trace.column("scale.reading").unwrap()) {
                // The filter starts settled at the initial position.
                let position = START_M + SPEED_M_PER_S * form((t - delay_s).max(0.0));
                close(*reading, 2.0 * position - 1.0, EXACT);
            }
        }
    }
}

/// A body slides to a halt: until then its guide pushes back with the level of its friction alone.
#[test]
fn regress_the_filtered_force_of_a_guide_includes_its_friction() {
    let (level_n, corner_hz) = (2.0, 50.0);
    for filter in [LowPass::FirstOrder { corner_hz }, LowPass::SecondOrder { corner_hz, damping_ratio: 0.7 }]
    {
        let mut machine = free_mass(1.0, START_M, SPEED_M_PER_S);
        let effects = vec![effect("coulomb-friction", &[level_n])];
        machine.springs.insert("guide".into(), Spring { effects, ..spring(GROUND, "tip", 0.0, 0.0) });
        let gauge = Sensor { low_pass: Some(filter), ..sensor("guide", Quantity::Force) };
        machine.sensors.insert("gauge".into(), gauge);
        let (trace, _) = run(&scenario(machine, 0.1, &["gauge.reading"]));
        for reading in trace.column("gauge.reading").unwrap() {
            close(*reading, -level_n, EXACT);
        }
    }
}

#[test]
fn truth_resolution_rounds_to_the_nearest_step() {
    let step = 0.01;
    let quantised =
        Sensor { resolution: Some(step), effects: vec![effect("encoder-resolution", &[step])], ..scale() };
    for sensor in [Sensor { effects: Vec::new(), ..quantised.clone() }, quantised] {
        let (trace, _) = run(&flight(sensor, 0.5));
        for (t, reading) in trace.t_s.iter().zip(trace.column("scale.reading").unwrap()) {
            let exact = START_M + SPEED_M_PER_S * t;
            close((reading / step).round() * step, *reading, EXACT);
            assert!((reading - exact).abs() <= 0.5 * step + EXACT);
        }
    }
}

#[test]
fn truth_noise_is_white_normal_and_its_own() {
    let sigma = 0.02;
    let noisy = |seed: u64, second: bool| {
        let mut scenario = flight(Sensor { noise: sigma, ..scale() }, 20.0);
        scenario.run.seed = seed;
        if second {
            scenario.machine.sensors.insert("other".into(), Sensor { noise: 1.0, ..scale() });
            scenario.run.record.insert(0, "other.reading".parse().unwrap());
        }
        let (trace, _) = run(&scenario);
        let readings = trace.t_s.iter().zip(trace.column("scale.reading").unwrap());
        let other = trace.column("other.reading").map(<[f64]>::to_vec);
        (readings.map(|(t, reading)| reading - START_M - SPEED_M_PER_S * t).collect::<Vec<_>>(), other)
    };
    let (noise, _) = noisy(1, false);
    let n = noise.len() as f64;
    let moment = |f: &dyn Fn(usize) -> f64| (0..noise.len() - 1).map(f).sum::<f64>() / (n - 1.0);
    // Five standard errors of each estimate for 20,000 independent normal numbers.
    let wide = 5.0 / n.sqrt();
    close(moment(&|i| noise[i]) / sigma, 0.0, wide);
    close(moment(&|i| noise[i].powi(2)) / (sigma * sigma), 1.0, wide * 2_f64.sqrt());
    close(moment(&|i| noise[i].powi(4)) / sigma.powi(4), 3.0, wide * 96_f64.sqrt());
    close(moment(&|i| noise[i] * noise[i + 1]) / (sigma * sigma), 0.0, wide);
    // Another sensor does not change its noise and has independent noise; another seed gives other noise.
    let (beside, other) = noisy(1, true);
    assert!(noise.iter().zip(&beside).all(|(a, b)| a.to_bits() == b.to_bits()));
    let other = other.unwrap();
    let position = |i: usize| START_M + SPEED_M_PER_S * i as f64 * 1e-3;
    close(moment(&|i| noise[i] * (other[i] - position(i))) / sigma, 0.0, wide);
    let (reseeded, _) = noisy(2, false);
    close(moment(&|i| noise[i] * reseeded[i]) / (sigma * sigma), 0.0, wide);
}

/// An open loop whose reference is time itself shows its sample times.
fn sample_times(jitter_s: f64, effects: &[(&str, &[f64])], offset_s: f64) -> Vec<f64> {
    let mut machine = free_mass(1.0, 0.0, 0.0);
    machine.actuators.insert("drive".into(), drive("tip", "ground"));
    let mut scenario = scenario(machine, 20.0, &["clock.output"]);
    scenario.run.step_s = 1e-2;
    command(&mut scenario, "clock", ReferenceSpec::PiecewiseLinear(vec![(0.0, 0.0), (30.0, 30.0)]), 1e-2);
    let clock = &mut scenario.controllers["clock"];
    clock.spec.jitter_s = jitter_s;
    clock.spec.offset_s = offset_s;
    clock.effects = effects.iter().map(|(kind, values)| effect(kind, values)).collect();
    let (trace, _) = run(&scenario);
    trace.column("clock.output").unwrap().to_vec()
}

#[test]
fn truth_samples_are_taken_on_the_grid_and_jitter_takes_them_off_it() {
    for (i, t) in sample_times(0.0, &[], 0.0).iter().enumerate() {
        close(*t, 1e-2 * i as f64, EXACT);
    }
    // Records come half a period after samples, so each shows the sample before it; the record at zero shows
    // none.
    let nominal = |i: usize| 1e-2 * i as f64 - 5e-3;
    let sigma = 1e-3_f64.hypot(5e-4);
    let times = sample_times(1e-3, &[("timing-jitter", &[5e-4])], 5e-3);
    let n = (times.len() - 1) as f64;
    let offsets: Vec<f64> = (1..times.len()).map(|i| (times[i] - nominal(i)) / sigma).collect();
    // Five standard errors of mean and variance of 2000 normal numbers. The clock limits them beyond 4.38
    // sigma, which has no effect here.
    close(offsets.iter().sum::<f64>() / n, 0.0, 5.0 / n.sqrt());
    close(offsets.iter().map(|x| x * x).sum::<f64>() / n, 1.0, 5.0 * (2.0 / n).sqrt());
}

/// A controller with a delayed sensor acts on past values: a proportional law on the position shows it.
#[test]
fn truth_a_controller_reads_a_late_sensor_as_it_was() {
    for (delay_s, period_s) in [(0.0, 1e-3), (2.5e-4, 1e-3), (3.3e-3, 1e-3), (1e-2 / 7.0, 1.7e-3)] {
        let mut scenario = flight(Sensor { delay_s, ..scale() }, 0.1);
        // Too heavy for the force to matter, so that the speed stays constant.
        scenario.machine.bodies["tip"].mass_kg = 1e15;
        scenario.machine.actuators.insert("drive".into(), drive("tip", "ground"));
        scenario.run.record.push("loop.output".parse().unwrap());
        let gains = feeler_control::PositionGains { kp: -1.0, ..Default::default() };
        command(&mut scenario, "loop", ReferenceSpec::Constant(0.0), period_s);
        scenario.controllers["loop"].spec.law = feeler_control::Law::Position(gains);
        scenario.controllers["loop"].reads = Some("scale".into());
        let (trace, _) = run(&scenario);
        for (t, output) in trace.t_s.iter().zip(trace.column("loop.output").unwrap()) {
            let sampled = (t / period_s + 1e-9).floor() * period_s;
            close(*output, START_M + SPEED_M_PER_S * (sampled - delay_s).max(0.0), EXACT);
        }
    }
}

/// Between two samples a late reading takes its signal as a row of the same product. In a record of ten times
/// the rate every interval ends at that instant instead. Both differ by roundings, which impacts amplify. A
/// stiff wall divides the interval into parts.
#[test]
fn prop_a_signal_taken_on_the_way_is_that_of_an_instant() {
    const ROUNDINGS: f64 = 1e-9;
    for (delay_s, stiffness, duration_s) in [(0.3e-3, 2e5, 0.2), (2.7e-3, 2e5, 0.2), (0.4e-3, 2e7, 0.04)] {
        let mut scenario = axis(duration_s);
        scenario.run.energy = false;
        scenario.machine.contacts["tool"].stiffness = stiffness;
        scenario.machine.sensors["force"].delay_s = delay_s;
        let (coarse, simulation) = run(&scenario);
        scenario.run.record_rate_hz = Some(1e4);
        let (fine, _) = run(&scenario);
        // A millisecond is one step, or two parts of one.
        let milliseconds = (duration_s * 1e3).round() as u64;
        let most = if stiffness > 1e6 { 2 * milliseconds } else { milliseconds };
        assert!(coarse.events.len() > 2 && simulation.steps() <= most, "{} steps", simulation.steps());
        for name in ["tool.force", "tip.position", "motor.velocity", "drive.force", "force.reading"] {
            let (coarse, fine) = (coarse.column(name).unwrap(), fine.column(name).unwrap());
            let largest = coarse.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
            for (i, value) in coarse.iter().enumerate() {
                close(*value, fine[10 * i], ROUNDINGS * largest);
            }
        }
    }
}
