//! Margins at the edge of what rounding can tell.

use feeler_lti::{LoopTransfer, StateSpace};
use nalgebra::dmatrix;
#[test]
fn regress_an_integrator_s_pole_moved_by_rounding_is_still_one() {
    // The pole of a sampled integrator, off 1 by an ulp either way: 0.2 / (z - 1) is stable at gain 1, whose phase margin follows from |z - 1| = 0.2.
    for pole in [1.0, 1.0 + f64::EPSILON, 1.0 - f64::EPSILON] {
        let integrator = StateSpace::discrete(dmatrix![pole], dmatrix![0.2], dmatrix![1.0], dmatrix![0.0], 1e-3).unwrap();
        let transfer = LoopTransfer::discrete(&integrator).unwrap();
        let margins = transfer.margins().unwrap();
        assert!(margins.closed_loop_stable, "{pole}");
        let expected = std::f64::consts::FRAC_PI_2 - 0.1_f64.asin();
        assert!((margins.smallest_phase().unwrap().margin_rad - expected).abs() < 1e-9, "{pole}");
        assert!((margins.smallest_increase().unwrap().factor - 10.0).abs() < 1e-9, "{pole}");
    }
}
