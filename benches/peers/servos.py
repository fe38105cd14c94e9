#!/usr/bin/env python3
"""Servos against closed forms and against MuJoCo, in one run: prints the table of docs/servos.md.

Usage: servos.py [FEELER], the binary to measure (target/release/feeler if absent).
Needs `pip install mujoco`.
"""

import csv
import math
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import mujoco
except ImportError:
    print("skipped: MuJoCo is absent; install it with `pip install mujoco`")
    sys.exit(0)

MASS, KP, KD, TARGET = 2.0, 800.0, 24.0, 0.05
DURATION = 1.0
STEPS = (2e-3, 1e-3, 5e-4)


def closed_step(t):
    omega, zeta = math.sqrt(KP / MASS), KD / (2 * math.sqrt(KP * MASS))
    damped = omega * math.sqrt(1 - zeta**2)
    return TARGET * (
        1
        - math.exp(-zeta * omega * t) * (math.cos(damped * t) + zeta * omega / damped * math.sin(damped * t))
    )


def closed_limited(t, limit=20.0):
    """Even acceleration, then the linear loop from there."""
    a = limit / MASS
    half = KD / KP
    leaves = -half + math.sqrt(half**2 - 2 * (limit / KP - TARGET) / a)
    if t < leaves:
        return 0.5 * a * t * t
    return linear_from(0.5 * a * leaves**2 - TARGET, a * leaves, t - leaves) + TARGET


def linear_from(x, v, t):
    omega, zeta = math.sqrt(KP / MASS), KD / (2 * math.sqrt(KP * MASS))
    damped, decay = omega * math.sqrt(1 - zeta**2), zeta * omega
    return math.exp(-decay * t) * (x * math.cos(damped * t) + (v + decay * x) / damped * math.sin(damped * t))


LATE = 0.02
VOLTS, OHMS, CONSTANT, RATIO = 6.0, 1.5, 0.05, 20.0
DAMPING = (RATIO * CONSTANT) ** 2 / OHMS
GRAVITY = 9.81


def closed_motor(t):
    top, rate = VOLTS / (RATIO * CONSTANT), DAMPING / MASS
    return top * (t - (1 - math.exp(-rate * t)) / rate)


PERIOD = 0.01


def sampled():
    """Positions at the samples of a loop that holds its force in between; speed by differences."""
    x = v = last = 0.0
    rows = []
    for _ in range(round(DURATION / PERIOD) + 1):
        rows.append(x)
        force = KP * (TARGET - x) - KD * (x - last) / PERIOD
        last = x
        x += v * PERIOD + force / MASS * PERIOD**2 / 2
        v += force / MASS * PERIOD
    return rows


SAMPLED = sampled()

SERVO = f'kind = "position-servo"\nkp = {KP}\nkd = {KD}\n'
POSITION = f'<position joint="axis" kp="{KP}" kv="{KD}"'
# Name, actuator of a Feeler file, its command, load on the mass, actuator of MuJoCo, closed form.
# MuJoCo delays a command by whole samples of it, and keeps one sample a step.
CASES = [
    ("step", SERVO, TARGET, 0.0, POSITION + "/>", closed_step),
    (
        "load of 19.62 N",
        SERVO,
        TARGET,
        -MASS * GRAVITY,
        POSITION + "/>",
        lambda t: closed_step(t) - MASS * GRAVITY / KP * closed_step(t) / TARGET,
    ),
    (
        "limit of 20 N",
        SERVO + "limit = 20.0\n",
        TARGET,
        0.0,
        POSITION + ' forcelimited="true" forcerange="-20 20"/>',
        closed_limited,
    ),
    (
        "target 20 ms late",
        SERVO + f"delay = {LATE}\n",
        TARGET,
        0.0,
        POSITION + f' delay="{LATE}" nsample="{{samples}}"/>',
        lambda t: closed_step(max(t - LATE, 0.0)),
    ),
    ("sampled at 100 Hz", SERVO + f"period = {PERIOD}\n", TARGET, 0.0, '<motor joint="axis"/>', None),
    (
        "motor on 6 V",
        f'kind = "dc-motor"\nresistance = {OHMS}\ntorque_constant = {CONSTANT}\ngear_ratio = {RATIO}\n',
        VOLTS,
        0.0,
        f'<dcmotor joint="axis" motorconst="{CONSTANT}" resistance="{OHMS}" gear="{RATIO}"/>',
        closed_motor,
    ),
]


def feeler(binary, actuator, command, load):
    text = f"""name = "servo"
[bodies.tip]
mass = {MASS}
[springs.guide]
between = ["ground", "tip"]
[springs.guide.effects.constant-load]
force = {load}
[actuators.servo]
on = "tip"
{actuator}
[controllers.aim]
law = "open-loop"
drives = "servo"
period = {PERIOD}
reference = {command}
[run]
duration = {DURATION}
record = ["tip.position"]
record_rate = 1000
"""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "servo.toml")
        file.write_text(text)
        done = subprocess.run([binary, "run", file, "--out", folder, "--csv"], capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stdout + done.stderr)
        with open(Path(folder, "trace.csv"), newline="") as rows:
            return [(float(row["t_s"]), float(row["tip.position"])) for row in csv.DictReader(rows)]


def peer(name, actuator, command, load, step, integrator):
    actuator = actuator.format(samples=round(LATE / step) + 1)
    model = mujoco.MjModel.from_xml_string(f"""<mujoco>
      <option timestep="{step}" gravity="0 0 {load / MASS}" integrator="{integrator}"/>
      <worldbody><body><joint name="axis" type="slide" axis="0 0 1"/>
        <geom type="sphere" size="0.1" mass="{MASS}" contype="0" conaffinity="0"/></body></worldbody>
      <actuator>{actuator}</actuator></mujoco>""")
    data = mujoco.MjData(model)
    rows, last = [], 0.0
    held = round(PERIOD / step)
    for k in range(round(DURATION / step) + 1):
        rows.append((data.time, data.qpos[0]))
        if name.startswith("sampled"):
            if k % held == 0:
                data.ctrl[0] = KP * (TARGET - data.qpos[0]) - KD * (data.qpos[0] - last) / PERIOD
                last = data.qpos[0]
        else:
            data.ctrl[0] = command
        mujoco.mj_step(model, data)
    return rows


def worst(rows, closed):
    """Largest error over the run; of the sampled loop at its samples."""
    if closed is None:
        at = {round(k * PERIOD, 6): x for k, x in enumerate(SAMPLED)}
        return max(abs(x - at[round(t, 6)]) for t, x in rows if round(t, 6) in at)
    return max(abs(x - closed(t)) for t, x in rows)


def damping_and_frequency(rows):
    """Of the swings about the target: from the first overshoot and the crossings."""
    over = [x / TARGET - 1 for _, x in rows]
    peak = max(over)
    ratio = math.log(peak)
    zeta = abs(ratio) / math.hypot(math.pi, ratio)
    crossings = []
    for (t0, x0), (t1, x1) in zip(rows, rows[1:]):
        if (x0 - TARGET) * (x1 - TARGET) < 0:
            crossings.append(t0 + (t1 - t0) * (TARGET - x0) / (x1 - x0))
    return zeta, 0.5 / (crossings[1] - crossings[0])


def main():
    binary = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parents[2] / "target/release/feeler")
    print(f"Largest error of the position against the closed form, in um (MuJoCo {mujoco.__version__}).\n")
    heads = [f"{integrator} {step * 1e3:g} ms" for integrator in ("implicitfast", "RK4") for step in STEPS]
    print("| case | Feeler | " + " | ".join(heads) + " |")
    print("|---" * (2 + len(heads)) + "|")
    for name, own, command, load, actuator, closed in CASES:
        errors = [worst(feeler(binary, own, command, load), closed)]
        for integrator in ("implicitfast", "RK4"):
            errors += [worst(peer(name, actuator, command, load, step, integrator), closed) for step in STEPS]
        print(f"| {name} | " + " | ".join(f"{error * 1e6:.3g}" for error in errors) + " |")
    print("\n| of the motion | closed form | Feeler | implicitfast 2 ms | RK4 2 ms |\n|---|---|---|---|---|")
    zeta = KD / (2 * math.sqrt(KP * MASS))
    hertz = math.sqrt(KP / MASS) * math.sqrt(1 - zeta**2) / (2 * math.pi)
    found = [damping_and_frequency(feeler(binary, SERVO, TARGET, 0.0))]
    found += [
        damping_and_frequency(peer("step", POSITION + "/>", TARGET, 0.0, 2e-3, i))
        for i in ("implicitfast", "RK4")
    ]
    print(f"| damping ratio | {zeta:.4f} | " + " | ".join(f"{z:.4f}" for z, _ in found) + " |")
    rates = " | ".join(f"{f:.4f}" for _, f in found)
    print(f"| frequency of the oscillation, Hz | {hertz:.4f} | {rates} |")
    under_load = next(closed for name, *_, closed in CASES if name.startswith("load"))
    ends = [feeler(binary, SERVO, TARGET, -MASS * GRAVITY)[-1][1]]
    ends += [
        peer("load", POSITION + "/>", TARGET, -MASS * GRAVITY, 2e-3, i)[-1][1]
        for i in ("implicitfast", "RK4")
    ]
    print(
        f"| under the load after {DURATION:g} s, mm | {under_load(DURATION) * 1e3:.4f} | "
        + " | ".join(f"{x * 1e3:.4f}" for x in ends)
        + " |"
    )


if __name__ == "__main__":
    main()
