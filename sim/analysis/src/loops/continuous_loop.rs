//! The loop as drawn on paper: continuous laws without sampling, hold, delay or filters of sensors and
//! readings. Drives keep their lags.

use feeler_control::ControllerSpec;
use feeler_lti::StateSpace;
use feeler_plant::assembly::Source;
use nalgebra::{DMatrix, RowDVector};

use crate::error::AnalysisError;
use crate::loops::continuous_law::{ContinuousLaw, INPUTS, POSITION, READING, READING_RATE, VELOCITY};
use crate::loops::control_loop::{ControlLoop, LoopPlant, Probe};
use crate::machine::linearise::OutputRow;

/// The continuous loop of a [`ControlLoop`].
#[derive(Clone, Debug)]
pub struct ContinuousLoop {
    whole: ControlLoop,
    plant: LoopPlant,
}

impl ContinuousLoop {
    /// The continuous loop of a machine and its controllers.
    ///
    /// # Errors
    /// Those of [`ControlLoop::altered`].
    pub fn new(whole: &ControlLoop) -> Result<Self, AnalysisError> {
        let whole = on_paper(whole)?;
        let plant = whole.loop_plant(None)?;
        Ok(Self { whole, plant })
    }

    /// From the output of one controller to a sensor, with the other controllers closed.
    ///
    /// # Errors
    /// As [`Self::closed_loop`].
    pub(crate) fn response_to(
        whole: &ControlLoop,
        controller: usize,
        sensor: usize,
    ) -> Result<StateSpace, AnalysisError> {
        let whole = on_paper(whole)?;
        let output = whole.plant().output(Source::Sensor(sensor))?;
        let plant = whole.loop_plant(Some((controller, output)))?;
        let this = Self { whole, plant };
        this.assemble(&this.whole.specs(), Some((controller, Probe::Reading)))
    }

    /// State matrix of the closed loop. The plant's states come first.
    ///
    /// # Errors
    /// [`AnalysisError::Improper`] if a law differentiates a signal that jumps with the command.
    pub fn closed_loop(&self) -> Result<DMatrix<f64>, AnalysisError> {
        Ok(self.assemble(&self.whole.specs(), None)?.a().clone())
    }

    /// State matrix of the closed loop with one gain changed. The plant's states come first.
    ///
    /// # Errors
    /// [`AnalysisError::NoGain`], [`AnalysisError::Improper`].
    pub fn closed_loop_with(
        &self,
        controller: usize,
        gain: &str,
        value: f64,
    ) -> Result<DMatrix<f64>, AnalysisError> {
        Ok(self.assemble(&self.whole.specs_with(controller, gain, value)?, None)?.a().clone())
    }

    /// The loop broken at the output of one controller, with the others closed: from that output to the
    /// negated response of the controller.
    ///
    /// # Errors
    /// As [`Self::closed_loop`].
    pub fn open_loop(&self, controller: usize) -> Result<StateSpace, AnalysisError> {
        self.assemble(&self.whole.specs(), Some((controller, Probe::Law)))
    }

    /// Matrix from a state of the loop to positions and speeds of the machine.
    pub(crate) fn expand(&self) -> &DMatrix<f64> {
        &self.plant.reduced.expand
    }

    /// Collects all states and each controller's inputs as `H x + J u`, then closes the loop.
    fn assemble(
        &self,
        specs: &[ControllerSpec],
        broken: Option<(usize, Probe)>,
    ) -> Result<StateSpace, AnalysisError> {
        let controllers = self.whole.controllers();
        let laws: Vec<ContinuousLaw> = specs.iter().map(ContinuousLaw::new).collect();
        let part = &self.plant.reduced;
        let (n, drives) = part.b.shape();
        let integrates: Vec<bool> = controllers
            .iter()
            .zip(&laws)
            .map(|(c, law)| c.motion_is_velocity && c.motion.is_some() && law.uses(POSITION))
            .collect();
        let order = n
            + laws.iter().map(|law| law.a.nrows()).sum::<usize>()
            + integrates.iter().filter(|i| **i).count();
        let mut a = DMatrix::zeros(order, order);
        a.view_mut((0, 0), (n, n)).copy_from(&part.a);
        let mut b = DMatrix::zeros(order, drives);
        b.view_mut((0, 0), (n, drives)).copy_from(&part.b);
        // Outputs of the controllers: u = P x + Q u over drives.
        let count = controllers.len();
        let (mut p, mut q) = (DMatrix::zeros(count, order), DMatrix::zeros(count, drives));
        let mut probe = (RowDVector::zeros(order), RowDVector::zeros(drives));
        let mut next = n;
        for (i, (controller, law)) in controllers.iter().zip(&laws).enumerate() {
            let (mut h, mut j) = (DMatrix::zeros(INPUTS, order), DMatrix::zeros(INPUTS, drives));
            if let Some(reading) = &self.plant.reading[i] {
                self.signal(&controller.name, law, [READING, READING_RATE], reading, &mut h, &mut j)?;
            }
            if let Some(motion) = &self.plant.motion[i] {
                if controller.motion_is_velocity {
                    h.view_mut((VELOCITY, 0), (1, n)).copy_from(&motion.c);
                    j.row_mut(VELOCITY).copy_from(&motion.d);
                    if integrates[i] {
                        a.view_mut((next, 0), (1, n)).copy_from(&motion.c);
                        h[(POSITION, next)] = 1.0;
                        next += 1;
                    }
                } else {
                    self.signal(&controller.name, law, [POSITION, VELOCITY], motion, &mut h, &mut j)?;
                }
            }
            let states = law.a.nrows();
            a.view_mut((next, next), (states, states)).copy_from(&law.a);
            let mut rows = a.rows_mut(next, states);
            rows += &law.b * &h;
            b.rows_mut(next, states).copy_from(&(&law.b * &j));
            p.row_mut(i).copy_from(&(&law.d * &h));
            p.view_mut((i, next), (1, states)).copy_from(&law.c);
            q.row_mut(i).copy_from(&(&law.d * &j));
            match broken {
                Some((controller, Probe::Law)) if controller == i => probe = (-p.row(i), -q.row(i)),
                Some((controller, Probe::Reading)) if controller == i => {
                    probe = (h.row(READING).into_owned(), j.row(READING).into_owned());
                }
                _ => {}
            }
            next += states;
        }
        let drive_of: Vec<usize> = controllers.iter().map(|c| c.drive).collect();
        close([&a, &b, &p, &q], &drive_of, broken.map(|(controller, _)| controller), &probe)
    }

    /// A signal and its derivative as inputs of a law.
    fn signal(
        &self,
        name: &str,
        law: &ContinuousLaw,
        [value, rate]: [usize; 2],
        row: &OutputRow,
        h: &mut DMatrix<f64>,
        j: &mut DMatrix<f64>,
    ) -> Result<(), AnalysisError> {
        let part = &self.plant.reduced;
        let n = part.a.nrows();
        h.view_mut((value, 0), (1, n)).copy_from(&row.c);
        j.row_mut(value).copy_from(&row.d);
        if law.uses(rate) {
            if row.d.amax() > 0.0 {
                return Err(AnalysisError::Improper { name: name.into() });
            }
            h.view_mut((rate, 0), (1, n)).copy_from(&(&row.c * &part.a));
            j.row_mut(rate).copy_from(&(&row.c * &part.b));
        }
        Ok(())
    }
}

/// A machine and its controllers without the filters and delays of sensors.
fn on_paper(whole: &ControlLoop) -> Result<ControlLoop, AnalysisError> {
    whole.altered(|assembly, _| {
        for sensor in &mut assembly.sensors {
            sensor.filters.clear();
            sensor.delay = 0.0;
        }
    })
}

/// Controllers' outputs `p x + q u` drive `u`. The input replaces the broken one, and the output is the probe
/// `c x + d u`.
fn close(
    [a, b, p, q]: [&DMatrix<f64>; 4],
    drive_of: &[usize],
    broken: Option<usize>,
    (c, d): &(RowDVector<f64>, RowDVector<f64>),
) -> Result<StateSpace, AnalysisError> {
    let drives = b.ncols();
    // Which controllers feed which drive.
    let select = DMatrix::from_fn(drives, drive_of.len(), |d, i| {
        f64::from(u8::from(drive_of[i] == d && broken != Some(i)))
    });
    let around = DMatrix::identity(drives, drives) - &select * q;
    let inverse = around.try_inverse().ok_or(feeler_lti::LtiError::AlgebraicLoop)?;
    let enter =
        DMatrix::from_fn(drives, 1, |d, _| f64::from(u8::from(broken.is_some_and(|i| drive_of[i] == d))));
    let u_x = &inverse * &select * p;
    let u_r = &inverse * enter;
    let c = c + d * &u_x;
    let d = d * &u_r;
    Ok(StateSpace::new(
        a + b * u_x,
        b * u_r,
        DMatrix::from_row_slice(1, c.len(), c.as_slice()),
        DMatrix::from_row_slice(1, 1, d.as_slice()),
    )?)
}
