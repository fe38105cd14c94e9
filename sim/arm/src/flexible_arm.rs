//! The arm in motion, with flexible joints against a wall. Classical Runge-Kutta steps of fixed length.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::error::ArmError;
use crate::flexible::{Arm, Others};

fn rk4<F: FnMut(&DVector<f64>) -> Option<DVector<f64>>>(
    x: &DVector<f64>,
    h: f64,
    mut slope: F,
) -> Option<DVector<f64>> {
    let a = slope(x)?;
    let b = slope(&(x + 0.5 * h * &a))?;
    let c = slope(&(x + 0.5 * h * &b))?;
    let d = slope(&(x + h * &c))?;
    Some(x + h / 6.0 * (a + 2.0 * b + 2.0 * c + d))
}

/// A plane wall: a spring and damper that only push. It does not use the contacts of a machine, so a
/// comparison with them is independent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// Its distance from the tool at the start, along the normal.
    pub gap_m: f64,
    pub stiffness_n_per_m: f64,
    pub damping_n_s_per_m: f64,
}

/// A moving arm with flexible joints, compensated gravity and no dry friction; the wall is perpendicular to a
/// normal.
#[derive(Clone, Debug)]
pub struct FlexibleArm<'a> {
    arm: &'a Arm,
    home: DVector<f64>,
    normal: Vector3<f64>,
    /// Initial position of the tool along the normal.
    origin_m: f64,
    basis: DMatrix<f64>,
    motor_mass: DMatrix<f64>,
    along: DVector<f64>,
    rigid: DVector<f64>,
    /// Motors, links, and their speeds.
    state: DVector<f64>,
    wall: Wall,
    t_s: f64,
}

impl<'a> FlexibleArm<'a> {
    /// The arm at rest at a pose, with relaxed springs.
    ///
    /// # Errors
    /// Those of [`Arm::reduce`].
    pub fn new(
        arm: &'a Arm,
        q: &[f64],
        normal: [f64; 3],
        others: Others,
        wall: Wall,
    ) -> Result<Self, ArmError> {
        let linear = arm.linear(q, normal, others)?;
        let home = DVector::from_column_slice(q);
        let unit = Vector3::from(normal).normalize();
        let (p, n) = (linear.basis.ncols(), q.len());
        let mut state = DVector::zeros(2 * (p + n));
        state.rows_mut(p, n).copy_from(&home);
        let motor_mass = linear.system.mass.view((0, 0), (p, p)).into_owned();
        let origin_m = unit.dot(&arm.chain.tool_place(q).translation.vector);
        Ok(Self {
            arm,
            home,
            normal: unit,
            origin_m,
            basis: linear.basis,
            motor_mass,
            along: linear.along,
            rigid: linear.rigid,
            state,
            wall,
            t_s: 0.0,
        })
    }

    /// Gives the arm a speed along the normal: motors and links move as a rigid arm would.
    ///
    /// # Errors
    /// Those of [`Arm::reduce`].
    pub fn throw(&mut self, others: Others, speed_m_per_s: f64) -> Result<(), ArmError> {
        let linear = self.arm.linear(self.home.as_slice(), self.normal.into(), others)?;
        let (p, n) = (self.basis.ncols(), self.home.len());
        let rigid = linear.rigid * speed_m_per_s;
        let motors = if p == n { rigid.clone() } else { DVector::from_element(1, speed_m_per_s) };
        self.state.rows_mut(p + n, p).copy_from(&motors);
        self.state.rows_mut(p + n + p, n).copy_from(&rigid);
        Ok(())
    }

    /// Sets the arm to the state in which a force along the normal holds it on the wall, with only wall and
    /// springs deflected.
    pub(crate) fn press(&mut self, wall_n_per_m: f64, force_n: f64) {
        let (p, n) = (self.basis.ncols(), self.home.len());
        let depth_m = force_n / wall_n_per_m;
        let bent = self.along.component_div(&self.arm.per_joint(|d| d.stiffness_n_m_per_rad)) * force_n;
        let beyond = self.along.dot(&bent);
        // The motors move by the tool's displacement plus the bending of the joints.
        let motors = &self.rigid * (depth_m + beyond);
        self.state.rows_mut(0, p).copy_from(&if p == n {
            motors.clone()
        } else {
            DVector::from_element(1, depth_m + beyond)
        });
        let links = &self.home + motors - bent;
        self.state.rows_mut(p, n).copy_from(&links);
    }

    /// Advances by one step under a drive force along the normal.
    ///
    /// # Errors
    /// [`ArmError::Diverged`].
    pub fn step(&mut self, step_s: f64, drive_n: f64) -> Result<(), ArmError> {
        let next =
            rk4(&self.state, step_s, |x| self.slope(x, drive_n)).filter(|x| x.iter().all(|x| x.is_finite()));
        self.state = next.ok_or(ArmError::Diverged { t_s: self.t_s })?;
        self.t_s += step_s;
        Ok(())
    }

    /// Displacement of the tool along the normal, m, and its speed.
    pub fn tool(&self) -> [f64; 2] {
        self.tool_of(&self.state)
    }

    /// Positions of the links.
    pub fn links(&self) -> &[f64] {
        let p = self.basis.ncols();
        &self.state.as_slice()[p..p + self.home.len()]
    }

    /// Force of the wall on the tool, N.
    pub fn force_n(&self) -> f64 {
        self.force_of(&self.state)
    }

    fn tool_of(&self, x: &DVector<f64>) -> [f64; 2] {
        let (p, n) = (self.basis.ncols(), self.home.len());
        let q = &x.as_slice()[p..p + n];
        let along = self.arm.chain.jacobian(q).rows(0, 3).transpose() * self.normal;
        let position = self.normal.dot(&self.arm.chain.tool_place(q).translation.vector) - self.origin_m;
        [position, along.dot(&x.rows(2 * p + n, n))]
    }

    fn force_of(&self, x: &DVector<f64>) -> f64 {
        let [position, speed] = self.tool_of(x);
        let d = position - self.wall.gap_m;
        if d > 0.0 {
            (self.wall.stiffness_n_per_m * d + self.wall.damping_n_s_per_m * speed).max(0.0)
        } else {
            0.0
        }
    }

    fn slope(&self, x: &DVector<f64>, drive_n: f64) -> Option<DVector<f64>> {
        let (p, n) = (self.basis.ncols(), self.home.len());
        let (s, q, s_rate, v) = (x.rows(0, p), x.rows(p, n), x.rows(p + n, p), x.rows(2 * p + n, n));
        let arm = self.arm;
        let motors = &self.home + &self.basis * s;
        let motor_speeds = &self.basis * s_rate;
        let twist = motors - q;
        let twist_rate = &motor_speeds - v;
        let joint = arm.per_joint(|d| d.stiffness_n_m_per_rad).component_mul(&twist)
            + arm.per_joint(|d| d.damping_n_m_s_per_rad).component_mul(&twist_rate);
        let friction = arm.per_joint(|d| d.viscous_friction_n_m_s_per_rad).component_mul(&motor_speeds);
        let (q, v) = (q.as_slice().to_vec(), v.as_slice().to_vec());
        let along = arm.chain.jacobian(&q).rows(0, 3).transpose() * self.normal;
        let links = &joint - along * self.force_of(x) - arm.chain.coriolis_efforts(&q, &v);
        let accelerations = arm.chain.mass_matrix(&q).cholesky()?.solve(&links);
        let efforts = self.basis.transpose() * (&self.along * drive_n - joint - friction);
        let motor_accelerations = self.motor_mass.clone().cholesky()?.solve(&efforts);
        let mut slope = DVector::zeros(x.len());
        slope.rows_mut(0, p).copy_from(&s_rate);
        slope.rows_mut(p, n).copy_from_slice(&v);
        slope.rows_mut(p + n, p).copy_from(&motor_accelerations);
        slope.rows_mut(2 * p + n, n).copy_from(&accelerations);
        Some(slope)
    }
}
