//! Effects on an element, from the library.

use std::cmp::Ordering;

use feeler_catalogue::{Bound, Dimension};
use feeler_plant::effects::{ABOVE_ZERO, EffectUse, HostKind, LIBRARY, Parameter, find};
use feeler_plant::names::{did_you_mean, nearest};

use super::{Builder, Item};
use crate::keys::EFFECTS;
use crate::read::{Reader, join};
use crate::tree::{Entry, Node, Table, Value};

impl Builder<'_> {
    /// The effects of an element with the library's kind `host`.
    pub(super) fn effects(&mut self, item: Item<'_>, host: HostKind) -> Vec<EffectUse> {
        self.effects_on(item, host, Dimension::FORCE)
    }

    /// The effects of an element; `command` is the dimension of an actuator's command.
    pub(super) fn effects_on(
        &mut self,
        item: Item<'_>,
        host: HostKind,
        command: Dimension,
    ) -> Vec<EffectUse> {
        let Some(entry) = item.table.get(EFFECTS) else { return Vec::new() };
        let path = item.key(EFFECTS);
        let effects = self.problems.table(&entry.node, &path, format!("write [{path}.KIND]"));
        effects
            .into_iter()
            .flatten()
            .filter_map(|(kind, entry)| self.effect(kind, entry, (host, command), &join(&path, kind)))
            .collect()
    }

    /// One effect on an element with the library's kind `host`; `command` is the dimension of an actuator's
    /// command.
    pub(crate) fn effect(
        &mut self,
        kind: &str,
        entry: &Entry,
        (host, command): (HostKind, Dimension),
        path: &str,
    ) -> Option<EffectUse> {
        let Some(definition) = find(kind) else {
            // Suggestions start with effects of this kind of element; others follow only if none of these is
            // similar.
            let fitting = LIBRARY
                .iter()
                .filter(|definition| definition.hosts.contains(&host))
                .map(|definition| definition.name);
            let near = nearest(kind, fitting);
            let remedy = near.map_or_else(
                || did_you_mean(kind, LIBRARY.iter().map(|d| d.name)),
                |near| format!("did you mean `{near}`?"),
            );
            self.problems.add(&entry.key, path, format!("there is no effect `{kind}`"), remedy);
            return None;
        };
        if !definition.hosts.contains(&host) {
            let message = format!("`{kind}` does not disturb {}", host.phrase());
            let remedy = format!("it goes under {}", definition.sits_under());
            self.problems.add(&entry.key, path, message, remedy);
            return None;
        }
        let table = self.problems.table(&entry.node, path, format!("write [{path}]"))?;
        let names = || definition.parameters.iter().map(|parameter| parameter.name);
        for (name, entry) in table.iter().filter(|(name, _)| !names().any(|known| known == name.as_str())) {
            let message = format!("`{kind}` has no parameter `{name}`");
            self.problems.add(&entry.key, join(path, name), message, did_you_mean(name, names()));
        }
        let mut values: Vec<Option<f64>> = Vec::new();
        for parameter in definition.parameters {
            let mut parameter = *parameter;
            parameter.dimension = definition.dimension_of(&parameter, command);
            // In a law `k d^n` the exponent is the first parameter.
            if let (true, Some(Some(exponent))) = (parameter.dimension.any_length, values.first()) {
                parameter.dimension = Dimension::power_stiffness(*exponent);
            }
            values.push(self.parameter(&parameter, table, &entry.node, path));
        }
        let values = values.into_iter().collect::<Option<Vec<f64>>>()?;
        Some(EffectUse { definition, values })
    }

    fn parameter(&mut self, parameter: &Parameter, table: &Table, effect: &Node, path: &str) -> Option<f64> {
        let path = join(path, parameter.name);
        let Some(entry) = table.get(parameter.name) else {
            if parameter.default.is_none() {
                let unit = parameter.dimension.si_unit(self.rotational());
                let remedy = format!(
                    "add `{} = {}`{}{unit}: {}",
                    parameter.name,
                    parameter.typical,
                    if unit.is_empty() { "" } else { " in " },
                    parameter.text
                );
                self.problems.add(&effect.origin, path, format!("`{}` is missing", parameter.name), remedy);
            }
            return parameter.default;
        };
        // An effect that vanishes at infinity, such as a limit, accepts this value.
        if let (Value::Float(value), Some(null)) = (&entry.node.value, parameter.null)
            && value.is_infinite()
            && value.total_cmp(&null).is_eq()
        {
            return Some(null);
        }
        let scope = self.scope();
        Reader { problems: self.problems, scope }.quantity_of(
            &entry.node,
            parameter.dimension,
            bound_of(parameter),
            &path,
        )
    }
}

/// The bounds of a parameter; open ones become the next floats.
pub(crate) fn bound_of(parameter: &Parameter) -> Bound {
    let (least, most) = parameter.bounds;
    match (least.total_cmp(&0.0), least.total_cmp(&ABOVE_ZERO).is_eq(), most.is_finite()) {
        (_, true, true) => Bound::Above(0.0, most),
        (_, true, false) => Bound::Positive,
        (Ordering::Equal, _, false) => Bound::NotNegative,
        (_, _, true) => Bound::Within(least, most),
        (_, _, false) if least.is_finite() => Bound::AtLeast(least),
        _ => Bound::Any,
    }
}
