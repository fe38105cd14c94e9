//! Joints with gears and springs, and the linear model of an arm at a pose.

use feeler_catalogue::{
    Bound, Dimension, Field, KeyKind, Keyed, Tabled, Unit, field, number, optional, required,
};
use nalgebra::{DMatrix, DVector, Vector3};

use crate::chain::Chain;
use crate::error::ArmError;
use crate::linear_system::LinearSystem;
use crate::sampled::Lag;

/// The drive of one joint. All values are at the joint's side of the gear, except for the rotor.
#[derive(Clone, Debug, PartialEq)]
pub struct JointDrive {
    /// Turns of the rotor per turn of the joint.
    pub gear_ratio: f64,
    /// Inertia of the rotor about its own axis, before the gear; kg m² (kg for a joint that slides).
    pub rotor_inertia_kg_m2: f64,
    /// Stiffness of gear and shaft, N m/rad.
    pub stiffness_n_m_per_rad: f64,
    /// Damping of gear and shaft, N m s/rad.
    pub damping_n_m_s_per_rad: f64,
    /// Viscous friction of the motor's side, N m s/rad.
    pub viscous_friction_n_m_s_per_rad: f64,
    /// Dry friction of the motor's side, N m.
    pub dry_friction_n_m: f64,
    pub effort_limit_n_m: Option<f64>,
    /// First-order bandwidth of the torque loop, Hz.
    pub bandwidth_hz: Option<f64>,
}

impl Tabled for JointDrive {
    const TABLE: &'static str = "joints";
}

impl JointDrive {
    /// Its rotor's inertia.
    pub const ROTOR_INERTIA: Field<Self> = field!(JointDrive: rotor_inertia_kg_m2,
        required("rotor_inertia", KeyKind::Quantity(Unit::Of(Dimension::MASS), Bound::Positive),
            "of the rotor about its own axis, before the gear"));
}

/// A drive takes friction and effort from its URDF if a file omits them.
impl Keyed for JointDrive {
    const FIELDS: &'static [Field<Self>] = &[
        field!(JointDrive: gear_ratio,
            required("gear_ratio", KeyKind::Quantity(Unit::Of(Dimension::NONE), Bound::Positive),
                "turns of the rotor per turn of the joint")),
        JointDrive::ROTOR_INERTIA,
        field!(JointDrive: stiffness_n_m_per_rad,
            required("stiffness", KeyKind::Quantity(Unit::Of(Dimension::STIFFNESS), Bound::Positive),
                "of gear and shaft, at the joint")),
        field!(JointDrive: damping_n_m_s_per_rad,
            number("damping", DAMPING, Bound::NotNegative, 0.0, "of gear and shaft, at the joint")),
        field!(JointDrive: viscous_friction_n_m_s_per_rad,
            optional("viscous_friction", KeyKind::Quantity(DAMPING, Bound::NotNegative),
                "of the motor, at the joint; the URDF's `dynamics damping` if absent")),
        field!(JointDrive: dry_friction_n_m,
            optional("dry_friction", KeyKind::Quantity(TORQUE, Bound::NotNegative),
                "of the motor, at the joint; the URDF's `dynamics friction` if absent")),
        field!(JointDrive: effort_limit_n_m,
            optional("limit", KeyKind::Quantity(TORQUE, Bound::Positive),
                "largest torque, at the joint; the URDF's `limit effort` if absent")),
        field!(JointDrive: bandwidth_hz,
            optional("bandwidth", KeyKind::Quantity(Unit::Of(Dimension::FREQUENCY), Bound::Positive),
                "first-order bandwidth of the torque loop")),
    ];
}

const DAMPING: Unit = Unit::Of(Dimension::DAMPING);
const TORQUE: Unit = Unit::Of(Dimension::FORCE);

/// A chain with its drives.
#[derive(Clone, Debug, PartialEq)]
pub struct Arm {
    pub(crate) chain: Chain,
    pub(crate) drives: Vec<JointDrive>,
}

/// How the drives act in directions other than the contact normal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Others {
    /// Position control holds the tool's other directions: the motors move only so that, with rigid joints,
    /// the tool would move along the normal. With six joints or more all other directions are held, with
    /// fewer the two other directions of position.
    #[default]
    Held,
    /// Every motor is free to follow the forces.
    Free,
}

/// An arm at a pose in linear theory. Coordinates are those of the motors (in a basis of their free
/// directions), then those of the links.
pub(crate) struct LinearArm {
    pub(crate) system: LinearSystem,
    /// Directions of joint space in which the motors move, one per column.
    pub(crate) basis: DMatrix<f64>,
    /// Joint motion per metre of the tool along the normal if nothing bends.
    pub(crate) rigid: DVector<f64>,
    /// The same motion in all coordinates.
    pub(crate) unbent: DVector<f64>,
    /// Joint motion per displacement of the rigid tool along the normal.
    pub(crate) along: DVector<f64>,
    /// Mass of the links in joint space.
    pub(crate) link_mass: DMatrix<f64>,
    /// Motor forces for a force along the normal, grouped by the bandwidths of their drives; together the
    /// system's `drive`.
    pub(crate) lags: Vec<Lag>,
}

/// Tool motion along the normal per joint motion, as a share of the largest, below which the arm cannot move
/// along the normal.
const SINGULAR: f64 = 1e-3;
/// Tolerated error of the desired motion, as a share.
const MISSED: f64 = 1e-6;

impl Arm {
    /// A chain with one drive per joint.
    ///
    /// # Errors
    /// [`ArmError::Pose`] for another number of drives, [`ArmError::Drive`] for invalid values.
    pub fn new(chain: Chain, drives: Vec<JointDrive>) -> Result<Self, ArmError> {
        if drives.len() != chain.joints() {
            let names: Vec<&str> = chain.joints.iter().map(|joint| joint.name.as_str()).collect();
            return Err(ArmError::Pose {
                given: drives.len(),
                needed: chain.joints(),
                names: names.join(", "),
            });
        }
        for (joint, drive) in chain.joints.iter().zip(&drives) {
            let positive = [
                ("the gear ratio", drive.gear_ratio.abs()),
                ("the rotor inertia", drive.rotor_inertia_kg_m2),
                ("the stiffness", drive.stiffness_n_m_per_rad),
            ];
            let not_negative = [
                ("the damping", drive.damping_n_m_s_per_rad),
                ("the viscous friction", drive.viscous_friction_n_m_s_per_rad),
                ("the dry friction", drive.dry_friction_n_m),
            ];
            let rule = |bad: Option<&(&'static str, f64)>, rule| match bad {
                Some(&(what, value)) => Err(ArmError::Drive { joint: joint.name.clone(), what, value, rule }),
                None => Ok(()),
            };
            rule(positive.iter().find(|(_, x)| !(*x > 0.0 && x.is_finite())), "above zero and finite")?;
            rule(
                not_negative.iter().find(|(_, x)| !(*x >= 0.0 && x.is_finite())),
                "zero or above, and finite",
            )?;
        }
        Ok(Self { chain, drives })
    }

    /// Links and joints.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// One per joint.
    pub fn drives(&self) -> &[JointDrive] {
        &self.drives
    }

    /// Inertia of each rotor at its joint: the gear ratio squared times its own.
    pub fn reflected_inertia_kg_m2(&self) -> DVector<f64> {
        DVector::from_iterator(
            self.drives.len(),
            self.drives.iter().map(|d| d.gear_ratio * d.gear_ratio * d.rotor_inertia_kg_m2),
        )
    }

    pub(crate) fn per_joint(&self, number: impl Fn(&JointDrive) -> f64) -> DVector<f64> {
        DVector::from_iterator(self.drives.len(), self.drives.iter().map(number))
    }

    /// The arm at a pose in linear theory, without gravity and its compensation.
    pub(crate) fn linear(&self, q: &[f64], normal: [f64; 3], others: Others) -> Result<LinearArm, ArmError> {
        self.chain.check_pose(q)?;
        let unit = Vector3::from(normal)
            .try_normalize(1e-12)
            .filter(|n| n.iter().all(|x| x.is_finite()))
            .ok_or(ArmError::Normal { normal })?;
        let jacobian = self.chain.jacobian(q);
        let n = self.chain.joints();
        let along = jacobian.rows(0, 3).transpose() * unit;
        let link_mass = self.chain.mass_matrix(q);
        let reflected = DMatrix::from_diagonal(&self.reflected_inertia_kg_m2());
        let total_mass = &link_mass + &reflected;
        let (basis, rigid, motors_rigid) = match others {
            Others::Held => {
                let rows = if n >= 6 { 6 } else { 3 };
                let rigid = held_direction(&jacobian.rows(0, rows).into_owned(), &unit)?;
                (DMatrix::from_columns(std::slice::from_ref(&rigid)), rigid, DVector::from_element(1, 1.0))
            }
            Others::Free => {
                let size = jacobian.rows(0, 3).norm();
                let share = along.norm() / size;
                if share.is_nan() || share < SINGULAR {
                    return Err(ArmError::Singular { held: "", share });
                }
                // Positive definite, since every joint moves a mass: see `Urdf::chain`.
                let solved = total_mass
                    .clone()
                    .lu()
                    .solve(&along)
                    .ok_or(ArmError::Singular { held: "", share: 0.0 })?;
                let mobility = along.dot(&solved);
                let rigid = solved / mobility;
                (DMatrix::identity(n, n), rigid.clone(), rigid)
            }
        };
        let stiffness = DMatrix::from_diagonal(&self.per_joint(|d| d.stiffness_n_m_per_rad));
        let damping = DMatrix::from_diagonal(&self.per_joint(|d| d.damping_n_m_s_per_rad));
        let friction = DMatrix::from_diagonal(&self.per_joint(|d| d.viscous_friction_n_m_s_per_rad));
        let p = basis.ncols();
        let motors = |matrix: &DMatrix<f64>| basis.transpose() * matrix * &basis;
        let coupled = |matrix: &DMatrix<f64>| {
            let mut all = DMatrix::zeros(p + n, p + n);
            all.view_mut((0, 0), (p, p)).copy_from(&motors(matrix));
            all.view_mut((0, p), (p, n)).copy_from(&-(basis.transpose() * matrix));
            all.view_mut((p, 0), (n, p)).copy_from(&-(matrix * &basis));
            all.view_mut((p, p), (n, n)).copy_from(matrix);
            all
        };
        let mut mass = DMatrix::zeros(p + n, p + n);
        mass.view_mut((0, 0), (p, p)).copy_from(&motors(&reflected));
        mass.view_mut((p, p), (n, n)).copy_from(&link_mass);
        let mut all_damping = coupled(&damping);
        let own = all_damping.view((0, 0), (p, p)) + motors(&friction);
        all_damping.view_mut((0, 0), (p, p)).copy_from(&own);
        let mut tip = DVector::zeros(p + n);
        tip.rows_mut(p, n).copy_from(&along);
        let mut drive = DVector::zeros(p + n);
        drive.rows_mut(0, p).copy_from(&(basis.transpose() * &along));
        let mut unbent = DVector::zeros(p + n);
        unbent.rows_mut(0, p).copy_from(&motors_rigid);
        unbent.rows_mut(p, n).copy_from(&rigid);
        let mut lags: Vec<Lag> = Vec::new();
        for (i, joint) in self.drives.iter().enumerate().filter(|(i, _)| along[*i] != 0.0) {
            let known = lags.iter().position(|(hz, _)| *hz == joint.bandwidth_hz);
            let place = known.unwrap_or_else(|| {
                lags.push((joint.bandwidth_hz, DVector::zeros(p + n)));
                lags.len() - 1
            });
            let mut asked = lags[place].1.rows_mut(0, p);
            asked += basis.row(i).transpose() * along[i];
        }
        let mass_kg = (total_mass * &rigid).dot(&rigid);
        let system =
            LinearSystem { mass, stiffness: coupled(&stiffness), damping: all_damping, tip, drive, mass_kg };
        Ok(LinearArm { system, basis, rigid, unbent, along, link_mass, lags })
    }
}

/// Joint motion that moves the tool by one along `normal` and in no other direction of the task.
fn held_direction(task: &DMatrix<f64>, normal: &Vector3<f64>) -> Result<DVector<f64>, ArmError> {
    let held = ", its other directions held";
    let mut wanted = DVector::zeros(task.nrows());
    wanted.rows_mut(0, 3).copy_from(normal);
    let largest = task.singular_values().max();
    let inverse = task
        .clone()
        .pseudo_inverse(SINGULAR * largest)
        .map_err(|_| ArmError::Singular { held, share: 0.0 })?;
    let direction = inverse * &wanted;
    let share = 1.0 / (direction.norm() * largest);
    let missed = (task * &direction - wanted).norm();
    if missed > MISSED || share.is_nan() || share < SINGULAR {
        return Err(ArmError::Singular { held, share: if missed > MISSED { 0.0 } else { share } });
    }
    Ok(direction)
}
