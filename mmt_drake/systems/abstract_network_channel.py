"""One direction of a network, for signals that are no vectors."""

from __future__ import annotations

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import Context, State

from mmt_drake.network.config import ChannelConfig
from mmt_drake.network.packets import NEXT_PACKET, arrives_at_once, channel_memory, step_channel
from mmt_drake.network.parameters import CAPACITY, channel_parameters, may_arrive_at_once
from mmt_drake.systems.leaf import LeafSystem


class _Packets:
    """Packets in flight, by their numbers; never changed, so that copies of a state may share them."""

    def __init__(self, content: dict[int, AbstractValue]):
        self.content = content

    def __deepcopy__(self, memo: object) -> _Packets:
        return self


class AbstractNetworkChannel(LeafSystem):
    """The network of `NetworkChannel` for signals that are no vectors, such as point clouds.

    .. pydrake_system::

        name: AbstractNetworkChannel
        input_ports:
        - sent
        output_ports:
        - received

    - `sent`, `received` (abstract, of the model value's type): as for `NetworkChannel`; a play-out buffer holds.

    What travels through the compiled path are the numbers of the packets; the packets lie beside it.

    Args:
        config: what the network does.
        model: a value of the signal's type, received before anything has arrived.
        period: time between packets [s].

    Raises:
        BadInput: a trace that cannot be read.
    """

    def __init__(self, config: ChannelConfig, model: AbstractValue, period: float):
        super().__init__()
        self._period = period
        self._p, self._trace = channel_parameters(config, period)
        self._none = _Packets({-1: model.Clone()})
        memory = channel_memory(self._p, 1)
        self._sent = self.DeclareAbstractInputPort("sent", model)
        self._number = self.DeclareDiscreteState(np.array([-1.0]))
        self._memory = self.DeclareDiscreteState(memory)
        self._packets = self.DeclareAbstractState(Value(self._none))
        tickets = {self.all_state_ticket()}
        if may_arrive_at_once(self._p, self._trace):
            tickets |= {self.input_port_ticket(self._sent.get_index()), self.time_ticket()}
        self._at_once = len(tickets) > 1
        self.DeclareAbstractOutputPort("received", model.Clone, self._output, prerequisites_of_calc=tickets)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._update)
        # Compiles before the clock starts.
        step_channel(np.zeros(1), self._p, self._trace, memory, np.zeros(1))
        memory.flags.writeable = False  # as Drake hands it out
        arrives_at_once(self._p, self._trace, memory)

    def _update(self, context: Context, state: State) -> None:
        vectors = state.get_mutable_discrete_state()
        memory, number = vectors.get_mutable_value(self._memory), vectors.get_mutable_value(self._number)
        packet = int(memory[NEXT_PACKET])
        held = state.get_abstract_state(self._packets).get_value().content
        step_channel(np.array([float(packet)]), self._p, self._trace, memory, number)
        # A packet is needed while it is shown, or in flight.
        oldest = max(int(number[0]), packet - int(self._p[CAPACITY]))
        kept = {k: value for k, value in held.items() if k >= oldest or k == number[0]}
        kept[packet] = self._sent.EvalAbstract(context).Clone()
        state.get_mutable_abstract_state(self._packets).set_value(_Packets(kept))

    def _output(self, context: Context, output: AbstractValue) -> None:
        if self._at_once:
            now = context.get_time() / self._period
            memory = context.get_discrete_state(self._memory).value()
            if abs(now - round(now)) < 1e-6 and arrives_at_once(self._p, self._trace, memory):
                output.SetFrom(self._sent.EvalAbstract(context))
                return
        number = int(context.get_discrete_state(self._number).value()[0])
        output.SetFrom(context.get_abstract_state(self._packets).get_value().content[number])
