//! Linearisation: the state space of small motions of a machine about rest.

use feeler_engine::EngineError;
use feeler_plant::assembly::{Assembly, Drive, Source, assemble, resolve};
use feeler_plant::description::{Machine, Quantity, SignalName};
use feeler_plant::motion::{Equations, Mode, Motion, Row};

use nalgebra::{DMatrix, RowDVector};

use crate::error::AnalysisError;
use crate::machine::equilibrium::{Holding, OperatingPoint, eliminate, equilibrium, term_gradients};
use crate::machine::prepare::{View, without_switches};

/// Small motions of a machine about an operating point: `x' = A x + B u`, with the command of each drive as
/// an input.
///
/// States are those of [`feeler_plant::motion::Layout`]: positions, speeds, then states of drives and sensor
/// filters, all as deviations. Delays of drives and sensors are not part of it. They accompany each input and
/// output, exactly.
#[derive(Clone, Debug)]
pub struct LinearMachine {
    machine: Machine,
    motion: Motion,
    equations: Equations,
    gradients: Vec<Row>,
    operating_point: OperatingPoint,
    a: DMatrix<f64>,
    b: DMatrix<f64>,
}

/// Inputs that hold the machine at rest. A held command acts within deadband and limit.
fn holding(assembly: &Assembly, view: &View) -> Holding {
    let held = view.held.and_then(|held| assembly.drives.get(held.drive).map(|drive| (held, drive)));
    held.map_or(Holding::Preload(view.preload_n()), |(held, drive)| Holding::Drive {
        drive: held.drive,
        effort: drive.held(held.command),
    })
}

/// An output: `y = C x + D u`, `delay_s` later.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputRow {
    /// One entry per state.
    pub c: RowDVector<f64>,
    /// One entry per drive.
    pub d: RowDVector<f64>,
    /// Pure delay, s.
    pub delay_s: f64,
}

impl LinearMachine {
    /// Linearises a machine.
    ///
    /// # Errors
    /// The mistakes of the machine; [`AnalysisError::NoEquilibrium`] if a nonlinear machine cannot rest.
    pub fn new(machine: &Machine, view: &View) -> Result<Self, AnalysisError> {
        let mut assembly = assemble(machine).map_err(|problems| EngineError::Problems { problems })?;
        // Without its loops a machine has no samples, so its servos are continuous.
        assembly.drives.iter_mut().for_each(Drive::make_continuous);
        assembly.drives.iter_mut().for_each(|drive| drive.linearise_interpolation(None));
        Self::of_assembly(machine, &assembly, view)
    }

    /// Linearises an assembly of this machine. The assembly may have other parameter values, and more rigid
    /// links.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(crate) fn of_assembly(
        machine: &Machine,
        assembly: &Assembly,
        view: &View,
    ) -> Result<Self, AnalysisError> {
        let frozen = without_switches(assembly, view);
        let motion = Motion::new(frozen).map_err(|problems| EngineError::Problems { problems })?;
        let equations = motion.equations(Mode::default());
        let operating_point = equilibrium(&motion, &equations, holding(assembly, view))?;
        let gradients = term_gradients(&motion, &equations, &operating_point.xi);
        let layout = motion.layout();
        let (n, m) = (layout.states(), layout.inputs());
        let rows: Vec<Row> =
            equations.derivative.iter().map(|row| eliminate(&motion, &gradients, row)).collect();
        let a = DMatrix::from_fn(n, n, |i, j| rows[i][j]);
        let b = DMatrix::from_fn(n, m, |i, j| rows[i][layout.input(j)] * motion.assembly().drives[j].gain);
        Ok(Self { machine: machine.clone(), motion, equations, gradients, operating_point, a, b })
    }

    /// The machine as described.
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// The machine's motion, with contacts, friction and limits as in the view.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// The equations of motion at the operating point.
    pub fn equations(&self) -> &Equations {
        &self.equations
    }

    /// The operating point of the linearisation.
    pub fn operating_point(&self) -> &OperatingPoint {
        &self.operating_point
    }

    /// State matrix, 1/s.
    pub fn a(&self) -> &DMatrix<f64> {
        &self.a
    }

    /// Input matrix, one column per drive command.
    pub fn b(&self) -> &DMatrix<f64> {
        &self.b
    }

    /// A row of the extended vector as an output, without delay.
    pub fn row(&self, row: &Row) -> OutputRow {
        let layout = self.motion.layout();
        let linear = eliminate(&self.motion, &self.gradients, row);
        OutputRow {
            c: RowDVector::from_fn(layout.states(), |_, j| linear[j]),
            d: RowDVector::from_fn(layout.inputs(), |_, j| {
                linear[layout.input(j)] * self.motion.assembly().drives[j].gain
            }),
            delay_s: 0.0,
        }
    }

    /// The plant's signal of this name.
    ///
    /// # Errors
    /// [`AnalysisError::Signal`].
    pub fn source(&self, signal: &SignalName) -> Result<Source, AnalysisError> {
        Ok(resolve(&self.machine, signal)?)
    }

    /// A signal as an output; a sensor's reading comes with its gain, filters and delay.
    ///
    /// # Errors
    /// [`AnalysisError::NotLinear`] for whether a contact touches, and for commands.
    pub fn output(&self, source: Source) -> Result<OutputRow, AnalysisError> {
        let row = self.motion.signal(&self.equations, source);
        let row = row.ok_or_else(|| AnalysisError::NotLinear { name: format!("{source:?}") })?;
        let mut output = self.row(&row);
        if let Source::Sensor(i) = source {
            let sensor = &self.motion.assembly().sensors[i];
            output.c *= sensor.gain;
            output.d *= sensor.gain;
            output.delay_s = sensor.delay;
        }
        Ok(output)
    }

    /// The drive whose command a signal is, or its [`Self::input`].
    ///
    /// # Errors
    /// [`AnalysisError::NotAnInput`] for any other signal.
    pub fn drive(&self, signal: &SignalName) -> Result<usize, AnalysisError> {
        match self.source(signal)? {
            Source::Drive(i, Quantity::Command) => Ok(i),
            Source::Drive(i, _) if *signal == self.input(i) => Ok(i),
            _ => Err(AnalysisError::NotAnInput { name: signal.to_string() }),
        }
    }

    /// The input of drive `drive` by name. For a sampled servo it is the force, since its loop is not part of
    /// the machine.
    pub fn input(&self, drive: usize) -> SignalName {
        let part = &self.motion.assembly().drives[drive];
        let is_force = part.sampling().is_some();
        SignalName::new(&part.name, if is_force { Quantity::Force } else { Quantity::Command })
    }
}
