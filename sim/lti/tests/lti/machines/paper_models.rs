//! The machines of the paper (Eppinger and Seering 1992) with the numbers of the reference axis. Poles, zeros
//! and stable gains agree with independent figures (from `SciPy`) to every printed digit.

use std::f64::consts::TAU;

use super::axis::{Axis, Drive};
use feeler_lti::{AffineLoop, Continuous, StateSpace, TimeDomain, frequencies_hz};

/// Half a unit of the third decimal, the last printed for frequencies, plus the rounding of the number
/// itself.
const FREQUENCY_HZ: f64 = 0.5e-3 + 1e-9;
/// Half a unit of the fourth decimal, the last printed for gains.
const GAIN: f64 = 0.5e-4 + 1e-9;

#[expect(clippy::struct_excessive_bools, reason = "a model is named by which parts it has")]
pub(crate) struct Row {
    pub(crate) name: &'static str,
    flexible: bool,
    base: bool,
    workpiece: bool,
    source: bool,
    order: (usize, usize),
    poles_hz: &'static [f64],
    zeros_hz: &'static [f64],
    continuous: Option<f64>,
    sampled: Option<[f64; 3]>,
}

impl Row {
    pub(crate) fn system(&self) -> StateSpace {
        let wb = TAU * 12.0;
        Axis {
            masses: (7.0, 5.0),
            guide_damping: 60.0,
            contact: (2e5, 120.0),
            transmission: self.flexible.then_some((1.2e6, 120.0)),
            base: self.base.then_some((180.0, 180.0 * wb * wb, 2.0 * 0.03 * 180.0 * wb)),
            workpiece: self.workpiece.then_some((3.0, 1.5e6, 150.0)),
            drive: if self.source { Drive::VelocitySource(600.0, 2e-3) } else { Drive::Ideal },
            total_force: false,
        }
        .system()
    }
}

const PLAIN: Row = Row {
    name: "rigid, ideal",
    flexible: false,
    base: false,
    workpiece: false,
    source: false,
    order: (2, 0),
    poles_hz: &[20.547],
    zeros_hz: &[],
    continuous: None,
    sampled: Some([1.8070, 0.6067, 0.3689]),
};

pub(crate) const ROWS: [Row; 6] = [
    PLAIN,
    Row {
        name: "rigid, source",
        source: true,
        order: (3, 0),
        poles_hz: &[21.738, 71.094],
        continuous: Some(0.0034),
        sampled: None,
        ..PLAIN
    },
    Row {
        name: "flexible, ideal",
        flexible: true,
        order: (4, 1),
        poles_hz: &[19.967, 105.049],
        zeros_hz: &[1591.549],
        continuous: Some(5.6083),
        sampled: Some([1.5068, 0.5641, 0.3502]),
        ..PLAIN
    },
    Row {
        name: "base, ideal",
        base: true,
        order: (4, 2),
        poles_hz: &[11.458, 21.518],
        zeros_hz: &[11.619],
        sampled: Some([1.8475, 0.6234, 0.3804]),
        ..PLAIN
    },
    Row {
        name: "workpiece, ideal",
        workpiece: true,
        order: (4, 2),
        poles_hz: &[19.270, 119.995],
        zeros_hz: &[112.540],
        sampled: Some([1.5741, 0.5705, 0.3519]),
        ..PLAIN
    },
    Row {
        name: "all three, ideal",
        flexible: true,
        base: true,
        workpiece: true,
        order: (8, 5),
        poles_hz: &[11.322, 19.788, 103.789, 121.826],
        zeros_hz: &[11.529, 112.661, 1591.549],
        continuous: Some(4.968),
        sampled: Some([1.4167, 0.5607, 0.3534]),
        ..PLAIN
    },
];

fn assert_close(name: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{name}: {found:?} against {expected:?}");
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() <= tolerance, "{name}: {found:?} against {expected:?}");
    }
}

/// The largest stable gain, `None` if there is none; gain zero must be stable.
fn largest_gain<T: TimeDomain>(system: &StateSpace<T>) -> Option<f64> {
    let stable = AffineLoop::negative_feedback(system).unwrap().stable_gains().unwrap();
    assert!(stable.intervals[0].lower.is_none());
    stable.intervals.last().unwrap().upper.as_ref().map(|edge| edge.gain)
}

#[test]
fn reference_poles_and_zeros() {
    for row in &ROWS {
        let system = row.system();
        let (poles, zeros) = (system.poles().unwrap(), system.zeros().unwrap());
        assert_eq!((poles.len(), zeros.len()), row.order, "{}", row.name);
        assert_close(row.name, &frequencies_hz(Continuous, &poles), row.poles_hz, FREQUENCY_HZ);
        assert_close(row.name, &frequencies_hz(Continuous, &zeros), row.zeros_hz, FREQUENCY_HZ);
    }
}

#[test]
fn reference_continuous_gain_limits() {
    for row in &ROWS {
        let found = largest_gain(&row.system());
        match (found, row.continuous) {
            (None, None) => {}
            // Three of the printed limits have three or four decimals; the coarsest sets the comparison.
            (Some(found), Some(expected)) => {
                let tolerance = if row.flexible && row.base { 0.5e-3 } else { GAIN };
                assert!((found - expected).abs() <= tolerance, "{}: {found} against {expected}", row.name);
            }
            other => panic!("{}: {other:?}", row.name),
        }
    }
}

#[test]
fn reference_sampled_gain_limits() {
    for row in &ROWS {
        let Some(expected) = row.sampled else { continue };
        for (samples, expected) in expected.into_iter().enumerate() {
            let sampled = row.system().zero_order_hold_delayed(1e-3, samples as f64 * 1e-3).unwrap();
            let found = largest_gain(&sampled).unwrap();
            assert!(
                (found - expected).abs() <= GAIN,
                "{}, {samples} samples: {found} against {expected}",
                row.name
            );
        }
    }
}

#[test]
fn truth_zeros_vanish_by_substitution() {
    for row in &ROWS {
        let system = row.system();
        for zero in system.zeros().unwrap() {
            let near = zero * 1.01;
            let ratio = system.at(zero).unwrap()[(0, 0)].norm() / system.at(near).unwrap()[(0, 0)].norm();
            // At a distance of one per cent the response is of order 0.01. At the zero it is of the order of
            // its relative error times that.
            assert!(ratio < 1e-10, "{}: {zero}: {ratio:e}", row.name);
        }
    }
}

#[test]
fn truth_zero_pole_gain_reproduces_the_response() {
    for row in &ROWS {
        let system = row.system();
        let form = system.zero_pole_gain().unwrap();
        assert_eq!(form.poles.len() - form.zeros.len(), row.order.0 - row.order.1);
        for f in [0.1, 5.0, 20.0, 111.0, 900.0] {
            let point = Continuous.boundary_point(TAU * f);
            let (direct, factored) = (system.at(point).unwrap()[(0, 0)], form.at(point));
            // Zeros and poles are exact to some tens of roundings, more if the response is small between
            // large terms.
            assert!(
                (direct - factored).norm() < 1e-10 * direct.norm(),
                "{} at {f} Hz: {direct} {factored}",
                row.name
            );
        }
    }
}

/// The stable gains of the continuous workpiece model have no upper end, as printed, but they have a gap. A
/// search for the largest stable gain misses it. Hurwitz's determinant of the characteristic polynomial,
/// written out by hand, is zero at both of its ends.
#[test]
fn truth_workpiece_model_has_a_gap_of_unstable_gains() {
    let hurwitz = |gain: f64| {
        let (m, br, ks, bs, mw, kw, bw) = (12.0, 60.0, 2e5, 120.0, 3.0, 1.5e6, 150.0);
        let k = ks * (1.0 + gain);
        let (a4, a3) = (m * mw, m * (bs + bw) + (br + bs) * mw);
        let a2 = m * (ks + kw) + (br + bs) * (bs + bw) + k * mw - bs * bs;
        let a1 = (br + bs) * (ks + kw) + k * (bs + bw) - bs * ks - bs * k;
        let a0 = k * kw;
        a3 * a2 * a1 - a4 * a1 * a1 - a3 * a3 * a0
    };
    let stable = AffineLoop::negative_feedback(&ROWS[4].system()).unwrap().stable_gains().unwrap();
    assert_eq!(stable.intervals.len(), 2);
    assert!(stable.intervals[1].upper.is_none());
    let edges =
        [stable.intervals[0].upper.as_ref().unwrap().gain, stable.intervals[1].lower.as_ref().unwrap().gain];
    // The determinant changes sign within one part in 1e9 of each edge.
    assert!(hurwitz(edges[0] * (1.0 - 1e-9)) > 0.0 && hurwitz(edges[0] * (1.0 + 1e-9)) < 0.0, "{edges:?}");
    assert!(hurwitz(edges[1] * (1.0 - 1e-9)) < 0.0 && hurwitz(edges[1] * (1.0 + 1e-9)) > 0.0, "{edges:?}");
}
