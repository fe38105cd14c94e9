//! Times Rapier on M1, M2 and M4 under the same sampled force control. Bodies move along x only; springs and
//! contact act on them as explicit forces.
//!
//! Prints the common CSV: program, method, machine, step, wall seconds per simulated second, peak contact
//! force.

use std::time::Instant;

use rapier3d_f64::prelude::*;

/// Number of samples. The first push contains the largest peak of every machine. A short run is more often
/// free of disturbance by other processes.
const SAMPLES: usize = 100;
const ROUNDS: usize = 25;

struct Machine {
    name: &'static str,
    masses_kg: &'static [f64],
    /// First body, second body or the ground, stiffness, damping.
    springs: &'static [(usize, Option<usize>, f64, f64)],
    driven: usize,
    reaction: Option<usize>,
    tip: usize,
    work: Option<usize>,
    start_m: &'static [f64],
}

const MACHINES: [Machine; 3] = [
    Machine {
        name: "M1",
        masses_kg: &[10.0],
        springs: &[(0, None, 0.0, 50.0)],
        driven: 0,
        reaction: None,
        tip: 0,
        work: None,
        start_m: &[-5e-3],
    },
    Machine {
        name: "M2",
        masses_kg: &[6.0, 4.0],
        springs: &[(0, None, 0.0, 50.0), (1, Some(0), 4e5, 60.0)],
        driven: 0,
        reaction: None,
        tip: 1,
        work: None,
        start_m: &[-5e-3, -5e-3],
    },
    Machine {
        name: "M4",
        masses_kg: &[200.0, 6.0, 4.0, 5.0],
        springs: &[
            (0, None, 1.1e6, 600.0),
            (1, Some(0), 0.0, 50.0),
            (2, Some(1), 4e5, 60.0),
            (3, Some(0), 1e6, 200.0),
        ],
        driven: 1,
        reaction: Some(0),
        tip: 2,
        work: Some(3),
        start_m: &[0.0, -5e-3, -5e-3, 0.0],
    },
];

fn main() {
    for machine in &MACHINES {
        for steps in [10, 20] {
            let mut walls: Vec<f64> = Vec::new();
            let mut peak_n = 0.0;
            for _ in 0..ROUNDS {
                let (wall_s, peak) = run(machine, steps);
                walls.push(wall_s);
                peak_n = peak;
            }
            walls.sort_by(f64::total_cmp);
            let step_s = 1e-3 / steps as f64;
            println!(
                "Rapier,\"semi-implicit Euler\",{},{step_s},{:.6e},{peak_n:.12}",
                machine.name,
                walls[ROUNDS / 2]
            );
        }
    }
}

/// Runs a machine. Returns wall seconds per simulated second, and the largest contact force (N) on a grid of
/// 0.1 ms.
fn run(machine: &Machine, steps: usize) -> (f64, f64) {
    let mut bodies = RigidBodySet::new();
    let handles: Vec<_> = (machine.masses_kg.iter().zip(machine.start_m))
        .map(|(&mass, &x)| {
            let body = RigidBodyBuilder::dynamic()
                .translation(Vector::new(x, 0.0, 0.0))
                .additional_mass(mass)
                .enabled_translations(true, false, false)
                .lock_rotations()
                .can_sleep(false);
            bodies.insert(body)
        })
        .collect();
    let parameters = IntegrationParameters { dt: 1e-3 / steps as f64, ..IntegrationParameters::default() };
    let mut colliders = ColliderSet::new();
    let mut pipeline = PhysicsPipeline::new();
    let mut islands = IslandManager::new();
    let mut broad_phase = DefaultBroadPhase::new();
    let mut narrow_phase = NarrowPhase::new();
    let mut joints = ImpulseJointSet::new();
    let mut multibodies = MultibodyJointSet::new();
    let mut continuous = CCDSolver::new();
    let mut soft_bodies = SoftBodySet::new();
    let mut peak = 0.0_f64;
    let mut force = 0.0;
    let begin = Instant::now();
    for _ in 0..SAMPLES {
        let u = (20.0 + 2.0 * (20.0 - force)).clamp(-200.0, 200.0);
        for i in 0..steps {
            let mut forces = [0.0; 4];
            let state = |i: usize| (bodies[handles[i]].translation().x, bodies[handles[i]].linvel().x);
            let between = |a: usize, b: Option<usize>| {
                let ((x_a, v_a), (x_b, v_b)) = (state(a), b.map_or((0.0, 0.0), &state));
                (x_a - x_b, v_a - v_b)
            };
            for &(a, b, stiffness, damping) in machine.springs {
                let (e, e_dot) = between(a, b);
                let f = stiffness * e + damping * e_dot;
                forces[a] -= f;
                if let Some(b) = b {
                    forces[b] += f;
                }
            }
            forces[machine.tip] -= force;
            if let Some(work) = machine.work {
                forces[work] += force;
            }
            forces[machine.driven] += u;
            if let Some(base) = machine.reaction {
                forces[base] -= u;
            }
            for (&handle, f) in handles.iter().zip(forces) {
                let body = &mut bodies[handle];
                body.reset_forces(false);
                body.add_force(Vector::new(f, 0.0, 0.0), false);
            }
            pipeline.step(
                Vector::new(0.0, 0.0, 0.0),
                &parameters,
                &mut islands,
                &mut broad_phase,
                &mut narrow_phase,
                &mut bodies,
                &mut colliders,
                &mut joints,
                &mut multibodies,
                &mut soft_bodies,
                &mut continuous,
                &(),
                &(),
            );
            let state = |i: usize| (bodies[handles[i]].translation().x, bodies[handles[i]].linvel().x);
            let ((x, v), (x_w, v_w)) = (state(machine.tip), machine.work.map_or((0.0, 0.0), state));
            let law = 1e5 * (x - x_w) + 100.0 * (v - v_w);
            force = if x > x_w { law.max(0.0) } else { 0.0 };
            if (i + 1) % (steps / 10) == 0 {
                peak = peak.max(force);
            }
        }
    }
    (begin.elapsed().as_secs_f64() / (SAMPLES as f64 * 1e-3), peak)
}
