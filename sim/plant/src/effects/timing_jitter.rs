//! `timing-jitter`: controller samples deviate from the grid.

use super::prelude::*;

parameters! { TimingJitter
    sigma: log(Dimension::TIME, Some(0.0), 5e-5, (0.0, 1.0), "one standard deviation of the sample times"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: TimingJitter::KIND,
    name: "timing-jitter",
    place: Place::Timing,
    order: 410,
    hosts: &[HostKind::Controller],
    site: "",
    parameters: TimingJitter::PARAMETERS,
    summary: "controller samples are taken at irregular instants",
    example: "\
[controllers.force.effects.timing-jitter]
sigma = \"0.1 ms\"
",
    sections: "\
## Model
Sample `i` of the controller is taken at `offset + i period + w_i`. The error `w_i` is normally distributed
with standard deviation `sigma`, and independent from sample to sample. It is limited to 0.49 of the period,
so that samples keep their order; no sample is before zero. If `sigma` exceeds a fifth of the period, the root
mean square is therefore smaller than `sigma`. The controller computes as if the grid were exact, and its
output follows `delay` after the sample. With the controller's own `jitter`, the squares of both add.

## Where it comes from
Operating systems that are not real-time, shared buses, interrupts.

## How it shows
The difference of two positions is wrong by speed times the error of the interval, `sqrt(2) sigma` in the root
mean square. So a velocity has an error of `sqrt(2) sigma v / period`, which vanishes at rest. The mean delay
stays; that separates it from `command-delay`. `encoder-resolution` scatters differences as well, in slow
motion too.

## How it is recognised
Plot the scatter of position differences over speed: a straight line through zero. Or record when each sample
was taken. A diagnosis does not try it: records hold the commands that came out of the jittered loop.

## Numerical treatment
Each sample has an instant of its own, drawn from the run's seed. Every integrator ends a step there. Linear
theory assumes an even grid and lists that among its assumptions.

## Source
B. Wittenmark, J. Nilsson and M. Törngren, Timing problems in real-time control systems, American Control
Conference (1995).
",
    law: LawDrawing {
        axes: ["sample", "sampling instant"],
        start: 0.0,
        with: &[
            Curve::Points(&[(0.08, 0.15), (0.12, 0.15)]),
            Curve::Points(&[(0.28, 0.24), (0.32, 0.24)]),
            Curve::Points(&[(0.48, 0.56), (0.52, 0.56)]),
            Curve::Points(&[(0.68, 0.63), (0.72, 0.63)]),
            Curve::Points(&[(0.88, 0.94), (0.92, 0.94)]),
            // A bar from the grid, at the fourth sample.
            Curve::Points(&[(0.7, 0.63), (0.7, 0.7)]),
        ],
        without: &[Curve::Points(&[(0.0, 0.0), (1.0, 1.0)])],
        labels: &[(0.72, 0.5, "sigma")],
    },
    traits: &[],
    change: Change::SampleJitter(|values| TimingJitter::of(values).sigma),
};
