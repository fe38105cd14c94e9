//! Response of a sampled system to a record.

use nalgebra::{DMatrix, DVector};

use crate::error::{LtiError, require_shape};
use crate::state_space::DiscreteStateSpace;

impl DiscreteStateSpace {
    /// Outputs (outputs x samples) for inputs (inputs x samples), from an initial state (n).
    ///
    /// # Errors
    /// [`LtiError::Shape`].
    pub fn respond(&self, initial: &DVector<f64>, inputs: &DMatrix<f64>) -> Result<DMatrix<f64>, LtiError> {
        require_shape("inputs", inputs, (self.inputs(), inputs.ncols()))?;
        require_shape(
            "initial state",
            &DMatrix::from_column_slice(initial.len(), 1, initial.as_slice()),
            (self.states(), 1),
        )?;
        let mut x = initial.clone();
        let mut outputs = DMatrix::zeros(self.outputs(), inputs.ncols());
        for (k, u) in inputs.column_iter().enumerate() {
            outputs.set_column(k, &(self.c() * &x + self.d() * u));
            x = self.a() * x + self.b() * u;
        }
        Ok(outputs)
    }
}
