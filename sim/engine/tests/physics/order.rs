//! Order of the error over the step, by regression.

use feeler_engine::{Integrator, Scenario};
use feeler_plant::description::GROUND;

use crate::common::{axis, body, close, free_mass, reference_machine, run, scenario, spring};

/// Slope of `log error` over `log step` by least squares.
fn slope(steps: &[f64], errors: &[f64]) -> f64 {
    let n = steps.len() as f64;
    let (x, y): (Vec<f64>, Vec<f64>) =
        (steps.iter().map(|h| h.ln()).collect(), errors.iter().map(|e| e.ln()).collect());
    let (mean_x, mean_y) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let covariance: f64 = x.iter().zip(&y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    covariance / x.iter().map(|x| (x - mean_x).powi(2)).sum::<f64>()
}

fn last_state(scenario: &Scenario) -> Vec<f64> {
    run(scenario).1.state(0)
}

/// Distance of two states, with speeds divided by 100 rad/s.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let half = a.len() / 2;
    let weighed = |i: usize| (a[i] - b[i]) / if i < half { 1.0 } else { 100.0 };
    (0..a.len()).map(|i| weighed(i).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn order_of_a_smooth_motion_is_that_of_the_method() {
    let mut machine = free_mass(2.0, 1e-2, 0.0);
    machine.bodies.insert("load".into(), body(3.0, -5e-3));
    machine.springs.insert("mount".into(), spring(GROUND, "tip", 4e4, 20.0));
    machine.springs.insert("joint".into(), spring("tip", "load", 2e4, 10.0));
    let base = scenario(machine, 0.1, &[]);
    let exact = last_state(&base);
    // The band of the slope: the contribution of the next error term over a range of 8 in the step.
    for (integrator, order, band) in [(Integrator::SemiImplicitEuler, 1.0, 0.1), (Integrator::Rk4, 4.0, 0.1)]
    {
        let steps = [4e-4, 2e-4, 1e-4, 5e-5];
        let error = |step_s: &f64| {
            let mut scenario = base.clone();
            scenario.run.integrator = integrator;
            scenario.run.step_s = *step_s;
            distance(&last_state(&scenario), &exact)
        };
        let errors: Vec<f64> = steps.iter().map(error).collect();
        let slope = slope(&steps, &errors);
        println!("{}: {slope:.3}, errors {errors:?}", integrator.name());
        close(slope, order, band);
    }
}

/// Events at the ends of steps make both methods first order through an impact. The error depends on the
/// position of the touch within the step, so it is averaged over starting points.
#[test]
fn order_through_an_impact_is_one() {
    let start = |scenario: &mut Scenario, i: u32| {
        scenario.machine.bodies["tip"].position_m = -5e-3 - f64::from(i) * 3.7e-5;
    };
    let mut base = reference_machine(1, 0.06);
    base.run.record.clear();
    for integrator in [Integrator::SemiImplicitEuler, Integrator::Rk4] {
        let steps = [2e-4, 1e-4, 5e-5, 2.5e-5];
        let errors: Vec<f64> = (steps.iter())
            .map(|&step_s| {
                let of = |i: u32| {
                    let mut scenario = base.clone();
                    start(&mut scenario, i);
                    let exact = last_state(&scenario);
                    scenario.run.integrator = integrator;
                    scenario.run.step_s = step_s;
                    distance(&last_state(&scenario), &exact)
                };
                (0..24).map(of).sum::<f64>() / 24.0
            })
            .collect();
        let slope = slope(&steps, &errors);
        println!("{} through an impact: {slope:.3}, errors {errors:?}", integrator.name());
        // The mean of 24 errors, each spread uniformly over a range as wide as its mean, scatters by an
        // eighth. That is 0.17 octaves per step size, 0.1 in the slope.
        close(slope, 1.0, 0.25);
    }
}

/// The exact method has no step: the number of records changes only roundings. An impact multiplies the
/// rounding of its instant by the change of acceleration, a few times over.
#[test]
fn truth_exact_integrator_does_not_depend_on_the_record() {
    const ROUNDING: f64 = 1e-11;
    let mut scenarios: Vec<Scenario> =
        [1, 2, 4].iter().map(|&masses| reference_machine(masses, 0.3)).collect();
    scenarios.push(axis(0.2));
    for mut scenario in scenarios {
        scenario.run.record_rate_hz = Some(1.0);
        let coarse = last_state(&scenario);
        for rate_hz in [1e3, 1e4, 27_182.8] {
            scenario.run.record_rate_hz = Some(rate_hz);
            for energy in [false, true] {
                scenario.run.energy = energy;
                let fine = last_state(&scenario);
                assert!(
                    distance(&coarse, &fine) < ROUNDING,
                    "{}: {:e}",
                    scenario.machine.name,
                    distance(&coarse, &fine)
                );
            }
        }
    }
}
