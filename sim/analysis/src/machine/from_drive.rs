//! From the command of a drive to an output of a linear machine.

use feeler_lti::StateSpace;
use feeler_plant::description::SignalName;
use nalgebra::DMatrix;

use crate::error::AnalysisError;
use crate::machine::channel::{ResponseChannel, reduce};
use crate::machine::imposed;
use crate::machine::linearise::{LinearMachine, OutputRow};

impl LinearMachine {
    /// From the command of an actuator to a signal, with only the states that matter and the delays of both
    /// ends.
    ///
    /// Bodies that nothing holds in place are described by their distances from one of them. Their drift is
    /// then a pole at exactly zero, and is left out if the output does not observe it.
    ///
    /// # Errors
    /// Those of [`Self::drive`] and [`Self::output`].
    pub fn channel(&self, input: &SignalName, output: &SignalName) -> Result<ResponseChannel, AnalysisError> {
        let drive = self.drive(input)?;
        let row = match self.output(self.source(output)?) {
            Err(AnalysisError::NotLinear { .. }) => {
                return Err(AnalysisError::NotLinear { name: output.to_string() });
            }
            other => other?,
        };
        self.channel_of(drive, &row)
    }

    /// From the command of drive `drive` to an output.
    ///
    /// # Errors
    /// [`AnalysisError::ImposedOutput`] if the output differentiates an imposed motion;
    /// [`AnalysisError::Lti`] if a number is not finite.
    pub fn channel_of(&self, drive: usize, output: &OutputRow) -> Result<ResponseChannel, AnalysisError> {
        if let Some(channel) = imposed::channel(self, drive, output) {
            return channel;
        }
        let c = DMatrix::from_fn(1, self.a().ncols(), |_, j| output.c[j]);
        let d = DMatrix::from_element(1, 1, output.d[drive]);
        let part = reduce(
            self.a(),
            &self.b().columns(drive, 1).into_owned(),
            &c,
            self.motion().layout().coordinates(),
        );
        let states = part.names(&self.motion().state_names());
        let system = StateSpace::new(part.a, part.b, part.c, d)?;
        Ok(ResponseChannel {
            system,
            states,
            delay_s: output.delay_s + self.motion().assembly().drives[drive].delay,
        })
    }
}
