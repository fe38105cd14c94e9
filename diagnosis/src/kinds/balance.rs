//! What a kind adds to the balance of forces of an axis that moves as one: the drive's command on one side,
//! on the other what it takes to accelerate the mass, to move it through its damping, and what the kind
//! adds.

/// Sizes of all experiments together.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Extent {
    /// Root mean square of the speed, m/s.
    pub(crate) speed: f64,
    /// From the least to the largest position, m.
    pub(crate) stroke: f64,
    /// Largest command, N.
    pub(crate) command: f64,
    /// Shortest time that is resolved, s.
    pub(crate) resolved_s: f64,
}

/// A motion at one row, with the value of the one parameter that a force is not proportional to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct At {
    pub(crate) position: f64,
    pub(crate) speed: f64,
    /// From -1 to 1: the direction of the motion, which turns as a guide gives way.
    pub(crate) direction: f64,
    pub(crate) shape: f64,
}

/// A force that resists, for a coefficient of one.
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

/// On which side of the balance a kind acts, and how.
#[derive(Clone, Copy)]
pub(crate) enum Form {
    /// Forces of the motion.
    Forces(&'static [Force]),
    /// A force that goes with acceleration.
    Mass,
    /// The force is this many times the command; its shape.
    Gain,
    /// The force follows the command with a time constant; its shape.
    Lag,
    /// The force comes later than the command; its shape.
    Delay,
    /// The force lacks a part that has the sign of the command.
    Deadband,
    /// The force stays below a limit; its shape.
    Limit,
}

/// What a kind adds, and how its parameters follow.
#[derive(Clone, Copy)]
pub(crate) struct Balance<K> {
    pub(crate) form: Form,
    /// Values of the shape that are tried.
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

    /// A change whose one parameter is its shape.
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
