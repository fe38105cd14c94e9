//! The records of variants that run side by side.

use feeler_engine::{Event, Observer, Program, Trace};
use feeler_lanes::Lane;

use crate::run::record::recording;

/// Number of rows that are split into lanes together, so that each column grows by a large enough piece.
const ROWS: usize = 32;

/// A pause of a computation that goes on in the background.
pub(in crate::run) type Rest<'r> = &'r dyn Fn();

/// One trace per lane; a closed lane records nothing further. Its memory serves one block of variants after
/// another.
pub(in crate::run) struct Lanes<'r, L> {
    traces: Vec<Trace>,
    open: Vec<bool>,
    /// Rows of all lanes that are not yet in the traces.
    t_s: Vec<f64>,
    rows: Vec<L>,
    /// Called at each row.
    rest: Rest<'r>,
}

impl<'r, L: Lane> Lanes<'r, L> {
    pub(in crate::run) fn new(rest: Rest<'r>) -> Self {
        Self {
            traces: vec![Trace::default(); L::WIDTH],
            open: vec![true; L::WIDTH],
            t_s: Vec::new(),
            rows: Vec::new(),
            rest,
        }
    }

    /// Restarts with other variants, one per lane.
    pub(in crate::run) fn begin<'a>(&mut self, programs: impl Iterator<Item = &'a Program>) {
        self.open.fill(true);
        self.t_s.clear();
        self.rows.clear();
        for (trace, program) in self.traces.iter_mut().zip(programs) {
            trace.names = program.record_names().to_vec();
            trace.events.clear();
            trace.columns.resize_with(trace.names.len(), Vec::new);
            let rows = (program.settings().duration_s / program.record_spacing_s()) as usize + 1;
            for column in trace.columns.iter_mut().chain([&mut trace.t_s]) {
                column.clear();
                column.reserve(rows);
            }
        }
    }

    /// The pause at each row.
    pub(in crate::run) fn rest(&self) -> Rest<'r> {
        self.rest
    }

    /// Lanes that are not closed.
    pub(in crate::run) fn open(&self) -> Vec<usize> {
        (0..L::WIDTH).filter(|&l| self.open[l]).collect()
    }

    /// Ends the record of a lane.
    pub(in crate::run) fn close(&mut self, lane: usize) {
        self.open[lane] = false;
    }

    /// The record of a lane so far, as far as its motion is defined.
    pub(in crate::run) fn trace(&mut self, lane: usize) -> &Trace {
        self.take_apart();
        recording::drop_undefined_rows(&mut self.traces[lane]);
        &self.traces[lane]
    }

    /// Moves the waiting rows into the traces.
    fn take_apart(&mut self) {
        let signals = (self.rows.len() / self.t_s.len().max(1)).max(1);
        for (l, trace) in self.traces.iter_mut().enumerate().filter(|(l, _)| self.open[*l]) {
            trace.t_s.extend_from_slice(&self.t_s);
            for (s, column) in trace.columns.iter_mut().enumerate() {
                column.extend(self.rows.chunks_exact(signals).map(|row| row[s].lane(l)));
            }
        }
        self.t_s.clear();
        self.rows.clear();
    }
}

impl<L: Lane> Observer<L> for Lanes<'_, L> {
    fn record(&mut self, t_s: f64, values: &[L]) {
        (self.rest)();
        self.t_s.push(t_s);
        self.rows.extend_from_slice(values);
        if self.t_s.len() == ROWS {
            self.take_apart();
        }
    }

    fn event(&mut self, lane: usize, event: &Event) {
        if self.open[lane] {
            self.traces[lane].events.push(*event);
        }
    }
}
