//! Contribution of a kind to the balance of forces of a rigid axis. One side is the drive's command; the
//! other consists of the inertial force, the damping force, and the contribution of the kind.

/// Magnitudes over all experiments.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Extent {
    /// Root mean square of the speed, m/s.
    pub(crate) speed: f64,
    /// Least and largest position, m.
    pub(crate) ends: [f64; 2],
    /// Largest command, and median of its magnitude, N.
    pub(crate) command: f64,
    pub(crate) usual_command: f64,
    /// Shortest resolved time, s.
    pub(crate) resolved_s: f64,
}

impl Extent {
    pub(crate) fn stroke(&self) -> f64 {
        self.ends[1] - self.ends[0]
    }

    pub(crate) fn middle(&self) -> f64 {
        0.5 * (self.ends[0] + self.ends[1])
    }
}

/// The motion at one row, with the value of the single nonlinear parameter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct At {
    pub(crate) position: f64,
    /// Middle of the stroke of all experiments, m.
    pub(crate) middle: f64,
    pub(crate) speed: f64,
    /// Size of the weights of the believed machine that load a guide, N.
    pub(crate) load: f64,
    /// Direction of the motion from -1 to 1. It changes gradually during presliding, and exceeds one while
    /// damping of the bristles adds to their force.
    pub(crate) direction: f64,
    pub(crate) shape: f64,
}

/// A resisting force for a coefficient of one.
#[derive(Clone, Copy)]
pub(crate) struct Force {
    pub(crate) of: fn(At) -> f64,
    /// Whether the coefficient may be negative.
    pub(crate) is_signed: bool,
}

impl Force {
    pub(crate) const fn positive(of: fn(At) -> f64) -> Self {
        Self { of, is_signed: false }
    }

    pub(crate) const fn signed(of: fn(At) -> f64) -> Self {
        Self { of, is_signed: true }
    }
}

/// How a kind enters the balance.
#[derive(Clone, Copy)]
pub(crate) enum Form {
    /// Forces of the motion.
    Forces(&'static [Force]),
    /// A force proportional to acceleration.
    Mass,
    /// The force is the command times a factor, the shape.
    Gain,
    /// The force follows the command with a time constant, the shape.
    Lag,
    /// The force follows the command after a delay, the shape.
    Delay,
    /// The force lacks a constant part in the direction of the command.
    Deadband,
    /// The force stays below a limit, the shape.
    Limit,
}

/// Contribution of a kind, with the conversion to its parameters.
#[derive(Clone, Copy)]
pub(crate) struct Balance<K> {
    pub(crate) form: Form,
    /// Trial values of the shape.
    pub(crate) shapes: fn(&Extent) -> Vec<f64>,
    /// Parameters from the coefficients of the forces and the shape.
    pub(crate) values: fn(&[f64], f64) -> K,
    /// Coefficients of the forces and the shape from the parameters.
    pub(crate) coefficients: fn(K) -> (Vec<f64>, f64),
}

impl<K> Balance<K> {
    /// A balance with forces that are proportional to the parameters.
    pub(crate) const fn forces(
        forces: &'static [Force],
        values: fn(&[f64], f64) -> K,
        coefficients: fn(K) -> (Vec<f64>, f64),
    ) -> Self {
        Self { form: Form::Forces(forces), shapes: |_| vec![0.0], values, coefficients }
    }

    /// A balance with a single parameter, which is the shape.
    pub(crate) const fn shaped(
        form: Form,
        shapes: fn(&Extent) -> Vec<f64>,
        values: fn(&[f64], f64) -> K,
        coefficients: fn(K) -> (Vec<f64>, f64),
    ) -> Self {
        Self { form, shapes, values, coefficients }
    }
}

/// `count` values from `low` to `high` in equal ratios.
pub(crate) fn spread(low: f64, high: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| low * (high / low).powf(i as f64 / (count - 1) as f64)).collect()
}
