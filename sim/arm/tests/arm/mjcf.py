"""Prints what MuJoCo makes of a model: `python3 mjcf.py MODEL Q...` at joint positions Q.

One list of numbers a line: mass matrix without armature, effort of gravity, armature, damping, friction,
then gain, damping and largest force of each actuator at its joint. Needs `pip install mujoco numpy`.
"""

import sys

import mujoco
import numpy

model = mujoco.MjModel.from_xml_path(sys.argv[1])
data = mujoco.MjData(model)
data.qpos[:] = [float(q) for q in sys.argv[2:]]
mujoco.mj_forward(model, data)
mass = numpy.empty((model.nv, model.nv))
mujoco.mj_fullM(model, data, mass)
gear = model.actuator_gear[:, 0]
armature, damping = model.dof_armature.copy(), model.dof_damping.copy()
for i, joint in enumerate(model.actuator_trnid[:, 0]):
    armature[joint] += gear[i] ** 2 * model.actuator_armature[i]
    damping[joint] += gear[i] ** 2 * model.actuator_damping[i]
mass -= numpy.diag(armature)
# The largest force at the joint while it stands at zero error, by a command at the end of its range.
most = []
for i in range(model.nu):
    ends = []
    if model.actuator_forcelimited[i]:
        ends.append(abs(model.actuator_forcerange[i]).max())
    if model.actuator_ctrllimited[i] and model.actuator_biastype[i] == mujoco.mjtBias.mjBIAS_NONE:
        ends.append(abs(model.actuator_gainprm[i, 0] * model.actuator_ctrlrange[i]).max())
    most.append(min(ends, default=numpy.inf) * abs(gear[i]))
for numbers in [
    mass.ravel(),
    data.qfrc_bias,
    armature,
    damping,
    model.dof_frictionloss,
    -model.actuator_biasprm[:, 1],
    -model.actuator_biasprm[:, 2],
    most,
]:
    print(*[repr(float(x)) for x in numbers])
