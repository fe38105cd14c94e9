//! Position control of the tool's directions other than the normal.

use feeler_arm::Arm;
use nalgebra::{DMatrix, DVector, Isometry3, Vector3};

use crate::cell::Hold;

/// Singular values below this share of the largest are directions in which the arm cannot move.
const SINGULAR: f64 = 1e-6;
/// From this number of joints onwards, the tool's orientation is held as well.
const ALL_DIRECTIONS: usize = 6;

/// Holds the tool at a place in all directions but one. Let `T` be the Jacobian of the held directions and
/// `M` the mass of links and rotors. The torques are `T' (T M^-1 T')^-1 (w^2 e - 2 zeta w v)`. Source: O.
/// Khatib, "A unified approach for motion and force control of robot manipulators", IEEE J. Robotics and
/// Automation 3 (1987). Every held direction then has the natural frequency `w`, and none of these torques
/// pushes along the normal.
#[derive(Clone, Debug)]
pub(crate) struct HoldControl {
    hold: Hold,
    home: Isometry3<f64>,
    normal: Vector3<f64>,
    reflected: DVector<f64>,
}

impl HoldControl {
    pub(crate) fn new(arm: &Arm, hold: Hold, pose: &[f64], normal: Vector3<f64>) -> Self {
        Self { hold, home: arm.chain().tool_place(pose), normal, reflected: arm.reflected_inertia_kg_m2() }
    }

    /// Joint torques for a force along the normal and for holding the other directions, from the encoder
    /// readings.
    pub(crate) fn torques(
        &self,
        arm: &Arm,
        motors: &[f64],
        speeds: &DVector<f64>,
        force_n: f64,
    ) -> DVector<f64> {
        let posture = arm.chain().posture(motors);
        let jacobian = posture.jacobian();
        let along = jacobian.rows(0, 3).transpose() * self.normal;
        let mut torques = force_n * along;
        let n = motors.len();
        if self.hold.bandwidth_hz <= 0.0 || n < 2 {
            return torques;
        }
        let held = if n >= ALL_DIRECTIONS { 5 } else { 2 };
        let tool = posture.tool();
        let away = self.home.translation.vector - tool.translation.vector;
        let turn = (self.home.rotation * tool.rotation.inverse()).scaled_axis();
        let mut task = DMatrix::zeros(held, n);
        let mut error = DVector::zeros(held);
        for (row, side) in sides(&self.normal).iter().enumerate() {
            task.row_mut(row).copy_from(&(side.transpose() * jacobian.rows(0, 3)));
            error[row] = side.dot(&away);
        }
        if held > 2 {
            task.rows_mut(2, 3).copy_from(&jacobian.rows(3, 3));
            error.rows_mut(2, 3).copy_from(&turn);
        }
        let w = std::f64::consts::TAU * self.hold.bandwidth_hz;
        let wanted = w * w * error - 2.0 * self.hold.damping_ratio * w * (&task * speeds);
        let mass = posture.mass_matrix() + DMatrix::from_diagonal(&self.reflected);
        let Some(moved) = mass.cholesky().map(|cholesky| cholesky.solve(&task.transpose())) else {
            return torques;
        };
        let mobility = &task * moved;
        let largest = mobility.symmetric_eigenvalues().amax();
        if let Ok(inverse) = mobility.pseudo_inverse(SINGULAR * largest) {
            torques += task.transpose() * (inverse * wanted);
        }
        torques
    }
}

/// Two directions perpendicular to a normal and to each other.
fn sides(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    // The axis with the largest angle to the normal.
    let least = normal.map(f64::abs).imin();
    let first = normal.cross(&Vector3::ith(least, 1.0)).normalize();
    [first, normal.cross(&first)]
}
