//! The common scale of all forces.
//!
//! Motion alone does not determine the unit of mass. If no column is a force, or the gain of each force
//! column is unknown, a common factor on all masses, dampings, stiffnesses and frictions changes no measured
//! signal. Only the believed values limit this factor.
//!
//! Slopes by finite differences hide this. Each slope has an error near impacts and reversals. The sum of
//! these errors looks like information about the factor. It is therefore removed from the slopes, so that the
//! believed values alone determine the factor.

use feeler_plant::assembly::Source;
use feeler_plant::description::{ElementKind, Quantity, Site};
use feeler_plant::effects::{Definition, Trait};
use feeler_plant::units::Dimension;
use nalgebra::DVector;

use crate::dataset::Dataset;
use crate::fit::curvature::along;
use crate::fit::model::Model;
use crate::fit::unknown::{Target, Unknown};

/// Standard deviation of the logarithm of a believed value above which the value hardly limits the scale.
const LOOSE: f64 = 0.2;

/// Change of every unknown of a model if the unit of mass changes.
#[derive(Clone, Debug)]
pub(crate) struct SharedScale {
    /// Exponent of mass in the unit of each unknown; a gain has the exponent that keeps its column unchanged.
    exponents: Vec<f64>,
}

impl SharedScale {
    /// The scale of a model; `None` if a column carries a force without an unknown gain.
    pub(super) fn of(model: &Model, dataset: &Dataset) -> Option<Self> {
        let exponents: Vec<f64> = (model.unknowns.iter().enumerate())
            .map(|(i, unknown)| if model.is_idle(i) { 0.0 } else { exponent(model, unknown.target) })
            .collect();
        let is_scaled = |site: Site, mass: f64| {
            mass == 0.0
                || (model.unknowns.iter().zip(&exponents))
                    .any(|(unknown, exponent)| *exponent != 0.0 && is_gain_of(model, unknown, site))
        };
        let are_commands = dataset.drives.iter().all(|driven| {
            let site = Site { table: ElementKind::Actuators, index: driven.drive };
            is_scaled(site, dataset.machine.actuators[driven.drive].kind.command().mass)
        });
        let are_readings = dataset.channels.iter().all(|channel| {
            let mass = mass_of(channel.quantity(&dataset.machine));
            match channel.source {
                Source::Sensor(index) => is_scaled(Site { table: ElementKind::Sensors, index }, mass),
                _ => mass == 0.0,
            }
        });
        (are_commands && are_readings).then_some(Self { exponents })
    }

    /// The point with all forces multiplied by `exp(by)`.
    pub(crate) fn moved(&self, model: &Model, theta: &[f64], by: f64) -> Vec<f64> {
        let rows = model.unknowns.iter().zip(&self.exponents).zip(theta);
        rows.map(
            |((unknown, exponent), theta)| {
                if unknown.log { theta + exponent * by } else { theta * (exponent * by).exp() }
            },
        )
        .collect()
    }

    /// Derivative of every unknown with respect to the logarithm of the scale.
    pub(crate) fn direction(&self, model: &Model, theta: &[f64]) -> Vec<f64> {
        let rows = model.unknowns.iter().zip(&self.exponents).zip(theta);
        rows.map(|((unknown, exponent), theta)| if unknown.log { *exponent } else { exponent * theta })
            .collect()
    }

    /// The logarithm of the scale that the believed values prefer, within all bounds, and its standard
    /// deviation. `None` if no believed value depends on the scale.
    pub(super) fn believed(&self, model: &Model, theta: &[f64]) -> Option<(f64, f64)> {
        let (mut precision, mut pull) = (0.0_f64, 0.0_f64);
        let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
        let direction = self.direction(model, theta);
        let rows = model.unknowns.iter().zip(&self.exponents).zip(theta.iter().zip(&direction));
        for ((unknown, exponent), (theta, direction)) in rows.filter(|(_, (_, d))| **d != 0.0) {
            if let Some((mean, sigma)) = unknown.prior {
                precision += (direction / sigma).powi(2);
                pull += direction * (mean - theta) / sigma.powi(2);
            }
            let reach = |end: f64| {
                if unknown.log { (end - theta) / exponent } else { (end / theta).max(0.0).ln() / exponent }
            };
            let [a, b] = [unknown.bounds.0, unknown.bounds.1].map(reach);
            (least, most) = (least.max(a.min(b)), most.min(a.max(b)));
        }
        // Rounding may put a value at its bound slightly outside.
        let by = (pull / precision).clamp(least.min(0.0), most.max(0.0));
        (precision > 0.0 && by.is_finite()).then(|| (by, precision.sqrt().recip()))
    }

    /// Whether masses alone limit the scale closely. A gain then has the same effect as larger masses,
    /// dampings and frictions.
    pub(crate) fn is_of_masses(&self, model: &Model) -> bool {
        let is_close = |unknown: &Unknown| unknown.prior.is_some_and(|(_, sigma)| sigma < LOOSE);
        let is_mass = |unknown: &Unknown| {
            matches!(unknown.target, Target::Value(Site { table: ElementKind::Bodies, .. }, _))
        };
        let scaled = model.unknowns.iter().zip(&self.exponents).filter(|(_, exponent)| **exponent != 0.0);
        scaled.map(|(unknown, _)| unknown).filter(|unknown| is_close(unknown)).all(is_mass)
    }

    /// The point with the scale that the believed values prefer.
    pub(crate) fn settled(&self, model: &Model, theta: &[f64]) -> Vec<f64> {
        self.believed(model, theta).map_or_else(|| theta.to_vec(), |(by, _)| self.moved(model, theta, by))
    }
}

/// Removes the component along `direction` from the slopes of the unknowns, row by row.
pub(crate) fn without(direction: &[f64], slopes: &mut [Vec<f64>]) {
    let square: f64 = direction.iter().map(|d| d * d).sum();
    let rows = slopes.first().map_or(0, Vec::len);
    if square == 0.0 || rows == 0 {
        return;
    }
    let step = along(slopes, &DVector::from_column_slice(direction), rows);
    for (slope, d) in slopes.iter_mut().zip(direction).filter(|(_, d)| **d != 0.0) {
        slope.iter_mut().zip(&step).for_each(|(slope, step)| *slope -= step * d / square);
    }
}

/// Exponent of mass in the unit of a measured quantity; one if the unit is unknown.
fn mass_of(quantity: Quantity) -> f64 {
    quantity.dimension().map_or(1.0, |dimension| dimension.mass)
}

/// Whether an unknown is the gain between an element and its column.
fn is_gain_of(model: &Model, unknown: &Unknown, site: Site) -> bool {
    match unknown.target {
        Target::Value(own, _) => own == site && own.table == ElementKind::Sensors,
        Target::Belief(own, e, _) => {
            own == site && believed_effect(model, own, e).is_some_and(|own| own.has(Trait::Gain))
        }
        Target::Effect(e, _) => {
            model.tried[e].site == site && model.tried[e].effect.definition.has(Trait::Gain)
        }
        _ => false,
    }
}

fn believed_effect(model: &Model, site: Site, effect: usize) -> Option<&'static Definition> {
    Some(model.believed.element(site)?.1.effects().get(effect)?.definition)
}

/// Exponent of mass in the unit of an unknown's quantity.
fn exponent(model: &Model, target: Target) -> f64 {
    match target {
        Target::Value(site, _) if site.table == ElementKind::Sensors => -read(model, site),
        Target::Value(site, index) => {
            model.believed_at(site, index).map_or(0.0, |believed| believed.dimension().mass)
        }
        Target::Belief(site, e, p) => {
            believed_effect(model, site, e).map_or(0.0, |definition| of_parameter(model, site, definition, p))
        }
        Target::Effect(e, p) => {
            let tried = &model.tried[e];
            of_parameter(model, tried.site, tried.effect.definition, p)
        }
        Target::PreslidingFrequency | Target::PreslidingDamping | Target::CommandTiming => 0.0,
    }
}

/// Exponent of mass in the unit of a sensor.
fn read(model: &Model, site: Site) -> f64 {
    model.believed.sensors.get_index(site.index).map_or(0.0, |(_, sensor)| mass_of(sensor.reads.quantity))
}

/// Exponent of mass in the unit of a parameter of an effect.
fn of_parameter(model: &Model, site: Site, definition: &'static Definition, parameter: usize) -> f64 {
    let drive =
        model.believed.actuators.get_index(site.index).filter(|_| site.table == ElementKind::Actuators);
    let command = drive.map_or(Dimension::FORCE, |(_, actuator)| actuator.kind.command());
    match (site.table, definition.has(Trait::Gain)) {
        (ElementKind::Sensors, true) => -read(model, site),
        // A scaled loop gain of a servo scales its force.
        (_, true) => command.mass,
        // Parameters of sensors are in units of the reading, those of effects before the gain in units of the
        // command.
        (ElementKind::Sensors, false) => 0.0,
        _ if definition.has(Trait::BeforeGain) => 0.0,
        _ => definition
            .parameters
            .get(parameter)
            .map_or(0.0, |parameter| definition.dimension_of(parameter, command).mass),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sum of the first two slopes carries information to be removed; the third slope is independent.
    #[test]
    fn truth_no_step_along_the_scale_changes_a_prediction() {
        let mut slopes = vec![vec![1.0, -2.0, 0.5], vec![-0.9, 2.2, -0.5], vec![3.0, 1.0, 4.0]];
        let (third, direction) = (slopes[2].clone(), [1.0, 1.0, 0.0]);
        without(&direction, &mut slopes);
        for (first, second) in slopes[0].iter().zip(&slopes[1]) {
            // The rounding error of a few numbers of order one.
            assert!((first + second).abs() < 1e-14);
        }
        assert_eq!(slopes[2], third);
        // The sum of 0.1 in the first row is removed half from each of the two.
        assert!((slopes[0][0] - 0.95).abs() < 1e-14 && (slopes[1][0] + 0.95).abs() < 1e-14);
    }
}
