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
# # Inside set-up 1
#
# What [setup1.ipynb](setup1.ipynb) takes for granted: how an estimate becomes parameters and why there are two sets of
# them, that the simulated object has the transfer function that it should, how contact is found in a cloud, and how a
# renderer of one's own goes beside the shipped one. "Eq." and "figure" are the thesis's.

# %%
# %matplotlib inline
# %config InlineBackend.print_figure_kwargs = {"dpi": 100}
import tempfile
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from mmt_drake.analysis import charts, figures
from mmt_drake.analysis.metrics import measure
from mmt_drake.analysis.plotting import BLACK, BLUE, GREEN, GREY, ORANGE, RED, SKY, STYLE, WIDTH_IN
from mmt_drake.diagrams.stations.hands import Scripted
from mmt_drake.diagrams.stations.scenario import load_scenario
from mmt_drake.diagrams.stations.station import build_station
from mmt_drake.recording import load

mpl.rcParams.update({**STYLE, "figure.constrained_layout.use": True})
folder = tempfile.TemporaryDirectory()  # for the recordings; it goes when the kernel goes

# %% [markdown]
# One run, with strokes that touch, slide and lift three times in 20 s, and an estimator that waits 0.2 s after each
# touch:

# %%
thesis = replace(load_scenario("setup1"), operator=Scripted("strokes", {"duration": 20.0}), duration=20.0)
settle = replace(thesis, estimator=replace(thesis.estimator, settle=0.2))
simulator = build_station(settle, record=Path(folder.name) / "settle.mcap").simulate()
recording = load(Path(folder.name) / "settle.mcap")

# %% [markdown]
# ## 1  Eq. 30 and its twins
#
# The estimator finds seven numbers a ... g, of which a ... f are six equations for the five unknowns m, k1, k2, b1, b2,
# and g then gives Fc. `back_solve` takes all of them by least squares, or leaves one out, and reports every root.
#
# First the truth, regrouped exactly:

# %%
from mmt_drake.model.regrouping import EQUATIONS, back_solve, regroup

HEADER = f"{'':22}{'m':>9}{'k1':>9}{'k2':>9}{'b1':>9}{'b2':>9}{'misfit':>10}"


def row(name, root):
    numbers = "".join(f"{value:9.3f}" for value in (root.m, root.k1, root.k2, root.b1, root.b2))
    return f"{name:22}{numbers}{root.misfit:10.1e}"


design = back_solve(regroup(m=1.0, k1=0.0, k2=500.0, b1=60.0, b2=60.0, Fc=0.05), normal_k=500.0)
(twin,) = design.others
print(HEADER, row("chosen", design.chosen), row("twin", twin), sep="\n")

# %% [markdown]
# Both roots satisfy all six equations, because they are one and the same transfer function. The probe feels the contact
# spring K = k2 + b2 s and the body B + M = b1 s + k1 + m s² in series, H = K (M + B) / (M + B + K). Its zeros are those
# of both, and the force does not tell whose is which. Here they are 0, -k2/b2 = -8.3 and -b1/m = -60 rad/s. The twin
# gives 0 to the contact (k2 = 0) and the other two to the body, 1.16 (s + 8.3) (s + 60). That the poles come out the
# same as well is owed to k1 = 0 and b1 = b2.

# %%
from mmt_drake.model.linear import transfer_function

hertz = np.geomspace(0.05, 30.0, 300)
figure = Figure(figsize=(WIDTH_IN, 4.4))
magnitude, phase = figure.subplots(2, sharex=True)
for name, root, look in (
    ("chosen: k1 = 0, k2 = 500 N/m", design.chosen, {"color": BLACK, "linewidth": 3.0}),
    (f"twin: k1 = {twin.k1:.0f} N/m, k2 = 0", twin, {"color": ORANGE, "linestyle": "--"}),
):
    H = transfer_function(root, 2j * np.pi * hertz)
    magnitude.loglog(hertz, abs(H), label=name, **look)
    phase.semilogx(hertz, np.degrees(np.angle(H)), **look)
magnitude.set(ylabel="|H| [N/m]", title="Two sets of parameters, one H(s)")
phase.set(ylabel="phase [deg]", xlabel="frequency [Hz]")
magnitude.legend()
figure

# %% [markdown]
# What the force cannot decide, something else must: the object is one material, so of the admissible roots the one is
# taken whose k2 is nearest the stiffness along the normal, which eq. 8 gives. (The twin is not admissible anyway:
# without k2 there is no friction to be felt.)
#
# Now an estimate: the a ... g that the estimator of the run above has in its context at the end, solved in each way. It
# is the same estimate in every row, and predicts the same force at the estimator.

# %%
estimator = simulator.get_system().GetSubsystemByName("estimator")
context = estimator.GetMyContextFromRoot(simulator.get_context())
regrouped = estimator.GetOutputPort("regrouped").Eval(context)

print(HEADER)
for equations in EQUATIONS:
    print(row(equations, back_solve(regrouped, equations=equations, normal_k=500.0).chosen))

# %% [markdown]
# ## 2  H(s), calculated and measured
#
# The physics of `mmt_drake.model` needs no station. Here the object alone, under a hand that presses 4 mm deep and
# moves in y on a sine, in a diagram made by hand: two systems, one wire, one log.

# %%
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput

from mmt_drake.model.parameters import BoxParameters, FlexibleBoxModel
from mmt_drake.motion.analytic import AnalyticMotion, wave
from mmt_drake.systems.flexible_box import FlexibleBox
from mmt_drake.systems.scripted_operator import ScriptedOperator


def sine_response(model, hertz, amplitude=0.01):
    """-F/x of an object at one frequency [N/m, complex], by least squares over whole periods."""
    settled = 3.0
    end = settled + max(3, np.ceil(hertz)) / hertz
    sine = wave(1, 0.0, end + 1.0, amplitude, hertz)
    builder = DiagramBuilder()
    hand = builder.AddNamedSystem(
        "operator", ScriptedOperator(AnalyticMotion((0.0, 0.0, -0.004), steps=[], waves=[sine], cycle=end + 1.0))
    )
    box = builder.AddNamedSystem("environment", FlexibleBox(model, period=1e-3))
    builder.Connect(hand.GetOutputPort("motion"), box.GetInputPort("motion"))
    sink = LogVectorOutput(box.GetOutputPort("force"), builder, 1e-3)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(end)
    log = sink.FindLog(simulator.get_context())
    counts = log.sample_times() > settled
    omega_t = 2.0 * np.pi * hertz * log.sample_times()[counts]
    regressors = np.column_stack([np.sin(omega_t), np.cos(omega_t)])
    in_phase, quadrature = np.linalg.lstsq(regressors, log.data()[1, counts])[0]
    return -(in_phase + 1j * quadrature) / amplitude


slippery = FlexibleBoxModel(BoxParameters(m=1.0, k1=0.0, k2=500.0, b1=60.0, b2=60.0))
tested = np.array([0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0])
exact = transfer_function(slippery.parameters, 2j * np.pi * tested)
without_friction = np.array([sine_response(slippery, f) for f in tested])
with_friction = np.array([sine_response(thesis.environment.object, f) for f in tested])

print("   Hz   |H| exact  relative error: no friction   with friction")
for f, H, smooth, rough in zip(tested, exact, without_friction, with_friction, strict=True):
    print(f"{f:5.1f} {abs(H):11.3f} {abs(smooth / H - 1.0):28.1e} {abs(rough / H - 1.0):15.1e}")

# %%
figure = Figure(figsize=(WIDTH_IN, 4.4))
magnitude, phase = figure.subplots(2, sharex=True)
H = transfer_function(slippery.parameters, 2j * np.pi * hertz)
magnitude.loglog(hertz, abs(H), color=BLACK, label="H(s)")
phase.semilogx(hertz, np.degrees(np.angle(H)), color=BLACK)
for name, response, look in (
    ("simulated, no friction", without_friction, {"marker": "o", "color": BLUE}),
    ("simulated, friction of the thesis", with_friction, {"marker": "x", "color": RED}),
):
    magnitude.loglog(tested, abs(response), linestyle="", label=name, **look)
    phase.semilogx(tested, np.degrees(np.angle(response)), linestyle="", **look)
magnitude.set(ylabel="|H| [N/m]", title="Response to sines of 10 mm")
phase.set(ylabel="phase [deg]", xlabel="frequency [Hz]")
magnitude.legend()
figure

# %% [markdown]
# Without friction the simulation gives H(s) to better than a millionth. Friction is no part of H(s); its 0.05 N weigh
# most at low frequencies, where the object resists least.
#
# ## 3  The contact detector
#
# The telerobot knows of contact from a point cloud alone. A proxy follows the probe and is held up by the points
# (appendix C): within r1 they push it out, within r2 they mean contact, within r3 they give the normal. Below, a touch:
# left the tip and the proxy over time; right one row of the lowered cloud, and the spheres, 100 ms after the touch.
#
# The spheres would notice the surface from r2 away, so the detector takes the cloud to lie about r2 lower. Contact then
# begins where the tip passes z = 0, and the proxy rests r1 to r2 above the points: at z = 0 or up to 2 mm below.

# %%
from mmt_drake.cloud import contact_offset, plane

touch = measure(recording).touch.events_s[0]
shown = abs(recording.time - touch) < 0.12
time_ms = 1e3 * (recording.time[shown] - touch)
figure = Figure(figsize=(WIDTH_IN, 3.2))
left, right = figure.subplots(1, 2)
for name, label, color in (("position_z", "probe tip", BLUE), ("proxy_position_z", "proxy", RED)):
    left.plot(time_ms, 1e3 * recording[name][shown], label=label, color=color)
detected = recording["detected_contact"][shown] == 1.0
left.axvline(time_ms[detected][0], color=GREEN, label=f"detected after {time_ms[detected][0]:.0f} ms")
left.axhline(0.0, color=GREY, linewidth=0.8)
left.set(xlabel="time after the touch [ms]", ylabel="z [mm]", title="A touch")
left.legend()

settings, world = settle.detector, settle.environment.cloud
instant = np.searchsorted(recording.time, touch + 0.1)
body_x, body_y = (recording[f"body_position_{axis}"][instant] for axis in "xy")
surface = plane(world.points, (world.size, world.size)).moved((body_x, body_y, 0.0), recording.time[instant])
tip, proxy = recording.vector("position")[instant], recording.vector("proxy_position")[instant]
points = surface.points() - (0.0, 0.0, contact_offset(settings.r2, surface.spacing))
points = 1e3 * points[abs(points[:, 0] - proxy[0]) < surface.spacing / 2]
right.plot(points[:, 1], points[:, 2], ".", color=BLACK, markersize=3, label="points")
for radius, color in ((settings.r1, RED), (settings.r2, ORANGE), (settings.r3, SKY)):
    y, z = 1e3 * proxy[1:]
    right.add_patch(Circle((y, z), 1e3 * radius, fill=False, color=color))
    right.text(y, z + 1e3 * radius, f"{1e3 * radius:g} mm", color=color, ha="center", va="bottom")
right.plot(*(1e3 * proxy[1:]), "o", color=RED, label="proxy")
right.plot(*(1e3 * tip[1:]), "o", color=BLUE, label="tip")
right.set(xlim=(y - 18, y + 18), ylim=(-22, 13), aspect="equal")
right.set(xlabel="y [mm]", ylabel="z [mm]", title="The proxy on the cloud")
right.legend(loc="lower center", ncols=3, handlelength=1.0, columnspacing=1.0)
figure

# %% [markdown]
# ## 4  A system of your own
#
# A renderer is a LeafSystem that reads some of a renderer's ports. This one is the simplest that comes to mind: a
# spring to where the touch was, with the stiffnesses that the estimator found. Where the touch was is state, so it
# lives in the Context.

# %%
from pydrake.systems.framework import LeafSystem


class Spring(LeafSystem):
    """F = -k2 (x - x_touch) in x and y, -normal_k z along the normal: no damping, no body that slides."""

    def __init__(self):
        super().__init__()
        for name, size in (("motion", 6), ("theta", 10), ("in_contact", 1)):
            self.DeclareVectorInputPort(name, size)
        self.DeclareVectorOutputPort("force", 3, self._force)
        self.DeclareDiscreteState(4)  # where the touch was, and whether it lasts
        self.DeclarePeriodicDiscreteUpdateEvent(1e-3, 0.0, self._update)

    def _touch(self, context):
        """The state (4,), brought up to date."""
        held = context.get_discrete_state_vector().value()
        x, y, *_ = self.GetInputPort("motion").Eval(context)
        (touching,) = self.GetInputPort("in_contact").Eval(context)
        return held if touching and held[3] else np.array([x, y, 0.0, touching])

    def _force(self, context, force):
        *anchor, touching = self._touch(context)
        theta = self.GetInputPort("theta").Eval(context)  # NaN until the first estimate
        stretch = self.GetInputPort("motion").Eval(context)[:3] - anchor
        renders = touching and np.isfinite(theta).all()
        force.SetFromVector(-theta[[2, 2, 6]] * stretch if renders else np.zeros(3))

    def _update(self, context, state):
        state.get_mutable_value(0)[:] = self._touch(context)


# %% [markdown]
# A diagram is a system like any other: the whole station goes into another diagram, beside the spring, which reads
# the station's outputs.

# %%
from mmt_drake.recording import Recording

builder = DiagramBuilder()
station = builder.AddSystem(build_station(settle).diagram)
spring = builder.AddNamedSystem("spring", Spring())
for name in ("motion", "theta", "in_contact"):
    builder.Connect(station.GetOutputPort(name), spring.GetInputPort(name))
outputs = {
    "measurement": station.GetOutputPort("measurement"),
    "in_contact": station.GetOutputPort("in_contact"),
    "shipped": station.GetOutputPort("rendered_force"),
    "spring": spring.GetOutputPort("force"),
}
sinks = {name: LogVectorOutput(port, builder, settle.step) for name, port in outputs.items()}
simulator = Simulator(builder.Build())
simulator.AdvanceTo(settle.duration)
logs = {name: sink.FindLog(simulator.get_context()) for name, sink in sinks.items()}


def beside(renderer):
    """What was measured, and what one of the renderers made of it, as a recording."""
    columns = {"in_contact": logs["in_contact"].data()[0]}
    columns |= {f"force_{axis}": row for axis, row in zip("xyz", logs["measurement"].data()[6:], strict=True)}
    columns |= {f"rendered_force_{axis}": row for axis, row in zip("xyz", logs[renderer].data(), strict=True)}
    return Recording(logs[renderer].sample_times(), columns, source=renderer)


compared = {"the estimated object": beside("shipped"), "a spring": beside("spring")}
charts.error_bars({name: measure(made).rendered_error for name, made in compared.items()})

# %%
figures.measured_and_rendered(compared["a spring"], window_s=(7.0, 14.0))

# %% [markdown]
# A spring holds the hand where it touched; the object slides along. That is what m, b1 and b2 are for.
