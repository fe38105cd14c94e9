//! Machines of springs and masses, written out as matrices.

use feeler_lti::StateSpace;
use nalgebra::{DMatrix, DVector};

/// The drive of the machine.
#[derive(Clone, Copy)]
pub(crate) enum Drive {
    /// The input is the force itself.
    Ideal,
    /// The force follows the input with a time constant (s).
    Lag(f64),
    /// `tau f' + f = b_a (u - v)`: damping `b_a` (N s/m) and tau (s).
    VelocitySource(f64, f64),
}

/// One machine: motor mass on its guide, and the bodies attached to it. SI units throughout.
pub(crate) struct Axis {
    pub(crate) masses: (f64, f64),
    pub(crate) guide_damping: f64,
    pub(crate) contact: (f64, f64),
    /// Stiffness and damping between the two masses; `None` joins them.
    pub(crate) transmission: Option<(f64, f64)>,
    /// Mass, stiffness and damping of the base; `None` is ground.
    pub(crate) base: Option<(f64, f64, f64)>,
    /// Mass, stiffness and damping of the workpiece; `None` is rigid.
    pub(crate) workpiece: Option<(f64, f64, f64)>,
    pub(crate) drive: Drive,
    /// Whether the fed-back force includes the damper of the sensor.
    pub(crate) total_force: bool,
}

/// Mass, stiffness and damping matrices under construction.
struct Assembly {
    mass: Vec<f64>,
    links: Vec<(Option<usize>, Option<usize>, f64, f64)>,
}

impl Axis {
    /// The system from drive command to contact force.
    pub(crate) fn system(&self) -> StateSpace {
        let mut parts = Assembly { mass: Vec::new(), links: Vec::new() };
        let mut body = |m: f64| {
            parts.mass.push(m);
            Some(parts.mass.len() - 1)
        };
        let (motor, tip) = if self.transmission.is_some() {
            (body(self.masses.0), body(self.masses.1))
        } else {
            let joined = body(self.masses.0 + self.masses.1);
            (joined, joined)
        };
        let base = self.base.and_then(|(m, _, _)| body(m));
        let work = self.workpiece.map_or(base, |(m, _, _)| body(m));
        parts.links.push((motor, base, 0.0, self.guide_damping));
        parts.links.push((tip, work, self.contact.0, self.contact.1));
        if let Some((k, b)) = self.transmission {
            parts.links.push((motor, tip, k, b));
        }
        if let Some((_, k, b)) = self.base {
            parts.links.push((base, None, k, b));
        }
        if let Some((_, k, b)) = self.workpiece {
            parts.links.push((work, base, k, b));
        }
        parts.close(self, (motor, base), (tip, work))
    }
}

impl Assembly {
    /// State space with the force on the first of `driven` from its second, and the sensor between the two of
    /// `sensed`.
    fn close(
        &self,
        axis: &Axis,
        driven: (Option<usize>, Option<usize>),
        sensed: (Option<usize>, Option<usize>),
    ) -> StateSpace {
        let n = self.mass.len();
        let unit = |plus: Option<usize>, minus: Option<usize>| {
            DVector::from_fn(n, |i, _| f64::from(i8::from(plus == Some(i)) - i8::from(minus == Some(i))))
        };
        let inverse_mass = DMatrix::from_fn(n, n, |i, j| if i == j { 1.0 / self.mass[i] } else { 0.0 });
        let (mut stiffness, mut damping) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        for &(i, j, k, b) in &self.links {
            let direction = unit(i, j);
            stiffness += &direction * direction.transpose() * k;
            damping += &direction * direction.transpose() * b;
        }
        let drive = unit(driven.0, driven.1);
        let sensor = unit(sensed.0, sensed.1);
        let force_state = usize::from(!matches!(axis.drive, Drive::Ideal));
        let order = 2 * n + force_state;
        let mut a = DMatrix::zeros(order, order);
        a.view_mut((0, n), (n, n)).fill_with_identity();
        a.view_mut((n, 0), (n, n)).copy_from(&-(&inverse_mass * stiffness));
        a.view_mut((n, n), (n, n)).copy_from(&-(&inverse_mass * damping));
        let acceleration = &inverse_mass * &drive;
        let mut b = DMatrix::zeros(order, 1);
        match axis.drive {
            Drive::Ideal => b.view_mut((n, 0), (n, 1)).copy_from(&acceleration),
            Drive::Lag(tau) => {
                a.view_mut((n, 2 * n), (n, 1)).copy_from(&acceleration);
                a[(2 * n, 2 * n)] = -1.0 / tau;
                b[(2 * n, 0)] = 1.0 / tau;
            }
            Drive::VelocitySource(b_a, tau) => {
                a.view_mut((n, 2 * n), (n, 1)).copy_from(&acceleration);
                a[(2 * n, 2 * n)] = -1.0 / tau;
                b[(2 * n, 0)] = b_a / tau;
                for i in 0..n {
                    a[(2 * n, n + i)] = -b_a / tau * drive[i];
                }
            }
        }
        let mut c = DMatrix::zeros(1, order);
        for i in 0..n {
            c[(0, i)] = axis.contact.0 * sensor[i];
            if axis.total_force {
                c[(0, n + i)] = axis.contact.1 * sensor[i];
            }
        }
        StateSpace::new(a, b, c, DMatrix::zeros(1, 1)).unwrap()
    }
}
