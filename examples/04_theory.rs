//! Linear theory: modes and zeros of a flexible axis, and why it matters where the sensor sits.
//!
//! A motor of 7 kg moves a tip of 5 kg through a transmission of 1.2 MN/m. Seen at the motor, the response
//! has a zero before its mode: there the tip swings on the spring and holds the motor still. Seen at the tip,
//! that zero is gone, and with it the phase that the zero would restore. This is the trouble of every sensor
//! that does not sit where the drive pushes.
//!
//! ```console
//! cargo run --release --example 04_theory
//! ```
#![expect(clippy::print_stdout, reason = "a program that tells what it found")]

use std::f64::consts::TAU;

use feeler_sim::analysis::{Request, View, analyze};
use feeler_sim::prelude::*;

const MOTOR_KG: f64 = 7.0;
const TIP_KG: f64 = 5.0;
const STIFFNESS_N_PER_M: f64 = 1.2e6;
const DAMPING_N_S_PER_M: f64 = 120.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let machine = Machine::new("flexible axis")
        .with_body("motor", Body::new(MOTOR_KG))
        .with_body("tip", Body::new(TIP_KG))
        .with_spring("transmission", Spring::new("motor", "tip", STIFFNESS_N_PER_M, DAMPING_N_S_PER_M))
        .with_actuator("drive", Actuator::ideal("motor", GROUND));
    let scenario = Scenario::new(machine);
    let seen_at = |body: &str| {
        analyze(
            &scenario,
            &Request {
                input: Some(SignalName::new("drive", Quantity::Command)),
                output: Some(SignalName::new(body, Quantity::Position)),
                view: View::FREE,
                ..Request::default()
            },
        )
    };

    let at_motor = seen_at("motor")?;
    let mode = at_motor.modes.last().ok_or("no mode")?;

    // Two masses on a spring swing against each other; the rigid motion is the other mode.
    let reduced_kg = 1.0 / (1.0 / MOTOR_KG + 1.0 / TIP_KG);
    let hz = (STIFFNESS_N_PER_M / reduced_kg).sqrt() / TAU;
    println!("the mode oscillates at {:.4} Hz, by hand {hz:.4} Hz", mode.frequency_hz);

    // Its damping ratio is that of the reduced mass on spring and damper.
    let ratio = 0.5 * DAMPING_N_S_PER_M / (STIFFNESS_N_PER_M * reduced_kg).sqrt();
    println!("its damping ratio is {:.6}, by hand {ratio:.6}", mode.damping_ratio);

    // The zero at the motor: the tip alone on the transmission.
    let zero_hz = (STIFFNESS_N_PER_M / TIP_KG).sqrt() / TAU;
    let found_hz = *at_motor.zeros_hz.first().ok_or("no zero")?;
    println!("seen at the motor it has a zero at {found_hz:.4} Hz, by hand {zero_hz:.4} Hz");
    println!("its class there: {:?}", mode.class);

    // At the tip a zero is left only where damper and spring cancel, far away.
    let at_tip = seen_at("tip")?;
    let far_hz = STIFFNESS_N_PER_M / DAMPING_N_S_PER_M / TAU;
    let found_hz = *at_tip.zeros_hz.first().ok_or("no zero")?;
    println!("seen at the tip the first zero is at {found_hz:.4} Hz, by hand {far_hz:.4} Hz");
    println!("its class there: {:?}", at_tip.modes.last().ok_or("no mode")?.class);
    Ok(())
}
