"""Systems that are a compiled kernel over one discrete state vector, their memory.

Evaluating a port that Python computes costs more than most kernels. So the kernel of a system on the fast path writes
all outputs into one vector, the port `readout`, and its memory behind them. The named ports are parts of it, for use
one at a time; Drake's `Demultiplexer` takes it apart for a diagram that wants all of them at every tick.
"""

import weakref
from collections.abc import Callable, Collection, Mapping
from typing import Any

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, OutputPort, PortDataType

from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.leaf import LeafSystem


class KernelSystem(LeafSystem):
    """Base of these systems: an `__init__` declares inputs, then readout or memory, and last compiles the kernels.

    One with a readout has a method `_compute(t, memory, out, *inputs)`, any other a method `_step(t, memory, *inputs)`
    that updates the memory in place.
    """

    _readout: Any = None
    _compute: Callable[..., None]
    _step: Callable[..., None]

    def declare_memory(self, initial: Array, period: float) -> None:
        """Declare the memory and its update: `_update`, every `period` [s]; 0: at every step of the Simulator."""
        self._memory = self.DeclareDiscreteState(initial)
        if period > 0.0:
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)
        else:
            self.DeclarePerStepDiscreteUpdateEvent(self._update)

    def declare_readout(
        self, sizes: Mapping[str, int], initial: Array, period: float, memory_at: int | None = None
    ) -> None:
        """Declare a readout that `_compute` makes of time, memory and inputs; the update stores its memory.

        Args:
            sizes: name -> size of the ports that are its parts, one after the other from its start.
            initial: of the memory.
            period: of the updates, see `declare_memory`.
            memory_at: where in the readout the memory begins; behind the parts unless given.
        """
        self._memory_at = sum(sizes.values()) if memory_at is None else memory_at
        self.declare_memory(initial, period)
        sources = self._sources(self._reads)
        self._declare_parts(sizes, lambda context: held().Eval(context), sources)
        self._readout = self.declare_computed("readout", self._memory_at + len(initial), self._compute, self._reads)
        held: Callable[[], Any] = weakref.ref(self._readout)  # see `LeafSystem`

    def declare_computed(
        self, name: str, size: int, compute: Callable[..., None], inputs: Collection[str]
    ) -> OutputPort:
        """Declare an output that a method `compute(t, memory, out, *inputs)` makes of time, memory and these inputs."""
        owner: Callable[[], Any] = weakref.ref(self)  # see `LeafSystem`
        method, used = getattr(type(self), compute.__name__), tuple(inputs)

        def calc(context: Context, output: BasicVector) -> None:
            system = owner()
            values = [system._reads[name](context) for name in used]
            memory, out = context.get_discrete_state_vector().value(), output.get_mutable_value()
            method(system, context.get_time(), memory, out, *values)

        return self.DeclareVectorOutputPort(name, size, calc, self._sources(inputs))

    def declare_state_readout(self, sizes: Mapping[str, int], initial: Array, period: float) -> None:
        """Declare a readout that is the memory; its parts as for `declare_readout`."""
        self.declare_memory(initial, period)
        self.declare_state_parts(sizes)
        self.DeclareStateOutputPort("readout", self._memory)

    def declare_state_parts(self, sizes: Mapping[str, int]) -> None:
        """Declare outputs that are parts of the memory, one after the other from its start: name -> size."""
        self._declare_parts(sizes, lambda context: context.get_discrete_state_vector().value(), {self.xd_ticket()})

    def compile_kernels(self) -> None:
        """Compute every output and one update from zeros at every input: kernels compile before the clock starts."""
        context = self.CreateDefaultContext()
        for port in map(self.get_input_port, range(self.num_input_ports())):
            abstract = port.get_data_type() == PortDataType.kAbstractValued
            port.FixValue(context, self.AllocateInputAbstract(port) if abstract else np.zeros(port.size()))
        for index in range(self.num_output_ports()):
            self.get_output_port(index).Eval(context)
        self._update(context, context.get_mutable_discrete_state())

    def _declare_parts(self, sizes: Mapping[str, int], whole: Callable[[Context], Array], sources: set[Any]) -> None:
        start = 0
        for name, size in sizes.items():

            def calc(context: Context, output: BasicVector, part: slice = slice(start, start + size)) -> None:
                output.get_mutable_value()[:] = whole(context)[part]

            self.DeclareVectorOutputPort(name, size, calc, sources)
            start += size

    def _sources(self, inputs: Collection[str]) -> set[Any]:
        return {self.xd_ticket(), *self.tickets(inputs)}

    def _update(self, context: Context, state: DiscreteValues) -> None:
        memory = state.get_mutable_value()
        if self._readout is None:
            self._step(context.get_time(), memory, *self.inputs_at(context))
        else:
            memory[:] = self._readout.Eval(context)[self._memory_at :]
