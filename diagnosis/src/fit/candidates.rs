//! Candidates: every effect of the library on every element of the believed machine to which it applies.

use feeler_plant::assembly::{Assembly, GROUND_NODE, assemble};
use feeler_plant::description::{ActuatorKind, Axis, Element, ElementKind, Machine, Quantity, Site};
use feeler_plant::effects::{
    Change, Definition, EffectError, EffectUse, HostKind, Kind, LIBRARY, Place, Trait,
};

use crate::kinds::{dossier, host_of, overlaps};

/// An effect that may be the cause.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub(crate) site: Site,
    pub(crate) definition: &'static Definition,
    pub(crate) place: Place,
}

impl Candidate {
    /// Whether both are the same effect on the same element.
    pub(crate) fn is(&self, other: &Self) -> bool {
        self.site == other.site && self.definition.kind == other.definition.kind
    }

    /// Kind and place in words.
    pub(crate) fn named(&self) -> String {
        format!("{} at the {}", self.definition.kind, self.place.name())
    }

    /// Whether one of some causes acts on the same element with a law that contains this one, or the reverse.
    pub(crate) fn is_covered_by(&self, causes: &[Self]) -> bool {
        let kind = self.definition.kind;
        causes.iter().any(|cause| cause.site == self.site && overlaps(cause.definition.kind, kind))
    }
}

pub(crate) fn candidates(machine: &Machine) -> Vec<Candidate> {
    let is_cause = |definition: &Definition| dossier(definition.kind).is_cause;
    acting(machine, is_cause)
}

/// One kind on every element to which it applies, even if it cannot be a cause.
pub(crate) fn of_kind(machine: &Machine, kind: Kind) -> Vec<Candidate> {
    acting(machine, |definition| definition.kind == kind)
}

fn acting(machine: &Machine, is_asked: impl Fn(&Definition) -> bool) -> Vec<Candidate> {
    let Ok(assembly) = assemble(machine) else { return Vec::new() };
    let mut found = Vec::new();
    let is_loaded =
        !machine.contacts.is_empty() || assembly.weights.iter().any(|weight| weight.course.pull().is_some());
    let can_act = |definition: &&Definition| {
        is_asked(definition)
            && matches!(definition.change, Change::Plant(_))
            && (is_loaded || !dossier(definition.kind).needs_load)
            && (machine.axis == Axis::Rotational || !dossier(definition.kind).only_turning)
    };
    for definition in LIBRARY.iter().copied().filter(can_act) {
        for site in machine.sites() {
            let host = assembly.host_kind(host_of(site));
            if definition.hosts.contains(&host)
                && makes_sense(machine, &assembly, definition, site, host)
                && applies(machine, &assembly, definition, site)
            {
                found.push(Candidate { site, definition, place: definition.place_under(host) });
            }
        }
    }
    found
}

/// Whether the machine with the effect can be assembled.
fn applies(machine: &Machine, assembly: &Assembly, definition: &'static Definition, site: Site) -> bool {
    let mut probe = machine.clone();
    let values: Vec<f64> = definition.parameters.iter().map(|p| p.default.unwrap_or(p.typical)).collect();
    let Some(effects) = probe.element_mut(site).map(Element::effects_mut) else { return false };
    // A believed effect of an overlapping kind is replaced.
    effects.retain(|effect| !overlaps(definition.kind, effect.definition.kind));
    // An effect that splits a mass may exceed it with the typical value. The fit uses a smaller one.
    let refused = definition.apply(&mut assembly.clone(), host_of(site), &values);
    effects.push(EffectUse { definition, values });
    matches!(refused, Err(EffectError::MassExceeded { .. })) || assemble(&probe).is_ok()
}

/// Bodies between drive and tool: connected to a driven body rigidly or by stiffness, not through the ground
/// or a body that takes a drive's reaction.
fn driven(assembly: &Assembly) -> Vec<usize> {
    let pushed = assembly.drives.iter().map(|drive| drive.on).collect();
    let stops: Vec<usize> =
        assembly.drives.iter().map(|drive| drive.reacts_on).chain([GROUND_NODE]).collect();
    assembly.reached(pushed, &stops, |link| link.rigid || link.stiffness > 0.0)
}

/// Whether an effect on this element makes sense there: a transmission lies between driven bodies,
/// a fixture holds the workpiece of a contact.
fn makes_sense(
    machine: &Machine,
    assembly: &Assembly,
    definition: &Definition,
    site: Site,
    host: HostKind,
) -> bool {
    let chain = driven(assembly);
    let i = site.index;
    match (definition.place, site.table) {
        (Place::Transmission, ElementKind::Springs) => {
            chain.contains(&assembly.links[i].a) && chain.contains(&assembly.links[i].b)
        }
        (Place::Transmission, ElementKind::Bodies) => {
            // Rigidly joined bodies are one mass. The payload is reported at the body that meets the work.
            let tool = assembly.contacts.iter().map(|contact| contact.a).find(|node| chain.contains(node));
            let last = tool.or_else(|| chain.last().copied());
            chain.contains(&(i + 1))
                && (last == Some(i + 1) || !rigid_together(assembly, i + 1, last.unwrap_or(GROUND_NODE)))
        }
        (Place::Guide, ElementKind::Springs) => {
            let link = &assembly.links[i];
            host == HostKind::Spring && chain.contains(&link.a) != chain.contains(&link.b)
        }
        (Place::Workpiece, ElementKind::Springs) => {
            let link = &assembly.links[i];
            assembly
                .contacts
                .iter()
                .any(|contact| (contact.b == link.a || contact.b == link.b) && contact.b != GROUND_NODE)
        }
        (Place::Workpiece, ElementKind::Contacts) => {
            let touched = assembly.contacts[i].b;
            !assembly
                .links
                .iter()
                .any(|link| link.rigid && touched != GROUND_NODE && (link.a == touched || link.b == touched))
        }
        // A force beside a servo, or a servo's further input, is known. Only its gain may be off.
        (Place::Drive, ElementKind::Actuators) => !is_load(machine, i) || definition.has(Trait::PlainNumber),
        (Place::Encoder, ElementKind::Sensors) => machine.sensors[i].reads.quantity == Quantity::Position,
        _ => true,
    }
}

/// Whether a drive is a further input of a servo, or a force on a body that a drive of another kind moves.
fn is_load(machine: &Machine, drive: usize) -> bool {
    let is_force = |kind: &ActuatorKind| matches!(kind, ActuatorKind::Force { .. });
    let Some((_, own)) = machine.actuators.get_index(drive) else { return false };
    let is_beside = || machine.actuators.values().any(|other| other.on == own.on && !is_force(&other.kind));
    own.kind.feeds_servo() || (is_force(&own.kind) && is_beside())
}

fn rigid_together(assembly: &Assembly, a: usize, b: usize) -> bool {
    assembly.reached(vec![a], &[], |link| link.rigid).contains(&b)
}
