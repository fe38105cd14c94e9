//! A machine with unknowns: believed values, free within their tolerances, and trial effects.

use feeler_plant::assembly::{Assembly, assemble};
use feeler_plant::description::{Believed, Element, ElementKind, Engagement, Machine, Site};
use feeler_plant::effects::{Change, Definition, EffectUse, Kind, Parameter, Scale, Trait};
use feeler_plant::problem::Problem;
use feeler_plant::units::Dimension;
use indexmap::IndexMap;

use crate::error::DiagnosisError;
use crate::fit::unknown::{SIGMAS, Target, Unknown};
use crate::inverse::Part;
use crate::kinds::{dossier, overlaps};
use crate::tolerance;

/// Step of finite differences in `theta`.
pub(super) const DIFFERENCE: f64 = 1e-3;
/// Step of finite differences for a gap, m. It equals the step for the offset of a surface, which has the
/// same effect. The slopes then agree exactly, and only the priors separate the two.
const GAP_DIFFERENCE_M: f64 = 5e-7;

/// Calibration may reduce damping by this factor.
const LESS_DAMPING: f64 = 8.0;

/// A trial effect on an element.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tried {
    pub site: Site,
    /// The effect with its starting values.
    pub effect: EffectUse,
}

/// A machine with unknowns.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    pub(crate) believed: Machine,
    pub(crate) tried: Vec<Tried>,
    pub(crate) unknowns: Vec<Unknown>,
}

impl Model {
    /// The believed machine with its values free within their tolerances.
    pub(crate) fn calibration(
        machine: &Machine,
        stated: &IndexMap<String, f64>,
    ) -> Result<Self, DiagnosisError> {
        let assembly = assemble(machine).map_err(|problems| DiagnosisError::Machine { problems })?;
        let mut unknowns = Vec::new();
        let mut add = |site: Site, believed: &Believed| {
            let key = format!("{}.{}", site.key(machine), believed.key.name);
            let value = believed.value;
            if value == 0.0 {
                return;
            }
            let stated = stated.get(&key).copied();
            let is_gap = believed.dimension() == Dimension::LENGTH;
            let (log, unit, sigma) = match believed.dimension() {
                Dimension::DAMPING => (true, 1.0, stated.unwrap_or(tolerance::DAMPING).ln_1p()),
                _ if is_gap => (false, value.abs(), stated.unwrap_or(tolerance::GAP)),
                // An angle may be negative.
                _ if value < 0.0 => (false, value.abs(), stated.unwrap_or(tolerance::FRACTION)),
                _ => (true, 1.0, stated.unwrap_or(tolerance::FRACTION)),
            };
            let difference = if is_gap { GAP_DIFFERENCE_M / unit } else { DIFFERENCE };
            let bounds = (f64::NEG_INFINITY, f64::INFINITY);
            let target = Target::Value(site, believed.index);
            let mut unknown = Unknown { target, log, unit, prior: None, bounds, difference };
            let centre = unknown.theta(value);
            unknown.prior = Some((centre, sigma / SIGMAS));
            // A value beyond its tolerance must be found as an effect. Lower damping is the exception: no
            // effect reduces damping.
            let down =
                if believed.dimension() == Dimension::DAMPING { sigma.max(LESS_DAMPING.ln()) } else { sigma };
            unknown.bounds = (centre - down, centre + sigma);
            unknowns.push(unknown);
        };
        let takes_part = |site: &Site| match site.table {
            ElementKind::Bodies => assembly.rigid_mass_kg(site.index + 1).is_finite(),
            ElementKind::Springs => !machine.springs[site.index].rigid,
            ElementKind::Sensors => machine.sensors[site.index].reads.quantity.is_force(),
            ElementKind::Contacts | ElementKind::Actuators => true,
        };
        for site in machine.sites().filter(takes_part) {
            let believed = machine.element(site).map(|(_, element)| element.believed());
            believed.iter().flatten().for_each(|believed| add(site, believed));
        }
        for site in machine.sites() {
            let effects = machine.element(site).map_or(&[][..], |(_, element)| element.effects());
            for (e, effect) in effects.iter().enumerate() {
                let key = format!("{}.effects.{}", site.key(machine), effect.definition.kind);
                unknowns.extend(beliefs(site, e, effect, &key, stated));
            }
        }
        let mut model = Self { believed: machine.clone(), tried: Vec::new(), unknowns };
        if model.has_free_presliding() {
            model.free_presliding();
        }
        Ok(model)
    }

    /// The model with one more effect.
    pub(crate) fn with(&self, site: Site, definition: &'static Definition, values: &[f64]) -> Self {
        let mut model = self.clone();
        let index = model.tried.len();
        // An optional parameter is fitted only if its starting value differs from the default.
        let is_free = |(i, parameter): &(usize, &Parameter)| {
            parameter.default.is_none_or(|default| default.to_bits() != values[*i].to_bits())
        };
        for (i, parameter) in definition.parameters.iter().enumerate().filter(is_free) {
            let log = parameter.scale == Scale::Log;
            let unit = if parameter.typical == 0.0 { values[i].abs() } else { parameter.typical.abs() };
            let (target, bounds) = (Target::Effect(index, i), (0.0, 0.0));
            // Values of a small machine, or of one that turns, are far below typical ones.
            let size = if values[i] == 0.0 { unit } else { unit.min(values[i].abs()) };
            let is_scaled = !log && [Dimension::MASS, Dimension::FORCE].contains(&parameter.dimension);
            let difference = if is_scaled { DIFFERENCE * size / unit } else { DIFFERENCE };
            let mut unknown = Unknown { target, log, unit, prior: None, bounds, difference };
            let floor = if log { size * NEXT_TO_NOTHING } else { parameter.bounds.0 };
            let most = self.most_of_bristles(site, definition, parameter).min(parameter.bounds.1);
            let least = unknown.theta(parameter.bounds.0.max(floor));
            unknown.bounds = (least, unknown.theta(most).max(least));
            if let Some(spread) = dossier(definition.kind).read_off {
                let read = unknown.theta(values[i]);
                unknown.bounds = (read - spread, read + spread);
            }
            model.unknowns.push(unknown);
        }
        let had_it = model.has_free_presliding();
        model.tried.push(Tried { site, effect: EffectUse { definition, values: values.to_vec() } });
        if !had_it && model.has_free_presliding() {
            model.free_presliding();
        }
        model
    }

    /// The model without one of its effects, and the indices of the unknowns that remain.
    pub(crate) fn without(&self, effect: usize) -> (Self, Vec<usize>) {
        let mut model = self.clone();
        model.tried.remove(effect);
        let dry = model.has_free_presliding();
        let stays =
            |unknown: &Unknown| unknown.parameter_of(effect).is_none() && (dry || !unknown.is_presliding());
        let keep: Vec<usize> = (0..self.unknowns.len()).filter(|&i| stays(&self.unknowns[i])).collect();
        model.unknowns = keep.iter().map(|&i| self.unknowns[i].clone()).collect();
        for unknown in &mut model.unknowns {
            if let Target::Effect(e, _) = &mut unknown.target
                && *e > effect
            {
                *e -= 1;
            }
        }
        (model, keep)
    }

    /// The model with the parameters of its effects held at their starting values.
    pub(crate) fn held(mut self) -> Self {
        self.unknowns.retain(|unknown| !unknown.is_of_effect());
        self
    }

    /// Start of the fit: believed values, and the start values of trial effects.
    pub(crate) fn start(&self) -> Vec<f64> {
        self.unknowns
            .iter()
            .map(|unknown| match (unknown.target, unknown.prior) {
                (Target::Effect(e, p), _) => {
                    unknown.theta(self.tried[e].effect.values[p]).clamp(unknown.bounds.0, unknown.bounds.1)
                }
                (_, Some((centre, _))) => centre,
                (_, None) => 0.0,
            })
            .collect()
    }

    /// A point at which some parts of the believed machine are multiplied by these factors.
    pub(crate) fn scaled(&self, theta: &[f64], factors: &[(Part, f64)]) -> Vec<f64> {
        let part_of = |target: Target| match target {
            // A balance does not involve contacts.
            Target::Value(Site { table: ElementKind::Contacts, .. }, _) => None,
            Target::Value(site, index) => match self.believed_at(site, index)?.dimension() {
                Dimension::MASS => Some(Part::Mass),
                Dimension::DAMPING => Some(Part::Damping),
                Dimension::FORCE if site.table == ElementKind::Bodies => Some(Part::Gravity),
                _ => None,
            },
            Target::Belief(site, e, p) => {
                let definition = self.believed.element(site)?.1.effects().get(e)?.definition;
                (definition.parameters.get(p)?.dimension == Dimension::FORCE)
                    .then_some(Part::Effect(site, definition.kind))
            }
            _ => None,
        };
        let moved = |((unknown, start), theta): ((&Unknown, f64), &f64)| {
            let part = part_of(unknown.target);
            let factor = factors.iter().find(|(other, _)| Some(*other) == part);
            factor.map_or(*theta, |(_, factor)| {
                unknown.theta(factor * unknown.value(start)).clamp(unknown.bounds.0, unknown.bounds.1)
            })
        };
        self.unknowns.iter().zip(self.start()).zip(theta).map(moved).collect()
    }

    /// A point at which the parameters of trial effects have these values, where they are within bounds.
    pub(crate) fn with_values(&self, theta: &[f64], values: &[Vec<f64>]) -> Vec<f64> {
        let moved = |(unknown, theta): (&Unknown, &f64)| {
            let Target::Effect(e, p) = unknown.target else { return *theta };
            let value = values.get(e).and_then(|values| values.get(p)).map(|value| unknown.theta(*value));
            let (low, high) = unknown.bounds;
            value.filter(|value| (low..=high).contains(value)).unwrap_or(*theta)
        };
        self.unknowns.iter().zip(theta).map(moved).collect()
    }

    /// Whether a trial effect replaces a believed one: the kinds are equal, or one contains the other.
    fn replaces(&self, site: Site, kind: Kind) -> bool {
        self.tried.iter().any(|tried| tried.site == site && overlaps(tried.effect.definition.kind, kind))
    }

    /// Whether an unknown has no influence because another effect replaced its own.
    pub(crate) fn is_idle(&self, unknown: usize) -> bool {
        let Target::Belief(site, e, _) = self.unknowns[unknown].target else { return false };
        let effects = self.believed.element(site).map_or(&[][..], |(_, element)| element.effects());
        effects.get(e).is_some_and(|effect| self.replaces(site, effect.definition.kind))
    }

    /// The unknowns of a believed effect: number of the unknown and of its parameter.
    fn beliefs_of(&self, site: Site, kind: Kind) -> impl Iterator<Item = (usize, usize)> {
        let effects = self.believed.element(site).map_or(&[][..], |(_, element)| element.effects());
        let own = effects.iter().position(|effect| effect.definition.kind == kind);
        self.unknowns.iter().enumerate().filter_map(move |(i, unknown)| match unknown.target {
            Target::Belief(s, e, p) if s == site && Some(e) == own => Some((i, p)),
            _ => None,
        })
    }

    /// Whether an effect with these values matches a believed one within its tolerance.
    pub(crate) fn believes(&self, site: Site, kind: Kind, values: &[f64]) -> bool {
        let mut own = self.beliefs_of(site, kind).peekable();
        let is_within = |(i, p): (usize, usize)| {
            let Unknown { bounds: (low, high), .. } = self.unknowns[i];
            (low..=high).contains(&self.unknowns[i].theta(values[p]))
        };
        own.peek().is_some() && own.all(is_within)
    }

    /// Gives a believed effect these values, as far as its tolerance allows.
    pub(crate) fn believe(&self, theta: &mut [f64], site: Site, kind: Kind, values: &[f64]) {
        for (i, p) in self.beliefs_of(site, kind) {
            let unknown = &self.unknowns[i];
            theta[i] = unknown.theta(values[p]).clamp(unknown.bounds.0, unknown.bounds.1);
        }
    }

    /// Whether effect `effect` at `theta` matches a believed effect within its tolerance.
    pub(crate) fn is_believed(&self, effect: usize, theta: &[f64]) -> bool {
        let Tried { site, effect: tried } = &self.tried[effect];
        self.believes(*site, tried.definition.kind, &self.parameters(effect, theta))
    }

    /// Number of effect parameters among the unknowns: the measure of complexity.
    pub(crate) fn effect_parameters(&self) -> usize {
        self.unknowns.iter().filter(|unknown| unknown.is_of_effect()).count()
    }

    /// Copies the values of shared unknowns from `other` at `theta`, except for effects with index `effects`
    /// or higher.
    pub(crate) fn take_over(&self, start: &mut [f64], other: &Self, theta: &[f64], effects: usize) {
        for (unknown, start) in self.unknowns.iter().zip(start) {
            let shared = !matches!(unknown.target, Target::Effect(e, _) if e >= effects);
            if let Some(i) = other.unknowns.iter().position(|o| o.target == unknown.target).filter(|_| shared)
            {
                *start = theta[i];
            }
        }
    }

    /// Copies the values of another model's trial effects into the believed effects of the same kind that
    /// they replaced.
    pub(crate) fn take_back(&self, start: &mut [f64], other: &Self, theta: &[f64]) {
        for (i, tried) in other.tried.iter().enumerate() {
            self.believe(start, tried.site, tried.effect.definition.kind, &other.parameters(i, theta));
        }
    }

    /// A believed number of an element, by its index among the element's keys.
    pub(super) fn believed_at(&self, site: Site, index: usize) -> Option<Believed> {
        self.believed.element(site)?.1.believed().into_iter().find(|believed| believed.index == index)
    }

    /// The dotted key of a believed value; `None` for other unknowns.
    fn key_of(&self, target: Target) -> Option<String> {
        match target {
            Target::Value(site, index) => {
                let name = self.believed_at(site, index)?.key.name;
                Some(format!("{}.{name}", site.key(&self.believed)))
            }
            Target::Belief(site, e, p) => {
                let definition = self.believed.element(site)?.1.effects().get(e)?.definition;
                let name = definition.parameters.get(p)?.name;
                Some(format!("{}.effects.{}.{name}", site.key(&self.believed), definition.kind))
            }
            _ => None,
        }
    }

    /// Whether `value` lies at an end of the tolerance of a believed value, given by its dotted key.
    pub(crate) fn is_at_end(&self, key: &str, value: f64) -> bool {
        let is_of = |unknown: &&Unknown| self.key_of(unknown.target).as_deref() == Some(key);
        self.unknowns.iter().find(is_of).is_some_and(|unknown| unknown.is_at_end(unknown.theta(value)))
    }

    /// Believed values at the limits of their tolerances: element, key, believed and fitted value. A value is
    /// left out if a trial effect of the same dimension on the same element adds to it.
    pub(crate) fn at_limits(&self, theta: &[f64]) -> Vec<(Site, String, [f64; 2])> {
        let is_carried_on = |target: Target| {
            let Target::Value(site, index) = target else { return false };
            let dimension = self.believed_at(site, index).map(|believed| believed.dimension());
            self.tried.iter().any(|tried| {
                let first = tried.effect.definition.parameters.first();
                tried.site == site && first.map(|parameter| parameter.dimension) == dimension
            })
        };
        let rows = self.unknowns.iter().zip(theta).enumerate();
        rows.filter(|(i, (unknown, theta))| {
            unknown.is_at_limit(**theta) && !self.is_idle(*i) && !is_carried_on(unknown.target)
        })
        .filter_map(|(_, (unknown, theta))| {
            let (Target::Value(site, _) | Target::Belief(site, ..)) = unknown.target else { return None };
            let believed = unknown.value(unknown.prior?.0);
            Some((site, self.key_of(unknown.target)?, [believed, unknown.value(*theta)]))
        })
        .collect()
    }

    /// Excess of the fitted value of an element's key over the believed value, and whether it ends at the
    /// limit of its tolerance. `None` if the value is not fitted.
    pub(crate) fn excess(&self, site: Site, key: &str, theta: &[f64]) -> Option<(f64, bool)> {
        let key = format!("{}.{key}", site.key(&self.believed));
        let of = |unknown: &Unknown| self.key_of(unknown.target).as_deref() == Some(key.as_str());
        let (unknown, theta) = self.unknowns.iter().zip(theta).find(|(unknown, _)| of(unknown))?;
        let excess = unknown.value(*theta) - unknown.value(unknown.prior?.0);
        Some((excess, excess > 0.0 && unknown.is_at_limit(*theta)))
    }

    /// Number of the unknown that fits a parameter of an effect; `None` if the parameter is not fitted.
    pub(crate) fn unknown_of(&self, effect: usize, parameter: usize) -> Option<usize> {
        self.unknowns.iter().position(|unknown| unknown.parameter_of(effect) == Some(parameter))
    }

    pub(crate) fn parameters(&self, effect: usize, theta: &[f64]) -> Vec<f64> {
        let mut values = self.tried[effect].effect.values.clone();
        for (unknown, &theta) in self.unknowns.iter().zip(theta) {
            if let Some(parameter) = unknown.parameter_of(effect) {
                values[parameter] = unknown.value(theta);
            }
        }
        values
    }

    pub(crate) fn machine(&self, theta: &[f64]) -> Machine {
        let mut machine = self.believed.clone();
        for (unknown, &theta) in self.unknowns.iter().zip(theta) {
            let value = unknown.value(theta);
            match unknown.target {
                Target::Value(site, index) => {
                    if let Some(element) = machine.element_mut(site) {
                        element.believe(index, value);
                    }
                }
                Target::Belief(site, e, p) => {
                    let effects = machine.element_mut(site).map(Element::effects_mut);
                    if let Some(effect) = effects.and_then(|effects| effects.get_mut(e)) {
                        effect.values[p] = value;
                    }
                }
                _ => {}
            }
        }
        for tried in &self.tried {
            if let Some(element) = machine.element_mut(tried.site) {
                element.effects_mut().retain(|effect| !self.replaces(tried.site, effect.definition.kind));
            }
        }
        for (i, tried) in self.tried.iter().enumerate() {
            let effect = EffectUse { definition: tried.effect.definition, values: self.parameters(i, theta) };
            if let Some(element) = machine.element_mut(tried.site) {
                element.effects_mut().push(effect);
            }
        }
        machine
    }

    /// The assembly at `theta` with the engagement of an experiment; `None` if the values do not give a valid
    /// machine.
    ///
    /// A clamped tool is attached, so laws of separating surfaces (Hertz, Hunt and Crossley) do not apply.
    pub(crate) fn assembly(&self, theta: &[f64], engagement: Option<Engagement>) -> Option<Assembly> {
        assemble_for(self.machine(theta), engagement).ok()
    }
}

/// The parameters of a believed effect, free within their tolerances.
fn beliefs(
    site: Site,
    e: usize,
    effect: &EffectUse,
    key: &str,
    stated: &IndexMap<String, f64>,
) -> Vec<Unknown> {
    let definition = effect.definition;
    // The readings themselves show their step, so it is not fitted.
    let is_fitted =
        matches!(definition.change, Change::Plant(_)) && dossier(definition.kind).read_off.is_none();
    let parameters = definition.parameters.iter().zip(&effect.values).enumerate();
    let unknown = |(p, (parameter, &value)): (usize, (&Parameter, &f64))| {
        let log = parameter.scale == Scale::Log;
        let unit = if parameter.dimension == Dimension::NONE { parameter.typical.abs() } else { value.abs() };
        if !value.is_finite() || unit == 0.0 || (log && value <= 0.0) {
            return None;
        }
        let is_loose = definition.has(Trait::DryFriction) || parameter.dimension == Dimension::DAMPING;
        let usual = match definition.kind {
            Kind::Presliding => tolerance::PRESLIDING,
            _ if is_loose && log => tolerance::DAMPING,
            _ => tolerance::FRACTION,
        };
        let tolerance = stated.get(&format!("{key}.{}", parameter.name)).copied().unwrap_or(usual);
        let sigma = if log { tolerance.ln_1p() } else { tolerance };
        let target = Target::Belief(site, e, p);
        let unit = if log { 1.0 } else { unit };
        let mut unknown =
            Unknown { target, log, unit, prior: None, bounds: (0.0, 0.0), difference: DIFFERENCE };
        let centre = unknown.theta(value);
        let [low, high] = [parameter.bounds.0, parameter.bounds.1].map(|bound| unknown.theta(bound));
        unknown.prior = Some((centre, (sigma / SIGMAS).max(f64::MIN_POSITIVE)));
        unknown.bounds = ((centre - sigma).max(low).min(centre), (centre + sigma).min(high).max(centre));
        (tolerance > 0.0).then_some(unknown)
    };
    if is_fitted { parameters.filter_map(unknown).collect() } else { Vec::new() }
}

/// A machine with the engagement of an experiment.
pub(crate) fn assemble_for(
    mut machine: Machine,
    engagement: Option<Engagement>,
) -> Result<Assembly, Vec<Problem>> {
    if engagement == Some(Engagement::Clamped) {
        for contact in machine.contacts.values_mut() {
            contact.effects.retain(|effect| !effect.definition.has(Trait::SurfacesPart));
        }
    }
    assemble(&machine)
}

/// An effect below this share of its typical value, and of its starting value, counts as absent.
const NEXT_TO_NOTHING: f64 = 1e-5;
