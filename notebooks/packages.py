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
# # Beside other people's packages
#
# One recording, from the trial's own engine, in which Coulomb friction is concealed, goes to three programs: the fit
# that `diagnose` makes, [mujoco.sysid](https://mujoco.readthedocs.io) and [pysindy](https://pysindy.readthedocs.io).
# How long does each take, what does it find, and what does it say is missing? The two packages are the optional extra
# `peers`.
#
# 1. The recording, touch by touch.
# 2. The same numbers from the same start within the same bounds: this project and mujoco.sysid.
# 3. An equation by sparse regression: pysindy.
# 4. What `diagnose` says.

# %%
# %matplotlib inline
# %config InlineBackend.print_figure_kwargs = {"dpi": 100}
import contextlib
import io
import re
import time
import warnings
from dataclasses import replace

import matplotlib as mpl
import matplotlib.pyplot as plt
import mujoco
import numpy as np
import pysindy
from mujoco import sysid
from mujoco.sysid.report.sections.insights import AutomatedInsights
from scipy.signal import lfilter
from threadpoolctl import threadpool_limits

from mmt_drake.analysis.nrmse import nrmse
from mmt_drake.analysis.plotting import BLUE, GREY, RED, STYLE
from mmt_drake.analysis.signals import stretches
from mmt_drake.diagnosis.fit.hypothesis import SKEW, WIDEST, Hypothesis
from mmt_drake.diagnosis.fit.prepare import prepare, scales_of
from mmt_drake.diagnosis.fit.problem import Problem
from mmt_drake.diagnosis.fit.validate import intervals
from mmt_drake.diagrams.proof.experiments.engines.mujoco_methods import model_xml
from mmt_drake.diagrams.proof.trial.cases import draw_single
from mmt_drake.effects import LIBRARY
from mmt_drake.model_files import parse_model

mpl.rcParams.update({**STYLE, "figure.constrained_layout.use": True})
threads = threadpool_limits(1)  # one thread for all

# %% [markdown]
# ## 1  The recording
#
# Ten seconds at 500 Hz or 1 kHz. Other packages get every touch by itself: it starts at rest with the contact spring
# unstretched, as the model says.

# %%
case = draw_single(np.random.default_rng((11, 2)), "friction", "coulomb_friction", 0.8)
case = replace(case, session=replace(case.session, duration=10.0))
recording, model = case.recording(), parse_model(dict(case.nominal))
prepare([recording], model)  # compiles
began = time.process_time()
prepared = prepare([recording], model)
preparation = time.process_time() - began
track = max((t for t in prepared.problem.tracks if t.axis != "z"), key=lambda t: float(np.std(t.measured)))
problem, smoothed = Problem((track,)), track.smoothed
rate = smoothed.clock.rate_hz
begins = np.array([*([recording.time[0]] if smoothed.contact.starts_in else []), *smoothed.contact.touches])
touches = []  # first sample, time since then, stretch, velocity, force of each
for first, last in stretches(smoothed.contact.at(recording.time)):
    t, x = recording.time[first : last + 1], recording["position_y"]
    if t[-1] - t[0] >= 0.2:
        # The probe may be faster than a sample is short: where it touched lies between two of them.
        at = np.interp(begins[np.searchsorted(begins, t[0], side="right") - 1], recording.time, x)
        here = slice(first, last + 1)
        touches.append((first, t - t[0], x[here] - at, recording["velocity_y"][here], recording["force_y"][here]))
measured = np.concatenate([touch[4] for touch in touches])
(concealed,) = case.effects
print(f"{len(touches)} touches, {len(measured)} samples at {rate:g} Hz")
print(f"concealed: Fc = {concealed.parameters['Fc']:.3g} N")

# %% [markdown]
# ## 2  The same fit
#
# The project's own fit works on smoothed signals, on as many samples a second as suffice; mujoco.sysid gets the
# recording as it is, and thinned out to that rate. Time is that of the processor, everything loaded and compiled. Most
# of the project's own goes into preparing the signals, which is done once for all the fits of a diagnosis; so the fit
# is told by itself and with what it takes to prepare it.

# %%
friction = LIBRARY["coulomb_friction"]
start_friction = dict(friction.starts(scales_of(problem, model))[0])


def fit_own(free_friction):
    """Times [s] of preparation and fit, simulations, error of the recorded force, each number and half its interval."""
    hypothesis = Hypothesis(model, prepared.skew, unseen=problem.unseen)
    start = hypothesis.base()
    if free_friction:
        hypothesis = hypothesis.adding(friction)
        start = hypothesis.vector({}, {friction.name: start_friction})
    problem.residual(hypothesis.model(start), hypothesis.skew_of(start))  # compiles
    began = time.process_time()
    fitted = problem.fit(hypothesis, start)
    took = time.process_time() - began
    ci = intervals(problem, fitted)
    numbers = zip(hypothesis.free_parameters(), fitted.x, ci, strict=True)
    found = {p.symbol: (float(v), 0.5 * (high - low)) for p, v, (low, high) in numbers if p.symbol != SKEW}
    output, _ = track.replay(fitted.model, 1.0)  # to the smoothed motion, unfiltered
    simulated = np.interp(recording.time - fitted.skew, track.time, output)
    answered = np.concatenate([simulated[first : first + len(t)] for first, t, *_ in touches])
    return preparation, took, fitted.minimum.simulations, nrmse(measured, answered), found


# %% [markdown]
# In MuJoCo the object is a sliding joint that two actuators pull, one of them the contact spring and one the damper;
# the probe's recorded position and velocity are their controls. (A body moved by setting its position would lose its
# velocity.) Its dry friction is a soft constraint that creeps at rest, here as hard as a step allows: with the default
# softness 0.525 N came out as 0.582 N, and the contact spring a fifth too low.


# %%
def set_joint(attribute):
    def change(spec, parameter):
        joint = spec.joint("slide")
        if np.ndim(getattr(joint, attribute)):  # stiffness and damping are polynomials
            getattr(joint, attribute)[0] = parameter.value[0]
        else:
            setattr(joint, attribute, parameter.value[0])

    return change


def set_actuator(name, term):
    def change(spec, parameter):
        actuator = spec.actuator(name)
        actuator.gainprm[0], actuator.biasprm[term] = parameter.value[0], -parameter.value[0]

    return change


def set_mass(spec, parameter):
    spec.body("object").mass = parameter.value[0]


MODIFIERS = {"m": set_mass, "k1": set_joint("stiffness"), "b1": set_joint("damping"), "Fc": set_joint("frictionloss")}
MODIFIERS |= {"k2": set_actuator("spring", 1), "b2": set_actuator("damper", 2)}


def sequences(every):
    """All touches in the toolbox's own terms, every so manieth sample of them."""
    step = every / rate
    spec = mujoco.MjSpec.from_string(model_xml(model.parameters, step))
    compiled = spec.compile()
    names, states, controls, sensors = [], [], [], []
    for number, (_, t, stretch, velocity, force) in enumerate(touches, 1):
        names.append(f"touch {number}")
        states.append(sysid.create_initial_state(compiled, np.zeros(1), np.zeros(1)))
        control = np.column_stack([stretch, velocity])[::every]
        controls.append(sysid.TimeSeries.from_control_names(t[::every], control, compiled))
        # Sensors are read before a step and stamped with the time after it.
        sensors.append(sysid.TimeSeries.from_names(t[::every] + step, -force[::every, np.newaxis], compiled))
    return sysid.ModelSequences("box", spec, names, states, controls, sensors)


def fit_sysid(free_friction, every):
    """The same as `fit_own`, and what the toolbox's report says."""
    free = sysid.ParameterDict()
    for symbol, modifier in MODIFIERS.items():
        if value := getattr(model.parameters, symbol):
            free.add(sysid.Parameter(symbol, value, value / WIDEST, value * WIDEST, modifier=modifier))
    if free_friction:
        most = float(np.abs(measured).max())
        free.add(sysid.Parameter("Fc", start_friction["Fc"], 0.0, most, modifier=MODIFIERS["Fc"]))
    began = time.process_time()
    residual, simulations = sysid.build_residual_fn(models_sequences=[sequences(every)], n_threads=1), 0
    prepared_in = time.process_time() - began

    def counted(x, parameters, **options):
        nonlocal simulations
        simulations += 1 if x.ndim == 1 else x.shape[1]
        return residual(x, parameters, **options)

    residual(free.as_vector(), free)  # loads what is loaded late
    with contextlib.redirect_stdout(io.StringIO()):  # it prints a line for every step
        began = time.process_time()
        found, optimum = sysid.optimize(initial_params=free, residual_fn=counted, verbose=False)
        took = time.process_time() - began
    residuals, simulated, known = residual(found.as_vector(), found, return_pred_all=True)
    _, halves = sysid.calculate_intervals(residuals, optimum.jac)
    forces = (np.concatenate([touch[0].data.ravel() for touch in part]) for part in (known, simulated))
    insights = AutomatedInsights("Automated Insights", found).get_context()["insights"]
    says = re.sub(r"<[^>]*>", "", " ".join(f"{entry['title']}: {entry['message']}" for entry in insights))
    numbers = {n: (float(found[n].value[0]), float(half)) for n, half in zip(found.keys(), halves, strict=True)}
    return prepared_in, took, simulations, nrmse(*forces), numbers, says


# %%
thinned = max(1, int(rate / smoothed.rate_hz + 1e-9))
fits = {}
for free_friction in (False, True):
    fits["mmt_drake", smoothed.rate_hz, free_friction] = (*fit_own(free_friction), "")
    for every in dict.fromkeys((1, thinned)):
        fits["mujoco.sysid", rate / every, free_friction] = fit_sysid(free_friction, every)
for (tool, hertz, free_friction), (before, took, simulations, error, numbers, says) in fits.items():
    print(f"{tool}, {hertz:g} samples/s, friction {'free' if free_friction else 'left out'}: ", end="")
    own_before, own, *_ = fits["mmt_drake", smoothed.rate_hz, free_friction]
    ratios = f"{took / own:.3g} and {(before + took) / (own_before + own):.3g} times ours; "
    print(f"{took:.3g} s, prepared in {before:.3g} s, {ratios if tool != 'mmt_drake' else ''}", end="")
    print(f"{simulations} simulations, error {error:.3g}; ", end="")
    print(", ".join(f"{symbol} {value:.4g} ± {half:.2g}" for symbol, (value, half) in numbers.items()))
    print(f"  {says}" if says and not free_friction else "", end="\n" if says and not free_friction else "")

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(8.0, 2.6), sharey=True)
free = {f"{tool}, {hertz:g} Hz": fit for (tool, hertz, friction_free), fit in fits.items() if friction_free}
before, took = ([fit[i] for fit in free.values()] for i in range(2))
left.barh(list(free), took, left=before, color=[BLUE, RED, RED][: len(free)])
left.barh(list(free), before, color=GREY)
left.set(xlabel="processor time [s], of preparation in grey")
found = [fit[4]["Fc"] for fit in free.values()]
right.errorbar([value for value, _ in found], list(free), xerr=[half for _, half in found], fmt="o", color=BLUE)
right.axvline(concealed.parameters["Fc"], color=RED)
_ = right.set(xlabel="Coulomb friction found, 95 % [N]; line: concealed")

# %% [markdown]
# ## 3  An equation by sparse regression
#
# The body cannot be seen, so there are two ways to ask. *Equation of the force*: eliminate the body; what is left is a
# differential equation of the recorded force $f$ driven by the probe's motion. *Equation of the body*: believe in the
# model's contact spring and damper and integrate $d' = (f - k_2 d)/b_2$; then the body is where the probe is less $d$.
# Every term stands over its RMS, so that one threshold suits all; of the thresholds tried, the fewest terms whose error
# on the last third of every touch is within 5 % of the least are taken.

# %%
signs = {"sgn": np.sign, "drag": lambda z: z * np.abs(z), "cube": lambda z: z**3, "one": np.ones_like}
EQUATIONS = {
    "f''": [("f'", "f'"), ("f", "f"), ("x", "x"), ("v", "v"), ("a", "a"), ("j", "j"), ("sgn v", "v", "sgn")],
    "v_m'": [("v_m", "v_m"), ("f", "f"), ("x_m", "x_m"), ("sgn v_m", "v_m", "sgn"), ("v_m|v_m|", "v_m", "drag")],
}
EQUATIONS["f''"] += [("v|v|", "v", "drag"), ("f^3", "f", "cube"), ("1", "f", "one")]
EQUATIONS["v_m'"] += [("d^3", "d", "cube"), ("1", "f", "one")]


def signals_of(first, last):
    """Signals of one touch, where filtered ones can be trusted."""
    h, p, touch = 1.0 / smoothed.rate_hz, model.parameters, slice(first, last + 1)
    x, v, f = smoothed.input[touch, 1], smoothed.input_rate[touch, 1], -smoothed.output[touch, 1]
    s = {"x": x - x[0], "v": v, "a": np.gradient(v, h), "f": f, "f'": np.gradient(f, h)}
    s |= {"j": np.gradient(s["a"], h), "f''": np.gradient(s["f'"], h)}
    pole = np.exp(-p.k2 / p.b2 * h)
    d = lfilter([(1.0 - pole) / p.k2], [1.0, -pole], f)
    v_m = v - (f - p.k2 * d) / p.b2
    s |= {"d": d, "x_m": s["x"] - d, "v_m": v_m, "v_m'": np.gradient(v_m, h)}
    trusted = stretches(smoothed.weight[touch] > 0.0)
    return [{name: values[a : b + 1] for name, values in s.items()} for a, b in trusted if b - a >= 30]


def rms(values):
    return np.sqrt(np.mean(values**2, axis=0))


def sparsest(name):
    """Coefficients of an equation's terms in SI units, and its error on what was held out."""
    parts = [part for stretch in stretches(smoothed.in_contact) for part in signals_of(*stretch)]
    terms = [[signs[law[0]](s[signal]) if law else s[signal] for _, signal, *law in EQUATIONS[name]] for s in parts]
    columns, rates = [np.column_stack(each) for each in terms], [s[name] for s in parts]
    size, size_of_rate = rms(np.concatenate(columns)), rms(np.concatenate(rates))
    columns, rates = [c / size for c in columns], [r / size_of_rate for r in rates]
    early = [slice(0, 2 * len(r) // 3) for r in rates]
    late = np.concatenate([c[e.stop :] for c, e in zip(columns, early, strict=True)])
    true = np.concatenate([r[e.stop :] for r, e in zip(rates, early, strict=True)])
    tried = []
    for threshold in np.geomspace(0.01, 0.6, 20):
        # The terms are computed already: the first is the state, the others are inputs, taken as they are.
        optimizer = pysindy.STLSQ(threshold=threshold, alpha=1e-6)
        sindy = pysindy.SINDy(optimizer=optimizer, feature_library=pysindy.IdentityLibrary())
        chosen = [c[e] for c, e in zip(columns, early, strict=True)]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a threshold that leaves nothing is one of those tried
            sindy.fit(
                [c[:, :1] for c in chosen],
                t=1.0 / smoothed.rate_hz,
                x_dot=[r[e, np.newaxis] for r, e in zip(rates, early, strict=True)],
                u=[c[:, 1:] for c in chosen],
            )
        coefficients = np.asarray(sindy.coefficients())[0]
        tried.append((coefficients, rms(late @ coefficients - true) / rms(true)))
    least = min(error for _, error in tried)
    good = [one for one in tried if one[1] <= 1.05 * least]
    coefficients, error = min(good, key=lambda one: (np.count_nonzero(one[0]), one[1]))
    return coefficients * size_of_rate / size, error


for name, terms in EQUATIONS.items():
    coefficients, error = sparsest(name)
    equation = " ".join(f"{c:+.3g} {text}" for (text, *_), c in zip(terms, coefficients, strict=True) if c)
    print(f"{name} = {equation}; off by {100.0 * error:.2g} % on data held out")

# %% [markdown]
# A term of `sgn v` is Coulomb friction; every other one that the model has not is a law that is not there.
#
# ## 4  What `diagnose` says

# %%
from mmt_drake.diagnosis.diagnose import diagnose

diagnosis = diagnose([recording], model).diagnosis
print(f"{diagnosis.verdict}: {diagnosis.summary}")
