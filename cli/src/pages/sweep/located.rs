//! Accuracy of the edges of an adaptive sweep.

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
