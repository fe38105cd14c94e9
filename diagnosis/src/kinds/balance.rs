//! Contribution of a kind to the balance of forces of an axis that moves as one. One side is the drive's
//! command, the other the inertial force, the damping force, and the contribution of the kind.

/// Sizes of all experiments together.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Extent {
    /// Root mean square of the speed, m/s.
    pub(crate) speed: f64,
    /// From the least to the largest position, m.
    pub(crate) stroke: f64,
    /// Largest command, N.
    pub(crate) command: f64,
    /// Shortest resolved time, s.
    pub(crate) resolved_s: f64,
}

/// A motion at one row, with the value of the single nonlinear parameter.
#[derive(Clone, Copy, Debug)]
pub(crate) struct At {
    pub(crate) position: f64,
    pub(crate) speed: f64,
    /// Direction of the motion from -1 to 1; it changes gradually as a guide gives way.
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

/// Side of the balance, and form, of a kind's contribution.
#[derive(Clone, Copy)]
pub(crate) enum Form {
    /// Forces of the motion.
    Forces(&'static [Force]),
    /// A force proportional to acceleration.
    Mass,
    /// The force is this many times the command; its shape.
    Gain,
    /// The force follows the command with a time constant; its shape.
    Lag,
    /// The force is delayed after the command; its shape.
    Delay,
    /// The force lacks a part with the sign of the command.
    Deadband,
    /// The force stays below a limit; its shape.
    Limit,
}

/// Contribution of a kind, and the conversion to its parameters.
#[derive(Clone, Copy)]
pub(crate) struct Balance<K> {
    pub(crate) form: Form,
    /// Trial values of the shape.
    pub(crate) shapes: fn(&Extent) -> Vec<f64>,
    /// Parameters from the coefficients of the forces and the shape.
    pub(crate) values: fn(&[f64], f64) -> K,
    /// The other way round.
    pub(crate) coefficients: fn(K) -> (Vec<f64>, f64),
}

impl<K> Balance<K> {
    /// Forces that are proportional to the parameters.
    pub(crate) const fn forces(
        forces: &'static [Force],
        values: fn(&[f64], f64) -> K,
        coefficients: fn(K) -> (Vec<f64>, f64),
    ) -> Self {
        Self { form: Form::Forces(forces), shapes: |_| vec![0.0], values, coefficients }
    }

    /// A change with a single parameter, which is its shape.
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
