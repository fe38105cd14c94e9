//! Pressing a wall, and checking every number by hand.
//!
//! A rigid axis of 10 kg stands 5 mm off a spring of 100 kN/m. A constant force of 40 N drives it there. It
//! flies, touches, compresses the spring, and is thrown back: four numbers that paper and pencil give as
//! well.
//!
//! ```console
//! cargo run --release --example 01_press
//! ```
#![expect(clippy::print_stdout, reason = "a program that tells what it found")]

use feeler_sim::prelude::*;

const MASS_KG: f64 = 10.0;
const GAP_M: f64 = 5e-3;
const STIFFNESS_N_PER_M: f64 = 1e5;
const PUSH_N: f64 = 40.0;
/// Rows of the record per second.
const RATE_HZ: f64 = 1e5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The machine: one body, the wall as a contact that can only push, and an ideal drive. `+x` points to the
    // wall, and the tip touches where its position is zero.
    let machine = Machine::new("axis")
        .with_body("tip", Body::new(MASS_KG).at(-GAP_M))
        .with_contact("tool", Contact::kelvin_voigt("tip", GROUND, STIFFNESS_N_PER_M, 0.0))
        .with_actuator("drive", Actuator::ideal("tip", GROUND));

    // No feedback yet: the controller puts out its reference.
    let push = ControllerSpec {
        reference: ReferenceSpec::Constant(PUSH_N),
        ..ControllerSpec::new(Law::OpenLoop, 1e-3)
    };
    let scenario = Scenario::new(machine)
        .with_controller("push", ControllerUse::new(push, "drive"))
        .lasting(0.1)
        .recording(["tool.force".parse()?, "tip.velocity".parse()?], RATE_HZ);
    let trace = trace(&scenario)?;

    // Touch and lift are events: the stepper finds their instants to machine precision, whatever the record's
    // rate.
    let instant = |kind| trace.events.iter().find(|event| event.kind == kind).map(|event| event.t_s);
    let (Some(touch_s), Some(lift_s)) = (instant(EventKind::Touch), instant(EventKind::Lift)) else {
        return Err("the tool never touched, or never left".into());
    };

    // Flight at constant acceleration.
    let by_hand_s = (2.0 * GAP_M * MASS_KG / PUSH_N).sqrt();
    println!("touches after {:.6} ms, by hand {:.6} ms", 1e3 * touch_s, 1e3 * by_hand_s);

    // The record has a row at the instant of the touch, up to rounding.
    let row = trace.t_s.partition_point(|t_s| *t_s < touch_s - 0.5 / RATE_HZ);
    let speed = trace.column("tip.velocity").unwrap_or_default()[row];
    let by_hand = PUSH_N / MASS_KG * by_hand_s;
    println!("touches at {:.4} mm/s, by hand {:.4} mm/s", 1e3 * speed, 1e3 * by_hand);

    // Energy: at the turning point the spring stores the kinetic energy and the work of the push up to there.
    let peak_n = trace.column("tool.force").unwrap_or_default().iter().copied().fold(0.0, f64::max);
    let by_hand_n = PUSH_N + (PUSH_N.powi(2) + STIFFNESS_N_PER_M * MASS_KG * by_hand.powi(2)).sqrt();
    println!("pushes with {peak_n:.4} N at most, by hand {by_hand_n:.4} N");

    // On the spring the motion is a sine about the deflection at rest: the contact lasts a bit more than half
    // a period.
    let omega = (STIFFNESS_N_PER_M / MASS_KG).sqrt();
    let by_hand_s =
        2.0 / omega * (std::f64::consts::PI - (by_hand * STIFFNESS_N_PER_M / (omega * PUSH_N)).atan());
    println!("stays for {:.6} ms, by hand {:.6} ms", 1e3 * (lift_s - touch_s), 1e3 * by_hand_s);
    Ok(())
}
