//! The next mode after an input changes or a guard fires.

use super::{FrictionState, GuardValue, Mode, RampState, Switch, SwitchState};
use crate::motion::{Equations, Motion, dot};

/// A command this close to its target, relative to both, has arrived: a ramp of a few roundings ends before
/// the clock moves.
const AT_TARGET: f64 = 4.0 * f64::EPSILON;

/// The modes that a machine has met, with the means to carry its state through each.
pub trait ModeTable {
    /// Why a mode cannot be entered.
    type Error;

    /// The index of a mode, which is created at its first use.
    ///
    /// # Errors
    /// If no method can carry a state through the mode.
    fn index_of(&mut self, motion: &Motion, mode: Mode) -> Result<usize, Self::Error>;

    fn equations(&self, index: usize) -> &Equations;
}

/// A switch that has switched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Switched {
    /// Index of the next mode.
    pub index: usize,
    pub switch: Switch,
    pub from: SwitchState,
    pub to: SwitchState,
}

impl Motion {
    /// Gives drive `i` a new input in a mode, and returns the next mode. A drive with limited rate or with
    /// interpolation starts to ramp towards it.
    #[must_use]
    pub fn take_input(&self, mode: Mode, i: usize, value: f64, xi: &mut [f64]) -> Mode {
        let is_new = xi[self.layout.input(i)].to_bits() != value.to_bits();
        xi[self.layout.input(i)] = value;
        match (self.layout.ramp(i), self.number_of(Switch::Ramp(i))) {
            (Some(ramp), Some(switch)) => {
                if (value - xi[ramp]).abs() <= AT_TARGET * value.abs().max(xi[ramp].abs()) {
                    xi[ramp] = value;
                }
                let left = value - xi[ramp];
                if let Some(pace) = self.layout.pace(i).filter(|_| is_new) {
                    xi[pace] = self.assembly.drives[i].pace(left).copysign(left);
                }
                mode.with(switch, RampState::towards(left))
            }
            _ => mode,
        }
    }

    /// Handles a guard of the mode `index` that fires: the state follows its switch exactly, and the next
    /// mode is entered.
    ///
    /// # Errors
    /// Those of `table`.
    pub fn switch<T: ModeTable>(
        &self,
        table: &mut T,
        index: usize,
        guard: usize,
        xi: &mut [f64],
    ) -> Result<Switched, T::Error> {
        let equations = table.equations(index);
        let (mode, guard) = (equations.mode, &equations.guards[guard]);
        let (number, switch) = (guard.switch, self.switches[guard.switch]);
        let to = match guard.value {
            GuardValue::To(state) => state,
            GuardValue::Stop => self.after_stop(table, mode, number, xi)?.into(),
        };
        match (switch, to) {
            (Switch::Ramp(i), _) => {
                if let Some(ramp) = self.layout.ramp(i) {
                    xi[ramp] = xi[self.layout.input(i)];
                }
            }
            (Switch::Limit(i), to) => self.hold_force(i, to, xi),
            _ => {}
        }
        let index = table.index_of(self, mode.with(number, to))?;
        let entered = table.equations(index);
        self.join(entered, xi);
        self.fill_terms(entered, xi);
        Ok(Switched { index, switch, from: mode.state(switch, number), to })
    }

    /// A guide has come to rest: it sticks, or slides in the other direction.
    fn after_stop<T: ModeTable>(
        &self,
        table: &mut T,
        mode: Mode,
        switch: usize,
        xi: &[f64],
    ) -> Result<FrictionState, T::Error> {
        let index = table.index_of(self, mode.with(switch, FrictionState::Stick))?;
        let equations = table.equations(index);
        let mut rested = xi.to_vec();
        self.fill_terms(equations, &mut rested);
        let mut room = equations
            .guards
            .iter()
            .filter(|guard| guard.switch == switch)
            .map(|guard| dot(&guard.row, &rested));
        Ok(FrictionState::after_rest([(); 2].map(|()| room.next().unwrap_or(0.0))))
    }

    /// Makes the speeds of bodies that stick together bitwise equal.
    #[inline]
    pub fn join(&self, equations: &Equations, xi: &mut [f64]) {
        for &(member, lead) in &equations.joined {
            xi[self.layout.v(member)] = lead.map_or(0.0, |lead| xi[self.layout.v(lead)]);
        }
    }

    /// Sets a sliding guide to rest if a step has carried it past rest; momentum is conserved.
    pub fn stop_exactly(&self, equations: &Equations, guard: usize, xi: &mut [f64]) {
        let guard = &equations.guards[guard];
        let (GuardValue::Stop, Switch::Friction(link)) = (guard.value, self.switches[guard.switch]) else {
            return;
        };
        let link = &self.assembly.links[link];
        let is_imposed = |g: usize| self.coordinates.is_imposed(g);
        match [link.a, link.b].map(|node| self.coordinates.of(node)) {
            [Some(a), Some(b)] if is_imposed(a) != is_imposed(b) => {
                let (lead, other) = if is_imposed(a) { (a, b) } else { (b, a) };
                xi[self.layout.v(other)] = xi[self.layout.v(lead)];
            }
            [Some(a), Some(b)] => {
                let [ma, mb] = [a, b].map(|g| self.coordinates.mass_kg(g));
                let [va, vb] = [a, b].map(|g| self.layout.v(g));
                let joint = (ma * xi[va] + mb * xi[vb]) / (ma + mb);
                xi[va] = joint;
                xi[vb] = joint;
            }
            [Some(g), None] | [None, Some(g)] if is_imposed(g) => {}
            [Some(g), None] | [None, Some(g)] => xi[self.layout.v(g)] = 0.0,
            [None, None] => {}
        }
    }
}

/// The groups that follow from pairs of equal speeds (`None`: ground): each member with the first one, or
/// with ground, once. A coordinate with imposed motion leads its group and never follows.
pub(in crate::motion) fn joined(
    pairs: &[[Option<usize>; 2]],
    coordinates: usize,
    is_imposed: impl Fn(usize) -> bool,
) -> Vec<(usize, Option<usize>)> {
    let mut lead: Vec<Option<usize>> = (0..coordinates).map(Some).collect();
    let lead_of = |lead: &[Option<usize>], end: Option<usize>| end.and_then(|g| lead[g]);
    for &[a, b] in pairs {
        let (a, b) = (lead_of(&lead, a), lead_of(&lead, b));
        // `None`, the ground, is less than any coordinate.
        let (low, high) = (a.min(b), a.max(b));
        lead.iter_mut().filter(|l| **l == high).for_each(|l| *l = low);
    }
    for g in (0..coordinates).filter(|g| is_imposed(*g)) {
        let of_group = lead[g];
        lead.iter_mut().filter(|l| **l == of_group).for_each(|l| *l = Some(g));
    }
    (0..coordinates).map(|g| (g, lead[g])).filter(|(g, lead)| *lead != Some(*g) && !is_imposed(*g)).collect()
}
