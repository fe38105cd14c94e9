//! Machines of many parts: loops of springs, rigid groups, several contacts, several controllers.

use feeler_control::{ForceGains, ReferenceSpec};
use feeler_engine::Scenario;
use feeler_plant::description::{Axis, Body, Contact, GROUND, Quantity, Spring};

use crate::common::{
    axis, body, close, command, contact, drive, force_control, free_mass, largest_difference,
    reference_machine, run,
};
use crate::common::{scenario, sensor, spring};

/// Runs with different steps agree to roundings, which impacts amplify a few times.
const ROUNDING: f64 = 1e-11;

fn columns_agree(a: &Scenario, b: &Scenario, names: &[&str]) {
    let ((first, _), (second, _)) = (run(a), run(b));
    for name in names {
        let (x, y) = (first.column(name).unwrap(), second.column(name).unwrap());
        let size = x.iter().fold(1e-3, |size: f64, x| size.max(x.abs()));
        assert!(x.iter().any(|x| *x != 0.0), "{name} is idle");
        close(largest_difference(x, y), 0.0, ROUNDING * size);
    }
}

/// Two parallel springs, or a loop of three, equal their combined spring; so do two in series through a rigid
/// joint.
#[test]
fn truth_springs_in_parallel_and_in_a_loop_add() {
    let base = axis(0.2);
    let mut parallel = base.clone();
    parallel.machine.springs["transmission"] = spring("motor", "tip", 0.5e6, 100.0);
    parallel.machine.springs.insert("beside".into(), spring("tip", "motor", 0.7e6, 20.0));
    columns_agree(&base, &parallel, &["tool.force", "tip.position", "motor.velocity"]);
    // A loop ground - motor - tip - ground, compared with one spring to ground on each body.
    let mut guided = base.clone();
    guided.machine.springs.insert("left".into(), spring(GROUND, "motor", 3e3, 0.0));
    guided.machine.springs.insert("right".into(), spring("tip", GROUND, 5e3, 0.0));
    let mut split = guided.clone();
    split.machine.springs["right"] = spring(GROUND, "tip", 2e3, 0.0);
    split.machine.springs.insert("other".into(), spring("tip", GROUND, 3e3, 0.0));
    columns_agree(&guided, &split, &["tool.force", "tip.position", "motor.velocity"]);
}

/// Rigidly joined bodies move as one with their total mass, each at its own position. Any element may attach
/// to any of them.
#[test]
fn truth_rigid_groups_are_one_mass() {
    let base = reference_machine(1, 0.2);
    let mut group = base.clone();
    let parts = [("flange", 3.0, 0.4), ("sensor", 2.0, -0.3)];
    group.machine.bodies["tip"].mass_kg = 5.0;
    let rigid = |a: &str, b: &str| Spring { between: [a.into(), b.into()], rigid: true, ..Spring::default() };
    for (name, mass, place) in parts {
        group.machine.bodies.insert(name.into(), body(mass, place));
    }
    group.machine.springs.insert("first".into(), rigid("flange", "tip"));
    group.machine.springs.insert("second".into(), rigid("sensor", "flange"));
    group.machine.springs["guide"] = spring(GROUND, "sensor", 0.0, 50.0);
    group.machine.actuators["drive"] = drive("flange", GROUND);
    // The sensor body is 0.295 m behind the tip (-0.3 m against -5 mm), so its wall is closer by that amount.
    group.machine.contacts["tool"] = Contact { gap_m: -0.295, ..contact("sensor", GROUND, 1e5, 100.0) };
    group.run.record.push("flange.position".parse().unwrap());
    columns_agree(&base, &group, &["tool.force", "tip.position", "tip.velocity", "drive.command"]);
    let (trace, _) = run(&group);
    for (tip, flange) in
        trace.column("tip.position").unwrap().iter().zip(trace.column("flange.position").unwrap())
    {
        close(flange - tip, 0.405, ROUNDING);
    }
}

/// Two walls of half the stiffness equal one, and a second wall farther away is met separately.
#[test]
fn truth_contacts_beside_each_other_add() {
    let base = reference_machine(2, 0.2);
    let mut two = base.clone();
    for name in ["tool", "other"] {
        two.machine.contacts.insert(name.into(), contact("tip", GROUND, 5e4, 50.0));
    }
    two.machine.sensors["force"].gain = 2.0;
    columns_agree(&base, &two, &["tip.position", "tip.velocity", "drive.command"]);
    let mut stages = free_mass(1.0, 0.0, 1.0);
    stages.contacts.insert("soft".into(), contact("tip", GROUND, 1e4, 0.0));
    stages.contacts.insert("hard".into(), Contact { gap_m: 5e-3, ..contact("tip", GROUND, 3e4, 0.0) });
    let (trace, simulation) = run(&scenario(stages, 0.1, &[]));
    // Touch the soft wall at 0, the hard one on the sine of the soft one. Leave each at zero compression with
    // the speed of arrival.
    let omega = 100.0_f64;
    let to_hard = (5e-3 * omega).asin() / omega;
    close(trace.events[1].t_s, to_hard, ROUNDING);
    let speed = (omega * to_hard).cos();
    // Beyond: m d'' = -4e4 d - 1e4 * 5e-3, whose amplitude about its centre and duration follow.
    let (both, centre) = (200.0_f64, -1.25e-3);
    let quarter = (speed / both).atan2(-centre) / both;
    close(trace.events[2].t_s - trace.events[1].t_s, 2.0 * quarter, ROUNDING);
    close(trace.events[3].t_s, 2.0 * (to_hard + quarter), ROUNDING);
    close(simulation.state(0)[1], -1.0, ROUNDING);
}

/// Controllers at rates without a common period act each at their own instants: on a free mass the sum of
/// their impulses is known.
#[test]
fn truth_several_controllers_at_incommensurate_rates_add() {
    let mut machine = free_mass(2.0, 0.0, 0.0);
    machine.actuators.insert("drive".into(), drive("tip", GROUND));
    let mut many = scenario(machine, 0.5, &["tip.velocity", "drive.command"]);
    let rates = [
        ("first", 1e-3 * std::f64::consts::E, 0.0),
        ("second", 1e-3 * std::f64::consts::PI, 1.3e-4),
        ("third", 7e-4, 5e-3),
    ];
    for (name, period_s, offset_s) in rates {
        command(&mut many, name, ReferenceSpec::PiecewiseLinear(vec![(0.0, 0.0), (1.0, 10.0)]), period_s);
        many.controllers[name].spec.offset_s = offset_s;
    }
    let (trace, simulation) = run(&many);
    for (t, v) in trace.t_s.iter().zip(trace.column("tip.velocity").unwrap()) {
        let impulse = |(_, period, offset): &(&str, f64, f64)| {
            // Held values 10 (offset + k T) over whole periods, and the last one over the rest of its period.
            let whole = ((t - offset) / period).floor().max(-1.0);
            if whole < 0.0 {
                return 0.0;
            }
            let last = offset + whole * period;
            10.0 * (period * (whole * offset + period * whole * (whole - 1.0) / 2.0) + last * (t - last))
        };
        close(*v, rates.iter().map(impulse).sum::<f64>() / 2.0, ROUNDING);
    }
    let charged: f64 = simulation.energy(0).unwrap().controllers.iter().map(|(_, joule)| joule).sum();
    close(charged, 0.5 * 2.0 * trace.column("tip.velocity").unwrap().last().unwrap().powi(2), ROUNDING);
}

/// Two robots press the same workpiece from either side, each with its own loop: by symmetry it does not
/// move.
#[test]
fn truth_two_robots_on_one_workpiece_balance() {
    let mut machine = free_mass(10.0, -5e-3, 0.0);
    machine.bodies.insert("left".into(), body(10.0, 5e-3));
    machine.bodies.insert("part".into(), Body { mass_kg: 3.0, ..Body::default() });
    machine.contacts.insert("tool".into(), contact("tip", "part", 1e5, 100.0));
    machine.contacts.insert("back".into(), contact("part", "left", 1e5, 100.0));
    machine.actuators.insert("drive".into(), drive("tip", GROUND));
    machine.actuators.insert("other".into(), drive("left", GROUND));
    machine.sensors.insert("force".into(), sensor("tool", Quantity::Force));
    machine.sensors.insert(
        "mirror".into(),
        feeler_plant::description::Sensor { gain: -1.0, ..sensor("back", Quantity::Force) },
    );
    let mut pair = scenario(machine, 0.3, &["part.position", "tool.force", "back.force"]);
    let gains = ForceGains { feed_forward: 1.0, kp: 0.5, ..ForceGains::default() };
    force_control(&mut pair, gains, 1e-3, 20.0);
    let mut mirror = pair.controllers["force"].clone();
    mirror.reads = Some("mirror".into());
    mirror.drives = "other".into();
    mirror.spec.reference = ReferenceSpec::Constant(-20.0);
    pair.controllers.insert("mirror".into(), mirror);
    let (trace, simulation) = run(&pair);
    assert!(trace.events.len() > 3 && trace.column("tool.force").unwrap().iter().any(|f| *f > 15.0));
    for (x, (a, b)) in trace
        .column("part.position")
        .unwrap()
        .iter()
        .zip(trace.column("tool.force").unwrap().iter().zip(trace.column("back.force").unwrap()))
    {
        close(*x, 0.0, ROUNDING * 1e-3);
        close(*a, *b, ROUNDING * 1e3);
    }
    let balance = simulation.energy(0).unwrap();
    close(balance.residual() / balance.exchanged(), 0.0, ROUNDING);
}

/// A rotational axis has other units and the same numbers.
#[test]
fn truth_a_rotational_axis_has_the_same_numbers() {
    let base = reference_machine(2, 0.1);
    let mut rotational = base.clone();
    rotational.machine.axis = Axis::Rotational;
    assert_eq!(run(&base).0, run(&rotational).0);
}
