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
# # The thesis's open question
#
# The thesis estimates a remote object and renders the estimate's force to the operator. Its *estimated* force follows
# the measured one within about 5 %, its *rendered* force is off by up to 30 % at low and up to 100 % at high
# frequencies. It freezes the parameters after 5 s, sees the estimated force go wrong like the rendered one, and
# concludes that the renderer treats its parameters as constant; then it suspects the physics engine.
#
# 1. Why an estimated force can follow while the rendered force cannot, though both have the same parameters.
# 2. One cause at a time: which of the thesis's figures does each reproduce?
# 3. Is it the renderer, which treats its parameters as constant? Is it the physics engine?
# 4. What the hand does to an estimate.
# 5. What is settled, and what stays open.

# %%
# %matplotlib inline
# %config InlineBackend.print_figure_kwargs = {"dpi": 100}
import tempfile
from pathlib import Path

import matplotlib as mpl

from mmt_drake.analysis import figures as thesis_figures
from mmt_drake.analysis.plotting import STYLE
from mmt_drake.analysis.windows import wound_up
from mmt_drake.diagrams.experiments.ablation.causes import CAUSES
from mmt_drake.diagrams.experiments.ablation.claims import CLAIMS
from mmt_drake.diagrams.experiments.ablation.report import ablation, ablation_figure, findings, short_table
from mmt_drake.diagrams.experiments.ablation.run import verdicts_of
from mmt_drake.diagrams.experiments.engines import engines_table, run_engines
from mmt_drake.diagrams.experiments.engines.drake_methods import METHODS as DRAKE
from mmt_drake.diagrams.experiments.engines.own import METHODS as OURS
from mmt_drake.diagrams.studies import Asked
from mmt_drake.processors import processors
from mmt_drake.recording import load

mpl.rcParams.update(STYLE)
folder = tempfile.TemporaryDirectory()  # for the recordings; it goes when the kernel goes


def show(table):
    """Prints a table with its columns aligned."""
    lines = [list(table.headers), *table.texts()]
    widths = [max(len(line[i]) for line in lines) for i in range(len(table.headers))]
    for line in lines:
        print("  ".join(text.ljust(width) for text, width in zip(line, widths, strict=True)).rstrip())


# %% [markdown]
# ## 1  Following is not free running
#
# The estimated force is $\psi^T\theta$: the parameters of *now* times regressors that hold the measured force's own
# derivatives of *now*. Recursive least squares changes $\theta$ so that this one product fits. The rendered force is
# another thing: the parameters drive a model that runs by itself, and nothing of the measured force comes in. A set of
# parameters that fits the moment may be far from the object, and the estimated force does not show it.
#
# Here are eight of the causes that `mmt-drake experiment ablation` tries, by themselves: nothing; an estimator that
# solves eq. 30 without its equation for d, one that forgets, one that fits the free-running force; a renderer to whose
# contact damper the input's velocity is lost, one that is slow to take up new parameters; a hand that begins with its
# slow strokes; and the thesis's estimator as described.

# %%
names = (
    "nothing",
    "eq. 30 without d",
    "forgets after 1 s",
    "output error, not equation error",
    "velocity of the input lost",
    "parameters taken up over 5 s",
    "slow strokes first",
    "the thesis's estimator",
)
chosen = [next(cause for cause in CAUSES if cause.name == name) for name in names]
asked = Asked(Path(folder.name), seconds=24.0, jobs=processors())
cases = ablation(chosen).run(asked)
verdicts = verdicts_of(cases)
show(short_table(list(verdicts.values())))

# %% [markdown]
# The estimator that forgets, some seconds after the last fast stroke: slow strokes hold its parameters no longer. The
# estimated force (blue, late by the estimator's filters) follows all the same. The rendered force (red) has the same
# parameters at every instant, and does not: they wander, and the back-solve of eq. 30 jumps, now to its other root, now
# to none that is stable. The thesis's figures 10 and 30 show a force that follows and one that does not.

# %%
recording = load(verdicts["forgets after 1 s"].cases["running"].recording)
thesis_figures.estimated_rendered_and_measured(recording, window_s=(11.0, 17.0))

# %% [markdown]
# Freezing takes away the adaptation, and nothing else. Both forces then come from one model that stands still, and err
# alike. So figures 11 and 31 do not show that the renderer treats its parameters as constant. They show that the
# parameters of the fifth second were not the object's, and that up to then adapting had hidden it.

# %%
recording = load(verdicts["the thesis's estimator"].cases["frozen"].recording)
begin, _ = wound_up(recording)
thesis_figures.estimated_rendered_and_measured_frozen(recording, window_s=(begin - 0.5, begin + 6.0))

# %% [markdown]
# ## 2  Which cause, which figure
#
# What the thesis says of a figure is put as a condition on a run, so that anyone can disagree with it in the open:

# %%
for claim in CLAIMS:
    print(f"figure {claim.name}: {claim.says}\n    counts as reproduced where: {claim.needs}")

# %%
ablation_figure(list(verdicts.values()))

# %%
for sentence in findings(list(verdicts.values())):
    print(f"- {sentence}")

# %% [markdown]
# ## 3  The renderer? The engine?
#
# A renderer that treats its parameters as constant, or is slow to take up new ones, errs at *low* frequencies and is
# right at high ones (row "parameters taken up over 5 s"). That is figure 14, and the opposite of figures 24 to 28,
# which the explanation was made for.
#
# Appendix E tests engines at 0.98 and 1.15 where 4.2 was expected, and trusts Raisim, which is off by up to 4.5 %.
# Held against the exact transfer function, no integrator loses 70 to 100 % of a force, not even Euler's (us are of
# processor time):

# %%
integrators = [method for method in DRAKE if method.name.startswith(("explicit", "runge"))]
show(engines_table(run_engines([*OURS, *integrators])))

# %% [markdown]
# MuJoCo, Bullet and DART are within 5 % as well (`mmt-drake experiment engines`), as long as they are told the input's
# velocity. Losing that is what costs 70 to 100 %: a body that is moved by setting its position stands still for the
# engine, and the contact damper is then a damper to the world. The error stays low up to 0.3 Hz and is of the order of
# the force above, as in figures 27 and 28:

# %%
recording = load(verdicts["velocity of the input lost"].cases["running"].recording)
thesis_figures.error_spectrum(recording)

# %% [markdown]
# ## 4  A poor estimate without a fault
#
# Figure 14 is poor at low and good at high frequencies. Eq. 30 without d shows that, an estimator that forgets, and a
# renderer that is slow to take up parameters. But no fault is needed. The hand of figure 8 strokes fast and then
# slowly; here it begins each touch with the slow strokes instead, and nothing else is changed:

# %%
for name in ("nothing", "slow strokes first"):
    for run in ("running", "delayed"):
        error = verdicts[name].cases[run].metrics.between_switches_error.tangential
        print(f"{name:20} {run:9}", {band: f"{100.0 * ratio:.3g} %" for band, ratio in error.items()})

# %% [markdown]
# The estimated force follows even better than before. How good the parameters are depends on which strokes came first
# more than on most causes. The thesis's experiments 1 and 3 had different motions, so figure 14 may say more of the
# hand than of the delay.
#
# ## 5  What is settled, and what stays open
#
# Settled, as far as runs can settle it:
#
# - A good estimated force proves nothing about the parameters (figures 10, 29, 30), and freezing shows no fault of the
#   renderer (figures 11, 31). An estimator that forgets within about a second shows all of these and figure 14, with a
#   renderer that has no fault. The thesis speaks of parameters that vary, yet its eq. 4 and 5 forget nothing.
# - 800 ms are the round trip between the object's contact and the renderer's switch (figure 35), whatever else is done.
# - Figures 24 to 28, small errors up to 0.3 Hz and a plateau as high as the force, need something between the hand and
#   the rendered force: velocity lost, or an input some 50 ms late. Nothing in the estimator has that shape on this
#   motion.
# - An estimator that fits the free-running force leaves none of these errors but the round trip.
#
# Open:
#
# - Velocity lost or input late? Both show figures 24 to 28. That spikes differ in height before the parameters are
#   frozen (figure 31) speaks for the velocity: a late force has the same heights, and without velocity they differ by
#   64 % (`spikes` of `mmt-drake experiment ablation --json`). But with neither do they agree once the parameters are
#   frozen: a force that is wrong for its input is not made right by freezing. Only the thesis's code or recordings
#   could tell.
# - So no one set of causes here shows every figure at once. Two do between them, an estimator that forgets and an input
#   without velocity; whether the thesis had both, each in some of its runs, these figures cannot say.
# - The thesis gives its graphs few numbers. The conditions above are ours, read off its sentences.
