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
# # Set-up 4: three objects, one carried over another
#
# A sponge, a brick and a roll stand on a table under a simulated depth camera. The network takes 400 ms each way, with
# jitter. The hand pushes each, comes back to the sponge, lifts it over the brick and puts it down, and touches brick
# and roll again. One run of a minute; all below is read from its recording. How it works:
# [docs/scene.md](../docs/scene.md) and [docs/carrying.md](../docs/carrying.md).

# %%
# %matplotlib inline
# %config InlineBackend.print_figure_kwargs = {"dpi": 100}
import tempfile
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt
from matplotlib.patches import Circle, Rectangle

from mmt_drake.analysis.carried import carried_object
from mmt_drake.analysis.plotting import GREEN, ORANGE, RENDERED, SKY, STYLE
from mmt_drake.analysis.signals import delayed, vector
from mmt_drake.diagrams.proof.experiments.scene import latest, visits_of
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.model.scene_layout import SeenState
from mmt_drake.recording import load

mpl.rcParams.update({**STYLE, "figure.constrained_layout.use": True})
scenario = load_scenario("setup4")
with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "run.mcap"
    build_station(scenario, record=file).simulate()
    run = load(file)
time, delay = run.time, scenario.to_telerobot.playout
things = scenario.several.things
colours = dict(zip(things, (SKY, ORANGE, GREEN), strict=True))

# %% [markdown]
# ## Where they went
#
# From above: outlines at the start and, filled, at the end; lines are the ways of their middles. The sponge goes
# through the air over the brick. Dots are where the camera's scene had each, once a second.

# %%
figure, axes = plt.subplots(figsize=(7.0, 4.6))
for i, (name, thing) in enumerate(things.items()):
    x, y = (1e3 * run[f"places_{i + 1}_{axis}"] for axis in "xy")
    wide, deep = (1e3 * side for side in thing.size[:2])
    for k, filled in ((0, False), (-1, True)):
        looks = {"fill": filled, "alpha": 0.4 if filled else 1.0, "color": colours[name]}
        if thing.round:
            axes.add_patch(Circle((x[k], y[k]), 0.5 * wide, **looks))
        else:
            axes.add_patch(Rectangle((x[k] - 0.5 * wide, y[k] - 0.5 * deep), wide, deep, **looks))
    axes.plot(x, y, color=colours[name], label=name)
    seen = np.flatnonzero(run[f"scene_{i + 1}_thing"] > 0.0)[::1000]
    axes.plot(1e3 * run[f"scene_{i + 1}_x"][seen], 1e3 * run[f"scene_{i + 1}_y"][seen], ".", color="0.2", markersize=3)
axes.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
_ = axes.legend(frameon=False, loc="upper left")

# %% [markdown]
# Every identity was kept, and of the sponge it was told that it was carried:

# %%
identities_kept = {}
for i, name in enumerate(things):
    identities = sorted({int(each) for each in run[f"scene_{i + 1}_thing"]} - {0})
    identities_kept[name] = len(identities) == 1
    states = [SeenState(int(each)).name.lower() for each in np.unique(run[f"scene_{i + 1}_state"]) if each]
    print(f"{name}: identity {identities}, {', '.join(states)}")

# %% [markdown]
# ## A first touch, and a second
#
# Of an object that nobody has touched only a guess from its size is felt. At the second touch it is remembered: the
# force is right before the telerobot is there. Errors of the force along x and y, in the first half second and in all
# of the touch, which of the sponge's second has the carrying in it:

# %%
for visit in visits_of(run, scenario):
    which = "second" if visit.before else "first"
    print(f"{visit.object:7s}{which:7s} touch: {100 * visit.first:5.1f} % at first, {100 * visit.whole:5.1f} % in all")
print(f"touch and release are told within {1e3 * latest(run, delay):.0f} ms of the truth")

# %% [markdown]
# ## Carried
#
# The operator's copy of the sponge is lifted by the operator's own hand; what is felt is shown beside what the plant
# does 400 ms later. Its centre is first believed in the middle of the height that the camera sees, then told.

# %%
felt, true = delayed(vector(run, "rendered_force"), delay, scenario.step), vector(run, "true_force")
shown = (time > 27.0) & (time < 37.5)
figure, panels = plt.subplots(4, 1, figsize=(8.0, 7.0), sharex=True)
panels[0].plot(time[shown], 1e3 * run["body_height"][shown], color=GREEN)
panels[0].set_ylabel("height [mm]")
for panel, axis in zip(panels[1:3], (0, 2), strict=True):
    panel.plot(time[shown], true[shown, axis], color=GREEN, linewidth=2.0, label="the object's")
    panel.plot(time[shown], felt[shown, axis], color=RENDERED, linewidth=0.8, label="rendered")
    panel.set_ylabel(f"along {'xyz'[axis]} [N]")
panels[1].legend(frameon=False, ncols=2, loc="upper left")
panels[3].plot(time[shown], 1e3 * run["carried_m"][shown], color=RENDERED, label="mass [g]")
panels[3].plot(time[shown], 1e3 * run["carried_centre"][shown], color=GREEN, label="centre below the grip [mm]")
panels[3].legend(frameon=False, ncols=2, loc="center left")
panels[3].set(ylabel="told", xlabel="time [s]")
carried = carried_object(run, delay)
print(carried.line())
print(f"in truth {things['sponge'].object.parameters.m:.3f} kg, {1e3 * things['sponge'].centre:.1f} mm")
