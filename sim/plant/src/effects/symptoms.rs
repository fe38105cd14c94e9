//! From what a record shows to the effects that may cause it.

/// A part of the page of all effects, as Markdown.
pub const BY_SYMPTOM: &str = "\
## Where to begin

| the machine departs | effects |
|---|---|
| by a constant force | `constant-load`, `gravity`; only in the force reading: `force-bias` |
| by one factor | `drive-gain`, `loop-gain`, `added-mass`; only in the force reading: `force-gain` |
| by a lag | `actuator-lag`, `command-delay`, `command-interpolation`; only in the force reading: \
`force-lag`, `force-delay` |
| at reversals | of speed: `coulomb-friction`, `stribeck-friction`, `lugre-friction`, `presliding`, \
`asymmetric-friction`; of force: `backlash`; of the command: `drive-deadband` |
| in fast motion | `viscous-friction`, `directional-damping`, `quadratic-drag`, `speed-table`, \
`torque-speed-line`, `slew-limit` |
| at large force | `force-limit`, `torque-speed-line`, `hardening-stiffness`, `hertz-contact` |
| at the same places | `force-ripple`, `gravity`, `hard-stop`, `force-table`, `friction-table` |
| in contact only | `contact-stiffness`, `contact-damping`, `hertz-contact`, `hunt-crossley-contact`, \
`surface-offset`; there or under a weight: `load-friction` |
| by one mode more | `transmission-flexibility`, `base-flexibility`; in contact only: `workpiece-dynamics` |
| over minutes | `thermal-derating` |
| in the force reading of free motion | at rest: `force-bias`; under acceleration: `tool-inertia` |
| by steps or scatter | `encoder-resolution`, `force-resolution`, `timing-jitter`, `command-noise` |

Frictions under one spring add up. Describe dry friction by one law, and add `load-friction` or \
`friction-table` where needed.
";
