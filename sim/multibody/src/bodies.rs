//! The bodies of one machine in a Rapier world.

use std::f64::consts::{FRAC_PI_4, TAU};
use std::fmt;

use feeler_engine::{BodyEngine, EngineError, RunSettings};
use feeler_plant::description::Axis;
use feeler_plant::motion::Motion;
use feeler_plant::problem::Problem;
use rapier3d_f64::prelude::{
    IntegrationParameters, MassProperties, PhysicsWorld, Pose, PrismaticJointBuilder, RevoluteJointBuilder,
    RigidBodyBuilder, RigidBodyHandle, Rotation, Vector,
};

/// Largest rotation in one step, rad. Rapier integrates orientations to first order and normalises them, with
/// an error of a twelfth of the cube of the rotation. Within this limit the error is less than a twentieth of
/// the rotation, and the direction of rotation is unambiguous.
pub const LARGEST_TURN: f64 = FRAC_PI_4;

/// The moving bodies of a machine, stepped by Rapier.
pub struct RapierBodies {
    world: PhysicsWorld,
    axis: Axis,
    bodies: Vec<Tracked>,
}

/// A body, and its last pose from Rapier.
struct Tracked {
    handle: RigidBodyHandle,
    position: f64,
    speed: f64,
}

impl RapierBodies {
    /// One Rapier body per coordinate of `motion`, at the machine's initial state. Rigidly joined bodies
    /// become one body with the sum of the masses.
    pub fn new(motion: &Motion, axis: Axis) -> Self {
        let mut world = PhysicsWorld { gravity: Vector::ZERO, ..PhysicsWorld::default() };
        world.integration_parameters = IntegrationParameters {
            // With constant forces, sub-steps would only move positions ahead of their velocities.
            num_solver_iterations: 1,
            // Rapier's default speed limit would hide a motion that diverges.
            normalized_max_linear_velocity: f64::MAX,
            ..IntegrationParameters::default()
        };
        let ground = world.insert_body(RigidBodyBuilder::fixed());
        let state = motion.initial_state();
        let layout = motion.layout();
        let bodies = (0..motion.coordinates().count())
            .map(|g| {
                let (mass, position, speed) =
                    (motion.coordinates().mass_kg(g), state[layout.q(g)], state[layout.v(g)]);
                // The mass of a rotating body and the inertia of a sliding one have no effect, but must not
                // be zero.
                let properties = MassProperties::new(Vector::ZERO, mass, Vector::splat(mass));
                let body = RigidBodyBuilder::dynamic()
                    .additional_mass_properties(properties)
                    .can_sleep(false)
                    .allow_fast_rotation(true);
                let handle = world.insert_body(body);
                match axis {
                    Axis::Translational => {
                        world.insert_impulse_joint(ground, handle, PrismaticJointBuilder::new(Vector::X))
                    }
                    Axis::Rotational => {
                        world.insert_impulse_joint(ground, handle, RevoluteJointBuilder::new(Vector::X))
                    }
                };
                let mut tracked = Tracked { handle, position, speed };
                tracked.place(&mut world, axis, position, speed);
                tracked
            })
            .collect();
        Self { world, axis, bodies }
    }
}

impl Tracked {
    fn place(&mut self, world: &mut PhysicsWorld, axis: Axis, position: f64, speed: f64) {
        let body = &mut world.bodies[self.handle];
        let (pose, along) = match axis {
            Axis::Translational => {
                (Pose::from_translation(Vector::new(position, 0.0, 0.0)), Vector::new(speed, 0.0, 0.0))
            }
            Axis::Rotational => {
                (Pose::from_rotation(Rotation::from_rotation_x(position)), Vector::new(speed, 0.0, 0.0))
            }
        };
        body.set_position(pose, false);
        match axis {
            Axis::Translational => body.set_linvel(along, false),
            Axis::Rotational => body.set_angvel(along, false),
        }
        (self.position, self.speed) = (position, speed);
    }

    fn read(&mut self, world: &PhysicsWorld, axis: Axis, step_s: f64) -> Result<(), EngineError> {
        let body = &world.bodies[self.handle];
        match axis {
            Axis::Translational => (self.position, self.speed) = (body.translation().x, body.linvel().x),
            Axis::Rotational => {
                self.speed = body.angvel().x;
                let turned = 2.0 * body.rotation().x.atan2(body.rotation().w) - self.position;
                self.position += turned - TAU * (turned / TAU).round();
                if (self.speed * step_s).abs() > LARGEST_TURN {
                    return Err(too_fast(self.speed, step_s));
                }
            }
        }
        Ok(())
    }
}

fn too_fast(speed: f64, step_s: f64) -> EngineError {
    let message = format!(
        "a body turns at {speed:.4} rad/s, {:.3} rad in a step of {step_s:e} s, and Rapier \
         follows a turn of at most {LARGEST_TURN:.3} rad per step",
        (speed * step_s).abs()
    );
    let remedy = format!(
        "shorten `{}`, to {:.3e} s or less for this speed, or leave `{}` out: Feeler's own engine also \
         tells whether the motion is unstable",
        RunSettings::key(&RunSettings::STEP),
        LARGEST_TURN / speed.abs(),
        RunSettings::key(&RunSettings::ENGINE)
    );
    EngineError::Problems {
        problems: vec![Problem::new(RunSettings::key(&RunSettings::STEP), message, remedy)],
    }
}

impl BodyEngine for RapierBodies {
    fn step(
        &mut self,
        step_s: f64,
        forces_n: &[f64],
        positions_m: &mut [f64],
        speeds_m_per_s: &mut [f64],
    ) -> Result<(), EngineError> {
        self.world.integration_parameters.dt = step_s;
        for ((tracked, &force), (&position, &speed)) in
            self.bodies.iter_mut().zip(forces_n).zip(positions_m.iter().zip(speeds_m_per_s.iter()))
        {
            let left_there = |now: f64, then: f64| now.to_bits() == then.to_bits();
            if !(left_there(position, tracked.position) && left_there(speed, tracked.speed)) {
                tracked.place(&mut self.world, self.axis, position, speed);
            }
            let body = &mut self.world.bodies[tracked.handle];
            let along = Vector::new(force, 0.0, 0.0);
            match self.axis {
                Axis::Translational => {
                    body.reset_forces(false);
                    body.add_force(along, false);
                }
                Axis::Rotational => {
                    body.reset_torques(false);
                    body.add_torque(along, false);
                }
            }
        }
        self.world.step();
        for (tracked, (position, speed)) in
            self.bodies.iter_mut().zip(positions_m.iter_mut().zip(speeds_m_per_s.iter_mut()))
        {
            tracked.read(&self.world, self.axis, step_s)?;
            (*position, *speed) = (tracked.position, tracked.speed);
        }
        Ok(())
    }
}

impl fmt::Debug for RapierBodies {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("RapierBodies")
            .field("axis", &self.axis)
            .field("bodies", &self.bodies.len())
            .finish_non_exhaustive()
    }
}
