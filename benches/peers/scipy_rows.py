"""SciPy's solve_ivp with events: one call per mode and controller sample.

Its documentation suggests that for systems that switch.
"""

import time

import numpy as np
from scipy.integrate import solve_ivp

from models import MACHINES, PERIOD_S, command_n, row

# Long enough to hold the largest peak, which every machine has in its first push.
SIMULATED_S = 0.1


def simulate(machine, method, rtol):
    x, pushing, peak = machine.start, False, 0.0
    modes = [machine.a, machine.a + np.outer(machine.c, 1e5 * machine.d + 100.0 * machine.rate)]

    def lift(_, x):
        return machine.law_n(x)

    def touch(_, x):
        return min(machine.d @ x, machine.law_n(x))

    for event, direction in ((lift, -1), (touch, 1)):
        event.terminal, event.direction = True, direction
    for sample in range(round(SIMULATED_S / PERIOD_S)):
        drive = machine.b * command_n(machine.force_n(x))
        t, end = sample * PERIOD_S, (sample + 1) * PERIOD_S
        grid = t + np.arange(1, 11) * 1e-4
        while end - t > 1e-12:
            matrix = modes[pushing]
            times = np.append(grid[(grid > t) & (grid < end)], end)
            run = solve_ivp(
                lambda _, x, matrix=matrix: matrix @ x + drive,
                (t, end),
                x,
                method=method,
                t_eval=times,
                rtol=rtol,
                atol=1e-3 * rtol,
                events=lift if pushing else touch,
            )
            if pushing and run.y.size:
                peak = max(peak, max(map(machine.force_n, run.y.T)))
            if run.status == 1:
                t, x, pushing = run.t_events[0][0], run.y_events[0][0], not pushing
            else:
                t, x = end, run.y[:, -1]
    return peak


for name, machine in MACHINES.items():
    for method, rtol in (("RK45", 1e-6), ("DOP853", 1e-8), ("DOP853", 1e-11)):
        begin = time.thread_time()
        peak = simulate(machine, method, rtol)
        wall = (time.thread_time() - begin) / SIMULATED_S
        row("SciPy solve_ivp", f"{method} with events, rtol {rtol:g}", name, None, wall, peak)
