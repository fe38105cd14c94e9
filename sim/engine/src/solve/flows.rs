//! The flows of the modes that a machine has met.

use std::ops::{Index, IndexMut};

use feeler_plant::assembly::Source;
use feeler_plant::motion::modes::ModeTable;
use feeler_plant::motion::{Equations, Mode, Motion};

use crate::error::EngineError;
use crate::solve::flow::Flow;

/// One flow per mode, made at its first use.
#[derive(Debug)]
pub(crate) struct Flows {
    wanted: Vec<Source>,
    energy: bool,
    peaks: bool,
    met: Vec<Flow>,
}

impl Flows {
    /// No flows yet. Future flows provide the `wanted` signals, and the rows for ledger and peaks if these
    /// are kept.
    pub(crate) fn new(wanted: Vec<Source>, energy: bool, peaks: bool) -> Self {
        Self { wanted, energy, peaks, met: Vec::new() }
    }
}

impl ModeTable for Flows {
    type Error = EngineError;

    fn index_of(&mut self, motion: &Motion, mode: Mode) -> Result<usize, EngineError> {
        if let Some(i) = self.met.iter().position(|flow| flow.equations.mode == mode) {
            return Ok(i);
        }
        self.met.push(Flow::new(motion, mode, &self.wanted, self.energy, self.peaks)?);
        Ok(self.met.len() - 1)
    }

    fn equations(&self, index: usize) -> &Equations {
        &self.met[index].equations
    }
}

impl Index<usize> for Flows {
    type Output = Flow;

    fn index(&self, index: usize) -> &Flow {
        &self.met[index]
    }
}

impl IndexMut<usize> for Flows {
    fn index_mut(&mut self, index: usize) -> &mut Flow {
        &mut self.met[index]
    }
}
