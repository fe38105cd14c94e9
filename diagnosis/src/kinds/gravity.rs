//! `gravity`: the weight of an arm.

use std::f64::consts::{FRAC_PI_2, TAU};

use feeler_plant::description::Axis;
use feeler_plant::effects::{Gravity, Kind};

use super::force_ripple::wave;
use super::{Balance, Element, Force, Form, Glance, Known, Resembled};

/// Trial values of the largest torque, as shares of the largest command.
const SHARES: [f64; 3] = [0.05, 0.25, 0.7];

/// Number of angles within a turn at which a weight is compared with a constant load.
const ANGLES: u32 = 8;

impl Known for Gravity {
    const ONLY_TURNING: bool = true;
    const RESEMBLES: &'static [Resembled<Self>] = &[(Kind::ConstantLoad, |own| {
        let at = |i: u32| TAU * f64::from(i) / f64::from(ANGLES) + own.phase;
        (0..ANGLES).map(|i| vec![-own.amplitude * at(i).sin()]).collect()
    })];
    const BALANCE: Option<Balance<Self>> = Some(Balance {
        form: Form::Forces(&[
            Force::signed(|at| (TAU * at.position / at.shape).sin()),
            Force::signed(|at| (TAU * at.position / at.shape).cos()),
        ]),
        shapes: |_| vec![TAU],
        values: |of, period| Self { amplitude: of[0].hypot(of[1]), phase: of[1].atan2(of[0]), period },
        coefficients: |own| {
            (vec![own.amplitude * own.phase.cos(), own.amplitude * own.phase.sin()], own.period)
        },
    });
    const APART: &'static [(Kind, &'static str)] = &[
        (
            Kind::ConstantLoad,
            "hold the arm still at angles far apart: only one of them changes with the angle",
        ),
        (
            Kind::ForceRipple,
            "move through a whole turn: weight repeats once, a ripple of the drive many times",
        ),
    ];

    /// Only a rotational axis has an angle between arm and weight.
    fn starts(element: &Element<'_>, glance: &Glance) -> Vec<Self> {
        if element.machine.axis != Axis::Rotational {
            return Vec::new();
        }
        let at = |amplitude: f64, phase: f64| Self { amplitude, phase, period: TAU };
        let [sine, cosine] = wave(&glance.missing, TAU).map_or([0.0; 2], |(_, wave)| wave);
        let seen = Some(at(sine.hypot(cosine), (-cosine).atan2(-sine))).filter(|seen| seen.amplitude > 0.0);
        let quarters = [0.0, 1.0, 2.0, -1.0].map(|quarter| quarter * FRAC_PI_2);
        let tried =
            SHARES.into_iter().flat_map(|share| quarters.map(|phase| at(share * glance.command, phase)));
        seen.into_iter().chain(tried).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::nearest;
    use super::*;

    /// At any angle one of the loads equals the weight, within its change over a sixteenth of a turn.
    #[test]
    fn truth_a_weight_over_a_short_motion_begins_as_the_load_that_it_is() {
        let loads = nearest(Kind::Gravity, Kind::ConstantLoad, &[12.0, 0.7, TAU]);
        for angle in [-2.0, 0.0, 0.4, 1.0, 3.0_f64] {
            let load = -12.0 * (angle + 0.7).sin();
            let off = loads.iter().map(|of| (of[0] - load).abs()).fold(f64::INFINITY, f64::min);
            assert!(off <= 12.0 * TAU / 16.0, "{angle}: {off}");
        }
        assert!(nearest(Kind::Gravity, Kind::CoulombFriction, &[12.0, 0.7, TAU]).is_empty());
    }
}
