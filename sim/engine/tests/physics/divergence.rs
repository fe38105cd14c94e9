//! A motion that leaves all bounds is a result with a last state.

use feeler_control::ForceGains;
use feeler_engine::{Integrator, RunEnd, Scenario};
use feeler_plant::description::{Contact, ContactLaw, Engagement};

use crate::common::{axis, effect, force_control, run};

/// A force loop far beyond its largest stable gain, on an attached sensor so that nothing bounds it.
fn unstable(kp: f64) -> Scenario {
    let mut scenario = axis(20.0);
    scenario.controllers.clear();
    force_control(&mut scenario, ForceGains { kp, ..ForceGains::default() }, 1e-3, 20.0);
    scenario.machine.contacts["tool"].engagement = Engagement::Clamped;
    scenario.run.energy = false;
    scenario
}

fn diverges(what: &str, scenario: &Scenario) {
    let (trace, simulation) = run(scenario);
    let Some(RunEnd::Diverged { t_s }) = simulation.end(0) else { panic!("{what}: {:?}", simulation.end(0)) };
    assert!(t_s > 0.0 && t_s < 20.0, "{what}: {t_s}");
    let state = simulation.state(0);
    assert!(state.iter().all(|x| x.is_finite()), "{what}: {state:?}");
    assert!(trace.t_s.iter().all(|t| *t < t_s + 1.0), "{what}: recorded on after the end");
}

#[test]
fn truth_unstable_loops_diverge_with_a_finite_last_state() {
    for (integrator, name) in Integrator::ALL {
        for kp in [20.0, 50.0, 1e6, 1e150] {
            let mut scenario = unstable(kp);
            scenario.run.integrator = integrator;
            diverges(&format!("{name}, kp {kp}"), &scenario);
        }
        for law in [ContactLaw::HuntCrossley { alpha_s_per_m: 1.0, exponent: 1.5 }, ContactLaw::Hertz] {
            let mut scenario = unstable(50.0);
            scenario.run.integrator = integrator;
            let tool = &mut scenario.machine.contacts["tool"];
            *tool = Contact { law, stiffness: 2e7, ..tool.clone() };
            diverges(&format!("{name}, {law:?}"), &scenario);
        }
        let mut hardening = unstable(50.0);
        hardening.run.integrator = integrator;
        hardening.machine.contacts["tool"].effects.push(effect("hardening-stiffness", &[1e13]));
        diverges(&format!("{name}, hardening"), &hardening);
    }
}

/// Steps far too long for the machine make a fixed-step method diverge, with a cubic law within one step. The
/// exact method has no such limit.
#[test]
fn truth_too_long_a_fixed_step_diverges_and_the_exact_one_does_not() {
    for ((integrator, name), cubic) in
        Integrator::ALL.into_iter().flat_map(|method| [(method, 0.0), (method, 1e13)])
    {
        let mut scenario = axis(20.0);
        scenario.controllers.clear();
        scenario.machine.springs["transmission"].effects.push(effect("hardening-stiffness", &[cubic]));
        scenario.machine.bodies["tip"].velocity_m_per_s = 0.1;
        scenario.run.integrator = integrator;
        scenario.run.step_s = 0.05;
        scenario.run.record_rate_hz = Some(1.0);
        if integrator == Integrator::Exact {
            assert_eq!(run(&scenario).1.end(0), Some(RunEnd::Completed));
        } else {
            diverges(name, &scenario);
        }
    }
}
