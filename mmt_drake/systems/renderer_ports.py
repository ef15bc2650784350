"""The output that renderers share, so that one can take the place of another."""

import weakref
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from pydrake.systems.framework import BasicVector, Context, InputPort

from mmt_drake.rendering.status import NOT_FINITE, RENDERING
from mmt_drake.systems.leaf import LeafSystem


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
