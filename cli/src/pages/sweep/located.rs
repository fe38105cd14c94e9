//! The values at which runs stop coming to rest, and the accuracy of the edges of an adaptive sweep.

use feeler_studies::sweep::{DrawnAxis, Sweep};

use crate::numbers::{plain, with_unit};

/// Effect of noise on the edges that an adaptive sweep locates; `None` if it is not adaptive or has nothing
/// random.
pub(crate) fn about_noise(sweep: &Sweep) -> Option<&'static str> {
    sweep.file.refine?;
    let scenario = &sweep.document.scenario;
    let is_noisy = scenario.machine.sensors.values().any(|sensor| sensor.noise > 0.0)
        || scenario.controllers.values().any(|used| used.spec.jitter_s > 0.0);
    let text = "Sensors or samples are noisy, so chance decides near an edge. The edge is that of this seed \
                (run.seed draws another).";
    is_noisy.then_some(text)
}

/// The finest spacing of each axis in words, in the terms of the axis; `None` if the sweep is not adaptive.
pub(crate) fn located(sweep: &Sweep) -> Option<String> {
    let refine = sweep.file.refine?;
    let of = |axis: DrawnAxis| {
        let share = sweep.file.axes.get_full(&axis.key).map_or(1.0, |(i, _, values)| refine.share(i, values));
        let [first, next] = [axis.value(0.0), axis.value(share)];
        let spacing = if axis.log {
            format!("{} %", plain(100.0 * ((next / first).max(first / next) - 1.0)))
        } else {
            with_unit((next - first).abs(), &axis.unit)
        };
        format!("{spacing} of {}", axis.key)
    };
    Some(DrawnAxis::of(&sweep.file).into_iter().map(of).collect::<Vec<_>>().join(" and "))
}

/// The value at which runs along one axis stop or begin to come to rest, if there is exactly one. `points`
/// are values and whether the run comes to rest.
pub(super) fn edge(axis: &DrawnAxis, mut points: Vec<(f64, bool)>) -> Option<String> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut switches = points.windows(2).filter(|pair| pair[0].1 != pair[1].1);
    let ([(below, rests), (above, _)], None) = (switches.next()?, switches.next()) else { return None };
    let [below, above] = [*below, *above].map(|value| with_unit(value, &axis.unit));
    let key = &axis.key;
    Some(if *rests {
        format!("It settles up to {key} = {below}, and no longer at {above}. ")
    } else {
        format!("It settles at {key} = {above} and above, but not yet at {below}. ")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_an_edge_is_told_where_there_is_one() {
        let axis =
            DrawnAxis { key: "kp".into(), unit: String::new(), range: [0.0, 1.0], points: None, log: false };
        let sentence_of = |rests: &[bool]| {
            let points = rests.iter().enumerate().map(|(i, rests)| (0.5 * i as f64, *rests));
            // Points may come in any order.
            edge(&axis, points.rev().collect()).unwrap_or_default()
        };
        assert_eq!(sentence_of(&[true, true, false]), "It settles up to kp = 0.5, and no longer at 1. ");
        assert_eq!(sentence_of(&[false, true]), "It settles at kp = 0.5 and above, but not yet at 0. ");
        for none in [&[true, true][..], &[true, false, true], &[]] {
            assert_eq!(sentence_of(none), "");
        }
    }
}
