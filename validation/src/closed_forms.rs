//! The closed forms as checked rows, each against the computed or simulated value.

use std::f64::consts::{PI, TAU};

use feeler_analysis::{ContinuousLoop, SampledLoop, View};
use feeler_engine::{Program, Scenario, Simulation, Unobserved};
use feeler_lti::{AffineLoop, C64, Continuous, StateSpace, eigenvalues};
use feeler_plant::description::{
    ActuatorKind, Body, Contact, ContactLaw, GROUND, Machine, Quantity, SignalName,
};
use nalgebra::dmatrix;

use crate::error::ValidationError;
use crate::paper::{IDEAL, PaperAxis, gain_of};
use crate::table::CheckRow;
use crate::truths;

/// Edges are bisected to 1e-14; eigenvalues of these well-conditioned loops are accurate to 1e-12.
const EDGE: f64 = 1e-9;
/// Zeros of undamped machines: a few hundred roundings.
const ZERO: f64 = 1e-10;
/// Impacts: events are located to 1e-12 s of contacts that last milliseconds.
const IMPACT: f64 = 1e-8;

fn axis(masses_kg: (f64, f64), guide: f64, contact: (f64, f64)) -> PaperAxis {
    PaperAxis {
        masses_kg,
        guide_n_s_per_m: guide,
        contact,
        transmission: None,
        base: None,
        workpiece: None,
        drive: IDEAL,
        total_force: false,
    }
}

/// Rows A to G, I and J.
///
/// # Errors
/// [`ValidationError::Analysis`], [`ValidationError::Engine`], [`ValidationError::Lti`].
pub fn closed_form_rows() -> Result<Vec<CheckRow>, ValidationError> {
    let mut rows = Vec::new();
    lagged_axis(&mut rows)?;
    undamped_axes(&mut rows)?;
    integral_loops(&mut rows)?;
    impacts(&mut rows)?;
    one_sided_spring(&mut rows);
    virtual_wall(&mut rows);
    Ok(rows)
}

fn lagged_axis(rows: &mut Vec<CheckRow>) -> Result<(), ValidationError> {
    let (m, b, k_s, corner_hz) = (20.0, 200.0, 1e5, 30.0);
    let machine = PaperAxis {
        drive: ActuatorKind::Force { bandwidth_hz: Some(corner_hz) },
        ..axis((12.0, 8.0), b, (k_s, 0.0))
    };
    let whole = machine.kp_loop(1e-3, 0.0)?;
    let bands = whole.continuous_bands(gain_of(&whole))?;
    let (gain, omega) = truths::lagged_axis_largest_gain(m, b, k_s, 1.0 / (TAU * corner_hz));
    let claim = "closed form A: rigid axis with a first-order force lag";
    rows.push(CheckRow::relative("largest gain", claim, bands.first_upper(), gain, EDGE));
    rows.push(CheckRow::close("largest gain, as printed", claim, gain, 0.450_043, 0.5e-6));
    let edge_hz =
        bands.bands.first().and_then(|band| band.upper.as_ref()).map_or(f64::NAN, |edge| edge.frequency_hz);
    rows.push(CheckRow::relative("frequency at the edge", claim, edge_hz, omega / TAU, EDGE));
    Ok(())
}

fn undamped_axes(rows: &mut Vec<CheckRow>) -> Result<(), ValidationError> {
    let (m1, m2, k, k_s) = (12.0, 8.0, 4e5, 1e5);
    let two_mass = PaperAxis { transmission: Some((k, 0.0)), ..axis((m1, m2), 0.0, (k_s, 0.0)) };
    let whole = two_mass.kp_loop(1e-3, 0.0)?;
    let continuous = ContinuousLoop::new(&whole)?;
    let grows = |kp: f64| -> Result<bool, ValidationError> {
        let poles = eigenvalues(&continuous.closed_loop_with(0, gain_of(&whole), kp)?)?;
        // Below the limit motions neither grow nor decay, up to the rounding of poles about to meet: the
        // square root of 1e-16, times 300 rad/s.
        Ok(poles.iter().any(|p| p.re > 1e-4))
    };
    let expected = truths::two_mass_largest_gain(m1, m2, k, k_s);
    let (mut low, mut high) = (0.5 * expected, 2.0 * expected);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if grows(middle)? { high = middle } else { low = middle }
    }
    rows.push(CheckRow::relative(
        "largest gain",
        "closed form B: undamped two-mass axis",
        low,
        expected,
        1e-8,
    ));

    let (kb, mb, kw, mw) = (1.0e6, 180.0, 1.5e6, 3.0);
    let claim = "closed form C: zeros of base and workpiece";
    for (name, machine, expected) in [
        (
            "base",
            PaperAxis { base: Some((mb, kb, 0.0)), ..axis((7.0, 5.0), 0.0, (2e5, 0.0)) },
            (kb / (12.0 + mb)).sqrt(),
        ),
        (
            "workpiece",
            PaperAxis { workpiece: Some((mw, kw, 0.0)), ..axis((7.0, 5.0), 0.0, (2e5, 0.0)) },
            (kw / mw).sqrt(),
        ),
    ] {
        let plant = feeler_analysis::LinearMachine::new(&machine.machine(name), &View::CLAMPED)?;
        let channel = plant.channel(
            &SignalName::new("drive", Quantity::Command),
            &SignalName::new("tool", Quantity::SpringForce),
        )?;
        let zeros = channel.zeros_hz()?;
        rows.push(CheckRow::relative(
            format!("{name} zero"),
            claim,
            zeros.first().map_or(f64::NAN, |z| z * TAU),
            expected,
            ZERO,
        ));
    }

    let undamped = axis((7.0, 5.0), 0.0, (2e5, 0.0));
    let claim = "closed form E: a hold destabilises an undamped axis at every rate";
    for period_s in [1e-2, 1e-3, 1e-4] {
        let whole = undamped.kp_loop(period_s, 0.0)?;
        let sampled = SampledLoop::new(&whole)?;
        let fastest = eigenvalues(&sampled.closed_loop_with(0, gain_of(&whole), 0.1)?)?
            .iter()
            .map(|z| z.norm())
            .fold(0.0, f64::max);
        rows.push(CheckRow::above(
            format!("|z| at K = 0.1, every {period_s} s, less 1"),
            claim,
            fastest - 1.0,
            1e-9,
        ));
    }
    Ok(())
}

fn integral_loops(rows: &mut Vec<CheckRow>) -> Result<(), ValidationError> {
    let claim = "closed form D: integral force loop on a pure stiffness";
    let (period_s, k) = (1e-3, 1e5);
    let stiffness = StateSpace::gain(dmatrix![k], Continuous)?;
    let accumulator =
        StateSpace::discrete(dmatrix![1.0], dmatrix![period_s], dmatrix![1.0], dmatrix![0.0], period_s)?;
    for n in 0..4 {
        // The accumulator itself responds one sample late, which is n = 0 of the closed form.
        let open =
            stiffness.zero_order_hold_delayed(period_s, f64::from(n) * period_s)?.series(&accumulator)?;
        let stable = AffineLoop::negative_feedback(&open)?.stable_gains()?;
        let edge =
            stable.intervals.iter().find_map(|i| i.upper.as_ref().filter(|e| e.gain * period_s * k > 1e-6));
        let got = edge.map_or(f64::NAN, |edge| edge.gain * period_s * k);
        rows.push(CheckRow::relative(
            format!("T G k, {n} samples late"),
            claim,
            got,
            truths::integral_loop_largest_gain(n),
            EDGE,
        ));
    }
    Ok(())
}

/// A mass that flies into a wall: speed after over speed before.
fn restitution(
    law: ContactLaw,
    stiffness: f64,
    damping: f64,
    mass_kg: f64,
    speed: f64,
) -> Result<f64, ValidationError> {
    let tip = Body { velocity_m_per_s: speed, ..Body::new(mass_kg).at(-1e-3) };
    let contact = Contact { law, ..Contact::kelvin_voigt("tip", GROUND, stiffness, damping) };
    let machine = Machine::new("impact").with_body("tip", tip).with_contact("tool", contact);
    let program = Program::new(&Scenario::new(machine).lasting(0.3))?;
    let mut simulation = Simulation::<f64>::new(vec![program])?;
    simulation.run(&mut Unobserved)?;
    Ok(-simulation.state(0)[1] / speed)
}

fn impacts(rows: &mut Vec<CheckRow>) -> Result<(), ValidationError> {
    let (m, k, v) = (2.0, 1e5, 0.4);
    for (zeta, printed) in [(0.2, 0.5717), (0.5, 0.2984)] {
        let claim = "closed form F: Kelvin-Voigt impact";
        let expected = truths::kelvin_voigt_restitution(zeta);
        let got = restitution(ContactLaw::KelvinVoigt, k, 2.0 * zeta * f64::sqrt(k * m), m, v)?;
        rows.push(CheckRow::close(format!("restitution, zeta {zeta}"), claim, got, expected, IMPACT));
        rows.push(CheckRow::close(
            format!("restitution, zeta {zeta}, as printed"),
            claim,
            expected,
            printed,
            0.5e-4,
        ));
    }
    for (a_v, printed) in [(0.08, 0.949_354), (0.32, 0.823_632), (0.8, 0.647_967)] {
        let claim = "closed form G: Hunt-Crossley impact";
        let expected = truths::hunt_crossley_restitution(a_v);
        let got =
            restitution(ContactLaw::HuntCrossley { alpha_s_per_m: a_v / v, exponent: 1.5 }, 3e6, 0.0, m, v)?;
        rows.push(CheckRow::close(format!("restitution, a v {a_v}"), claim, got, expected, IMPACT));
        rows.push(CheckRow::close(
            format!("restitution, a v {a_v}, as printed"),
            claim,
            expected,
            printed,
            0.5e-6,
        ));
    }
    Ok(())
}

fn one_sided_spring(rows: &mut Vec<CheckRow>) {
    for r in [-0.9, -0.3, 0.0, 0.5, 0.95] {
        // First harmonic of max(0, r + cos) by the midpoint rule; its kinks leave an error of order 1/n^2.
        let n = 200_000;
        let sum: f64 = (0..n)
            .map(|i| TAU * (f64::from(i) + 0.5) / f64::from(n))
            .map(|t| (r + t.cos()).max(0.0) * t.cos())
            .sum();
        let got = 2.0 * sum / f64::from(n);
        rows.push(CheckRow::close(
            format!("N / k, x0/A {r}"),
            "closed form I: one-sided spring",
            got,
            truths::one_sided_spring(r),
            1e-8,
        ));
    }
}

fn virtual_wall(rows: &mut Vec<CheckRow>) {
    let period_s = 1e-3;
    for (k, b) in [(1e4, 0.0), (2e4, 5.0), (5e3, -4.0)] {
        // Colgate and Schenkel's integral condition: T / 2 max Re[(1 - e^-jwT) H] / (1 - cos wT), H = K + B
        // (z - 1) / (T z).
        let needed = |w: f64| {
            let z = C64::cis(w * period_s);
            let h = (C64::new(1.0, 0.0) - z.inv()) * (b / period_s) + k;
            0.5 * period_s * ((C64::new(1.0, 0.0) - z.inv()) * h).re / (1.0 - (w * period_s).cos())
        };
        let n = 10_000;
        let worst = (1..=n)
            .map(|i| needed(PI / period_s * f64::from(i) / f64::from(n)))
            .fold(f64::NEG_INFINITY, f64::max);
        let claim = "closed form J: virtual wall";
        // The supremum at low frequency is approached as (w T)^2, 1e-7 at the first of the frequencies.
        rows.push(CheckRow::relative(
            format!("damping, K {k}, B {b}"),
            claim,
            worst,
            truths::virtual_wall_damping(k, b, period_s),
            1e-6,
        ));
    }
}
