//! The mode of a state that was not reached by motion.

use super::{ContactState, DirectionState, FrictionState, GuardValue, Mode, ModeTable, Switch, SwitchState};
use crate::motion::{Motion, dot};

/// The initial mode of a machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Beginning {
    /// Index of the mode in which everything that is compressed pushes.
    pub pressed: usize,
    /// Index of the actual mode: surfaces that part faster than their law pushes are releasing.
    pub index: usize,
    /// The switches in which these two modes differ.
    pub releasing: Vec<Switch>,
}

impl Motion {
    /// The mode of given positions and speeds; limits and ramps stay as in `held`. Fills in the nonlinear
    /// terms of `xi`.
    ///
    /// # Errors
    /// Those of `table`.
    pub fn begin<T: ModeTable>(
        &self,
        table: &mut T,
        held: Mode,
        xi: &mut [f64],
    ) -> Result<Beginning, T::Error> {
        let mut mode = self.pressed_mode(held, xi);
        let pressed = table.index_of(self, mode)?;
        self.fill_terms(table.equations(pressed), xi);
        // The contacts do not affect each other here, so one pass is enough.
        let mut releasing = Vec::new();
        for guard in &table.equations(pressed).guards {
            if guard.value == GuardValue::To(SwitchState::Contact(ContactState::Releasing))
                && dot(&guard.row, xi) < 0.0
            {
                mode = mode.with(guard.switch, ContactState::Releasing);
                releasing.push(self.switches[guard.switch]);
            }
        }
        let index = table.index_of(self, mode)?;
        self.fill_terms(table.equations(index), xi);
        Ok(Beginning { pressed, index, releasing })
    }

    /// The mode of a state if everything compressed pushed.
    fn pressed_mode(&self, held: Mode, xi: &[f64]) -> Mode {
        let equations = self.equations(Mode::default());
        let value = |row: &[f64]| dot(row, xi);
        let mut mode = held;
        for (i, &switch) in self.switches.iter().enumerate() {
            mode = match switch {
                Switch::Contact(c) => mode.with(i, ContactState::at(value(&equations.compression[c][0]))),
                Switch::Stop(link, side) => {
                    let e = value(&equations.elongation[link][0]);
                    let mut stops = self.assembly.links[link].stops();
                    let is_compressed = stops.any(|(s, at)| s == side && side.sign() * (e - at) > 0.0);
                    mode.with(i, if is_compressed { ContactState::Pushing } else { ContactState::Open })
                }
                Switch::Friction(link) => {
                    mode.with(i, FrictionState::at(value(&equations.elongation[link][1])))
                }
                Switch::Direction(link) => {
                    mode.with(i, DirectionState::at(value(&equations.elongation[link][1])))
                }
                Switch::Limit(_) | Switch::Line(_) | Switch::Deadband(_) | Switch::Ramp(_) => mode,
            };
        }
        mode
    }
}
