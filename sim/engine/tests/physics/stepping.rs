//! A program that steps the simulation itself gets the same numbers as a run.

use feeler_control::{ForceGains, Law, ReferenceSpec};
use feeler_engine::{
    Event, EventKind, Integrator, Observer, Program, RunSettings, Scenario, Simulation, Stop, Trace,
};
use feeler_lanes::{Lane, Pack};
use feeler_plant::description::{Contact, ContactLaw, GROUND};

use crate::common::{axis, command, contact, drive, effect, free_mass, reference_machine, run, scenario};

/// Tolerance of an instant that closed forms and event location both give to machine precision, s.
const INSTANT_S: f64 = 1e-12;

/// Relative to the energy exchanged: closure of the ledger over some impacts.
const LEDGER: f64 = 1e-9;

/// Number of stops of a loop for each reason.
#[derive(Debug, Default)]
struct Stops {
    events: usize,
    samples: usize,
    records: usize,
}

/// Steps through a run and passes everything to an observer. If `cuts` is not empty, the requested end takes
/// these values first.
fn step_through<L: Lane>(
    simulation: &mut Simulation<L>,
    observer: &mut impl Observer<L>,
    cuts_s: &[f64],
    duration_s: f64,
) -> Stops {
    let mut stops = Stops::default();
    let mut ends_s = cuts_s.iter().copied().chain([duration_s]).peekable();
    while let Some(&until_s) = ends_s.peek() {
        match simulation.step_to(until_s).unwrap() {
            Stop::Event { lane, event } => {
                stops.events += 1;
                observer.event(lane, &event);
            }
            Stop::Sample => stops.samples += 1,
            Stop::Record => {
                stops.records += 1;
                observer.record(simulation.time_s(), simulation.recorded());
            }
            Stop::End => {
                ends_s.next();
            }
        }
    }
    stops
}

/// Times, columns and events of a trace, numbers by their bits.
type Bits = (Vec<u64>, Vec<Vec<u64>>, Vec<(u64, Event)>);

fn bits(trace: &Trace) -> Bits {
    let of = |values: &Vec<f64>| values.iter().map(|x| x.to_bits()).collect();
    let events = trace.events.iter().map(|event| (event.t_s.to_bits(), *event)).collect();
    (of(&trace.t_s), trace.columns.iter().map(of).collect(), events)
}

fn stepped(scenario: &Scenario) -> (Trace, Simulation<f64>, Stops) {
    let program = Program::new(scenario).unwrap();
    let mut trace = Trace::new(program.record_names());
    let mut simulation = Simulation::new(vec![program]).unwrap();
    let stops = step_through(&mut simulation, &mut trace, &[], scenario.run.duration_s);
    (trace, simulation, stops)
}

fn with_run(scenario: Scenario, change: impl Fn(&mut RunSettings)) -> Scenario {
    let mut scenario = scenario;
    change(&mut scenario.run);
    scenario
}

/// Machines that touch, lift, stick, slip and ramp, with delays and nonlinear laws, with and without the
/// ledger, in every integrator.
fn machines() -> Vec<(&'static str, Scenario)> {
    let mut chattering = axis(0.2);
    chattering.controllers[0].spec.delay_s = 2.3e-3;
    let mut sticking = axis(0.2);
    sticking.machine.springs["guide"].effects.push(effect("coulomb-friction", &[8.0]));
    sticking.machine.springs["transmission"].effects.push(effect("backlash", &[1e-4, 0.0, 0.0]));
    let mut late = axis(0.2);
    late.machine.sensors["force"].effects.push(effect("force-delay", &[1.7e-3]));
    late.machine.actuators["drive"].effects.push(effect("slew-limit", &[2e3]));
    let mut earlier = axis(0.2);
    earlier.machine.sensors["force"].delay_s = 0.4e-3;
    let mut hertzian = axis(0.1);
    let tool = hertzian.machine.contacts["tool"].clone();
    let hertz = Contact { law: ContactLaw::Hertz, stiffness: 1e8, ..tool };
    hertzian.machine.contacts.insert("tool".into(), hertz);
    vec![
        ("M4", with_run(reference_machine(4, 0.3), |run| run.peaks = true)),
        ("M2 with its ledger", with_run(reference_machine(2, 0.3), |run| run.energy = true)),
        ("M2 by RK4", with_run(reference_machine(2, 0.3), |run| run.integrator = Integrator::Rk4)),
        ("a late controller", with_run(chattering, |run| run.energy = false)),
        ("friction and play", sticking),
        ("a late sensor and a slow drive", late),
        ("a signal between samples", with_run(earlier, |run| run.energy = false)),
        ("a Hertzian contact", hertzian),
    ]
}

#[test]
fn prop_steps_give_the_bits_of_a_run() {
    for (what, scenario) in machines() {
        let (whole, run) = run(&scenario);
        let (trace, simulation, stops) = stepped(&scenario);
        assert!(whole.events.len() > 2, "{what}: {} events", whole.events.len());
        assert_eq!(bits(&trace), bits(&whole), "{what}");
        assert_eq!(simulation.energy(0), run.energy(0), "{what}");
        assert_eq!(simulation.peaks(0), run.peaks(0), "{what}");
        assert_eq!(simulation.steps(), run.steps(), "{what}");
        assert_eq!([stops.events, stops.records], [whole.events.len(), whole.t_s.len()], "{what}");
        let period_s = scenario.controllers[0].spec.period_s;
        assert_eq!(stops.samples, (scenario.run.duration_s / period_s).round() as usize + 1, "{what}");
    }
}

/// Keeps the result of every lane.
struct Traces(Vec<Trace>);

impl<L: Lane> Observer<L> for Traces {
    fn record(&mut self, t_s: f64, values: &[L]) {
        for (l, trace) in self.0.iter_mut().enumerate() {
            let own: Vec<f64> = values.iter().map(|value| value.lane(l)).collect();
            Observer::<f64>::record(trace, t_s, &own);
        }
    }

    fn event(&mut self, lane: usize, event: &Event) {
        Observer::<f64>::event(&mut self.0[lane], 0, event);
    }
}

#[test]
fn prop_steps_of_eight_variants_give_the_bits_of_their_run() {
    let variants = (0..8).map(|i| {
        let mut scenario = with_run(axis(0.2), |run| run.energy = false);
        scenario.machine.contacts["tool"].gap_m = 1e-4 * f64::from(i);
        let gains = ForceGains { feed_forward: 1.0, kp: 1.0 + f64::from(i), ..ForceGains::default() };
        scenario.controllers[0].spec.law = Law::ExplicitForce(gains);
        Program::new(&scenario).unwrap()
    });
    let programs: Vec<Program> = variants.collect();
    let give = |go: &dyn Fn(&mut Simulation<Pack<8>>, &mut Traces)| {
        let mut traces = Traces(vec![Trace::new(programs[0].record_names()); 8]);
        go(&mut Simulation::new(programs.clone()).unwrap(), &mut traces);
        traces.0
    };
    let whole = give(&|simulation, traces| simulation.run(traces).unwrap());
    let stepped = give(&|simulation, traces| {
        step_through(simulation, traces, &[], 0.2);
    });
    let events: usize = whole.iter().map(|trace| trace.events.len()).sum();
    assert!(events > 20, "{events} events");
    for (l, (stepped, whole)) in stepped.iter().zip(&whole).enumerate() {
        assert_eq!(bits(stepped), bits(whole), "lane {l}");
    }
}

/// A body of 1 kg, 0.1 m from a wall, pushed towards it with 9.81 N.
fn falling() -> Scenario {
    let mut machine = free_mass(1.0, -0.1, 0.0);
    machine.contacts.insert("floor".into(), contact("tip", GROUND, 1e5, 0.0));
    machine.actuators.insert("drive".into(), drive("tip", GROUND));
    let mut scenario = scenario(machine, 0.6, &["floor.force"]);
    command(&mut scenario, "weight", ReferenceSpec::Constant(9.81), 1e-3);
    scenario
}

#[test]
fn truth_a_lane_stands_at_its_event() {
    let program = Program::new(&falling()).unwrap();
    let mut simulation = Simulation::<f64>::new(vec![program]).unwrap();
    let event = loop {
        match simulation.step_to(0.6).unwrap() {
            Stop::Event { event, .. } => break event,
            Stop::End => panic!("it never touched"),
            _ => {}
        }
    };
    let falls_s = (2.0 * 0.1 / 9.81_f64).sqrt();
    assert_eq!(event.kind, EventKind::Touch);
    assert!((event.t_s - falls_s).abs() < INSTANT_S);
    assert_eq!(simulation.lane_time_s(0).to_bits(), event.t_s.to_bits());
    assert!(simulation.time_s() < event.t_s && event.t_s - simulation.time_s() < 1e-3);
    let [position_m, speed_m_per_s] = [0, 1].map(|i| simulation.state(0)[i]);
    assert!(position_m.abs() < INSTANT_S);
    assert!((speed_m_per_s - 9.81 * falls_s).abs() < 9.81 * INSTANT_S);
}

#[test]
fn truth_a_state_set_at_an_event_goes_on_from_there() {
    // The body leaves the wall with half its speed, so it returns after twice the time in which the force
    // removes that speed.
    let program = Program::new(&falling()).unwrap();
    let mut simulation = Simulation::<f64>::new(vec![program]).unwrap();
    let mut touches_s = Vec::new();
    while touches_s.len() < 2 {
        match simulation.step_to(0.6).unwrap() {
            Stop::Event { lane, event } if event.kind == EventKind::Touch => {
                touches_s.push(event.t_s);
                let [position_m, speed_m_per_s] = [0, 1].map(|i| simulation.state(lane)[i]);
                simulation.set_state(lane, &[position_m.min(0.0), -0.5 * speed_m_per_s]).unwrap();
            }
            Stop::End => panic!("it never came back"),
            _ => {}
        }
    }
    let falls_s = (2.0 * 0.1 / 9.81_f64).sqrt();
    assert!((touches_s[1] - 2.0 * falls_s).abs() < INSTANT_S, "{touches_s:?}");
}

#[test]
fn prop_an_interval_that_was_interrupted_is_finished_whatever_is_asked_for_next() {
    let scenario = with_run(reference_machine(2, 0.3), |run| run.energy = true);
    let (whole, _) = run(&scenario);
    let touch_s = whole.events[0].t_s;
    let program = Program::new(&scenario).unwrap();
    let mut trace = Trace::new(program.record_names());
    let mut simulation = Simulation::new(vec![program]).unwrap();
    step_through(&mut simulation, &mut trace, &[touch_s + 1e-5], touch_s + 1e-4);
    assert!(simulation.time_s() >= touch_s + 1e-4);
    simulation.run_to(0.3, &mut trace).unwrap();
    let energy = simulation.energy(0).unwrap();
    assert!(energy.residual().abs() < LEDGER * energy.exchanged());
    assert_eq!(trace.t_s, whole.t_s);
}
