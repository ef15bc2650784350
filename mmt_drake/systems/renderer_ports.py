"""The ports that renderers share, so that one can take the place of another."""

import weakref
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, InputPort

from mmt_drake.cloud import Cloud
from mmt_drake.model.held_body import HELD_SIZE
from mmt_drake.model.parameters import THETA
from mmt_drake.rendering.status import NOT_FINITE, RENDERING
from mmt_drake.systems.leaf import LeafSystem

_SIZES = {
    "motion": 6,
    "theta": len(THETA),
    "stable": 1,
    "in_contact": 1,
    "remote_force": 3,
    "remote_energy": 3,
    "high_band": 3,
    "held_body": HELD_SIZE,
}


def declare_renderer_inputs(system: LeafSystem, *names: str) -> tuple[InputPort, ...]:
    """Declare those inputs of renderers that this one reads."""
    return tuple(
        system.DeclareAbstractInputPort(name, AbstractValue.Make(Cloud.empty()))
        if name == "point_cloud"
        else system.DeclareVectorInputPort(name, _SIZES[name])
        for name in names
    )


def declare_rendering(system: LeafSystem, used: Sequence[InputPort] = ()) -> None:
    """Declare the output `status` of a renderer that waits for no parameters: it renders what is finite.

    Args:
        system: the renderer.
        used: inputs without which it has nothing to render.
    """

    held: list[Callable[[], Any]] = [weakref.ref(port) for port in used]  # see `LeafSystem`

    def calc(context: Context, status: BasicVector) -> None:
        usable = all(np.isfinite(port().Eval(context)).all() for port in held)
        status.SetFromVector([RENDERING if usable else NOT_FINITE])

    needs = {port.ticket() for port in used} or {system.nothing_ticket()}
    system.DeclareVectorOutputPort("status", BasicVector([RENDERING]), calc, needs)
