//! From an arm at a pose to one axis of two masses, or more.

use nalgebra::Complex;

use crate::branch::Branch;
use crate::error::ArmError;
use crate::flexible::{Arm, LinearArm, Others};
use crate::linear_system::ArmMode;

/// The axis that represents an arm along a contact normal: the paper's flexible machine, with the arm's
/// numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduction {
    /// Mass of the rigid arm.
    pub mass_kg: f64,
    /// Part of the mass on the motors' side of the equivalent spring, without the branches.
    pub motor_mass_kg: f64,
    /// Part of the mass on the tool's side.
    pub tip_mass_kg: f64,
    /// Further bodies, each on its own spring at the motor, some joined to the tool as well; empty if two
    /// masses are enough.
    pub branches: Vec<Branch>,
    /// The spring between the two; without branches the equivalent spring of all joints.
    pub stiffness_n_per_m: f64,
    pub damping_n_s_per_m: f64,
    /// Stiffness of all joints in series with locked motors: the stiffness against a slow force on the tool.
    pub static_stiffness_n_per_m: f64,
    /// Mass of the links alone with limp joints: the mass against a sudden blow on the tool.
    pub link_mass_kg: f64,
    /// Viscous friction of the motors.
    pub guide_damping_n_s_per_m: f64,
    /// Dry friction of the motors.
    pub dry_friction_n: f64,
    /// Largest force along the normal within every motor's limit.
    pub force_limit_n: Option<f64>,
    /// Bandwidth of the slowest drive that takes part.
    pub bandwidth_hz: Option<f64>,
    /// Joint motion per metre of the tool along the normal.
    pub direction: Vec<f64>,
    /// Modes that bend joints, with the tool free, slowest first.
    pub modes: Vec<ArmMode>,
}

impl Arm {
    /// The axis of two masses that represents the arm along `normal` at pose `q`; gravity counts as
    /// compensated.
    ///
    /// The axis keeps the total mass and the bending under slow forces. These are the tool's lag behind the
    /// rigid motion per drive force, and the tool's displacement beyond it per force on the tool. It also
    /// keeps the loss in the joints while a force on the tool changes slowly. An arm with one joint is
    /// represented exactly. For more joints, with several modes, the pair of masses agrees with all of them
    /// at low frequency (moment matching, as in model reduction). If no pair does, because the tool leads the
    /// drive, the pair has the slowest mode.
    ///
    /// # Errors
    /// [`ArmError::Pose`], [`ArmError::Limit`], [`ArmError::Normal`], [`ArmError::Singular`].
    pub fn reduce(&self, q: &[f64], normal: [f64; 3], others: Others) -> Result<Reduction, ArmError> {
        self.pair(&self.linear(q, normal, others)?)
    }

    pub(crate) fn pair(&self, linear: &LinearArm) -> Result<Reduction, ArmError> {
        let mass_kg = linear.system.mass_kg;
        let modes = linear.system.modes(0.0);
        let singular = ArmError::Singular { held: "", share: 0.0 };
        // Bending per force, over modes: tool by drive (noncolocated, so negative), tool by tool.
        let tau = std::f64::consts::TAU;
        let over = |number: &dyn Fn(&ArmMode) -> f64| {
            modes.iter().map(|mode| number(mode) / (tau * mode.frequency_hz).powi(2)).sum::<f64>()
        };
        let by_drive = -over(&|mode| mode.drive_share);
        let Some(slowest) = modes.first().filter(|_| by_drive.is_finite()) else { return Err(singular) };
        // With other directions held, the tool may lead its drive under a slow push, which no pair of masses
        // does. The pair then has the slowest mode.
        let omega = if by_drive > 0.0 { by_drive.recip().sqrt() } else { tau * slowest.frequency_hz };
        let ratio = over(&|mode| mode.tip_share) * omega * omega;
        let tip_mass_kg = mass_kg / (1.0 + ratio);
        let motor_mass_kg = mass_kg - tip_mass_kg;
        let stiffness_n_per_m = omega * omega * motor_mass_kg * tip_mass_kg / mass_kg;
        let along = &linear.along;
        let direction = &linear.rigid;
        let sum = |number: &dyn Fn(usize) -> f64| (0..self.drives.len()).map(number).sum::<f64>();
        let compliance = sum(&|i| along[i] * along[i] / self.drives[i].stiffness_n_m_per_rad);
        let loss = sum(&|i| {
            self.drives[i].damping_n_m_s_per_rad * (along[i] / self.drives[i].stiffness_n_m_per_rad).powi(2)
        });
        let limp = linear.link_mass.clone().lu().solve(along).ok_or(singular)?;
        let guide_damping =
            sum(&|i| self.drives[i].viscous_friction_n_m_s_per_rad * direction[i] * direction[i]);
        let takes_part = |i: &usize| along[*i].abs() > 1e-9 * along.amax();
        let limits = (0..self.drives.len())
            .filter(takes_part)
            .filter_map(|i| Some(self.drives[i].effort_limit_n_m? / along[i].abs()));
        let bandwidths =
            (0..self.drives.len()).filter(takes_part).filter_map(|i| self.drives[i].bandwidth_hz);
        Ok(Reduction {
            mass_kg,
            motor_mass_kg,
            tip_mass_kg,
            branches: Vec::new(),
            stiffness_n_per_m,
            damping_n_s_per_m: stiffness_n_per_m * stiffness_n_per_m * loss,
            static_stiffness_n_per_m: 1.0 / compliance,
            link_mass_kg: 1.0 / along.dot(&limp),
            guide_damping_n_s_per_m: guide_damping,
            dry_friction_n: sum(&|i| self.drives[i].dry_friction_n_m * direction[i].abs()),
            force_limit_n: limits.reduce(f64::min),
            bandwidth_hz: bandwidths.reduce(f64::min),
            direction: direction.iter().copied().collect(),
            modes,
        })
    }

    /// Modes of the arm with the tool on a spring along the normal, slowest first.
    ///
    /// # Errors
    /// Those of [`Self::reduce`].
    pub fn modes_in_contact(
        &self,
        q: &[f64],
        normal: [f64; 3],
        others: Others,
        contact_n_per_m: f64,
    ) -> Result<Vec<ArmMode>, ArmError> {
        Ok(self.linear(q, normal, others)?.system.modes(contact_n_per_m))
    }

    /// Force of a spring and damper under the tool per drive force along the normal, at frequencies in Hz. It
    /// includes every joint's motor and link, linear about the pose.
    ///
    /// # Errors
    /// Those of [`Self::reduce`].
    pub fn response_in_contact(
        &self,
        q: &[f64],
        normal: [f64; 3],
        others: Others,
        contact: [f64; 2],
        frequencies_hz: &[f64],
    ) -> Result<Vec<Complex<f64>>, ArmError> {
        Ok(self.linear(q, normal, others)?.system.response_in_contact(contact, frequencies_hz))
    }
}
