//! Loops whose sensor shows the command at once.

use crate::common::force_loop;
use feeler_analysis::{Request, View, analyze};
use feeler_plant::effects::{EffectUse, find};

/// A tool behind the sensor shares the drive's force with its body. At `kp` minus the ratio of both masses
/// the loop without a computer has no solution, at gains that a search may try.
#[test]
fn regress_a_tool_that_weighs_a_fraction_of_its_body_is_analysed_like_any_other() {
    let edge = |share: f64| {
        let mut scenario = force_loop(0.3, 0.0);
        scenario.machine.bodies.shift_remove("tip");
        scenario.machine.springs.shift_remove("transmission");
        scenario.machine.bodies["motor"].mass_kg = 12.0;
        scenario.machine.contacts["tool"].between[0] = "motor".into();
        let definition = find("tool-inertia").unwrap();
        let inertia = EffectUse { definition, values: vec![12.0 * share] };
        scenario.machine.sensors["force"].effects.push(inertia);
        let request = Request { view: View::CLAMPED, ..Request::default() };
        analyze(&scenario, &request).unwrap().looped.unwrap().gain.sampled.stable[1].unwrap()
    };
    for share in [1.0 / 2.0, 1.0 / 4.0, 1.0 / 6.0] {
        // The edge is a smooth function of the share.
        let [here, beside] = [share, share * (1.0 + 1e-6)].map(edge);
        assert!((here / beside - 1.0).abs() < 1e-5, "{share}: {here} {beside}");
    }
}
