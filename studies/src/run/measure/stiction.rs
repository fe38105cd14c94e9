//! Sticking and breaking loose of guides on bristles: `lugre-friction`.
//!
//! Such a guide has no instant at which it sticks: its bristles hold it elastically, and it creeps. So it
//! counts as stuck by its motion: it rests for a considerable part of each cycle, and in between it travels
//! farther than its bristles bend. A smooth oscillation only passes through rest.

use feeler_engine::Trace;
use feeler_plant::assembly::Bristle;
use feeler_plant::description::{GROUND, Machine, Quantity, SignalName};
use feeler_plant::effects::Trait;

/// Share of the largest speed below which a guide rests.
const RESTS: f64 = 0.05;
/// Smallest time at rest, as a share of the time since the last rest. A sine is at rest for 0.03 of it.
const LEAST_REST: f64 = 0.2;

/// The speeds that show whether guides on bristles stick.
pub(in crate::run) fn signals(machine: &Machine) -> impl Iterator<Item = SignalName> {
    let bristled = machine
        .springs
        .values()
        .filter(|spring| spring.effects.iter().any(|effect| effect.definition.has(Trait::Bristles)));
    let bodies = bristled.flat_map(|spring| &spring.between).filter(|body| *body != GROUND);
    bodies.map(|body| SignalName::new(body, Quantity::Velocity))
}

/// Instants from `from_s` onwards at which a guide with these bristles, between two bodies, begins to rest or
/// breaks loose, s.
pub(in crate::run) fn changes_s(
    record: &Trace,
    between: &[String; 2],
    bristle: &Bristle,
    from_s: f64,
) -> Vec<f64> {
    let first = record.t_s.partition_point(|&t| t < from_s);
    let speed = |body: &String| {
        let column = record.column(&SignalName::new(body, Quantity::Velocity).to_string());
        column.and_then(|column| column.get(first..))
    };
    let [Some(a), Some(b)] =
        between.each_ref().map(|body| if body == GROUND { Some(&[][..]) } else { speed(body) })
    else {
        return Vec::new();
    };
    let t_s = &record.t_s[first..];
    let speeds: Vec<f64> = (0..t_s.len())
        .map(|row| (b.get(row).copied().unwrap_or(0.0) - a.get(row).copied().unwrap_or(0.0)).abs())
        .collect();
    rests_s(t_s, &speeds, (bristle.coulomb + bristle.excess) / bristle.stiffness)
}

/// Begin and end of each rest, s. Between two of them the guide travels by more than `bend_m`.
fn rests_s(t_s: &[f64], speeds: &[f64], bend_m: f64) -> Vec<f64> {
    let slow = RESTS * speeds.iter().fold(0.0_f64, |most, speed| most.max(*speed));
    let mut changes = Vec::new();
    // The present rest began here, and the last one that counts ended here.
    let (mut began_s, mut loose_s) = (None, t_s.first().copied().unwrap_or(0.0));
    let mut travelled_m = 0.0;
    for row in 1..t_s.len() {
        if speeds[row] < slow {
            began_s.get_or_insert(t_s[row]);
            continue;
        }
        if let Some(began_s) = began_s.take()
            && t_s[row] - began_s > LEAST_REST * (began_s - loose_s)
            && travelled_m > bend_m
        {
            changes.extend([began_s, t_s[row]]);
            (loose_s, travelled_m) = (t_s[row], 0.0);
        }
        travelled_m += speeds[row] * (t_s[row] - t_s[row - 1]);
    }
    changes
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn changes(speed: impl Fn(f64) -> f64, bend_m: f64) -> usize {
        let t_s: Vec<f64> = (0..10_000).map(|i| f64::from(i) * 1e-3).collect();
        let speeds: Vec<f64> = t_s.iter().map(|&t| speed(t).abs()).collect();
        rests_s(&t_s, &speeds, bend_m).len()
    }

    #[test]
    fn truth_stick_slip_rests_and_a_sine_does_not() {
        let sine = |t: f64| (TAU * t).sin();
        assert_eq!(changes(sine, 0.01), 0);
        // Slides for a quarter of each second, and creeps for the rest.
        let jumps = |t: f64| if t.fract() < 0.25 { (TAU * 2.0 * t.fract()).sin() } else { 0.01 };
        assert_eq!(changes(jumps, 0.01), 18);
        // Its bristles bend by more than it travels: it does not break loose.
        assert_eq!(changes(jumps, 1.0), 0);
        assert_eq!(changes(|_| 0.0, 0.01), 0);
    }
}
