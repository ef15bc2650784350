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
# # Set-up 1 of the thesis, step by step
#
# An operator moves a hand; a telerobot repeats the motion on a flexible object that slides on a table. An estimator
# beside the object finds its impedance (m, k1, k2, b1, b2, Fc), and only those numbers cross the network: what the
# operator feels is their model, integrated on the operator's side, without delay.
#
# SI units throughout, one frame for every vector: z up along the table's normal, the top of the object at z = 0.
# `CONVENTIONS.md` has symbols, signs, ports and columns; "eq." and "figure" are the thesis's.

# %%
# %matplotlib inline
# %config InlineBackend.print_figure_kwargs = {"dpi": 100}
import os
import tempfile
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np

from mmt_drake.analysis import charts, figures
from mmt_drake.analysis.metrics import measure
from mmt_drake.analysis.plotting import STYLE
from mmt_drake.analysis.summary import lines
from mmt_drake.recording import load

mpl.rcParams.update({**STYLE, "figure.constrained_layout.use": True})
folder = tempfile.TemporaryDirectory()  # for the recordings; it goes when the kernel goes

# %% [markdown]
# ## 1  A scenario says what is built
#
# A scenario is a YAML file that becomes a frozen dataclass. This is the shipped one; what it leaves out has defaults.

# %%
from mmt_drake.diagrams.stations.hands import Scripted
from mmt_drake.diagrams.stations.scenario import SCENARIOS, load_scenario, shipped

print("shipped:", ", ".join(shipped()))
print((SCENARIOS / "setup1.yaml").read_text())

# %% [markdown]
# `dataclasses.replace` varies it, down to any depth. Here: strokes that touch, slide and lift three times in 20 s, and
# three ways to set up the estimator.
#
# - `thesis`: the defaults, the thesis's own choices where it states them.
# - `settle`: after each touch the estimator waits 0.2 s before it learns. Its filters then still hold samples from
#   free space, which no model of the contact explains.
# - `without_d`: as `settle`, but the back-solve of eq. 30 leaves out its equation for d. The thesis does not say how it
#   solved seven equations for six unknowns; this is one way it may have been.

# %%
thesis = replace(load_scenario("setup1"), operator=Scripted("strokes", {"duration": 20.0}), duration=20.0)
settle = replace(thesis, estimator=replace(thesis.estimator, settle=0.2))
without_d = replace(settle, estimator=replace(settle.estimator, equations="without_d"))

print(thesis.estimator)
print(settle.environment.object)

# %% [markdown]
# The command line says the same with `mmt-drake run setup1 --set estimator.settle=0.2`.
#
# ## 2  A station is the scenario, wired
#
# `build_station` gives a Drake diagram. Its wires, as they really are connected, except those to the recorder:

# %%
from mmt_drake.diagrams.stations.picture import station_picture
from mmt_drake.diagrams.stations.station import build_station

station = build_station(thesis)
diagram = station.diagram
station_picture(station)

# %% [markdown]
# Systems and ports are fetched by name. Without a delay a channel is a wire, Drake's PassThrough, in a
# small diagram that names its ports.


# %%
def ports(system):
    """Names of the outputs of a system, and their sizes (0: no vector)."""
    found = (system.get_output_port(i) for i in range(system.num_output_ports()))
    return ", ".join(f"{port.get_name()} ({port.size()})" for port in found)


for name in ("operator", "to_telerobot", "environment", "detector", "estimator", "to_operator", "renderer"):
    system = diagram.GetSubsystemByName(name)
    print(f"{name:12} {type(system).__name__:20} -> {ports(system)}")
print(f"{'the diagram':12} {type(diagram).__name__:20} -> {ports(diagram)}")

# %% [markdown]
# ## 3  A run leaves a recording
#
# The loop runs at the scenario's fixed step of 1 ms. Everything that is recorded goes into one `.mcap` file with
# standard ROS 2 messages.


# %%
def run(scenario, name, operator=None):
    """Runs a scenario; gives its recording, and the simulator at the end of the run."""
    file = Path(folder.name) / f"{name}.mcap"
    simulator = build_station(scenario, record=file, operator=operator).simulate()
    return load(file), simulator


recording, simulator = run(settle, "settle")
runs = {"thesis": run(thesis, "thesis")[0], "settle": recording, "without_d": run(without_d, "without_d")[0]}

print(f"{len(recording)} samples over {recording.time[-1]:g} s, {len(recording.clouds)} clouds")

# %% [markdown]
# Each signal, its topic, and its columns in the recording:

# %%
from mmt_drake.recording.signals import signals_in

units = {"position": "m", "velocity": "m/s", "force": "N", "flag": "0 or 1", "theta": "SI"}
units |= {"code": "0 to 5", "scalar": "J"}
for signal in signals_in(recording.columns):
    unit = "m/s" if signal.name.endswith("velocity") else units[signal.quantity]
    print(f"{signal.topic:32} {unit:8} {', '.join(signal.columns)}")

# %% [markdown]
# `force_*` is the force that the environment exerts on the probe, which settles the signs:
#
# | motion | force on the probe |
# | --- | --- |
# | press down (z < 0) | `force_z` > 0 |
# | push the object along +x | `force_x` < 0 |
# | push the object along +y | `force_y` < 0 |
#
# The recording agrees. In contact the tangential force opposes the velocity most of the time: where the hand slows down
# or turns round, the body still moves on.

# %%
touching = recording["in_contact"] == 1.0
for axis in "xyz":
    force = recording[f"force_{axis}"][touching]
    if axis == "z":
        print(f"z: force_z > 0 in {np.mean(force > 0.0):.1%} of the samples in contact")
    else:
        opposes = np.sign(force) == -np.sign(recording[f"velocity_{axis}"][touching])
        print(f"{axis}: force_{axis} opposes velocity_{axis} in {np.mean(opposes):.1%} of the samples in contact")

figures.input_position(recording)

# %% [markdown]
# ## 4  The forces, and the parameters behind them
#
# Measured at the telerobot against rendered to the operator, after the wind-up: the first 5 s of contact do not count.
# The rendered force is zero until the first stable estimate has arrived.

# %%
from mmt_drake.analysis.windows import wound_up

figures.measured_and_rendered(recording, window_s=wound_up(recording))

# %%
for name, made in runs.items():
    print(name, *lines(measure(made)), sep="\n  ")

charts.error_bars({name: measure(made).rendered_error for name, made in runs.items()})

# %% [markdown]
# One object, one motion, one estimator; what differs is what it learned in the 0.2 s after each touch, and how eq. 30
# was solved. Below 0.3 Hz this motion exerts little force, so that a share of it says less there than elsewhere.
#
# The estimator's own view is psi' theta against the force that it sees, which has passed the same filters. Away from
# touches and releases it follows within a few percent. That does not make theta right:

# %%
figures.estimator_error(recording, window_s=wound_up(recording))

# %%
from mmt_drake.model.parameters import THETA

truth = dict(zip(THETA, settle.environment.object.theta(), strict=True))
charts.parameters(recording, truth=truth)

# %% [markdown]
# ## 5  With 400 ms each way
#
# The same hand over a slow network: experiment 3 of the thesis. Motion takes 400 ms to the telerobot, parameters and
# contact flag 400 ms back. To compare, the rendered force is drawn 400 ms later, beside the measured force that the
# same motion caused.

# %%
far = replace(load_scenario("setup1-delay"), operator=settle.operator, duration=20.0, estimator=settle.estimator)
slow, _ = run(far, "delay")
print(*lines(measure(slow)), sep="\n")

figures.measured_and_rendered(slow, window_s=wound_up(slow))

# %% [markdown]
# Between touches and releases the delay hardly shows: the model is local. At each of them the operator's model switches
# one round trip late, since the flag comes from the telerobot.

# %%
charts.contact_timeline(slow)

# %% [markdown]
# ## 6  A real hand
#
# Any recording with a position can be the hand: here a person's who guided a robot arm along a drawn symbol, if the
# folder of public recordings is there (`MMT_RECORDINGS`), otherwise the one that the package ships. A motion recorded
# elsewhere is placed on the table, and says how. `mmt-drake run setup1 --operator FILE` does the same.

# %%
from mmt_drake.diagrams.stations.hands import load_operator
from mmt_drake.motion.placement import place

public = Path(os.environ.get("MMT_RECORDINGS", "../../shared/recordings"))
real = public / "panda_comanipulation" / "symbol17_rec4.npz"
hand = load_operator(real if real.exists() else "builtin:hand_reaching")

print("The hand is", f"a person's, {real.name}" if real.exists() else "a model's, builtin:hand_reaching")
print(*hand.notes, *place(hand).notes, sep="\n- ")

# %%
guided, _ = run(replace(settle, duration=None), "hand", operator=hand)
print(*lines(measure(guided)), sep="\n")

figures.whole_run(guided)

# %% [markdown]
# ## 7  Where next
#
# - [setup1_inside.ipynb](setup1_inside.ipynb): eq. 30 and its twins, H(s), the contact detector, a renderer
#   of your own.
# - `mmt-drake experiment 1` and `3`: the thesis's experiments, for every way of solving eq. 30, figures and a page.
# - `mmt-drake run setup1-everything --record out.mcap`: jitter, loss, noise, other filters; the scenario file shows
#   every option. `mmt-drake convert out.mcap out.csv` for other tools.
# - `diagrams/stations/table.py` is the wiring; `mmt_drake/systems/` has one LeafSystem per file, whose docstring tells
#   size, unit and frame of each port.
# - `mmt_drake/model/` is the only place where equations of motion stand.
