//! The energy ledger closes for every law, with the controller in the loop and through impacts.

use feeler_control::{ForceGains, ReferenceSpec};
use feeler_engine::{EventKind, RunEnd, Scenario};
use feeler_plant::description::{ActuatorKind, Contact, ContactLaw, Engagement};
use feeler_plant::motion::MeterKind;

use crate::common::{axis, contact, effect, reference_machine, run};

/// Requirement: 1e-9 of the energy exchanged.
const TOLERANCE: f64 = 1e-9;
/// A meter of dissipation may fall below zero by the rounding of its sum.
const ROUNDING: f64 = 1e-12;

/// Asserts that the ledger closes and gives the events of the run.
fn closes(what: &str, scenario: &Scenario) -> Vec<EventKind> {
    let (trace, simulation) = run(scenario);
    assert_eq!(simulation.end(0), Some(RunEnd::Completed), "{what}");
    let balance = simulation.energy(0).unwrap();
    let share = balance.residual().abs() / balance.exchanged();
    println!("{what}: {share:.1e} of {:.2e} J, {} events", balance.exchanged(), trace.events.len());
    assert!(balance.exchanged() > 1e-6, "{what}: nothing happened");
    assert!(share < TOLERANCE, "{what}: {share:.1e} of {:.1e} J, {:?}", balance.exchanged(), balance.meters);
    for (kind, name, joule) in &balance.meters {
        let takes = matches!(kind, MeterKind::LinkDamping | MeterKind::Friction | MeterKind::ContactDamping);
        assert!(
            !takes || *joule >= -ROUNDING * balance.exchanged(),
            "{what}: {kind:?} of {name} gave {joule} J"
        );
    }
    trace.events.iter().map(|event| event.kind).collect()
}

#[test]
fn truth_ledger_closes_for_every_contact_law() {
    let laws = [
        ("kelvin-voigt", ContactLaw::KelvinVoigt, 2e5, 120.0),
        ("kelvin-voigt, overdamped", ContactLaw::KelvinVoigt, 2e5, 6e3),
        ("undamped", ContactLaw::KelvinVoigt, 2e5, 0.0),
        ("hunt-crossley, n = 1", ContactLaw::HuntCrossley { alpha_s_per_m: 3.0, exponent: 1.0 }, 2e5, 0.0),
        ("hunt-crossley, n = 1.5", ContactLaw::HuntCrossley { alpha_s_per_m: 3.0, exponent: 1.5 }, 2e7, 0.0),
        (
            "hunt-crossley and damper",
            ContactLaw::HuntCrossley { alpha_s_per_m: 3.0, exponent: 1.5 },
            2e7,
            50.0,
        ),
        ("hertz", ContactLaw::Hertz, 2e7, 0.0),
        ("hertz and damper", ContactLaw::Hertz, 2e7, 100.0),
    ];
    for (name, law, stiffness, damping) in laws {
        for engagement in [Engagement::Unilateral, Engagement::Clamped] {
            let mut scenario = axis(0.3);
            let tool = &mut scenario.machine.contacts["tool"];
            *tool = Contact {
                law,
                engagement,
                gap_m: tool.gap_m,
                ..contact("tip", "ground", stiffness, damping)
            };
            let events = closes(&format!("{name}, {engagement:?}"), &scenario);
            assert!(engagement == Engagement::Clamped || events.len() > 2, "{name}: no impacts");
        }
    }
}

#[test]
fn truth_ledger_closes_for_every_effect_of_guide_transmission_and_contact() {
    let guide: [(&str, &[f64]); 6] = [
        ("coulomb-friction", &[4.0]),
        ("stribeck-friction", &[3.0, 6.0, 5e-3]),
        ("asymmetric-friction", &[4.0, 0.4]),
        ("load-friction", &[0.2]),
        ("viscous-friction", &[40.0]),
        ("constant-load", &[6.0]),
    ];
    for (kind, values) in guide {
        let mut scenario = axis(0.5);
        scenario.machine.springs["guide"].effects.push(effect(kind, values));
        closes(kind, &scenario);
    }
    let transmission: [(&str, &[f64]); 3] =
        [("backlash", &[5e-5, 0.0, 0.0]), ("hardening-stiffness", &[5e13]), ("coulomb-friction", &[3.0])];
    for (kind, values) in transmission {
        let mut scenario = axis(0.5);
        scenario.machine.springs["transmission"].effects.push(effect(kind, values));
        closes(kind, &scenario);
    }
    let mut both = axis(0.5);
    let effects = [effect("backlash", &[5e-5, 0.0, 0.0]), effect("hardening-stiffness", &[5e13])];
    both.machine.springs["transmission"].effects.extend(effects);
    closes("backlash with hardening flanks", &both);
    let mut hardening = axis(0.5);
    hardening.machine.contacts["tool"].effects.push(effect("hardening-stiffness", &[1e14]));
    closes("hardening contact", &hardening);
}

#[test]
fn truth_ledger_closes_for_every_effect_of_the_drive() {
    let drive: [(&str, &[f64]); 9] = [
        ("actuator-lag", &[2e-3]),
        ("command-delay", &[1.37e-3]),
        ("drive-gain", &[1.2]),
        ("drive-deadband", &[2.0]),
        ("force-limit", &[15.0]),
        ("slew-limit", &[3e3]),
        ("thermal-derating", &[20.0, 0.1]),
        ("force-ripple", &[2.0, 1e-3, 0.4]),
        ("force-ripple", &[2.0, 1e-4, 0.4]),
    ];
    for (kind, values) in drive {
        let mut scenario = axis(0.5);
        scenario.machine.actuators["drive"].effects.push(effect(kind, values));
        closes(kind, &scenario);
    }
    let mut source = axis(0.5);
    source.machine.actuators["drive"].kind =
        ActuatorKind::VelocitySource { damping_n_s_per_m: 600.0, time_constant_s: 2e-3 };
    source.machine.actuators["drive"].limit_n = Some(12.0);
    source.machine.actuators["drive"].rate_limit_per_s = Some(0.5);
    source.controllers.clear();
    crate::common::force_control(&mut source, ForceGains { kp: 2e-3, ..ForceGains::default() }, 1e-3, 20.0);
    let events = closes("velocity source with limits", &source);
    assert!(events.contains(&EventKind::Limit) && events.contains(&EventKind::Release));
}

#[test]
fn truth_ledger_closes_for_many_effects_at_once() {
    let mut scenario = axis(0.5);
    let machine = &mut scenario.machine;
    machine.springs["guide"]
        .effects
        .extend([effect("stribeck-friction", &[2.0, 3.0, 5e-3]), effect("load-friction", &[0.1])]);
    machine.springs["transmission"].effects.push(effect("backlash", &[2e-5, 0.0, 0.0]));
    machine.contacts["tool"].effects.extend([
        effect("hunt-crossley-contact", &[2.0]),
        effect("workpiece-dynamics", &[3.0, 1.5e6, 150.0]),
    ]);
    machine.actuators["drive"]
        .effects
        .extend([effect("slew-limit", &[5e3]), effect("force-ripple", &[1.0, 1e-3, 0.0])]);
    closes("many at once", &scenario);
}

/// Only the controller does work on these drives, so its work equals that of the drive.
#[test]
fn truth_controllers_are_charged_what_the_drive_did() {
    for masses in [1, 2, 4] {
        let mut scenario = reference_machine(masses, 0.3);
        scenario.run.energy = true;
        closes(&scenario.machine.name.clone(), &scenario);
        let (_, simulation) = run(&scenario);
        let balance = simulation.energy(0).unwrap();
        let drive: f64 = balance
            .meters
            .iter()
            .filter(|(kind, ..)| *kind == MeterKind::DriveWork)
            .map(|(.., joule)| joule)
            .sum();
        let controller: f64 = balance.controllers.iter().map(|(_, joule)| joule).sum();
        assert!((drive - controller).abs() < TOLERANCE * balance.exchanged(), "{drive} {controller}");
    }
}

/// A mass at rest under a nonlinear law stays there indefinitely: its remaining motion is rounding, which no
/// step can resolve.
#[test]
fn regress_rest_in_a_nonlinear_contact_is_a_motion_too() {
    for offset_m in [0.0, 0.7] {
        let mut scenario = axis(4.0);
        for name in ["motor", "tip"] {
            scenario.machine.bodies[name].position_m = offset_m;
        }
        let law = ContactLaw::HuntCrossley { alpha_s_per_m: 5.0, exponent: 1.5 };
        scenario.machine.contacts["tool"] =
            Contact { law, gap_m: offset_m, ..contact("tip", "ground", 2e7, 400.0) };
        scenario.controllers["force"].spec.reference = ReferenceSpec::Constant(20.0);
        closes("long rest", &scenario);
    }
}
