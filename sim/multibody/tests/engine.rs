//! Rapier against this project's own semi-implicit Euler, and against properties of every engine.

#![expect(clippy::unwrap_used, reason = "helpers of tests fail as tests do")]

use feeler_control::{ControllerSpec, Law, ReferenceSpec};
use feeler_engine::{
    BodyEngine, ControllerUse, EngineError, Integrator, Program, RunEnd, RunSettings, Scenario, Simulation,
    Trace, Unobserved,
};
use feeler_multibody::RapierBodies;
use feeler_plant::description::{
    Actuator, ActuatorKind, Axis, Body, Contact, ContactLaw, GROUND, Machine, Quantity, SignalName, Spring,
};
use feeler_plant::effects::{self, EffectUse};

/// Rounding of some 1e4 steps of a few operations each, amplified by an impact.
const ROUNDING: f64 = 1e-9;

/// Motor and tip on a flexible base, with dry friction in the guide, thrown against the ground.
fn machine() -> Machine {
    let mut machine = Machine::default();
    let friction = EffectUse { definition: effects::find("coulomb-friction").unwrap(), values: vec![5.0] };
    let mut body = |name: &str, mass_kg: f64, velocity_m_per_s: f64| {
        machine.bodies.insert(name.into(), Body { mass_kg, velocity_m_per_s, ..Body::default() });
    };
    body("base", 50.0, 0.0);
    body("motor", 3.0, 0.2);
    body("tip", 2.0, 0.2);
    body("flange", 0.5, 0.2);
    let mut spring = |name: &str, between: [&str; 2], k: f64, c: f64, effects: Vec<EffectUse>| {
        let rigid = name == "joint";
        let between = between.map(Into::into);
        machine.springs.insert(
            name.into(),
            Spring { between, stiffness_n_per_m: k, damping_n_s_per_m: c, rigid, effects },
        );
    };
    spring("mount", [GROUND, "base"], 2e5, 100.0, Vec::new());
    spring("guide", ["base", "motor"], 0.0, 20.0, vec![friction]);
    spring("transmission", ["motor", "tip"], 1e5, 30.0, Vec::new());
    spring("joint", ["tip", "flange"], 0.0, 0.0, Vec::new());
    let contact =
        Contact { law: ContactLaw::Hertz, gap_m: 1e-3, ..Contact::kelvin_voigt("flange", GROUND, 1e6, 0.0) };
    machine.contacts.insert("tool".into(), contact);
    machine
}

/// One free body.
fn flywheel(speed: f64) -> Machine {
    let mut machine = Machine { axis: Axis::Rotational, ..Machine::default() };
    machine.bodies.insert(
        "wheel".into(),
        Body { mass_kg: 0.02, velocity_m_per_s: speed, position_m: -1.0, ..Body::default() },
    );
    machine.springs.insert(
        "bearing".into(),
        Spring { between: [GROUND.into(), "wheel".into()], damping_n_s_per_m: 0.01, ..Spring::default() },
    );
    machine
}

fn scenario(machine: Machine, integrator: Integrator, step_s: f64, duration_s: f64) -> Scenario {
    let record = machine
        .bodies
        .keys()
        .flat_map(|name| [Quantity::Position, Quantity::Velocity].map(|q| SignalName::new(name, q)))
        .collect();
    let run = RunSettings {
        duration_s,
        step_s,
        integrator,
        record,
        record_rate_hz: Some(1e3),
        ..RunSettings::default()
    };
    Scenario { machine, controllers: [].into_iter().collect(), run }
}

fn run(scenario: &Scenario) -> (Trace, Option<RunEnd>) {
    let program = Program::new(scenario).unwrap();
    let mut trace = Trace::new(program.record_names());
    let bodies = (scenario.run.integrator == Integrator::External)
        .then(|| Box::new(RapierBodies::new(program.motion(), scenario.machine.axis)) as Box<dyn BodyEngine>);
    let mut simulation = Simulation::<f64>::with_bodies(vec![program], bodies.into_iter().collect()).unwrap();
    simulation.run(&mut trace).unwrap();
    (trace, simulation.end(0))
}

/// Largest difference of two traces, each column over its largest value.
fn apart(a: &Trace, b: &Trace) -> f64 {
    let column = |(a, b): (&Vec<f64>, &Vec<f64>)| {
        let size = a.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / size
    };
    assert_eq!(a.t_s.len(), b.t_s.len());
    a.columns.iter().zip(&b.columns).map(column).fold(0.0, f64::max)
}

#[test]
fn reference_rapier_is_semi_implicit_euler_to_rounding() {
    let [own, other] = [Integrator::SemiImplicitEuler, Integrator::External]
        .map(|integrator| run(&scenario(machine(), integrator, 1e-4, 0.4)));
    assert_eq!((own.1, other.1), (Some(RunEnd::Completed), Some(RunEnd::Completed)));
    let events =
        |trace: &Trace| trace.events.iter().map(|event| (event.kind, event.switch)).collect::<Vec<_>>();
    assert!(own.0.events.len() >= 4, "touch, lift, slip and stick: {:?}", own.0.events);
    assert_eq!(events(&own.0), events(&other.0));
    assert!(apart(&own.0, &other.0) < ROUNDING, "{}", apart(&own.0, &other.0));
}

#[test]
fn reference_the_step_follows_late_and_jittery_commands() {
    let mut given = [Integrator::SemiImplicitEuler, Integrator::External]
        .map(|integrator| scenario(machine(), integrator, 1e-4, 0.2));
    for scenario in &mut given {
        let kind = ActuatorKind::VelocitySource { damping_n_s_per_m: 300.0, time_constant_s: 2e-3 };
        let drive = Actuator { kind, limit_n: Some(40.0), ..Actuator::ideal("motor", "base") };
        scenario.machine.actuators.insert("drive".into(), drive);
        let mut spec = ControllerSpec::new(Law::OpenLoop, 1e-3);
        (spec.delay_s, spec.jitter_s) = (0.37e-3, 1e-4);
        spec.reference = ReferenceSpec::PiecewiseLinear(vec![(0.0, 0.0), (0.2, 0.5)]);
        let used =
            ControllerUse { spec, reads: None, motion: None, drives: "drive".into(), effects: Vec::new() };
        scenario.controllers.insert("excite".into(), used);
    }
    let [own, other] = given.map(|scenario| run(&scenario).0);
    assert!(apart(&own, &other) < ROUNDING, "{}", apart(&own, &other));
}

#[test]
fn truth_a_wheel_turns_through_many_circles() {
    let (trace, _) = run(&scenario(flywheel(50.0), Integrator::External, 1e-4, 1.0));
    // v = v0 exp(-t/T), angle = -1 + v0 T (1 - exp(-t/T)), T = J/b = 2 s.
    let (speed, time_s) = (50.0, 2.0);
    let at = |t: f64| -1.0 + speed * time_s * (1.0 - f64::exp(-t / time_s));
    let worst = trace.t_s.iter().zip(&trace.columns[0]).map(|(t, x)| (x - at(*t)).abs()).fold(0.0, f64::max);
    // Error of a first-order integrator: half a step times `v0 (t / T)^2`, and half a step times v.
    assert!(worst < 1e-4 * speed, "{worst}");
    assert!(trace.columns[0][1000] > 6.0 * std::f64::consts::TAU);
}

#[test]
fn truth_a_turn_too_large_for_one_step_is_refused_with_the_step_that_does() {
    // 800 rad/s in steps of 10 ms are 8 rad. An eighth of a turn at 800 rad/s takes 0.98 ms, and friction has
    // slowed the wheel slightly.
    let scenario = scenario(flywheel(800.0), Integrator::External, 1e-2, 1.0);
    let program = Program::new(&scenario).unwrap();
    let bodies: Box<dyn BodyEngine> = Box::new(RapierBodies::new(program.motion(), scenario.machine.axis));
    let mut simulation = Simulation::<f64>::with_bodies(vec![program], vec![bodies]).unwrap();
    let error = simulation.run_to(1.0, &mut Unobserved).unwrap_err();
    let EngineError::Problems { problems } = &error else { panic!("{error:?}") };
    assert_eq!((problems.len(), problems[0].key.as_str()), (1, "run.step"));
    assert!(problems[0].message.contains("at most 0.785 rad per step"), "{}", problems[0].message);
    assert!(problems[0].remedy.contains("to 9.8"), "{:?}", problems[0].remedy);
}

#[test]
fn truth_engines_and_variants_must_be_as_many() {
    let program = |integrator| Program::new(&scenario(machine(), integrator, 1e-4, 0.1)).unwrap();
    let missing = Simulation::<f64>::new(vec![program(Integrator::External)]).unwrap_err();
    assert_eq!(missing, EngineError::BodyEngines { given: 0, needed: 1 });
    let exact = program(Integrator::Exact);
    let bodies: Box<dyn BodyEngine> = Box::new(RapierBodies::new(exact.motion(), Axis::Translational));
    let idle = Simulation::<f64>::with_bodies(vec![exact], vec![bodies]).unwrap_err();
    assert_eq!(idle, EngineError::BodyEngines { given: 1, needed: 0 });
}
