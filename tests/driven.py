"""A system under test that others drive, and what it puts out, tick by tick."""

from collections.abc import Iterable

from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, System
from pydrake.systems.primitives import LogVectorOutput

from mmt_drake.numeric.arrays import Array

STEP = 1e-3


def driven(system: System, names: Iterable[str], seconds: float, **sources: System) -> tuple[dict[str, Array], Context]:
    """Run a system from 0 on.

    Args:
        system: that is run.
        names: of its outputs that are looked at.
        seconds: for how long [s].
        sources: of its inputs, by their names, each with one output.

    Returns:
        Output -> (ticks, size), and the system's own context in the end.
    """
    builder = DiagramBuilder()
    builder.AddSystem(system)
    for name, source in sources.items():
        builder.Connect(builder.AddSystem(source).get_output_port(), system.GetInputPort(name))
    logs = {name: LogVectorOutput(system.GetOutputPort(name), builder, STEP) for name in names}
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(seconds)
    root = simulator.get_context()
    return {name: log.FindLog(root).data().T.copy() for name, log in logs.items()}, system.GetMyContextFromRoot(root)
