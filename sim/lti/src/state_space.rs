//! State space with checked shapes, in continuous or discrete time.

use nalgebra::DMatrix;

use crate::domain::{Continuous, Discrete, TimeDomain};
use crate::error::{LtiError, require_finite, require_shape};

/// A linear system x' = A x + B u, y = C x + D u (or `x[n+1]`, see [`Discrete`]) with n states, m inputs and
/// p outputs.
#[derive(Debug, Clone, PartialEq)]
pub struct StateSpace<T: TimeDomain = Continuous> {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
    c: DMatrix<f64>,
    d: DMatrix<f64>,
    domain: T,
}

/// A linear system in discrete time.
pub type DiscreteStateSpace = StateSpace<Discrete>;

impl StateSpace<Continuous> {
    /// A continuous system from A (n x n), B (n x m), C (p x n), D (p x m); n may be zero.
    ///
    /// # Errors
    /// [`LtiError::Shape`] or [`LtiError::NotFinite`], naming the matrix.
    pub fn new(a: DMatrix<f64>, b: DMatrix<f64>, c: DMatrix<f64>, d: DMatrix<f64>) -> Result<Self, LtiError> {
        Self::with_domain(a, b, c, d, Continuous)
    }
}

impl StateSpace<Discrete> {
    /// A discrete system from A (n x n), B (n x m), C (p x n) and D (p x m). The sample time is in seconds.
    ///
    /// # Errors
    /// [`LtiError::Shape`], [`LtiError::NotFinite`] or [`LtiError::OutOfRange`].
    pub fn discrete(
        a: DMatrix<f64>,
        b: DMatrix<f64>,
        c: DMatrix<f64>,
        d: DMatrix<f64>,
        period_s: f64,
    ) -> Result<Self, LtiError> {
        Self::with_domain(a, b, c, d, Discrete::new(period_s)?)
    }

    /// Sample time, s.
    pub fn period_s(&self) -> f64 {
        self.domain.period_s()
    }
}

impl<T: TimeDomain> StateSpace<T> {
    /// A system in a given time domain.
    ///
    /// # Errors
    /// [`LtiError::Shape`] or [`LtiError::NotFinite`], naming the matrix.
    pub(crate) fn with_domain(
        a: DMatrix<f64>,
        b: DMatrix<f64>,
        c: DMatrix<f64>,
        d: DMatrix<f64>,
        domain: T,
    ) -> Result<Self, LtiError> {
        let n = a.nrows();
        require_shape("A", &a, (n, n))?;
        require_shape("B", &b, (n, d.ncols()))?;
        require_shape("C", &c, (d.nrows(), n))?;
        for (name, matrix) in [("A", &a), ("B", &b), ("C", &c), ("D", &d)] {
            require_finite(name, matrix)?;
        }
        Ok(Self { a, b, c, d, domain })
    }

    /// A memoryless gain y = D u.
    ///
    /// # Errors
    /// [`LtiError::NotFinite`].
    pub fn gain(d: DMatrix<f64>, domain: T) -> Result<Self, LtiError> {
        let (p, m) = d.shape();
        Self::with_domain(DMatrix::zeros(0, 0), DMatrix::zeros(0, m), DMatrix::zeros(p, 0), d, domain)
    }

    /// State matrix, n x n.
    pub fn a(&self) -> &DMatrix<f64> {
        &self.a
    }

    /// Input matrix, n x m.
    pub fn b(&self) -> &DMatrix<f64> {
        &self.b
    }

    /// Output matrix, p x n.
    pub fn c(&self) -> &DMatrix<f64> {
        &self.c
    }

    /// Feed-through matrix, p x m.
    pub fn d(&self) -> &DMatrix<f64> {
        &self.d
    }

    /// The time domain.
    pub fn domain(&self) -> T {
        self.domain
    }

    /// Number of states n.
    pub fn states(&self) -> usize {
        self.a.nrows()
    }

    /// Number of inputs m.
    pub fn inputs(&self) -> usize {
        self.d.ncols()
    }

    /// Number of outputs p.
    pub fn outputs(&self) -> usize {
        self.d.nrows()
    }

    /// The single-input single-output system from one input to one output, with all states.
    ///
    /// # Errors
    /// [`LtiError::NoSuchChannel`].
    pub fn channel(&self, output: usize, input: usize) -> Result<Self, LtiError> {
        if output >= self.outputs() {
            return Err(LtiError::NoSuchChannel { kind: "output", index: output, count: self.outputs() });
        }
        if input >= self.inputs() {
            return Err(LtiError::NoSuchChannel { kind: "input", index: input, count: self.inputs() });
        }
        Ok(Self {
            a: self.a.clone(),
            b: self.b.columns(input, 1).into_owned(),
            c: self.c.rows(output, 1).into_owned(),
            d: self.d.view((output, input), (1, 1)).into_owned(),
            domain: self.domain,
        })
    }

    /// The same system with its outputs multiplied by a number.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            a: self.a.clone(),
            b: self.b.clone(),
            c: &self.c * factor,
            d: &self.d * factor,
            domain: self.domain,
        }
    }

    /// Fails with [`LtiError::Shape`] unless there is one input and one output.
    pub(crate) fn require_siso(&self) -> Result<(), LtiError> {
        require_shape("D", &self.d, (1, 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_wrong_shapes_name_the_matrix() {
        let z = DMatrix::<f64>::zeros;
        let names = [
            (StateSpace::new(z(2, 3), z(2, 1), z(1, 2), z(1, 1)), "A"),
            (StateSpace::new(z(2, 2), z(3, 1), z(1, 2), z(1, 1)), "B"),
            (StateSpace::new(z(2, 2), z(2, 1), z(1, 3), z(1, 1)), "C"),
            (StateSpace::new(z(2, 2), z(2, 2), z(1, 2), z(1, 1)), "B"),
        ];
        for (result, name) in names {
            assert!(matches!(result, Err(LtiError::Shape { matrix, .. }) if matrix == name));
        }
        let nan = DMatrix::from_element(1, 1, f64::NAN);
        assert_eq!(StateSpace::gain(nan, Continuous), Err(LtiError::NotFinite { quantity: "D" }));
    }

    #[test]
    fn truth_channel_picks_row_and_column() {
        let d = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 3.0, 4.0]);
        let system = StateSpace::gain(d, Continuous).unwrap();
        assert_eq!(system.channel(1, 0).unwrap().d(), &DMatrix::from_element(1, 1, 3.0));
        assert_eq!(system.channel(2, 0), Err(LtiError::NoSuchChannel { kind: "output", index: 2, count: 2 }));
    }
}
