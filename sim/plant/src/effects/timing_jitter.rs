//! `timing-jitter`: controller samples deviate from the grid.

use super::{Change, Curve, Definition, HostKind, Law, Parameters, Place};
use crate::units::Dimension;

parameters! { TimingJitter
    sigma: log(Dimension::TIME, Some(0.0), 5e-5, (0.0, 1.0), "one standard deviation of the sample times"),
}

pub(super) static DEFINITION: Definition = Definition {
    kind: TimingJitter::KIND,
    name: "timing-jitter",
    place: Place::Timing,
    hosts: &[HostKind::Controller],
    site: "",
    parameters: TimingJitter::PARAMETERS,
    summary: "controller samples are taken off the grid",
    documentation: "\
## Example
```toml
[controllers.force.effects.timing-jitter]
sigma = \"0.1 ms\"
```
`feeler run scenarios/effects/timing-jitter.toml` runs it.

## Model
Sample `i` of the controller is taken at `i period + w_i`, `w_i` normally distributed with standard deviation
`sigma`. The controller computes as if the grid were exact. `w_i` is limited to 0.49 of the period, so that
samples keep their order.

## Where it comes from
Operating systems that are not real-time, shared buses, interrupts.

## How it shows
Differences of positions scatter in proportion to speed, so noise grows in fast motion and vanishes at rest.
The mean delay stays, which separates it from `command-delay`. `encoder-resolution` scatters differences as
well, at any speed.

## How it is recognised
Plot the scatter of position differences against speed: it grows in proportion and vanishes at rest.

## Numerical treatment
Each sample has its own instant, drawn from the run's seed, and is met exactly. Linear theory assumes an
even grid and says so.

## Source
B. Wittenmark, J. Nilsson and M. Törngren, Timing problems in real-time control systems, American Control
Conference (1995).
",
    law: Law {
        axes: ["sample", "time at which it is taken"],
        start: 0.0,
        with: &[Curve::Points(&[
            (0.0, 0.1),
            (0.2, 0.17),
            (0.4, 0.46),
            (0.6, 0.51),
            (0.8, 0.84),
            (0.9, 0.88),
        ])],
        without: &[Curve::Points(&[(0.0, 0.0), (0.9, 0.9)])],
    },
    traits: &[],
    change: Change::SampleJitter(|values| TimingJitter::of(values).sigma),
};
