//! Single values: quantities with their units, counts, words, signals, lists.

use std::borrow::Cow;

use feeler_catalogue::{Bound, Dimension, Unit, Word, compact};
use feeler_plant::description::SignalName;
use feeler_plant::names::{did_you_mean, list};
use feeler_problem::Remedy;

use super::Reader;
use crate::tree::{Node, Value};
use crate::units::{self, UnitError};

/// Largest accepted value, SI.
const LARGEST: f64 = 1e15;

/// Largest number of entries of a list in a file.
const MOST_ENTRIES: usize = 1_000_000;

impl Reader<'_> {
    pub(super) fn mistyped<T>(&mut self, node: &Node, expected: &str, path: &str) -> Option<T> {
        self.problems.mistyped(node, path, expected, format!("write {expected}"));
        None
    }

    pub(super) fn quantity(&mut self, node: &Node, unit: Unit, bound: Bound, path: &str) -> Option<f64> {
        let dim = self.scope.dim(unit);
        if unit == Unit::Swept
            && let Value::Text(text) = &node.value
        {
            return match units::parse_any(text) {
                Ok(value) => self.bounded(node, value, dim, bound, path),
                Err(error) => self.wrong_unit(node, error, dim, path),
            };
        }
        self.quantity_of(node, dim, bound, path)
    }

    /// A unit of the scope's signal: its factor to SI.
    pub(crate) fn unit(&mut self, node: &Node, path: &str) -> Option<f64> {
        let dim = self.scope.dim(Unit::Signal);
        match units::parse(&format!("1 {}", node.as_text()?), dim, self.scope.rotational) {
            Ok(value) => Some(value),
            Err(error) => {
                let rotational = self.scope.rotational;
                let wrong = WrongQuantity { error, dim, rotational, is_unit: true };
                self.problems.add_error(&node.origin, path, &wrong);
                None
            }
        }
    }

    /// A quantity of a given dimension.
    pub(crate) fn quantity_of(
        &mut self,
        node: &Node,
        dim: Dimension,
        bound: Bound,
        path: &str,
    ) -> Option<f64> {
        let value = match &node.value {
            Value::Float(value) => *value,
            Value::Integer(value) => *value as f64,
            Value::Text(text) => match units::parse(text, dim, self.scope.rotational) {
                Ok(value) => value,
                Err(error) => return self.wrong_unit(node, error, dim, path),
            },
            _ => {
                let unit = dim.si_unit(self.scope.rotational);
                let expected = if unit.is_empty() {
                    "a number".into()
                } else {
                    format!("a number in {unit}, or a text with a unit")
                };
                return self.mistyped(node, &expected, path);
            }
        };
        self.bounded(node, value, dim, bound, path)
    }

    fn bounded(&mut self, node: &Node, value: f64, dim: Dimension, bound: Bound, path: &str) -> Option<f64> {
        let unit = dim.si_unit(self.scope.rotational);
        let shown = if unit.is_empty() { compact(value) } else { format!("{} {unit}", compact(value)) };
        if !bound.admits(value) {
            let remedy = remedy(bound, value);
            self.problems.add(&node.origin, path, format!("{shown} is out of range"), remedy);
            return None;
        }
        if value.abs() > LARGEST {
            let remedy = format!("write at most {LARGEST:e}, and check the unit");
            self.problems.add(&node.origin, path, format!("{shown} is too large"), remedy);
            return None;
        }
        Some(value)
    }

    fn wrong_unit(&mut self, node: &Node, error: UnitError, dim: Dimension, path: &str) -> Option<f64> {
        let wrong = WrongQuantity { error, dim, rotational: self.scope.rotational, is_unit: false };
        self.problems.add_error(&node.origin, path, &wrong);
        None
    }

    pub(super) fn count(&mut self, node: &Node, least: u64, most: u64, path: &str) -> Option<u64> {
        let Value::Integer(value) = node.value else { return self.mistyped(node, "a whole number", path) };
        match u64::try_from(value) {
            Ok(count) if (least..=most).contains(&count) => Some(count),
            _ => {
                self.problems.add(
                    &node.origin,
                    path,
                    format!("{value} is out of range"),
                    format!("this must lie from {least} to {most}"),
                );
                None
            }
        }
    }

    pub(super) fn word(&mut self, node: &Node, words: &'static [Word], path: &str) -> Option<&'static str> {
        let names = || words.iter().map(|word| word.name);
        let Value::Text(text) = &node.value else {
            return self.mistyped(node, &format!("one of {}", list(names())), path);
        };
        let found = names().find(|name| name == text);
        if found.is_none() {
            self.problems.add(
                &node.origin,
                path,
                format!("`{text}` is none of {}", list(names())),
                did_you_mean(text, names()),
            );
        }
        found
    }

    pub(super) fn signal(&mut self, node: &Node, path: &str) -> Option<SignalName> {
        let Value::Text(text) = &node.value else {
            return self.mistyped(node, "a signal, as in \"motor.position\"", path);
        };
        let found = text.parse::<SignalName>();
        found.map_err(|error| self.problems.add_error(&node.origin, path, &error)).ok()
    }

    pub(super) fn list<'n>(&mut self, node: &'n Node, expected: &str, path: &str) -> Option<&'n [Node]> {
        let Value::Array(items) = &node.value else { return self.mistyped(node, expected, path) };
        if items.len() > MOST_ENTRIES {
            let message = format!("{} entries are more than the {MOST_ENTRIES} that are taken", items.len());
            self.problems.add(&node.origin, path, message, "put them into a CSV file");
            return None;
        }
        Some(items)
    }

    pub(super) fn range(&mut self, node: &Node, unit: Unit, path: &str) -> Option<[f64; 2]> {
        let items = self.list(node, "a list of two numbers", path)?;
        let [low, high] = items else { return self.mistyped(node, "a list of two numbers", path) };
        let ends = (self.quantity(low, unit, Bound::Any, path), self.quantity(high, unit, Bound::Any, path));
        let (Some(low), Some(high)) = ends else { return None };
        // A sweep may be descending. A band may not, and it has no negative frequencies.
        if unit != Unit::Swept && (low >= high || low < 0.0) {
            let remedy = "write the lower frequency first, at or above zero";
            self.problems.add(&node.origin, path, format!("a band from {low} to {high} is empty"), remedy);
            return None;
        }
        Some([low, high])
    }

    pub(super) fn numbers(&mut self, node: &Node, unit: Unit, count: usize, path: &str) -> Option<Vec<f64>> {
        let form = if count > 0 { format!("a list of {count} numbers") } else { "a list of numbers".into() };
        let items = self.list(node, &form, path)?;
        if count > 0 && items.len() != count {
            self.problems.add(
                &node.origin,
                path,
                format!("there are {} numbers here", items.len()),
                format!("write {form}"),
            );
            return None;
        }
        let read: Vec<Option<f64>> =
            items.iter().map(|item| self.quantity(item, unit, Bound::Any, path)).collect();
        read.into_iter().collect()
    }

    pub(super) fn points(&mut self, node: &Node, unit: Unit, path: &str) -> Option<Vec<(f64, f64)>> {
        let form = "a list of [time, value] pairs, as in [[0.0, 20.0], [1.2, 30.0]]";
        let items = self.list(node, form, path)?;
        if items.is_empty() {
            self.problems.add(&node.origin, path, "there are no points", "give at least one: [[0.0, ...]]");
            return None;
        }
        let mut points = Vec::with_capacity(items.len());
        let mut complete = true;
        for item in items {
            let Value::Array(pair) = &item.value else { return self.mistyped(item, form, path) };
            let [time, value] = pair.as_slice() else { return self.mistyped(item, form, path) };
            let time_s = self.quantity(time, Unit::Of(Dimension::TIME), Bound::Any, path);
            let value = self.quantity(value, unit, Bound::Any, path);
            let (Some(time_s), Some(value)) = (time_s, value) else {
                complete = false;
                continue;
            };
            if let Some((before, _)) = points.last()
                && time_s <= *before
            {
                self.problems.add(
                    &time.origin,
                    path,
                    format!("the time {time_s} s is not after {before} s"),
                    "times must increase",
                );
                complete = false;
            }
            points.push((time_s, value));
        }
        complete.then_some(points)
    }
}

/// Advice for a number out of bounds. A wrong sign is mentioned before limits of size, because these may be
/// far from the values of any machine.
fn remedy(bound: Bound, value: f64) -> String {
    const TINY: f64 = 1e-6;
    if !value.is_finite() {
        return "write a finite number".into();
    }
    let bound = match bound {
        Bound::Within(least, _) if value <= 0.0 && 0.0 < least && least < TINY => Bound::Positive,
        Bound::Above(least, _) if value <= 0.0 && (0.0..TINY).contains(&least) => Bound::Positive,
        Bound::Within(least, _) if value < 0.0 && (0.0..TINY).contains(&least) => Bound::NotNegative,
        bound => bound,
    };
    format!("this {}", bound.words())
}

/// A text that is not a quantity with the key's dimension.
#[derive(Debug, thiserror::Error)]
#[error("{error}, and this must be {}", dim.phrase(*rotational))]
struct WrongQuantity {
    error: UnitError,
    dim: Dimension,
    rotational: bool,
    /// Whether a unit alone is asked for, without a number.
    is_unit: bool,
}

impl Remedy for WrongQuantity {
    fn remedy(&self) -> Cow<'_, str> {
        let unit = self.dim.si_unit(self.rotational);
        match &self.error {
            UnitError::DecimalComma { meant, .. } => format!("write a decimal point: \"{meant}\"").into(),
            UnitError::UnknownUnit { nearest: Some(nearest), .. } => {
                format!("did you mean `{nearest}`?").into()
            }
            _ if self.is_unit && unit.is_empty() => "remove it: these numbers have no unit".into(),
            _ if self.is_unit => {
                format!("write {} without a number, such as \"{unit}\"", self.dim.phrase(self.rotational))
                    .into()
            }
            UnitError::NoUnit { text } => {
                format!("write {text} without quotes for SI, or \"{} {unit}\"", text.trim()).into()
            }
            _ if unit.is_empty() => "write a number".into(),
            _ => format!("write a number in {unit}, or a text such as \"1 {unit}\"").into(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_every_error_says_what_to_do() {
        let dim = Dimension::LENGTH;
        let of = |text: &str| WrongQuantity {
            error: units::parse(text, dim, false).unwrap_err(),
            dim,
            rotational: false,
            is_unit: false,
        };
        let all = ["wide", "5", "1,5 mm", "5 mn", "5 m/(s", "5 kg"].map(of);
        let unit = WrongQuantity { is_unit: true, ..of("1 millimetres") };
        assert_eq!(unit.remedy(), "write a length (m) without a number, such as \"m\"");
        assert_eq!(
            feeler_problem::contract::violations(&all, include_str!("values.rs")),
            Vec::<String>::new()
        );
    }
}
