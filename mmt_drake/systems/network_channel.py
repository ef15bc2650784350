"""One direction of a network between operator and telerobot."""

import math
import numbers

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, DiscreteValues, System
from pydrake.systems.primitives import DiscreteTimeDelay, PassThrough

from mmt_drake.errors import BadInput
from mmt_drake.network.config import ChannelConfig
from mmt_drake.network.packets import arrives_at_once, channel_memory, step_channel
from mmt_drake.network.parameters import INTERPOLATIONS, channel_parameters, may_arrive_at_once, whole_ticks
from mmt_drake.numeric.arrays import Array
from mmt_drake.systems.abstract_network_channel import AbstractNetworkChannel
from mmt_drake.systems.kernel_system import KernelSystem


def network_channel(
    config: ChannelConfig,
    signal: int | AbstractValue,
    period: float,
    *,
    initial: ArrayLike | None = None,
    interpolation: str = "hold",
) -> System:
    """One direction of a network, as the cheapest system that does what the configuration says.

    Every system has the ports `sent` and `received`. With a delay of n ticks, received(t_k) = sent(t_{k-n}) to
    the tick; without delay it is a wire. Sent at tick k and travelling for d seconds, a packet is available at
    tick k + ceil(d / period): the first one at or after its arrival.

    A wire is Drake's `PassThrough`, a constant delay Drake's `DiscreteTimeDelay`; the rest is `NetworkChannel` or,
    for abstract signals, `AbstractNetworkChannel`.

    Args:
        config: what the network does.
        signal: size of a vector, or a model value of an abstract signal. Abstract values are cloned whenever Drake
            copies a state, so large ones should be immutable and return themselves from `__deepcopy__`.
        period: time between packets, at which the signal is sampled [s]: the step of the fast path for vectors,
            the interval of its frames for a cloud.
        initial: (signal) what is received before anything has arrived; zeros unless given. For an abstract signal
            it is the model value.
        interpolation: how a play-out buffer bridges gaps in a vector, one of `INTERPOLATIONS`. "motion" is for
            positions followed by as many velocities.

    Raises:
        BadInput: a trace that cannot be read, a period that is not positive, an initial value or an
            interpolation that does not fit the signal.
    """
    if not 0.0 < period < math.inf:
        raise BadInput("network channel", at="period", found=period, expected="a positive time [s]")
    abstract = isinstance(signal, AbstractValue)
    if not abstract:
        initial = _fitting(signal, initial, interpolation)
    elif initial is not None or interpolation != "hold":
        raise BadInput(
            "network channel", found="an initial value or an interpolation", expected="neither, for an abstract signal"
        )
    ticks = whole_ticks(config.delay, period)
    if config.is_constant and ticks == 0:
        wire = PassThrough(abstract_model_value=signal) if abstract else PassThrough(vector_size=signal)
        return _named(wire)
    # DiscreteTimeDelay with n steps shows at a tick, before that tick's update, what came in n + 1 ticks ago.
    if abstract:
        if config.is_constant:
            return _named(DiscreteTimeDelay(period, ticks - 1, abstract_model_value=signal))
        return AbstractNetworkChannel(config, signal, period)
    if config.is_constant and not np.any(initial):
        return _named(DiscreteTimeDelay(period, ticks - 1, vector_size=signal))
    return NetworkChannel(config, signal, period, initial=initial, interpolation=interpolation)


def _fitting(size: int, initial: ArrayLike | None, interpolation: str) -> Array:
    """The initial value, (size), of a vector that travels under an interpolation that suits it."""
    if not isinstance(size, numbers.Integral) or size < 1:
        raise BadInput(
            "network channel", at="signal", found=repr(size), expected="a size of 1 or more, or an abstract value"
        )
    first = np.zeros(size) if initial is None else np.asarray(initial, dtype=np.float64)
    if first.shape != (size,) or not np.isfinite(first).all():
        raise BadInput("network channel", at="initial", found=first, expected=f"{size} numbers")
    if interpolation not in INTERPOLATIONS:
        raise BadInput(
            "network channel", at="interpolation", found=interpolation, expected=f"one of {', '.join(INTERPOLATIONS)}"
        )
    if interpolation == "motion" and size % 2:
        found = f"motion of {size} numbers"
        raise BadInput("network channel", at="interpolation", found=found, expected="as many velocities as positions")
    return first


def _named(system: System) -> System:
    """The system with its ports called `sent` and `received`."""
    builder = DiagramBuilder()
    builder.AddSystem(system)
    builder.ExportInput(system.get_input_port(), "sent")
    builder.ExportOutput(system.get_output_port(), "received")
    diagram = builder.Build()
    diagram.set_name("NetworkChannel")
    return diagram


class NetworkChannel(KernelSystem):
    """A network with jitter, loss, duplication, reordering and a limited rate, for vectors.

    .. pydrake_system::

        name: NetworkChannel
        input_ports:
        - sent
        output_ports:
        - received

    - `sent` (size): sampled once per period.
    - `received` (size): the newest packet that has arrived, held; or what the play-out buffer shows. Depends on
      `sent` directly only if a packet can arrive within its own tick.

    All state is in the Context: what is shown, and the memory of the kernels, which begins with the counts of
    `STATISTICS`. The random numbers are functions of the seed and of the packet's number.

    Args:
        config, period, initial, interpolation: see `network_channel`.
        size: of the vector.

    Raises:
        BadInput: a trace that cannot be read, an initial value or an interpolation that does not fit.
    """

    def __init__(
        self,
        config: ChannelConfig,
        size: int,
        period: float,
        *,
        initial: ArrayLike | None = None,
        interpolation: str = "hold",
    ):
        super().__init__()
        first = _fitting(size, initial, interpolation)
        self._period = period
        self._p, self._trace = channel_parameters(config, period, interpolation)
        self.declare_inputs(sent=size)
        self._received = self.DeclareDiscreteState(first)
        self._memory = self.DeclareDiscreteState(channel_memory(self._p, size))
        if may_arrive_at_once(self._p, self._trace):
            self.DeclareVectorOutputPort("received", size, self._output)
        else:
            self.DeclareStateOutputPort("received", self._received)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)
        self.compile_kernels()

    def _update(self, context: Context, state: DiscreteValues) -> None:
        (sent,) = self.inputs_at(context)
        step_channel(sent, self._p, self._trace, state.get_mutable_value(1), state.get_mutable_value(0))

    def _output(self, context: Context, output: BasicVector) -> None:
        now = context.get_time() / self._period
        at_tick = abs(now - round(now)) < 1e-6
        memory = context.get_discrete_state(self._memory).value()
        if at_tick and arrives_at_once(self._p, self._trace, memory):
            (sent,) = self.inputs_at(context)
            output.SetFromVector(sent)
        else:
            output.SetFromVector(context.get_discrete_state(self._received).value())
