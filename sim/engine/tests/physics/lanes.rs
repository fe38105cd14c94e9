//! The same numbers, bit for bit: in every lane, in every run, and however the run is divided.

use feeler_control::{ForceGains, Law};
use feeler_engine::{Event, Integrator, Observer, Program, RunEnd, Scenario, Simulation, Trace, Unobserved};
use feeler_lanes::{Lane, Pack};
use feeler_plant::description::{Contact, ContactLaw};

use crate::common::{axis, effect, reference_machine, run};

/// All output of each lane as bits: instants, values and events.
struct Bits<L> {
    rows: Vec<Vec<u64>>,
    events: Vec<Vec<(u64, Event)>>,
    lane: std::marker::PhantomData<L>,
}

impl<L: Lane> Observer<L> for Bits<L> {
    fn record(&mut self, t_s: f64, values: &[L]) {
        for (l, row) in self.rows.iter_mut().enumerate() {
            row.push(t_s.to_bits());
            row.extend(values.iter().map(|value| value.lane(l).to_bits()));
        }
    }

    fn event(&mut self, lane: usize, event: &Event) {
        self.events[lane].push((event.t_s.to_bits(), *event));
    }
}

fn run_lanes<L: Lane>(scenarios: &[Scenario]) -> (Bits<L>, Vec<Vec<u64>>) {
    let programs = scenarios.iter().map(|scenario| Program::new(scenario).unwrap()).collect();
    let mut simulation = Simulation::<L>::new(programs).unwrap();
    let mut bits = Bits {
        rows: vec![Vec::new(); L::WIDTH],
        events: vec![Vec::new(); L::WIDTH],
        lane: std::marker::PhantomData,
    };
    simulation.run(&mut bits).unwrap();
    let states = (0..L::WIDTH).map(|l| simulation.state(l).iter().map(|x| x.to_bits()).collect()).collect();
    (bits, states)
}

/// Asserts that packs of 4 and of 8 give the same results as each of eight variants alone, and that events
/// occurred.
fn alike(what: &str, scenarios: &[Scenario]) {
    let alone: Vec<_> =
        scenarios.iter().map(|scenario| run_lanes::<f64>(std::slice::from_ref(scenario))).collect();
    let happened: usize = alone.iter().map(|(bits, _)| bits.events[0].len()).sum();
    assert!(happened > 8, "{what}: {happened} events");
    let four: Vec<_> = scenarios.chunks_exact(4).map(run_lanes::<Pack<4>>).collect();
    let eight: Vec<_> = scenarios.chunks_exact(8).map(run_lanes::<Pack<8>>).collect();
    for (i, (bits, state)) in alone.iter().enumerate() {
        let packs = [
            (&four[i / 4].0.rows[i % 4], &four[i / 4].0.events[i % 4], &four[i / 4].1[i % 4]),
            (&eight[0].0.rows[i], &eight[0].0.events[i], &eight[0].1[i]),
        ];
        for (rows, events, states) in packs {
            assert_eq!(rows, &bits.rows[0], "{what}, variant {i}: record");
            assert_eq!(events, &bits.events[0], "{what}, variant {i}: events");
            assert_eq!(states, &state[0], "{what}, variant {i}: state");
        }
    }
}

/// Eight variants of a scenario.
fn variants(scenario: &Scenario, vary: impl Fn(&mut Scenario, f64)) -> Vec<Scenario> {
    let variant = |i: i32| {
        let mut scenario = scenario.clone();
        vary(&mut scenario, 1.0 + 0.07 * f64::from(i - 3));
        scenario
    };
    (0..8).map(variant).collect()
}

fn kp(scenario: &mut Scenario, factor: f64) {
    if let Law::ExplicitForce(gains) = &mut scenario.controllers["force"].spec.law {
        *gains = ForceGains { kp: gains.kp * factor, ..*gains };
    }
}

#[test]
fn prop_lanes_give_the_bits_of_a_lone_run() {
    for (integrator, name) in Integrator::ALL {
        for masses in [1, 2, 4] {
            for energy in [false, true] {
                let mut base = reference_machine(masses, 0.15);
                base.run.integrator = integrator;
                base.run.record_rate_hz = Some(3e3);
                base.run.energy = energy;
                let vary = |scenario: &mut Scenario, factor: f64| {
                    kp(scenario, factor);
                    scenario.machine.bodies["tip"].mass_kg *= factor;
                    scenario.machine.contacts["tool"].stiffness /= factor;
                };
                alike(&format!("M{masses}, {name}, energy {energy}"), &variants(&base, vary));
            }
        }
    }
}

#[test]
fn prop_lanes_of_nonlinear_and_switching_machines_give_the_bits_of_a_lone_run() {
    for (integrator, name) in Integrator::ALL {
        let base = || {
            let mut base = axis(0.1);
            base.run.integrator = integrator;
            base.run.energy = false;
            base.run.step_s = 1e-4;
            base.run.record_rate_hz = Some(1e3);
            base
        };
        let mut friction = base();
        friction.machine.springs["guide"]
            .effects
            .extend([effect("coulomb-friction", &[4.0]), effect("load-friction", &[0.1])]);
        let mut play = base();
        play.machine.springs["transmission"].effects.push(effect("backlash", &[5e-5, 0.0, 0.0]));
        let mut limits = base();
        limits.machine.actuators["drive"].limit_n = Some(12.0);
        limits.machine.actuators["drive"].rate_limit_per_s = Some(4e3);
        let mut hertz = base();
        let tool = &mut hertz.machine.contacts["tool"];
        *tool = Contact { law: ContactLaw::Hertz, stiffness: 2e7, ..tool.clone() };
        let mut hunt_crossley = base();
        let tool = &mut hunt_crossley.machine.contacts["tool"];
        *tool = Contact {
            law: ContactLaw::HuntCrossley { alpha_s_per_m: 3.0, exponent: 1.5 },
            stiffness: 2e7,
            ..tool.clone()
        };
        let mut stribeck = base();
        stribeck.machine.springs["guide"].effects.push(effect("stribeck-friction", &[3.0, 6.0, 5e-3]));
        let mut lugre = base();
        lugre.machine.springs["guide"].effects.push(effect("lugre-friction", &[1e5, 300.0, 3.0, 6.0, 5e-3]));
        let mut sensors = base();
        sensors.machine.sensors["force"].noise = 0.5;
        sensors.machine.sensors["force"].delay_s = 0.37e-3;
        sensors.machine.sensors["force"].resolution = Some(0.1);
        sensors.controllers["force"].spec.delay_s = 0.4e-3;
        sensors.controllers["force"].spec.jitter_s = 5e-5;
        // Signals on the way between samples: in one part of the interval, and in one of several.
        let mut late = base();
        late.machine.sensors["force"].delay_s = 0.37e-3;
        let mut stiff = late.clone();
        stiff.machine.contacts["tool"].stiffness = 2e8;
        let cases = [friction, play, limits, hertz, hunt_crossley, stribeck, lugre, sensors, late, stiff];
        let names = [
            "friction",
            "play",
            "limits",
            "hertz",
            "hunt-crossley",
            "stribeck",
            "lugre",
            "sensors",
            "late",
            "stiff",
        ];
        for (what, base) in names.iter().zip(cases) {
            let vary = |scenario: &mut Scenario, factor: f64| {
                kp(scenario, factor);
                scenario.machine.contacts["tool"].stiffness *= factor;
                scenario.machine.bodies["motor"].mass_kg /= factor;
                for effect in scenario.machine.springs.values_mut().flat_map(|spring| &mut spring.effects) {
                    effect.values[0] *= factor;
                }
            };
            alike(&format!("{what}, {name}"), &variants(&base, vary));
        }
    }
}

/// Half of the lanes are removed in the middle of the run: they keep their state, and the others continue as
/// if alone.
#[test]
fn prop_lanes_that_are_stopped_leave_the_others_their_bits() {
    for (integrator, name) in Integrator::ALL {
        let mut base = reference_machine(2, 0.2);
        base.run.integrator = integrator;
        let scenarios = variants(&base, kp);
        let mut simulation = Simulation::<Pack<8>>::new(
            scenarios.iter().map(|scenario| Program::new(scenario).unwrap()).collect(),
        )
        .unwrap();
        simulation.run_to(0.1, &mut Unobserved).unwrap();
        let states: Vec<Vec<f64>> = (0..8).map(|l| simulation.state(l)).collect();
        (0..8).step_by(2).for_each(|l| simulation.stop(l));
        simulation.run_to(0.2, &mut Unobserved).unwrap();
        for (l, scenario) in scenarios.iter().enumerate() {
            if l % 2 == 0 {
                assert_eq!(simulation.state(l), states[l], "{name}, lane {l}");
                assert!(
                    matches!(simulation.end(l), Some(RunEnd::Stopped { t_s }) if (t_s - 0.1).abs() < 1e-12),
                    "{name}, lane {l}"
                );
            } else {
                let (_, alone) = run_lanes::<f64>(std::slice::from_ref(scenario));
                let bits: Vec<u64> = simulation.state(l).iter().map(|x| x.to_bits()).collect();
                assert_eq!(bits, alone[0], "{name}, lane {l}");
                assert_eq!(simulation.end(l), Some(RunEnd::Completed));
            }
        }
    }
}

#[test]
fn prop_run_twice_gives_the_same_bits() {
    for masses in [1, 4] {
        let mut scenario = reference_machine(masses, 0.2);
        scenario.machine.sensors["force"].noise = 0.3;
        scenario.controllers["force"].spec.jitter_s = 1e-5;
        let ((first, _), (second, _)) = (run(&scenario), run(&scenario));
        assert!(first.t_s == second.t_s && first.events == second.events && first.columns == second.columns);
    }
}

/// A run that is divided at instants at which an action is due has the same steps.
#[test]
fn prop_run_in_slices_gives_the_same_bits() {
    for (integrator, _) in Integrator::ALL {
        let mut scenarios = vec![reference_machine(2, 0.2), axis(0.2)];
        scenarios[1].machine.springs["guide"].effects.push(effect("stribeck-friction", &[3.0, 6.0, 5e-3]));
        for mut scenario in scenarios {
            scenario.run.integrator = integrator;
            let (whole, reference) = run(&scenario);
            for slice_s in [1e-3, 7e-3, 0.05] {
                let program = Program::new(&scenario).unwrap();
                let mut trace = Trace::new(program.record_names());
                let mut simulation = Simulation::<f64>::new(vec![program]).unwrap();
                let slices = (scenario.run.duration_s / slice_s).ceil() as u32;
                for slice in 1..=slices {
                    simulation
                        .run_to((f64::from(slice) * slice_s).min(scenario.run.duration_s), &mut trace)
                        .unwrap();
                }
                assert_eq!(simulation.state(0), reference.state(0));
                assert_eq!(trace, whole);
                assert_eq!(simulation.energy(0), reference.energy(0));
            }
        }
    }
}
