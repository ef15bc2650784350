"""A proxy that follows the hand within the tick, for systems whose outputs must not be late."""

import weakref
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, DiscreteValues, InputPort

from mmt_drake.cloud.proxy import MEMORY_SIZE, NO_CLOUD, ProxySettings, new_memory, step_proxy
from mmt_drake.systems.leaf import Cached, LeafSystem

Array = NDArray[np.float64]


def declare_proxy(system: LeafSystem, hand: InputPort, cloud: InputPort, settings: ProxySettings) -> Cached:
    """Declare the proxy's memory, a discrete state, and its step, computed once and stored by the update.

    Args:
        system: gets state and update; it has no other discrete state before.
        hand: whose first three numbers are its position [m].
        cloud: the surface.
        settings: of the proxy; their period is that of the update.

    Returns:
        The memory after the step at this instant (`mmt_drake.cloud.proxy`).
    """
    packed = settings.packed()
    held_hand: Callable[[], Any] = weakref.ref(hand)  # see `LeafSystem`
    held_cloud: Callable[[], Any] = weakref.ref(cloud)
    memory = system.DeclareDiscreteState(MEMORY_SIZE)

    def calc(context: Context, following: AbstractValue) -> None:
        after: Array = following.get_mutable_value()
        after[:] = context.get_discrete_state(memory).value()
        step_proxy(after, held_hand().Eval(context), held_cloud().Eval(context), packed)

    def update(context: Context, state: DiscreteValues) -> None:
        state.get_mutable_value(memory)[:] = after_step.Eval(context)

    after_step = system.declare_cached(
        "proxy after this step",
        lambda: AbstractValue.Make(new_memory()),
        calc,
        {system.discrete_state_ticket(memory), hand.ticket(), cloud.ticket()},
    )
    system.DeclarePeriodicDiscreteUpdateEvent(settings.period, 0.0, update)
    step_proxy(new_memory(), np.zeros(3), NO_CLOUD, packed)  # compiles before the clock starts
    return after_step
