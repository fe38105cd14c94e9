//! The force at which a machine is seen as linear.

use feeler_analysis::ContactView;
use feeler_control::{ControllerSpec, Law, Reference, ReferenceSpec};
use feeler_engine::Scenario;
use feeler_plant::assembly::assemble;
use feeler_plant::description::Engagement;

use crate::arguments::Analyze;
use crate::failure::BadInput;
use crate::numbers::with_unit;
use crate::units::Units;

/// How the contacts are taken, and what there is to say about it.
pub(super) fn contact_view(arguments: &Analyze, scenario: &Scenario) -> anyhow::Result<(ContactView, Option<String>)> {
    if let Some(preload_n) = arguments.preload {
        if !(preload_n.is_finite() && preload_n > 0.0) {
            return Err(BadInput::error(format!("--preload {preload_n} presses nothing"), "give a force above zero, in N"));
        }
        return Ok((ContactView::Pressed { preload_n }, None));
    }
    if arguments.free {
        return Ok((ContactView::Free, None));
    }
    let plain = if arguments.clamped { ContactView::Clamped } else { ContactView::AsDescribed };
    let Some(dependence) = dependence(scenario, arguments.clamped) else { return Ok((plain, None)) };
    if let Some(preload_n) = wanted_force(scenario) {
        let force = with_unit(preload_n, Units::of(&scenario.machine).force);
        let note = format!("{}; linearised at the last reference, {force} (--preload chooses another)", dependence.words());
        return Ok((ContactView::Pressed { preload_n }, Some(note)));
    }
    match dependence {
        Dependence::Vanishing => Err(BadInput::error(
            format!(
                "{}: the contact has no stiffness without force, and no reference of the file is a force above zero",
                arguments.file.display()
            ),
            "name the force at which to look at it, as in --preload 30, or look at the machine without contact with --free",
        )),
        Dependence::Contact => {
            let note = format!("{}; linearised without force, since no reference is one (--preload chooses one)", dependence.words());
            Ok((plain, Some(note)))
        }
        // Springs are at rest where nothing presses.
        Dependence::Spring => Ok((plain, None)),
    }
}

/// What depends on the force.
#[derive(Clone, Copy)]
enum Dependence {
    /// A contact, which without force has no stiffness.
    Vanishing,
    /// A contact.
    Contact,
    /// A spring.
    Spring,
}

impl Dependence {
    fn words(self) -> &'static str {
        match self {
            Self::Vanishing | Self::Contact => "the contact's stiffness or damping depends on its force",
            Self::Spring => "the stiffness of a spring depends on its force",
        }
    }
}

/// What of the machine depends on the contact's force: as assembled, since effects change the laws.
fn dependence(scenario: &Scenario, clamped: bool) -> Option<Dependence> {
    let assembly = assemble(&scenario.machine).ok()?;
    let touching: Vec<_> = assembly.contacts.iter().filter(|contact| clamped || contact.engagement != Engagement::Free).collect();
    if touching.iter().any(|contact| contact.law.exponent > 1.0) {
        return Some(Dependence::Vanishing);
    }
    if touching.iter().any(|contact| !contact.law.is_linear()) {
        return Some(Dependence::Contact);
    }
    let hardens = assembly.links.iter().any(|link| !link.rigid && link.cubic != 0.0);
    (hardens && !touching.is_empty()).then_some(Dependence::Spring)
}

/// What the first controller whose reference is a force asks for in the end; on average, where it never ends.
fn wanted_force(scenario: &Scenario) -> Option<f64> {
    let of_force = |spec: &&ControllerSpec| matches!(spec.law, Law::ExplicitForce(_) | Law::Admittance(_));
    let spec = scenario.controllers.values().map(|control| &control.spec).find(of_force)?;
    let force = match &spec.reference {
        ReferenceSpec::Multisine { offset, .. } | ReferenceSpec::WhiteNoise { offset, .. } | ReferenceSpec::Prbs { offset, .. } => *offset,
        lasting => Reference::new(lasting, 0, "").ok()?.value(f64::MAX),
    };
    Some(force).filter(|force| *force > 0.0)
}
