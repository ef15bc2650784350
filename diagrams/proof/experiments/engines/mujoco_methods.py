"""MuJoCo: a sliding joint that two actuators pull, one of them the contact spring, one the contact damper.

Steps are made by its `rollout`, in C, and one by one from Python, as a loop at 1 kHz would have them: a control is held
over the step. That leaves its own semi-implicit methods, whose control is that at the step's beginning, and Runge-Kutta
4, which is best served with that of the step's middle. To evaluate the control inside the step takes a callback in
Python.

A `mocap` body, which is moved by setting its position, is the obvious way to bring a hand in, and no good one: it has
no velocity, so the contact damper acts between the object and the world. It is run to show what that costs.
"""

import time
from functools import partial
from typing import Any

import numpy as np

from mmt_drake.diagrams.proof.experiments.engines.method import (
    STEP,
    Method,
    Setting,
    Trace,
    engine_package,
    stepped,
    us_per_step,
)
from mmt_drake.model.hermite import cubic, position_at, velocity_at
from mmt_drake.model.parameters import BoxParameters
from mmt_drake.numeric.arrays import Array

_PACKAGE = "mujoco"

MOCAP = "mocap body as input"

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
_REACH = 10.0  # [m] at rest between the mocap body and the object: a tendon's length has no sign
_MOCAP_MODEL = """<mujoco>
<option timestep="{step}" gravity="0 0 0" integrator="implicitfast"><flag contact="disable"/></option>
<worldbody>
  <body name="probe" mocap="true"><site name="hand"/></body>
  <body name="object">
    <inertial pos="0 0 0" mass="{m}" diaginertia="1e-3 1e-3 1e-3"/>
    <joint name="slide" type="slide" axis="0 1 0" stiffness="{k1}" damping="{b1}"/>
    <site name="surface"/>
  </body>
</worldbody>
<tendon><spatial stiffness="{k2}" damping="{b2}" springlength="{reach}">
  <site site="hand"/><site site="surface"/>
</spatial></tendon>
</mujoco>"""


def model_xml(parameters: BoxParameters, step: float) -> str:
    """The object as MuJoCo's own model file, its time step in seconds."""
    values = {name: getattr(parameters, name) for name in ("m", "k1", "k2", "b1", "b2", "Fc")}
    return _MODEL.format(step=step, twice=2.0 * step, **values)


def _model(mujoco: Any, setting: Setting, integrator: str) -> Any:
    model = mujoco.MjModel.from_xml_string(model_xml(setting.parameters, STEP))
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}")
    return model


def _roll_out(setting: Setting, integrator: str, held: str) -> Trace:
    mujoco = engine_package(_PACKAGE)
    x, v = setting.probe.at_middles() if held == "middle" else (signal[:-1] for signal in setting.probe.at_samples())
    body, us = _rolled_out(mujoco, _model(mujoco, setting, integrator), setting, np.column_stack([x, v]), "CTRL")
    return Trace(setting.force(*body.T), us)


def _move_mocap(setting: Setting) -> Trace:
    mujoco, p = engine_package(_PACKAGE), setting.parameters
    values = {name: getattr(p, name) for name in ("m", "k1", "k2", "b1", "b2")}
    model = mujoco.MjModel.from_xml_string(_MOCAP_MODEL.format(step=STEP, reach=_REACH, **values))
    x, _ = setting.probe.at_samples()
    positions = np.column_stack([np.zeros_like(x), _REACH + x, np.zeros_like(x)])
    body, us = _rolled_out(mujoco, model, setting, positions[:-1], "MOCAP_POS")
    return Trace(p.k2 * (x - body[:, 0]) - p.b2 * body[:, 1], us)


def _rolled_out(mujoco: Any, model: Any, setting: Setting, control: Array, kind: str) -> tuple[Array, float]:
    """The body's position and velocity at the samples (steps + 1, 2) under a control (steps, n), and us per step."""
    rollout = engine_package("mujoco.rollout")
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = setting.body_at_start()
    what = mujoco.mjtState.mjSTATE_FULLPHYSICS
    start = np.empty(mujoco.mj_stateSize(model, what))
    mujoco.mj_getState(model, data, start, what)
    spec = int(getattr(mujoco.mjtState, f"mjSTATE_{kind}"))
    began = time.process_time()
    states, _ = rollout.rollout(model, data, start[np.newaxis], control[np.newaxis], control_spec=spec)
    us = us_per_step(began, setting.probe.steps)
    whole = np.vstack([start, states[0]])  # time, position, velocity
    return whole[:, 1:3], us


def _call_back(setting: Setting) -> Trace:
    mujoco = engine_package(_PACKAGE)
    model, probe = _model(mujoco, setting, "RK4"), setting.probe
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = setting.body_at_start()
    x, v = (signal.tolist() for signal in probe.at_samples())
    path, since = cubic.py_func(x[0], v[0], x[1], v[1], STEP), 0.0

    def control(_: Any, now: Any) -> None:
        s = now.time - since
        now.ctrl[0], now.ctrl[1] = position_at.py_func(path, s), velocity_at.py_func(path, s)

    def advance(k: int, *_: float) -> tuple[float, float]:
        nonlocal path, since
        path, since = cubic.py_func(x[k], v[k], x[k + 1], v[k + 1], STEP), data.time
        mujoco.mj_step(model, data)
        return data.qpos[0], data.qvel[0]

    mujoco.set_mjcb_control(control)
    try:
        return stepped(setting, advance)
    finally:
        mujoco.set_mjcb_control(None)


def _step_from_python(setting: Setting) -> Trace:
    mujoco = engine_package(_PACKAGE)
    model = _model(mujoco, setting, "EULER")
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = setting.body_at_start()
    control, position, velocity = data.ctrl, data.qpos, data.qvel
    x, v = (signal.tolist() for signal in setting.probe.at_samples())
    body = np.array([setting.body_at_start()] * len(x))
    began = time.process_time()
    for k in range(setting.probe.steps):  # as lean as can be
        control[0], control[1] = x[k], v[k]
        mujoco.mj_step(model, data)
        body[k + 1, 0], body[k + 1, 1] = position[0], velocity[0]
    us = us_per_step(began, setting.probe.steps)
    return Trace(setting.force(*body.T), us)


METHODS = (
    Method("mujoco", "Euler", partial(_roll_out, integrator="EULER", held="start"), _PACKAGE),
    Method("mujoco", "implicitfast", partial(_roll_out, integrator="IMPLICITFAST", held="start"), _PACKAGE),
    Method("mujoco", "Runge-Kutta 4, middle held", partial(_roll_out, integrator="RK4", held="middle"), _PACKAGE),
    Method("mujoco", "Runge-Kutta 4, callback", _call_back, _PACKAGE, from_python=True),
    Method("mujoco", "Euler from Python", _step_from_python, _PACKAGE, from_python=True),
    Method("mujoco", MOCAP, _move_mocap, _PACKAGE),
)
