//! The columns of a joint.

use indexmap::IndexMap;

use super::follow::Follow;
use super::role::ColumnRole;
use super::units::{UnitGuess, is_stated};

/// A column that was chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// Its name in the run.
    pub column: String,
    /// Why.
    pub why: String,
    /// The apparent unit of its numbers, and the reason; `None` for SI.
    pub unit: Option<(UnitGuess, String)>,
}

impl Chosen {
    /// One of its numbers in SI.
    pub(super) fn in_si(&self) -> f64 {
        self.unit.as_ref().map_or(1.0, |(unit, _)| unit.in_si())
    }
}

/// Findings on a joint.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Guess {
    /// Columns by role.
    pub columns: IndexMap<ColumnRole, Chosen>,
    /// How the position follows the target, if both exist.
    pub follow: Option<Follow>,
}

impl Guess {
    /// Replaces units that a joint of this axis cannot have; a sentence for each.
    pub(super) fn fit_axis(&mut self, is_straight: bool) -> Vec<String> {
        let mut said = Vec::new();
        for (role, chosen) in &mut self.columns {
            let Some((unit, why)) = &chosen.unit else { continue };
            if unit.is_straight().is_none_or(|is_its| is_its == is_straight) {
                continue;
            }
            let (symbol, axis) = match (is_straight, role) {
                (true, ColumnRole::TargetVelocity) => ("mm/s", "slides"),
                (true, _) => ("mm", "slides"),
                (false, ColumnRole::TargetVelocity) => ("rad/s", "turns"),
                (false, _) => ("rad", "turns"),
            };
            said.push(format!("`{}` is taken for {symbol}: the joint {axis} (else: {why})", chosen.column));
            chosen.unit = is_straight.then(|| (UnitGuess::symbol(symbol), "the joint slides".into()));
        }
        said
    }

    /// A column whose file or name states a unit that a machine of this axis cannot have.
    pub(super) fn stated_against(&self, is_straight: bool) -> Option<String> {
        let is_other = |unit: &UnitGuess| unit.is_straight().is_some_and(|its| its != is_straight);
        let found = self.columns.values().find_map(|chosen| {
            let (unit, why) = chosen.unit.as_ref()?;
            (is_other(unit) && is_stated(why)).then_some((chosen, unit))
        });
        let (chosen, unit) = found?;
        let UnitGuess::Symbol(symbol) = unit else { return None };
        let axis = if is_straight { "slides" } else { "turns" };
        Some(format!("this machine {axis}, but `{}` is in {symbol}", chosen.column))
    }

    /// Whether its units are those of a slide.
    pub(super) fn is_straight(&self) -> bool {
        let mut units = self.columns.values().filter_map(|chosen| chosen.unit.as_ref());
        units.any(|(unit, _)| unit.is_straight() == Some(true))
    }
}
