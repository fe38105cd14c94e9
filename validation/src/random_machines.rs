//! Random machines: impulse responses by linear theory and by simulation, poles and zeros by substitution.

use feeler_analysis::{LinearMachine, View};
use feeler_control::Stream;
use feeler_engine::{Program, RunSettings, Scenario, Simulation, Trace};
use feeler_lti::{C64, expm};
use feeler_plant::description::{Actuator, Body, GROUND, Machine, Quantity, SignalName, Spring};
use nalgebra::{DMatrix, DVector};

use crate::error::ValidationError;
use crate::table::CheckRow;

/// Tolerance of impulse responses, relative to their largest value.
const IMPULSE: f64 = 1e-8;
/// Samples of a response, and the angle of the motion between two of them, rad: 3.5 turns.
const SAMPLES: u32 = 60;
const STEP_RAD: f64 = 0.37;
/// A body whose speed stays below this share of the excited one is compared relative to that one.
const FAINT: f64 = 1e-6;
/// Smallest singular value of the equilibrated matrix that a pole or zero makes singular: a hundred
/// roundings, amplified by the equilibration.
const SUBSTITUTION: f64 = 1e-9;

/// A random tree: up to six bodies, each on a spring to an earlier one or to ground, masses and stiffnesses
/// over four decades.
fn random_machine(seed: u64) -> Machine {
    let stream = Stream::new(seed, "random machine");
    let mut draws = 0;
    let mut uniform = || {
        draws += 1;
        // A normal draw through a logistic approximation of its distribution is spread well enough over (0,
        // 1).
        1.0 / (1.0 + (-1.702 * stream.normal_at(draws)).exp())
    };
    let mut machine = Machine::new(format!("random {seed}"));
    let bodies = 1 + (uniform() * 5.999) as usize;
    for i in 0..bodies {
        let mass_kg = 0.1 * 10_f64.powf(4.0 * uniform());
        machine.bodies.insert(format!("body{i}"), Body::new(mass_kg));
        let parent = (uniform() * (i as f64 + 0.999)) as usize;
        let other = if parent == i { GROUND.to_string() } else { format!("body{parent}") };
        let k = 1e3 * 10_f64.powf(4.0 * uniform());
        let c = 2.0 * (0.002 + 0.1 * uniform()) * (k * mass_kg).sqrt();
        machine.springs.insert(format!("spring{i}"), Spring::new(other, format!("body{i}"), k, c));
    }
    let on = format!("body{}", (uniform() * (bodies as f64 - 0.001)) as usize);
    machine.actuators.insert("drive".into(), Actuator::ideal(on, GROUND));
    machine
}

/// The state matrix over positions and velocities, and the state after a unit impulse on the driven body,
/// from Newton's law for each body.
fn by_newton(machine: &Machine) -> (DMatrix<f64>, DVector<f64>) {
    let n = machine.bodies.len();
    let mut a = DMatrix::zeros(2 * n, 2 * n);
    let mass = |i: usize| machine.bodies[i].mass_kg;
    let index = |name: &str| machine.bodies.get_index_of(name);
    for i in 0..n {
        a[(i, n + i)] = 1.0;
    }
    for link in machine.springs.values() {
        let [from, to] = [&link.between[0], &link.between[1]].map(|name| index(name));
        for (this, other) in [(from, to), (to, from)] {
            let Some(i) = this else { continue };
            for (column, factor) in [(Some(i), -1.0), (other, 1.0)] {
                let Some(j) = column else { continue };
                a[(n + i, j)] += factor * link.stiffness_n_per_m / mass(i);
                a[(n + i, n + j)] += factor * link.damping_n_s_per_m / mass(i);
            }
        }
    }
    let mut start = DVector::zeros(2 * n);
    if let Some(hit) = index(&machine.actuators[0].on) {
        start[n + hit] = 1.0 / mass(hit);
    }
    (a, start)
}

/// Largest relative difference of velocities after a unit impulse on the driven body from those of Newton's
/// law, simulated and by linear theory. It is taken over every body, over the fastest and over the slowest
/// motion.
fn impulse_difference(machine: &Machine, plant: &LinearMachine) -> Result<f64, ValidationError> {
    let (a, start) = by_newton(machine);
    let n = machine.bodies.len();
    let outputs: Vec<SignalName> =
        machine.bodies.keys().map(|name| SignalName::new(name, Quantity::Velocity)).collect();
    let rows =
        outputs.iter().map(|output| plant.output(plant.source(output)?)).collect::<Result<Vec<_>, _>>()?;
    let rates: Vec<f64> = feeler_lti::eigenvalues(&a)?.iter().map(|p| p.norm()).collect();
    let (fastest, slowest) =
        (rates.iter().copied().fold(0.0, f64::max), rates.iter().copied().fold(f64::INFINITY, f64::min));
    let mut worst: f64 = 0.0;
    for step_s in [STEP_RAD / fastest, STEP_RAD / slowest] {
        let duration_s = f64::from(SAMPLES) * step_s;
        let run = RunSettings { duration_s, step_s, record: outputs.clone(), ..RunSettings::default() };
        let scenario = Scenario { run, ..Scenario::new(machine.clone()) };
        let program = Program::new(&scenario)?;
        let mut trace = Trace::new(program.record_names());
        let mut simulation = Simulation::<f64>::new(vec![program])?;
        // An impulse leaves a jump of the state by B.
        let theory_start: DVector<f64> = plant.b().column(0).into_owned();
        simulation.set_state(0, theory_start.as_slice())?;
        simulation.run(&mut trace)?;
        let (by_law, by_theory) = (expm(&(&a * step_s))?, expm(&(plant.a() * step_s))?);
        let (mut state, mut theory) = (start.clone(), theory_start);
        let mut scale = vec![FAINT * start.amax(); n];
        let mut difference = vec![0.0_f64; n];
        for k in 0..trace.t_s.len() {
            for i in 0..n {
                let expected = state[n + i];
                scale[i] = scale[i].max(expected.abs());
                for got in [trace.columns[i][k], (&rows[i].c * &theory)[(0, 0)]] {
                    difference[i] = difference[i].max((got - expected).abs());
                }
            }
            state = &by_law * state;
            theory = &by_theory * theory;
        }
        worst = difference.iter().zip(&scale).map(|(d, s)| d / s).fold(worst, f64::max);
    }
    Ok(worst)
}

/// The worst residual of poles and zeros, from the drive to the last body's velocity, in their substitution.
fn substitution(machine: &Machine, plant: &LinearMachine) -> Result<f64, ValidationError> {
    let output = SignalName::new(format!("body{}", machine.bodies.len() - 1), Quantity::Velocity);
    let channel = plant.channel(&SignalName::new("drive", Quantity::Command), &output)?;
    let system = &channel.system;
    let n = system.states();
    let mut substitution: f64 = 0.0;
    for pole in channel.poles()? {
        let pencil = DMatrix::from_fn(n, n, |i, j| {
            C64::new(system.a()[(i, j)], 0.0) - if i == j { pole } else { C64::new(0.0, 0.0) }
        });
        substitution = substitution.max(singularity(pencil));
    }
    for zero in channel.zeros()? {
        let pencil = DMatrix::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
            (true, true) => {
                C64::new(system.a()[(i, j)], 0.0) - if i == j { zero } else { C64::new(0.0, 0.0) }
            }
            (true, false) => C64::new(system.b()[(i, 0)], 0.0),
            (false, true) => C64::new(system.c()[(0, j)], 0.0),
            (false, false) => C64::new(system.d()[(0, 0)], 0.0),
        });
        substitution = substitution.max(singularity(pencil));
    }
    Ok(substitution)
}

/// Smallest singular value of a matrix with equilibrated rows and columns.
fn singularity(mut matrix: DMatrix<C64>) -> f64 {
    for _ in 0..4 {
        for i in 0..matrix.nrows() {
            let norm = matrix.row(i).norm();
            matrix.row_mut(i).unscale_mut(if norm > 0.0 { norm } else { 1.0 });
        }
        for j in 0..matrix.ncols() {
            let norm = matrix.column(j).norm();
            matrix.column_mut(j).unscale_mut(if norm > 0.0 { norm } else { 1.0 });
        }
    }
    matrix.singular_values().min()
}

/// Rows for `machines` random machines.
///
/// # Errors
/// [`ValidationError`] if a computation fails.
pub fn random_machine_rows(machines: u64) -> Result<Vec<CheckRow>, ValidationError> {
    let claim = "random machines: linear theory and simulation agree";
    let mut worst = (0.0_f64, 0.0_f64);
    for seed in 0..machines {
        let machine = random_machine(seed);
        let plant = LinearMachine::new(&machine, &View::default())?;
        worst = (
            worst.0.max(impulse_difference(&machine, &plant)?),
            worst.1.max(substitution(&machine, &plant)?),
        );
    }
    Ok(vec![
        CheckRow::at_most(
            format!("{machines} impulse responses, relative difference"),
            claim,
            worst.0,
            IMPULSE,
        ),
        CheckRow::at_most(
            format!("{machines} machines' poles and zeros by substitution"),
            claim,
            worst.1,
            SUBSTITUTION,
        ),
    ])
}
