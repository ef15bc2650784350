"""The flexible box in mujoco.sysid: a sliding joint that two actuators pull, one of them a spring, one a damper.

The probe's recorded position and velocity are the actuators' controls, so their force on the joint is that of the
contact spring and damper, k2 (x - x_m) + b2 (v - v_m); stiffness, damping and frictionloss of the joint are k1, b1 and
Fc. (A body moved by setting its position would lose its velocity.) Every touch is a sequence of its own that starts at
rest with the contact spring unstretched, as the model says.

Dry friction in MuJoCo is a soft constraint that creeps at rest; here it is as hard as a step allows. With the default
softness a concealed friction of 0.525 N came out as 0.582 N, and the contact spring a fifth too low. Euler's method is
MuJoCo's own choice, and here the best it has: damping taken implicitly hides (b1 + b2) / 2 of a step's worth of mass.
"""

from __future__ import annotations

import contextlib
import io
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mmt_drake.analysis.nrmse import nrmse
from mmt_drake.diagnosis.fit.hypothesis import WIDEST
from mmt_drake.diagrams.trial.peers.case import FRICTION, PeerCase
from mmt_drake.diagrams.trial.peers.extra import peer
from mmt_drake.diagrams.trial.peers.own import friction_start
from mmt_drake.diagrams.trial.peers.result import SYSID, WITH, WITHOUT, Estimate, PeerResult, Stopwatch
from mmt_drake.model.parameters import BoxParameters

Array = NDArray[np.float64]

_MODEL = """<mujoco>
<option timestep="{step}" gravity="0 0 0" integrator="Euler"><flag contact="disable"/></option>
<worldbody><body name="object">
  <inertial pos="0 0 0" mass="{m}" diaginertia="1e-3 1e-3 1e-3"/>
  <joint name="slide" type="slide" axis="0 1 0" stiffness="{k1}" damping="{b1}" frictionloss="{Fc}"
    solreffriction="{twice} 1" solimpfriction="0.99 0.999 0.001"/>
</body></worldbody>
<actuator>
  <general name="spring" joint="slide" biastype="affine" gainprm="{k2}" biasprm="0 -{k2} 0"/>
  <general name="damper" joint="slide" biastype="affine" gainprm="{b2}" biasprm="0 0 -{b2}"/>
</actuator>
<sensor><jointactuatorfrc name="force" joint="slide"/></sensor>
</mujoco>"""

Modifier = Callable[[Any, Any], None]


def model_xml(parameters: BoxParameters, step: float) -> str:
    """The object as MuJoCo's own model file, its time step in seconds."""
    values = {name: getattr(parameters, name) for name in ("m", "k1", "k2", "b1", "b2", "Fc")}
    return _MODEL.format(step=step, twice=2.0 * step, **values)


def fit_sysid(case: PeerCase, *, friction: bool, every: int = 1) -> PeerResult:
    """Fit the model's parameters with the settings that mujoco.sysid comes with, but on one thread.

    Args:
        case: to be fitted.
        friction: whether Coulomb friction, which the model lacks, is free too.
        every: takes every so manieth sample; MuJoCo's time step is the interval between those taken.

    Raises:
        MissingDependency: the extra `peers` is not installed.
    """
    sysid = peer("mujoco.sysid")
    toolbox = _Toolbox(sysid, case, every)
    parameters = toolbox.parameters(friction)
    counted = _Counted(sysid.build_residual_fn(models_sequences=[toolbox.sequences()], n_threads=1))
    counted(parameters.as_vector(), parameters)  # loads what is loaded late
    counted.simulations = 0
    with contextlib.redirect_stdout(io.StringIO()), Stopwatch() as taken:  # it prints a line for every step
        found, optimum = sysid.optimize(initial_params=parameters, residual_fn=counted, verbose=False)
    simulations = counted.simulations
    residuals, simulated, measured = counted(found.as_vector(), found, return_pred_all=True)
    _, halves = sysid.calculate_intervals(residuals, optimum.jac)
    estimates = {
        name: Estimate(float(found[name].value[0]), float(half))
        for name, half in zip(found.keys(), halves, strict=True)
    }
    forces = (np.concatenate([touch[0].data.ravel() for touch in part]) for part in (measured, simulated))
    return PeerResult(
        tool=SYSID,
        version=version("mujoco"),
        setting=WITH if friction else WITHOUT,
        rate_hz=case.rate_hz / every,
        seconds=taken.seconds,
        cpu_seconds=taken.cpu_seconds,
        simulations=simulations,
        estimates=estimates,
        error=nrmse(*forces),
        says=_insights(found),
    )


@dataclass
class _Counted:
    """A residual function of the toolbox that counts simulations; it is given one vector, or several as columns."""

    residual: Callable[..., Any]
    simulations: int = 0

    def __call__(self, x: Array, parameters: Any, **options: Any) -> Any:
        self.simulations += 1 if x.ndim == 1 else x.shape[1]
        return self.residual(x, parameters, **options)


@dataclass(frozen=True)
class _Toolbox:
    """A case in the toolbox's own terms."""

    sysid: Any
    case: PeerCase
    every: int

    @property
    def step(self) -> float:
        """[s]"""
        return self.every / self.case.rate_hz

    def sequences(self) -> Any:
        """All touches."""
        sysid, mujoco = self.sysid, peer("mujoco")
        spec = mujoco.MjSpec.from_string(model_xml(self.case.model.parameters, self.step))
        model = spec.compile()
        names, states, controls, sensors = [], [], [], []
        for number, touch in enumerate(self.case.touches, 1):
            t = touch.time[:: self.every]
            control = np.column_stack([touch.stretch, touch.velocity])[:: self.every]
            force = -touch.force[:: self.every, np.newaxis]
            names.append(f"touch {number}")
            states.append(sysid.create_initial_state(model, np.zeros(1), np.zeros(1)))
            controls.append(sysid.TimeSeries.from_control_names(t, control, model))
            # Sensors are read before a step and stamped with the time after it.
            sensors.append(sysid.TimeSeries.from_names(t + self.step, force, model))
        return sysid.ModelSequences("box", spec, names, states, controls, sensors)

    def parameters(self, friction: bool) -> Any:
        """What is free, within the bounds of the project's own fit."""
        own = self.case.model.parameters
        free = self.sysid.ParameterDict()
        for symbol, modifier in _MODIFIERS.items():
            value = getattr(own, symbol)
            if value != 0.0:
                free.add(self.sysid.Parameter(symbol, value, value / WIDEST, value * WIDEST, modifier=modifier))
        if friction:
            (symbol,) = (p.symbol for p in FRICTION.parameters)
            most = max(float(np.abs(touch.force).max()) for touch in self.case.touches)
            start = friction_start(self.case)[symbol]
            free.add(self.sysid.Parameter(symbol, start, 0.0, most, modifier=_MODIFIERS[symbol]))
        return free


def _set_mass(spec: Any, parameter: Any) -> None:
    spec.body("object").mass = parameter.value[0]


def _set_joint(attribute: str) -> Modifier:
    def change(spec: Any, parameter: Any) -> None:
        joint = spec.joint("slide")
        if np.ndim(getattr(joint, attribute)):  # stiffness and damping are polynomials
            getattr(joint, attribute)[0] = parameter.value[0]
        else:
            setattr(joint, attribute, parameter.value[0])

    return change


def _set_actuator(name: str, term: int) -> Modifier:
    def change(spec: Any, parameter: Any) -> None:
        actuator = spec.actuator(name)
        actuator.gainprm[0], actuator.biasprm[term] = parameter.value[0], -parameter.value[0]

    return change


_MODIFIERS: dict[str, Modifier] = {
    "m": _set_mass,
    "k1": _set_joint("stiffness"),
    "k2": _set_actuator("spring", 1),
    "b1": _set_joint("damping"),
    "b2": _set_actuator("damper", 2),
    "Fc": _set_joint("frictionloss"),
}


def _insights(found: Any) -> str:
    """What the toolbox's own report says about a fit."""
    section = peer("mujoco.sysid.report.sections.insights").AutomatedInsights("Automated Insights", found)
    texts = [f"{entry['title']}: {entry['message']}" for entry in section.get_context()["insights"]]
    return re.sub(r"<[^>]*>", "", " ".join(texts))


def thinned(case: PeerCase) -> int:
    """Every so manieth sample brings a case to the rate of the project's own fit, or as near below as samples allow."""
    return max(1, math.floor(case.rate_hz / case.track.smoothed.rate_hz + 1e-9))
