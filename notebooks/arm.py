# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # A robot arm: from a URDF and a log to a better plant
#
# You have a URDF and a log of the joints, and the simulation is off. Put your own files in the place of the two below;
# [docs/arms.md](../docs/arms.md) says what a log may be. The arm here has three joints that rub; its model does not
# know.

# %%
# %matplotlib inline
import matplotlib.pyplot as plt
import numpy as np
from pydrake.systems.analysis import Simulator

from mmt_drake.arms.arm_file import load_arm_model
from mmt_drake.arms.believed import predicted
from mmt_drake.arms.deliver import arm_diagram, set_links
from mmt_drake.arms.diagnosis import diagnose_arm
from mmt_drake.arms.joint_log import load_joint_log
from mmt_drake.arms.plant import ArmPlant

believed = load_arm_model("../examples/arm.yaml")
arm = ArmPlant.of(believed)
log = load_joint_log("../examples/arm_log.csv", believed, arm.joints)
print(f"{log.duration:.0f} s of {', '.join(arm.joints)}; torque from the column {log.column}")

# %%
found = diagnose_arm([log], believed)
print(found.verdict, found.summary, sep="\n")
for effect in found.effects:
    numbers = ", ".join(f"{symbol} = {n.value:.3g} {n.unit}" for symbol, n in effect.numbers.items())
    print(f"{effect.where}: {effect.name}, {numbers}; certain: {effect.certain}")

# %% [markdown]
# Torque over time, and the error over velocity: a step at zero is dry friction, a slope viscous friction. The errors
# that `found.joints` tells are those of stretches that no choice has seen.

# %%
before, after = (predicted(arm, model, log) for model in (believed, found.model))
figure, panels = plt.subplots(2, len(arm.joints), figsize=(11, 5), layout="constrained")
for j, (over_time, over_velocity) in enumerate(panels.T):
    over_time.plot(before.time, before.measured[:, j], color="0.6", label="measured")
    for name, one in (("as handed in", before), ("with what was found", after)):
        moves = one.counted[:, j]
        over_time.plot(one.time, one.predicted[:, j], linewidth=1, label=name)
        over_velocity.plot(one.velocity[moves, j], (one.measured - one.predicted)[moves, j], ".", markersize=2)
    joint = found.joints[j]
    over_time.set(title=f"{joint.name}: {joint.nominal:.2f} -> {joint.augmented:.3f}", xlabel="t [s]", xlim=(0, 8))
    over_velocity.set(xlabel="velocity [rad/s]")
panels[0, 0].set_ylabel("torque [N m]")
panels[1, 0].set_ylabel("error [N m]")
panels[0, 0].legend(fontsize="small")
plt.show()

# %% [markdown]
# The better plant is a Drake diagram: the links in the plant, the effects beside it. Let it swing from the same place
# as the plant of the URDF alone, its drives without torque.


# %%
def swing(model, seconds=4.0):
    """Position of the elbow over time, from rest."""
    diagram, plant = arm_diagram(model)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    own = plant.GetMyMutableContextFromRoot(context)
    set_links(model, plant, own)
    plant.SetPositions(own, [0.0, 1.2, 1.0])
    diagram.GetInputPort("torque").FixValue(context, np.zeros(3))
    times, angles = np.arange(0.0, seconds, 0.02), []
    for t in times:
        simulator.AdvanceTo(t)
        angles.append(plant.GetPositions(own)[2])
    return times, np.array(angles)


figure, panel = plt.subplots(figsize=(8, 2.6), layout="constrained")
for name, model in (("URDF alone", believed), ("with what was found", found.model)):
    panel.plot(*swing(model), label=name)
panel.set(xlabel="t [s]", ylabel="elbow [rad]")
panel.legend()
plt.show()

# %% [markdown]
# Keep it: `save_arm_model(found.model, "better.yaml")` of `mmt_drake.arms.arm_file`, and `write_urdf` of
# `mmt_drake.arms.deliver` where inertial numbers were found. Then record another motion, and hold the model to that.
