"""Vectors taken apart and put together between the systems of a diagram."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import Demultiplexer, Multiplexer


def split(builder: DiagramBuilder, port: OutputPort, sizes: tuple[int, ...]) -> list[OutputPort]:
    """Ports for the first parts of a vector; what is left of it has none."""
    rest = port.size() - sum(sizes)
    parts: System = builder.AddSystem(Demultiplexer([*sizes, rest] if rest else list(sizes)))
    builder.Connect(port, parts.get_input_port(0))
    return [parts.get_output_port(i) for i in range(len(sizes))]


def join(builder: DiagramBuilder, ports: tuple[OutputPort, ...]) -> OutputPort:
    """One port for several vectors, one after the other."""
    whole = builder.AddSystem(Multiplexer([port.size() for port in ports]))
    for i, port in enumerate(ports):
        builder.Connect(port, whole.get_input_port(i))
    return whole.get_output_port(0)


def shown_first(system: System, port: str) -> NDArray[np.float64]:
    """What a system shows on a port before anything happens."""
    value: NDArray[np.float64] = system.GetOutputPort(port).Eval(system.CreateDefaultContext())
    return value
