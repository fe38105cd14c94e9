//! Newton-Euler recursion along a chain: R. Featherstone, "Rigid Body Dynamics Algorithms", 2008, ch. 5; here
//! in vectors of the base's frame.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::chain::{Chain, JointKind};
use crate::posture::Posture;

impl Chain {
    /// Joint efforts for the acceleration `acceleration` at a state, including gravity: `M a + C v + g`.
    pub fn inverse_dynamics(&self, q: &[f64], v: &[f64], acceleration: &[f64]) -> DVector<f64> {
        self.posture(q).efforts(v, acceleration, &self.gravity_m_per_s2)
    }

    /// Joint efforts of centrifugal and Coriolis forces, `C(q, v) v`.
    pub fn coriolis_efforts(&self, q: &[f64], v: &[f64]) -> DVector<f64> {
        self.posture(q).coriolis_efforts(v)
    }

    /// Mass matrix of the links: kg m², kg m or kg, depending on the joints.
    pub fn mass_matrix(&self, q: &[f64]) -> DMatrix<f64> {
        self.posture(q).mass_matrix()
    }

    /// Kinetic energy of the links, and their potential energy in gravity (zero at the base), J.
    pub fn energy(&self, q: &[f64], v: &[f64]) -> [f64; 2] {
        let speeds = DVector::from_column_slice(v);
        let posture = self.posture(q);
        let kinetic = 0.5 * (posture.mass_matrix() * &speeds).dot(&speeds);
        let potential = self.joints.iter().zip(&posture.bodies).map(|(joint, body)| {
            let centre = body.frame.translation.vector + body.centre;
            -joint.inertial.mass_kg * self.gravity_m_per_s2.dot(&centre)
        });
        [kinetic, potential.sum()]
    }
}

impl Posture<'_> {
    /// Joint efforts of centrifugal and Coriolis forces, `C(q, v) v`.
    pub fn coriolis_efforts(&self, v: &[f64]) -> DVector<f64> {
        self.efforts(v, &vec![0.0; v.len()], &Vector3::zeros())
    }

    /// Mass matrix of the links: kg m², kg m or kg, depending on the joints. Each joint accelerates all that
    /// it carries as one rigid body, whose wrench the joints before it bear (composite rigid bodies;
    /// Featherstone, ch. 6).
    pub fn mass_matrix(&self) -> DMatrix<f64> {
        let joints = &self.chain.joints;
        let n = self.bodies.len();
        let mut matrix = DMatrix::zeros(n, n);
        let origin = |i: usize| self.bodies[i].frame.translation.vector;
        // All that joint `j` carries, about its origin: mass, mass times centre, and inertia.
        let (mut mass, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for (j, body) in self.bodies.iter().enumerate().rev() {
            if j + 1 < n {
                let ahead = origin(j + 1) - origin(j);
                second += about(&ahead, &(2.0 * first + mass * ahead));
                first += mass * ahead;
            }
            let own = joints[j].inertial.mass_kg;
            mass += own;
            first += own * body.centre;
            second += body.inertia + about(&body.centre, &(own * body.centre));
            // Force of the acceleration and its moment, which moves from joint to joint.
            let (force, mut moment) = match joints[j].kind {
                JointKind::Prismatic => (mass * body.axis, first.cross(&body.axis)),
                JointKind::Revolute | JointKind::Continuous => (body.axis.cross(&first), second * body.axis),
            };
            for i in (0..=j).rev() {
                if i < j {
                    moment += (origin(i + 1) - origin(i)).cross(&force);
                }
                let along = if joints[i].kind == JointKind::Prismatic { &force } else { &moment };
                let share = self.bodies[i].axis.dot(along);
                (matrix[(i, j)], matrix[(j, i)]) = (share, share);
            }
        }
        matrix
    }

    fn efforts(&self, v: &[f64], acceleration: &[f64], gravity: &Vector3<f64>) -> DVector<f64> {
        let joints = &self.chain.joints;
        let n = joints.len();
        let origin = |i: usize| self.bodies[i].frame.translation.vector;
        let [mut omega, mut alpha] = [Vector3::zeros(); 2];
        // A base that accelerates upwards is equivalent to gravity.
        let mut a = -gravity;
        let mut before = Vector3::zeros();
        let mut wrenches = Vec::with_capacity(n);
        for (i, (joint, body)) in joints.iter().zip(&self.bodies).enumerate() {
            let axis = body.axis;
            let r = origin(i) - before;
            a += alpha.cross(&r) + omega.cross(&omega.cross(&r));
            if joint.kind == JointKind::Prismatic {
                a += axis * acceleration[i] + 2.0 * omega.cross(&(axis * v[i]));
            } else {
                alpha += axis * acceleration[i] + omega.cross(&(axis * v[i]));
                omega += axis * v[i];
            }
            before = origin(i);
            let arm = body.centre;
            let force = joint.inertial.mass_kg * (a + alpha.cross(&arm) + omega.cross(&omega.cross(&arm)));
            let moment = body.inertia * alpha + omega.cross(&(body.inertia * omega)) + arm.cross(&force);
            wrenches.push((force, moment));
        }
        let mut efforts = DVector::zeros(n);
        let [mut force, mut moment] = [Vector3::zeros(); 2];
        for i in (0..n).rev() {
            if i + 1 < n {
                moment += (origin(i + 1) - origin(i)).cross(&force);
            }
            force += wrenches[i].0;
            moment += wrenches[i].1;
            let along = if joints[i].kind == JointKind::Prismatic { &force } else { &moment };
            efforts[i] = self.bodies[i].axis.dot(along);
        }
        efforts
    }
}

/// The symmetric part of `(a . b) 1 - a b'`: the inertia of a mass at `a`, where `b` is the mass times `a`.
fn about(a: &Vector3<f64>, b: &Vector3<f64>) -> Matrix3<f64> {
    let product = a * b.transpose();
    Matrix3::from_diagonal_element(product.trace()) - 0.5 * (product + product.transpose())
}
