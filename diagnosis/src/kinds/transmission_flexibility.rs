//! `transmission-flexibility`: a flexible joint.

use std::f64::consts::TAU;

use feeler_plant::assembly::Assembly;
use feeler_plant::effects::{Host, Kind, TransmissionFlexibility};

use super::start::{NARROW, every, is_overdamped, mode};
use super::{Element, Glance, Known, Seen};

/// Range of trial frequencies for the mode of a joint, Hz.
const RANGE_HZ: (f64, f64) = (10.0, 400.0);
/// Trial shares of the largest command that deflect the spring.
const SHARES: [f64; 4] = [1.0, 0.5, 0.2, 0.1];
/// Lowest visible mode of a servo, over the frequency of the servo's loop.
const BELOW_LOOP: f64 = 0.7;
/// Smallest number of rows in a period of a mode.
const ROWS_PER_PERIOD: f64 = 3.0;

impl Known for TransmissionFlexibility {
    /// On average, a joint with play is flexible, too.
    const WHERE_IT_RATTLES: Option<Kind> = Some(Kind::Backlash);

    fn starts(element: &Element<'_>, glance: &Glance) -> Vec<Self> {
        let Some(assembly) = element.assembly() else { return Vec::new() };
        let range_hz = range_hz(&assembly, glance.spacing_s);
        let mass_of = |node: usize| assembly.nodes[node].mass_kg;
        // The split of a body's mass is unknown: a third or two thirds may be beyond the spring.
        let split = match element.host {
            Host::Spring(i) => vec![[mass_of(assembly.links[i].a), mass_of(assembly.links[i].b)]],
            Host::Body(node) => [1.0 / 3.0, 2.0 / 3.0]
                .map(|share| [(1.0 - share) * mass_of(node), share * mass_of(node)])
                .to_vec(),
            _ => Vec::new(),
        };
        // Sensors on both bodies show the deflection of a spring, under at most the largest command.
        let most = glance.elongation(element.host).map(|range| 2.0 * glance.command / range);
        let of = |[a, b]: [f64; 2]| {
            let reduced = a * b / (a + b);
            let bent = most.into_iter().flat_map(|stiffness| SHARES.map(|share| share * stiffness));
            let bent_hz = bent.map(move |stiffness| (stiffness / reduced).sqrt() / TAU);
            every(range_hz).chain(bent_hz).map(move |frequency_hz| {
                let (stiffness, damping) = mode(reduced, frequency_hz, NARROW);
                Self { stiffness, damping, tip_mass: b }
            })
        };
        let is_sound = |own: &Self| own.stiffness.is_finite() && own.stiffness > 0.0;
        split.into_iter().flat_map(of).filter(is_sound).collect()
    }

    fn is_trivial(self, _: &Element<'_>, seen: Seen) -> bool {
        seen.is_lost(seen.command_n / self.stiffness)
            || is_overdamped(self.tip_mass, self.stiffness, self.damping)
    }
}

/// Range of possible frequencies of a mode. The loop of a servo, and its rows, may be slower than all of
/// [`RANGE_HZ`].
fn range_hz(assembly: &Assembly, spacing_s: f64) -> (f64, f64) {
    let total: f64 = assembly.nodes.iter().map(|node| node.mass_kg).filter(|mass| mass.is_finite()).sum();
    let loops = assembly.drives.iter().filter_map(|drive| drive.servo);
    let low = loops.map(|servo| BELOW_LOOP * (servo.kp / total).sqrt() / TAU).fold(RANGE_HZ.0, f64::min);
    let high = if low < RANGE_HZ.0 { 1.0 / (ROWS_PER_PERIOD * spacing_s) } else { RANGE_HZ.1 };
    (low, high.clamp(low, RANGE_HZ.1))
}

#[cfg(test)]
mod tests {
    use feeler_plant::assembly::assemble;
    use feeler_plant::description::{Actuator, ActuatorKind, Body, GROUND, Machine, PositionServo};

    use super::*;

    #[test]
    fn truth_a_slow_loop_widens_the_range_to_its_own_frequency_and_its_rows_narrow_it() {
        let range_of = |loop_hz: f64, rate_hz: f64| {
            let kp = 0.02 * (TAU * loop_hz).powi(2);
            let servo = ActuatorKind::PositionServo(PositionServo { kp, ..PositionServo::default() });
            let machine = Machine::new("joint")
                .with_body("link", Body::new(0.02))
                .with_actuator("servo", Actuator { kind: servo, ..Actuator::ideal("link", GROUND) });
            range_hz(&assemble(&machine).unwrap(), 1.0 / rate_hz)
        };
        let (low, high) = range_of(4.0, 100.0);
        assert!((low - BELOW_LOOP * 4.0).abs() < 1e-12 && (high - 100.0 / ROWS_PER_PERIOD).abs() < 1e-9);
        let (low, high) = range_of(100.0, 1e4);
        assert!(low.total_cmp(&RANGE_HZ.0).is_eq() && high.total_cmp(&RANGE_HZ.1).is_eq());
    }
}
