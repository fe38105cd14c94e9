//! Properties of a run that every effect of the library must keep.

use feeler_control::ReferenceSpec;
use feeler_engine::{Program, RunEnd, Scenario, Simulation, Trace, Unobserved};
use feeler_plant::description::{Axis, Body, GROUND, Machine, Spring};
use feeler_plant::effects::{Definition, EffectUse, HostKind, Kind, LIBRARY, Trait};
use feeler_plant::motion::MeterKind;

use crate::common::{axis, body, command, drive, effect, largest_difference, run, scenario, spring};

/// Puts an effect on every element of the axis that accepts it, one variant each.
fn placements(base: &Scenario, definition: &'static Definition, values: &[f64]) -> Vec<Scenario> {
    let used = EffectUse { definition, values: values.to_vec() };
    let mut scenarios = Vec::new();
    for host in definition.hosts {
        let mut scenario = base.clone();
        let machine = &mut scenario.machine;
        match host {
            HostKind::Body => machine.bodies["tip"].effects.push(used.clone()),
            // Guide effects sit on the guide, and so does the base; the rest on the transmission.
            HostKind::Spring => {
                let on_guide = matches!(definition.place.name(), "guide" | "base");
                let effects = &mut machine.springs[if on_guide { "guide" } else { "transmission" }].effects;
                effects.push(used.clone());
                // It changes how dry friction begins, and does nothing without.
                if definition.kind == Kind::Presliding {
                    effects.push(effect("coulomb-friction", &[6.0]));
                }
            }
            HostKind::Contact => machine.contacts["tool"].effects.push(used.clone()),
            HostKind::Actuator => machine.actuators["drive"].effects.push(used.clone()),
            HostKind::ForceSensor => machine.sensors["force"].effects.push(used.clone()),
            HostKind::MotionSensor => machine.sensors["encoder"].effects.push(used.clone()),
            HostKind::Controller => scenario.controllers["force"].effects.push(used.clone()),
            // No rigid spring and no other sensor here; separate tests below cover these.
            HostKind::RigidSpring | HostKind::OtherSensor => continue,
        }
        scenarios.push(scenario);
    }
    scenarios
}

/// The values of the ideal machine. If the library names none, the element's own value applies, or else a
/// limit.
fn null_values(definition: &Definition) -> Option<Vec<f64>> {
    match definition.kind {
        Kind::ContactStiffness => Some(vec![2e5]),
        Kind::ContactDamping => Some(vec![120.0]),
        Kind::HertzContact => Some(vec![1.0, 2e5]),
        _ => {
            let has_null = definition.parameters.iter().any(|parameter| parameter.null.is_some());
            has_null.then(|| definition.parameters.iter().map(|p| p.null.unwrap_or(p.typical)).collect())
        }
    }
}

fn typical_values(definition: &Definition) -> Vec<f64> {
    definition.parameters.iter().map(|parameter| parameter.typical).collect()
}

#[test]
fn prop_at_its_null_value_every_effect_is_absent() {
    let base = axis(0.15);
    let (ideal, _) = run(&base);
    let mut seen = 0;
    for definition in LIBRARY {
        let Some(values) = null_values(definition) else { continue };
        for scenario in placements(&base, definition, &values) {
            let (trace, simulation) = run(&scenario);
            assert_eq!(simulation.end(0), Some(RunEnd::Completed), "{}", definition.kind);
            assert!(trace == ideal, "{} at {values:?} is not absent", definition.kind);
            seen += 1;
        }
    }
    assert!(seen >= LIBRARY.len() - 4, "only {seen} effects were looked at");
}

/// Effects without a null but with a stiff limit. The machine approaches the ideal one as one over the
/// stiffness, in the motion after the first impact.
#[test]
fn order_the_stiff_limit_of_added_bodies_is_the_ideal_machine() {
    let base = axis(0.03);
    let (ideal, _) = run(&base);
    let force = |trace: &Trace| trace.column("tool.force").unwrap().to_vec();
    for (kind, mass) in [("workpiece-dynamics", 0.02_f64), ("base-flexibility", 50.0)] {
        let values = |k: f64| [mass, k, 2.0 * (k * mass).sqrt()];
        let definition = feeler_plant::effects::find(kind).unwrap();
        let distance = |k: f64| {
            let scenario = placements(&base, definition, &values(k)).pop().unwrap();
            largest_difference(&force(&run(&scenario).0), &force(&ideal))
        };
        let (soft, stiff) = (distance(1e9), distance(1e11));
        // The compliance of the damper falls only with the root of the stiffness. So over two decades of
        // stiffness the distance falls by one to two decades.
        assert!(stiff < 0.2 * soft && stiff < 0.2, "{kind}: {soft} and {stiff} N");
    }
    // A guide that hardly yields is rigid dry friction.
    let rigid = |effects: Vec<EffectUse>| {
        let mut scenario = base.clone();
        scenario.machine.springs["guide"].effects = effects;
        force(&run(&scenario).0)
    };
    let held = rigid(vec![effect("coulomb-friction", &[6.0])]);
    let distance = |k: f64| {
        let yielding = effect("presliding", &[k, 0.5]);
        largest_difference(&rigid(vec![effect("coulomb-friction", &[6.0]), yielding]), &held)
    };
    let (soft, stiff) = (distance(1e7), distance(1e9));
    assert!(stiff < 0.2 * soft && stiff < 0.2, "presliding: {soft} and {stiff} N");
    // One body split into two with the same total mass and a stiff spring in between.
    let definition = feeler_plant::effects::find("transmission-flexibility").unwrap();
    let distance = |k: f64| {
        let mut scenario = base.clone();
        let values = vec![k, 2.0 * k.sqrt(), 2.0];
        scenario.machine.bodies["tip"].effects.push(EffectUse { definition, values });
        largest_difference(&force(&run(&scenario).0), &force(&ideal))
    };
    let (soft, stiff) = (distance(1e9), distance(1e11));
    assert!(stiff < 0.2 * soft && stiff < 0.2, "{soft} and {stiff} N");
}

/// On a machine without drives, stored energy never grows if the effect only dissipates, and no meter of loss
/// decreases.
#[test]
fn prop_dissipative_effects_never_add_energy() {
    /// Rounding of a sum of about ten energies.
    const ROUNDING: f64 = 1e-13;
    let mut base = axis(0.2);
    base.controllers.clear();
    base.machine.bodies["motor"].velocity_m_per_s = 0.1;
    base.machine.springs.insert("centring".into(), spring(GROUND, "motor", 5e3, 0.0));
    for definition in LIBRARY.iter().filter(|definition| definition.has(Trait::Dissipative)) {
        for scenario in placements(&base, definition, &typical_values(definition)) {
            let program = Program::new(&scenario).unwrap();
            let mut simulation = Simulation::<f64>::new(vec![program]).unwrap();
            let mut last = f64::INFINITY;
            for slice in 1..=200 {
                simulation.run_to(1e-3 * f64::from(slice), &mut Unobserved).unwrap();
                let balance = simulation.energy(0).unwrap();
                let stored = balance.kinetic[1] + balance.elastic[1];
                let size = balance.exchanged();
                assert!(
                    stored <= last + ROUNDING * size,
                    "{}: grew by {:e} J",
                    definition.kind,
                    stored - last
                );
                last = stored;
                for (kind, name, joule) in
                    balance.meters.iter().filter(|(kind, ..)| *kind != MeterKind::DriveWork)
                {
                    assert!(
                        *joule >= -ROUNDING * size,
                        "{}: {kind:?} of {name} gave {joule:e} J",
                        definition.kind
                    );
                }
                assert!(balance.residual().abs() < 1e-9 * size, "{}", definition.kind);
            }
        }
    }
}

/// Every effect near its typical value, which may be that of the axis itself. It runs to the end, changes the
/// motion or the readings, and closes the ledger.
#[test]
fn prop_near_its_typical_value_every_effect_shows_and_closes_the_ledger() {
    let mut base = axis(0.3);
    // Large enough to reach the limits of the drive.
    base.controllers["force"].spec.reference = feeler_control::ReferenceSpec::Constant(300.0);
    base.run.record.push("encoder.reading".parse().unwrap());
    let (ideal, _) = run(&base);
    for definition in LIBRARY {
        let values: Vec<f64> = typical_values(definition).iter().map(|value| 0.9 * value).collect();
        for scenario in placements(&base, definition, &values) {
            let (trace, simulation) = run(&scenario);
            assert_eq!(simulation.end(0), Some(RunEnd::Completed), "{}", definition.kind);
            assert!(trace.columns != ideal.columns, "{} does not show", definition.kind);
            let balance = simulation.energy(0).unwrap();
            let share = balance.residual().abs() / balance.exchanged();
            assert!(share < 1e-9, "{}: {share:e}", definition.kind);
        }
    }
}

/// Effects of rigid joints: a joint with compliance and play is a machine like any other.
#[test]
fn prop_effects_of_rigid_joints_run_and_close_the_ledger() {
    for kind in ["backlash", "transmission-flexibility", "workpiece-dynamics", "base-flexibility"] {
        let definition = feeler_plant::effects::find(kind).unwrap();
        assert!(definition.hosts.contains(&HostKind::RigidSpring), "{kind}");
        let mut scenario = axis(0.2);
        let rigid =
            |a: &str, b: &str| Spring { between: [a.into(), b.into()], rigid: true, ..Spring::default() };
        let joint = match kind {
            "workpiece-dynamics" => {
                scenario.machine.bodies.insert("part".into(), Body { mass_kg: 3.0, ..Body::default() });
                scenario.machine.contacts["tool"].between[1] = "part".into();
                rigid(GROUND, "part")
            }
            "base-flexibility" => {
                scenario.machine.bodies.insert("base".into(), Body { mass_kg: 180.0, ..Body::default() });
                scenario.machine.springs["guide"].between[0] = "base".into();
                scenario.machine.actuators["drive"].reacts_on = "base".into();
                rigid(GROUND, "base")
            }
            _ => rigid("motor", "tip"),
        };
        let name =
            if kind.ends_with("dynamics") || kind.starts_with("base") { "joint" } else { "transmission" };
        let effects = vec![EffectUse { definition, values: typical_values(definition) }];
        scenario.machine.springs.insert(name.into(), Spring { effects, ..joint });
        let (_, simulation) = run(&scenario);
        assert_eq!(simulation.end(0), Some(RunEnd::Completed), "{kind}");
        let balance = simulation.energy(0).unwrap();
        assert!(balance.residual().abs() < 1e-9 * balance.exchanged(), "{kind}");
    }
}

/// An arm of 10 N m, held by its drive, on a base of 1000 N m/rad. The weight turns the base, whether it is a
/// body of its own or an effect of the guide.
#[test]
fn regress_the_weight_of_an_arm_loads_the_base_that_an_effect_makes() {
    let (torque, stiffness) = (10.0, 1000.0);
    let arm = |on_base: bool| {
        let mut machine = Machine { axis: Axis::Rotational, ..Machine::default() };
        let half_pi = std::f64::consts::FRAC_PI_2;
        let pulled = Body { gravity_n: torque, gravity_phase_rad: half_pi, ..body(0.5, 0.0) };
        machine.bodies.insert("arm".into(), pulled);
        let mut guide = spring(GROUND, "arm", 0.0, 50.0);
        let mut actuator = drive("arm", GROUND);
        if on_base {
            machine.bodies.insert("base".into(), body(2.0, 0.0));
            machine.springs.insert("mount".into(), spring(GROUND, "base", stiffness, 50.0));
            guide.between[0] = "base".into();
            actuator.reacts_on = "base".into();
        } else {
            guide.effects.push(effect("base-flexibility", &[2.0, stiffness, 50.0]));
        }
        machine.springs.insert("guide".into(), guide);
        machine.actuators.insert("drive".into(), actuator);
        let mut scenario = scenario(machine, 0.5, &["arm.position", "arm.velocity"]);
        command(&mut scenario, "hold", ReferenceSpec::Constant(torque), 1e-3);
        run(&scenario).0
    };
    let (own, made) = (arm(true), arm(false));
    for (own, made) in own.columns.iter().zip(&made.columns) {
        // The order of two sums differs: their roundings, over 500 steps of motions of 0.01 rad.
        assert!(largest_difference(own, made) < 1e-12);
    }
    // The drive holds the weight against the base, which turns by the torque over its stiffness.
    let sag = *made.columns[0].last().unwrap();
    assert!((sag + torque / stiffness).abs() < 1e-3, "{sag}");
}
