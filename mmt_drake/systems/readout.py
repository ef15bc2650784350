"""Systems whose output ports are parts of one vector, the readout.

Evaluating a port that Python computes costs more than most kernels. So the kernel of a system on the fast path writes
all outputs into one vector, the port `readout`, and its memory behind them. The named ports are parts of it, for use
one at a time; Drake's `Demultiplexer` takes it apart for a diagram that wants all of them at every tick.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import BasicVector, Context, DependencyTicket, InputPort, OutputPort

from mmt_drake.systems.leaf import LeafSystem

Array = NDArray[np.float64]


def declare_parts(
    system: LeafSystem,
    sizes: Mapping[str, int],
    readout: Callable[[Context], Array],
    sources: set[DependencyTicket],
) -> None:
    """Declare one vector output port for each part of a readout.

    Args:
        system: gets the ports.
        sizes: name -> size of the parts, one after the other from the readout's start.
        readout: the readout at a Context.
        sources: what the readout depends on.
    """
    start = 0
    for name, size in sizes.items():

        def calc(context: Context, output: BasicVector, part: slice = slice(start, start + size)) -> None:
            output.get_mutable_value()[:] = readout(context)[part]

        system.DeclareVectorOutputPort(name, size, calc, sources)
        start += size


def declare_readout(
    system: LeafSystem,
    sizes: Mapping[str, int],
    size: int,
    calc: Callable[[Context, BasicVector], None],
    used: Iterable[InputPort],
) -> OutputPort:
    """Declare a readout that is computed from time, discrete state and inputs, and its parts before it.

    Args:
        system: gets the ports.
        sizes: name -> size of the parts.
        size: of the readout.
        calc: computes it.
        used: the inputs.

    Returns:
        The port `readout`.
    """
    sources = {system.time_ticket(), system.xd_ticket(), *(port.ticket() for port in used)}
    declare_parts(system, sizes, lambda context: held().Eval(context), sources)
    readout: OutputPort = system.DeclareVectorOutputPort("readout", size, calc, sources)
    held: Callable[[], Any] = weakref.ref(readout)  # see `LeafSystem`
    return readout


def declare_state_readout(system: LeafSystem, sizes: Mapping[str, int], initial: Array) -> None:
    """Declare a readout that is a discrete state, with its initial value, and its parts before it."""
    state = system.DeclareDiscreteState(initial)
    sources = {system.discrete_state_ticket(state)}
    declare_parts(system, sizes, lambda context: context.get_discrete_state(state).value(), sources)
    system.DeclareStateOutputPort("readout", state)


def frozen_zeros(size: int) -> Array:
    """A vector of the kind that Drake hands out of a Context: read-only. Kernels are compiled for it beforehand."""
    zeros = np.zeros(size)
    zeros.flags.writeable = False
    return zeros
