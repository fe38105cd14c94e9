"""Drake: the same equations as symbolic expressions, evaluated and stepped in C++.

The contact force is sampled and held in the same diagram.
"""

import statistics
import time

import numpy as np
from pydrake.symbolic import Variable, if_then_else, logical_and, max as largest, min as smallest
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import SymbolicVectorSystem, VectorLogSink, ZeroOrderHold

from models import CONTACT_N_PER_M, CONTACT_N_S_PER_M, MACHINES, PERIOD_S, row

SIMULATED_S = 0.2
ROUNDS = 3


def diagram(machine, logged):
    builder = DiagramBuilder()
    n = len(machine.start)
    x = np.array([Variable(f"x{i}") for i in range(n)])
    held = Variable("held")
    u = smallest(200.0, largest(-200.0, 20.0 + 2.0 * (20.0 - held)))
    gap, rate = machine.d @ x, machine.rate @ x
    law = CONTACT_N_PER_M * gap + CONTACT_N_S_PER_M * rate
    force = if_then_else(logical_and(gap > 0, law > 0), law, 0.0)
    sparse = [
        sum(machine.a[i, j] * x[j] for j in range(n) if machine.a[i, j])
        + machine.b[i] * u
        + machine.c[i] * force
        for i in range(n)
    ]
    plant = builder.AddSystem(SymbolicVectorSystem(state=x, input=[held], dynamics=sparse, output=[force]))
    hold = builder.AddSystem(ZeroOrderHold(PERIOD_S, 1))
    builder.Connect(plant.get_output_port(), hold.get_input_port())
    builder.Connect(hold.get_output_port(), plant.get_input_port())
    sink = None
    if logged:
        sink = builder.AddSystem(VectorLogSink(1, 1e-4))
        builder.Connect(plant.get_output_port(), sink.get_input_port())
    return builder.Build(), plant, sink


def simulate(machine, scheme, step_s, logged):
    system, plant, sink = diagram(machine, logged)
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    plant.GetMyMutableContextFromRoot(context).SetContinuousState(machine.start)
    integrator = ResetIntegratorFromFlags(simulator, scheme, step_s)
    if scheme == "runge_kutta3":
        integrator.set_fixed_step_mode(True)
    simulator.Initialize()
    begin = time.thread_time()
    simulator.AdvanceTo(SIMULATED_S)
    wall = (time.thread_time() - begin) / SIMULATED_S
    return wall, sink.FindLog(context).data()[0].max() if logged else None


for name, machine in MACHINES.items():
    for scheme in ("explicit_euler", "runge_kutta2", "runge_kutta3"):
        for step_s in (1e-4, 5e-5):
            _, peak = simulate(machine, scheme, step_s, True)
            wall = statistics.median(simulate(machine, scheme, step_s, False)[0] for _ in range(ROUNDS))
            row("Drake", scheme.replace("_", " "), name, step_s, wall, peak)
