//! Connected systems: series, append and feedback.

use nalgebra::DMatrix;

use crate::domain::TimeDomain;
use crate::error::{LtiError, require_shape};
use crate::state_space::StateSpace;

/// Writes `block` into `target` with its first element at `(row, column)`.
fn place(target: &mut DMatrix<f64>, row: usize, column: usize, block: &DMatrix<f64>) {
    target.view_mut((row, column), block.shape()).copy_from(block);
}

/// Block diagonal matrix of two matrices.
fn block_diagonal(first: &DMatrix<f64>, second: &DMatrix<f64>) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(first.nrows() + second.nrows(), first.ncols() + second.ncols());
    place(&mut out, 0, 0, first);
    place(&mut out, first.nrows(), first.ncols(), second);
    out
}

impl<T: TimeDomain> StateSpace<T> {
    fn require_same_domain(&self, other: &Self) -> Result<(), LtiError> {
        if self.domain() == other.domain() {
            return Ok(());
        }
        let period = |system: &Self| std::f64::consts::PI / system.domain().nyquist_rad_per_s();
        Err(LtiError::SampleTimes { left_s: period(self), right_s: period(other) })
    }

    /// Both systems side by side: inputs, outputs and states of `self` first, then those of `other`.
    ///
    /// # Errors
    /// [`LtiError::SampleTimes`].
    pub fn append(&self, other: &Self) -> Result<Self, LtiError> {
        self.require_same_domain(other)?;
        Self::with_domain(
            block_diagonal(self.a(), other.a()),
            block_diagonal(self.b(), other.b()),
            block_diagonal(self.c(), other.c()),
            block_diagonal(self.d(), other.d()),
            self.domain(),
        )
    }

    /// The output of `self` drives the input of `next`; states of `self` come first.
    ///
    /// # Errors
    /// [`LtiError::Shape`] if the number of outputs of `self` is not that of the inputs of `next`;
    /// [`LtiError::SampleTimes`].
    pub fn series(&self, next: &Self) -> Result<Self, LtiError> {
        self.require_same_domain(next)?;
        require_shape("D of the second system", next.d(), (next.outputs(), self.outputs()))?;
        let (n1, n2) = (self.states(), next.states());
        let mut a = block_diagonal(self.a(), next.a());
        place(&mut a, n1, 0, &(next.b() * self.c()));
        let mut b = DMatrix::zeros(n1 + n2, self.inputs());
        place(&mut b, 0, 0, self.b());
        place(&mut b, n1, 0, &(next.b() * self.d()));
        let mut c = DMatrix::zeros(next.outputs(), n1 + n2);
        place(&mut c, 0, 0, &(next.d() * self.c()));
        place(&mut c, 0, n1, next.c());
        Self::with_domain(a, b, c, next.d() * self.d(), self.domain())
    }

    /// Negative feedback: u = r - `back`(y), from r to y. States of `self` come first.
    ///
    /// # Errors
    /// [`LtiError::Shape`] unless `back` goes from the outputs of `self` to its inputs;
    /// [`LtiError::SampleTimes`]; [`LtiError::AlgebraicLoop`] if I + D `D_back` is singular.
    pub fn feedback(&self, back: &Self) -> Result<Self, LtiError> {
        self.require_same_domain(back)?;
        require_shape("D of the feedback system", back.d(), (self.inputs(), self.outputs()))?;
        let (n1, n2) = (self.states(), back.states());
        // u = r - Cb xb - Db y and y = C x + D u. Hence u = E (r - Cb xb - Db C x) with E = (I + Db D)^-1.
        let loop_matrix = DMatrix::identity(self.inputs(), self.inputs()) + back.d() * self.d();
        let e = loop_matrix
            .try_inverse()
            .filter(|e| e.iter().all(|v| v.is_finite()))
            .ok_or(LtiError::AlgebraicLoop)?;
        let u_x = -(&e * back.d() * self.c());
        let u_xb = -(&e * back.c());
        let y_x = self.c() + self.d() * &u_x;
        let y_xb = self.d() * &u_xb;
        let y_r = self.d() * &e;
        let mut a = DMatrix::zeros(n1 + n2, n1 + n2);
        place(&mut a, 0, 0, &(self.a() + self.b() * &u_x));
        place(&mut a, 0, n1, &(self.b() * &u_xb));
        place(&mut a, n1, 0, &(back.b() * &y_x));
        place(&mut a, n1, n1, &(back.a() + back.b() * &y_xb));
        let mut b = DMatrix::zeros(n1 + n2, self.inputs());
        place(&mut b, 0, 0, &(self.b() * &e));
        place(&mut b, n1, 0, &(back.b() * &y_r));
        let mut c = DMatrix::zeros(self.outputs(), n1 + n2);
        place(&mut c, 0, 0, &y_x);
        place(&mut c, 0, n1, &y_xb);
        Self::with_domain(a, b, c, y_r, self.domain())
    }
}
