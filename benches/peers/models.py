"""M1, M2 and M4 as matrices: x' = A x + B u + C f, with compression d = D x."""

import numpy as np

PERIOD_S = 1e-3
START_M = -5e-3
CONTACT_N_PER_M = 1e5
CONTACT_N_S_PER_M = 100.0
# Largest contact force on a grid of 0.1 ms, from event-located exact integration outside this
# project, checked against DOP853 and Radau at 1e-11.
PEAK_N = {
    "M1": 140.26950413170414,
    "M2": 142.27373949186986,
    "M4": 127.47205308216019,
    "loop": 129.05269184228666,
}


def command_n(force_n):
    """The sampled force controller of all three machines."""
    return min(200.0, max(-200.0, 20.0 + 2.0 * (20.0 - force_n)))


class Machine:
    """Masses, and springs as (body, body or None, stiffness, damping)."""

    def __init__(self, masses, springs, driven, reaction, tip, work, start):
        n = len(masses)
        k, b = np.zeros((n, n)), np.zeros((n, n))
        for i, j, stiffness, damping in springs:
            shape = np.zeros(n)
            shape[i] = 1.0
            if j is not None:
                shape[j] = -1.0
            k += stiffness * np.outer(shape, shape)
            b += damping * np.outer(shape, shape)
        inverse = np.diag(1.0 / np.array(masses))
        across = np.zeros(n)
        across[tip] = 1.0
        if work is not None:
            across[work] = -1.0
        push = np.zeros(n)
        push[driven] = 1.0
        if reaction is not None:
            push[reaction] = -1.0
        self.a = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ k, -inverse @ b]])
        self.b = np.concatenate([np.zeros(n), inverse @ push])
        self.c = np.concatenate([np.zeros(n), -inverse @ across])
        self.d = np.concatenate([across, np.zeros(n)])
        self.rate = np.concatenate([np.zeros(n), across])
        self.start = np.concatenate([np.array(start), np.zeros(n)])

    def force_n(self, x):
        """Total contact force."""
        return max(0.0, self.law_n(x)) if self.d @ x > 0 else 0.0

    def law_n(self, x):
        """Force of the contact while it pushes."""
        return CONTACT_N_PER_M * (self.d @ x) + CONTACT_N_S_PER_M * (self.rate @ x)


MACHINES = {
    "M1": Machine([10.0], [(0, None, 0.0, 50.0)], 0, None, 0, None, [START_M]),
    "M2": Machine(
        [6.0, 4.0], [(0, None, 0.0, 50.0), (1, 0, 4e5, 60.0)], 0, None, 1, None, [START_M, START_M]
    ),
    "M4": Machine(
        [200.0, 6.0, 4.0, 5.0],
        [(0, None, 1.1e6, 600.0), (1, 0, 0.0, 50.0), (2, 1, 4e5, 60.0), (3, 0, 1e6, 200.0)],
        1,
        0,
        2,
        3,
        [0.0, START_M, START_M, 0.0],
    ),
}


def row(who, method, machine, step_s, wall_s_per_simulated_s, peak_n):
    """One line of the common CSV."""
    step = "" if step_s is None else f"{step_s:g}"
    print(f'{who},"{method}",{machine},{step},{wall_s_per_simulated_s:.6e},{peak_n:.12f}', flush=True)
