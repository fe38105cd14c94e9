//! The texts of the manual between its tables.

pub(super) const EFFECTS_INTRODUCTION: &str = "\
# Effects

```console
feeler effects
feeler effects EXAMPLE
feeler effects EXAMPLE --out out/law.svg
feeler run scenarios/effects/EXAMPLE.toml --out out/friction
```

![law of EXAMPLE](images/effects/EXAMPLE.svg)

An effect is a departure from the ideal machine. It sits under the element that it disturbs. This page
is generated from the library, as is the output of `feeler effects KIND`. Words: [glossary](glossary.md).

Each drawing shows the law of an effect in outline, without numbers, and names its main parameters. The
solid line is the machine with the effect, the dashed line the machine without it. A drawing without a
dashed line shows the effect alone.

The *missing force* is mass times acceleration, less the forces of the undisturbed machine. Among these,
the drive force is the one that the undisturbed drive would give for the recorded command. Drawings of
friction show the resistance instead, which is positive against forward motion. In a
[portrait](glossary.md#diagnosis) of the missing force they are upside down.

The column `typical` holds for a linear axis of about 10 kg that presses with 30 N, such as
`scenarios/effects/ideal.toml`. It does not hold for a rotational axis: begin with data sheets there.
Fits take step sizes and bounds from it, so a few values are chosen for the fit: the text of the effect
then says so. The unit 1 marks a plain number; an angle is in rad.

The effects under a drive act in this order: `command-noise`, `command-delay`, `drive-deadband`,
`drive-gain` and `loop-gain`, `force-limit`, `slew-limit` and `command-interpolation`, `actuator-lag`,
`torque-speed-line`, `thermal-derating`. `force-ripple` is added last. On a velocity source, and on a
motor with a voltage or a duty cycle, the law of the drive follows the lag, and `force-limit` follows
the law. Under a position servo, noise, delay, gain, rate and interpolation act on the target, and the
deadband acts on the error. `loop-gain` scales the law of the servo. Its force then passes limit, speed
line, lag and warming; if it is sampled, the lag precedes the line.

BY-SYMPTOM

No effect describes:

- torque per current that falls at large current, or ripple that grows with the current,
- friction that changes with warmth, or with the time at rest,
- eccentricity of an encoder, or vibration of the floor.

A diagnosis then answers `unknown-cause`, or names the effect that comes nearest. For a wrong scale or delay
of a sensor, state its keys `gain` and `delay` instead.
";

pub(super) const INTRODUCTION: &str = "\
# File keys and effects

```console
feeler check scenarios/chatter/sustained.toml
feeler run scenarios/chatter/sustained.toml --out out/sustained
```

![What a file of these keys makes](images/sustained.png)

This page is generated from the declarations that the parser reads; a test compares both. A machine
file in full is in the [tutorial](tutorials/tune.md#the-machine). Words: [glossary](glossary.md).

Files are TOML. A plain number is SI. A text has a unit, as in `\"1.2 kN/mm\"`, `\"5 mm\"`,
`\"12 N s/m\"`, `\"1 kHz\"`, `\"2 deg\"`, `\"10 %\"`.

- Units are products of g, m, s, min, Hz, N, J, W, A, V, ohm, H, rad, deg, rpm with the
  prefixes n, u, m, c, k, M, G.
- Factors are separated by a space, `*` or `·`. Powers are written `m2` or `m^2`.
- There is at most one `/`. Put a denominator of several factors in parentheses.
- If two units are given below, the one in parentheses is for a rotational axis.

In the tables, the bounds of a number follow its unit. A dash in the column `default` means: absent unless
given.

## Signals

A signal is named `element.quantity`, as in `motor.position`.

| element | quantities |
|---|---|
| body | `position`, `velocity`, `acceleration` |
| contact | `force` (in total), `spring_force` (its elastic part), `compression`, `contact` (1 or 0) |
| contact | `gap` (distance along the axis, negative under compression), `gap_rate` |
| its `surface` | `point_x`, `point_y`, `point_z`: where the tip meets the workpiece along the axis |
| its `surface` | `normal_x`, `normal_y`, `normal_z`: unit vector there, from tip into workpiece |
| spring | `force`, `spring_force` |
| actuator | `command`, `force`; `position`, `velocity` of its body against the one that it reacts on |
| position servo | `target` (its command) |
| motor | `voltage` (its command, if that is one), `current` (as it flows) |
| sensor | `reading` |
| controller | `output`, `reference` |

Points and normals are in the frame in which `surface` places the shapes.
";

/// The discrete PID, motion signals and filters of `sim/control/src`.
pub(super) const DISCRETE: &str = "
### How a controller is discretised

A controller runs once per `period` T. Its output is held until the next sample. `[n]` is the value
at sample n.

| part | on paper | as it runs |
|---|---|---|
| integral | `ki / s` | `i[n] = i[n-1] + ki T e[n]`: the error of this sample is part of it |
| derivative | `kd s / (tau s + 1)`, tau = `derivative_filter` \
| `d[n] = (tau d[n-1] + e[n] - e[n-1]) / (tau + T)`, times `kd` (backward Euler) |
| velocity of a position sensor | `s / (tau s + 1)`, tau = `velocity_filter` \
| `v[n] = (tau v[n-1] + x[n] - x[n-1]) / (tau + T)`; 0 at the first sample |
| position of a velocity sensor | `1 / s` | `x[n] = x[n-1] + T (v[n] + v[n-1]) / 2`; 0 at the first sample |
| `low_pass` of a controller, first order | `1 / (1 + s / w)` \
| bilinear transform, prewarped at the corner: -3 dB exactly there |
| `low_pass` of a controller, second order | `w^2 / (s^2 + 2 zeta w s + w^2)` \
| bilinear transform, prewarped at the natural frequency |
| `notch` | `(s^2 + 2 d zeta w s + w^2) / (s^2 + 2 zeta w s + w^2)`, `d` its depth \
| bilinear transform, prewarped at its frequency: its depth exactly there |
| `lead` | `(1 + s / w_z) / (1 + s / w_p)` \
| bilinear transform `s = (2 / T) (1 - z^-1) / (1 + z^-1)`, not prewarped: \
the gain at half the sampling rate is exactly pole over zero |

The `low_pass` of a sensor is analogue: it is part of the machine and integrated with it. The
integral and the derivative begin at zero, at the first sample and at the first one after an
approach. A filter begins at its steady state for the present input.
";

/// The words in capitals stand for lists of effects.
pub(super) const CELL_TEXT: &str = "\
With `arm = ...` in a machine file, `feeler run` simulates the whole arm, with flexible joints, against
a workpiece in space ([arms.md](arms.md)). It has the tables below, and these of an axis:

- `[contacts.NAME]`, exactly one: the law between tip and workpiece, which only pushes. It takes no
  `between`, `engagement`, `surface` or `profile`. `gap` moves the surface farther away. Effects:
  CONTACT-EFFECTS.
- `[sensors.NAME]` that read the contact's `force` or `spring_force`: what a wrist sensor measures
  against the normal. It may have every effect of a force sensor except SENSOR-EXCEPTIONS.
- `[sensors.NAME]` that read `motor.position` or `motor.velocity`: the tool's travel along the normal
  from its start, or its rate, from the joints' encoders. One of these, `encoder`, always exists.
- `[controllers.NAME]`, exactly one, without `drives`. Its output is a force along the normal, which
  the transposed Jacobian turns into joint torques.
- `[run]`: `duration`, `step` (the longest step; by default from the fastest mode), `seed`, and
  `record_rate` (1 kHz by default).

Lengths and speeds of the tables below are in m and m/s: units in parentheses do not apply. A height
field rises along its own -x and turns with the workpiece.";
