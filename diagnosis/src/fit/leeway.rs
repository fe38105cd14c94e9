//! Unknowns of a model beyond the values of its machine: presliding of guides, and the instants at which
//! commands act.

use std::f64::consts::TAU;

use feeler_plant::assembly::assemble;
use feeler_plant::description::{ElementKind, Site};
use feeler_plant::effects::{Definition, EffectUse, Kind, Parameter, Trait};
use feeler_plant::units::Dimension;

use crate::fit::least_squares::Fitted;
use crate::fit::model::{DIFFERENCE, Model};
use crate::fit::unknown::{SIGMAS, Target, Unknown};
use crate::inverse::Reversal;
use crate::predict::{Leeway, MOST_LATE_ROWS, Presliding};

/// Step of finite differences for the timing of commands, rows.
const TIMING_DIFFERENCE: f64 = 1e-2;

/// Shift of the trial presliding frequency of sticking guides, as a logarithm.
const STIFFER: f64 = 1.4;

/// Stiffness of presliding over that of Dahl's bristles; see the effect `presliding`.
const DAHL: f64 = 0.7;

/// Prior standard deviations of presliding frequency and damping ratio, as logarithms.
const PRESLIDING_SPREAD: [f64; 2] = [1.2, 1.0];

/// Deviations below the usual value to which presliding frequency and damping ratio are searched. A slow
/// axis with much friction yields over a thousandth of its stroke: at 2 Hz or so.
const PRESLIDING_BELOW: [f64; 2] = [3.0, 2.0];
/// Deviations above the usual value to which both are searched.
const PRESLIDING_ABOVE: f64 = 2.0;

impl Model {
    /// Adds the unknown instant at which commands act, for commands without a stated hold. It is within half
    /// a row of the row; half a row later corresponds to a held command.
    pub(crate) fn with_free_timing(mut self) -> Self {
        self.unknowns.push(Unknown {
            target: Target::CommandTiming,
            log: false,
            unit: 1.0,
            prior: Some((0.0, MOST_LATE_ROWS / SIGMAS)),
            bounds: (-MOST_LATE_ROWS, MOST_LATE_ROWS),
            difference: TIMING_DIFFERENCE,
        });
        self
    }

    /// Whether any element has dry friction and no stated presliding.
    pub(crate) fn has_free_presliding(&self) -> bool {
        let is_dry = |effect: &EffectUse| effect.definition.has(Trait::DryFriction);
        let machine = &self.believed;
        machine.sites().any(|site| {
            let effects = machine.element(site).map_or(&[][..], |(_, element)| element.effects());
            let tried = self.tried.iter().filter(|tried| tried.site == site).map(|tried| &tried.effect);
            !effects.iter().any(|effect| effect.definition.kind == Kind::Presliding)
                && effects.iter().chain(tried).any(is_dry)
        })
    }

    /// Adds the presliding of sticking guides to the unknowns.
    pub(super) fn free_presliding(&mut self) {
        let usual = Presliding::default();
        for (target, value, sigma, below) in [
            (Target::PreslidingFrequency, usual.frequency_hz, PRESLIDING_SPREAD[0], PRESLIDING_BELOW[0]),
            (Target::PreslidingDamping, usual.damping_ratio, PRESLIDING_SPREAD[1], PRESLIDING_BELOW[1]),
        ] {
            let centre = value.ln();
            let bounds = (centre - below * sigma, centre + PRESLIDING_ABOVE * sigma);
            let prior = Some((centre, sigma));
            self.unknowns.push(Unknown {
                target,
                log: true,
                unit: 1.0,
                prior,
                bounds,
                difference: DIFFERENCE,
            });
        }
    }

    /// Largest stiffness or damping of the bristles of a guide: that of the fastest presliding that is
    /// searched. Records do not tell stiffer bristles apart, but each prediction would take far longer.
    /// Infinite for other parameters.
    pub(super) fn most_of_bristles(&self, site: Site, definition: &Definition, parameter: &Parameter) -> f64 {
        let is_bound = [Dimension::STIFFNESS, Dimension::DAMPING].contains(&parameter.dimension);
        if !is_bound || !definition.has(Trait::Bristles) || site.table != ElementKind::Springs {
            return f64::INFINITY;
        }
        let Ok(assembly) = assemble(&self.believed) else { return f64::INFINITY };
        let Some(link) = assembly.links.get(site.index) else { return f64::INFINITY };
        let mass_kg = assembly.sliding_mass_kg(link);
        let most = |usual: f64, sigma: f64| usual * (PRESLIDING_ABOVE * sigma).exp();
        let usual = Presliding::default();
        let fastest = Presliding {
            frequency_hz: most(usual.frequency_hz, PRESLIDING_SPREAD[0]),
            damping_ratio: most(usual.damping_ratio, PRESLIDING_SPREAD[1]),
        }
        .of_mass(mass_kg);
        if parameter.dimension == Dimension::STIFFNESS { fastest.stiffness } else { fastest.damping(mass_kg) }
    }

    /// The start, and starts with sticking guides at lower and higher presliding frequency. Only the start if
    /// no guide sticks.
    pub(crate) fn stiffer(&self, start: &[f64]) -> Vec<Vec<f64>> {
        let Some(i) = self.unknowns.iter().position(|unknown| unknown.target == Target::PreslidingFrequency)
        else {
            return vec![start.to_vec()];
        };
        let at = |shift: f64| {
            let mut start = start.to_vec();
            start[i] = (start[i] + shift).clamp(self.unknowns[i].bounds.0, self.unknowns[i].bounds.1);
            start
        };
        [-STIFFER, 0.0, STIFFER].map(at).to_vec()
    }

    /// The start. If another fit has bristles, its presliding is not fitted: then [`Self::stiffer`] as well,
    /// and guides that preslide as these bristles bend.
    pub(crate) fn stiffer_after(&self, start: &[f64], other: &Fitted) -> Vec<Vec<f64>> {
        match self.as_bristles(start, other) {
            Some(as_bristles) => self.stiffer(start).into_iter().chain([as_bristles]).collect(),
            None => vec![start.to_vec()],
        }
    }

    fn as_bristles(&self, start: &[f64], other: &Fitted) -> Option<Vec<f64>> {
        let assembly = other.model.assembly(&other.theta, None)?;
        let (link, bristle) = assembly.links.iter().find_map(|link| Some((link, link.bristle?)))?;
        let mass_kg = assembly.sliding_mass_kg(link);
        Some(self.on_bristles(start, bristle.stiffness, bristle.damping, mass_kg))
    }

    /// The point at which friction reverses as in a balance of forces; `None` if presliding is not fitted.
    pub(crate) fn reversing(
        &self,
        theta: &[f64],
        Reversal { length_m, lead_s, .. }: Reversal,
    ) -> Option<Vec<f64>> {
        if !self.has_free_presliding() {
            return None;
        }
        let assembly = self.assembly(theta, None)?;
        let (_, link) = assembly.dry_guides().find(|(_, link)| link.presliding.is_none())?;
        let friction = &link.friction;
        let level = 0.5 * (friction.forward + friction.backward) + friction.stribeck_excess;
        let stiffness = level / length_m;
        let is_there = stiffness > 0.0 && stiffness.is_finite();
        is_there
            .then(|| self.on_bristles(theta, stiffness, lead_s * stiffness, assembly.sliding_mass_kg(link)))
    }

    /// The point at which guides preslide like bristles of this stiffness and damping.
    fn on_bristles(&self, start: &[f64], stiffness: f64, damping: f64, mass_kg: f64) -> Vec<f64> {
        let omega = (DAHL * stiffness / mass_kg).sqrt();
        let mut start = start.to_vec();
        for (unknown, start) in self.unknowns.iter().zip(&mut start) {
            let value = match unknown.target {
                Target::PreslidingFrequency => omega / TAU,
                Target::PreslidingDamping => damping / (2.0 * mass_kg * omega),
                _ => continue,
            };
            *start = unknown.theta(value).clamp(unknown.bounds.0, unknown.bounds.1);
        }
        start
    }

    /// Whether commands act at the earliest or latest permitted instant.
    pub(crate) fn is_timing_at_limit(&self, theta: &[f64]) -> bool {
        let is_it = |(unknown, theta): (&Unknown, &f64)| {
            unknown.target == Target::CommandTiming && unknown.is_at_limit(*theta)
        };
        self.unknowns.iter().zip(theta).any(is_it)
    }

    /// Whether commands act at the latest permitted instant. A command cannot act before it is given, so only
    /// this limit may need a cause.
    pub(crate) fn is_timing_at_late_limit(&self, theta: &[f64]) -> bool {
        self.is_timing_at_limit(theta) && self.leeway(theta).late_rows > 0.0
    }

    /// Whether guides yield at the lowest frequency that is searched.
    pub(crate) fn is_presliding_softest(&self, theta: &[f64]) -> bool {
        let is_it = |(unknown, theta): (&Unknown, &f64)| {
            unknown.target == Target::PreslidingFrequency
                && unknown.is_at_end(*theta)
                && unknown.prior.is_some_and(|(centre, _)| *theta < centre)
        };
        self.unknowns.iter().zip(theta).any(is_it)
    }

    /// Values of the unknowns beyond the machine, at `theta`.
    pub(crate) fn leeway(&self, theta: &[f64]) -> Leeway {
        let mut found = Leeway::default();
        for (unknown, &theta) in self.unknowns.iter().zip(theta) {
            match unknown.target {
                Target::PreslidingFrequency => found.presliding.frequency_hz = unknown.value(theta),
                Target::PreslidingDamping => found.presliding.damping_ratio = unknown.value(theta),
                Target::CommandTiming => found.late_rows = unknown.value(theta),
                _ => {}
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use feeler_files::Document;
    use feeler_plant::effects::find;
    use indexmap::IndexMap;

    use super::*;

    const MACHINE: &str = "[bodies.axis]\nmass = 2.0\n[springs.guide]\nbetween = [\"ground\", \"axis\"]\n\
        [actuators.drive]\non = \"axis\"\nkind = \"force\"\n";

    /// The guide of [`MACHINE`] with one effect.
    fn with(kind: &str, values: &[f64]) -> Model {
        of(MACHINE, kind, values)
    }

    fn of(text: &str, kind: &str, values: &[f64]) -> Model {
        let machine = Document::parse(text, "axis.toml").unwrap().scenario.machine;
        let calibrated = Model::calibration(&machine, &IndexMap::new()).unwrap();
        let site = Site { table: ElementKind::Springs, index: 0 };
        calibrated.with(site, find(kind).unwrap(), values)
    }

    /// 2 kg on bristles of 2 kg (2 pi 25 Hz)^2, with a damping ratio of 0.3. Presliding has 0.7 times their
    /// stiffness.
    #[test]
    fn truth_a_dry_guide_takes_over_the_frequency_and_the_damping_of_bristles() {
        let omega = TAU * 25.0;
        let bristles = with("lugre-friction", &[2.0 * omega * omega, 4.0 * 0.3 * omega, 5.0, 5.0, 0.01]);
        let theta = bristles.start();
        let outer = Fitted { sigma: vec![0.0; theta.len()], model: bristles, theta, cost: 0.0 };
        let dry = with("coulomb-friction", &[5.0]);
        let starts = dry.stiffer_after(&dry.start(), &outer);
        assert_eq!(starts.len(), 4);
        let Presliding { frequency_hz, damping_ratio } = dry.leeway(&starts[3]).presliding;
        // Rounding of logarithms.
        let softer = 0.7_f64.sqrt();
        assert!((frequency_hz - 25.0 * softer).abs() < 1e-9 && (damping_ratio - 0.3 / softer).abs() < 1e-12);
        // Without bristles, the other fit has fitted presliding.
        let theta = dry.start();
        let other = Fitted { sigma: vec![0.0; theta.len()], model: dry.clone(), theta, cost: 0.0 };
        assert_eq!(dry.stiffer_after(&dry.start(), &other), [dry.start()]);
    }

    /// Dahl's bristles of 5 kN/m and 50 N s/m under 5 N: presliding has 0.7 times their stiffness.
    #[test]
    fn truth_guides_give_way_as_a_balance_found() {
        let dry = with("coulomb-friction", &[5.0]);
        let reversal = Reversal { length_m: 1e-3, lead_s: 1e-2, sharpness: 0 };
        let found = dry.leeway(&dry.reversing(&dry.start(), reversal).unwrap()).presliding;
        let omega = (0.7 * 5e3 / 2.0_f64).sqrt();
        // Rounding of logarithms.
        assert!((found.frequency_hz - omega / TAU).abs() < 1e-9);
        assert!((found.damping_ratio - 50.0 / (4.0 * omega)).abs() < 1e-12);
        let smooth = with("viscous-friction", &[5.0]);
        assert!(smooth.reversing(&smooth.start(), reversal).is_none());
    }

    #[test]
    fn truth_bristles_end_at_the_fastest_presliding() {
        let stiff = with("lugre-friction", &[1e12, 1e9, 5.0, 5.0, 0.01]);
        let dry = with("coulomb-friction", &[5.0]);
        let fastest = dry.unknowns.iter().find(|unknown| unknown.target == Target::PreslidingFrequency);
        let fastest = fastest.map(|unknown| unknown.value(unknown.bounds.1)).unwrap();
        let stiffness = stiff.parameters(0, &stiff.start())[0];
        assert!((stiffness / (2.0 * (TAU * fastest).powi(2)) - 1.0).abs() < 1e-9, "{stiffness}");
    }

    /// Commands in mN m that are read as N m make friction of a rotor of 0.1 g cm^2 far too large.
    #[test]
    fn regress_bristles_that_are_too_stiff_for_a_tiny_mass_have_a_start() {
        let tiny = MACHINE.replace("mass = 2.0", "mass = 1e-8");
        let bristles = of(&tiny, "lugre-friction", &[1e12, 1e9, 5.0, 5.0, 0.01]);
        assert!(bristles.start().iter().all(|theta| theta.is_finite()));
        assert!(bristles.unknowns.iter().all(|unknown| unknown.bounds.0 <= unknown.bounds.1));
    }
}
