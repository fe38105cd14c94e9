//! Masses, springs and dampers between a drive and a tool: their modes, and their force on a contact.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, DVector, SymmetricEigen};

/// Share of the largest squared frequency below which a mode bends no spring.
pub(crate) const BENDS_NOTHING: f64 = 1e-9;

/// Share of a slow drive force on the contact. Above it a mode counts as the one in which the whole arm moves
/// on the contact.
const WHOLE_ARM: f64 = 0.3;

/// A mode of the arm that bends its joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmMode {
    /// Undamped frequency with the tool free, Hz.
    pub frequency_hz: f64,
    /// Damping ratio from the dampings of joints and motors; coupling to other modes is neglected.
    pub damping_ratio: f64,
    /// Contribution of the mode to the tool's motion under a drive force along the normal, relative to the
    /// arm's mass. It is -1 if this mode alone separates the tool from the motors. Negative means
    /// noncolocated.
    pub drive_share: f64,
    /// Contribution of the mode to the tool's response to a force on the tool, relative to the arm's mass. It
    /// is the ratio of motor to tip mass of the equivalent pair.
    pub tip_share: f64,
}

/// `M x'' + D x' + K x = b u`, with the tool's displacement along the normal `c x`.
pub(crate) struct LinearSystem {
    pub(crate) mass: DMatrix<f64>,
    pub(crate) stiffness: DMatrix<f64>,
    pub(crate) damping: DMatrix<f64>,
    pub(crate) tip: DVector<f64>,
    pub(crate) drive: DVector<f64>,
    /// Mass of the rigid arm along the normal.
    pub(crate) mass_kg: f64,
}

/// Squared angular frequencies, and shapes (one per column) with modal mass one; `None` unless the mass
/// matrix is positive definite.
pub(crate) fn eigen(mass: &DMatrix<f64>, stiffness: &DMatrix<f64>) -> Option<(DVector<f64>, DMatrix<f64>)> {
    let lower = mass.clone().cholesky()?.l();
    // L^-1 K L^-T, through two triangular solutions.
    let half = lower.solve_lower_triangular(stiffness)?;
    let reduced = lower.solve_lower_triangular(&half.transpose())?;
    let eigen = SymmetricEigen::new(0.5 * (&reduced + reduced.transpose()));
    let shapes = lower.transpose().solve_upper_triangular(&eigen.eigenvectors)?;
    Some((eigen.eigenvalues, shapes))
}

impl LinearSystem {
    /// The largest squared angular frequency in the air, which identifies modes that bend no spring. On a
    /// contact it would grow with the stiffness of the contact.
    fn largest_square(&self) -> f64 {
        eigen(&self.mass, &self.stiffness).map_or(0.0, |(squares, _)| squares.amax())
    }

    /// Modes that bend something, slowest first; with `contact_n_per_m` on the tip, all modes.
    pub(crate) fn modes(&self, contact_n_per_m: f64) -> Vec<ArmMode> {
        let stiffness = &self.stiffness + contact_n_per_m * &self.tip * self.tip.transpose();
        let Some((squares, shapes)) = eigen(&self.mass, &stiffness) else { return Vec::new() };
        let largest = self.largest_square();
        let mut modes: Vec<ArmMode> = (squares.iter().zip(shapes.column_iter()))
            .filter(|(square, _)| **square > BENDS_NOTHING * largest)
            .map(|(square, shape)| {
                let omega = square.sqrt();
                let (t, d) = (self.tip.dot(&shape), self.drive.dot(&shape));
                ArmMode {
                    frequency_hz: omega / TAU,
                    damping_ratio: (&self.damping * shape).dot(&shape) / (2.0 * omega),
                    drive_share: t * d * self.mass_kg,
                    tip_share: t * t * self.mass_kg,
                }
            })
            .collect();
        modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        modes
    }

    /// Frequency of the mode in which drive and tool move on a contact (Hz). It is the first mode that
    /// carries a large part of a slow drive force to the contact. Without one it is the mode that carries
    /// most of it.
    pub(crate) fn contact_mode_hz(&self, contact_n_per_m: f64) -> f64 {
        let stiffness = &self.stiffness + contact_n_per_m * &self.tip * self.tip.transpose();
        let Some((squares, shapes)) = eigen(&self.mass, &stiffness) else { return f64::NAN };
        let largest = self.largest_square();
        let mut carried: Vec<(f64, f64)> = (squares.iter().zip(shapes.column_iter()))
            .filter(|(square, _)| **square > BENDS_NOTHING * largest)
            .map(|(square, shape)| {
                // The mode's part of the contact force is the rest after the springs and the inertia at the
                // tool. This is exact for contacts so stiff that almost nothing moves there.
                let force = (*square * (&self.mass * shape) - &self.stiffness * shape).dot(&self.tip)
                    / self.tip.norm_squared();
                (square.sqrt() / TAU, force * self.drive.dot(&shape) / square)
            })
            .collect();
        carried.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let first = carried.iter().find(|(_, part)| part.abs() > WHOLE_ARM);
        let most = carried.iter().max_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()));
        first.or(most).map_or(f64::NAN, |(frequency_hz, _)| *frequency_hz)
    }

    /// Force of a spring (N/m) and damper (N s/m) under the tool per drive force, at frequencies in Hz.
    pub(crate) fn response_in_contact(&self, contact: [f64; 2], frequencies_hz: &[f64]) -> Vec<Complex<f64>> {
        let force = |f: &f64, [tool, _]: [Complex<f64>; 2]| {
            (contact[0] + contact[1] * Complex::new(0.0, TAU * f)) * tool
        };
        frequencies_hz
            .iter()
            .zip(self.moved(contact, frequencies_hz))
            .map(|(f, moved)| force(f, moved))
            .collect()
    }

    /// Displacement of the tool and of the drive per drive force, with the tool on a spring and damper.
    pub(crate) fn moved(&self, contact: [f64; 2], frequencies_hz: &[f64]) -> Vec<[Complex<f64>; 2]> {
        let [k, c] = contact;
        let touch = &self.tip * self.tip.transpose();
        let stiffness = &self.stiffness + k * &touch;
        let damping = &self.damping + c * &touch;
        let complex = |matrix: &DMatrix<f64>, factor: Complex<f64>| matrix.map(|x| factor * x);
        let one = Complex::new(1.0, 0.0);
        let (drive, tip) = (self.drive.map(|x| one * x), self.tip.map(|x| one * x));
        (frequencies_hz.iter())
            .map(|frequency_hz| {
                let s = Complex::new(0.0, TAU * frequency_hz);
                let dynamic = complex(&self.mass, s * s) + complex(&damping, s) + complex(&stiffness, one);
                dynamic
                    .lu()
                    .solve(&drive)
                    .map_or([Complex::new(f64::NAN, 0.0); 2], |x| [x.dot(&tip), x.dot(&drive)])
            })
            .collect()
    }
}
