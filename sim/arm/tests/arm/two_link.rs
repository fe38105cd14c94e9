//! A planar arm of two links, compared with the closed-form Lagrangian, with conservation of energy in a free
//! swing, and with Rapier's reduced coordinates.

#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "helpers of tests fail as tests do, and say what they measured"
)]

use feeler_arm::{Chain, Urdf};
use rapier3d_f64::prelude as rapier;

/// Rounding of a few dozen products of numbers near one.
const ROUNDING: f64 = 1e-12;

/// Lengths, centres of mass, masses and inertias.
struct Links {
    l1: f64,
    c: [f64; 2],
    m: [f64; 2],
    i: [f64; 2],
}

const LINKS: Links = Links { l1: 0.7, c: [0.31, 0.22], m: [3.4, 2.1], i: [0.21, 0.09] };
const G: f64 = 9.806_65;

/// An arm in the x-z plane. Joints turn about -y, so that angles count from x towards z.
fn arm() -> Chain {
    let Links { l1, c, m, i } = LINKS;
    let text = format!(
        r#"<robot name="planar"><link name="base"/>
        <link name="one"><inertial><origin xyz="{} 0 0"/><mass value="{}"/>
        <inertia ixx="{i0}" iyy="{i0}" izz="{i0}"/></inertial></link>
        <link name="two"><inertial><origin xyz="{} 0 0"/><mass value="{}"/>
        <inertia ixx="{i1}" iyy="{i1}" izz="{i1}"/></inertial></link>
        <link name="tip"/>
        <joint name="a" type="continuous"><parent link="base"/><child link="one"/><axis xyz="0 -1 0"/></joint>
        <joint name="b" type="continuous"><parent link="one"/><child link="two"/>
        <origin xyz="{l1} 0 0"/><axis xyz="0 -1 0"/></joint>
        <joint name="c" type="fixed"><parent link="two"/><child link="tip"/>
        <origin xyz="0.5 0 0"/></joint></robot>"#,
        c[0],
        m[0],
        c[1],
        m[1],
        i0 = i[0],
        i1 = i[1],
    );
    Urdf::parse(&text).unwrap().chain("tip").unwrap()
}

#[test]
fn truth_mass_gravity_and_coriolis_are_the_lagrangian_s() {
    let chain = arm();
    let Links { l1, c, m, i } = LINKS;
    for k in 0..40 {
        let k = f64::from(k);
        let (q, v, a) = ([0.37 * k, 2.0 - 0.61 * k], [1.3 - 0.2 * k, 0.17 * k], [0.4 * k, 3.0 - 0.3 * k]);
        // Spong, Hutchinson, Vidyasagar, "Robot Modeling and Control", 2006, sec. 7.4.
        let (cos, sin) = (q[1].cos(), q[1].sin());
        let coupling = m[1] * l1 * c[1];
        let m11 = i[0] + i[1] + m[0] * c[0] * c[0] + m[1] * (l1 * l1 + c[1] * c[1]) + 2.0 * coupling * cos;
        let m12 = i[1] + m[1] * c[1] * c[1] + coupling * cos;
        let m22 = i[1] + m[1] * c[1] * c[1];
        let h = -coupling * sin;
        let coriolis = [h * (2.0 * v[0] * v[1] + v[1] * v[1]), -h * v[0] * v[0]];
        let outer = m[1] * c[1] * G * (q[0] + q[1]).cos();
        let gravity = [(m[0] * c[0] + m[1] * l1) * G * q[0].cos() + outer, outer];
        let mass = chain.mass_matrix(&q);
        for (found, expected) in
            [(mass[(0, 0)], m11), (mass[(0, 1)], m12), (mass[(1, 0)], m12), (mass[(1, 1)], m22)]
        {
            assert!((found - expected).abs() < ROUNDING * m11, "{q:?}: {found} {expected}");
        }
        let still = [0.0; 2];
        let found_gravity = chain.inverse_dynamics(&q, &still, &still);
        let found_coriolis = chain.coriolis_efforts(&q, &v);
        let all = chain.inverse_dynamics(&q, &v, &a);
        let masses = [m11 * a[0] + m12 * a[1], m12 * a[0] + m22 * a[1]];
        for j in 0..2 {
            let size = 1.0 + masses[j].abs() + coriolis[j].abs() + gravity[j].abs();
            assert!(
                (found_coriolis[j] - coriolis[j]).abs() < ROUNDING * size,
                "{q:?} {v:?}: {} {}",
                found_coriolis[j],
                coriolis[j]
            );
            assert!(
                (found_gravity[j] - gravity[j]).abs() < ROUNDING * size,
                "{q:?}: {} {}",
                found_gravity[j],
                gravity[j]
            );
            assert!(
                (all[j] - masses[j] - coriolis[j] - gravity[j]).abs() < 10.0 * ROUNDING * size,
                "{}",
                all[j]
            );
        }
    }
}

/// Angles and energy (kinetic and potential, J) of the arm without drives or friction, from rest and after
/// every classical Runge-Kutta step.
fn free_swing(chain: &Chain, from: [f64; 2], step_s: f64, duration_s: f64) -> Vec<([f64; 2], f64)> {
    let slope = |[a, b, v, w]: [f64; 4]| {
        let bias = chain.inverse_dynamics(&[a, b], &[v, w], &[0.0; 2]);
        let acceleration = chain.mass_matrix(&[a, b]).cholesky().unwrap().solve(&-bias);
        [v, w, acceleration[0], acceleration[1]]
    };
    let moved = |x: [f64; 4], by: [f64; 4], step_s: f64| -> [f64; 4] {
        std::array::from_fn(|i| x[i] + step_s * by[i])
    };
    let state = |[a, b, v, w]: [f64; 4]| ([a, b], chain.energy(&[a, b], &[v, w]).iter().sum::<f64>());
    let mut x = [from[0], from[1], 0.0, 0.0];
    let mut states = vec![state(x)];
    for _ in 0..(duration_s / step_s).round() as usize {
        let a = slope(x);
        let b = slope(moved(x, a, 0.5 * step_s));
        let c = slope(moved(x, b, 0.5 * step_s));
        let d = slope(moved(x, c, step_s));
        let mean: [f64; 4] = std::array::from_fn(|i| (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]) / 6.0);
        x = moved(x, mean, step_s);
        states.push(state(x));
    }
    states
}

#[test]
fn order_energy_of_the_free_swing_drifts_with_the_fourth_power_of_the_step() {
    let chain = arm();
    let drift = |step_s: f64| {
        let states = free_swing(&chain, [0.2, 0.9], step_s, 10.0);
        let start_j = states[0].1;
        // Relative to the exchanged energy: about 20 J.
        states.iter().map(|(_, energy_j)| (energy_j - start_j).abs()).fold(0.0, f64::max) / 20.0
    };
    let drifts = [8e-3, 4e-3, 2e-3].map(drift);
    println!("energy drift over 10 s at 8, 4, 2 ms: {drifts:?}");
    // An error of fourth order dissipates energy at fifth order if its sign is constant. In a double pendulum
    // it hardly is: the order lies between 4 and 5.
    for pair in drifts.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((3.5..6.0).contains(&order), "{drifts:?} {order}");
    }
    assert!(drifts[2] < 1e-6, "{drifts:?}");
}

/// The same arm as a multibody of Rapier; its angles after 0.5 s.
fn rapier_swing(chain: &Chain, step_s: f64) -> [f64; 2] {
    let mut world = rapier::PhysicsWorld {
        gravity: rapier::Vector::new(0.0, 0.0, -G),
        ..rapier::PhysicsWorld::default()
    };
    world.integration_parameters.dt = step_s;
    let mut parent = world.insert_body(rapier::RigidBodyBuilder::fixed());
    let mut bodies = Vec::new();
    for (i, joint) in chain.joints.iter().enumerate() {
        let centre = rapier::Vector::new(joint.inertial.centre_m.x, 0.0, 0.0);
        let inertia = rapier::Vector::splat(joint.inertial.inertia_kg_m2[(0, 0)]);
        let properties = rapier::MassProperties::new(centre, joint.inertial.mass_kg, inertia);
        let x = if i == 0 { 0.0 } else { LINKS.l1 };
        let pose = rapier::Pose::from_translation(rapier::Vector::new(x, 0.0, 0.0));
        let body = world.insert_body(
            rapier::RigidBodyBuilder::dynamic()
                .pose(pose)
                .additional_mass_properties(properties)
                .can_sleep(false),
        );
        let hinge = rapier::RevoluteJointBuilder::new(-rapier::Vector::Y)
            .local_anchor1(rapier::Vector::new(x, 0.0, 0.0));
        let handle = world.multibody_joints.insert(parent, body, hinge, true).unwrap();
        // By default Rapier damps joints.
        world.multibody_joints.get_mut(handle).unwrap().0.damping_mut().fill(0.0);
        bodies.push(body);
        parent = body;
    }
    for _ in 0..(0.5 / step_s).round() as usize {
        world.step();
    }
    let [a, b] = [bodies[0], bodies[1]].map(|body| {
        let rotation = world.bodies[body].rotation();
        -2.0 * rotation.y.atan2(rotation.w)
    });
    [a, b - a]
}

#[test]
fn reference_rapier_s_reduced_coordinates_swing_the_same_way() {
    let chain = arm();
    // Stretched out, where the coordinates of Rapier's joints start.
    let (own, _) = *free_swing(&chain, [0.0, 0.0], 1e-3, 0.5).last().unwrap();
    let errors = [2e-3, 1e-3, 5e-4].map(|step_s| {
        let found = rapier_swing(&chain, step_s);
        (0..2).map(|i| (found[i] - own[i]).sin().abs()).fold(0.0, f64::max)
    });
    println!("Rapier at 2, 1, 0.5 ms: {errors:?} rad");
    assert!(errors[2] < 0.02, "{errors:?}");
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 1.0).abs() < 0.25, "{errors:?} {order}");
    }
}
