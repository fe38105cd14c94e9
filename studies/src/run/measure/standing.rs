//! Motion that has not ended at the end of a run.

use feeler_control::{Law, ReferenceSpec};
use feeler_engine::{ControllerUse, Scenario, Simulation};
use feeler_lanes::Lane;
use feeler_manipulator::{Cell, JointPart};
use feeler_plant::description::Engagement;

use crate::run::measure::contact::ContactRun;

/// The state of a run at its end.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::run) struct Standing {
    /// Whether a controller was in its approach.
    pub(in crate::run) is_approaching: bool,
    /// Compression of each contact, m, its rate, m/s, and its acceleration, m/s2.
    compressions: Vec<[f64; 3]>,
}

impl Standing {
    pub(in crate::run) fn of<L: Lane>(simulation: &Simulation<L>, lane: usize) -> Self {
        Self { is_approaching: simulation.is_approaching(lane), compressions: simulation.compressions(lane) }
    }

    /// The state of a whole arm with its one contact. Beyond the measurable distance only an approach can
    /// close the gap. If nothing holds or drives the arm, drag slows a tool that leaves, but does not bring
    /// it back.
    pub(in crate::run) fn of_arm(simulation: &feeler_manipulator::CellSimulation, cell: &Cell) -> Self {
        let leaves = |[_, rate, _]: &[f64; 3]| *rate < 0.0 && !is_driven(cell);
        Self {
            is_approaching: simulation.is_approaching() && simulation.has_a_way(),
            compressions: simulation.compression().filter(|state| !leaves(state)).into_iter().collect(),
        }
    }

    /// Whether the tool may still touch: a controller approaches, or some gap closes within `horizon_s` at
    /// its present rate and acceleration.
    pub(in crate::run) fn is_on_its_way(&self, contacts: &[ContactRun], horizon_s: f64) -> bool {
        let arrives =
            |(contact, state): (&ContactRun, &[f64; 3])| can_touch(contact) && closes(*state, horizon_s);
        (self.is_approaching && contacts.iter().any(can_touch))
            || contacts.iter().zip(&self.compressions).any(arrives)
    }

    /// Time until the first gap closes at its present rate, s; `None` if no gap closes.
    pub(in crate::run) fn touches_in_s(&self, contacts: &[ContactRun]) -> Option<f64> {
        let gaps = contacts.iter().zip(&self.compressions).filter(|(contact, _)| can_touch(contact));
        let closing = gaps.filter(|(_, [compression, rate, _])| *compression < 0.0 && *rate > 0.0);
        closing.map(|(_, [compression, rate, _])| -compression / rate).reduce(f64::min)
    }
}

/// Whether anything moves the motors of an arm: its position control, a controller with a law or a reference,
/// or a joint's load or ripple.
fn is_driven(cell: &Cell) -> bool {
    let drives = |used: &ControllerUse| {
        !matches!(used.spec.law, Law::OpenLoop) || used.spec.reference != ReferenceSpec::Constant(0.0)
    };
    let loaded = |joint: &JointPart| joint.guide.load != 0.0 || !joint.drive.ripples.is_empty();
    cell.hold.bandwidth_hz > 0.0
        || cell.scenario.controllers.values().any(drives)
        || cell.joints.iter().any(loaded)
}

/// Whether a negative compression becomes positive within `horizon_s`.
fn closes([compression, rate, acceleration]: [f64; 3], horizon_s: f64) -> bool {
    let after = |t: f64| compression + t * (rate + 0.5 * t * acceleration);
    // If the tool turns back before the horizon, it is nearest where it turns.
    let turns_s = if acceleration < 0.0 { -rate / acceleration } else { horizon_s };
    let nearest_s = turns_s.min(horizon_s);
    nearest_s > 0.0 && after(nearest_s) >= 0.0
}

/// Whether no contact of a scenario ever touches. A wall is then one that a controller renders, and
/// `no-contact` is its rest.
pub(crate) fn nothing_can_touch(scenario: &Scenario) -> bool {
    scenario.machine.contacts.values().all(|contact| contact.engagement == Engagement::Free)
}

/// Whether a contact is one that opens and closes.
pub(in crate::run) fn can_touch(contact: &ContactRun) -> bool {
    contact.engagement == Engagement::Unilateral
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_a_gap_closes_by_its_rate_or_by_what_drives_it() {
        for (state, closes_so) in [
            ([-1.0, 0.1, 0.0], true),
            ([-1.0, 0.09, 0.0], false),
            ([-1.0, 0.0, 0.0], false),
            // Thrown off, and pushed back.
            ([-1.0, -0.39, 0.1], true),
            ([-1.0, -1.0, 0.1], false),
            // Approaching, and slowed down: it advances by 0.5 m at most.
            ([-0.4, 1.0, -1.0], true),
            ([-0.6, 1.0, -1.0], false),
        ] {
            assert_eq!(closes(state, 10.0), closes_so, "{state:?}");
        }
    }
}
