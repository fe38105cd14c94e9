//! Helpers for short machine definitions: parts, the reference machines M1, M2 and M4 (see the README of the
//! reference numbers), and their runs.

use std::io::Write as _;
use std::path::PathBuf;

use feeler_control::{ControllerSpec, ForceGains, Law, ReferenceSpec};
use feeler_engine::{ControllerUse, Program, RunSettings, Scenario, Simulation, Trace};
use feeler_plant::description::{
    Actuator, Body, Contact, GROUND, Machine, Quantity, Sensor, SignalName, Spring,
};
use feeler_plant::effects::{self, EffectUse};

pub(crate) fn body(mass_kg: f64, position_m: f64) -> Body {
    Body::new(mass_kg).at(position_m)
}

pub(crate) fn spring(a: &str, b: &str, k: f64, c: f64) -> Spring {
    Spring::new(a, b, k, c)
}

pub(crate) fn contact(tip: &str, work: &str, stiffness: f64, damping: f64) -> Contact {
    Contact::kelvin_voigt(tip, work, stiffness, damping)
}

pub(crate) fn drive(on: &str, reacts_on: &str) -> Actuator {
    Actuator::ideal(on, reacts_on)
}

pub(crate) fn sensor(element: &str, quantity: Quantity) -> Sensor {
    Sensor::ideal(SignalName::new(element, quantity))
}

/// An effect of the library; optional values may be omitted.
pub(crate) fn effect(kind: &str, values: &[f64]) -> EffectUse {
    let definition = effects::find(kind).unwrap();
    let left_out = definition.parameters.iter().skip(values.len()).filter_map(|parameter| parameter.default);
    EffectUse { definition, values: values.iter().copied().chain(left_out).collect() }
}

/// One body, `tip`, of this mass, position and speed.
pub(crate) fn free_mass(mass_kg: f64, position_m: f64, velocity_m_per_s: f64) -> Machine {
    Machine::default().with_body("tip", Body { velocity_m_per_s, ..body(mass_kg, position_m) })
}

/// A run without controllers that keeps the energy ledger.
pub(crate) fn scenario(machine: Machine, duration_s: f64, record: &[&str]) -> Scenario {
    let record = record.iter().map(|name| name.parse().unwrap()).collect();
    let run = RunSettings { duration_s, step_s: 1e-3, record, energy: true, ..RunSettings::default() };
    Scenario { run, ..Scenario::new(machine) }
}

/// Adds an open-loop controller that gives the drive `drive` the reference every `period_s`.
pub(crate) fn command(scenario: &mut Scenario, name: &str, reference: ReferenceSpec, period_s: f64) {
    let mut spec = ControllerSpec::new(Law::OpenLoop, period_s);
    spec.reference = reference;
    scenario.controllers.insert(name.into(), ControllerUse::new(spec, "drive"));
}

/// Adds explicit force control of the drive `drive` by the sensor `force`.
pub(crate) fn force_control(scenario: &mut Scenario, gains: ForceGains, period_s: f64, force_n: f64) {
    let mut spec = ControllerSpec::new(Law::ExplicitForce(gains), period_s);
    spec.reference = ReferenceSpec::Constant(force_n);
    scenario.controllers.insert("force".into(), ControllerUse::new(spec, "drive").reading("force"));
}

/// The axis for effects, in a force loop at 1 kHz with a 20 N reference. A motor (7 kg) on a guide, a
/// transmission, and a tip (5 kg) 0.2 mm from a wall.
pub(crate) fn axis(duration_s: f64) -> Scenario {
    let mut machine = Machine::default();
    machine.bodies.insert("motor".into(), body(7.0, 0.0));
    machine.bodies.insert("tip".into(), body(5.0, 0.0));
    machine.springs.insert("guide".into(), spring(GROUND, "motor", 0.0, 60.0));
    machine.springs.insert("transmission".into(), spring("motor", "tip", 1.2e6, 120.0));
    machine.contacts.insert("tool".into(), Contact { gap_m: 2e-4, ..contact("tip", GROUND, 2e5, 120.0) });
    machine.actuators.insert("drive".into(), drive("motor", GROUND));
    machine.sensors.insert("force".into(), sensor("tool", Quantity::Force));
    machine.sensors.insert("encoder".into(), sensor("motor", Quantity::Position));
    let names = [
        "tool.force",
        "tip.position",
        "tip.velocity",
        "motor.position",
        "motor.velocity",
        "drive.force",
        "force.reading",
    ];
    let mut scenario = scenario(machine, duration_s, &names);
    let gains = ForceGains { feed_forward: 1.0, kp: 0.3, damping: 100.0, ..ForceGains::default() };
    force_control(&mut scenario, gains, 1e-3, 20.0);
    scenario
}

/// M1, M2 or M4 for `duration_s`, its record every 0.1 ms.
pub(crate) fn reference_machine(masses: u32, duration_s: f64) -> Scenario {
    let mut machine = Machine::new(format!("M{masses}"));
    let start = -5e-3;
    let (mut guide, mut work) = (GROUND, GROUND);
    let mut motor = "tip";
    if masses == 4 {
        machine.bodies.insert("base".into(), body(200.0, 0.0));
        machine.springs.insert("mount".into(), spring(GROUND, "base", 1.1e6, 600.0));
        (guide, work) = ("base", "workpiece");
    }
    if masses == 1 {
        machine.bodies.insert("tip".into(), body(10.0, start));
    } else {
        machine.bodies.insert("motor".into(), body(6.0, start));
        machine.bodies.insert("tip".into(), body(4.0, start));
        machine.springs.insert("transmission".into(), spring("motor", "tip", 4e5, 60.0));
        motor = "motor";
    }
    if masses == 4 {
        machine.bodies.insert("workpiece".into(), body(5.0, 0.0));
        machine.springs.insert("fixture".into(), spring("base", "workpiece", 1e6, 200.0));
    }
    machine.springs.insert("guide".into(), spring(guide, motor, 0.0, 50.0));
    machine.contacts.insert("tool".into(), contact("tip", work, 1e5, 100.0));
    machine.actuators.insert("drive".into(), drive(motor, guide));
    machine.sensors.insert("force".into(), sensor("tool", Quantity::Force));
    let gains = ForceGains { feed_forward: 1.0, kp: 2.0, ..ForceGains::default() };
    let mut spec = ControllerSpec::new(Law::ExplicitForce(gains), 1e-3);
    spec.output_limit = Some(200.0);
    spec.reference = ReferenceSpec::Constant(20.0);
    let record = ["tool.force", "tip.position", "tip.velocity", "drive.command"]
        .iter()
        .map(|name| name.parse().unwrap())
        .collect();
    let run = RunSettings { duration_s, record, ..RunSettings::default() };
    let controller = ControllerUse::new(spec, "drive").reading("force");
    Scenario { run, ..Scenario::new(machine).with_controller("force", controller) }
}

/// Runs a scenario on one lane and gives its trace and simulation.
pub(crate) fn run(scenario: &Scenario) -> (Trace, Simulation<f64>) {
    let program = Program::new(scenario).unwrap();
    let mut trace = Trace::new(program.record_names());
    let mut simulation = Simulation::new(vec![program]).unwrap();
    simulation.run(&mut trace).unwrap();
    (trace, simulation)
}

/// A file of the reference numbers, or `None` with a message if it is absent.
pub(crate) fn reference_file(name: &str) -> Option<String> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/reference").join(name);
    let text = std::fs::read_to_string(&path).ok();
    if text.is_none() {
        // Not by the error macro, whose output a passing test hides.
        let _ = writeln!(std::io::stderr(), "skipped: {} is absent", path.display());
    }
    text
}

/// The largest difference of two columns.
pub(crate) fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Asserts `|value - expected| <= tolerance`.
#[track_caller]
pub(crate) fn close(value: f64, expected: f64, tolerance: f64) {
    assert!(
        (value - expected).abs() <= tolerance,
        "{value} is {:.2e} off {expected}, allowed {tolerance:.1e}",
        (value - expected).abs()
    );
}
