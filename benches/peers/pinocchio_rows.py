"""Time of four calls of Pinocchio's articulated-body algorithm, for a step of classical Runge-Kutta of
the six-joint arm (`cargo run --release -p feeler-benches --example arm`). Needs `pip install pin`.

The calls are timed in batches on one thread, so that Python takes no part in them. The swing itself,
with the same start and steps, shows that both solve the same equations.
"""

import statistics
import time
from pathlib import Path

import numpy as np
import pinocchio

STEP_S = 1e-3
BATCH = 20_000
ROUNDS = 15

urdf = Path(__file__).parents[2] / "scenarios/arms/six-joint.urdf"
model = pinocchio.buildModelFromUrdf(str(urdf))
model.gravity.setZero()
data = model.createData()
still = np.zeros(6)


def slope(x):
    return np.concatenate([x[6:], pinocchio.aba(model, data, x[:6], x[6:], still)])


x = np.array([0.2, -1.1, 1.4, 0.3, 0.8, -0.5, 1.0, -0.6, 0.8, 1.5, -2.0, 3.0])
for _ in range(1000):
    a = slope(x)
    b = slope(x + 0.5 * STEP_S * a)
    c = slope(x + 0.5 * STEP_S * b)
    d = slope(x + STEP_S * c)
    x = x + STEP_S / 6 * (a + 2 * b + 2 * c + d)

pool = pinocchio.ModelPool(model, 1)
draw = np.random.default_rng(1)
q, v, torque = (np.asfortranarray(draw.normal(size=(6, BATCH))) for _ in range(3))
found = np.zeros_like(q, order="F")
times = []
for _ in range(ROUNDS):
    started = time.process_time()
    pinocchio.abaInParallel(1, pool, q, v, torque, found)
    times.append((time.process_time() - started) / BATCH)
print(f"four calls: {4e6 * statistics.median(times):.2f} us, {[float(f'{p:.12f}') for p in x[:6]]}")
