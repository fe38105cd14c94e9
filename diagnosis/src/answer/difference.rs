//! Differences between two machines, printed as lines of a machine file.

use std::fmt;

use feeler_plant::description::{Axis, Element, Machine};
use feeler_plant::effects::{EffectUse, Kind};
use feeler_plant::units::Dimension;
use indexmap::IndexMap;
use serde::Serialize;

use crate::fit::model::Model;

/// Smaller relative changes are rounding errors.
const ROUNDING: f64 = 1e-9;
/// Smaller changes, in percent, are printed without a percentage.
const LEAST_PERCENT: f64 = 0.05;
/// Larger changes are not printed in percent: the old value was nearly zero.
const MOST_PERCENT: f64 = 1e4;
/// Significant digits of printed values.
const DIGITS: usize = 5;

/// A changed value.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Changed {
    /// Dotted key, such as `bodies.motor.mass`.
    pub key: String,
    /// Believed value, SI.
    pub old: f64,
    /// Value found, SI.
    pub new: f64,
    /// SI unit.
    pub unit: String,
    /// Whether calibration stopped at the tolerance; the true value may then be farther off.
    pub is_at_end: bool,
}

/// An effect that only the new machine has.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Added {
    /// Key of its table, such as `springs.guide.effects.coulomb-friction`.
    pub key: String,
    /// Name, value (SI) and unit of its parameters.
    pub parameters: Vec<(&'static str, f64, String)>,
}

/// The changes from one machine to another.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Difference {
    /// Changed values, in the order of the file.
    pub changed: Vec<Changed>,
    /// Effects that are added.
    pub added: Vec<Added>,
    /// Tables of believed effects that other effects replace.
    pub removed: Vec<String>,
}

impl Difference {
    /// The changes from `old` to `new`. Both machines have the same elements.
    pub fn between(old: &Machine, new: &Machine) -> Self {
        let rotational = old.axis == Axis::Rotational;
        let unit = |dimension: Dimension| dimension.si_unit(rotational).into_owned();
        let mut found = Self::default();
        for (key, a, b) in pairs(old, new) {
            for (a, b) in a.believed().iter().zip(&b.believed()) {
                let (old, new, unit) = (a.value, b.value, unit(a.dimension()));
                if (new - old).abs() > ROUNDING * old.abs().max(new.abs()) {
                    let key = format!("{key}.{}", a.key.name);
                    found.changed.push(Changed { key, old, new, unit, is_at_end: false });
                }
            }
            let of_kind = |effects: &'_ [EffectUse], kind: Kind| {
                effects.iter().find(|effect| effect.definition.kind == kind).cloned()
            };
            for effect in b.effects() {
                let kind = effect.definition.kind;
                let parameters = effect.definition.parameters.iter().zip(&effect.values);
                let key = format!("{key}.effects.{kind}");
                let Some(believed) = of_kind(a.effects(), kind) else {
                    let parameters = parameters.map(|(p, value)| (p.name, *value, unit(p.dimension)));
                    found.added.push(Added { key, parameters: parameters.collect() });
                    continue;
                };
                for ((p, &new), &old) in parameters.zip(&believed.values) {
                    if (new - old).abs() > ROUNDING * old.abs().max(new.abs()) {
                        let (key, unit) = (format!("{key}.{}", p.name), unit(p.dimension));
                        found.changed.push(Changed { key, old, new, unit, is_at_end: false });
                    }
                }
            }
            let gone = a.effects().iter().map(|effect| effect.definition.kind);
            let gone = gone.filter(|kind| of_kind(b.effects(), *kind).is_none());
            found.removed.extend(gone.map(|kind| format!("{key}.effects.{kind}")));
        }
        found
    }

    /// Marks values that calibration moved to the end of their tolerance. `old` is the believed machine;
    /// `tolerance` holds the tolerances stated in its file.
    #[must_use]
    pub(crate) fn with_ends(mut self, old: &Machine, tolerance: &IndexMap<String, f64>) -> Self {
        if let Ok(model) = Model::calibration(old, tolerance) {
            for changed in &mut self.changed {
                changed.is_at_end = model.is_at_end(&changed.key, changed.new);
            }
        }
        self
    }

    /// Whether the machines are equal.
    pub fn is_empty(&self) -> bool {
        self.changed.is_empty() && self.added.is_empty() && self.removed.is_empty()
    }
}

/// Elements of both machines, with their keys.
fn pairs<'a>(
    old: &'a Machine,
    new: &'a Machine,
) -> impl Iterator<Item = (String, &'a dyn Element, &'a dyn Element)> {
    old.sites().filter_map(move |site| {
        let (name, a) = old.element(site)?;
        let mut same = new.sites().filter(|other| other.table == site.table);
        let (_, b) = same.find_map(|other| new.element(other).filter(|(other, _)| *other == name))?;
        Some((site.key(old), a, b))
    })
}

/// Prints a number with few digits and no trailing zeros.
fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value);
    if rounded != 0.0 && !(1e-3..1e6).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        format!("{rounded}")
    }
}

impl fmt::Display for Difference {
    /// Writes lines of a machine file: values as `key = new  # was old`, effects as separate tables.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for Changed { key, old, new, unit, is_at_end } in &self.changed {
            let percent = 100.0 * (new / old - 1.0);
            let share = if (LEAST_PERCENT..MOST_PERCENT).contains(&percent.abs()) {
                format!(", {percent:+.1} %")
            } else {
                String::new()
            };
            let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
            let end = if *is_at_end { " (at the end of its tolerance)" } else { "" };
            writeln!(f, "{key} = {}  # was {}{unit}{share}{end}", short(*new), short(*old))?;
        }
        for key in &self.removed {
            writeln!(f, "# remove [{key}]: another effect replaces it")?;
        }
        for Added { key, parameters } in &self.added {
            writeln!(f, "\n[{key}]")?;
            for (name, value, unit) in parameters {
                let unit = if unit.is_empty() { String::new() } else { format!("  # {unit}") };
                writeln!(f, "{name} = {}{unit}", short(*value))?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_files::Document;

    const BELIEVED: &str =
        "[bodies.tip]\nmass = 5.0\n[springs.guide]\nbetween = [\"ground\", \"tip\"]\ndamping = 60.0\n";

    #[test]
    fn truth_a_value_and_an_effect_are_found_and_written() {
        let old = Document::parse(BELIEVED, "old.toml").unwrap().scenario.machine;
        let text =
            BELIEVED.replace("5.0", "5.5") + "[springs.guide.effects.coulomb-friction]\nlevel = 12.0\n";
        let new = Document::parse(&text, "new.toml").unwrap().scenario.machine;
        let found = Difference::between(&old, &new);
        assert_eq!(
            found.to_string(),
            "bodies.tip.mass = 5.5  # was 5 kg, +10.0 %\n\n\
             [springs.guide.effects.coulomb-friction]\nlevel = 12  # N\n"
        );
        assert!(Difference::between(&old, &old).is_empty());
    }

    #[test]
    fn truth_a_believed_effect_is_changed_or_gives_way_to_another() {
        let parse = |effect: &str| {
            let text = format!("{BELIEVED}[springs.guide.effects.{effect}\n");
            Document::parse(&text, "machine.toml").unwrap().scenario.machine
        };
        let old = parse("coulomb-friction]\nlevel = 10.0");
        let said = |effect: &str| Difference::between(&old, &parse(effect)).to_string();
        assert_eq!(
            said("coulomb-friction]\nlevel = 12.0"),
            "springs.guide.effects.coulomb-friction.level = 12  # was 10 N, +20.0 %\n"
        );
        assert_eq!(
            said("asymmetric-friction]\nlevel = 12.0\nasymmetry = 0.2"),
            "# remove [springs.guide.effects.coulomb-friction]: another effect replaces it\n\n\
             [springs.guide.effects.asymmetric-friction]\nlevel = 12  # N\nasymmetry = 0.2\n"
        );
    }

    /// By default a mass has a tolerance of a tenth as a ratio: up to `5 exp(0.1) = 5.526`.
    #[test]
    fn truth_a_value_that_calibration_stopped_at_says_so() {
        let parse = |text: &str| Document::parse(text, "machine.toml").unwrap().scenario.machine;
        let old = parse(BELIEVED);
        let said = |mass: &str, tolerance: &IndexMap<String, f64>| {
            Difference::between(&old, &parse(&BELIEVED.replace("5.0", mass)))
                .with_ends(&old, tolerance)
                .to_string()
        };
        let none = IndexMap::new();
        assert_eq!(
            said("5.52585", &none),
            "bodies.tip.mass = 5.5259  # was 5 kg, +10.5 % (at the end of its tolerance)\n"
        );
        assert_eq!(said("5.4", &none), "bodies.tip.mass = 5.4  # was 5 kg, +8.0 %\n");
        let stated: IndexMap<String, f64> = [("bodies.tip.mass".to_owned(), 0.2)].into_iter().collect();
        assert!(!said("5.52585", &stated).contains("tolerance"));
    }
}
