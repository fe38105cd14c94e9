//! Three ways to step: semi-implicit Euler, RK4, and RK4 that stops at touch and release.

use super::control::{Control, PERIOD_S};
use super::fma;
use super::plants::Plant;

/// The peak force is taken on a grid of 0.1 ms, whatever the step.
const LOOKS_PER_SAMPLE: usize = 10;
/// Largest number of evaluations to locate a crossing to machine precision.
const MOST_LOOKS: usize = 60;
/// The search ends when two evaluations are this close, s. It ends past the crossing, so that the next mode
/// begins within its bounds.
const INSTANT_S: f64 = 1e-15;

/// Integration method.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Semi-implicit Euler.
    SemiImplicitEuler,
    /// Classical RK4 without detection of touch and release.
    Rk4,
    /// Classical RK4 in one mode at a time, cut at the located touch or release.
    Rk4WithEvents,
}

/// Results of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunResult {
    /// Largest contact force on a grid of 0.1 ms, N.
    pub peak_force_n: f64,
    /// Contact force at the end, N.
    pub final_force_n: f64,
}

/// Runs a machine for `samples` controller periods of 1 ms, each divided into `steps_per_sample` equal steps,
/// a multiple of ten.
#[inline(never)]
pub fn run<const S: usize>(
    plant: &impl Plant<S>,
    method: Method,
    samples: usize,
    steps_per_sample: usize,
) -> RunResult {
    match method {
        Method::SemiImplicitEuler => sampled(plant, samples, steps_per_sample, semi_implicit_euler),
        Method::Rk4 => sampled(plant, samples, steps_per_sample, rk4_blind),
        Method::Rk4WithEvents => sampled(plant, samples, steps_per_sample, rk4_with_events),
    }
}

/// The contact law within a step.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Mode {
    Free,
    Pushing,
    /// The state decides whether the contact pushes.
    Either,
}

#[inline(always)]
fn sampled<const S: usize, P: Plant<S>>(
    plant: &P,
    samples: usize,
    steps: usize,
    step: impl Fn(&P, &mut [f64; S], &mut bool, f64, f64),
) -> RunResult {
    let mut x = plant.start();
    let mut pushing = false;
    let mut peak = 0.0_f64;
    let mut force = contact(plant, &x);
    let mut controller = plant.controller();
    let mut reading = plant.reading_n(&x, force);
    let h = PERIOD_S / steps as f64;
    for _ in 0..samples {
        let u = controller.command_n(reading);
        for look in 1..=LOOKS_PER_SAMPLE {
            for _ in 0..steps / LOOKS_PER_SAMPLE {
                step(plant, &mut x, &mut pushing, u, h);
            }
            force = contact(plant, &x);
            peak = if force > peak { force } else { peak };
            if look == LOOKS_PER_SAMPLE - P::READ_LATE {
                reading = plant.reading_n(&x, force);
            }
        }
    }
    RunResult { peak_force_n: peak, final_force_n: force }
}

/// Total contact force, `max(0, k_s d + b_s d')` for `d > 0`.
#[inline(always)]
fn contact<const S: usize>(plant: &impl Plant<S>, x: &[f64; S]) -> f64 {
    let compression = plant.compression(x);
    let force = plant.contact_force_n(compression);
    if compression[0] > 0.0 && force > 0.0 { force } else { 0.0 }
}

#[inline(always)]
fn slope<const S: usize>(plant: &impl Plant<S>, x: &[f64; S], u: f64, mode: Mode) -> [f64; S] {
    let force = match mode {
        Mode::Free => 0.0,
        Mode::Pushing => plant.contact_force_n(plant.compression(x)),
        Mode::Either => contact(plant, x),
    };
    plant.slopes(x, u, force)
}

/// `x + s k`.
#[inline(always)]
fn along<const S: usize>(x: &[f64; S], k: &[f64; S], s: f64) -> [f64; S] {
    let mut there = *x;
    for i in 0..S {
        there[i] = fma(s, k[i], there[i]);
    }
    there
}

#[inline(always)]
fn rk4_blind<const S: usize>(plant: &impl Plant<S>, x: &mut [f64; S], _: &mut bool, u: f64, h: f64) {
    rk4(plant, x, u, h, Mode::Either);
}

#[inline(always)]
fn semi_implicit_euler<const S: usize>(
    plant: &impl Plant<S>,
    x: &mut [f64; S],
    _: &mut bool,
    u: f64,
    h: f64,
) {
    let slopes = plant.slopes(x, u, contact(plant, x));
    for i in 0..S / 2 {
        x[i + S / 2] = fma(h, slopes[i + S / 2], x[i + S / 2]);
        x[i] = fma(h, x[i + S / 2], x[i]);
    }
    for i in S / 2 * 2..S {
        x[i] = fma(h, slopes[i], x[i]);
    }
}

#[inline(always)]
fn rk4<const S: usize>(plant: &impl Plant<S>, x: &mut [f64; S], u: f64, h: f64, mode: Mode) {
    let k1 = slope(plant, x, u, mode);
    let k2 = slope(plant, &along(x, &k1, 0.5 * h), u, mode);
    let k3 = slope(plant, &along(x, &k2, 0.5 * h), u, mode);
    let k4 = slope(plant, &along(x, &k3, h), u, mode);
    for i in 0..S {
        x[i] = fma(h / 6.0, fma(2.0, k2[i] + k3[i], k1[i] + k4[i]), x[i]);
    }
}

#[inline(always)]
fn part<const S: usize>(plant: &impl Plant<S>, x: &[f64; S], u: f64, h: f64, mode: Mode) -> [f64; S] {
    let mut there = *x;
    rk4(plant, &mut there, u, h, mode);
    there
}

/// Positive while the mode lasts. In free motion the contact may still be compressed after a release, and
/// pushes again when its force becomes positive.
#[inline(always)]
fn guard<const S: usize>(plant: &impl Plant<S>, x: &[f64; S], pushing: bool) -> f64 {
    let compression = plant.compression(x);
    let force = plant.contact_force_n(compression);
    if pushing { force } else { -compression[0].min(force) }
}

#[inline(always)]
fn rk4_with_events<const S: usize>(
    plant: &impl Plant<S>,
    x: &mut [f64; S],
    pushing: &mut bool,
    u: f64,
    h: f64,
) {
    let start = *x;
    rk4(plant, x, u, h, if *pushing { Mode::Pushing } else { Mode::Free });
    if guard(plant, x, *pushing) < 0.0 {
        *x = start;
        through_event(plant, x, pushing, u, h);
    }
}

/// A step that contains a touch or release: the Illinois method on steps from the start, then the rest in the
/// other mode.
#[cold]
#[inline(never)]
fn through_event<const S: usize>(
    plant: &impl Plant<S>,
    x: &mut [f64; S],
    pushing: &mut bool,
    u: f64,
    h: f64,
) {
    let mode = if *pushing { Mode::Pushing } else { Mode::Free };
    let (mut a, mut b) = (0.0, h);
    let (mut g_a, mut g_b) = (guard(plant, x, *pushing), guard(plant, &part(plant, x, u, h, mode), *pushing));
    let mut kept_a = false;
    if g_a <= 0.0 {
        b = 0.0;
    }
    for _ in 0..MOST_LOOKS {
        if b - a < INSTANT_S {
            break;
        }
        let s = (a * g_b - b * g_a) / (g_b - g_a);
        let g = guard(plant, &part(plant, x, u, s, mode), *pushing);
        let before = if g <= 0.0 { std::mem::replace(&mut b, s) } else { a };
        if g <= 0.0 {
            g_b = g;
            g_a *= if kept_a { 0.5 } else { 1.0 };
        } else {
            (a, g_a) = (s, g);
            g_b *= if kept_a { 1.0 } else { 0.5 };
        }
        kept_a = g <= 0.0;
        if kept_a && before - b < INSTANT_S {
            break;
        }
    }
    *x = part(plant, x, u, b, mode);
    *pushing = !*pushing;
    rk4(plant, x, u, h - b, if *pushing { Mode::Pushing } else { Mode::Free });
}
