//! Margins at the limit of rounding.

use feeler_lti::{LoopTransfer, StateSpace};
use nalgebra::dmatrix;
#[test]
fn regress_an_integrator_s_pole_moved_by_rounding_is_still_one() {
    // The pole of a sampled integrator, off 1 by an ulp either way. 0.2 / (z - 1) is stable at gain 1, whose
    // phase margin follows from |z - 1| = 0.2.
    for pole in [1.0, 1.0 + f64::EPSILON, 1.0 - f64::EPSILON] {
        let integrator =
            StateSpace::discrete(dmatrix![pole], dmatrix![0.2], dmatrix![1.0], dmatrix![0.0], 1e-3).unwrap();
        let transfer = LoopTransfer::discrete(&integrator).unwrap();
        let margins = transfer.margins().unwrap();
        assert!(margins.closed_loop_stable, "{pole}");
        let expected = std::f64::consts::FRAC_PI_2 - 0.1_f64.asin();
        assert!((margins.smallest_phase().unwrap().margin_rad - expected).abs() < 1e-9, "{pole}");
        assert!((margins.smallest_increase().unwrap().factor - 10.0).abs() < 1e-9, "{pole}");
    }
}

#[test]
fn regress_an_integrator_that_its_zero_all_but_cancels_leaves_the_margins_of_the_rest() {
    // 0.5 / (z - 0.5) under 1 + k / (z - 1): the integrator is below rounding. The rest is -1/3 at z = -1 and
    // stable up to 3.
    for integral in [1e-9, 1e-13, 1e-15] {
        let open = StateSpace::discrete(
            dmatrix![1.0, 0.0; 0.5 * integral, 0.5],
            dmatrix![1.0; 0.5],
            dmatrix![0.0, 1.0],
            dmatrix![0.0],
            1e-3,
        );
        let transfer = LoopTransfer::discrete(&open.unwrap()).unwrap();
        let margins = transfer.margins().unwrap();
        assert!(margins.closed_loop_stable, "{integral}");
        // The integrator's own share of the response at z = -1 is half of `integral`.
        assert!((margins.smallest_increase().unwrap().factor - 3.0).abs() < 1e-8, "{integral}");
    }
}
