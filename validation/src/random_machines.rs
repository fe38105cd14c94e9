//! Random machines: impulse responses by linear theory and by simulation, poles and zeros by substitution.

use feeler_analysis::{LinearMachine, View};
use feeler_control::Stream;
use feeler_engine::{Program, RunSettings, Scenario, Simulation, Trace};
use feeler_lti::{C64, expm_action};
use feeler_plant::description::{Actuator, ActuatorKind, Body, GROUND, Machine, Quantity, SignalName};
use nalgebra::{DMatrix, DVector};

use crate::error::ValidationError;
use crate::paper::spring;
use crate::table::Row;

/// Asked of impulse responses, relative to their largest value.
const IMPULSE: f64 = 1e-8;
/// Smallest singular value of the equilibrated matrix that a pole or zero makes singular: a hundred roundings, times what equilibration amplifies.
const SUBSTITUTION: f64 = 1e-9;

/// A random tree: up to six bodies, each on a spring to an earlier one or to ground, masses and stiffnesses over four decades.
pub fn random_machine(seed: u64) -> Machine {
    let stream = Stream::new(seed, "random machine");
    let mut draws = 0;
    let mut uniform = || {
        draws += 1;
        // A normal draw through its distribution's logistic likeness is spread well enough over (0, 1).
        1.0 / (1.0 + (-1.702 * stream.normal_at(draws)).exp())
    };
    let mut machine = Machine { name: format!("random {seed}"), ..Machine::default() };
    let bodies = 1 + (uniform() * 5.999) as usize;
    for i in 0..bodies {
        let mass_kg = 0.1 * 10_f64.powf(4.0 * uniform());
        machine.bodies.insert(format!("body{i}"), Body { mass_kg, ..Body::default() });
        let parent = (uniform() * (i as f64 + 0.999)) as usize;
        let other = if parent == i { GROUND.to_string() } else { format!("body{parent}") };
        let k = 1e3 * 10_f64.powf(4.0 * uniform());
        let c = 2.0 * (0.002 + 0.1 * uniform()) * (k * mass_kg).sqrt();
        machine.springs.insert(format!("spring{i}"), spring(&other, &format!("body{i}"), k, c));
    }
    let on = format!("body{}", (uniform() * (bodies as f64 - 0.001)) as usize);
    let kind = ActuatorKind::Force { bandwidth_hz: None };
    let drive = Actuator { on, reacts_on: GROUND.into(), kind, limit_n: None, rate_limit_per_s: None, effects: Vec::new() };
    machine.actuators.insert("drive".into(), drive);
    machine
}

/// Largest relative difference between analytic and simulated response to an impulse on the driven body, seen at the last body's velocity;
/// and the worst ratio by which poles and zeros fail their substitution.
fn check(seed: u64) -> Result<(f64, f64), ValidationError> {
    let machine = random_machine(seed);
    let plant = LinearMachine::new(&machine, &View::default())?;
    let last = format!("body{}", machine.bodies.len() - 1);
    let output = SignalName::new(&last, Quantity::Velocity);
    let row = plant.output(plant.source(&output)?)?;
    let fastest = feeler_lti::eigenvalues(plant.a())?.iter().map(|p| p.norm()).fold(0.0, f64::max);
    let step_s = 0.37 / fastest;
    let samples = 60;

    // An impulse leaves behind a jump of the state by B.
    let start: DVector<f64> = plant.b().column(0).into_owned();
    let scenario = Scenario {
        machine: machine.clone(),
        controllers: [].into_iter().collect(),
        run: RunSettings { duration_s: f64::from(samples) * step_s, step_s, record: vec![output.clone()], ..RunSettings::default() },
    };
    let program = Program::new(&scenario)?;
    let mut trace = Trace::new(program.record_names());
    let mut simulation = Simulation::<f64>::new(vec![program])?;
    simulation.set_state(0, start.as_slice())?;
    simulation.run(&mut trace)?;
    let mut worst: f64 = 0.0;
    let mut scale: f64 = 0.0;
    for (t, got) in trace.t_s.iter().zip(&trace.columns[0]) {
        let expected = (&row.c * expm_action(plant.a(), &start, *t)?)[(0, 0)];
        worst = worst.max((got - expected).abs());
        scale = scale.max(expected.abs());
    }
    // A body that the impulse hardly reaches is compared with the one that it hits.
    let hit = start.amax();
    let impulse = worst / scale.max(1e-6 * hit);

    let channel = plant.channel(&SignalName::new("drive", Quantity::Command), &output)?;
    let system = &channel.system;
    let n = system.states();
    let mut substitution: f64 = 0.0;
    for pole in channel.poles()? {
        let pencil = DMatrix::from_fn(n, n, |i, j| C64::new(system.a()[(i, j)], 0.0) - if i == j { pole } else { C64::new(0.0, 0.0) });
        substitution = substitution.max(singularity(pencil));
    }
    for zero in channel.zeros()? {
        let pencil = DMatrix::from_fn(n + 1, n + 1, |i, j| match (i < n, j < n) {
            (true, true) => C64::new(system.a()[(i, j)], 0.0) - if i == j { zero } else { C64::new(0.0, 0.0) },
            (true, false) => C64::new(system.b()[(i, 0)], 0.0),
            (false, true) => C64::new(system.c()[(0, j)], 0.0),
            (false, false) => C64::new(system.d()[(0, 0)], 0.0),
        });
        substitution = substitution.max(singularity(pencil));
    }
    Ok((impulse, substitution))
}

/// Smallest singular value of a matrix whose rows and columns have been brought to the same size.
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

/// Rows for so many machines.
///
/// # Errors
/// [`ValidationError`] where a computation fails.
pub fn random_machine_rows(machines: u64) -> Result<Vec<Row>, ValidationError> {
    let claim = "random machines: linear theory and simulation agree";
    let mut worst = (0.0_f64, 0.0_f64);
    for seed in 0..machines {
        let (impulse, substitution) = check(seed)?;
        worst = (worst.0.max(impulse), worst.1.max(substitution));
    }
    Ok(vec![
        Row::at_most(format!("{machines} impulse responses, relative difference"), claim, worst.0, IMPULSE),
        Row::at_most(format!("{machines} machines' poles and zeros by substitution"), claim, worst.1, SUBSTITUTION),
    ])
}
