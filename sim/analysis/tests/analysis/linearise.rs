//! Linearisation: operating points, free bodies, friction.

use std::sync::Arc;

use crate::common::{force_loop, machine};
use feeler_analysis::{ContactView, ControlLoop, FrictionView, HeldCommand, LinearMachine, View};
use feeler_lti::C64;
use feeler_plant::description::{ContactLaw, Engagement, Machine, Profile, Quantity, SignalName};
use feeler_plant::effects::{EffectUse, find};

/// Newton's method ends at 1e-10 of the forces.
const EQUILIBRIUM: f64 = 1e-8;

fn command() -> SignalName {
    SignalName::new("drive", Quantity::Command)
}

#[test]
fn truth_a_hertzian_contact_is_as_stiff_as_its_preload_makes_it() {
    let mut machine = machine();
    let contact = &mut machine.contacts["tool"];
    contact.law = ContactLaw::Hertz;
    contact.engagement = Engagement::Unilateral;
    contact.stiffness = 3e8;
    let preload_n: f64 = 25.0;
    let view = View { contact: ContactView::Pressed { preload_n }, ..View::default() };
    let plant = LinearMachine::new(&machine, &view).unwrap();
    // F = k d^1.5, so dF/dd = 1.5 k d^0.5 at d = (F / k)^(2/3). A slow force of the drive reaches the sensor
    // completely.
    let depth = (preload_n / 3e8).powf(2.0 / 3.0);
    let compression = plant.channel(&command(), &SignalName::new("tool", Quantity::Compression)).unwrap();
    let softness = compression.system.at(C64::new(0.0, 0.0)).unwrap()[(0, 0)].re;
    assert!((softness * 1.5 * 3e8 * depth.sqrt() - 1.0).abs() < EQUILIBRIUM, "{softness}");
    assert!(plant.operating_point().balanced);
    let held = plant.operating_point().xi[plant.motion().layout().input(0)];
    assert!((held / preload_n - 1.0).abs() < EQUILIBRIUM, "the drive holds {held} N");
}

/// A force over position that begins behind a gap has its slope where the tip touches, not where the bodies
/// start. So a common shift of wall and table does not change the small motions.
#[test]
fn truth_a_wall_and_a_table_that_are_shifted_together_change_no_small_motion() {
    let table = find("force-table").unwrap();
    let mut values = vec![0.0; table.parameters.len()];
    for (value, parameter) in values.iter_mut().zip(table.parameters) {
        let place = parameter.name.strip_prefix("force_").and_then(|i| i.parse::<f64>().ok());
        *value = place.map_or(0.0, |i| 12.5 * (i - 1.0));
    }
    let at = |name: &str| table.parameters.iter().position(|parameter| parameter.name == name).unwrap();
    let shifted = |gap_m: f64, from_m: f64, contact: ContactView| {
        let mut machine = machine();
        machine.contacts["tool"].engagement = Engagement::Unilateral;
        machine.contacts["tool"].gap_m = gap_m;
        let mut values = values.clone();
        (values[at("from")], values[at("to")]) = (from_m, from_m + 1e-3);
        machine.springs["guide"].effects.push(EffectUse { definition: table, values });
        let view = View { contact, ..View::default() };
        LinearMachine::new(&machine, &view).unwrap()
    };
    for contact in [ContactView::AsDescribed, ContactView::Pressed { preload_n: 30.0 }] {
        let [near, far] = [(0.0, -0.5e-3), (4e-3, 3.5e-3)].map(|(gap, from)| shifted(gap, from, contact));
        assert!(near.operating_point().balanced && far.operating_point().balanced);
        // Positions near the middle of the table, where the law is straight except for the tails of its ends.
        assert!((near.a() - far.a()).amax() < EQUILIBRIUM * near.a().amax(), "{contact:?}");
        // The table rises by 100 kN/m there, and is flat 4 mm before it.
        let away = shifted(4e-3, -0.5e-3, contact);
        let pushed = (near.a() - away.a()).amax() * 7.0;
        assert!((pushed / 1e5 - 1.0).abs() < 0.05, "{contact:?}: {pushed} N/m");
    }
}

#[test]
fn truth_a_surface_that_moves_changes_nothing_of_linear_theory() {
    let wavy = Profile::smooth(&[(0.0, 0.0), (0.1, 1e-3), (0.2, -1e-3)]).unwrap();
    let moving = |profile: Option<Profile>| {
        let mut machine = machine();
        machine.contacts["tool"].engagement = Engagement::Unilateral;
        machine.profiles.extend(profile.map(|profile| ("tool".to_owned(), Arc::new(profile))));
        let view = View { contact: ContactView::Pressed { preload_n: 30.0 }, ..View::default() };
        LinearMachine::new(&machine, &view).unwrap()
    };
    let (at_rest, moved) = (moving(None), moving(Some(wavy)));
    assert_eq!((at_rest.a(), at_rest.b()), (moved.a(), moved.b()));
    let force = SignalName::new("tool", Quantity::Force);
    let [of_rest, of_moved] = [at_rest, moved].map(|plant| plant.channel(&command(), &force).unwrap());
    assert_eq!(format!("{:?}", of_rest.system), format!("{:?}", of_moved.system));
}

#[test]
fn truth_a_held_command_presses_as_hard_as_it_arrives() {
    let mut machine = machine();
    let contact = &mut machine.contacts["tool"];
    contact.law = ContactLaw::Hertz;
    contact.stiffness = 3e8;
    let deadband = find("drive-deadband").unwrap();
    let width_n: f64 = 5.0;
    machine.actuators["drive"]
        .effects
        .push(EffectUse { definition: deadband, values: vec![width_n; deadband.parameters.len()] });
    // Only the drive pushes, so the contact carries 30 N less the deadband.
    let held = View { held: Some(HeldCommand { drive: 0, command: 30.0 }), ..View::default() };
    let pressed = View { contact: ContactView::Pressed { preload_n: 30.0 - width_n }, ..View::default() };
    let [held, pressed] = [held, pressed].map(|view| LinearMachine::new(&machine, &view).unwrap());
    assert!(held.operating_point().balanced);
    assert!((held.a() - pressed.a()).amax() < EQUILIBRIUM * pressed.a().amax());
}

#[test]
fn truth_free_bodies_drift_with_a_pole_at_zero_exactly() {
    let mut machine = machine();
    machine.springs["guide"].damping_n_s_per_m = 0.0;
    let plant = LinearMachine::new(&machine, &View::FREE).unwrap();
    // Acceleration does not depend on position. Two free speeds remain; their common motion is a pole at
    // zero.
    let channel = plant.channel(&command(), &SignalName::new("tip", Quantity::Acceleration)).unwrap();
    assert_eq!(channel.system.states(), 3);
    let poles = channel.poles().unwrap();
    assert!(poles[0].norm() < 1e-9 * poles[1].norm(), "{poles:?}");
    // At low frequency the machine acts as its mass.
    let slow = channel.frequency_response(&[0.01]).unwrap()[0];
    assert!((slow.re * 12.0 - 1.0).abs() < 1e-6 && slow.im.abs() < 1e-6, "{slow}");
}

#[test]
fn truth_a_sticking_guide_holds_its_body() {
    let mut machine = machine();
    let definition = find("coulomb-friction").unwrap();
    machine.springs["guide"]
        .effects
        .push(EffectUse { definition, values: vec![10.0; definition.parameters.len()] });
    let view = |friction| View { friction, ..View::CLAMPED };
    let slides = LinearMachine::new(&machine, &view(FrictionView::Ignored)).unwrap();
    let sticks = LinearMachine::new(&machine, &view(FrictionView::Stuck)).unwrap();
    assert_eq!((slides.motion().layout().coordinates(), sticks.motion().layout().coordinates()), (2, 1));
    // The tip between transmission and sensor remains.
    let own = feeler_analysis::modes(&sticks).unwrap();
    let expected = f64::sqrt(1.4e6 / 5.0) / std::f64::consts::TAU;
    assert!((own[0].frequency_hz() / expected - 1.0).abs() < 1e-9);
}

#[test]
fn truth_delays_stand_beside_the_state_space() {
    let mut scenario = force_loop(0.1, 0.0);
    scenario.machine.sensors["force"].delay_s = 2e-3;
    let plant = LinearMachine::new(&scenario.machine, &View::CLAMPED).unwrap();
    let channel = |signal: SignalName| plant.channel(&command(), &signal).unwrap();
    let (read, true_force) = (
        channel(SignalName::new("force", Quantity::Reading)),
        channel(SignalName::new("tool", Quantity::SpringForce)),
    );
    assert!((read.delay_s - 2e-3).abs() < 1e-15);
    let f = [37.0];
    let ratio = read.frequency_response(&f).unwrap()[0] / true_force.frequency_response(&f).unwrap()[0];
    assert!(
        (ratio.arg() + std::f64::consts::TAU * 37.0 * 2e-3).abs() < 1e-12
            && (ratio.norm() - 1.0).abs() < 1e-12
    );
}

/// Bristles that do not slide bend as the body moves: `sigma_0` and `sigma_1` are then those of the guide.
#[test]
fn truth_bristles_at_rest_are_a_spring_and_a_damper() {
    let (stiffness, damping) = (4e5, 300.0);
    let [mut bent, mut held] = [machine(), machine()];
    let definition = find("lugre-friction").unwrap();
    let values = vec![stiffness, damping, 10.0, 13.0, 0.01];
    bent.springs["guide"].effects.push(EffectUse { definition, values });
    let guide = &mut held.springs["guide"];
    guide.stiffness_n_per_m += stiffness;
    guide.damping_n_s_per_m += damping;
    let [bent, held] = [bent, held].map(|machine| {
        feeler_analysis::modes(&LinearMachine::new(&machine, &View::CLAMPED).unwrap()).unwrap()
    });
    assert_eq!(bent.len(), held.len());
    for (bent, held) in bent.iter().zip(&held) {
        assert!((bent.eigenvalue - held.eigenvalue).norm() < 1e-9 * held.eigenvalue.norm(), "{bent:?}");
    }
}

/// A guide that yields before it slides is a spring while it sticks, and adds nothing while it slides.
#[test]
fn truth_a_guide_that_yields_is_a_spring_only_while_it_sticks() {
    let (stiffness, damping_ratio) = (3e5, 0.4);
    let with = |kinds: &[(&str, &[f64])]| {
        let mut machine = machine();
        let used = kinds
            .iter()
            .map(|(kind, values)| EffectUse { definition: find(kind).unwrap(), values: values.to_vec() });
        machine.springs["guide"].effects.extend(used);
        machine
    };
    let dry = ("coulomb-friction", &[10.0][..]);
    let yielding = with(&[dry, ("presliding", &[stiffness, damping_ratio])]);
    let view = |friction| View { friction, ..View::CLAMPED };
    let [slides, bare] = [&yielding, &with(&[dry])]
        .map(|machine| LinearMachine::new(machine, &view(FrictionView::Ignored)).unwrap());
    assert_eq!(slides.a(), bare.a());
    let sticks = LinearMachine::new(&yielding, &view(FrictionView::Stuck)).unwrap();
    let mut held = machine();
    let guide = &mut held.springs["guide"];
    guide.stiffness_n_per_m += stiffness;
    // The motor of 7 kg slides.
    guide.damping_n_s_per_m += 2.0 * damping_ratio * (stiffness * 7.0_f64).sqrt();
    let held = LinearMachine::new(&held, &view(FrictionView::Ignored)).unwrap();
    assert!((sticks.a() - held.a()).amax() < 1e-12 * held.a().amax());
    // A loop has the same poles as without yielding: the sliding surfaces of the run are no part of it.
    let poles = |machine: &Machine| {
        let mut scenario = force_loop(0.1, 0.0);
        scenario.machine = machine.clone();
        let whole = ControlLoop::new(&scenario, &View::CLAMPED).unwrap();
        whole.plant().a().clone()
    };
    assert_eq!(poles(&yielding), poles(&with(&[dry])));
}
