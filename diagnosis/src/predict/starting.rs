//! The state in which a record begins, from its first rows.

use super::anchor::Anchor;
use super::begin::Parabola;
use super::load::swing;
use super::loops::at_start;
use super::machine::Moving;
use super::run::Predictor;
use super::state::State;
use crate::dataset::Driven;
use crate::error::DiagnosisError;

/// Number of rows along which a motion is simulated to find its initial state, and number of iterations:
/// friction may first act in the wrong direction.
const FEWEST_STARTING: usize = 6;
const MOST_STARTING: usize = 50;
const STARTS: usize = 3;
/// Largest number of rows that show whether a hidden spring swings from its start.
const MOST_SWINGING: usize = 200;

impl Predictor<'_> {
    /// The corrections towards the measured motion.
    pub(super) fn anchor(&self) -> Option<Anchor> {
        let (motion, times) = (&self.machine.motion, (self.record.spacing_s, self.pace));
        let (channels, silent) = (&self.dataset.channels, &self.record.silent);
        Anchor::new(motion, channels, silent, &self.surfaces, times, self.beside)
    }

    /// The state at the first row. Springs that no sensor shows are deflected if the first readings agree
    /// better with that.
    pub(super) fn start(
        &mut self,
        anchor: Option<&Anchor>,
        commands: &[Vec<f64>],
    ) -> Result<State, DiagnosisError> {
        let bare = self.start_with(anchor, commands, false)?;
        let Some(anchor) = anchor.filter(|anchor| !anchor.hidden.is_empty()) else { return Ok(bare) };
        let loaded = self.start_with(Some(anchor), commands, true)?;
        let step = anchor.finest_m;
        let q = |g: &usize| self.machine.motion.layout().q(*g);
        if anchor.hidden.iter().all(|g| (loaded.xi[q(g)] - bare.xi[q(g)]).abs() <= step) {
            return Ok(bare);
        }
        let [without, with] = [&bare, &loaded].map(|state| self.swing_from(state.clone(), commands));
        Ok(if with? < without? { loaded } else { bare })
    }

    /// Error of the first rows from a state, see [`swing`].
    fn swing_from(&mut self, mut state: State, commands: &[Vec<f64>]) -> Result<f64, DiagnosisError> {
        let dt = self.record.spacing_s;
        let rows = self.record.len().min(MOST_SWINGING);
        let mut predicted = Vec::with_capacity(rows);
        for k in 0..rows {
            self.machine.impose(&mut state, k as f64 * dt);
            let mut seen = Vec::new();
            self.machine.evaluate_signals(&state, &mut seen);
            predicted.push(seen);
            self.drive_on(&mut state, commands, k, dt)?;
        }
        Ok(swing(&predicted, &self.dataset.channels, self.machine.motion.assembly(), self.record))
    }

    /// The state at the first row, with springs deflected or as they are. If a record begins in motion,
    /// position and speed are corrected with the first readings. The difference between prediction and
    /// readings is a parabola: a wrong speed gives its slope, a missing force its curvature.
    fn start_with(
        &mut self,
        anchor: Option<&Anchor>,
        commands: &[Vec<f64>],
        is_loaded: bool,
    ) -> Result<State, DiagnosisError> {
        let mut moved = [0.0; 2];
        let mut state = self.begun(anchor, moved, commands, is_loaded);
        let Some(own) = anchor.filter(|_| self.is_in_motion && self.servos.is_empty()) else {
            return Ok(state);
        };
        let dt = self.record.spacing_s;
        let rows = ((1.0 / (self.pace * dt)) as usize).clamp(FEWEST_STARTING, MOST_STARTING);
        let mut seen = Vec::new();
        for _ in 0..STARTS {
            let mut beyond = Vec::with_capacity(rows);
            for k in 0..rows.min(self.record.len()) {
                self.machine.impose(&mut state, k as f64 * dt);
                self.machine.evaluate_signals(&state, &mut seen);
                beyond.extend(own.beyond(&seen, &self.record.series, k));
                self.drive_on(&mut state, commands, k, dt)?;
            }
            if let Some(bent) = Parabola::through(&beyond).filter(Parabola::is_finite) {
                moved = [moved[0] + bent.value, moved[1] + bent.speed / dt];
            }
            state = self.begun(anchor, moved, commands, is_loaded);
        }
        Ok(state)
    }

    /// The initial state with the chain `moved` in position and speed, and its springs deflected if asked.
    fn begun(
        &mut self,
        anchor: Option<&Anchor>,
        moved: [f64; 2],
        commands: &[Vec<f64>],
        is_loaded: bool,
    ) -> State {
        let begin = |machine: &Moving, xi: &mut [f64]| {
            if let Some(anchor) = anchor {
                anchor.shift(machine, xi, moved);
            }
        };
        let mut state = State { loops: at_start(&self.servos), ..self.machine.start(begin) };
        if let Some(anchor) = anchor.filter(|_| is_loaded) {
            let mut loaded = state.clone();
            for (&Driven { drive, .. }, commands) in self.dataset.drives.iter().zip(commands) {
                let first = &commands[..commands.len().min(FEWEST_STARTING)];
                let mean = first.iter().sum::<f64>() / first.len().max(1) as f64;
                self.machine.set_input(&mut loaded, drive, mean);
            }
            if self.machine.load(&mut loaded, &anchor.hidden, anchor.lead) {
                state = loaded;
            }
        }
        state
    }

    /// Error of the first rows, see [`swing`].
    pub(super) fn first_swing(&mut self) -> Result<f64, DiagnosisError> {
        let commands = self.effective_commands();
        let state = self.start(self.anchor().as_ref(), &commands)?;
        self.swing_from(state, &commands)
    }
}
